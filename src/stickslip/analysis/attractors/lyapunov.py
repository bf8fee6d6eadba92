"""Lyapunov exponents: on the line time averages of log |f'| with an error bar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.branches.discontinuities import TOGETHER
from stickslip.analysis.branches.table import LOCATED
from stickslip.analysis.exponents.blocking import blocking_error, settled_period
from stickslip.analysis.exponents.spectrum import checked_steps_of_mean, largest_exponents
from stickslip.analysis.interpolation.interpolated import PROBES, stand_in
from stickslip.analysis.maps.arguments import line_map, map_of
from stickslip.analysis.maps.derived import plain
from stickslip.analysis.maps.protocol import (
    SAME,
    MapND,
    advance,
    checked_points,
    clip_to_domain,
    domain_width,
    sample,
    values_and_slopes,
)
from stickslip.analysis.maps.rotation import OrbitMean
from stickslip.analysis.orbits.newton import polish_on
from stickslip.analysis.scales import FEW, ORBIT_NOISE, RECOGNISED
from stickslip.numerics.waiting import waits
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Bools, Floats, Map1D, Modelled

SETTLING: Final = 512  # steps in which orbits come to where they stay, or leave what repels
MANY: Final = 50_000  # steps from which on an interpolation of the map pays
SAMPLES: Final = 1 << 15  # slopes evaluated together, averaged for an exponent, and searched for
# cycles, from all orbits at first, from each at last
GROWTH: Final = 4  # factor from one look at an orbit to the next, until it is clear
SIGMAS: Final = 5  # error bars by which the exponent of chaos must exceed zero
CLEAR: Final = 2 * SIGMAS  # ... and by which it is then away from zero
TENTHS: Final = np.array([1, 2, 4, 6])  # of the longer ones that are shorter yet


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovExponent(OrbitMean):
    """Mean of ``log |f'|`` along orbits, per step; in R^n of the most growing direction's.

    Attributes
    ----------
    value : float or ndarray
        The exponent; shaped like the starting points. NaN where the orbit left the map's
        domain or fell into a gap, ``-inf`` where it met a turning point exactly.
    error : float or ndarray
        Standard error of `value` (one standard deviation), correlations included.
    n : int
        Steps that were averaged.
    """

    value: Any
    error: Any
    n: int

    def __iter__(self) -> Iterator[Any]:
        """Unpack as ``value, error``."""
        return iter((self.value, self.error))

    def __repr__(self) -> str:
        """Value ± error, one row per starting point."""
        if np.ndim(self.value) == 0:
            return f"LyapunovExponent({self.value:.10g} ± {self.error:.2g}, n={self.n})"
        pairs = zip(self.value.flat, self.error.flat, strict=True)
        rows = [f"  {value: .10f} ± {error:.2g}" for value, error in pairs]
        return "\n".join([f"LyapunovExponent, n={self.n}", *rows])


@waits
@suggests
def lyapunov_exponent(
    f: Map1D | MapND | Modelled[Map1D] | Modelled[MapND],
    d: ArrayLike,
    n: int = 100_000,
    *,
    transient: int | None = None,
) -> LyapunovExponent:
    """Estimate the Lyapunov exponent, of a map of R^n the largest, of the orbits from `d`.

    Parameters
    ----------
    f : map or model
    d : array_like of float
        Starting points inside the domain; one exponent each. In R^n the last axis of the array
        holds a point.
    n : int
        Steps to average, after the transient.
    transient : int, optional
        Steps to drop first. By default a tenth of `n`, at least 1000.

    Returns
    -------
    LyapunovExponent
        Shaped like `d`.

    Raises
    ------
    ValueError
        `n` is below 2, `transient` negative, or a starting point outside the domain.

    Notes
    -----
    An orbit that has settled on a cycle is averaged over whole periods. For the others the error
    is a standard deviation found by blocking; it holds if the `n` steps see every part of the
    attractor, which no finite orbit can prove.

    From 50 000 steps on orbits are followed on the map's table of branches, interpolated to 1e-9 of
    the range of values; a cycle is solved for on the map itself, and the error of another orbit
    includes the difference of both maps' slopes along it (docs/theory/attractors.md).

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 4.0})
    >>> round(ss.lyapunov_exponent(f, 0.3).value, 2)  # log 2
    0.69
    """
    n, skip = checked_steps_of_mean(n, transient)
    found = map_of(f)
    if isinstance(found, MapND):
        mean, error = largest_exponents(found, d, n, skip)
        return LyapunovExponent(plain(mean), plain(error), n)
    f = line_map(found)
    start = checked_points(f.domain, d, "d")
    fast = stand_in(f) if start.size * (skip + n) >= MANY else f
    values, slopes = trace(fast, start.ravel(), n, skip)
    if fast is not f and not np.isfinite(values).all():  # whether orbits leave, the map decides
        fast, (values, slopes) = f, trace(f, start.ravel(), n, skip)
    pairs = [_mean_of_logs(f, fast, v, s) for v, s in zip(values, slopes, strict=True)]
    mean, error = np.moveaxis(np.array(pairs, dtype=np.float64).reshape(*start.shape, 2), -1, 0)
    return LyapunovExponent(plain(mean), plain(error), n)


def _mean_of_logs(f: Map1D, fast: Map1D, values: Floats, slopes: Floats) -> tuple[float, float]:
    """Mean of log |f'| along an orbit of a map or its stand-in, and its error."""
    if not np.all(np.isfinite(values)):
        return np.nan, np.nan
    with np.errstate(divide="ignore"):
        logs = np.log(np.abs(slopes))
    if np.any(logs == -np.inf):
        return -np.inf, 0.0
    if period := settled_period(values, SAME * domain_width(f)):
        cycle = polish_on(f, values[None, -period:])
        if cycle.converged[0]:
            return float(np.log(np.abs(cycle.slopes[0])).mean()), 0.0
        logs = logs[len(logs) % period :]
    doubt = 0.0 if fast is f else difference(f, values[None], slopes[None])[1]
    return float(logs.mean()), float(np.hypot(blocking_error(logs), doubt))


