"""The shape of a map as a table: branches, breakpoints, gaps, laps; made once per map."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final, cast

import numpy as np

from stickslip.analysis.branches.breakpoints import Breakpoint, Kind, kind_of, limits_inside
from stickslip.analysis.branches.discontinuities import ACCUMULATE, Unresolved, find_discontinuities
from stickslip.analysis.branches.laps import Laps, Segments, smooth_stretches, tabulate_laps
from stickslip.analysis.branches.mesh import WIDE, Mesh, finest
from stickslip.analysis.branches.pieces import (
    Hints,
    TooManyPiecesError,
    hints_of,
    itineraries,
    pieces_of_powers,
    tolerance,
)
from stickslip.analysis.maps.protocol import (
    base_and_exponent,
    domain_size,
    domain_width,
    remembered,
)
from stickslip.checks import finite_number
from stickslip.numerics.arrays import interval_of
from stickslip.numerics.processes import travels
from stickslip.results.result import ResultList, ResultRow
from stickslip.results.table import SHOWN, aligned, more
from stickslip.status import MESSAGES

if TYPE_CHECKING:
    from stickslip.analysis.branches.discontinuities import Discontinuities
    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D

CROWD: Final = 64  # branches that are not wide, beyond which less is resolved, if that is left open
MAX_CROWD: Final = 4096  # ... or where a resolution is asked for
MANY: Final = 2048  # ways from a lap back to it: beyond, branches that are not wide are left out
SPENT: Final = 1 << 20  # events of long motions for one table of many, before less is resolved
GAP_PART: Final = 0.25  # of these in its gaps, which tell least; all in those of any other
LOCATED: Final = 1e-14  # of the domain's size: within rounding of a tie labels may flicker

NOT_FOLLOWED: Final = "motions are not followed to an end, so there may be a value"

_RESOLUTION: Final = travels(ContextVar[float | None]("resolution", default=None))


@dataclass(frozen=True, eq=False, repr=False)
class Branch(ResultRow):
    """Maximal interval of one label.

    Attributes
    ----------
    left, right : float
        Ends of the branch.
    value_left, value_right : float
        One-sided limits of the map there.
    label : int
    system : map or None
        Whose branch it is.
    """

    left: float
    right: float
    value_left: float
    value_right: float
    label: int = field(repr=False)
    system: Map1D | None = field(default=None, repr=False, compare=False)
    _column_names: ClassVar = ("left", "right", "value_left", "value_right", "label")
    _plot: ClassVar = "columns.draw_branch"
    _has_picture: ClassVar = False


@dataclass(frozen=True, eq=False, repr=False)
class BranchTable(ResultList[Branch]):
    """Branches of a map of the line, complete for everything wider than ``resolution``.

    A sequence of `Branch`, with the rest of the map's shape.

    Attributes
    ----------
    f : Map1D
    resolution : float
    branches : tuple of Branch
        Ascending; gaps lie between them where they do not touch.
    breakpoints : tuple of Breakpoint
        Ascending.
    gaps : ndarray of float, shape (k, 2)
        Open intervals without a value: last point before and first point after, or the end
        of the domain.
    turning_points : ndarray of float, shape (m,)
        Smooth extrema of the map.
    laps : Laps
        Maximal smooth monotone intervals.
    pieces : Laps
        The same, cut at every breakpoint, the harmless ones too.
    unresolved : tuple of Unresolved
        What stayed undecided, with reasons.
    n_evaluations : int
        Evaluations of the map that the table took.
    """

    f: Map1D
    resolution: float
    branches: tuple[Branch, ...]
    breakpoints: tuple[Breakpoint, ...]
    gaps: Floats
    turning_points: Floats
    laps: Laps
    pieces: Laps
    unresolved: tuple[Unresolved, ...]
    n_evaluations: int
    _texts: dict[int, str] = field(default_factory=dict, init=False, compare=False)
    _column_names: ClassVar = Branch._column_names
    _plot: ClassVar = "maps.draw_branch_table"
    _of: ClassVar = "branches"

    def __repr__(self) -> str:
        """Branches with their values, gaps, and what stayed open."""
        lines = [
            f"BranchTable: {len(self)} branches, {len(self.laps)} laps, complete above "
            f"{self.resolution:.2g}",
        ]
        g = "{:.10g}".format
        rows = [
            (g(b.left), g(b.right), g(b.value_left), g(b.value_right), self.text(b.label))
            for b in self.branches[:SHOWN]
        ]
        lines += aligned([("left", "right", "f(left+)", "f(right-)", "label"), *rows], ">>>><")
        lines += more(len(self))
        lines += [f"  gap: no value in ({lo:.12g}, {hi:.12g})" for lo, hi in self.gaps[:SHOWN]]
        lines += [f"  unresolved: {item}" for item in self.unresolved[:SHOWN]]
        return "\n".join(lines)

    @cached_property
    def unknown(self) -> Floats:
        """Intervals whose branches are too narrow to be told apart, shape (k, 2)."""
        rows = sorted((u.lo, u.hi) for u in self.unresolved if u.reason == ACCUMULATE)
        return np.array(rows, dtype=np.float64).reshape(-1, 2)

    @cached_property
    def given_up(self) -> Floats:
        """Parts of the gaps where it is not known that there is no value, shape (k, 2)."""
        rows = [(u.lo, u.hi) for u in self.unresolved if u.reason.startswith(NOT_FOLLOWED)]
        return np.array(rows, dtype=np.float64).reshape(-1, 2)

    def matters(self, number: int) -> bool:
        """Tell whether the end of a lap, by its number in `Laps`, is a break of the map."""
        return 0 <= number < len(self.breakpoints) and self.breakpoints[number].kind != "smooth"

    def labels_at(self, x: Floats) -> Labels:
        """Label of the branch of each point, 0 in a gap; nothing is evaluated."""
        lefts = np.array([b.left for b in self.branches])
        rights = np.array([b.right for b in self.branches])
        labels = np.array([b.label for b in self.branches] + [0], dtype=np.uint64)
        return labels[interval_of(x, lefts, rights)]

    def text(self, label: int) -> str:
        """Itinerary of a branch in the map's own words, if it has any, else its label."""
        if label not in self._texts:
            branch = next((b for b in self.branches if b.label == label), None)
            describe = getattr(self.f, "itinerary", None)
            if branch is None or describe is None:
                self._texts[label] = str(label)
            else:
                self._texts[label] = str(describe(0.5 * (branch.left + branch.right)))
        return self._texts[label]

    def _columns(self) -> Mapping[str, Any]:
        return {**super()._columns(), "itinerary": [self.text(b.label) for b in self]}


