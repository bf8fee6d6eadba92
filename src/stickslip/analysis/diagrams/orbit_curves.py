"""Followed orbits solved for at every value of a diagram: from where each begins to where it ends.

Near a fold or flip points move like a root of the distance to there, and are foretold in it.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.bifurcations.in_space.bifurcations_nd import KINDS
from stickslip.analysis.continuation.curve import Curve, CurveEnd
from stickslip.analysis.continuation.follower import off_multiplier
from stickslip.analysis.maps.protocol import Floats, MapND, domain_width, lengths, turned_near
from stickslip.analysis.orbits.newton import padded, polish_on, solve_orbits
from stickslip.analysis.orbits.orbits_nd import multipliers_of
from stickslip.analysis.scales import CLOSE, ORBIT_NOISE, PASSING
from stickslip.numerics.continuation import lagrange_weights

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


BEHIND: Final = 3  # places before a value, passed or known, that foretell it
AHEAD: Final = 2  # known places ahead that do
APART: Final = 1e-2  # of the way to a value: closer places tell only of their errors
ASTRAY: Final = 0.3  # of the way since the last place: how far an orbit may be from its guess
MEETS: Final = ("fold", "transcritical", "pitchfork")  # where a curve turns, or crosses another
ROOTS: Final = ("fold", "flip", "step limit")  # where points may move like a square root


@dataclass(frozen=True, eq=False)
class SampledOrbit:
    """An orbit over an interval of the parameter, known at some values."""

    values: Floats  # ascending; the orbit exists between the first and the last
    points: Floats  # in the map's order, each column following one point; (n, p), or (n, p, m)
    multipliers: Any  # (n,), or all in R^m
    # whether the points move like a square root at the lower and at the upper end
    roots: tuple[bool, bool] = (False, False)
    ends: tuple[CurveEnd, ...] = ()  # the lower one first

    @property
    def period(self) -> int:
        """Of the orbit."""
        return int(self.points.shape[1])

    @property
    def side(self) -> float:
        """On which side of 1 the multiplier is: det(M - 1)."""
        return off_multiplier(self.multipliers[len(self.multipliers) // 2], 1.0)

    def foretell(self, value: float, passed: list[tuple[float, Floats]]) -> Floats:
        """Interpolate to a parameter value through places passed and known places ahead."""
        ahead = bisect_right(self.values, value)
        rows = range(max(0, ahead - BEHIND), min(ahead + AHEAD, len(self.values)))
        known = {float(self.values[k]): self.points[k] for k in rows} | dict(passed)
        if value in known:
            return known[value]
        kept: list[float] = []
        for q in sorted(known, key=lambda q: abs(q - value)):
            room = BEHIND if q <= value else AHEAD
            clear = all(abs(q - other) >= APART * abs(q - value) for other in kept)
            if clear and sum((other <= value) == (q <= value) for other in kept) < room:
                kept.append(q)
        *u, at = self._smooth(np.array([*kept, value])).tolist()
        return np.tensordot(lagrange_weights(u, at), np.array([known[q] for q in kept]), 1)

    def _smooth(self, q: Floats) -> Floats:
        """Return coordinates in which the points are smooth near the last of these values."""
        low, high = float(self.values[0]), float(self.values[-1])
        reach = 0.5 * (high - low)  # to the nearer end
        if self.roots[0] and q[-1] - low <= reach:
            return np.sqrt(np.maximum(q - low, 0.0))
        if self.roots[1] and high - q[-1] <= reach:
            return np.sqrt(np.maximum(high - q, 0.0))
        return q


# ------------------------------------------------------------------ at every value


@dataclass
class _Course:
    """An orbit on its way through the values."""

    sampled: SampledOrbit
    points: Floats
    multipliers: Any  # in R^n the one of largest modulus
    passed: list[tuple[float, Floats]] = field(default_factory=list)


def fill(
    maps: Sequence[Any], values: Floats, sampled_orbits: Sequence[SampledOrbit]
) -> list[tuple[Floats, Any]]:
    """Solve for orbits at all ascending values between their ends, NaN where there is none."""
    courses = [
        _Course(
            s,
            np.full((len(values), *s.points.shape[1:]), np.nan),
            np.full(len(values), np.nan, dtype=s.multipliers.dtype),
        )
        for s in sampled_orbits
    ]
    first = np.searchsorted(values, [s.values[0] for s in sampled_orbits], side="left")
    stop = np.searchsorted(values, [s.values[-1] for s in sampled_orbits], side="right")
    for k, f in enumerate(maps):
        here = [c for c, a, b in zip(courses, first, stop, strict=True) if a <= k < b]
        guesses = [course.sampled.foretell(float(values[k]), course.passed) for course in here]
        found = _solved_in_space(f, guesses) if isinstance(f, MapND) else _solved(f, guesses)
        width = _width(f)
        for course, guess, (points, multipliers) in zip(here, guesses, found, strict=True):
            if _is_the_orbit(points, multipliers, guess, course, width):
                course.points[k] = points
                course.multipliers[k] = np.atleast_1d(multipliers)[0]
                course.passed = [*course.passed, (float(values[k]), points)][-BEHIND:]
    return [(c.points, c.multipliers) for c in courses]


def _width(f: Any) -> Any:
    return lengths(f) if isinstance(f, MapND) else domain_width(f)


def _solved(f: Any, guesses: list[Floats]) -> Iterator[tuple[Floats, Any]]:
    """Polish the orbits of one value all at once."""
    starts, periods = padded(guesses)
    found = polish_on(f, starts, periods=periods, enough=ORBIT_NOISE * domain_width(f))
    multipliers = np.where(found.converged, found.multipliers, np.nan)
    for points, p, multiplier in zip(found.points, periods, multipliers, strict=True):
        yield points[:p], multiplier


def _solved_in_space(f: MapND, guesses: list[Floats]) -> Iterator[tuple[Floats, Any]]:
    for guess in guesses:
        got = solve_orbits(f, guess[None])
        yield got.points[0], multipliers_of(got.jacobians[0]) if got.found[0] else np.nan


def _is_the_orbit(
    now: Floats, multipliers: Any, guess: Floats, course: _Course, width: Any
) -> bool:
    """Tell whether Newton's method stayed with the orbit, and did not end on a neighbour."""
    if not np.isfinite(multipliers).all():
        return False
    sampled = course.sampled
    if off_multiplier(multipliers, 1.0) * sampled.side < 0:
        return False  # the other orbit of a fold
    last = course.passed[-1][1] if course.passed else sampled.points[0]
    way, off = (np.abs((now - other) / width).max() for other in (last, guess))
    return bool(off <= ASTRAY * way + CLOSE)


