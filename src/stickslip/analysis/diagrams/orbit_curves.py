"""Orbits of a surveyed range as curves: from where each begins to where it ends, at every value.

Near a fold or flip points move like a root of the distance to there, and are foretold in it.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.scan.events import orbit_at
from stickslip.analysis.maps.protocol import domain_width
from stickslip.analysis.orbits.bundles import evaluate_padded
from stickslip.analysis.orbits.newton import solve_cyclic, turn_towards
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.bifurcations.scan.events import Event
    from stickslip.analysis.bifurcations.scan.nodes import Family, Node
    from stickslip.analysis.bifurcations.scan.survey import Span, Survey
    from stickslip.analysis.bifurcations.scan.tracking import Piece
    from stickslip.analysis.maps.protocol import Floats, Map1D

PASSED: Final = 3  # values just passed that foretell the next
AHEAD: Final = 2  # known places ahead that do
NEAR_ROOT: Final = 0.5  # share of an orbit that is seen in the square root of the distance
ASTRAY: Final = 0.3  # of the way since the last place: how far an orbit may be from its guess
FLOOR: Final = 1e-6  # of the domain's width: errors of a guess that count for nothing
TINY: Final = 1e-10  # of the domain's width: after a Newton step this small, points are exact
STALLED: Final = 1e-7  # of the domain's width: smaller steps must go on shrinking
MOST_STEPS: Final = 12
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
        slopes, _, residuals = evaluate_padded(f, points[todo], periods[todo])
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


@part
@dataclass(frozen=True, eq=False)
class OrbitCurveEnd:
    """Where an orbit begins or ends.

    Attributes
    ----------
    value : float
        Of the parameter.
    points : ndarray of float, shape (p,)
        The orbit there, as far as it is known.
    reason : str
        "end of range", "fold", "flip", "border_collision", "enters_gap", "outside" (it leaves
        the window), or how an orbit ends that no event explains.
    """

    value: float
    points: Floats
    reason: str


@dataclass(frozen=True, eq=False)
class Traced:
    """An orbit with both ends, the lower first."""

    sampled: SampledOrbit
    ends: tuple[OrbitCurveEnd, OrbitCurveEnd]


@dataclass
class _Open:
    """An orbit that still grows: samples in ascending order of the parameter."""

    start: str
    values: list[float] = field(default_factory=list)
    points: list[Floats] = field(default_factory=list)
    multipliers: list[float] = field(default_factory=list)

    def add(self, values: Floats, points: Floats, multipliers: Floats) -> None:
        """Append samples, turned so that each column goes on with the same point."""
        if self.points:
            points = np.roll(points, -turn_towards(points[0], self.points[-1]), axis=1)
        for q, x, multiplier in zip(values, points, multipliers, strict=True):
            if not self.values or q > self.values[-1]:
                self.values.append(float(q))
                self.points.append(x)
                self.multipliers.append(float(multiplier))

    def closed(self, reason: str) -> Traced:
        """Finish the orbit."""
        values, points = np.array(self.values), np.array(self.points)
        roots = (self.start in ROOTS, reason in ROOTS)
        sampled = SampledOrbit(values, points, np.array(self.multipliers), roots)
        return Traced(
            sampled,
            (
                OrbitCurveEnd(float(values[0]), points[0], self.start),
                OrbitCurveEnd(float(values[-1]), points[-1], reason),
            ),
        )


def trace_orbits(survey: Survey) -> list[Traced]:
    """Link what a survey found between its values: by period, then by lower end and place."""
    done: list[Traced] = []
    first = survey.spans[0].left
    growing = {k: _begun(first, k, "end of range") for k in range(len(first.orbits))}
    for span in survey.spans:
        pieces = [*span.pieces, *(ending.piece for ending in span.endings)]
        arrived: dict[int, _Open] = {}
        for piece in pieces:
            sampled = _grown(growing, piece, _reason(span, piece))
            if piece.right is not None:
                arrived[piece.right] = sampled
            else:
                done.append(sampled.closed(_reason(span, piece)))
        for k in span.loose_left:
            sampled = growing.pop(k) if k in growing else _begun(span.left, k, "unexplained")
            done.append(_ended(sampled, span, survey.family))
        for k in span.loose_right:
            arrived[k] = _born(span, k, survey.family)
        growing = arrived
    done += [sampled.closed("end of range") for sampled in growing.values()]
    return sorted(done, key=lambda t: (t.sampled.period, t.ends[0].value, t.sampled.points[0, 0]))


def _begun(node: Node, k: int, reason: str) -> _Open:
    orbit, sampled = node.orbits[k], _Open(reason)
    sampled.add(np.array([node.q]), orbit.points[None], np.array([orbit.multiplier]))
    return sampled


def _grown(growing: dict[int, _Open], piece: Piece, reason: str) -> _Open:
    """Append a piece to the orbit that it continues, or begin one with it."""
    sampled = None if piece.left is None else growing.pop(piece.left, None)
    sampled = _Open(reason) if sampled is None else sampled
    sampled.add(piece.values, piece.points, piece.multipliers)
    return sampled


def _reason(span: Span, piece: Piece) -> str:
    """Why a piece ends inside a span."""
    return next(
        (e.event.kind if e.event else e.reason for e in span.endings if e.piece is piece),
        "unexplained",
    )


def _ended(sampled: _Open, span: Span, family: Family) -> Traced:
    """Lead an orbit up to the event in a span, and end it there."""
    event, points = _event_at(span, sampled.points[-1], family)
    if event is None:
        return sampled.closed("unexplained")
    if points is not None:
        multiplier = _multiplier_at(event, sampled.multipliers[-1])
        sampled.add(np.array([event.value]), points[None], np.array([multiplier]))
    return sampled.closed(event.kind)


def _born(span: Span, k: int, family: Family) -> _Open:
    """Begin an orbit at the event in a span."""
    orbit = span.right.orbits[k]
    event, points = _event_at(span, orbit.points, family)
    sampled = _Open("unexplained" if event is None else event.kind)
    if event is not None and points is not None:
        multiplier = _multiplier_at(event, orbit.multiplier)
        sampled.add(np.array([event.value]), points[None], np.array([multiplier]))
    sampled.add(np.array([span.right.q]), orbit.points[None], np.array([orbit.multiplier]))
    return sampled


def _event_at(span: Span, points: Floats, family: Family) -> tuple[Event | None, Floats | None]:
    """Choose the event of a span that an orbit ends at, and the orbit's points there."""
    best, best_gap, best_points = None, CLOSE * span.left.width, None
    for event in span.events:
        there = orbit_at(event, points, family)
        if there is None:
            continue
        gap = float(np.abs(there - points).max())
        if gap < best_gap:
            best, best_gap, best_points = event, gap, there
    if best is None and span.events:
        return span.events[0], None
    return best, best_points


def _multiplier_at(event: Event, beside: float) -> float:
    """Multiplier of an orbit that ends in an event, from its multiplier just beside."""
    return 1.0 if event.kind in ("fold", "flip", "transcritical", "pitchfork") else beside