@contextmanager
def tables_complete_above(resolution: float) -> Iterator[None]:
    """Make many tables inside: with this resolution if none is asked, and less for long motions."""
    token = _RESOLUTION.set(resolution)
    try:
        yield
    finally:
        _RESOLUTION.reset(token)


def branch_table(f: Map1D, resolution: float | None = None) -> BranchTable:
    """Return the table of a map, from memory if it was made before and the map still lives."""
    # Without a resolution less is resolved where branches crowd.
    lo, hi = f.domain
    crowd, events = MAX_CROWD, (math.inf, math.inf)
    if resolution is None:
        found = _RESOLUTION.get()
        events = (math.inf, SPENT) if found is None else (SPENT, GAP_PART * SPENT)
        resolution, crowd = min(found or finest(f), WIDE * (hi - lo)), CROWD
    resolution = finite_number("resolution", resolution)
    if not 0 < resolution <= WIDE * (hi - lo):
        raise ValueError(
            f"resolution = {resolution!r}: a positive number, at most a thousandth of the "
            f"domain's width {hi - lo:.6g}, is needed."
        )
    return _make_table(f, resolution, crowd, events)


@remembered
def _make_table(
    f: Map1D, resolution: float, crowd: int, events: tuple[float, float]
) -> BranchTable:
    base, exponent = base_and_exponent(f)
    hints, unresolved = Hints.none(), list[Unresolved]()
    if exponent > 1:
        table = branch_table(base, None if crowd == CROWD else resolution)
        resolution, crowd = max(resolution, table.resolution), MAX_CROWD
        hints, unresolved = _hints(f, table, exponent)
    mesh = Mesh(f, resolution, crowd, hints.seeds, *events)
    cuts, too_many = find_discontinuities(mesh)
    unresolved += too_many
    breaks, segments = _classify(mesh, cuts, hints)
    stretches = smooth_stretches(mesh, segments)
    gaps = _gaps(segments, unresolved)
    unresolved += _given_up(mesh, gaps)
    return BranchTable(
        f=f,
        resolution=mesh.resolution,
        branches=_branches(f, segments),
        breakpoints=tuple(breaks),
        gaps=gaps,
        turning_points=np.concatenate([s.x[s.turns] for s in stretches] or [np.empty(0)]),
        laps=tabulate_laps(mesh, stretches, segments, harmless=False),
        pieces=tabulate_laps(mesh, stretches, segments, harmless=True),
        unresolved=tuple(unresolved),
        n_evaluations=mesh.n_evaluations,
    )


def _hints(f: Map1D, table: BranchTable, exponent: int) -> tuple[Hints, list[Unresolved]]:
    """Ask the table of the base map what a power f of it looks like."""
    try:
        *_, pieces = pieces_of_powers(table.pieces, exponent)
    except TooManyPiecesError as reason:
        lo, hi = f.domain
        return Hints.none(), [Unresolved(f"{reason}: sampled without their help", lo, hi)]
    return hints_of(pieces, len(table.breakpoints)), list(table.unresolved)


