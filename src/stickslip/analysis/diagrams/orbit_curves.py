"""Orbits of a surveyed range as curves: from where each begins to where it ends, at every value.

Near a fold or flip points move like a root of the distance to there, and are foretold in it.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.explain import concerned_orbits
from stickslip.analysis.bifurcations.orbit_curves import Row, columns_of, orbit_chains
from stickslip.analysis.bifurcations.scan.events import orbit_at
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.maps.protocol import domain_width
from stickslip.analysis.orbits.newton import polish_on
from stickslip.numerics.continuation import lagrange_weights

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from stickslip.analysis.bifurcations.orbit_curves import Link
    from stickslip.analysis.bifurcations.scan.survey import Survey
    from stickslip.analysis.maps.protocol import Floats, Map1D

PASSED: Final = 3  # values just passed that foretell the next
AHEAD: Final = 2  # known places ahead that do
NEAR_ROOT: Final = 0.5  # share of an orbit that is seen in the square root of the distance
ASTRAY: Final = 0.3  # of the way since the last place: how far an orbit may be from its guess
FLOOR: Final = 1e-6  # of the domain's width: errors of a guess that count for nothing
TINY: Final = 1e-10  # of the domain's width: after a Newton step this small, points are exact
ROOTS: Final = ("fold", "flip", "standstill", "doubling")  # where points move like a square root
CLOSE: Final = 0.05  # of the domain's width: how far an orbit may be from the event that ends it


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
        *u, at = self._smooth(np.append(q, value)).tolist()
        return np.asarray(lagrange_weights(u, at) @ np.array(list(places.values())))

    def _smooth(self, q: Floats) -> Floats:
        """Return coordinates in which the points are smooth near the last of these values."""
        low, high = float(self.values[0]), float(self.values[-1])
        reach = NEAR_ROOT * (high - low)
        if self.roots[0] and q[-1] - low <= reach:
            return np.sqrt(np.maximum(q - low, 0.0))
        if self.roots[1] and high - q[-1] <= reach:
            return np.sqrt(np.maximum(high - q, 0.0))
        return q


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
    found = polish_on(f, guess, periods=periods, enough=TINY * domain_width(f))
    points, multipliers = found.points, np.where(found.converged, found.multipliers, np.nan)
    slack = FLOOR * domain_width(f)
    for row, course in enumerate(courses):
        p = course.sampled.period
        if _is_the_orbit(points[row, :p], multipliers[row], guess[row, :p], course, slack):
            course.points[k] = points[row, :p]
            course.multipliers[k] = multipliers[row]
            course.passed = [*course.passed, (value, points[row, :p])][-PASSED:]


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


@dataclass(frozen=True, eq=False)
class Traced:
    """An orbit with both ends, the lower first."""

    sampled: SampledOrbit
    ends: tuple[CurveEnd, CurveEnd]


def trace_orbits(survey: Survey) -> list[Traced]:
    """Take apart what a survey joined where orbits turn back: by period, lower end and place."""
    concerned = {k: concerned_orbits(span)[0] for k, span in enumerate(survey.spans) if span.events}
    traced = [
        _traced(survey.family.name, stretch)
        for chain in orbit_chains(survey, concerned)
        for stretch in _stretches(survey, *chain)
    ]
    return sorted(traced, key=lambda t: (t.sampled.period, t.ends[0].value, t.sampled.points[0, 0]))


def _stretches(
    survey: Survey, first: Link | None, rows: list[Row], last: Link | None
) -> Iterator[tuple[str, list[Row], str]]:
    """Cut a chain where orbits meet: reasons at both ends, and the rows between."""
    cuts = [k for k, row in enumerate(rows) if row.event is not None and row.event.kind != "flip"]
    begun = _reason(survey, first, rows[0])
    if last is not None and last.to is not None and cuts:
        # A closed curve: begin where two orbits meet.
        rows, cuts = rows[cuts[0] :] + rows[: cuts[0] + 1], [k - cuts[0] for k in cuts[1:]]
        begun = _reason(survey, None, rows[0])
        last = None
    for a, b in pairwise([0, *cuts, len(rows) - 1]):
        ended = _reason(survey, last if b == len(rows) - 1 else None, rows[b])
        inner = rows[a : b + 1]
        if a == 0 and first is not None:
            inner = _led_up(survey, first, inner[0]) + inner
        if b == len(rows) - 1 and last is not None:
            inner = inner + _led_up(survey, last, inner[-1])
        if a < b or not cuts:
            yield begun, inner, ended
        begun = ended


def _reason(survey: Survey, link: Link | None, row: Row) -> str:
    """Say why an orbit ends at a row, or beyond it."""
    if link is not None and link.to is None:
        return link.event.kind if link.event is not None else link.reason or "unexplained"
    if row.event is not None:
        return row.event.kind
    return "end of range" if row.value in (survey.lo, survey.hi) else "unexplained"


def _led_up(survey: Survey, link: Link, row: Row) -> list[Row]:
    """Return the orbit at the event in which its way ends beyond a row, if that is known."""
    event = link.event
    there = None if event is None else orbit_at(event, row.points, survey.family)
    if event is None or there is None or event.value == row.value:
        return []
    if np.abs(there - row.points).max() >= CLOSE * domain_width(survey.family.f):
        return []
    one = event.kind in ("fold", "flip", "transcritical", "pitchfork")
    return [Row(event.value, there, 1.0 if one else row.multiplier, event)]


def _traced(name: str, stretch: tuple[str, list[Row], str]) -> Traced:
    """Describe an orbit from its lower to its upper end."""
    begun, rows, ended = stretch
    if rows[-1].value < rows[0].value:
        begun, rows, ended = ended, rows[::-1], begun
    values, points = columns_of(rows)
    listed = next((k for k, row in enumerate(rows) if row.event is None), 0)
    points = np.roll(points, -int(np.argmin(points[listed])), axis=1)
    roots = (begun in ROOTS, ended in ROOTS)
    sampled = SampledOrbit(values, points, np.array([row.multiplier for row in rows]), roots)
    ends = ((values[0], points[0], begun), (values[-1], points[-1], ended))
    low, high = (CurveEnd(why, {name: float(value)}, there) for value, there, why in ends)
    return Traced(sampled, (low, high))
