"""Lanes: eight doubles as one value of a kernel; every operation on them is vector code.

They are one vector of AVX-512, two of AVX2; in plain Python arrays of NumPy. They come from an
array (`load`) and go back into one (`store`). Numba spends its time on statements: one call that
sums twenty products costs what one product does.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, register_model
from numpy.typing import NDArray

from stickslip.numerics.targets import config

# One AVX-512 vector: a few motions cost half of what they would with 16 lanes, a full row the same.
LANES = 8

FUSED = ("contract",)
# LLVM takes half vectors of AVX-512 on processors whose clock, it thinks, whole ones slow down.
WIDEST = '"prefer-vector-width"="512"'

Floats = NDArray[np.float64]
Lanes = Any  # to the type checker, which does not know numba's types


# --- plain Python -------------------------------------------------------------------------------


def _load(x: Floats, place: int) -> Lanes:
    return x[place : place + LANES].copy()


def _store(x: Floats, place: int, lanes: Lanes) -> None:
    x[place : place + LANES] = lanes


def _bits(lanes: Lanes) -> Lanes:
    return np.asarray(lanes).view(np.int64)


def _from_bits(bits: Lanes) -> Lanes:
    return np.asarray(bits).view(np.float64)


def _select(mask: Lanes, one: Lanes, other: Lanes) -> Lanes:
    return np.where(mask, one, other)


def _products(*factors: Lanes) -> Lanes:
    total = factors[0] * factors[1]
    for k in range(2, len(factors), 2):
        total = total + factors[k] * factors[k + 1]
    return total


def _polynomial(t: Lanes, *coefficients: Lanes) -> Lanes:
    total = coefficients[0]
    for c in coefficients[1:]:
        total = total * t + c
    return total


def _nothing() -> None:
    pass


# --- types --------------------------------------------------------------------------------------


class _Row(types.Type):
    """Eight doubles, integers of 64 bits, or truth values."""

    def __init__(self, name: str, element: Any) -> None:
        super().__init__(f"{name} x {LANES}")
        self.element = element
        self.vector = ir.VectorType(element, LANES)


lanes = _Row("float64", ir.DoubleType())
integers = _Row("int64", ir.IntType(64))
mask = _Row("bool", ir.IntType(1))


@register_model(_Row)
class _RowModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: _Row) -> None:
        super().__init__(manager, kind, kind.vector)  # type: ignore[no-untyped-call]


def _spread(builder: Any, value: Any, row: _Row) -> Any:
    """Give every lane the value, unless it is a row already."""
    if value.type == row.vector:
        return value
    one = builder.insert_element(ir.Constant(row.vector, ir.Undefined), value, ir.IntType(32)(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(row.vector, ir.Undefined), zeros)


# --- operators ----------------------------------------------------------------------------------


def _operator(function: Any, row: _Row, result: _Row, emit: Callable[..., Any], n: int = 2) -> None:
    """Define an operator on rows; with two operands either may be a number."""
    number = types.float64 if row is lanes else types.int64
    cases: list[tuple[Any, ...]] = [(row,) * n]
    if n == 2 and row is not mask:
        cases += [(row, number), (number, row)]

    def lowered(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return emit(builder, *(_spread(builder, arg, row) for arg in args))

    for case in cases:
        lower_builtin(function, *case)(lowered)
    known = {"key": function, "cases": [signature(result, *case) for case in cases]}
    infer_global(function)(type(f"{row.name} {function.__name__}", (ConcreteTemplate,), known))


def _absolute(builder: Any, x: Any) -> Any:
    kind = ir.FunctionType(x.type, [x.type])
    name = f"llvm.fabs.v{LANES}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [x])


def _instruction(name: str, **flags: Any) -> Callable[..., Any]:
    return lambda builder, *args: getattr(builder, name)(*args, **flags)


def _comparison(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


def _define() -> None:
    """Define what the steps of lanes use."""
    arithmetic = {"add": "fadd", "sub": "fsub", "mul": "fmul", "truediv": "fdiv"}
    for name, instruction in arithmetic.items():
        _operator(getattr(operator, name), lanes, lanes, _instruction(instruction, flags=FUSED))
    _operator(operator.neg, lanes, lanes, _instruction("fneg"), 1)
    _operator(abs, lanes, lanes, _absolute, 1)
    for name, sign in {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "=="}.items():
        _operator(getattr(operator, name), lanes, mask, _comparison(sign))
    whole = {"add": "add", "and_": "and_", "or_": "or_", "lshift": "shl", "rshift": "ashr"}
    for name, instruction in whole.items():
        _operator(getattr(operator, name), integers, integers, _instruction(instruction))
    for name in ("and_", "or_"):
        _operator(getattr(operator, name), mask, mask, _instruction(name))
    _operator(operator.invert, mask, mask, _instruction("not_"), 1)


# --- functions ----------------------------------------------------------------------------------


def _place(builder: Any, context: Any, array: Any, value: Any, place: Any) -> Any:
    data = context.make_array(array)(context, builder, value).data
    return builder.bitcast(builder.gep(data, [place]), lanes.vector.as_pointer())


@intrinsic
def _load_text(typingctx: Any, x: Any, place: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_place(builder, context, sig.args[0], *args), align=8)

    return lanes(x, types.intp), codegen


@intrinsic
def _store_text(typingctx: Any, x: Any, place: Any, value: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        pointer = _place(builder, context, sig.args[0], *args[:2])
        builder.store(_spread(builder, args[2], lanes), pointer, align=8)
        return context.get_dummy_value()

    return types.none(x, types.intp, value), codegen


def _numbers(kinds: Any) -> tuple[Any, ...]:
    """Operands as they are taken: rows as rows, whatever else as doubles."""
    return tuple(lanes if kind == lanes else types.float64 for kind in kinds)


@intrinsic
def _select_text(typingctx: Any, condition: Any, one: Any, other: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.select(args[0], *(_spread(builder, arg, lanes) for arg in args[1:]))

    return lanes(mask, *_numbers((one, other))), codegen


@intrinsic
def _products_text(typingctx: Any, *factors: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        x = [_spread(builder, arg, lanes) for arg in cgutils.unpack_tuple(builder, args[0])]
        total = builder.fmul(x[0], x[1], flags=FUSED)
        for one, other in zip(x[2::2], x[3::2], strict=True):
            total = builder.fadd(total, builder.fmul(one, other, flags=FUSED), flags=FUSED)
        return total

    return lanes(types.StarArgTuple.from_types(_numbers(factors))), codegen


@intrinsic
def _polynomial_text(typingctx: Any, t: Any, *coefficients: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        rows = [_spread(builder, arg, lanes) for arg in cgutils.unpack_tuple(builder, args[1])]
        total = rows[0]
        for c in rows[1:]:
            total = builder.fadd(builder.fmul(total, args[0], flags=FUSED), c, flags=FUSED)
        return total

    return lanes(lanes, types.StarArgTuple.from_types(_numbers(coefficients))), codegen


def _reread(source: _Row, result: _Row) -> Any:
    def typer(typingctx: Any, row: Any) -> Any:
        def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return builder.bitcast(args[0], result.vector)

        return result(source), codegen

    typer.__name__ = f"{source} as {result}"
    return intrinsic(typer)


@intrinsic
def _wide(typingctx: Any) -> Any:
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        attributes = builder.function.attributes
        attributes.alignstack = 64
        attributes.add("noinline")
        set.add(attributes, WIDEST)  # its own `add` knows attributes without a value only
        return context.get_dummy_value()

    return types.none(), codegen


# load(x, place): the lanes that begin at a place of an array; store(x, place, lanes).
load: Callable[[Floats, int], Lanes]
store: Callable[[Floats, int, Lanes], None]
# select(mask, one, other): of each lane one of two doubles, both of them computed.
select: Callable[[Lanes, Lanes, Lanes], Lanes]
# products(a, b, c, d, ...): a b + c d + ...; polynomial(t, c_n, ..., c_0): by Horner.
products: Callable[..., Lanes]
polynomial: Callable[..., Lanes]
# bits(lanes): bits of doubles as integers; from_bits(integers): the doubles with these bits.
bits: Callable[[Lanes], Lanes]
from_bits: Callable[[Lanes], Lanes]
# wide_vectors(): the function that calls it uses the longest vectors that there are (measured: a
# sixth to a third faster), keeps them on the stack where each lies in one line of the cache (a
# fifth faster where many are kept), and is not inlined.
wide_vectors: Callable[[], None]

if config.DISABLE_JIT:
    load, store, select, products, polynomial = _load, _store, _select, _products, _polynomial
    bits, from_bits, wide_vectors = _bits, _from_bits, _nothing
else:
    _define()
    load, store = cast(Any, _load_text), cast(Any, _store_text)
    select, products, polynomial = (
        cast(Any, text) for text in (_select_text, _products_text, _polynomial_text)
    )
    bits, from_bits = _reread(lanes, integers), _reread(integers, lanes)
    wide_vectors = cast(Any, _wide)
