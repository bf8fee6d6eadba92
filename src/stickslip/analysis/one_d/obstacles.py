"""What stops an orbit that is followed along a parameter: which break of the map, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.one_d.borders import Border, ConditionLost
from stickslip.analysis.one_d.meeting import BorderWall, DomainEnd
from stickslip.analysis.one_d.table import branch_table
from stickslip.analysis.protocol import domain_width, sample
from stickslip.analysis.window import WindowMap
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.one_d.meeting import Wall
    from stickslip.analysis.orbit_equations import Departure, OrbitEquations
    from stickslip.analysis.protocol import Floats, Map1D, MapFamily

__all__ = ["Obstacle", "obstacles", "unlabelled_obstacles"]

FAN: Final = 33  # points between an orbit's point and where it has left, three times
ROUNDS: Final = 3
NEARBY: Final = 1e-4  # of the domain: where a break without a label is looked for


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A break, or an end of the domain, that a point of an orbit has come to.

    Attributes
    ----------
    index : int
        Of the point.
    kind : str
        ``jump``, ``corner``, ``edge``, ``smooth``, or ``end`` of the domain.
    wall : Wall
    beyond : int or None
        Label on the other side; None where there is no value.
    """

    index: int
    kind: str
    wall: Wall
    beyond: int | None = None


def obstacles(
    equations: OrbitEquations, points: Floats, value: float, departure: Departure
) -> Iterator[Obstacle]:
    """Name what lies between points of an orbit and those where it has left its pieces.

    Parameters
    ----------
    equations : OrbitEquations
    points : ndarray of float, shape (p,)
        Of the orbit, in its pieces.
    value : float
        Parameter there.
    departure : Departure

    Yields
    ------
    Obstacle
        At most one per point that has left.
    """
    values = (departure.value, value, 0.5 * (departure.value + value))
    for index in departure.indices:
        # Orbit and break both move: between which of their places it lies is to be tried.
        for q in values:
            f = equations.at(q)
            found = _between(f, equations.pieces[index], points[index], departure.points[index])
            if found is not None:
                yield _obstacle(index, *found, f)
                break


def _obstacle(index: int, wall: Wall, kind: str, f: MapFamily) -> Obstacle:
    if isinstance(wall, BorderWall):
        border = wall.border
        beyond = border.right_label if wall.side < 0 else border.left_label
        return Obstacle(index, kind, wall, beyond)
    return Obstacle(index, kind, wall)


def _between(
    f: MapFamily, piece: set[int], inside: float, outside: float
) -> tuple[Wall, str] | None:
    """Find the first break between a point on a piece and one that is not; None if none is seen."""
    lo, hi = f.domain
    if not lo <= inside <= hi:
        return None
    side = -1 if outside > inside else 1
    left_domain = not lo <= outside <= hi
    change = _first_change(f, piece, inside, min(max(outside, lo), hi))
    if change is None:
        return (DomainEnd(side), "end") if left_domain else None
    x, own, other = change
    left, right = (own, other) if side < 0 else (other, own)
    try:
        reading = Border(left, right, x, "jump").at(f, heirs=False)
    except ConditionLost:
        return None
    assert isinstance(reading.critical, Border)
    return BorderWall(reading.critical, side), reading.kind


def _first_change(
    f: Map1D, piece: set[int], inside: float, outside: float
) -> tuple[float, int, int | None] | None:
    """Return a place close to the first change of label, and the labels before and after it."""
    allowed = np.array(sorted(piece), dtype=np.uint64)
    for _ in range(ROUNDS):
        x = np.linspace(inside, outside, FAN)
        values = sample(f, x)
        ok = values.status == OK
        gone = np.flatnonzero(~(ok & np.isin(values.label, allowed)))
        if not gone.size or gone[0] == 0:
            return None
        first = int(gone[0])
        inside, outside = float(x[first - 1]), float(x[first])
        own = int(values.label[first - 1])
        other = int(values.label[first]) if ok[first] else None
    return 0.5 * (inside + outside), own, other


def unlabelled_obstacles(f: MapFamily, points: Floats) -> list[Obstacle]:
    """Look for breaks that no label tells of, close to points of an orbit, the nearest first."""
    found: list[tuple[float, Obstacle]] = []
    half = NEARBY * domain_width(f)
    for index, x in enumerate(points.tolist()):
        for b in branch_table(WindowMap(f, (x - half, x + half))).breakpoints:
            if b.kind != "smooth":
                side = -1 if b.d > x else 1
                border = Border.of(b)
                beyond = border.right_label if side < 0 else border.left_label
                wall = BorderWall(border, side)
                found.append((abs(b.d - x), Obstacle(index, b.kind, wall, beyond)))
    return [obstacle for _, obstacle in sorted(found, key=lambda pair: pair[0])]