# ------------------------------------------------------------------ from curves


def sampled_orbits(curves: Sequence[Curve]) -> list[SampledOrbit]:
    """Take curves apart where they turn back: by period, lower end and place."""
    found = [stretch for curve in curves for stretch in _stretches(curve)]
    return sorted(found, key=lambda s: (s.period, s.ends[0].value, float(s.points.flat[0])))


def _stretches(curve: Curve) -> Iterator[SampledOrbit]:
    """Cut a curve where orbits meet, into stretches along which the parameter rises or falls."""
    events = [item for item in curve.bifurcations if item.kind in MEETS]
    cuts = [item.row for item in events]
    meets = [CurveEnd(e.kind, e.parameters, e.points, e.multipliers, e.error) for e in events]
    first, last = (_named(end) for end in curve.ends)
    if cuts and first.reason == "closed":
        curve, cuts = _begun_at(curve, cuts[0]), [c - cuts[0] for c in cuts[1:]]
        first, *meets = meets
        last = replace(first, points=curve.points[-1])
    bounds = pairwise([0, *cuts, len(curve.values) - 1]), pairwise([first, *meets, last])
    for (a, b), ends in zip(*bounds, strict=True):
        if a < b or not cuts:
            listed = [k for k in range(a, b + 1) if k not in cuts]
            yield _sampled(curve, slice(a, b + 1), listed[0] if listed else a, ends)


def _begun_at(curve: Curve, row: int) -> Curve:
    """Let a closed curve begin and end at one of its rows."""
    n, near = len(curve), curve.points[-1]
    rows = np.concatenate([np.arange(row, n), np.arange(row + 1)])
    points = curve.points[rows]
    # The curve may have come back with its points in another turn, and angles after whole turns.
    turns = [np.roll(curve.points[0], k, axis=0) for k in range(len(near))]
    closest = [turned_near(curve.system, points, near) for points in turns]
    k = int(np.argmin([np.abs(points - near).max() for points in closest]))
    points[n - row :] = np.roll(points[n - row :], k, axis=1) + (closest[k] - turns[k])
    parameters = {name: values[rows] for name, values in curve.parameters.items()}
    return replace(curve, parameters=parameters, points=points, multipliers=curve.multipliers[rows])


def _sampled(
    curve: Curve, rows: slice, listed: int, ends: tuple[CurveEnd, CurveEnd]
) -> SampledOrbit:
    """Describe an orbit from its lower to its upper end, its smallest point in a list first."""
    values, points, multipliers = curve.values[rows], curve.points[rows], curve.multipliers[rows]
    if values[-1] < values[0]:
        values, points, multipliers = values[::-1], points[::-1], multipliers[::-1]
        ends = ends[::-1]
    width = np.ptp(curve.points) if curve.system is None else _width(curve.system)
    for end, at in zip(ends, (0, len(values)), strict=True):
        near = values[-1 if at else 0]
        beyond = end.value > near if at else end.value < near
        if beyond and (np.abs(end.points - points[-1 if at else 0]) < PASSING * width).all():
            values, points = np.insert(values, at, end.value), np.insert(points, at, end.points, 0)
            multipliers = np.insert(multipliers, at, multipliers[-1 if at else 0], 0)
    columns = curve.points[listed].reshape(curve.points.shape[1], -1)
    turn = -int(np.argmin(columns[:, 0]))
    low, high = (
        replace(
            end,
            points=np.roll(end.points, turn, axis=0),
            index=None if end.index is None else (end.index + turn) % len(columns),
        )
        for end in ends
    )
    roots = (low.reason in ROOTS, high.reason in ROOTS)
    return SampledOrbit(values, np.roll(points, turn, axis=1), multipliers, roots, (low, high))


def _named(end: CurveEnd) -> CurveEnd:
    """Say by which bifurcation a curve ends."""
    reason = KINDS.get(end.reason, end.reason)
    if end.reason == "end of domain":
        reason = "outside" if end.border is None else "enters_gap"
    return replace(end, reason=reason)
