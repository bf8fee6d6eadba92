"""Images of intervals under a piecewise-monotone map, and the bands of chaotic attractors.

A short interval in a chaotic attractor grows until it fills the bands; in a transient it does not.
Where a map stretches little and cuts what it stretches, the images may for very long cover no band
at once; what all of them cover together stops growing soon.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.branches.mesh import RESOLUTION
from stickslip.analysis.maps.protocol import SAME, advance, domain_width, values_and_slopes
from stickslip.analysis.scales import BLOCK
from stickslip.numerics.arrays import interval_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.branches.laps import Laps
    from stickslip.analysis.maps.protocol import Bools, Floats, Map1D

APART: Final = RESOLUTION  # of the domain's width: closer bands are one; no table knows better
MAX_STEPS: Final = 2000  # images of the whole, until it stays as it is
AHEAD: Final = 64  # images that are looked at together, or before another interval is tried
MAX_INTERVALS: Final = 2048
LONGEST: Final = 128  # period that is recognised: costs next to nothing
GROWING: Final = f"an interval of the orbit was still growing after {MAX_STEPS} steps"
NARROW: Final = "the bands are narrower than can be told"
UNEXPLAINED: Final = "not an early image of a breakpoint or turning point"


@dataclass(frozen=True)
class Bands:
    """The set that a short interval grows into."""

    intervals: Floats  # disjoint, from left to right; shape (k, 2)
    period: int  # number of sets of bands visited in turn; 0 if the growth did not end
    # largest distance between an edge of the bands and the nearest edge of their image
    residual: float
    # for each edge, in the order of ``intervals.ravel()``, what it is an image of
    causes: tuple[str, ...]
    reason: str = ""  # empty for a trapping region, else why there is none
    # for each edge: end of a lap, side of approach (-1 left, 1 right), maps (0: unknown)
    sources: tuple[tuple[float, int, int], ...] = ()
    lowest_period: int = 0  # of an orbit in the bands: maps from one back to itself, at least

    def contain(self, x: Floats, slack: float = 0.0) -> Bools:
        """Tell which points lie in a band, with `slack` on both sides."""
        return inside(self.intervals, x, slack)


def inside(intervals: Floats, x: Floats, slack: float = 0.0) -> Bools:
    """Tell which points lie in one of the sorted disjoint intervals (k, 2)."""
    return np.asarray(interval_of(x, intervals[:, 0] - slack, intervals[:, 1] + slack) >= 0)


def merged(intervals: NDArray[Any], slack: float) -> NDArray[Any]:
    """Sort intervals and join those that overlap or come closer than `slack`."""
    if len(intervals) < 2:
        return intervals
    rows = intervals[np.argsort(intervals[:, 0], kind="stable")]
    reach = np.maximum.accumulate(rows[:, 1])
    starts = np.flatnonzero(np.concatenate([[True], rows[1:, 0] > reach[:-1] + slack]))
    ends = np.concatenate([starts[1:] - 1, [len(rows) - 1]])
    return np.array([rows[starts, 0], reach[ends]]).T


def common(intervals: Floats, left: Floats, right: Floats) -> tuple[Floats, Floats]:
    """Return the ends of what k intervals share with m others, (k, m); reversed for nothing."""
    return np.maximum(intervals[:, :1], left), np.minimum(intervals[:, 1:], right)


def image(f: Map1D, laps: Laps, intervals: Floats, slack: float) -> tuple[Floats, bool]:
    """Map a union of intervals, but for contacts below `slack`, and tell if part has no image."""
    _, images, lost = _images(f, laps, intervals, slack)
    return merged(images, slack), lost


def _images(
    f: Map1D, laps: Laps, intervals: Floats, slack: float
) -> tuple[NDArray[np.intp], Floats, bool]:
    """Images of the parts of intervals that laps cut, the interval of each, and as `image`."""
    # An end of a row for each part of an interval in a lap: the lower ones, then the upper ones.
    low, high = common(intervals, laps.left, laps.right)
    point = intervals[:, :1] == intervals[:, 1:]  # what a plateau leaves of an interval
    which, lap = ((high - low > slack) | (point & (high == low))).nonzero()
    ends = np.array([low[which, lap], high[which, lap]])
    values = end_values(f, laps, lap, ends)
    covered = np.bincount(which, weights=ends[1] - ends[0], minlength=len(intervals))
    missed = intervals[:, 1] - intervals[:, 0] - covered
    lost = bool((missed > slack * (1 + len(laps))).any())
    values.sort(axis=0)
    known = np.isfinite(values).all(axis=0)
    if not known.all():  # a hole that the search for branches did not see
        lost, which, values = True, which[known], values[:, known]
    return which, values.T, lost


def end_values(f: Map1D, laps: Laps, lap: NDArray[np.intp], ends: Floats) -> Floats:
    """Values at ends (2, m) of intervals in laps: from inside where those are ends of laps."""
    values = np.array([laps.value_left[lap], laps.value_right[lap]])
    inner = np.array([ends[0] > laps.left[lap], ends[1] < laps.right[lap]])
    if inner.any():
        values[inner] = values_and_slopes(f, ends[inner])[0]
    return values


def grow(f: Map1D, laps: Laps, intervals: Floats) -> Bands:
    """Map a short interval forward until its images repeat, and return the bands they fill.

    Of the rows of ``intervals`` the first does, but where it also grows into what only leads
    to the bands, and that stays for long.
    """
    slack = SAME * domain_width(f)
    alone = whole = _repeated(f, laps, intervals[:1], slack, BLOCK)
    for current in (alone.intervals, *intervals[1:, None]):
        # What only leads to the bands is left behind: the whole is mapped, too, until it stays.
        if whole.reason != GROWING:
            break
        union, reason = _covered(f, laps, current, slack)
        if reason:
            return replace(alone, intervals=union, reason=reason)
        whole = _repeated(f, laps, union, slack, AHEAD)
    if whole.reason == GROWING:
        whole = _repeated(f, laps, whole.intervals, slack, MAX_STEPS)
    if not whole.period:
        return whole
    turns, lowest = _turns(f, laps, whole.intervals, slack)
    whole = replace(whole, period=alone.period or turns, lowest_period=lowest)
    return whole if whole.period else replace(whole, reason=NARROW)


def _repeated(f: Map1D, laps: Laps, current: Floats, slack: float, steps: int) -> Bands:
    """Map intervals until they are what they were before: the union of what came since."""
    past: list[Floats] = []
    sizes, totals = np.zeros((2, steps + AHEAD))  # tell most sets apart at little cost
    while len(past) < steps:
        for each in _in_laps(f, laps, current):
            sizes[len(past)], totals[len(past)] = len(each), each.sum()
            past.append(each)
        current, lost = image(f, laps, past[-1], slack)
        if reason := _fault(current, lost):
            return Bands(current, 0, np.inf, (), reason)
        alike = sizes == len(current)
        alike &= np.abs(totals - current.sum()) <= slack * current.size
        alike[: max(len(past) - LONGEST, 0)] = False
        for k in np.flatnonzero(alike)[::-1]:
            if np.all(np.abs(past[k] - current) <= slack):
                parts = np.concatenate(past[k:])
                union = merged(parts, APART * domain_width(f))
                # Each edge is the image of another one, or of an end of a lap.
                intervals, sources = _explain(f, laps, union, parts.size)
                return _described(f, laps, intervals, sources, len(past) - int(k), slack)
    return Bands(current, 0, np.inf, (), GROWING)


def _in_laps(f: Map1D, laps: Laps, intervals: Floats) -> Iterator[Floats]:
    """Yield intervals; of a single one its images, too, up to the first not inside of a lap."""
    yield intervals
    if len(intervals) > 1 or not _lie_in_laps(laps, *intervals.T)[0]:
        return
    ends = np.sort(advance(f, intervals[0], AHEAD), axis=0)
    moves = _lie_in_laps(laps, *ends)[:-1] & np.isfinite(ends[1, 1:])
    n = int(np.argmin(np.append(moves, False)))
    yield from ends.T[1 : n + 1, None]


def _lie_in_laps(laps: Laps, low: Floats, high: Floats) -> Bools:
    """Tell of which intervals the ends alone tell the image."""
    lap = np.minimum(np.searchsorted(laps.right, low), len(laps) - 1)
    inside: Bools = (laps.left[lap] < low) & (high < laps.right[lap])
    return inside


def _covered(f: Map1D, laps: Laps, intervals: Floats, slack: float) -> tuple[Floats, str]:
    """Join intervals with all their images; tell, too, why that does not end."""
    union = fresh = intervals
    for _ in range(MAX_STEPS):
        images, lost = image(f, laps, fresh, slack)
        if reason := _fault(union, lost):
            return union, reason
        fresh = _outside(union, images, slack)
        if not len(fresh):
            return union, ""
        union, fresh = _ahead(f, laps, union, fresh, slack)
    return union, GROWING


def _ahead(
    f: Map1D, laps: Laps, union: Floats, fresh: Floats, slack: float
) -> tuple[Floats, Floats]:
    """Join fresh intervals, and images while these are fresh and lie in a lap; return the last."""
    # Inside of laps the ends of an interval tell its images, many at once.
    ends = advance(f, fresh.ravel(), AHEAD).reshape(-1, 2, AHEAD + 1)
    low, high = ends.min(axis=1), ends.max(axis=1)
    part = np.clip(np.searchsorted(union[:, 0] - slack, low, side="right") - 1, 0, None)
    known = (union[part, 0] - slack <= low) & (high <= union[part, 1] + slack)
    known[:, 0] = False
    moves = _lie_in_laps(laps, low, high) & ~known
    moves[:, :-1] &= np.isfinite(low[:, 1:])  # a hole that no lap shows is found by `image`
    n = np.logical_and.accumulate(moves[:, :-1], axis=1).sum(axis=1)
    passed = np.arange(AHEAD + 1) <= n[:, None]
    last = np.column_stack([end[np.arange(len(n)), n] for end in (low, high)])
    joined = merged(np.concatenate([union, np.column_stack([low[passed], high[passed]])]), slack)
    return joined, _outside(union, merged(last, slack), slack)


def _fault(intervals: Floats, lost: bool) -> str:
    if lost or len(intervals) == 0:
        return "the images of an interval around the orbit reach a gap"
    return f"more than {MAX_INTERVALS} bands" if len(intervals) > MAX_INTERVALS else ""


def _outside(known: Floats, intervals: Floats, slack: float) -> Floats:
    """Cut what is known out of intervals; both are disjoint and sorted."""
    low, high = common(intervals, np.append(-np.inf, known[:, 1]), np.append(known[:, 0], np.inf))
    there = high - low > slack
    return np.column_stack([low[there], high[there]])


def _turns(f: Map1D, laps: Laps, bands: Floats, slack: float) -> tuple[int, int]:
    """Return the greatest common divisor of all ways from a band back to itself, and the least."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import shortest_path  # slow to load, and seldom asked

    which, images, _ = _images(f, laps, bands, slack)
    low, high = common(images, *bands.T)
    part, onto = (high - low > slack).nonzero()
    start = which[part]
    meets = csr_array((np.ones(len(onto)), (start, onto)), shape=(len(bands),) * 2)
    steps = shortest_path(meets, "D", unweighted=True)
    start, onto = (end[np.isfinite(steps[0, start])] for end in (start, onto))
    least = float((steps[onto, start] + 1).min(initial=np.inf))
    if least == np.inf:
        return 0, 0
    return int(np.gcd.reduce((steps[0, start] + 1 - steps[0, onto]).astype(int))), int(least)


