"""Code of expressions."""

from __future__ import annotations

import ast
import builtins
import math
import operator
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import reduce
from types import ModuleType
from typing import Any

import numpy as np
from llvmlite import ir

from stickslip.numerics.translation.codes import WORD, Codes
from stickslip.numerics.translation.text import Text
from stickslip.numerics.translation.values import (
    NotUnderstood,
    Value,
    form_of,
    known,
    natural,
    types,
)

BINARY = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
COMPARE = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
# What numba writes for operands of one type, without being asked.
FLOATS = {
    operator.add: "fadd",
    operator.sub: "fsub",
    operator.mul: "fmul",
    operator.truediv: "fdiv",
}
WHOLES = {operator.add: "add", operator.sub: "sub", operator.mul: "mul"}
SIGNS = {
    operator.eq: "==",
    operator.ne: "!=",
    operator.lt: "<",
    operator.le: "<=",
    operator.gt: ">",
    operator.ge: ">=",
}
# What may be evaluated though Python would not: without effect, and no index out of an array.
HARMLESS = (
    ast.Name, ast.Constant, ast.Compare, ast.BoolOp, ast.UnaryOp, ast.Attribute, ast.expr_context,
    ast.cmpop, ast.boolop, ast.unaryop, ast.BinOp, ast.Add, ast.Sub, ast.Mult,
)  # fmt: skip


class Again(Exception):
    """A name or the result turned out to be of another kind: the kernel is read again."""


