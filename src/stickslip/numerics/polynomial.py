"""First contact of a polynomial with zero, proved from its coefficients."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.roots import EPSILON, contact_time, leaving_step, safe_step
from stickslip.numerics.rounding import two_product, two_sum
from stickslip.numerics.targets import kernel

Floats = NDArray[np.float64]

# No contact on the interval, and a search that did not end (never seen).
NO_ROOT, UNFINISHED = -1.0, -2.0
MAX_SEARCH = 10_000
# Of an interval: no step that follows a slope is shorter.
SHORTEST = 1e-3


@kernel(inline=True)
def value(c: Floats, t: float) -> float:
    """Sum of ``c[k] t^k``."""
    total = 0.0
    for k in range(c.shape[0] - 1, -1, -1):
        total = total * t + c[k]
    return total


@kernel(inline=True)
def value_sharp(c: Floats, low: Floats, t: float) -> tuple[float, float]:
    """Sum of ``c[k] t^k`` as a sum of two; `low`: what the first coefficients leave out."""
    n = low.shape[0]
    total = 0.0
    for k in range(c.shape[0] - 1, n - 1, -1):
        total = total * t + c[k]
    rest = 0.0
    for k in range(n - 1, -1, -1):
        total, product_low = two_product(total, t)
        total, sum_low = two_sum(c[k], total)
        rest = rest * t + (product_low + sum_low + low[k])
    return two_sum(total, rest)


@kernel(inline=True)
def jet(c: Floats, t: float) -> tuple[float, float, float]:
    """Value, slope and second derivative at `t`.

    With u = t^2 the polynomial is E(u) + t O(u): two recurrences, half as long, that need not
    wait for each other.
    """
    u = t * t
    n = c.shape[0]
    even = c[n - 1] if n % 2 == 1 else 0.0
    even_1 = even_2 = odd = odd_1 = odd_2 = 0.0
    for k in range(n // 2 - 1, -1, -1):
        even_2 = even_2 * u + even_1
        even_1 = even_1 * u + even
        even = even * u + c[2 * k]
        odd_2 = odd_2 * u + odd_1
        odd_1 = odd_1 * u + odd
        odd = odd * u + c[2 * k + 1]
    slope = odd + 2.0 * (t * even_1 + u * odd_1)
    curvature = 2.0 * even_1 + 6.0 * t * odd_1 + 8.0 * u * (even_2 + t * odd_2)
    return even + t * odd, slope, curvature


@kernel(inline=True)
def tail(c: Floats, h: float) -> float:
    """Bound of the terms of degree 3 and more on [0, h]."""
    total = 0.0
    for k in range(c.shape[0] - 1, 2, -1):
        total = total * h + abs(c[k])
    return total * h * h * h


@kernel(inline=True)
def derivative_bounds(c: Floats, h: float) -> tuple[float, float]:
    """Bounds of the second and third derivative on [0, h]; recurrences in h^2, as in `jet`.

    There are at least four coefficients.
    """
    u = h * h
    n = c.shape[0]
    even_2 = even_3 = odd_2 = odd_3 = 0.0
    if n % 2 == 1:
        even_2 = (n - 1.0) * (n - 2.0) * abs(c[n - 1])
        even_3 = (n - 3.0) * even_2
    for j in range(n // 2 - 1, 1, -1):
        k = 2.0 * j
        even = k * (k - 1.0) * abs(c[2 * j])
        odd = k * (k + 1.0) * abs(c[2 * j + 1])
        even_2 = even_2 * u + even
        even_3 = even_3 * u + (k - 2.0) * even
        odd_2 = odd_2 * u + odd
        odd_3 = odd_3 * u + (k - 1.0) * odd
    odd = 6.0 * abs(c[3])
    bound_2 = even_2 * u + 2.0 * abs(c[2]) + h * (odd_2 * u + odd)
    return bound_2, odd_3 * u + odd + h * even_3


@kernel(inline=True)
def signal_rounding(start: float, size: float, slack: float) -> float:
    """How near zero counts as zero; `size`: of all terms but the first, `start`, in sum."""
    return slack + 2.0 * EPSILON * (abs(start) + size)


@kernel(inline=True)
def first_contact(c: Floats, h: float, leaving: bool, slack: float) -> float:
    """First t in (0, h] at which a signal that is positive before reaches zero, or NO_ROOT.

    `leaving`: the signal starts at zero; that root is divided out. `slack`: how near zero counts as
    zero (rounding of the coefficients).
    """
    higher = tail(c, h)
    rounding = signal_rounding(c[0], abs(c[1]) * h + abs(c[2]) * h * h + higher, slack)
    if leaving:
        if c[1] >= 0.0 and c[2] >= 0.0 and c[1] * h + c[2] * h * h > higher:
            return NO_ROOT
    elif c[0] + min(0.0, c[1] * h) + min(0.0, c[2] * h * h) - higher > rounding:
        return NO_ROOT
    return search(c, h, leaving, rounding)


@kernel
def search(c: Floats, h: float, leaving: bool, rounding: float) -> float:
    """Follow a polynomial from 0 to `h` by steps that provably skip no contact."""
    bound_2, bound_3 = derivative_bounds(c, h)
    t, g, slope, curvature = 0.0, c[0], c[1], 2.0 * c[2]
    if leaving:
        if slope < 0.0 or (slope == 0.0 and curvature <= 0.0):
            return 0.0
        if h == 0.0:
            return NO_ROOT
        t = leaving_step(slope, curvature, bound_3, h)
    for _ in range(MAX_SEARCH):
        if t > 0.0:
            g, slope, curvature = jet(c, t)
        if (g <= rounding and slope <= 0.0) or is_near(g, slope, curvature, bound_3, rounding):
            contact = max(contact_time(t, g, slope, curvature, rounding), 0.0)
            if contact > h + 2.0 * EPSILON * h:  # beyond: the next step's
                return NO_ROOT
            return min(contact, h)
        if t >= h:
            return NO_ROOT
        step = safe_step(max(g, 0.0), slope, curvature, bound_2, bound_3, h - t)
        if slope >= 0.0 and bound_3 > 0.0:  # it rises until its curvature may vanish
            step = max(step, 3.0 * curvature / bound_3)
        t = min(h, t + max(step, EPSILON * h))
    return UNFINISHED


@kernel(inline=True)
def is_near(g: float, slope: float, curvature: float, bound_3: float, rounding: float) -> bool:
    """Whether a contact just ahead is that of the parabola, to a hundredth of `rounding`.

    The parabola crosses zero with at least half of the slope here, so at most 4/3 as far ahead as
    the tangent; up to there the cubic term is at most a hundredth of `rounding`.
    """
    if not slope < 0.0 or 8.0 * g * curvature > 3.0 * slope * slope:
        return False
    ahead = -1.3333333333333335 * g / slope
    return bound_3 * ahead * ahead * ahead <= 0.06 * rounding


@kernel
def lowest_minimum(c: Floats, h: float) -> float:
    """Time of the lowest minimum inside (0, h), or NO_ROOT.

    The slope is followed by steps that provably skip no change of its sign, unless two lie
    within `SHORTEST` h: such a minimum is no lower than the ends of a step, to 1e-9.
    """
    _, bound = derivative_bounds(c, h)
    lowest, found = math.inf, NO_ROOT
    t, slope, curvature = 0.0, c[1], 2.0 * c[2]
    falls, low = slope < 0.0, 0.0
    while t < h:
        side = 1.0 if slope > 0.0 or (slope == 0.0 and curvature > 0.0) else -1.0
        step = safe_step(side * slope, side * curvature, 0.0, bound, math.inf, h - t)
        if step >= h - t and slope != 0.0:
            break  # its sign is that of the rest
        t = min(h, t + max(step, SHORTEST * h))
        _, slope, curvature = jet(c, t)
        if slope > 0.0 and falls:
            at = minimum_between(c, low, t)
            if value(c, at) < lowest:
                lowest, found = value(c, at), at
        if slope != 0.0:
            falls, low = slope < 0.0, t
    return found


@kernel
def minimum_between(c: Floats, low: float, high: float) -> float:
    """Time of a minimum between a falling and a rising point, by Newton's method or halving."""
    width = high - low
    t = 0.5 * (low + high)
    for _ in range(60):
        _, slope, curvature = jet(c, t)
        if slope < 0.0:
            low = t
        else:
            high = t
        if curvature > 0.0 and abs(slope) <= 1e-13 * curvature * width:
            break
        t = t - slope / curvature if curvature > 0.0 else math.nan
        if not low < t < high:
            t = 0.5 * (low + high)
    return t