def on_map(f: Map1D, laps: Laps, bands: Bands) -> Bands:
    """Take bands of a stand-in over to the map, with its residual; edges of no source stay."""
    edges = bands.intervals.ravel().copy()
    known = {(x, side) for x, side, order in bands.sources if order}
    row = {source: k for k, source in enumerate(sorted(known))}
    limits = {-1: (laps.right, laps.value_right), 1: (laps.left, laps.value_left)}
    starts = np.array([limits[side][1][np.searchsorted(limits[side][0], x)] for x, side in row])
    images = advance(f, starts, max((order for *_, order in bands.sources), default=0) - 1)
    for i, (x, side, order) in enumerate(bands.sources):
        if order:
            edges[i] = images[row[x, side], order - 1]
    intervals = edges.reshape(-1, 2)
    if not np.all(np.isfinite(edges)) or np.any(np.diff(edges) < 0):
        return replace(bands, reason="edges of the bands do not keep their order")
    slack = SAME * domain_width(f)
    there = _described(f, laps, intervals, bands.sources, bands.period, slack)
    return replace(there, lowest_period=bands.lowest_period)


def _described(
    f: Map1D,
    laps: Laps,
    intervals: Floats,
    sources: tuple[tuple[float, int, int], ...],
    period: int,
    slack: float,
) -> Bands:
    again, lost = image(f, laps, intervals, slack)
    if not len(again):
        return Bands(intervals, period, np.inf, (), NARROW)
    again = merged(again, APART * domain_width(f))
    distance = np.abs(again.ravel()[:, None] - intervals.ravel())
    residual = float(max(distance.min(axis=0).max(), distance.min(axis=1).max()))
    causes = tuple(
        f"image {order} of {x:.10g}" if order else UNEXPLAINED for x, _, order in sources
    )
    reason = "part of the bands has no image" if lost else ""
    return Bands(intervals, period, residual, causes, reason, sources)