def _classify(mesh: Mesh, cuts: Discontinuities, hints: Hints) -> tuple[list[Breakpoint], Segments]:
    """Take limits at all cuts and drop those that are none: same label, smooth across."""
    first, last = cuts.starts, cuts.ends
    n, inward = len(first), np.repeat([1.0, -1.0], len(first))
    limits = limits_inside(mesh, first.joined(last), inward, np.tile(last.x - first.x, 2))
    at_first = hints.sharpened(first.x, limits.take(slice(0, n)), at_starts=True)
    at_last = hints.sharpened(last.x, limits.take(slice(n, None)), at_starts=False)
    width = cuts.right.x - cuts.left.x
    kinds = np.array(
        kind_of(mesh, at_last.take(slice(0, -1)), at_first.take(slice(1, None)), width)
    )
    false = (kinds == "smooth") & (cuts.left.label == cuts.right.label)
    if false.any():
        return _classify(mesh, cuts.take(~false), hints)
    # One float per break, the first one right of it that has a value; beside 0 it is 0.
    where = np.where((cuts.left.x == 0) | ~cuts.right.ok, cuts.left.x, cuts.right.x)
    # What lies within a bracket is not known: there the limits are those at its ends.
    close = width <= LOCATED * domain_size(mesh.f)
    at_first = at_first.moved(np.append(0.0, np.where(close, where - cuts.right.x, 0.0)))
    at_last = at_last.moved(np.append(np.where(close, where - cuts.left.x, 0.0), 0.0))
    segments = Segments(first, last, at_first, at_last, where, kinds == "smooth")
    breaks = [
        Breakpoint(
            d=float(where[i]),
            left=float(at_last.value[i]),
            right=float(at_first.value[i + 1]),
            left_slope=float(at_last.slope[i]),
            right_slope=float(at_first.slope[i + 1]),
            kind=cast("Kind", str(kinds[i])),
            left_label=int(cuts.left.label[i]),
            right_label=int(cuts.right.label[i]),
            interval=(float(cuts.left.x[i]), float(cuts.right.x[i])),
            quality="located" if close[i] else "bracketed",
            scatter=(float(at_last.scatter[i]), float(at_first.scatter[i + 1])),
        )
        for i in range(len(cuts))
    ]
    return breaks, segments


def _branches(f: Map1D, segments: Segments) -> tuple[Branch, ...]:
    first, last = segments.first, segments.last
    return tuple(
        Branch(
            float(first.x[i]),
            float(last.x[i]),
            float(segments.at_first.value[i]),
            float(segments.at_last.value[i]),
            int(first.label[i]),
            f,
        )
        for i in np.flatnonzero(first.ok)
    )


def _gaps(segments: Segments, unresolved: list[Unresolved]) -> Floats:
    """Intervals without a value, from the last point before to the first one after."""
    first, last = segments.first, segments.last
    rows = [
        (
            last.x[i - 1] if i > 0 else first.x[i],
            first.x[i + 1] if i + 1 < len(first) else last.x[i],
        )
        for i in np.flatnonzero(~first.ok)
    ]
    unknown = {(item.lo, item.hi) for item in unresolved if item.reason == ACCUMULATE}
    gaps = [row for row in rows if row not in unknown]
    return np.array(gaps, dtype=np.float64).reshape(-1, 2)


def _given_up(mesh: Mesh, gaps: Floats) -> Iterator[Unresolved]:
    """Tell of gaps between which points, as far as others have shown, motions were given up."""
    points = np.array(sorted(mesh.given_up))
    x = mesh.nodes.x
    for lo, hi in gaps.tolist():
        inside = points[(points >= lo) & (points <= hi)].tolist()
        if inside:
            why = Counter(mesh.given_up[point] for point in inside).most_common(1)[0][0]
            before, after = (
                np.searchsorted(x, inside[0]) - 1,
                np.searchsorted(x, inside[-1], "right"),
            )
            yield Unresolved(
                f"{NOT_FOLLOWED} ({MESSAGES[why]}), in",
                max(lo, float(x[max(before, 0)])),
                min(hi, float(x[min(after, len(x) - 1)])),
            )


def resolution_of_lists(table: BranchTable, max_period: int) -> float:
    """Return a resolution at which orbits up to a period are few enough to be followed."""
    # Where branches accumulate and each leads to all others, there are ever more of them.
    widest = WIDE * domain_width(table.f)
    all_wide = all(branch.right - branch.left >= widest for branch in table)
    few = all_wide or itineraries(table.pieces, max_period) <= MANY
    return table.resolution if few else widest


def preimages(f: Map1D, x: float) -> Floats:
    """Return all y with f(y) = x, ascending, one per lap whose closed image contains x.

    At a jump the one-sided limits count as values; of a lap where f is x throughout, both ends.

    >>> import stickslip as ss
    >>> tent = ss.PiecewiseMap(lambda x: 1 - abs(2 * x - 1), (0, 1), breakpoints=[0.5])
    >>> tent.preimages(0.5)
    array([0.25, 0.75])
    """
    value = finite_number("x", x, why="It is the value whose preimages are sought.")
    laps = branch_table(f).laps
    slack = tolerance(laps)
    reached = np.flatnonzero((laps.value_min <= value + slack) & (laps.value_max >= value - slack))
    flat = laps.direction[reached] == 0
    points = np.concatenate(
        [
            laps.inverse(reached[~flat], np.full(np.count_nonzero(~flat), value)),
            laps.left[reached[flat]],
            laps.right[reached[flat]],
        ]
    )
    points.sort()
    apart = np.ones(len(points), dtype=bool)
    apart[1:] = np.diff(points) > slack
    return points[apart]
