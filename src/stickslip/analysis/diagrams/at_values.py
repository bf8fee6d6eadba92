"""Orbits at every one of many parameter values, between places where they are known.

Each orbit is foretold from the values just passed and from known places ahead, all orbits of one
value are solved for by Newton's method together, and each must come out where it was foretold.
Near a fold, or where a doubled orbit is born, points move like the square root of the distance
to there; in that root they are smooth, and so they are foretold in it.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.analysis.orbits.newton import solve_cyclic

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Map1D

PASSED: Final = 3  # values just passed that foretell the next
AHEAD: Final = 2  # known places ahead that do
NEAR_ROOT: Final = 0.5  # share of an orbit that is seen in the square root of the distance
ASTRAY: Final = 0.3  # of the way since the last place: how far an orbit may be from its guess
FLOOR: Final = 1e-6  # of the domain's width: errors of a guess that count for nothing
TINY: Final = 1e-10  # of the domain's width: after a Newton step this small, points are exact
STALLED: Final = 1e-7  # of the domain's width: smaller steps must go on shrinking
MOST_STEPS: Final = 12


@dataclass(frozen=True, eq=False)
class SampledOrbit:
    """An orbit over an interval of the parameter, known at some values."""

    values: Floats  # ascending; the orbit exists between the first and the last
    points: Floats  # in the map's order, each column following one point
    multipliers: Floats
    # whether the points move like a square root at the lower and at the upper end
    roots: tuple[bool, bool] = (False, False)

    @property
    def period(self) -> int:
        """Of the orbit."""
        return int(self.points.shape[1])

    def foretell(self, value: float, passed: list[tuple[float, Floats]]) -> Floats:
        """Interpolate to a parameter value through places passed and known places ahead."""
        ahead = bisect_right(self.values, value)
        behind = max(0, ahead - max(1, PASSED - len(passed)))
        known = range(
            behind if len(passed) < PASSED else ahead, min(ahead + AHEAD, len(self.values))
        )
        places = {float(self.values[k]): self.points[k] for k in known}
        places.update(passed[-PASSED:])
        if value in places:
            return places[value]
        q = np.array(list(places))
        u = self._smooth(np.append(q, value))
        return _lagrange(u[:-1], np.array(list(places.values())), float(u[-1]))

    def _smooth(self, q: Floats) -> Floats:
        """Return coordinates in which the points are smooth near the last of these values."""
        low, high = float(self.values[0]), float(self.values[-1])
        reach = NEAR_ROOT * (high - low)
        if self.roots[0] and q[-1] - low <= reach:
            return np.sqrt(np.maximum(q - low, 0.0))
        if self.roots[1] and high - q[-1] <= reach:
            return np.sqrt(np.maximum(high - q, 0.0))
        return q


def _lagrange(u: Floats, x: Floats, at: float) -> Floats:
    """Polynomial through (u, x), shapes (k,) and (k, p), at one place."""
    with np.errstate(all="ignore"):
        ratio = (at - u[None, :]) / (u[:, None] - u[None, :])
    np.fill_diagonal(ratio, 1.0)
    return np.asarray(ratio.prod(axis=1) @ x)


@dataclass
class _Course:
    """An orbit on its way through the values."""

    sampled: SampledOrbit
    points: Floats
    multipliers: Floats
    passed: list[tuple[float, Floats]] = field(default_factory=list)


def fill(
    maps: Sequence[Map1D], values: Floats, sampled_orbits: Sequence[SampledOrbit]
) -> list[tuple[Floats, Floats]]:
    """Solve for orbits at all ascending values between their ends, NaN where there is none."""
    n = len(values)
    courses = [
        _Course(s, np.full((n, s.period), np.nan), np.full(n, np.nan)) for s in sampled_orbits
    ]
    first = np.searchsorted(values, [s.values[0] for s in sampled_orbits], side="left")
    stop = np.searchsorted(values, [s.values[-1] for s in sampled_orbits], side="right")
    for k, f in enumerate(maps):
        here = [c for c, a, b in zip(courses, first, stop, strict=True) if a <= k < b]
        if here:
            _solve(f, float(values[k]), k, here)
    return [(c.points, c.multipliers) for c in courses]


def _solve(f: Map1D, value: float, k: int, courses: list[_Course]) -> None:
    """Find all orbits of one value, and enter those that are where they were foretold."""
    longest = max(course.sampled.period for course in courses)
    guess = np.full((len(courses), longest), np.nan)
    for line, course in zip(guess, courses, strict=True):
        line[: course.sampled.period] = course.sampled.foretell(value, course.passed)
    periods = np.array([course.sampled.period for course in courses], dtype=np.intp)
    points, multipliers = _newton(f, guess, periods)
    slack = FLOOR * domain_width(f)
    for row, course in enumerate(courses):
        p = course.sampled.period
        if _is_the_orbit(points[row, :p], multipliers[row], guess[row, :p], course, slack):
            course.points[k] = points[row, :p]
            course.multipliers[k] = multipliers[row]
            course.passed = [*course.passed, (value, points[row, :p])][-PASSED:]


def _newton(
    f: Map1D, guess: Floats, periods: NDArray[np.intp]
) -> tuple[Floats, NDArray[np.float64]]:
    """Solve for orbits, one per row padded with NaN; the multiplier is NaN where that failed."""
    points = np.clip(guess, *f.domain)
    multipliers = np.full(len(points), np.nan)
    todo = np.arange(len(points))
    last = np.full(len(points), np.inf)
    enough, small = TINY * domain_width(f), STALLED * domain_width(f)
    for _ in range(MOST_STEPS):
        slopes, residuals = _slopes_and_residuals(f, points[todo], periods[todo])
        steps = solve_cyclic(slopes, -residuals, periods[todo])
        used = np.arange(points.shape[1]) < periods[todo, None]
        with np.errstate(invalid="ignore"):
            size = np.where(used, np.abs(steps), 0.0).max(axis=1)
        points[todo] = np.clip(points[todo] + np.where(used, steps, 0.0), *f.domain)
        # Small steps that shrink no more are the map's rounding over 1 - multiplier.
        done = (size <= enough) | ((size <= small) & (size >= 0.25 * last[todo]))
        multipliers[todo] = np.where(done, slopes.prod(axis=1), np.nan)
        last[todo] = size
        todo = todo[~done & np.isfinite(size)]
        if not todo.size:
            break
    return points, multipliers


def _slopes_and_residuals(
    f: Map1D, points: Floats, periods: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """Return slopes and f(x_i) - x_(i+1), padded with 1 and 0 beyond the period."""
    used = np.arange(points.shape[1]) < periods[:, None]
    values = sample(f, points[used])
    slopes, residuals = np.ones(points.shape), np.zeros(points.shape)
    following = np.roll(points, -1, axis=1)
    following[np.arange(len(points)), periods - 1] = points[:, 0]
    slopes[used] = values.derivative
    residuals[used] = values.value - following[used]
    return slopes, residuals


def _is_the_orbit(
    now: Floats, multiplier: float, guess: Floats, course: _Course, slack: float
) -> bool:
    """Tell whether Newton's method stayed with the orbit, and did not end on a neighbour."""
    if not np.isfinite(multiplier):
        return False
    sampled = course.sampled
    side = np.sign(sampled.multipliers[len(sampled.multipliers) // 2] - 1)
    if (multiplier - 1) * side < 0:
        return False  # the other orbit of a fold
    last = course.passed[-1][1] if course.passed else sampled.points[0]
    way = float(np.abs(now - last).max())
    return bool(np.abs(now - guess).max() <= ASTRAY * way + slack)