def _explain(
    f: Map1D, laps: Laps, bands: Floats, n_images: int
) -> tuple[Floats, tuple[tuple[float, int, int], ...]]:
    """Replace each edge by the earliest image of a lap's end that meets it."""
    width = domain_width(f)
    ends, values = np.append(laps.left, laps.right), np.append(laps.value_left, laps.value_right)
    sides = np.repeat([1, -1], len(laps))
    within = inside(bands, ends, SAME * width) & np.isfinite(values)
    ends, values, sides = ends[within], values[within], sides[within]
    edges = bands.ravel().copy()
    nothing = (float("nan"), 0, 0)
    if ends.size == 0:
        return bands, (nothing,) * edges.size
    images = advance(f, values, n_images - 1)
    # A break or turning point says more than an end of the domain.
    own = (ends > f.domain[0]) & (ends < f.domain[1])
    sources = []
    for i in range(edges.size):
        with np.errstate(invalid="ignore"):
            close = np.abs(images - edges[i]) <= APART * width
        near = close & own[:, None]
        near = near if near.any() else close
        if not near.any():
            sources.append(nothing)
            continue
        order = int(np.flatnonzero(near.any(axis=0))[0])
        source = int(np.flatnonzero(near[:, order])[0])
        edges[i] = images[source, order]
        sources.append((float(ends[source]), int(sides[source]), order + 1))
    return edges.reshape(-1, 2), tuple(sources)
