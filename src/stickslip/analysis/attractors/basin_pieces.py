"""Pieces of a domain, decided and undecided, refined by comparing each with its image.

Each edge remembers which first edge it is a preimage of: docs/theory/attractors.md.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from stickslip.analysis.attractors.bands import end_values, image, inside, merged
from stickslip.analysis.attractors.in_space.fates import LEFT, UNDECIDED, UNFOLLOWED
from stickslip.analysis.attractors.recurrence import (
    Cycle,
    capture_radius,
    confirmed,
    share_left,
    turns_that_tell,
)
from stickslip.analysis.branches.pieces import runs
from stickslip.analysis.maps.protocol import EXACT, SAME, advance, domain_width, values_and_slopes
from stickslip.analysis.scales import BLOCK, HALVINGS, NEARBY, RECOGNISED
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.branches.laps import Laps
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Bools, Floats, Integers, Map1D


MAX_PERIOD: Final = 16  # unstable orbits that are recognised
RESOLUTION: Final = 1e-5  # of the domain's width: of pieces, and of edges' orbits that recur
MAX_SLIVERS: Final = 2000  # edges that are followed; more occur only among interwoven basins

# Where motions are given up, or come there: as decided as it ever will be.
LOST: Final = UNFOLLOWED

Source = Literal["orbit", "breakpoint", "gap", "domain", "unresolved"]


@dataclass(frozen=True)
class Pieces:
    """Consecutive pieces of a domain, from left to right; no one-sided value is computed twice."""

    edges: Floats  # shape (n + 1,)
    index: Integers  # place of the attractor, or `UNDECIDED`, or `LEFT`, or `LOST`
    lap: Integers  # that holds an undecided piece
    value_left: Floats  # limits of the map at the ends, from inside
    value_right: Floats
    # which of the first edges each edge is a preimage of, and in how many steps; (n + 1,)
    source: Integers
    order: Integers

    def count_undecided(self) -> int:
        """Return the number of undecided pieces."""
        return int(np.sum(self.index == UNDECIDED))

    def open_length(self) -> float:
        """Return the length of all undecided pieces together."""
        return float(np.diff(self.edges)[self.index == UNDECIDED].sum())

    def fate(self, x: Floats) -> Integers:
        """Index of the pieces that hold points; `LEFT` without one."""
        k = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, len(self.index) - 1)
        return np.where(np.isfinite(x), self.index[k], LEFT)

    def same_as(self, other: Pieces) -> bool:
        """Tell whether nothing has changed."""
        return np.array_equal(self.edges, other.edges) and np.array_equal(self.index, other.index)

    def joined(self) -> Pieces:
        """Join neighbours that know the same; undecided ones only inside one lap."""
        keep = np.diff(self.edges) > 0
        index, lap = self.index[keep], self.lap[keep]
        differs = index[1:] != index[:-1]
        differs |= (index[1:] == UNDECIDED) & (lap[1:] != lap[:-1])
        first, last = np.append(True, differs), np.append(differs, True)
        edges, source, order = (
            np.append(a[:-1][keep][first], a[-1]) for a in (self.edges, self.source, self.order)
        )
        sides = self.value_left[keep][first], self.value_right[keep][last]
        return Pieces(edges, index[first], lap[first], *sides, source, order)


def spread_over_open(edges: Floats, index: Integers, shares: Floats) -> Floats:
    """Points of what is not proved, one at a share (0 to 1) of each of as many equal parts."""
    open_ = np.flatnonzero(np.isin(index, (UNDECIDED, LOST)))
    ends = np.cumsum(np.diff(edges)[open_])
    place = ends[-1] * (np.arange(len(shares)) + shares) / len(shares)
    k = np.clip(np.searchsorted(ends, place, side="right"), 0, len(open_) - 1)
    return np.asarray(edges[open_[k] + 1] - (ends[k] - place))


def first_pieces(f: Map1D, branches: BranchTable, known: Sequence[Attractor]) -> Pieces:
    """Cut the domain at the ends of laps, known and unknown ones, and around the attractors."""
    table, unknown, lost = branches.laps, branches.unknown, branches.given_up
    traps = [_trap(f, table, attractor) for attractor in known]
    # What is unknown may lie in a gap: the laps on both sides do not show where it ends.
    inner = (one.ravel() for one in (unknown, lost, *traps))
    cuts = np.concatenate([table.left, table.right, *inner])
    low, high = f.domain
    edges = np.unique(np.concatenate([[low, high], cuts[(cuts > low) & (cuts < high)]]))
    middle = 0.5 * (edges[:-1] + edges[1:])
    lap = table.locate(middle)
    index = np.where((lap >= 0) | inside(unknown, middle), UNDECIDED, LEFT)
    index[(lap < 0) & inside(lost, middle)] = LOST
    for k, trap in enumerate(traps):
        index[inside(trap, middle)] = k
    in_lap, ends = lap >= 0, np.array([edges[:-1], edges[1:]])
    at_left, at_right = np.full(ends.shape, np.nan)
    at_left[in_lap], at_right[in_lap] = end_values(f, table, lap[in_lap], ends[:, in_lap])
    number = np.arange(len(edges))
    # Not joined: the first edges are what `source` counts.
    return Pieces(edges, index, lap, at_left, at_right, number, np.zeros_like(number))


def _trap(f: Map1D, table: Laps, attractor: Attractor) -> Floats:
    """Intervals that belong to the attractor's basin for certain; none for undecided ones."""
    if attractor.kind in ("chaotic", "neutral"):
        return attractor.bands
    nothing = np.empty((0, 2))
    if attractor.kind != "periodic" or attractor.orbit is None:
        return nothing
    cycle = confirmed(f, attractor.orbit.points)
    if cycle is None:
        return nothing
    # On a corner the slope of either side may be met.
    cycle = replace(cycle, multiplier=attractor.orbit.multiplier)
    centre, radius = cycle.points[0], 0.5 * capture_radius(f, cycle)
    low, high = f.domain
    while radius > EXACT * (high - low):
        start = np.array([[max(centre - radius, low), min(centre + radius, high)]])
        images = _images(f, table, start, cycle.period)
        if images is not None and _shrinks(f, table, cycle, start, images[-1]):
            trap = merged(np.concatenate([start, *images[:-1]]), 0.0)
            return _grown(f, table, cycle, trap[trap[:, 0] < trap[:, 1]])
        radius *= 0.5
    return nothing


