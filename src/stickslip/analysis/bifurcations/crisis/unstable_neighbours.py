"""What the edges of a chaotic attractor may run into: unstable orbits, breaks, domain ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.attractors.attractors import MAX_PERIOD
from stickslip.analysis.attractors.bands import APART
from stickslip.analysis.attractors.recurrence import confirmed
from stickslip.analysis.attractors.search import LOOK
from stickslip.analysis.bifurcations.conditions.conditions import Connection, Contact
from stickslip.analysis.branches.along.tracked import DomainEnd, TrackedDiscontinuity, TurningPoint
from stickslip.analysis.maps.protocol import Bools, Floats, domain_width
from stickslip.numerics.zeros import halved

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import ArrayLike

    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.branches.along.tracked import Critical
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.interpolation.interpolated import InterpolatedMap

SAMPLES: Final = 128  # points on either half of a gap, closer and closer towards its ends
NEAREST: Final = 1e-7  # of the gap: the first point's distance from an end
CUTS: Final = 2  # of a bracket of an orbit ...
PARTS: Final = 64  # ... into so many: many points take hardly longer than one
STEPS_OUT: Final = 32  # from an edge to the other end of its gap
ON_BORDER: Final = 1e-6  # of the domain's width: points this close belong to one orbit there
AT_ONCE: Final = 8  # edges beyond which the border of a basin is looked for together
NEIGHBOURS: Final = 2  # unstable orbits beside an edge that are worth trying


@dataclass(frozen=True)
class Edge:
    """An edge of a chaotic attractor's bands, and the free interval beside it."""

    x: float
    critical: Critical  # what it is an image of
    side: int  # from which side the map is taken there, -1 or 1
    k: int  # number of maps
    gap: tuple[float, float]  # free interval up to the next band or the end of the domain
    width: float  # of the band that it bounds
    n_gaps: int  # between bands, if this one is: an orbit in it has no more points; else 0


