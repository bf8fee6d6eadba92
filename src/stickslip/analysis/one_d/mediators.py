"""Unstable orbits beside the bands of a chaotic attractor: what its edges may run into."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.one_d.borders import Border, TurningPoint
from stickslip.analysis.protocol import domain_width
from stickslip.analysis.recurrence import confirmed

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.attractor import Attractor
    from stickslip.analysis.one_d.borders import Critical
    from stickslip.analysis.one_d.interpolated import InterpolatedMap
    from stickslip.analysis.one_d.table import BranchTable
    from stickslip.analysis.protocol import Floats, Map1D

__all__ = ["Edge", "edges_of", "mediators"]

SAMPLES: Final = 128  # points on either half of a gap, closer and closer towards its ends
NEAREST: Final = 1e-7  # of the gap: the first point's distance from an end
SLACK: Final = 1e-9  # of the domain's width: an orbit this close to another is the same
NEIGHBOURS: Final = 4  # unstable orbits beside an edge that are worth trying


@dataclass(frozen=True)
class Edge:
    """An edge of a chaotic attractor's bands, and the free interval beside it.

    Attributes
    ----------
    x : float
    critical : Border or TurningPoint
        What it is an image of.
    side : int
        From which side the map is taken there, -1 or 1.
    k : int
        Number of maps.
    gap : tuple of float
        Free interval that the edge bounds: up to the next band or the end of the domain.
    outward : int
        -1 if the gap lies left of the edge, 1 if right.
    inner : bool
        Whether the gap lies between two bands of the attractor.
    """

    x: float
    critical: Critical
    side: int
    k: int
    gap: tuple[float, float]
    outward: int
    inner: bool


def edges_of(attractor: Attractor, table: BranchTable) -> list[Edge]:
    """Edges of a chaotic attractor whose source is known.

    Parameters
    ----------
    attractor : Attractor
    table : BranchTable
        Of its map.
    """
    lo, hi = table.f.domain
    ends = attractor.bands.ravel()
    around = np.concatenate([[lo], ends, [hi]])
    found = []
    for i, (x, side, k) in enumerate(attractor.sources):
        critical = _critical(table, x) if k else None
        if critical is None:
            continue
        left = i % 2 == 0
        gap = (around[i], around[i + 1]) if left else (around[i + 1], around[i + 2])
        inner = 0 < i < len(ends) - 1
        interval = (float(gap[0]), float(gap[1]))
        found.append(Edge(float(ends[i]), critical, side, k, interval, -1 if left else 1, inner))
    return found


def _critical(table: BranchTable, x: float) -> Critical | None:
    for breakpoint_ in table.breakpoints:
        if breakpoint_.d == x and breakpoint_.kind != "smooth":
            return Border.of(breakpoint_)
    return TurningPoint(x) if x in table.turning_points else None


def mediators(
    f: Map1D, fast: InterpolatedMap, edge: Edge, periods: tuple[int, ...]
) -> list[tuple[float, ...]]:
    """Find the unstable orbits with a point in the gap beside an edge, the nearest first.

    Parameters
    ----------
    f : Map1D
    fast : InterpolatedMap
        Of `f`: shows where the orbits are.
    edge : Edge
    periods : tuple of int
        That are searched.

    Returns
    -------
    list of tuple of float
        At most ``NEIGHBOURS`` orbits; each starts with its point in the gap.
    """
    same = SLACK * domain_width(f)
    lo, hi = edge.gap[0] - same, edge.gap[1] + same
    found: list[tuple[float, ...]] = []
    for start, period in _starts(fast, edge, periods, same):
        guess = fast.iterate(start, period - 1)
        if not np.all(np.isfinite(guess)):
            continue
        cycle = confirmed(f, guess)
        if cycle is None or cycle.stable or not lo <= cycle.points[0] <= hi:
            continue
        if not any(abs(points[0] - cycle.points[0]) <= same for points in found):
            found.append(tuple(cycle.points.tolist()))
        if len(found) >= NEIGHBOURS:
            break
    return sorted(found, key=lambda points: abs(points[0] - edge.x))


def _starts(
    fast: InterpolatedMap, edge: Edge, periods: tuple[int, ...], same: float
) -> Iterator[tuple[float, int]]:
    """Yield guesses of periodic points in the gap, with their periods, the nearest first."""
    lo, hi = edge.gap
    if hi - lo <= same:
        # The attractor meets the orbit just here, or fills the domain.
        images = fast.iterate(edge.x, max(periods))
        near = [p for p in periods if abs(images[p] - edge.x) <= same]
        yield from ((edge.x, p) for p in near)
        return
    x = _graded(lo, hi)
    images = fast.iterate(x, max(periods))
    for place, period in _crossings(x, images, periods, edge):
        yield _halved(fast, x[place], x[place + 1], period), period


def _graded(lo: float, hi: float) -> Floats:
    share = 0.5 * np.geomspace(NEAREST, 1.0, SAMPLES)
    return np.concatenate([lo + (hi - lo) * share, hi - (hi - lo) * share[-2::-1]])


def _crossings(
    x: Floats, images: Floats, periods: tuple[int, ...], edge: Edge
) -> list[tuple[int, int]]:
    """Cells in which some f^p crosses the diagonal, the ones nearest to the edge first."""
    places = []
    for period in periods:
        off = images[:, period] - x
        with np.errstate(invalid="ignore"):
            for place in np.flatnonzero(off[1:] * off[:-1] <= 0):
                distance = min(abs(x[place] - edge.x), abs(x[place + 1] - edge.x))
                places.append((distance, period, int(place)))
    return [(place, period) for _, period, place in sorted(places)]


def _halved(fast: InterpolatedMap, a: float, b: float, period: int) -> float:
    """Halve a bracket of a zero of f^p(x) - x; cheap on the interpolated map."""
    at_a = float(fast.iterate(a, period)[-1]) - a
    for _ in range(60):
        middle = 0.5 * (a + b)
        off = float(fast.iterate(middle, period)[-1]) - middle
        if (off < 0) == (at_a < 0):
            a = middle
        else:
            b = middle
    return 0.5 * (a + b)
