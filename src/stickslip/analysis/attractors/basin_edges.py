"""Why a basin ends where it does: each edge followed forward to the thing it is a preimage of.

The image of a basin edge is a basin edge, as long as the map is continuous there. So an edge's
orbit ends on a breakpoint, a gap or the domain's end after finitely many steps, or it stays on
edges for ever: on an unstable periodic orbit, or, between interwoven basins, on none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from stickslip.analysis.attractors.basin_pieces import UNDECIDED
from stickslip.analysis.attractors.lyapunov import advance
from stickslip.analysis.attractors.recurrence import Cycle, confirmed
from stickslip.analysis.maps.protocol import domain_width, values_and_slopes
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.attractors.basin_pieces import Pieces
    from stickslip.analysis.branches.laps import Laps
    from stickslip.analysis.maps.protocol import Floats, Map1D

    Integers = NDArray[np.int64]

MAX_ORDER: Final = 64  # preimages that are recognised
MAX_PERIOD: Final = 16  # unstable orbits that are recognised
RECURS: Final = 1e-5  # of the domain's width: an edge's orbit this close to recurring is tried
MEETS: Final = 1e-12  # of the domain's width, before errors grow with the slope along the orbit
LOST: Final = 1e-3  # of the domain's width: beyond this error an orbit tells nothing
MAX_SLIVERS: Final = 2000  # edges that are followed; more occur only among interwoven basins

Source = Literal["orbit", "breakpoint", "gap", "domain", "unresolved"]


@part
@dataclass(frozen=True)
class EdgeCause:
    """What a basin edge is a preimage of.

    Attributes
    ----------
    kind : {"orbit", "breakpoint", "gap", "domain", "unresolved"}
        An unstable periodic orbit, a jump of the map, the end of a gap, an end of the domain
        (crossed by the image), or none of these.
    order : int
        Steps of the map that take the edge there.
    source : float
        The point that is reached.
    period : int
        Of the unstable orbit; else 0.
    """

    kind: Source
    order: int = 0
    source: float = float("nan")
    period: int = 0

    def __str__(self) -> str:
        """Sentence for tables."""
        if self.kind == "unresolved":
            return "unresolved"
        text = {
            "orbit": f"unstable period-{self.period} orbit",
            "breakpoint": "breakpoint",
            "gap": "end of a gap",
            "domain": "end of the domain",
        }[self.kind]
        before = f"preimage {self.order} of " if self.order else ""
        return f"{before}{text} {self.source:.12g}"


UNRESOLVED: Final = EdgeCause("unresolved")


def first_causes(f: Map1D, table: Laps, edges: Floats) -> list[EdgeCause]:
    """Name the first edges: ends of the domain, of gaps, jumps; the rest explain nothing."""
    causes = {float(x): EdgeCause("domain", 0, float(x)) for x in f.domain}
    for i in range(len(table) - 1):
        right, left = float(table.right[i]), float(table.left[i + 1])
        if left > right:
            causes |= {x: EdgeCause("gap", 0, x) for x in (right, left)}
        elif abs(table.value_right[i] - table.value_left[i + 1]) > MEETS * domain_width(f):
            causes[left] = EdgeCause("breakpoint", 0, left)
    return [causes.get(float(x), UNRESOLVED) for x in edges]


def explain(
    f: Map1D, pieces: Pieces, first: list[EdgeCause], widest: float
) -> tuple[Floats, Integers, tuple[EdgeCause, ...], int]:
    """Turn slivers into edges and name the cause of every edge, the domain's ends included.

    ``first`` causes are counted by ``pieces.source``; pieces below ``widest`` of the domain are
    parts of edges. Returns edges, index and causes of the rest, and how many decided pieces were
    too thin.
    """
    wide = np.diff(pieces.edges) > widest * domain_width(f)
    thin = int(np.sum(~wide & (pieces.index != UNDECIDED)))
    number, index = np.flatnonzero(wide), pieces.index[wide]
    differs = np.flatnonzero(index[1:] != index[:-1])
    # An edge is a bracket: from the end of a wide piece to the start of the next one.
    start, stop = number[differs] + 1, number[differs + 1]
    low, high = pieces.edges[start], pieces.edges[stop]
    exact = [
        replace(first[s], order=int(o)) if first[s].kind != "unresolved" else UNRESOLVED
        for s, o in zip(pieces.source[stop], pieces.order[stop], strict=True)
    ]
    index = index[np.append(True, np.diff(index) != 0)]
    # A sliver that rounding has closed leaves an edge that only its orbit explains.
    open_ = (high > low) | np.array([cause is UNRESOLVED for cause in exact], dtype=np.bool_)
    slivers = np.flatnonzero(open_ & (index[:-1] != UNDECIDED) & (index[1:] != UNDECIDED))
    inner = 0.5 * (low + high)
    for i, x, cause in _sliver_causes(f, slivers[:MAX_SLIVERS], low, high):
        inner[i], exact[i] = x, cause
    outer = [EdgeCause("domain", 0, float(x)) for x in f.domain]
    edges = np.concatenate([[f.domain[0]], inner, [f.domain[1]]])
    return edges, index, (outer[0], *exact, outer[1]), thin


def _sliver_causes(
    f: Map1D, slivers: Integers, low: Floats, high: Floats
) -> Iterator[tuple[int, float, EdgeCause]]:
    """Follow the slivers: those whose orbit reaches an unstable cycle are its preimages."""
    middle, width = 0.5 * (low + high)[slivers], (high - low)[slivers]
    orbits = advance(f, middle, MAX_ORDER + MAX_PERIOD)
    slopes = np.abs(values_and_slopes(f, orbits[:, :-1])[1])
    growth = np.hstack([np.ones((len(middle), 1)), np.cumprod(slopes, axis=1)])
    errors = MEETS * domain_width(f) + 0.5 * width[:, None] * growth
    known: list[Cycle] = []
    slack = MEETS * domain_width(f)
    for i, orbit, error in zip(slivers, orbits, errors, strict=True):
        if cause := _orbit_cause(f, orbit, error, known):
            x = _pull_back(f, orbit[: cause.order], cause.source)
            yield int(i), min(max(x, low[i] - slack), high[i] + slack), cause


def _orbit_cause(f: Map1D, orbit: Floats, error: Floats, known: list[Cycle]) -> EdgeCause | None:
    """Find the unstable orbit that an edge's orbit follows, and when it has reached it."""
    for order in range(MAX_ORDER):
        if not np.isfinite(orbit[order + MAX_PERIOD]) or error[order] > LOST * domain_width(f):
            return None
        close = max(RECURS * domain_width(f), error[order])
        for period in range(1, MAX_PERIOD + 1):
            if abs(orbit[order + period] - orbit[order]) > close:
                continue
            cycle = _cycle_at(f, orbit[order : order + period], known)
            if cycle is None or cycle.stable:
                continue
            source = float(cycle.points[np.argmin(np.abs(cycle.points - orbit[order]))])
            if abs(source - orbit[order]) <= error[order]:
                return EdgeCause("orbit", order, source, cycle.period)
    return None


def _cycle_at(f: Map1D, points: Floats, known: list[Cycle]) -> Cycle | None:
    close = RECURS * domain_width(f)
    for cycle in known:
        if len(points) % cycle.period == 0 and np.min(np.abs(cycle.points - points[0])) <= close:
            return cycle
    found = confirmed(f, points)
    if found is not None:
        known.append(found)
    return found


def _pull_back(f: Map1D, orbit: Floats, target: float) -> float:
    """Solve f^k(x) = target next to an orbit, one step of the map after the other."""
    low, high = f.domain
    for x in orbit[::-1]:
        at = float(x)
        for _ in range(4):
            value, slope = (float(one[0]) for one in values_and_slopes(f, np.array([at])))
            excess = value - target
            if not np.isfinite(excess) or slope == 0 or excess == 0:
                break
            at = min(max(at - excess / slope, low), high)
        target = at
    return target
