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
from numba.core import cgutils

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
# Of numba's arrays.
N_ITEMS, DATA, SHAPE, STRIDES = 2, 4, 5, 6
# What may be evaluated though Python would not: without effect, and no index out of an array.
HARMLESS = (
    ast.Name, ast.Constant, ast.Compare, ast.BoolOp, ast.UnaryOp, ast.Attribute, ast.expr_context,
    ast.cmpop, ast.boolop, ast.unaryop, ast.BinOp, ast.Add, ast.Sub, ast.Mult,
)  # fmt: skip
WORD, HALF = ir.IntType(64), ir.IntType(32)


class Again(Exception):
    """A name or the result turned out to be of another kind: the kernel is read again."""


class Expressions:
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
        self.function, self.text, self.state, self.called = function, text, state, called
        self.context, self.typing = state.targetctx, state.typingctx
        self.slots, self.kinds = slots, kinds  # what earlier readings have found
        self.names: dict[str, Value] = {}
        self.places: dict[str, Any] = {}  # of slots
        self.builder: Any = None
        self.code: Any = None
        self.entry: Any = None
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

    # --- code

    def block(self) -> Any:
        """Begin a block of code."""
        return self.code.append_basic_block()

    def room(self, type_: Any) -> Any:
        """Place on the stack for something of a type of LLVM, or of each of its parts."""
        if isinstance(type_, (tuple, list)):
            return [self.room(each) for each in type_]
        with self.builder.goto_block(self.entry):
            return self.builder.alloca(type_)

    def slot(self, kind: Any) -> Any:
        """Place for a value, of a tuple for each part."""
        if isinstance(kind, types.BaseTuple):
            return [self.slot(each) for each in kind.types]
        if isinstance(kind, types.Array):
            return self.room(self.context.data_model_manager[kind].get_argument_type())
        return self.room(self.context.get_value_type(kind))

    def store(self, value: Value, kind: Any, slot: Any) -> None:
        """Keep a value, as another type, in a slot."""
        if isinstance(kind, types.BaseTuple):
            for part, *each in zip(self.parts_of(value), kind.types, slot, strict=True):
                self.store(part, *each)
        elif isinstance(kind, types.Array):
            codes = self.fields_of(
                value if value.kind == kind else Value(kind, self.cast(value, kind))
            )
            for code, place in zip(_flat(codes), _flat(slot), strict=True):
                self.builder.store(code, place)
        else:
            self.builder.store(self.cast(value, kind), slot)

    def load(self, kind: Any, slot: Any) -> Value:
        """Read what a slot holds."""
        if isinstance(kind, types.BaseTuple):
            parts = [self.load(*each) for each in zip(kind.types, slot, strict=True)]
            return Value(kind, parts=parts)
        if isinstance(kind, types.Array):
            return self.argument(kind, _mapped(self.builder.load, slot))
        if kind is types.none:
            return known(kind, None)
        return Value(kind, self.builder.load(slot))

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

    def code_of(self, value: Value) -> Any:
        """Code of a value: of a known one a constant."""
        if value.given is not None:
            return value.given
        if value.parts is not None or value.fields is not None:
            if value.made is None or value.made[0] is not self.builder.block:
                value.made = self.builder.block, self.whole_of(value)
            return value.made[1]
        if value.kind is types.none:
            return self.context.get_dummy_value()
        if value.known and value.kind is not None:
            return self.constant(value)
        raise NotUnderstood("an object as a value")

    def whole_of(self, value: Value) -> Any:
        """Code of a tuple or an array, joined of its parts."""
        if value.fields is not None:
            return self.context.get_argument_value(self.builder, value.kind, value.fields)
        codes = [self.code_of(each) for each in value.parts or ()]
        return self.context.make_tuple(self.builder, value.kind, codes)

    def fields_of(self, value: Value) -> Any:
        """Code of each field of an array, or of a number, as numba passes them."""
        if value.fields is not None:
            return value.fields
        code = self.code_of(value)
        return self.context.get_value_as_argument(self.builder, value.kind, code)

    def constant(self, value: Value) -> Any:
        """Code of a known number or array."""
        kind, thing = value.kind, value.object
        if kind in (types.float64, types.int64, types.uint64, types.boolean):
            number = thing.item() if isinstance(thing, np.generic) else thing
            return ir.Constant(self.context.get_value_type(kind), number)
        return self.context.get_constant_generic(self.builder, kind, thing)

    def cast(self, value: Value, kind: Any) -> Any:
        """Code of a value as another type."""
        if value.kind == kind:
            return self.code_of(value)
        if value.known and kind == types.float64 and isinstance(value.object, (int, float)):
            return ir.Constant(ir.DoubleType(), float(value.object))
        return self.context.cast(self.builder, self.code_of(value), value.kind, kind)

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
        by = BINARY.get(type(node.op))
        if by is None:
            return self.unknown(node)
        return self.operation(by, self.value(node.left), self.value(node.right))

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
                return natural(self.field(value, N_ITEMS))
            if name == "shape":
                return self.joint([natural(self.field(value, SHAPE, k)) for k in range(kind.ndim)])
        return self.unknown(node)

    def field(self, array: Value, *path: int) -> Any:
        """Code of a field of an array: numbers of an argument are there already."""
        if array.fields is None:
            return self.builder.extract_value(self.code_of(array), path)
        return reduce(operator.getitem, path, array.fields)

    def part(self, value: Value, place: int) -> Value:
        """Part of a tuple."""
        if value.parts is not None:
            return value.parts[place]
        kind = value.kind.types[place]
        if kind is types.none:
            return known(kind, None)
        return Value(kind, self.builder.extract_value(self.code_of(value), place))

    def parts_of(self, value: Value, n: int | None = None) -> list[Value]:
        """Parts of a tuple, or that many elements of an array."""
        if isinstance(value.kind, types.BaseTuple):
            parts = [self.part(value, k) for k in range(len(value.kind.types))]
            if n in (None, len(parts)):
                return parts
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
                return natural(self.field(array, SHAPE, axis.object))
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
        data = self.field(array, DATA)
        codes = [self.inside(array, axis, each) for axis, each in enumerate(index)]
        if kind.layout == "C":
            at = codes[0]
            for axis in range(1, kind.ndim):
                at = builder.add(builder.mul(at, self.field(array, SHAPE, axis)), codes[axis])
            return builder.gep(data, [at])
        at = None
        for axis, code in enumerate(codes):
            one = builder.mul(code, self.field(array, STRIDES, axis))
            at = one if at is None else builder.add(at, one)
        bytes_ = builder.bitcast(data, ir.IntType(8).as_pointer())
        return builder.bitcast(builder.gep(bytes_, [at]), data.type)

    def inside(self, array: Value, axis: int, index: Value) -> Any:
        """Code of an index that counts from the beginning."""
        builder = self.builder
        if not index.kind.signed:
            return self.cast(index, types.uint64)
        code = self.cast(index, types.int64)
        if index.natural:
            return code
        if index.known:
            return builder.add(self.field(array, SHAPE, axis), code)
        size = self.field(array, SHAPE, axis)
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
        return known(kind, None) if kind is types.none else Value(kind, code)

    # --- kernels --------------------------------------------------------------------------------
    # Called as numba calls them. A tuple goes from kernel to kernel as the numbers it is made of,
    # which nobody joins on the way: most of the code would do so.

    def argument(self, kind: Any, codes: Any) -> Value:
        """Value of an argument of this kernel."""
        if kind is types.none:
            return known(kind, None)
        if isinstance(kind, types.BaseTuple):
            parts = [self.argument(*each) for each in zip(kind.types, codes, strict=True)]
            return Value(kind, parts=parts)
        if isinstance(kind, types.Array):
            array = Value(kind)
            array.fields = codes
            return array
        return Value(kind, self.context.get_argument_value(self.builder, kind, codes))

    def passed(self, value: Value) -> list[Any]:
        """Codes of an argument of another kernel."""
        if value.parts is not None:
            return [code for part in value.parts for code in self.passed(part)]
        return list(_flat(self.fields_of(value)))

    def result_of(self, part: Any, values: list[Value]) -> Value:
        """Call a kernel."""
        builder, told = self.builder, part.fndesc
        if isinstance(told.restype, types.Optional):
            raise NotUnderstood("a result that may be none")
        callee = builder.module.globals.get(told.llvm_func_name)
        if callee is None:
            callee = self.context.declare_function(builder.module, told)
        self.context.add_linking_libs([part.library])
        place, trouble = self.room(callee.args[0].type.pointee), self.code.args[1]
        codes = [code for value in values for code in self.passed(value)]
        status = builder.call(callee, [place, trouble, *codes])
        with cgutils.if_unlikely(builder, builder.icmp_signed("!=", status, status.type(0))):
            builder.ret(status)
        return self.taken(told.restype, place)

    def taken(self, kind: Any, place: Any) -> Value:
        """Read the result of a kernel from where the kernel put it."""
        if kind is types.none:
            return known(kind, None)
        if isinstance(kind, types.BaseTuple):
            parts = [self.taken(each, self.place_of(place, k)) for k, each in enumerate(kind.types)]
            return Value(kind, parts=parts)
        code = self.builder.load(place)
        if code.type != self.context.get_value_type(kind):
            code = self.context.data_model_manager[kind].from_data(self.builder, code)
        return Value(kind, code)

    def put_result(self, kind: Any, value: Value, place: Any) -> None:
        """Put the result of this kernel where the caller takes it from."""
        if isinstance(kind, types.BaseTuple) and len(kind.types):
            for k, part in enumerate(self.parts_of(value, len(kind.types))):
                self.put_result(kind.types[k], part, self.place_of(place, k))
            return
        code = self.cast(value, kind)
        if code.type != place.type.pointee:
            code = self.context.get_value_as_data(self.builder, kind, code)
        self.builder.store(code, place)

    def place_of(self, tuple_: Any, k: int) -> Any:
        """Where a part of a tuple is."""
        return self.builder.gep(tuple_, [HALF(0), HALF(k)], inbounds=True)


def _flat(codes: Any) -> Iterator[Any]:
    if not isinstance(codes, (tuple, list)):
        yield codes
    else:
        for each in codes:
            yield from _flat(each)


def _mapped(function: Callable[[Any], Any], tree: Any) -> Any:
    if isinstance(tree, list):
        return [_mapped(function, each) for each in tree]
    return function(tree)


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
