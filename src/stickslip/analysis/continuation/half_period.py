"""Where an orbit of even period merges with one of half its period, which flips there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import Floats, turned_near
from stickslip.analysis.scales import DIFFERENCE, FINE
from stickslip.numerics.arrays import EPS

if TYPE_CHECKING:
    from collections.abc import Callable

    # Solve for an orbit near a guess at a value: points, and det(M + 1), NaN if there is none.
    Solve: TypeAlias = Callable[[float, Floats], tuple[Floats, float]]

MAX_SECANT: Final = 30
ROUNDING: Final = 4 * EPS  # of the size of the parameter: a last step


def shrinks_to_half(f: Any, before: Floats, after: Floats) -> bool:
    """Tell whether an orbit passed through one of half its period: its halves changed places."""
    half, odd = divmod(len(before), 2)
    if odd:
        return False
    one, other = np.split(before, 2)
    turned = turned_near(f, other, one) - other
    first, second = np.split(after, 2)
    moved = (one - other - turned) * (first - second - turned)
    return bool((moved.reshape(half, -1).sum(axis=1) < 0).all())


def flip_of_half(
    solve: Solve, half: Floats, value: float, low: float, high: float
) -> tuple[float, Floats] | None:
    """Find the flip near a guess, and the orbit that flips there."""
    aside = DIFFERENCE * (high - low)
    old = value + aside if value + aside <= high else value - aside
    half, g_old = solve(old, half)
    half, g = solve(value, half)
    last = np.inf
    for _ in range(MAX_SECANT):
        step = -g * (value - old) / (g - g_old) if g != g_old else 0.0
        if not np.isfinite(step):
            return None
        smallest = ROUNDING * max(abs(value), high - low)
        if abs(step) <= smallest or (abs(g) < FINE and abs(step) >= 0.5 * last):
            break
        old, g_old, last = value, g, abs(step)
        value = min(max(value + step, low), high)
        half, g = solve(value, half)
    return (value, half) if abs(g) < FINE else None