def difference(f: Map1D, values: Floats, slopes: Floats) -> tuple[float, float]:
    """Compare orbits (m, n) of a stand-in with the map at some points: values, and exponents."""
    rng = np.random.default_rng(0)
    rows, columns = slopes.shape
    row = rng.integers(0, rows, PROBES)
    column = rng.integers(0, columns - 1, PROBES)
    true = sample(f, values[row, column])
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.log(np.abs(true.derivative / slopes[row, column]))
    doubt = abs(float(np.mean(change))) + float(np.std(change)) / np.sqrt(PROBES)
    return float(np.max(np.abs(true.value - values[row, column + 1]))), doubt


def trace(f: Map1D, x: Floats, n: int, skip: int = 0) -> tuple[Floats, Floats]:
    """Follow orbits for `skip` steps, then `n`: points left behind and slopes there, (m, n)."""
    # Floats have few bits: under x -> 2 x mod 1 every orbit ends on 0 after 53 steps. Orbits that
    # end on a repelling cycle are followed once more, moved by a few roundings now and then.
    values, slopes = np.empty((len(x), n)), np.empty((len(x), n))
    on_cycle = np.any(advance(f, x, RECOGNISED)[:, 1:] == x[:, None], axis=1)
    rng, start = np.random.default_rng(0), x
    x, done = advance(f, x, skip)[:, -1], 0
    while done < n:
        step = min(SAMPLES, n - done)
        piece, slope = _stretch(f, x, step)
        stuck = _held_by_rounding(piece[:, :-1], slope) & ~on_cycle
        if np.any(stuck):
            again = _perturbed_orbit(f, start[stuck], skip + SETTLING, rng)[:, -1]
            piece[stuck] = _perturbed_orbit(f, again, step, rng)
            slope[stuck] = values_and_slopes(f, piece[stuck, :-1])[1]
        values[:, done : done + step], slopes[:, done : done + step] = piece[:, :-1], slope
        x, done = piece[:, -1], done + step
        start = x
    return values, slopes


