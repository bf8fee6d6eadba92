"""Steady motions of a block shaken by a cos(frequency t) against friction of size 1.

Derivation: docs/studies/den_hartog1931.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from stickslip.numerics.arrays import Floats

SAMPLES: Final = 2001
XTOL: Final = 1e-15


def response(frequency: float) -> float:
    """Amplitude over forcing without friction, with its sign."""
    return 1.0 / (1.0 - frequency**2)


def damping(frequency: float) -> float:
    """Return what friction takes: sin(T) / (frequency (1 + cos(T))), T half a period."""
    return math.tan(0.5 * math.pi / frequency) / frequency


def amplitude(frequency: float, forcing: float) -> float:
    """Amplitude of the motion without stops; NaN where there is none."""
    square = (forcing * response(frequency)) ** 2 - damping(frequency) ** 2
    if square < 0.0 or forcing < stop_boundary(frequency):
        return math.nan
    return math.sqrt(square)


def one_harmonic(frequency: float, forcing: float) -> float:
    """Amplitude by balance of one harmonic, of friction 4 / pi; NaN where there is none."""
    square = forcing**2 - (4.0 / math.pi) ** 2
    return math.sqrt(square) * abs(response(frequency)) if square > 0.0 else math.nan


def stop_boundary(frequency: float) -> float:
    """Smallest forcing whose motion never stops."""
    return math.hypot(damping(frequency), _least_amplitude(frequency)) / abs(response(frequency))


def _least_amplitude(frequency: float) -> float:
    """Amplitude below which the velocity would change its sign within half a period."""
    u = damping(frequency)

    def needed(t: float) -> float:
        turn = frequency * u * (math.cos(frequency * t) - math.cos(t))
        return (math.sin(t) + turn) / (frequency * math.sin(frequency * t))

    times = np.linspace(0.0, math.pi / frequency, SAMPLES)[1:-1]
    best = int(np.argmax([needed(t) for t in times.tolist()]))
    at_turn = 1.0 / frequency**2  # the limit at both ends, where the block turns
    if best in (0, times.size - 1):
        return at_turn
    ends = (float(times[best - 1]), float(times[best + 1]))
    found = minimize_scalar(lambda t: -needed(t), bounds=ends, options={"xatol": 1e-10})
    return max(at_turn, -float(found.fun))


def one_stop_amplitude(frequency: float, forcing: float) -> float:
    """Amplitude of the motion with one stop in each half period: at rest at -X, then at +X."""

    def excess(x: float) -> float:
        return _first_stop(frequency, forcing, x) - x

    sizes = np.linspace(0.0, forcing + 1.0, 102)[1:-1]
    return _first_root(excess, sizes)


def _first_stop(frequency: float, forcing: float, x: float) -> float:
    """Where a block stops that left rest at -x as the forcing on it reached the limit."""
    phase = -math.acos((1.0 - x) / forcing)
    start = phase / frequency
    swing = forcing * response(frequency)
    a = 1.0 - x - swing * math.cos(phase)
    b = frequency * swing * math.sin(phase)

    def velocity(t: float) -> float:
        free = -a * math.sin(t - start) + b * math.cos(t - start)
        return free - frequency * swing * math.sin(frequency * t)

    times = start + np.linspace(0.01, 1.0, SAMPLES) * 2.0 * math.pi / frequency
    t = _first_root(velocity, times)
    free = a * math.cos(t - start) + b * math.sin(t - start)
    return -1.0 + swing * math.cos(frequency * t) + free


def _first_root(func: Callable[[float], float], points: Floats) -> float:
    """First root between neighbouring points, or NaN."""
    values = np.array([func(point) for point in points.tolist()])
    (changes,) = np.nonzero(values[1:] * values[:-1] < 0.0)
    if not changes.size:
        return math.nan
    k = int(changes[0])
    return float(brentq(func, points[k], points[k + 1], xtol=XTOL))
