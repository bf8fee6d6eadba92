"""Where an orbit of even period merges with one of half its period, which flips there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.orbits.newton import EPS, solve_orbit

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.analysis.maps.protocol import Floats, Map1D, MapFamily

MAX_SECANT: Final = 30
FIRST_CHANGE: Final = 1e-5  # of the parameter's range: for the first secant
ROUNDING: Final = 4 * EPS
NOISE: Final = 1e-9  # of multiplier + 1: steps that do not shrink below it are rounding


def shrinks_to_half(before: Floats, after: Floats) -> bool:
    """Tell whether an orbit passed through one of half its period: its halves changed places."""
    p = len(before)
    if p % 2:
        return False
    first, second = before[: p // 2] - before[p // 2 :], after[: p // 2] - after[p // 2 :]
    return bool((first * second < 0).all())


def flip_of_half(
    at: Callable[[float], MapFamily], points: Floats, value: float, low: float, high: float
) -> tuple[float, Floats] | None:
    """Find the flip to which an orbit of even period shrinks: the value, and half the orbit."""
    half = 0.5 * (points[: len(points) // 2] + points[len(points) // 2 :])
    aside = FIRST_CHANGE * (high - low)
    old = value + aside if value + aside <= high else value - aside
    half, g_old = _off_flip(at(old), half)
    half, g = _off_flip(at(value), half)
    last = np.inf
    for _ in range(MAX_SECANT):
        step = -g * (value - old) / (g - g_old) if g != g_old else 0.0
        if not np.isfinite(step):
            return None
        smallest = ROUNDING * max(abs(value), high - low)
        if abs(step) <= smallest or (abs(g) < NOISE and abs(step) >= 0.5 * last):
            break
        old, g_old, last = value, g, abs(step)
        value = min(max(value + step, low), high)
        half, g = _off_flip(at(value), half)
    return (value, half) if abs(g) < NOISE else None


def _off_flip(f: Map1D, guess: Floats) -> tuple[Floats, float]:
    """Solve for an orbit, points in the order of the guess; how far its multiplier is from -1."""
    orbit = solve_orbit(f, guess)
    if orbit.quality != "located":
        return guess, np.nan
    shift = int(np.argmin(np.abs(orbit.points - guess[0])))
    return np.roll(orbit.points, -shift), orbit.multiplier + 1.0
