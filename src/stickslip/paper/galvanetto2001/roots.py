"""Bracketing solvers for the parameters that the paper prints.

Each is the root of one scalar condition inside a bracket that the caller states. A condition is
evaluated for many parameters, so what it needs of each map is solved for directly, rather than
picked from complete lists as for the figures.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.study.event_map import EventMap

__all__ = ["Root", "cusp", "fixed_point", "jump", "root"]

ACCURACY = {"exact": 1e-14, "adaptive": 1e-13}
"""Error of one map value by engine (docs/design.md, section 3), for well-conditioned motions."""


@dataclass(frozen=True)
class Root:
    """A root and an estimate of its absolute error."""

    value: float
    error: float


def root(g: Callable[[float], float], low: float, high: float, *, noise: float = 1e-14) -> Root:
    """Root of a scalar function whose sign changes between two points.

    Parameters
    ----------
    g : callable
        Continuous in the bracket.
    low, high : float
        Ends of the bracket.
    noise : float
        Error of a value of `g`.

    Returns
    -------
    Root
        The error is that of g divided by the secant slope over 1e-4 of the bracket,
        and at least two ulp.

    Raises
    ------
    ValueError
        The signs at the ends do not differ.
    """
    value = float(brentq(g, low, high, xtol=1e-300, rtol=4 * np.finfo(float).eps))
    step = 1e-4 * (high - low)
    slope = abs(g(min(value + step, high)) - g(max(value - step, low))) / (2.0 * step)
    error = (abs(g(value)) + noise) / slope if slope > 0.0 else np.inf
    return Root(value, float(max(error, 2.0 * np.spacing(abs(value)))))


def fixed_point(f: Any, low: float, high: float, *, noise: float = 1e-14) -> Root:
    """Root of f(d) - d inside one branch.

    Parameters
    ----------
    f : EventMap or power of one
        With ``evaluate``.
    low, high : float
        Ends of the bracket.
    noise : float
        Error of a value of `f`.

    Returns
    -------
    Root
        With the error that follows from the multiplier: noise / abs(1 - multiplier).
    """
    found = root(lambda d: _value(f, d) - d, low, high, noise=noise)
    gap = abs(1.0 - float(f.evaluate(found.value).derivative))
    residual = abs(_value(f, found.value) - found.value)
    return Root(found.value, max((noise + residual) / gap, 2.0 * float(np.spacing(found.value))))


@lru_cache(maxsize=32)  # several conditions on one map start from its cusp
def cusp(f: EventMap, window: tuple[float, float], points: int = 101) -> tuple[float, float]:
    """Adjacent floats around the first maximum of a map at a corner.

    Parameters
    ----------
    f : EventMap
        Rises to the corner and falls behind it.
    window : pair of float
        Where to look.
    points : int
        Size of the first sample of slopes.

    Returns
    -------
    tuple of float
        Last d with a positive and first with a negative slope.

    Raises
    ------
    ValueError
        The slope never changes from positive to negative.
    """
    d = np.linspace(*window, points)
    slope = f.derivative(d)
    (peaks,) = np.nonzero((slope[:-1] > 0.0) & (slope[1:] < 0.0))
    if peaks.size == 0:
        raise ValueError(f"no corner of f in {window}")
    low, high = d[peaks[0]], d[peaks[0] + 1]
    return _change(lambda x: bool(f.derivative(x) > 0.0), low, high)


def jump(f: EventMap, low: float, high: float) -> tuple[float, float]:
    """Adjacent floats between which the itinerary changes.

    Parameters
    ----------
    f : EventMap
        With one change of itinerary between `low` and `high`.
    low, high : float
        Ends of the bracket.

    Returns
    -------
    tuple of float
        Last d with the itinerary of `low`, and the next float.
    """
    label = f.evaluate(low).label
    return _change(lambda x: bool(f.evaluate(x).label == label), low, high)


def _change(is_left: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """Bisect to the adjacent floats between which a property that holds at `low` is lost."""
    low, high = float(low), float(high)
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if is_left(middle) else (low, middle)
    return low, high


def _value(f: Any, d: float) -> float:
    return float(f.evaluate(d).value)
