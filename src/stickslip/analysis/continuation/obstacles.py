"""What stops an orbit that is followed along a parameter: which break of the map, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.along.change_search import SLIVER
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity, piece_end
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.continuation.walls import BorderWall, DomainEnd
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.branches.along.tracked import PieceEnd
    from stickslip.analysis.continuation.orbit_equations import Departure, OrbitEquations
    from stickslip.analysis.continuation.walls import Wall
    from stickslip.analysis.maps.protocol import Floats, Map1D, MapFamily

OVERTAKES: Final = 32.0  # times the orbit's step: how far a break may come from
TINY: Final = 1e-12
NEARBY: Final = 1e-4  # of the domain: where a break without a label is looked for


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A break, or an end of the domain, that a point of an orbit has come to."""

    index: int
    kind: str
    wall: Wall
    beyond: int | None = None  # label on the other side; None where there is no value


def obstacles(
    equations: OrbitEquations, points: Floats, value: float, departure: Departure
) -> Iterator[Obstacle]:
    """Name the likely obstacles between an orbit and its points that have left their pieces."""
    for index in departure.indices:
        yield from _of_point(equations, index, points[index], value, departure)


def _of_point(
    equations: OrbitEquations, index: int, x: float, value: float, departure: Departure
) -> Iterator[Obstacle]:
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
) -> Obstacle | None:
    """Find the first break between a point on a piece and one that is not; None if none is seen."""
    lo, hi = f.domain
    if not lo <= inside <= hi:
        return None
    side = -1 if outside > inside else 1
    left_domain = not lo <= outside <= hi
    end = piece_end(f, piece, inside, min(max(outside, lo), hi))
    if end is None:
        return Obstacle(index, "end", DomainEnd(side)) if left_domain else None
    border = _settled(end, f)
    beyond = border.right_label if side < 0 else border.left_label
    return Obstacle(index, border.kind, BorderWall(border, side, frozenset(piece)), beyond)


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


def unlabelled_obstacles(f: MapFamily, points: Floats) -> list[Obstacle]:
    """Look for breaks that no label tells of, close to points of an orbit, the nearest first."""
    found: list[tuple[float, Obstacle]] = []
    half = NEARBY * domain_width(f)
    for index, x in enumerate(points.tolist()):
        for b in branch_table(WindowMap(f, (x - half, x + half))).breakpoints:
            if b.kind != "smooth":
                side = -1 if b.d > x else 1
                border = TrackedDiscontinuity.of(b)
                beyond = border.right_label if side < 0 else border.left_label
                wall = BorderWall(border, side)
                found.append((abs(b.d - x), Obstacle(index, b.kind, wall, beyond)))
    return [obstacle for _, obstacle in sorted(found, key=lambda pair: pair[0])]
