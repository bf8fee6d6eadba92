"""Where an orbit of even period merges with one of half its period, which flips there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.protocol import sample
from stickslip.analysis.shooting import EPS, solve_orbit

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.analysis.protocol import Floats, Map1D, MapFamily

__all__ = ["flip_of_half", "shrinks_to_half"]

MAX_SECANT: Final = 30
FIRST_CHANGE: Final = 1e-5  # of the parameter's range: for the first secant
ROUNDING: Final = 4 * EPS


def shrinks_to_half(before: Floats, after: Floats) -> bool:
    """Tell whether an orbit has passed through one of half its period.

    Parameters
    ----------
    before, after : ndarray of float, shape (p,)
        Neighbours along a branch: behind the merger the halves of the orbit have changed
        places.
    """
    p = len(before)
    if p % 2:
        return False
    first, second = before[: p // 2] - before[p // 2 :], after[: p // 2] - after[p // 2 :]
    return bool((first * second < 0).all())


def flip_of_half(
    at: Callable[[float], MapFamily], points: Floats, value: float, low: float, high: float
) -> tuple[float, Floats] | None:
    """Find the flip that an orbit of even period shrinks to.

    Parameters
    ----------
    at : callable
        The map at a value of the parameter.
    points : ndarray of float, shape (p,)
        The orbit close to it.
    value : float
        Of the parameter there.
    low, high : float
        Range of the parameter.

    Returns
    -------
    value : float
    points : ndarray of float, shape (p // 2,)
        The orbit of half the period, in the order of ``points``; None if there is none.
    """
    half = 0.5 * (points[: len(points) // 2] + points[len(points) // 2 :])

    def distance(q: float, guess: Floats) -> tuple[float, Floats]:
        found, slopes = _solved(at(q), guess)
        return float(slopes.prod()) + 1.0, found

    aside = FIRST_CHANGE * (high - low)
    old = value + aside if value + aside <= high else value - aside
    g_old, half = distance(old, half)
    g, half = distance(value, half)
    last = np.inf
    for _ in range(MAX_SECANT):
        if g == g_old or not np.isfinite(g):
            break
        step = -g * (value - old) / (g - g_old)
        if abs(step) <= ROUNDING * max(abs(value), high - low) or (
            abs(g) < 1e-9 and abs(step) >= 0.5 * last
        ):
            return value, half
        old, g_old, last = value, g, abs(step)
        value = min(max(value + step, low), high)
        g, half = distance(value, half)
    return (value, half) if abs(g) < 1e-9 else None


def _solved(f: Map1D, guess: Floats) -> tuple[Floats, Floats]:
    """Solve for an orbit, points in the order of the guess, and its slopes."""
    orbit = solve_orbit(f, guess)
    if orbit.quality != "located":
        return guess, np.full(len(guess), np.nan)
    shift = int(np.argmin(np.abs(orbit.points - guess[0])))
    points = np.roll(orbit.points, -shift)
    return points, sample(f, points).derivative
