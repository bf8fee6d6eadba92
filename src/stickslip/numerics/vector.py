"""What vector code needs and Python lacks: bits of doubles, choices, long sums as one statement.

Numba spends its time on statements. A sum of twenty products that is one call costs what one
product does.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, cast

from numba.core import cgutils, types
from numba.extending import intrinsic

from stickslip.numerics.targets import config


def _bits(x: float) -> int:
    return int(struct.unpack("<q", struct.pack("<d", x))[0])


def _from_bits(bits: int) -> float:
    return float(struct.unpack("<d", struct.pack("<Q", bits & 2**64 - 1))[0])


def _select(condition: bool, one: float, other: float) -> float:
    return one if condition else other


def _instruction(name: str, signature: Any, emit: Callable[..., Any]) -> Any:
    """Make a function of one machine instruction."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return emit(builder, *args, context.get_value_type(signature.return_type))

    if len(signature.args) == 1:

        def typer(typingctx: Any, x: Any) -> Any:
            return signature, codegen

    else:

        def typer(typingctx: Any, condition: Any, one: Any, other: Any) -> Any:  # type: ignore[misc]
            return signature, codegen

    typer.__name__ = name
    return intrinsic(typer)


def _products(*factors: float) -> float:
    total = factors[0] * factors[1]
    for k in range(2, len(factors), 2):
        total += factors[k] * factors[k + 1]
    return total


def _polynomial(t: float, *coefficients: float) -> float:
    total = coefficients[0]
    for c in coefficients[1:]:
        total = total * t + c
    return total


def _nothing() -> None:
    pass


FUSED = ("contract",)
# LLVM takes half vectors of AVX-512 on processors whose clock, it thinks, whole ones slow down.
WIDEST = '"prefer-vector-width"="512"'


@intrinsic
def _products_text(typingctx: Any, *factors: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        x = cgutils.unpack_tuple(builder, args[0])
        total = builder.fmul(x[0], x[1], flags=FUSED)
        for one, other in zip(x[2::2], x[3::2], strict=True):
            total = builder.fadd(total, builder.fmul(one, other, flags=FUSED), flags=FUSED)
        return total

    return types.float64(types.StarArgTuple.from_types(factors)), codegen


@intrinsic
def _polynomial_text(typingctx: Any, t: Any, *coefficients: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        total, *others = cgutils.unpack_tuple(builder, args[1])
        for c in others:
            total = builder.fadd(builder.fmul(total, args[0], flags=FUSED), c, flags=FUSED)
        return total

    return types.float64(t, types.StarArgTuple.from_types(coefficients)), codegen


@intrinsic
def _wide(typingctx: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        attributes = builder.function.attributes
        attributes.alignstack = 64
        attributes.add("noinline")
        set.add(attributes, WIDEST)  # its own `add` knows attributes without a value only
        return context.get_dummy_value()

    return types.none(), codegen


bits: Callable[[float], int]
from_bits: Callable[[int], float]
select: Callable[[bool, float, float], float]
wide_vectors: Callable[[], None]
products: Callable[..., float]
polynomial: Callable[..., float]

if config.DISABLE_JIT:
    bits, from_bits, select, wide_vectors = _bits, _from_bits, _select, _nothing
    products, polynomial = _products, _polynomial
else:
    # products(a, b, c, d, ...): a b + c d + ...; polynomial(t, c_n, ..., c_0): by Horner.
    products = cast(Callable[..., float], _products_text)
    polynomial = cast(Callable[..., float], _polynomial_text)
    # wide_vectors(): the function that calls it uses the longest vectors that there are (measured:
    # a sixth to a third faster), keeps them on the stack where each lies in one line of the cache
    # (a fifth faster where many are kept), and is not inlined.
    wide_vectors = cast(Callable[[], None], _wide)
    # bits(x): bits of a double as an integer; from_bits(n): the double with these bits;
    # select(condition, one, other): one of two doubles, both of them computed.
    bits = _instruction(
        "bits", types.int64(types.float64), lambda builder, x, kind: builder.bitcast(x, kind)
    )
    from_bits = _instruction(
        "from_bits", types.float64(types.int64), lambda builder, n, kind: builder.bitcast(n, kind)
    )
    select = _instruction(
        "select",
        types.float64(types.boolean, types.float64, types.float64),
        lambda builder, condition, one, other, kind: builder.select(condition, one, other),
    )
