"""What an orbit may meet along a parameter: breaks of the map, and the ends of its domain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from stickslip.analysis.branches.along.change_search import SLIVER
from stickslip.analysis.branches.along.tracked import (
    ConditionLost,
    TrackedDiscontinuity,
    piece_end,
    piece_end_near,
)
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.branches.along.tracked import PieceEnd
    from stickslip.analysis.continuation.orbit_equations import Departure, OrbitEquations
    from stickslip.analysis.maps.protocol import Floats, Map1D, MapFamily

OVERTAKES: Final = 32.0  # times the orbit's step: how far a break may come from
TINY: Final = 1e-12
NEARBY: Final = 1e-4  # of the domain: where a break without a label is looked for


class Border(Protocol):
    """A place of the map that moves with its parameters and that an orbit may meet."""

    side: int  # where the orbit is: -1 left of it, 1 right

    def reading(self, f: Map1D) -> tuple[float, float, float]:
        """Return its place, and value and slope of the map there on the orbit's side."""


@dataclass
class Break:
    """A break of the map; remembers where it was last."""

    discontinuity: TrackedDiscontinuity
    side: int  # the orbit's: -1 left, 1 right
    # labels on the orbit's side, at whose end the break is; empty without labels
    piece: frozenset[int] = frozenset()

    def reading(self, f: Map1D) -> tuple[float, float, float]:
        """Find the break in a map; `ConditionLost` if it is gone."""
        try:
            found = self.discontinuity.at(f, successors=False)
        except ConditionLost:
            end = piece_end_near(f, self.piece, self.discontinuity.x, self.side)
            if end is None:
                raise
            self.discontinuity = end.border
            return end.border.x, end.value, end.slope
        assert isinstance(found.critical, TrackedDiscontinuity)
        self.discontinuity = found.critical
        return found.x, found.value(self.side), found.slope(self.side)


@dataclass
class DomainEnd:
    """An end of the domain or window: the orbit's ``side`` of it is -1 for the upper end."""

    side: int

    def reading(self, f: Map1D) -> tuple[float, float, float]:
        """Evaluate the map at its end."""
        x = f.domain[0 if self.side > 0 else 1]
        values = sample(f, x)
        if values.status != OK:
            raise ConditionLost(f"no value at the end {x:.12g} of the domain")
        return x, float(values.value), float(values.derivative)


@dataclass(frozen=True, eq=False)
class Encounter:
    """A border that a point of an orbit has come to."""

    index: int
    kind: str
    border: Border
    beyond: int | None = None  # label on the other side; None where there is no value

    @classmethod
    def of(
        cls, index: int, break_: TrackedDiscontinuity, side: int, piece: set[int] | None = None
    ) -> Encounter:
        """Meet a break from one side."""
        beyond = break_.right_label if side < 0 else break_.left_label
        return cls(index, break_.kind, Break(break_, side, frozenset(piece or ())), beyond)


def encounters(
    equations: OrbitEquations, points: Floats, value: float, departure: Departure
) -> Iterator[Encounter]:
    """Name the likely borders between an orbit and its points that have left their pieces."""
    for index in departure.indices:
        yield from _of_point(equations, index, points[index], value, departure)


def _of_point(
    equations: OrbitEquations, index: int, x: float, value: float, departure: Departure
) -> Iterator[Encounter]:
    """Name what stands in the way of one point."""
    piece, gone_to = equations.pieces[index], float(departure.points[index])
    # Orbit and break both move: between which of their places it lies is to be tried.
    for q in (departure.value, value, 0.5 * (departure.value + value)):
        found = _between(equations.at(q), piece, x, gone_to, index)
        if found is not None:
            yield found
            return
    # Or the break has overtaken the orbit.
    f = equations.at(value)
    reach = OVERTAKES * abs(gone_to - x) + TINY * domain_width(f)
    for side in (-1, 1):
        found = _between(f, piece, x, float(np.clip(x - side * reach, *f.domain)), index)
        if found is not None:
            yield found


def _between(
    f: MapFamily, piece: set[int], inside: float, outside: float, index: int
) -> Encounter | None:
    """Find the first break between a point on a piece and one that is not; None if none is seen."""
    lo, hi = f.domain
    if not lo <= inside <= hi:
        return None
    side = -1 if outside > inside else 1
    end = piece_end(f, piece, inside, min(max(outside, lo), hi))
    if end is None:
        return None if lo <= outside <= hi else Encounter(index, "end", DomainEnd(side))
    return Encounter.of(index, _settled(end, f), side, piece)


def _settled(end: PieceEnd, f: Map1D) -> TrackedDiscontinuity:
    """Tell a break by the next branch worth the name; within rounding of a tie labels flicker."""
    own = end.border.left_label if end.side < 0 else end.border.right_label
    next_one = float(np.clip(end.border.x - end.side * SLIVER * domain_width(f), *f.domain))
    values = sample(f, next_one)
    label = int(values.label) if values.status == OK else None
    for beyond in dict.fromkeys((label, end.beyond)):
        left, right = (own, beyond) if end.side < 0 else (beyond, own)
        try:
            found = (
                TrackedDiscontinuity(left, right, end.border.x, end.border.kind)
                .at(f, successors=False)
                .critical
            )
        except ConditionLost:
            continue
        if isinstance(found, TrackedDiscontinuity):
            return found
    return end.border


def unlabelled_encounters(f: MapFamily, points: Floats) -> list[Encounter]:
    """Look for breaks that no label tells of, close to points of an orbit, the nearest first."""
    found: list[tuple[float, Encounter]] = []
    half = NEARBY * domain_width(f)
    for index, x in enumerate(points.tolist()):
        for b in branch_table(WindowMap(f, (x - half, x + half))).breakpoints:
            if b.kind != "smooth":
                side = -1 if b.d > x else 1
                found.append((abs(b.d - x), Encounter.of(index, TrackedDiscontinuity.of(b), side)))
    return [encounter for _, encounter in sorted(found, key=lambda pair: pair[0])]