def _stretch(f: Map1D, x: Floats, n: int) -> tuple[Floats, Floats]:
    """Points (m, n + 1) and slopes (m, n) along orbits."""
    native = getattr(f, "iterate_with_slopes", None)
    if native is not None and np.all(clip_to_domain(f.domain, x)[1]):
        values, slopes = native(x, n)
        return values, slopes
    if len(x) < TOGETHER:
        piece = advance(f, x, n)
        return piece, values_and_slopes(f, piece[:, :-1])[1]
    piece, slope = np.empty((len(x), n + 1)), np.empty((len(x), n))
    piece[:, 0] = x
    for k in range(n):
        piece[:, k + 1], slope[:, k] = values_and_slopes(f, piece[:, k])
    return piece, slope


def _held_by_rounding(values: Floats, slopes: Floats) -> Bools:
    """Tell which orbits end on a cycle that repels."""
    stuck = np.zeros(len(values), dtype=np.bool_)
    recent = values[:, -1 - RECOGNISED : -1]
    hits = recent == values[:, -1:]
    for row in np.flatnonzero(hits.any(axis=1)):
        period = recent.shape[1] - int(np.flatnonzero(hits[row])[-1])
        stuck[row] = np.prod(np.abs(slopes[row, -period:])) > 1
    return stuck


def _perturbed_orbit(f: Map1D, x: Floats, n: int, rng: np.random.Generator) -> Floats:
    """Iterate, moving the points by a few roundings each time, so that their bits last."""
    orbit = np.empty((len(x), n + 1))
    orbit[:, 0] = x
    for k in range(n):
        orbit[:, k + 1] = advance(f, perturbed(f, orbit[:, k], rng), 1)[:, -1]
    return orbit


def perturbed(f: Map1D, x: Floats, rng: np.random.Generator) -> Floats:
    """Move points by a few roundings at random, inside the domain."""
    low, high = f.domain
    moved = x + LOCATED * (high - low) * rng.uniform(-1, 1, len(x))
    return np.clip(np.where((moved < low) | (moved > high), 2 * x - moved, moved), low, high)


class ChaoticMotion:
    """Independent orbits that start all over a trapping region, long enough to forget that."""

    def __init__(self, f: Map1D, bands: Floats) -> None:
        steps, x = SAMPLES // FEW, _spread_over(bands)
        x = advance(f, x, steps)[:, -1]
        while True:
            self.values, self.slopes = trace(f, x, steps)
            x, steps, self.reason = self.values[:, -1], GROWTH * steps, ""
            if not np.all(np.isfinite(self.values)):
                self.reason = "part of the bands is lost: the map has a hole there"
                break
            self.exponent = mean_of_logs(self.slopes)
            value, error = self.exponent
            if abs(value) > CLEAR * error or steps > SAMPLES:
                break


def _spread_over(bands: Floats) -> Floats:
    """One random point in each of equal parts of a union of intervals."""
    lengths = bands[:, 1] - bands[:, 0]
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.arange(FEW) + np.random.default_rng(0).random(FEW)
    at = starts[-1] * places / FEW
    k = np.clip(np.searchsorted(starts, at, side="right") - 1, 0, len(bands) - 1)
    return np.asarray(np.minimum(bands[k, 0] + at - starts[k], bands[k, 1]))


def short_intervals(f: Map1D, points: Floats) -> Floats:
    """Neighbours among the points: so short that no gap between bands is inside; (k, 2)."""
    points = np.unique(points)
    gaps = np.diff(points)
    (usable,) = np.nonzero(gaps > ORBIT_NOISE * domain_width(f))
    if not usable.size:
        return np.array([[points[0], points[0] + ORBIT_NOISE * domain_width(f)]])
    k = usable[np.argsort(gaps[usable])[TENTHS * usable.size // 10]]
    return np.column_stack([points[k], points[k + 1]])


def mean_of_logs(slopes: Floats) -> LyapunovExponent:
    """Mean over orbits (m, n); the larger error of blocking and of the spread of orbits' means."""
    logs = np.log(np.maximum(np.abs(slopes), 1e-300))
    error = blocking_error(logs.ravel())
    if len(logs) > 1:
        error = max(error, float(np.std(logs.mean(axis=1), ddof=1) / np.sqrt(len(logs))))
    return LyapunovExponent(float(logs.mean()), error, logs.size)
