"""Kernels into LLVM's code, straight from their text: types and code of an expression in one go.

Numba makes bytecode of its own representation, infers types by a network of constraints and writes
code in a third pass: a millisecond and more for each statement, most of the time that the first
value of a law takes. Kernels are simple functions: what each name holds is known where its text
is read. Types, their operators and their code are numba's, asked for one by one; whatever is not
understood here is left to numba as a whole.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import errors
from numba.core.bytecode import FunctionIdentity
from numba.core.callconv import RETCODE_OK
from numba.core.fastmathpass import rewrite_module
from numba.core.targetconfig import ConfigStack

from stickslip.numerics.translation.codes import Descriptor, inner
from stickslip.numerics.translation.expressions import BINARY, Again, Expressions
from stickslip.numerics.translation.text import text_of
from stickslip.numerics.translation.values import NotUnderstood, Value, known, types


def translate(function: Callable[..., Any], state: Any, called: Callable[..., Any]) -> Any:
    """Write a kernel into the library of a compiler's state: its signature and its descriptor.

    `called` gives the part of a kernel for some types, None of anything else.
    """
    text = text_of(function)
    kinds = {} if text.result is None else {"return": text.result}
    slots: dict[str, Any] = {}
    for _ in range(4 * (4 + function.__code__.co_nlocals)):
        try:
            return Reader(function, text, state, called, slots, kinds).written()
        except Again:
            continue
        except (errors.NumbaError, NotImplementedError, RecursionError) as error:
            raise NotUnderstood(str(error)) from error
    raise NotUnderstood("its types do not settle")


class Reader(Expressions):
    """Reads one kernel and writes its code."""

    # --- the whole ------------------------------------------------------------------------------

    def written(self) -> tuple[Any, Any]:
        """Write the code; return its signature and its descriptor."""
        state, context = self.state, self.context
        result = self.kinds.get("return")
        told = FunctionIdentity.from_function(self.function)
        flags, arguments = state.flags, tuple(state.args)
        if any(isinstance(kind, (types.Omitted, types.Optional)) for kind in arguments):
            raise NotUnderstood("an argument that may be missing")
        self.descriptor = Descriptor(told, state, result or types.none)
        with ConfigStack().enter(flags.copy()), context.push_code_library(state.library):
            module = state.library.create_ir_module(told.unique_name)
            context.declare_env_global(module, context.get_env_name(self.descriptor))
            self.code = inner(context, module, self.descriptor)
            self.entry = self.code.append_basic_block("entry")
            self.builder = ir.IRBuilder(self.entry)
            self.builder.branch(start := self.block())
            self.builder.position_at_end(start)
            codes = iter(self.code.args[2:])
            for name, kind in zip(told.arg_names, arguments, strict=True):
                self.bind(name, self.argument(types.unliteral(kind), codes))
            self.statements(self.text.body)
            if not self.builder.block.is_terminated:
                self.give(known(types.none, None))
            if self.returned != self.kinds.get("return"):
                self.kinds["return"] = self.returned
                raise Again
            for block in self.code.blocks:
                if not block.is_terminated:
                    ir.IRBuilder(block).unreachable()
            if flags.fastmath:
                rewrite_module(module, flags.fastmath)
            state.library.add_ir_module(module)
        return self.descriptor.restype(*arguments), self.descriptor

    # --- statements -----------------------------------------------------------------------------

    def statements(self, body: list[ast.stmt]) -> None:
        """Write the code of statements, until one that ends the block."""
        for each in body:
            if self.builder.block.is_terminated:
                return
            getattr(self, f"do_{type(each).__name__}", self.unknown)(each)

    def do_Pass(self, node: ast.Pass) -> None:
        """Write nothing."""
        pass

    def do_Expr(self, node: ast.Expr) -> None:
        """Write the code of a call."""
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def do_Assign(self, node: ast.Assign) -> None:
        """Write the code of a statement."""
        value = self.value(node.value)
        for target in node.targets:
            self.assign(target, value)

    def do_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Write the code of a statement."""
        if node.value is not None:
            self.assign(node.target, self.value(node.value))

    def assign(self, target: ast.expr, value: Value) -> None:
        """Give a target a value."""
        if isinstance(target, ast.Name):
            self.bind(target.id, value)
        elif isinstance(target, ast.Tuple):
            parts = self.parts_of(value, len(target.elts))
            for each, part in zip(target.elts, parts, strict=True):
                self.assign(each, part)
        elif isinstance(target, ast.Subscript):
            array, index = self.value(target.value), self.index(target.slice)
            place = self.element(array, index)
            if place is not None and array.kind.mutable:
                self.put(array, place, value)
            else:
                self.operation(operator.setitem, array, self.whole(index), value)
        else:
            self.unknown(target)

    def do_AugAssign(self, node: ast.AugAssign) -> None:
        """Write the code of a statement."""
        target, by = node.target, type(node.op)
        if by not in BINARY:
            self.unknown(node)
        if isinstance(target, ast.Name):
            old = self.lookup(target.id)
            if isinstance(old.kind, types.Array):
                raise NotUnderstood("an array changed in place")
            self.bind(target.id, self.operation(BINARY[by], old, self.value(node.value)))
        elif isinstance(target, ast.Subscript):
            array, index = self.value(target.value), self.index(target.slice)
            place = self.element(array, index)
            if place is None or not array.kind.mutable:
                self.unknown(target)
            old = self.get(array, place)
            self.put(array, place, self.operation(BINARY[by], old, self.value(node.value)))
        else:
            self.unknown(target)

    def do_Return(self, node: ast.Return) -> None:
        """Write the code of a statement."""
        self.give(known(types.none, None) if node.value is None else self.value(node.value))

    def give(self, value: Value) -> None:
        """Return a value."""
        if value.kind is None:
            raise NotUnderstood("an object as result")
        self.returned = (
            value.kind if self.returned is None else self.unified(self.returned, value.kind)
        )
        result = self.kinds.setdefault("return", self.returned)
        if self.typing.unify_pairs(result, value.kind) != result:
            self.kinds["return"] = self.returned
            raise Again
        place = self.code.args[0]
        if self.descriptor.restype != result:  # not known until now
            self.descriptor.restype = result
            place.type = self.context.call_conv.get_return_type(result)
        self.put_result(result, value, place)
        self.builder.ret(RETCODE_OK)

    def do_If(self, node: ast.If) -> None:
        """Write the code of a statement."""
        known = self.decided(node.test)
        if known is not None:
            self.statements(node.body if known else node.orelse)
            return
        then, after = self.block(), self.block()
        other = self.block() if node.orelse else after
        self.branch(node.test, then, other)
        ended = bool(node.orelse)
        for block, body in ((then, node.body), (other, node.orelse)):
            if body:
                self.builder.position_at_end(block)
                with self.scope():
                    self.statements(body)
                ended = self.builder.block.is_terminated and ended
                self.close(after)
        self.builder.position_at_end(after)
        if ended:
            self.builder.unreachable()

    def close(self, block: Any) -> None:
        """Go on at a block, unless the code ends here."""
        if not self.builder.block.is_terminated:
            self.builder.branch(block)

    def do_While(self, node: ast.While) -> None:
        """Write the code of a statement."""
        if node.orelse:
            self.unknown(node)
        known = self.decided(node.test)
        if known is False:
            return
        test, body, after = self.block(), self.block(), self.block()
        self.builder.branch(test)
        self.builder.position_at_end(test)
        if known:
            self.builder.branch(body)
        else:
            self.branch(node.test, body, after)
        self.repeat(node.body, body, test, after)
        if known and after not in self.left:
            self.builder.unreachable()

    def repeat(self, statements: list[ast.stmt], body: Any, following: Any, after: Any) -> None:
        """Write the body of a loop."""
        self.builder.position_at_end(body)
        self.loops.append((following, after))
        with self.scope():
            self.statements(statements)
        self.loops.pop()
        self.close(following)
        self.builder.position_at_end(after)

    def do_Break(self, node: ast.Break) -> None:
        """Write the code of a statement."""
        after = self.loops[-1][1]
        self.left.append(after)
        self.builder.branch(after)

    def do_Continue(self, node: ast.Continue) -> None:
        """Write the code of a statement."""
        self.builder.branch(self.loops[-1][0])

    def do_For(self, node: ast.For) -> None:
        """Write the code of a statement."""
        if node.orelse:
            self.unknown(node)
        over = node.iter
        if isinstance(over, ast.Call) and self.value(over.func).object is range:
            self.count(node, [self.value(each) for each in over.args])
            return
        after = self.block()
        for part in self.parts_of(self.value(over)):
            following = self.block()
            with self.scope():
                self.assign(node.target, part)
                body = self.block()
                self.builder.branch(body)
                self.repeat(node.body, body, following, after)
            self.builder.position_at_end(following)
        self.builder.branch(after)
        self.builder.position_at_end(after)

    def count(self, node: ast.For, bounds: list[Value]) -> None:
        """Write a loop over a range."""
        builder = self.builder
        kind = self.typing.resolve_value_type(range)
        kind = kind.get_call_type(self.typing, tuple(each.kind for each in bounds), {})
        kind = kind.return_type.dtype
        step = bounds[2] if len(bounds) == 3 else self.thing(1)
        first, stop = bounds[:2] if len(bounds) > 1 else (self.thing(0), bounds[0])
        if not step.known or step.object == 0:
            raise NotUnderstood("a step that is not known")
        upward = step.object > 0
        end = self.cast(stop, kind)
        place = self.slot(kind)
        builder.store(self.cast(first, kind), place)
        test, body, following, after = (self.block() for _ in range(4))
        builder.branch(test)
        builder.position_at_end(test)
        now = builder.load(place)
        compared = builder.icmp_signed if kind.signed else builder.icmp_unsigned
        builder.cbranch(compared("<" if upward else ">", now, end), body, after)
        builder.position_at_end(body)
        value = Value(kind, now)
        value.natural = (first.natural and upward) or not kind.signed
        if not upward and stop.known:
            value.natural = stop.object >= -1
        with self.scope():
            self.assign(node.target, value)
            self.repeat(node.body, body, following, after)
        builder.position_at_end(following)
        flags = (("nsw",) if kind.signed else ("nuw",)) if abs(step.object) == 1 else ()
        more = builder.add(now, ir.Constant(now.type, step.object), flags=flags)
        builder.store(more, place)
        builder.branch(test)
        builder.position_at_end(after)
