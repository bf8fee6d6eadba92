"""What rounding leaves out: sums and products with their errors, exact (Knuth, Dekker).

These hold where each operation is rounded as written, so not inside fused kernels.
"""

from __future__ import annotations

from stickslip.numerics.targets import kernel

SPLITTER = 2.0**27 + 1.0


@kernel(inline=True)
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return (s, r): ``a + b = s + r`` exactly, s the rounded sum."""
    s = a + b
    part = s - a
    return s, (a - (s - part)) + (b - part)


@kernel(inline=True)
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return (p, r): ``a b = p + r`` exactly, p the rounded product."""
    p = a * b
    shifted = SPLITTER * a
    a_high = shifted - (shifted - a)
    a_low = a - a_high
    shifted = SPLITTER * b
    b_high = shifted - (shifted - b)
    b_low = b - b_high
    return p, ((a_high * b_high - p) + a_high * b_low + a_low * b_high) + a_low * b_low
