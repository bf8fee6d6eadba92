"""What vector code needs and Python lacks: the bits of doubles, and a choice without a branch."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from numba.core import types
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


def _align_stack() -> None:
    pass


def _aligned_stack(typingctx: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        attributes = builder.function.attributes
        attributes.alignstack = 64
        attributes.add("noinline")
        return context.get_dummy_value()

    return types.none(), codegen


if config.DISABLE_JIT:
    bits, from_bits, select, align_stack = _bits, _from_bits, _select, _align_stack
else:
    # align_stack(): the function that calls it keeps its vectors on the stack where each lies in
    # one line of the cache (measured: a fifth faster where many are kept), and is not inlined.
    align_stack = intrinsic(_aligned_stack)
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