def _shrinks(f: Map1D, table: Laps, cycle: Cycle, start: Floats, after: Floats) -> bool:
    """Tell whether all of an interval is drawn to a cycle, one turn after another."""
    # What is mapped into itself alone may hold another attractor.
    if after[0, 0] < start[0, 0] or after[0, 1] > start[0, 1]:
        return False
    turns = turns_that_tell(cycle)
    least = share_left(cycle) ** turns * np.ptp(start) + SAME * domain_width(f)
    for _ in range(turns - 1):
        if np.ptp(after) <= least:
            break
        images = _images(f, table, after, cycle.period)
        if images is None:
            return False
        after = images[-1]
    return bool(np.ptp(after) <= least)


def _grown(f: Map1D, table: Laps, cycle: Cycle, trap: Floats) -> Floats:
    """Widen a trap by intervals beside the cycle that are monotonically carried into it."""
    # An end whose orbit shares all laps with the cycle's: the interval between the last points
    # decides.
    low, high = f.domain
    period, lasting = cycle.period, min(max(abs(cycle.multiplier), 0.1), 0.999)
    passes = np.log(np.diff(trap).min() / (high - low)) / np.log(lasting)
    steps = period * int(np.ceil(min(passes, BLOCK / period)))
    reach = np.outer([-1.0, 1.0], 0.5 ** np.arange(1, HALVINGS + 1)).ravel() * (high - low)
    number = np.repeat(np.arange(period), len(reach))
    ends = (cycle.points[:, None] + reach).ravel()
    chosen = (ends > low) & (ends < high)
    laps = table.locate(cycle.points)
    chosen &= table.locate(ends) == laps[number]
    number, ends = number[chosen], ends[chosen]
    theirs = (number[:, None] + np.arange(steps + 1)) % period
    orbits = advance(f, ends, steps)
    together = np.all(table.locate(orbits) == laps[theirs], axis=1)
    last = np.sort(np.stack([orbits[:, -1], cycle.points[theirs[:, -1]]]), axis=0)
    part = np.searchsorted(trap[:, 0], last[0], side="right") - 1
    carried = together & (part >= 0) & (last[1] <= trap[part, 1])
    pairs = np.sort(np.stack([cycle.points[number], ends], axis=1), axis=1)[carried]
    return merged(np.concatenate([trap, pairs]), 0.0)


def _images(f: Map1D, table: Laps, interval: Floats, n: int) -> list[Floats] | None:
    """First n images of an interval; None if one falls apart or is lost."""
    images = []
    for _ in range(n):
        interval, lost = image(f, table, interval, 0.0)
        if lost or len(interval) != 1:
            return None
        images.append(interval)
    return images