def edges_of(attractor: Attractor, table: BranchTable) -> list[Edge]:
    """Edges of a chaotic attractor whose source is known."""
    lo, hi = table.f.domain
    ends = attractor.bands.ravel()
    around = np.concatenate([[lo], ends, [hi]])
    found, last = [], len(ends) - 1
    for i, (x, side, k) in enumerate(attractor.sources):
        critical = _critical(table, x) if k else None
        if critical is None:
            continue
        left = i % 2 == 0
        gap = (around[i], around[i + 1]) if left else (around[i + 1], around[i + 2])
        low, high = attractor.bands[i // 2]
        interval = (float(gap[0]), float(gap[1]))
        n_gaps = last // 2 if 0 < i < last else 0
        found.append(Edge(float(ends[i]), critical, side, k, interval, float(high - low), n_gaps))
    return found


def _critical(table: BranchTable, x: float) -> Critical | None:
    for breakpoint_ in table.breakpoints:
        if breakpoint_.d == x and breakpoint_.kind != "smooth":
            return TrackedDiscontinuity.of(breakpoint_)
    return TurningPoint(x) if x in table.turning_points else None


@dataclass(frozen=True)
class Meeting:
    """An edge and what lies beside it; see `meetings` and `borders_beside`."""

    edge: Edge
    x: float  # what may be met there
    met: tuple[float, ...] | TrackedDiscontinuity | DomainEnd  # an orbit, this point first; or that

    @property
    def condition(self) -> Connection | Contact:
        """That the edge is there."""
        source = self.edge.critical, self.edge.side, self.edge.k
        if isinstance(self.met, tuple):
            return Connection(*source, self.met)
        return Contact(*source, self.met)


def borders_beside(table: BranchTable, edges: Iterable[Edge]) -> Iterator[Meeting]:
    """Find the nearest break beside each edge beyond which orbits go elsewhere, or have left."""
    breaks = [item for item in table.breakpoints if item.kind in ("jump", "edge")]
    slack = APART * domain_width(table.f)
    for edge in edges:
        lo, hi = edge.gap
        beside = [item for item in breaks if lo - slack <= item.d <= hi + slack]
        if beside:
            nearest = min(beside, key=lambda item: abs(item.d - edge.x))
            yield Meeting(edge, nearest.d, TrackedDiscontinuity.of(nearest))
        for upper, end in enumerate(table.f.domain):
            if end in edge.gap:
                yield Meeting(edge, end, DomainEnd(bool(upper), end))


def meetings(
    fast: InterpolatedMap, edges: Iterable[Edge], periods: tuple[int, ...]
) -> Iterator[Meeting]:
    """Find the closest unstable orbits beside each edge, their point there first."""
    same = APART * domain_width(fast)
    places = [place for edge in edges for place in _places(fast, edge, periods, same)]
    found: dict[float, list[float]] = {}
    for place in sorted(places, key=lambda place: place.distance):
        known = found.setdefault(place.edge.x, [])
        if len(known) >= NEIGHBOURS:
            continue
        points = _polished(fast, place, same)
        if points is not None and all(abs(points[0] - x) > same for x in known):
            known.append(points[0])
            yield Meeting(place.edge, points[0], points)


def late(fast: InterpolatedMap, x: ArrayLike) -> Floats:
    """Follow orbits, and return the half of them that tells where they go."""
    return fast.iterate(x, LOOK)[..., LOOK // 2 :]


def on_border(
    fast: InterpolatedMap, attractor: Attractor, edges: Sequence[Edge]
) -> Iterator[Meeting]:
    """Find the orbits, of any period, on the border of an attractor's basin beside its edges."""

    def stays(x: Floats) -> Bools:
        return np.asarray(attractor.contains(late(fast, x)).all(axis=-1))

    same = ON_BORDER * domain_width(fast)
    share = np.concatenate([[0.0], np.geomspace(NEAREST, 1.0, STEPS_OUT)])
    # Some at a time: mostly the first few are all that is asked for.
    for start in range(0, len(edges), AT_ONCE):
        some = edges[start : start + AT_ONCE]
        near = np.array([edge.x for edge in some])
        ends = np.array([edge.gap for edge in some])
        far = np.where(near == ends[:, 0], ends[:, 1], ends[:, 0])
        x = near[:, None] + (far - near)[:, None] * share
        leaves = ~stays(x[:, 1:])
        k = np.flatnonzero(leaves.any(axis=1))
        first = leaves[k].argmax(axis=1)
        inside, outside = halved(stays, x[k, first], x[k, first + 1], np.finfo(np.float64).nmant)
        paths = fast.iterate(np.stack([inside, outside], axis=-1), LOOK)
        for place, (one, other) in zip(k.tolist(), paths, strict=True):
            parted = ~(np.abs(one - other) <= same)
            path = one[: int(np.append(parted, True).argmax())]
            back = np.flatnonzero(np.abs(path[1:] - path[:1]) <= same)
            cycle = confirmed(fast, path[: back[0] + 1]) if back.size else None
            if cycle is not None and not cycle.stable:
                points: list[float] = cycle.points.tolist()
                yield Meeting(some[place], points[0], tuple(points))


@dataclass(frozen=True)
class _Place:
    """Where a power of the interpolated map crosses the diagonal beside an edge."""

    edge: Edge
    bracket: tuple[float, float]
    period: int
    distance: float


def _places(
    fast: InterpolatedMap, edge: Edge, periods: tuple[int, ...], same: float
) -> list[_Place]:
    lo, hi = edge.gap
    if hi - lo <= same:
        # The attractor meets the orbit just here, or fills the domain.
        images = fast.iterate(edge.x, max(periods))
        near = [p for p in periods if abs(images[p] - edge.x) <= same]
        return [_Place(edge, (edge.x, edge.x), p, 0.0) for p in near]
    share = 0.5 * np.geomspace(NEAREST, 1.0, SAMPLES)
    x = np.concatenate([lo + (hi - lo) * share, hi - (hi - lo) * share[-2::-1]])
    # Bands whose gaps one orbit visits merge there all at once, however long it is.
    tried = np.array(sorted({*periods, *range(1, min(edge.n_gaps, MAX_PERIOD) + 1)}))
    off = fast.iterate(x, tried[-1])[:, tried] - x[:, None]
    with np.errstate(invalid="ignore"):
        crossed = off[1:] * off[:-1] <= 0
    width = max(edge.width, same)  # a band that just meets a break has another of no width
    distances = np.minimum(np.abs(x[1:] - edge.x), np.abs(x[:-1] - edge.x)) / width
    brackets = np.flatnonzero(crossed.any(axis=1))
    places: list[_Place] = []
    for k in brackets[np.argsort(distances[brackets], kind="stable")].tolist():
        if len(places) >= 2 * NEIGHBOURS:
            break
        known: list[int] = []
        for period in tried[crossed[k]].tolist():
            if period in periods or all(period % shorter for shorter in known):
                known.append(period)
        bracket = (float(x[k]), float(x[k + 1]))
        places += [_Place(edge, bracket, period, float(distances[k])) for period in known]
    return places[: 2 * NEIGHBOURS]


def _polished(fast: InterpolatedMap, place: _Place, same: float) -> tuple[float, ...] | None:
    """Solve for the orbit on the interpolated map; None if it is stable or elsewhere."""
    guess = fast.iterate(_narrowed(fast, *place.bracket, place.period), place.period - 1)
    cycle = confirmed(fast, guess) if np.all(np.isfinite(guess)) else None
    if cycle is None or cycle.stable:
        return None
    lo, hi = place.edge.gap
    points: list[float] = cycle.points.tolist()
    return tuple(points) if lo - same <= points[0] <= hi + same else None


def _narrowed(fast: InterpolatedMap, a: float, b: float, period: int) -> float:
    """Cut a bracket of a zero of f^p(x) - x until Newton's method can take over."""
    for _ in range(CUTS):
        x = np.linspace(a, b, PARTS + 1)
        falls = fast.iterate(x, period)[:, -1] < x
        last = int(np.argmin(np.append(falls[:-1] == falls[0], False)))
        a, b = x[last - 1 : last + 1].tolist()
    return 0.5 * (a + b)
