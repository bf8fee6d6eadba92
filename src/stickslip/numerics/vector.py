"""Lanes: a vector of doubles as one value; every operation on them is vector code.

A function of lanes is Python. It runs on arrays of NumPy; or once on values that write down what is
asked of them, whatever loops, lists and branches lead there: straight-line code in the kernel that
calls it (`written`). Numba would type every statement, which takes longer than all else.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from stickslip.numerics.kernel_cache import levels
from stickslip.numerics.targets import config

# One vector of AVX-512, else of AVX2: with twice as many lanes a few motions cost up to twice as
# much, and many no less.
LANES = 8 if "x86-64-v4" in levels() else 4

FUSED = ("contract",)
# LLVM takes half vectors of AVX-512 on processors whose clock, it thinks, whole ones slow down.
WIDEST = '"prefer-vector-width"="512"'

DOUBLE, WHOLE, TRUTH = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
LANES_KIND = ir.VectorType(DOUBLE, LANES)
INSTRUCTIONS = {
    DOUBLE: {"add": "fadd", "sub": "fsub", "mul": "fmul", "truediv": "fdiv", "neg": "fneg"},
    WHOLE: {"add": "add", "and_": "and_", "or_": "or_", "lshift": "shl", "rshift": "ashr"},
    TRUTH: {"and_": "and_", "or_": "or_", "invert": "not_"},
}

F = TypeVar("F", bound=Callable[..., Any])
Lanes = Any  # an array, or a value that is written
Floats = Any  # an array of either kind


# --- values that are written --------------------------------------------------------------------


def _operator(name: str, turned: bool = False) -> Any:
    return lambda self, other: self._binary(name, other, turned)


def _comparison(sign: str) -> Any:
    return lambda self, other: self.made(self.builder.fcmp_ordered(sign, *_alike(self, other)))


class _Value:
    """A double, or lanes of doubles, integers or truth values."""

    __slots__ = ("builder", "context", "value")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, context: Any, builder: Any, value: Any) -> None:
        self.context, self.builder, self.value = context, builder, value

    def made(self, value: Any) -> _Value:
        """Another one, in the same code."""
        return _Value(self.context, self.builder, value)

    def _instruction(self, name: str, *operands: Any) -> _Value:
        element = getattr(self.value.type, "element", self.value.type)
        flags = {"flags": FUSED} if len(operands) == 2 and element == DOUBLE else {}
        emit = getattr(self.builder, INSTRUCTIONS[element][name])
        return self.made(emit(*operands, **flags))

    def _binary(self, name: str, other: Any, turned: bool) -> _Value:
        one, two = _alike(self, other)
        return self._instruction(name, *((two, one) if turned else (one, two)))

    __add__, __sub__ = _operator("add"), _operator("sub")
    __mul__, __truediv__ = _operator("mul"), _operator("truediv")
    __rsub__, __rtruediv__ = _operator("sub", turned=True), _operator("truediv", turned=True)
    __and__, __or__ = _operator("and_"), _operator("or_")
    __lshift__, __rshift__ = _operator("lshift"), _operator("rshift")
    __lt__, __le__, __eq__ = _comparison("<"), _comparison("<="), _comparison("==")
    __gt__, __ge__ = _comparison(">"), _comparison(">=")

    def __radd__(self, other: Any) -> _Value:
        return self if other == 0 else self._binary("add", other, turned=True)  # a sum begins

    def __rmul__(self, other: Any) -> Any:
        return other if other == 0 else self._binary("mul", other, turned=True)

    def __neg__(self) -> _Value:
        return self._instruction("neg", self.value)

    def __invert__(self) -> _Value:
        return self._instruction("invert", self.value)

    def __abs__(self) -> _Value:
        kind, module = self.value.type, self.builder.module
        name = f"llvm.fabs.{f'v{LANES}' if kind == LANES_KIND else ''}f64"
        absolute = cgutils.get_or_insert_function(module, ir.FunctionType(kind, [kind]), name)
        return self.made(self.builder.call(absolute, [self.value]))

    def __bool__(self) -> bool:
        raise TypeError("no branch of straight-line code: select")


def _alike(one: Any, other: Any) -> tuple[Any, Any]:
    """Two operands of one type: a number beside lanes is in each of them."""
    builder = (one if isinstance(one, _Value) else other).builder
    kinds = [each.value.type for each in (one, other) if isinstance(each, _Value)]
    kind = next((each for each in kinds if isinstance(each, ir.VectorType)), kinds[0])
    return _operand(builder, one, kind), _operand(builder, other, kind)


def _operand(builder: Any, operand: Any, kind: Any) -> Any:
    if not isinstance(operand, _Value):
        element = getattr(kind, "element", kind)
        number = int(operand) if element == WHOLE else float(operand)
        return ir.Constant(kind, [number] * LANES if kind != element else number)
    if operand.value.type == kind:
        return operand.value
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), operand.value, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(kind, ir.Undefined), zeros)


class _Array:
    """An array whose single elements nothing writes; vectors of it are read and written."""

    def __init__(self, context: Any, builder: Any, kind: Any, value: Any) -> None:
        self.context, self.builder = context, builder
        self.data = context.make_array(kind)(context, builder, value).data
        self._read: dict[int, _Value] = {}

    def __getitem__(self, place: int) -> _Value:
        if place not in self._read:
            pointer = self.builder.gep(self.data, [ir.Constant(WHOLE, place)])
            self._read[place] = _Value(self.context, self.builder, self.builder.load(pointer))
        return self._read[place]

    def vector(self, place: int) -> Any:
        pointer = self.builder.gep(self.data, [ir.Constant(WHOLE, place)])
        return self.builder.bitcast(pointer, LANES_KIND.as_pointer())


# --- functions ----------------------------------------------------------------------------------


def load(x: Floats, place: int) -> Lanes:
    """Return the lanes that begin at a place of an array."""
    if isinstance(x, _Array):
        return _Value(x.context, x.builder, x.builder.load(x.vector(place), align=8))
    return x[place : place + LANES].copy()


def store(x: Floats, place: int, lanes: Lanes) -> None:
    """Write lanes, or a number into each, at a place of an array."""
    if isinstance(x, _Array):
        x.builder.store(_operand(x.builder, lanes, LANES_KIND), x.vector(place), align=8)
    else:
        x[place : place + LANES] = lanes


def select(mask: Lanes, one: Lanes, other: Lanes) -> Lanes:
    """Of each lane one of two doubles, both of them computed."""
    if isinstance(mask, _Value):
        choices = (_operand(mask.builder, each, LANES_KIND) for each in (one, other))
        return mask.made(mask.builder.select(mask.value, *choices))
    return np.where(mask, one, other)


def polynomial(t: Lanes, *coefficients: Lanes) -> Lanes:
    """Value of a polynomial, the highest power first, by Horner."""
    total = coefficients[0]
    for c in coefficients[1:]:
        total = total * t + c
    return total


def bits(lanes: Lanes) -> Lanes:
    """Bits of doubles as integers."""
    return _reread(lanes, WHOLE, np.int64)


def from_bits(integers: Lanes) -> Lanes:
    """Return the doubles with these bits."""
    return _reread(integers, DOUBLE, np.float64)


def _reread(row: Lanes, element: Any, kind: Any) -> Lanes:
    if isinstance(row, _Value):
        return row.made(row.builder.bitcast(row.value, ir.VectorType(element, LANES)))
    return np.asarray(row).view(kind)


class _OfLanes:
    """Functions of `math`, of each lane by itself."""

    def __getattr__(self, name: str) -> Callable[..., Lanes]:
        return partial(_of_each, getattr(math, name))


of_lanes = _OfLanes()


def _of_each(function: Callable[..., float], *arguments: Lanes) -> Lanes:
    first = next((each for each in arguments if isinstance(each, _Value)), None)
    if first is None:
        rows = zip(*np.broadcast_arrays(*arguments, np.empty(LANES))[:-1], strict=True)
        return np.array([function(*row) for row in rows])
    context, builder = first.context, first.builder
    typing = context.typing_context
    kind = typing.resolve_value_type(function)
    sig = kind.get_call_type(typing, (types.float64,) * len(arguments), {})
    call = context.get_function(kind, sig)
    context.add_linking_libs(getattr(call, "libs", ()))
    operands = [_operand(builder, each, LANES_KIND) for each in arguments]
    found: Any = ir.Constant(LANES_KIND, ir.Undefined)
    for place in map(ir.IntType(32), range(LANES)):
        one = call(builder, [builder.extract_element(each, place) for each in operands])
        found = builder.insert_element(found, one, place)
    return first.made(found)


# --- kernels ------------------------------------------------------------------------------------


def written(function: F) -> F:
    """Make what a kernel calls for the work of a function that returns nothing.

    It takes arrays, which do not overlap and whose single elements nothing writes, and numbers.
    """
    if config.DISABLE_JIT:
        return function

    def typer(typingctx: Any, *kinds: Any) -> Any:
        def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            given = cgutils.unpack_tuple(builder, args[0])
            function(
                *(
                    _Array(context, builder, kind, value)
                    if isinstance(kind, types.Array)
                    else _Value(context, builder, value)
                    for kind, value in zip(kinds, given, strict=True)
                )
            )
            return context.get_dummy_value()

        return types.none(types.StarArgTuple.from_types(kinds)), codegen

    made: Any = intrinsic(typer)
    return made


def _nothing() -> None:
    pass


@intrinsic
def _wide(typingctx: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        attributes = builder.function.attributes
        attributes.alignstack = 64
        attributes.add("noinline")
        set.add(attributes, WIDEST)  # its own `add` knows attributes without a value only
        return context.get_dummy_value()

    return types.none(), codegen


# wide_vectors(): the function that calls it uses the longest vectors that there are (measured: a
# sixth to a third faster), keeps them on the stack where each lies in one line of the cache (a
# fifth faster where many are kept), and is not inlined.
wide_vectors: Any = _nothing if config.DISABLE_JIT else _wide