def refined(f: Map1D, table: Laps, pieces: Pieces, floor: float) -> Pieces | None:
    """Cut undecided pieces at preimages, and take over what is known of images; None when done."""
    # Pieces narrower than `floor` are not cut, but follow their image if all of it has one fate.
    # The whole line: what leaves the domain, the pieces, what leaves the domain. What lies left
    # of an edge has the edge's position, what lies right of the last edge one more.
    fates = np.concatenate([[LEFT], pieces.index, [LEFT]])
    todo = np.flatnonzero((pieces.index == UNDECIDED) & (pieces.lap >= 0))
    at_a, at_b = pieces.value_left[todo], pieces.value_right[todo]
    first, last = _edges_inside(pieces.edges, at_a, at_b, EXACT * domain_width(f))
    changes = np.concatenate([[0], np.cumsum(fates[1:] != fates[:-1])])
    uniform = changes[first] == changes[last]
    wide = np.diff(pieces.edges)[todo] > floor
    chosen = np.where(uniform, fates[first] != UNDECIDED, wide)
    if not np.any(chosen):
        return None
    last = np.where(uniform, first, last)  # nothing to cut
    todo, first, last = todo[chosen], first[chosen], last[chosen]
    at_a, at_b = at_a[chosen], at_b[chosen]
    falling = at_b < at_a

    # Cuts of each piece from left to right, as positions among the edges that its image crosses.
    owner, step = runs(last - first)
    crossed = np.where(falling[owner], last[owner] - 1 - step, first[owner] + step)
    target = pieces.edges[crossed]
    a, b = pieces.edges[todo], pieces.edges[todo + 1]
    cuts = np.clip(table.inverse(pieces.lap[todo][owner], target), a[owner], b[owner])
    cuts = np.maximum.accumulate(cuts)  # rounded, those of edges side by side may change places

    part, step = runs(last - first + 1)
    fate = fates[np.where(falling[part], last[part] - step, first[part] + step)]
    starts, stops = step == 0, step == (last - first)[part]
    fresh = (
        _filled(starts, a, cuts),
        fate,
        pieces.lap[todo][part],
        _filled(starts, at_a, target),
        _filled(stops, at_b, target),
        _filled(starts, pieces.source[todo], pieces.source[crossed]),
        _filled(starts, pieces.order[todo], pieces.order[crossed] + 1),
    )
    return _with_parts(pieces, todo, fresh)


def _filled(chosen: Bools, these: Any, others: Any) -> Any:
    """Array with `these` in the chosen places and `others` in the rest, both in order."""
    result = np.empty(len(chosen), dtype=these.dtype)
    result[chosen], result[~chosen] = these, others
    return result


def _edges_inside(
    edges: Floats, at_a: Floats, at_b: Floats, slack: float
) -> tuple[Integers, Integers]:
    """Range [first, last) of the edges inside each image, those at its ends not counted."""
    low, high = np.minimum(at_a, at_b), np.maximum(at_a, at_b)
    middle = 0.5 * (low + high)
    first = np.searchsorted(edges, np.minimum(low + slack, middle), side="right")
    last = np.searchsorted(edges, np.maximum(high - slack, middle), side="left")
    return first, np.maximum(first, last)


def _with_parts(pieces: Pieces, todo: Integers, fresh: tuple[Any, ...]) -> Pieces:
    """Replace pieces by their parts; columns as in `Pieces`, of edges the left one only."""
    n = len(pieces.index)
    keep = np.ones(n, dtype=np.bool_)
    keep[todo] = False
    old = [getattr(pieces, each.name) for each in fields(pieces)]
    columns = [np.concatenate([o[:n][keep], new]) for o, new in zip(old, fresh, strict=True)]
    place = np.argsort(columns[0], kind="stable")
    # The last edge begins no piece.
    whole = (np.append(c[place], o[n:]) for c, o in zip(columns, old, strict=True))
    return Pieces(*whole).joined()


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
        elif abs(table.value_right[i] - table.value_left[i + 1]) > SAME * domain_width(f):
            causes[left] = EdgeCause("breakpoint", 0, left)
    return [causes.get(float(x), UNRESOLVED) for x in edges]


def explain(
    f: Map1D, pieces: Pieces, first: list[EdgeCause], widest: float
) -> tuple[Floats, Integers, tuple[EdgeCause, ...], int]:
    """Turn slivers below ``widest`` of the domain into edges; name the cause of every edge."""
    # Returns edges, index and causes of the rest, and how many decided pieces were too thin.
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
    orbits = advance(f, middle, RECOGNISED + MAX_PERIOD)
    slopes = np.abs(values_and_slopes(f, orbits[:, :-1])[1])
    growth = np.hstack([np.ones((len(middle), 1)), np.cumprod(slopes, axis=1)])
    errors = SAME * domain_width(f) + 0.5 * width[:, None] * growth
    known: list[Cycle] = []
    slack = SAME * domain_width(f)
    for i, orbit, error in zip(slivers, orbits, errors, strict=True):
        if cause := _orbit_cause(f, orbit, error, known):
            x = _pull_back(f, orbit[: cause.order], cause.source)
            yield int(i), min(max(x, low[i] - slack), high[i] + slack), cause


def _orbit_cause(f: Map1D, orbit: Floats, error: Floats, known: list[Cycle]) -> EdgeCause | None:
    """Find the unstable orbit that an edge's orbit follows, and when it has reached it."""
    for order in range(RECOGNISED):
        # Beyond so large an error an orbit tells nothing.
        if not np.isfinite(orbit[order + MAX_PERIOD]) or error[order] > NEARBY * domain_width(f):
            return None
        close = max(RESOLUTION * domain_width(f), error[order])
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
    close = RESOLUTION * domain_width(f)
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
