"""Zeros of functions of one number and of their slopes, and where something ceases to hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeVar

import numpy as np

from stickslip.numerics.arrays import EPS, Floats

Places = TypeVar("Places", float, Floats)

MAX_STEPS: Final = 60  # even bisection alone is done by then ...
WIDTH: Final = 4 * EPS  # of the place: a bracket so narrow is closed
MAX_ROUNDS: Final = 80  # ... from wide brackets beside 0, too
ASIDE: Final = 1e-2  # of the bracket: first guess of how far the chord's zero may be off
BEYOND: Final = 64.0  # times as far: points that tell more than rounding
SPREAD: Final = 0.25  # of the bracket: three points so far apart quarter it


def zero_between(g: Callable[[float], float], a: float, b: float, g_a: float, g_b: float) -> float:
    """Find a zero of a continuous function between two points where its signs differ.

    Chandrupatla's method, Advances in Engineering Software 28, 145 (1997). Of the last bracket, the
    end with the smaller value.
    """
    if g_a == 0:
        return a
    if g_b == 0:
        return b
    c, g_c, share = a, g_a, 0.5
    for _ in range(MAX_STEPS):
        x = a + share * (b - a)
        value = g(x)
        if np.sign(value) == np.sign(g_a):
            c, g_c, a, g_a = a, g_a, x, value
        else:
            c, b, a, g_c, g_b, g_a = b, a, x, g_b, g_a, value
        best = a if abs(g_a) < abs(g_b) else b
        width = WIDTH * max(abs(a), abs(b), 1e-3) / abs(b - a) if b != a else 1.0
        if g_a == 0 or width >= 0.5:
            break
        share = min(max(_share(a, b, c, g_a, g_b, g_c), width), 1 - width)
    return best


def _share(a: float, b: float, c: float, g_a: float, g_b: float, g_c: float) -> float:
    """Place of the next trial between a and b."""
    x, y = (a - b) / (c - b), (g_a - g_b) / (g_c - g_b) if g_c != g_b else 0.0
    if not (y * y < x and (1 - y) ** 2 < 1 - x):
        return 0.5
    first = g_a / (g_b - g_a) * g_c / (g_b - g_c)
    second = (c - a) / (b - a) * g_a / (g_c - g_a) * g_b / (g_c - g_b)
    return first + second


def halved(
    holds: Callable[[Places], Any], inside: Places, outside: Places, times: int
) -> tuple[Places, Places]:
    """Close in on where something ceases to hold: the last places where it does, and does not."""
    for _ in range(times):
        middle = 0.5 * (inside + outside)
        kept = holds(middle)
        if isinstance(middle, np.ndarray):
            inside, outside = np.where(kept, middle, inside), np.where(kept, outside, middle)
        elif kept:
            inside = middle
        else:
            outside = middle
    return inside, outside


def middle_zero(g: Callable[[float], float], a: float, b: float) -> float:
    """Find where a function changes its sign, also if it is 0 around there, as to rounding."""
    from scipy.optimize import brentq  # not for the first value

    zero = float(brentq(g, a, b, xtol=1e-300, rtol=1e-15))
    step, g_low, g_high = float(np.spacing(max(abs(a), abs(b)))), g(zero), 0.0
    if g_low != 0.0:
        return zero
    while g_low == 0.0 or g_high == 0.0:  # the chord of points well beyond
        step *= BEYOND
        low, high = max(a, zero - step), min(b, zero + step)
        g_low, g_high = g(low), g(high)
    return low - g_low * (high - low) / (g_high - g_low)


def slope_zeros(slope: Callable[[Floats], Floats], ends: Floats, slopes: Floats) -> Floats:
    """Close in on one change of sign in each bracket; of adjacent floats, the smaller slope."""
    # Three points at once, the chord's zero and one on either side of it, make a bracket as narrow
    # as their distance. The chord's error is quadratic in the width, so the distance is squared
    # each time: from a cell of a table three or four calls suffice. Where the zero is not between
    # the outer points, the next three quarter the bracket.
    outer, ends, at = ends, ends.copy(), slopes.copy()
    rising = (at[0] < 0) | (at[1] > 0)
    aside = np.full(rising.shape, ASIDE)
    for _ in range(MAX_ROUNDS):
        width = ends[1] - ends[0]
        todo = np.flatnonzero(width > 2 * np.spacing(np.abs(ends).max(axis=0)))
        if not todo.size:
            break
        x = _trials(ends[:, todo], at[:, todo], aside[todo])
        _narrow(ends, at, todo, x, slope(x.ravel()).reshape(x.shape), rising)
        share = (ends[1] - ends[0])[todo] / width[todo]
        missed = share > 2 * np.minimum(aside[todo], SPREAD)
        aside[todo] = np.where(missed, 2 * SPREAD, np.minimum(aside[todo], ASIDE) ** 2)
    size = np.where(ends == outer, np.inf, np.abs(at))
    return np.where(size[0] <= size[1], ends[0], ends[1])


def _trials(ends: Floats, at: Floats, aside: Floats) -> Floats:
    """Three points in each bracket, shape (3, n)."""
    lower, upper = ends
    width = upper - lower
    with np.errstate(all="ignore"):
        centre = lower - at[0] * width / (at[1] - at[0])
    known = np.isfinite(centre) & (aside < SPREAD)
    centre = np.where(known, centre, 0.5 * (lower + upper))
    ulp = np.spacing(np.maximum(np.abs(lower), np.abs(upper)))
    reach = np.maximum(np.where(known, aside, SPREAD) * width, ulp)
    x = centre + reach * np.array([[-1.0], [0.0], [1.0]])
    return np.clip(x, np.nextafter(lower, upper), np.nextafter(upper, lower))


def _narrow(
    ends: Floats, at: Floats, k: np.ndarray, x: Floats, slopes: Floats, rising: np.ndarray
) -> None:
    """Move the ends of brackets to the points that lie on their sides of the zero."""
    for point, value in zip(x, slopes, strict=True):
        inside = (point > ends[0, k]) & (point < ends[1, k])
        side = np.where((value < 0) == rising[k], 0, 1)
        i, j = side[inside], k[inside]
        ends[i, j], at[i, j] = point[inside], value[inside]
