"""Functions that kernels call by their address: of a user, who has them in one process only.

Kernels that hold the function itself would have to be compiled with it, each time anew.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from stickslip.numerics.targets import config, kernel_uncached

Function = Callable[..., float]
_kept: list[Any] = []  # while the process lives, so does what it may call


@cache
def address_of(function: Function, n: int) -> float:
    """Where `call_at` finds a function of n numbers: a whole number, of this process."""
    compiled: Any = kernel_uncached(function)
    _kept.append(compiled)
    if config.DISABLE_JIT:
        return float(len(_kept) - 1)
    return float(compiled.address((types.float64,) * n))


@intrinsic
def _call_at(typingctx: Any, address: Any, *numbers: Any) -> Any:
    kinds = (types.float64,) * len(numbers)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        convention = context.call_conv
        pointer = convention.get_function_type(types.float64, kinds).as_pointer()
        function = builder.inttoptr(builder.fptoui(args[0], ir.IntType(64)), pointer)
        values = cgutils.unpack_tuple(builder, args[1])
        status, value = convention.call_function(builder, function, types.float64, kinds, values)
        with cgutils.if_unlikely(builder, status.is_error):  # the user's own exception
            convention.return_status_propagate(builder, status)
        return value

    return types.float64(types.float64, types.StarArgTuple.from_types(kinds)), codegen


def _call_plain(address: float, *numbers: float) -> float:
    value: float = _kept[int(address)](*numbers)
    return value


call_at: Any = _call_plain if config.DISABLE_JIT else _call_at
"""``call_at(address, *numbers)``: the value of the function there, in kernels."""
