"""Samples of motions that seem chaotic: where they start, how long they run, what they average."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.attractors.lyapunov import LyapunovExponent, advance, blocking_error, trace
from stickslip.analysis.maps.protocol import domain_width

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats, Map1D

ENSEMBLE: Final = 32  # orbits from which a chaotic motion is sampled together
SAMPLES: Final = 1 << 15  # slopes averaged for an exponent, at first and ...
MAX_SAMPLES: Final = 1 << 20  # ... at most
GROWTH: Final = 4  # factor from one sample to the next, until the exponent's sign is clear
CLEAR: Final = 10  # error bars by which it is then away from zero
SHORT: Final = 1e-10  # of the domain's width: intervals to grow are longer than this


class ChaoticMotion:
    """Independent orbits that start all over a trapping region, long enough to forget that."""

    def __init__(self, f: Map1D, bands: Floats) -> None:
        steps, x = SAMPLES // ENSEMBLE, _spread_over(bands, ENSEMBLE)
        x = advance(f, x, steps)[:, -1]
        while True:
            self.values, self.slopes = trace(f, x, steps)
            x, steps, self.reason = self.values[:, -1], GROWTH * steps, ""
            if not np.all(np.isfinite(self.values)):
                self.reason = "part of the bands is lost: the map has a hole there"
                break
            self.exponent = mean_of_logs(self.slopes)
            value, error = self.exponent
            if abs(value) > CLEAR * error or steps * ENSEMBLE > MAX_SAMPLES:
                break


def _spread_over(bands: Floats, n: int) -> Floats:
    """One random point in each of n equal parts of a union of intervals."""
    lengths = bands[:, 1] - bands[:, 0]
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    at = starts[-1] * (np.arange(n) + np.random.default_rng(0).random(n)) / n
    k = np.clip(np.searchsorted(starts, at, side="right") - 1, 0, len(bands) - 1)
    return np.asarray(np.minimum(bands[k, 0] + at - starts[k], bands[k, 1]))


def short_interval(f: Map1D, points: Floats) -> tuple[float, float]:
    """Two neighbours among the points: so short that no gap between bands is inside."""
    points = np.unique(points)
    gaps = np.diff(points)
    short = np.where(gaps > SHORT * domain_width(f), gaps, np.inf)
    if not np.isfinite(short).any():
        return float(points[0]), float(points[0] + SHORT * domain_width(f))
    k = int(np.argsort(short)[np.isfinite(short).sum() // 10])
    return float(points[k]), float(points[k + 1])


def mean_of_logs(slopes: Floats) -> LyapunovExponent:
    """Mean over orbits (m, n); the error is the larger of two estimates.

    Blocking sees correlations along orbits, the spread of orbits' means those that last longer.
    """
    with np.errstate(divide="ignore"):
        logs = np.log(np.maximum(np.abs(slopes), 1e-300))
    error = blocking_error(logs.ravel())
    if len(logs) > 1:
        error = max(error, float(np.std(logs.mean(axis=1), ddof=1) / np.sqrt(len(logs))))
    return LyapunovExponent(float(logs.mean()), error, logs.size)
