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


@kernel(inline=True)
def sum_of_two(a: float, b: float, low: float) -> tuple[float, float]:
    """Add two numbers and a small one: the rounded sum, and the rest."""
    s, rest = two_sum(a, b)
    return two_sum(s, rest + low)


@kernel(inline=True)
def product(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    """Multiply two sums of two."""
    p, low = two_product(a, b)
    return p, low + (a * b_low + a_low * b)


@kernel(inline=True)
def quotient(a: float, a_low: float, b: float, b_low: float) -> tuple[float, float]:
    """Divide a sum of two by another."""
    q = a / b
    p, low = two_product(q, b)
    return q, ((a - p) - low + a_low - q * b_low) / b