class Expressions(Codes):
    """Reads expressions of one kernel and writes their code."""

    def __init__(
        self,
        function: Callable[..., Any],
        text: Text,
        state: Any,
        called: Callable[..., Any],
        slots: dict[str, Any],
        kinds: dict[str, Any],
    ) -> None:
        super().__init__(state.targetctx, called)
        self.function, self.text, self.state = function, text, state
        self.typing = state.typingctx
        self.slots, self.kinds = slots, kinds  # what earlier readings have found
        self.names: dict[str, Value] = {}
        self.places: dict[str, Any] = {}  # of slots
        self.loops: list[tuple[Any, Any]] = []
        self.left: list[Any] = []  # blocks after a loop, by a break
        self.returned: Any = None
        self.scopes: list[list[str]] = [[]]
        cells = function.__closure__ or ()
        self.outside = {
            **vars(builtins),
            **function.__globals__,
            **{
                name: cell.cell_contents
                for name, cell in zip(function.__code__.co_freevars, cells, strict=True)
            },
        }
        self.counts, self.used = text.counts, text.used

    # --- names ----------------------------------------------------------------------------------

    def bind(self, name: str, value: Value) -> None:
        """Give a name a value; one that is never asked for nothing."""
        if name not in self.used:
            return
        if self.counts[name] <= 1 and name not in self.slots:
            self.names[name] = value
            self.scopes[-1].append(name)
            return
        if value.kind in (None, types.none):
            raise NotUnderstood(f"{name} is an object")
        kind = self.slots.get(name)
        unified = value.kind if kind is None else self.unified(kind, value.kind)
        self.slots[name] = unified
        if unified != kind and name in self.places:
            raise Again  # what was written took it for something else
        if name not in self.places:
            self.places[name] = self.slot(unified)
        self.store(value, unified, self.places[name])

    def held(self, node: ast.expr) -> Any:
        """Type and slot of a name, or of a field of it; None if it has none."""
        if isinstance(node, ast.Name) and node.id in self.places and node.id not in self.names:
            return self.slots[node.id], self.places[node.id]
        if isinstance(node, ast.Attribute):
            whole = self.held(node.value)
            fields = getattr(whole[0], "fields", ()) if whole else ()
            if node.attr in fields:
                k = fields.index(node.attr)
                return whole[0].types[k], whole[1][k]
        return None

    def lookup(self, name: str) -> Value:
        """Find what a name holds."""
        if name in self.names:
            return self.names[name]
        if name in self.places:
            return self.load(self.slots[name], self.places[name])
        if name in self.counts:
            if name in self.slots:
                if self.slots[name] is None:
                    raise NotUnderstood(f"{name} before it is given")
                self.places[name] = self.slot(self.slots[name])
                return self.lookup(name)
            self.slots[name] = None
            raise Again
        if name not in self.outside:
            raise NotUnderstood(f"{name} is not known")
        return self.thing(self.outside[name])

    def thing(self, thing: Any) -> Value:
        """Value of an object that is known."""
        if isinstance(thing, bool):
            return known(types.boolean, thing)
        if isinstance(thing, int):
            return known(types.int64 if -(2**63) <= thing < 2**63 else types.uint64, thing)
        if isinstance(thing, float):  # np.float64 too
            return known(types.float64, float(thing))
        if thing is None:
            return known(types.none, None)
        if isinstance(thing, (np.generic, np.ndarray)):
            return known(self.typing.resolve_value_type(thing), thing)
        if type(thing) is tuple:
            parts = [self.thing(each) for each in thing]
            return self.joint(parts)
        return known(None, thing)

    def joint(self, parts: list[Value], made: Any = None) -> Value:
        """Make a tuple of its parts."""
        if any(part.kind is None for part in parts):
            raise NotUnderstood("a tuple of objects")
        return Value(types.BaseTuple.from_types([each.kind for each in parts], made), parts=parts)

    def unified(self, one: Any, other: Any) -> Any:
        """Return the type of what is of one type or of another."""
        found = self.typing.unify_pairs(one, other)
        if found is None or isinstance(found, types.Optional):
            raise NotUnderstood(f"either {one} or {other}")
        return found

    @contextmanager
    def scope(self) -> Iterator[None]:
        """Names given here are not known later: their code may not have run."""
        self.scopes.append([])
        yield
        for name in self.scopes.pop():
            self.names.pop(name, None)

    def unknown(self, node: ast.AST) -> Any:
        """Leave the kernel to numba."""
        raise NotUnderstood(type(node).__name__)

    def put(self, array: Value, place: Any, value: Value) -> None:
        """Write an element of an array."""
        kind = array.kind.dtype
        code = self.cast(value, kind)
        align = None if array.kind.aligned else 1
        self.context.pack_value(self.builder, kind, code, place, align=align)

    # --- conditions -----------------------------------------------------------------------------

    def decided(self, node: ast.expr) -> bool | None:
        """Whether a condition holds, if the text tells."""
        if isinstance(node, ast.BoolOp):
            end = isinstance(node.op, ast.Or)  # one such operand decides
            for each in node.values:
                known = self.decided(each)
                if known is not (not end):
                    return known
            return not end
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            known = self.decided(node.operand)
            return None if known is None else not known
        if self.is_free(node):
            value = self.value(node)
            if value.known and value.kind is not None and not isinstance(value.kind, types.Array):
                return bool(value.object)
        return None

    def is_free(self, node: ast.expr) -> bool:
        """Whether a value is known without code: of known names and constants."""
        if isinstance(node, ast.Name):
            if node.id in self.names:
                return self.names[node.id].known
            return node.id not in self.counts
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], (ast.Is, ast.IsNot)):
            return True
        if isinstance(node, ast.Attribute):
            return self.is_free(node.value) or node.attr == "ndim"
        if isinstance(node, ast.Constant):
            return True
        if isinstance(node, (ast.Compare, ast.BinOp, ast.UnaryOp)):
            return all(
                self.is_free(each)
                for each in ast.iter_child_nodes(node)
                if isinstance(each, ast.expr)
            )
        return False

    def branch(self, node: ast.expr, then: Any, other: Any) -> None:
        """Go on where a condition says."""
        if isinstance(node, ast.BoolOp):
            either = isinstance(node.op, ast.Or)
            for each in node.values[:-1]:
                more = self.block()
                self.branch(each, then if either else more, more if either else other)
                self.builder.position_at_end(more)
            self.branch(node.values[-1], then, other)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.branch(node.operand, other, then)
        else:
            known = self.decided(node)
            if known is not None:
                self.builder.branch(then if known else other)
            else:
                self.builder.cbranch(self.truth(self.value(node)), then, other)

    def truth(self, value: Value) -> Any:
        """Code of whether something is true."""
        if value.kind is None:
            raise NotUnderstood("truth of an object")
        code = self.code_of(value)
        if value.kind == types.boolean:
            return code
        return self.context.cast(self.builder, code, value.kind, types.boolean)

    # --- expressions ----------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Value:
        """Write the code of an expression."""
        found: Value = getattr(self, f"of_{type(node).__name__}", self.unknown)(node)
        return found

    def of_Constant(self, node: ast.Constant) -> Value:
        """Write the code of an expression."""
        return self.thing(node.value)

    def of_Name(self, node: ast.Name) -> Value:
        """Write the code of an expression."""
        return self.lookup(node.id)

    def of_Tuple(self, node: ast.Tuple) -> Value:
        """Write the code of an expression."""
        return self.joint([self.value(each) for each in node.elts])

    def of_BinOp(self, node: ast.BinOp) -> Value:
        """Write the code of an expression."""
        one, other = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow) and isinstance(other.kind, types.Integer):
            if other.object != 2 or one.kind != types.float64:  # a square is a product for numba
                return self.unknown(node)
            return self.operation(operator.mul, one, one)
        by = BINARY.get(type(node.op))
        return self.unknown(node) if by is None else self.operation(by, one, other)

    def of_UnaryOp(self, node: ast.UnaryOp) -> Value:
        """Write the code of an expression."""
        if isinstance(node.op, ast.Not):
            known = self.decided(node)
            if known is not None:
                return self.thing(known)
            return Value(types.boolean, self.builder.not_(self.truth(self.value(node.operand))))
        value = self.value(node.operand)
        if isinstance(node.op, ast.USub):
            if value.known and type(value.object) in (int, float):
                return self.thing(-value.object)
            return self.operation(operator.neg, value)
        return self.unknown(node)

    def of_Compare(self, node: ast.Compare) -> Value:
        """Write the code of an expression."""
        left, found = self.value(node.left), None
        for by, each in zip(node.ops, node.comparators, strict=True):
            right = self.value(each)
            if isinstance(by, (ast.Is, ast.IsNot)):
                if right.kind is not types.none or left.kind is None:
                    return self.unknown(node)
                one = self.thing((left.kind is types.none) == isinstance(by, ast.Is))
            elif type(by) in COMPARE:
                one = self.operation(COMPARE[type(by)], left, right)
            else:
                return self.unknown(node)
            found = one if found is None else self.both(found, one)
            left = right
        assert found is not None
        return found

    def both(self, one: Value, other: Value) -> Value:
        """Join two conditions."""
        return Value(types.boolean, self.builder.and_(self.truth(one), self.truth(other)))

    def of_BoolOp(self, node: ast.BoolOp) -> Value:
        """Write the code of an expression."""
        known = self.decided(node)
        if known is not None:
            return self.thing(known)
        if all(map(_harmless, node.values[1:])):
            values = [self.value(each) for each in node.values]
            join = self.builder.or_ if isinstance(node.op, ast.Or) else self.builder.and_
            if all(value.kind == types.boolean for value in values):
                return Value(types.boolean, reduce(join, map(self.code_of, values)))
            raise NotUnderstood("a choice of numbers")
        ends = self.block(), self.block()
        after = self.block()
        self.branch(node, *ends)
        for block in ends:
            self.builder.position_at_end(block)
            self.builder.branch(after)
        self.builder.position_at_end(after)
        codes = self.code_of(self.thing(True)), self.code_of(self.thing(False))
        return Value(types.boolean, self.joined(types.boolean, zip(codes, ends, strict=True)))

    def joined(self, kind: Any, ends: Iterable[tuple[Any, Any]]) -> Any:
        """Code of what one of several blocks has computed."""
        found = self.builder.phi(self.context.get_value_type(kind))
        for code, block in ends:
            found.add_incoming(code, block)
        return found

    def of_IfExp(self, node: ast.IfExp) -> Value:
        """Write the code of an expression."""
        known = self.decided(node.test)
        if known is not None:
            return self.value(node.body if known else node.orelse)
        simple = all(map(_simple, (node.body, node.orelse)))
        if simple and not isinstance(node.test, ast.BoolOp):
            test = self.truth(self.value(node.test))
            one, other = self.value(node.body), self.value(node.orelse)
            return self.chosen(test, one, other)
        then, otherwise, after = (self.block() for _ in range(3))
        self.branch(node.test, then, otherwise)
        values, ends = [], []
        for block, arm in ((then, node.body), (otherwise, node.orelse)):
            self.builder.position_at_end(block)
            with self.scope():
                values.append(self.value(arm))
                values[-1] = self.rebuilt(values[-1].kind, iter(self.leaves(values[-1])))
            ends.append(self.builder.block)
        codes = []
        pairs = self.pairs(*values)
        for k, block in enumerate(ends):
            self.builder.position_at_end(block)
            codes.append([self.cast(pair[k], pair[2]) for pair in pairs])
            self.builder.branch(after)
        self.builder.position_at_end(after)
        joined = [
            Value(pair[2], self.joined(pair[2], zip(each, ends, strict=True)))
            for pair, *each in zip(pairs, *codes, strict=True)
        ]
        return self.rebuilt(values[0].kind, iter(joined))

    def chosen(self, test: Any, one: Value, other: Value) -> Value:
        """Return one of two values, both of which are there."""
        parts = [
            Value(kind, self.builder.select(test, self.cast(a, kind), self.cast(b, kind)))
            for a, b, kind in self.pairs(one, other)
        ]
        return self.rebuilt(one.kind, iter(parts))

    def pairs(self, one: Value, other: Value) -> list[Any]:
        """Numbers that two values of one form are made of, side by side, with the type of both."""
        if form_of(one.kind) != form_of(other.kind):
            raise NotUnderstood("a choice of different things")
        return [
            (a, b, self.unified(a.kind, b.kind))
            for a, b in zip(self.leaves(one), self.leaves(other), strict=True)
        ]

    def leaves(self, value: Value) -> list[Value]:
        """Return what a tuple of tuples is made of."""
        if value.kind in (None, types.none):
            raise NotUnderstood("a choice of objects")
        if not isinstance(value.kind, types.BaseTuple):
            return [value]
        return [leaf for part in self.parts_of(value) for leaf in self.leaves(part)]

    def rebuilt(self, kind: Any, leaves: Iterator[Value]) -> Value:
        """Invert `leaves`."""
        if not isinstance(kind, types.BaseTuple):
            return next(leaves)
        parts = [self.rebuilt(each, leaves) for each in kind.types]
        return self.joint(parts, getattr(kind, "instance_class", None))

    def of_Attribute(self, node: ast.Attribute) -> Value:
        """Write the code of an expression."""
        held = self.held(node)
        if held is not None:
            return self.load(*held)
        value, name = self.value(node.value), node.attr
        if value.kind is None:
            if isinstance(value.object, ModuleType):
                return self.thing(getattr(value.object, name))
            return self.unknown(node)
        kind = value.kind
        if isinstance(kind, types.BaseNamedTuple):
            if name not in kind.fields:
                return self.unknown(node)
            return self.part(value, kind.fields.index(name))
        if isinstance(kind, types.Array):
            if name == "ndim":
                return self.thing(kind.ndim)
            if name == "size":
                return natural(self.count_of(value))
            if name == "shape":
                return self.joint([natural(code) for code in self.fields_of(value)[1]])
        return self.unknown(node)

    def parts_of(self, value: Value, n: int | None = None) -> list[Value]:
        """Parts of a tuple, or that many elements of an array."""
        if isinstance(value.kind, types.BaseTuple):
            if n in (None, len(value.kind.types)):
                return self.tuple_parts(value)
        elif isinstance(value.kind, types.Array) and value.kind.ndim == 1 and n is not None:
            places = (self.element(value, [self.thing(k)]) for k in range(n))
            return [self.get(value, place) for place in places]
        raise NotUnderstood("no tuple, or one of another length")

    # --- arrays ---------------------------------------------------------------------------------

    def index(self, node: ast.expr) -> list[Value]:
        """Read what an array is indexed with."""
        nodes = node.elts if isinstance(node, ast.Tuple) else [node]
        return [
            self.bounds(each) if isinstance(each, ast.Slice) else self.value(each) for each in nodes
        ]

    def bounds(self, node: ast.Slice) -> Value:
        """Read a slice."""
        if node.step is not None:
            return self.unknown(node)
        ends = [self.thing(None) if e is None else self.value(e) for e in (node.lower, node.upper)]
        return self.invoked(slice, ends)

    def whole(self, index: list[Value]) -> Value:
        """Make one value of what an array is indexed with."""
        return index[0] if len(index) == 1 else self.joint(index)

    def of_Subscript(self, node: ast.Subscript) -> Value:
        """Write the code of an expression."""
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            array, (axis,) = self.value(node.value.value), self.index(node.slice)
            if isinstance(array.kind, types.Array) and axis.known:
                return natural(self.fields_of(array)[1][axis.object])
        value, index = self.value(node.value), self.index(node.slice)
        if isinstance(value.kind, types.BaseTuple):
            (place,) = index
            n = len(value.kind.types)
            if place.known and isinstance(place.object, int) and -n <= place.object < n:
                return self.part(value, place.object % n)
            if isinstance(place.kind, types.Integer):
                return self.operation(operator.getitem, value, place)
            return self.unknown(node)
        place = self.element(value, index)
        if place is not None:
            return self.get(value, place)
        if not isinstance(value.kind, types.Array):
            return self.unknown(node)
        return self.operation(operator.getitem, value, self.whole(index))

    def get(self, array: Value, place: Any) -> Value:
        """Read an element of an array."""
        kind = array.kind.dtype
        align = None if array.kind.aligned else 1
        return Value(kind, self.context.unpack_value(self.builder, kind, place, align=align))

    def element(self, array: Value, index: list[Value]) -> Any:
        """Where an element of an array is; None if that is not what the index asks for."""
        kind, builder = array.kind, self.builder
        if not isinstance(kind, types.Array) or kind.ndim != len(index):
            return None
        if not all(isinstance(each.kind, types.Integer) for each in index) or kind.layout == "F":
            return None
        if not isinstance(kind.dtype, (types.Number, types.Boolean)):
            return None
        data, shape, strides = self.fields_of(array)
        codes = [self.inside(size, each) for size, each in zip(shape, index, strict=True)]
        if kind.layout == "C":
            at = codes[0]
            for axis in range(1, kind.ndim):
                at = builder.add(builder.mul(at, shape[axis]), codes[axis])
            return builder.gep(data, [at])
        at = None
        for code, stride in zip(codes, strides, strict=True):
            one = builder.mul(code, stride)
            at = one if at is None else builder.add(at, one)
        bytes_ = builder.bitcast(data, ir.IntType(8).as_pointer())
        return builder.bitcast(builder.gep(bytes_, [at]), data.type)

    def inside(self, size: Any, index: Value) -> Any:
        """Code of an index that counts from the beginning."""
        builder = self.builder
        if not index.kind.signed:
            return self.cast(index, types.uint64)
        code = self.cast(index, types.int64)
        if index.natural:
            return code
        if index.known:
            return builder.add(size, code)
        negative = builder.icmp_signed("<", code, ir.Constant(WORD, 0))
        return builder.select(negative, builder.add(code, size), code)

    # --- operations and calls -------------------------------------------------------------------

    def operation(self, by: Any, *values: Value) -> Value:
        """Apply an operator of numba."""
        if all(value.known and type(value.object) in (int, float, bool) for value in values):
            folded = _folded(by, [value.object for value in values])
            if folded is not None:
                return self.thing(folded)
        kinds = tuple(value.kind for value in values)
        if None in kinds:
            raise NotUnderstood("an operation on objects")
        if len(kinds) == 2 and (by in FLOATS or by in SIGNS):
            found = self.plain(by, *values)
            if found is not None:
                return found
        return self.invoked(by, list(values))

    def plain(self, by: Any, one: Value, other: Value) -> Value | None:
        """Apply an operator to two numbers, if that is one instruction."""
        kinds, builder = {one.kind, other.kind}, self.builder
        if kinds <= {types.float64, types.int64} and types.float64 in kinds:
            codes = self.cast(one, types.float64), self.cast(other, types.float64)
            if by in FLOATS:
                return Value(types.float64, getattr(builder, FLOATS[by])(*codes))
            compared = builder.fcmp_unordered if by is operator.ne else builder.fcmp_ordered
            return Value(types.boolean, compared(SIGNS[by], *codes))
        if kinds == {types.int64} or kinds == {types.uint64}:
            codes = self.code_of(one), self.code_of(other)
            if by in WHOLES:
                found = Value(one.kind, getattr(builder, WHOLES[by])(*codes))
                found.natural = one.natural and other.natural and by is not operator.sub
                return found
            if by in SIGNS:
                signed = kinds == {types.int64}
                compared = builder.icmp_signed if signed else builder.icmp_unsigned
                return Value(types.boolean, compared(SIGNS[by], *codes))
        return None

    def of_Call(self, node: ast.Call) -> Value:
        """Write the code of an expression."""
        if node.keywords:
            return self.unknown(node)
        function = self.value(node.func)
        if function.kind is not None:
            return self.unknown(node)
        values: list[Value] = []
        for each in node.args:
            if isinstance(each, ast.Starred):
                values.extend(self.parts_of(self.value(each.value)))
            else:
                values.append(self.value(each))
        thing = function.object
        if isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields"):
            if len(values) != len(thing._fields):
                return self.unknown(node)
            return self.joint(values, thing)
        if thing in (min, max) and len(values) > 1:
            return self.extreme(operator.lt if thing is min else operator.gt, values)
        return self.invoked(thing, values)

    def extreme(self, better: Any, values: list[Value]) -> Value:
        """As numba's `do_minmax`, and Python's."""
        best = values[0]
        if not all(isinstance(each.kind, types.Number) for each in values):
            raise NotUnderstood("extremes of other things")
        for each in values[1:]:
            kind = self.typing.unify_types(best.kind, each.kind)
            old, new = Value(kind, self.cast(best, kind)), Value(kind, self.cast(each, kind))
            test = self.truth(self.operation(better, new, old))
            natural = best.natural and each.natural
            best = Value(kind, self.builder.select(test, new.given, old.given))
            best.natural = natural
        return best

    def invoked(self, thing: Any, values: list[Value]) -> Value:
        """Call a function that numba knows."""
        kinds = tuple(value.kind for value in values)
        if None in kinds:
            raise NotUnderstood("an object as an argument")
        part = self.called(thing, kinds)
        if part is not None:
            return self.result_of(part, values)
        function = self.typing.resolve_value_type(thing)
        sig = self.typing.resolve_function_type(function, kinds, {})
        if sig is None:
            raise NotUnderstood(f"{thing} of {kinds}")
        wanted = list(sig.args)
        if wanted and isinstance(wanted[-1], types.StarArgTuple):
            split = len(wanted) - 1
            values = [*values[:split], Value(wanted[-1], parts=values[split:])]
        if len(wanted) != len(values) or sig.recvr is not None:
            raise NotUnderstood(f"arguments of {thing}")
        codes = [self.cast(value, kind) for value, kind in zip(values, wanted, strict=True)]
        implementation = self.context.get_function(function, sig)
        code = implementation(self.builder, codes)
        kind = sig.return_type
        if isinstance(kind, (types.Optional, types.Literal)):
            raise NotUnderstood(f"result of {thing}")
        return known(kind, None) if kind is types.none else self.spread(Value(kind, code))


def _harmless(node: ast.expr) -> bool:
    return all(isinstance(each, HARMLESS) for each in ast.walk(node))


def _simple(node: ast.expr) -> bool:
    """Whether a value is there already, or a constant."""
    if isinstance(node, ast.Tuple):
        return all(map(_simple, node.elts))
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant)
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, (ast.Name, ast.Constant))


def _folded(by: Any, numbers: list[Any]) -> Any:
    """Apply an operator to numbers of Python; None if numba may find another result."""
    if by in FLOATS or by in SIGNS:
        if by is operator.truediv and numbers[1] == 0:
            return None
        if any(isinstance(each, bool) for each in numbers) and by not in SIGNS:
            return None
        found = by(*numbers)
        small = not isinstance(found, int) or abs(found) < 2**62
        return found if small and not (isinstance(found, float) and math.isnan(found)) else None
    if by in (operator.floordiv, operator.mod, operator.lshift, operator.rshift):
        if all(type(each) is int and 0 <= each < 2**31 for each in numbers) and numbers[1]:
            return by(*numbers) if by is not operator.lshift or numbers[1] < 32 else None
    return None
