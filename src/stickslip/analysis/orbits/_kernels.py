"""The linear equations of Newton's method for periodic orbits, compiled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats

    Counts = NDArray[np.intp]


@kernel
def cyclic_rows(s: Floats, b: Floats, periods: Counts, y: Floats) -> None:
    """Solve s_i y_i - y_(i+1) = b_i, cyclic in each row of its own length."""
    for k in range(len(s)):
        cyclic_row(s[k, : periods[k]], b[k, : periods[k]], y[k, : periods[k]])


@kernel
def cyclic_row(s: Floats, b: Floats, y: Floats) -> None:
    """Solve for one row; never divide by what should be large."""
    columns = len(s)
    product, now = 1.0, 0.0
    for j in range(columns):
        product = product * s[j]
    if abs(product) <= 1:
        # Start where going round once leads back.
        for j in range(columns):
            now = s[j] * now - b[j]
        now = now / (1 - product)
        for j in range(columns):
            y[j] = now
            now = s[j] * now - b[j]
    else:
        for j in range(columns - 1, -1, -1):
            now = (now + b[j]) / s[j]
        now = now / (1 - 1 / product)
        for j in range(columns - 1, -1, -1):
            now = (now + b[j]) / s[j]
            y[j] = now


@kernel
def newton_rows(
    s: Floats,
    b: Floats,
    periods: Counts,
    rounding: tuple[float, float, float],
    y: Floats,
    is_done: NDArray[np.bool_],
) -> None:
    """Newton's step of each row, NaN where there is none; `is_done`: no step can improve it."""
    singular, allowed, steepest = rounding
    for k in range(len(s)):
        product, finite, small = 1.0, True, True
        for j in range(periods[k]):
            product = product * s[k, j]
            finite = finite and math.isfinite(s[k, j])
            small = small and abs(b[k, j]) <= allowed * (1 + min(abs(s[k, j]), steepest))
        is_done[k] = small and finite
        y[k, : periods[k]] = math.nan
        if finite and not abs(product - 1) <= singular:
            cyclic_row(s[k, : periods[k]], b[k, : periods[k]], y[k, : periods[k]])
