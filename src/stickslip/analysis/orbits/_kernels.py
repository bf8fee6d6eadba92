"""The linear equations of Newton's method for periodic orbits, compiled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats


@kernel
def cyclic_rows(s: Floats, b: Floats, y: Floats) -> None:
    """Solve s_i y_i - y_(i+1) = b_i, cyclic in each row; never divide by what should be large."""
    rows, columns = s.shape
    for k in range(rows):
        product, now = 1.0, 0.0
        for j in range(columns):
            product = product * s[k, j]
        if abs(product) <= 1:
            # Start where going round once leads back.
            for j in range(columns):
                now = s[k, j] * now - b[k, j]
            now = now / (1 - product)
            for j in range(columns):
                y[k, j] = now
                now = s[k, j] * now - b[k, j]
        else:
            for j in range(columns - 1, -1, -1):
                now = (now + b[k, j]) / s[k, j]
            now = now / (1 - 1 / product)
            for j in range(columns - 1, -1, -1):
                now = (now + b[k, j]) / s[k, j]
                y[k, j] = now
