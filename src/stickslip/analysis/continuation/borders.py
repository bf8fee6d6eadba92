"""What an orbit may meet along a parameter: breaks of the map, and the ends of its domain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.along.tracked import (
    ConditionLost,
    DomainEnd,
    TrackedDiscontinuity,
    piece_end,
    piece_end_near,
)
from stickslip.analysis.branches.mesh import RESOLUTION
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.continuation.half_period import ROUNDING
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import SAME, domain_width, sample
from stickslip.analysis.scales import FINE, ON_CURVE
from stickslip.numerics.zeros import MAX_STEPS
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.continuation.orbit_equations import Departure, OrbitEquations
    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D, MapFamily

REACHES: Final = 32.0  # times the last step: how far off a break, or the end of a curve, may be
FIRST_CHANGE: Final = 1e-6  # of a parameter's range: differences of values and of readings
SHRINKS: Final = 0.9  # at a tangency, too, each step is half or two thirds of the one before


@dataclass
class Border:
    """A break of the map, or an end of its domain, that an orbit meets; knows where it was."""

    index: int  # of the point of the orbit
    critical: TrackedDiscontinuity | DomainEnd
    side: int  # the orbit's: -1 left, 1 right
    # labels on the orbit's side, at whose end the break is; empty without labels
    piece: frozenset[int] = frozenset()

    def reading(self, f: Map1D) -> CriticalReading:
        """Find the border in a map; `ConditionLost` if it is gone, or there is no value."""
        try:
            found = self.critical.at(f, successors=False)
        except ConditionLost:
            end = piece_end_near(f, self.piece, self.critical.x, self.side)
            if end is None:
                raise
            found = end
        if not math.isfinite(found.value(self.side)):
            raise ConditionLost(f"no value at the end {found.x:.12g} of the domain")
        assert isinstance(found.critical, TrackedDiscontinuity | DomainEnd)
        self.critical = found.critical
        return found

    @property
    def harmless(self) -> int | None:
        """Label beyond a break that does the orbit nothing; None at any other border."""
        met = self.critical
        if isinstance(met, DomainEnd) or met.kind != "smooth":
            return None
        return met.right_label if self.side < 0 else met.left_label


def encounters(
    equations: OrbitEquations, points: Floats, value: float, departure: Departure
) -> Iterator[Border]:
    """Name the likely borders between an orbit and its points that have left their pieces."""
    for index in departure.indices:
        x, gone_to = points[index], float(departure.points[index])
        piece, middle = equations.pieces[index], 0.5 * (departure.value + value)
        # Orbit and break both move: between which of their places it lies is to be tried.
        tried = map(equations.at, (departure.value, value, middle))
        met = (_between(f, piece, x, gone_to, index) for f in tried)
        if (found := next(filter(None, met), None)) is not None:
            yield found
            continue
        # Or the break has overtaken the orbit.
        f = equations.at(value)
        reach = REACHES * abs(gone_to - x) + SAME * domain_width(f)
        for side in (-1, 1):
            found = _between(f, piece, x, float(np.clip(x - side * reach, *f.domain)), index)
            if found is not None:
                yield found


def _between(
    f: MapFamily, piece: set[int], inside: float, outside: float, index: int
) -> Border | None:
    """Find the first break between a point on a piece and one that is not; None if none is seen."""
    lo, hi = f.domain
    if not lo <= inside <= hi:
        return None
    side = -1 if outside > inside else 1
    end = piece_end(f, piece, inside, min(max(outside, lo), hi))
    if end is None:
        upper = side < 0
        ended = not lo <= outside <= hi
        return Border(index, DomainEnd(upper, f.domain[upper]), side) if ended else None
    assert isinstance(end.critical, TrackedDiscontinuity)
    return Border(index, _settled(end.critical, side, f), side, frozenset(piece))


def _settled(end: TrackedDiscontinuity, side: int, f: Map1D) -> TrackedDiscontinuity:
    """Tell a break by the next branch worth the name; within rounding of a tie labels flicker."""
    own, next_one = (end.left_label, end.right_label)[::-side]
    values = sample(f, float(np.clip(end.x - side * RESOLUTION * domain_width(f), *f.domain)))
    label = int(values.label) if values.status == OK else None
    for beyond in dict.fromkeys((label, next_one)):
        if beyond == own:  # a sliver inside the branch: of no break could these labels tell
            continue
        left, right = (own, beyond)[::-side]
        try:
            met = TrackedDiscontinuity(left, right, end.x, end.kind)
            found = met.at(f, successors=False).critical
        except ConditionLost:
            continue
        if isinstance(found, TrackedDiscontinuity):
            return found
    return end


def unlabelled_encounters(f: MapFamily, points: Floats) -> list[Border]:
    """Look for breaks that no label tells of, close to points of an orbit, the nearest first."""
    found: list[tuple[float, Border]] = []
    half = ON_CURVE * domain_width(f)
    for index, x in enumerate(points.tolist()):
        for b in branch_table(WindowMap(f, (x - half, x + half))).breakpoints:
            if b.kind != "smooth":
                side = -1 if b.d > x else 1
                found.append((abs(b.d - x), Border(index, TrackedDiscontinuity.of(b), side)))
    return [border for _, border in sorted(found, key=lambda pair: pair[0])]


# ------------------------------------------------------------------ the meeting solved for

# One point of the orbit is pinned to the border, and the parameter takes its place among the
# unknowns. Only one-sided values at the border enter, so that neither an orbit that ends there nor
# a root's infinite slope does any harm.


@dataclass(frozen=True, eq=False)
class Meeting:
    """An orbit with a point held on a border; periodic where the residual vanishes."""

    value: float  # of the parameter
    points: Floats
    f: MapFamily
    image: float  # of the border: its one-sided value
    slopes: Floats  # one-sided at the border
    labels: Labels  # at the border maybe that of the other side
    residual: Floats


def meet(
    at: Callable[[float], MapFamily],
    name: str,
    points: Floats,
    border: Border,
    value: float,
    low: float,
    high: float,
) -> Meeting:
    """Solve for the parameter at which a point of a periodic orbit lies on the border it came to.

    Raises `ConditionLost` if the border is gone, the orbit leaves the domain, or nothing is nearby.
    """
    aside = max(FIRST_CHANGE * (high - low), ROUNDING * abs(value))
    beside = value + aside if value + aside <= high else value - aside
    before = _held(at(beside), border, beside, points)
    now = _held(at(value), border, value, points)
    last = np.inf
    for _ in range(MAX_STEPS):
        step = _newton_step(before, now, border.index, name)
        change = abs(step[border.index])
        noise = change <= FINE * (high - low) and change >= SHRINKS * last
        if noise or change <= ROUNDING * max(abs(now.value), high - low):
            return now
        q = min(max(now.value + step[border.index], low), high)
        if not np.isfinite(step).all() or q == now.value:
            break
        before, now, last = now, _held(at(q), border, q, now.points + step), change
    raise ConditionLost("the orbit does not meet the break nearby")


def _held(f: MapFamily, border: Border, q: float, guess: Floats) -> Meeting:
    """Evaluate the equations, the pinned point on the border."""
    k, met, side = border.index, border.reading(f), border.side
    points = np.clip(guess, *f.domain)
    points[k] = met.x
    values = sample(f, points)
    rest = np.arange(len(points)) != k
    if (values.status[rest] != OK).any():
        raise ConditionLost("the orbit has no value on the way to the break")
    images, slopes = values.value.copy(), values.derivative.copy()
    images[k], slopes[k] = met.value(side), met.slope(side)
    residual = images - np.roll(points, -1)
    return Meeting(q, points, f, met.value(side), slopes, values.label, residual)


def _newton_step(before: Meeting, now: Meeting, k: int, name: str) -> Floats:
    """Solve for changes of the points, and the parameter's in place of the pinned one's."""
    p = len(now.points)
    ahead = (np.arange(p) + 1) % p
    difference = now.value - before.value
    rates = np.zeros(p)
    rest = np.arange(p) != k
    if rest.any():
        rates[rest] = now.f.parameter_derivative(now.points[rest], name)
    rates[k] = (now.image - before.image) / difference
    matrix = np.zeros((p, p))
    matrix[np.arange(p), np.arange(p)] = np.where(rest, now.slopes, 0.0)
    matrix[np.arange(p), ahead] -= np.where(ahead == k, 0.0, 1.0)
    matrix[:, k] = rates
    matrix[k - 1, k] -= (now.points[k] - before.points[k]) / difference
    try:
        return np.asarray(np.linalg.solve(matrix, -now.residual), dtype=np.float64)
    except np.linalg.LinAlgError as reason:
        raise ConditionLost("the orbit touches the break without crossing it") from reason
