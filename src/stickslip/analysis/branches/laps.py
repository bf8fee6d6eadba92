"""Laps: the maximal intervals on which a map is smooth and monotone, and their inverses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Map1D, values_and_slopes
from stickslip.numerics.arrays import EPS, Columns, interval_of
from stickslip.numerics.zeros import MAX_STEPS, slope_zeros
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.branches.breakpoints import Limits
    from stickslip.analysis.branches.mesh import Mesh, Nodes


LO: Final = -1  # number of the end of a lap that is the left end of the domain
HI: Final = -2  # ... the right end

SEED_STEPS: Final = 6  # Newton steps on the interpolant, free of evaluations
SLOPE_MARGIN: Final = 1e-3  # the table's interpolants err by less than a tenth of it
GUARD: Final = 1 / 64  # of the resolution: closer to a break the map is continued linearly


@part
@dataclass(frozen=True, eq=False)
class Cells(Columns):
    """Intervals between neighbouring nodes with values and slopes at both, shapes (n,)."""

    x0: Floats
    x1: Floats
    v0: Floats
    v1: Floats
    s0: Floats
    s1: Floats

    def steepness(self, x0: Floats, x1: Floats) -> tuple[Floats, Floats]:
        """Least and largest absolute slope of the cubic interpolants between x0 and x1."""
        with np.errstate(all="ignore"):
            width = self.x1 - self.x0
            mean = (self.v1 - self.v0) / width
            b = 6 * mean - 4 * self.s0 - 2 * self.s1
            c = 3 * (self.s0 + self.s1 - 2 * mean)
            t0, t1, turn = (x0 - self.x0) / width, (x1 - self.x0) / width, -b / (2 * c)
            ends = [self.s0 + t * (b + c * t) for t in (t0, t1)]
            inside = (turn > t0) & (turn < t1)
            ends.append(np.where(inside, self.s0 + b * turn / 2, ends[0]))
        slopes = np.abs(ends)
        regular = np.isfinite(slopes).all(axis=0)
        finite = np.minimum(np.abs(self.s0), np.abs(self.s1))
        least = np.where(regular, slopes.min(axis=0), finite)
        # Slopes of a lap have one sign: where an interpolant's do not, it is close to 0.
        signs = np.sign(ends)
        least = np.where(regular & (signs.min(axis=0) < 0) & (signs.max(axis=0) > 0), 0.0, least)
        return least, np.where(regular, slopes.max(axis=0), np.inf)


@part
@dataclass(frozen=True, eq=False)
class Laps:
    """All laps (Milnor and Thurston 1988) of a map, ascending; arrays of shape (n,)."""

    # Closed: ends have one-sided limits. Outside its guards a lap is continued linearly.

    f: Map1D
    left: Floats
    right: Floats
    value_left: Floats
    value_right: Floats
    slope_left: Floats
    slope_right: Floats
    guard_left: Floats
    guard_right: Floats
    direction: Indices  # +1 rising, -1 falling, 0 constant
    end_left: Indices  # number of a breakpoint, n_breaks + that of a turning point, `LO` or `HI`
    end_right: Indices
    cells: Cells  # of all laps, one lap after the other
    first_cell: Indices  # shape (n + 1,)
    value_scale: float  # range of the map's values

    def __len__(self) -> int:
        """Return the number of laps."""
        return len(self.left)

    @property
    def value_min(self) -> Floats:
        """Lower end of each lap's image."""
        return np.minimum(self.value_left, self.value_right)

    @property
    def value_max(self) -> Floats:
        """Upper end of each lap's image."""
        return np.maximum(self.value_left, self.value_right)

    def locate(self, x: Floats) -> Indices:
        """Return the lap of each point (of two the right one); -1 in a gap or outside."""
        return interval_of(x, self.left, self.right)

    def evaluate(self, lap: Indices, x: Floats) -> tuple[Floats, Floats]:
        """Return value and slope on a lap, continued linearly across its breaks; shapes (m,)."""
        inside = np.clip(x, self.guard_left[lap], self.guard_right[lap])
        value, slope = values_and_slopes(self.f, inside)
        beyond = np.where(np.isfinite(slope), x - inside, 0.0)
        with np.errstate(invalid="ignore"):
            value = np.where(beyond == 0, value, value + slope * beyond)
        return value, slope

    def inverse(self, lap: Indices, y: Floats) -> Floats:
        """Return the point of each lap with value y, by Newton's method in a cell; else the end."""
        return self._inversion(lap, y).solve()

    def near_inverse(self, lap: Indices, y: Floats) -> Floats:
        """Return about the same from the table's interpolants: nothing is evaluated."""
        return self._inversion(lap, y).seed()

    def _inversion(self, lap: Indices, y: Floats) -> _Inversion:
        return _Inversion(self, lap, y, self.cells.take(self._cell_of_value(lap, y)))

    def steepness(self, lap: Indices, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
        """Bound the absolute slope on subintervals of laps, as sure as the table's interpolants."""
        first, last = self._cell_at(lap, lower), self._cell_at(lap, upper)
        pairs = np.column_stack([first, last + 1]).ravel()
        by_cell = self._cell_steepness
        least = np.minimum.reduceat(np.append(by_cell[0], np.inf), pairs)[::2]
        most = np.maximum.reduceat(np.append(by_cell[1], 0.0), pairs)[::2]
        # Within one cell the subinterval's own ends tell more.
        own = np.flatnonzero(first == last)
        least[own], most[own] = self.cells.take(first[own]).steepness(lower[own], upper[own])
        return least * (1 - SLOPE_MARGIN), most * (1 + SLOPE_MARGIN)

    @cached_property
    def _cell_steepness(self) -> tuple[Floats, Floats]:
        return self.cells.steepness(self.cells.x0, self.cells.x1)

    def _cell_at(self, lap: Indices, x: Floats) -> Indices:
        cell = np.searchsorted(self.cells.x0, x, side="right") - 1
        return np.clip(cell, self.first_cell[lap], self.first_cell[lap + 1] - 1)

    def _cell_of_value(self, lap: Indices, y: Floats) -> Indices:
        found = np.empty(len(lap), dtype=np.intp)
        for number in np.unique(lap):
            chosen = lap == number
            first, last = self.first_cell[number], self.first_cell[number + 1]
            sign = -1.0 if self.direction[number] < 0 else 1.0
            # Rounding may leave tiny steps back beside a turning point.
            starts = np.maximum.accumulate(sign * self.cells.v0[first:last])
            place = np.searchsorted(starts, sign * y[chosen], side="right") - 1
            found[chosen] = first + np.clip(place, 0, last - first - 1)
        return found


class _Inversion:
    """Bracketed Newton iterations for f(x) = y, one per element."""

    def __init__(self, laps: Laps, lap: Indices, y: Floats, cells: Cells) -> None:
        self.laps, self.lap, self.y, self.cells = laps, lap, y, cells
        self.lower, self.upper = cells.x0.copy(), cells.x1.copy()
        self.sign = np.where(laps.direction[lap] < 0, -1.0, 1.0)
        with np.errstate(all="ignore"):
            bend = np.abs(cells.s1 - cells.s0) / (cells.x1 - cells.x0)
        self.bend = np.where(np.isfinite(bend), bend, np.inf)

    def solve(self) -> Floats:
        x = self.seed()
        todo = np.flatnonzero(self.upper > self.lower)
        for _ in range(MAX_STEPS):
            if not todo.size:
                break
            x[todo], done = self._step(todo, x[todo])
            todo = todo[~done]
        return x

    def _step(self, k: Indices, x: Floats) -> tuple[Floats, Bools]:
        """Return better points, and which of them no further step can improve."""
        value, slope = self.laps.evaluate(self.lap[k], x)
        off = value - self.y[k]
        high = self.sign[k] * off > 0
        self.upper[k] = np.where(high, x, self.upper[k])
        self.lower[k] = np.where(high, self.lower[k], x)
        exact = np.abs(off) <= EPS * np.abs(self.y[k])
        with np.errstate(all="ignore"):
            step = -off / slope
            better = np.clip(x + step, self.lower[k], self.upper[k])
            # After a Newton step the error is step^2 f'' / (2 f').
            sharp = step**2 * self.bend[k] <= 4 * EPS * np.abs(slope * better)
            newton = sharp | (np.abs(better - x) > 0) & (better > self.lower[k]) & (
                better < self.upper[k]
            )
        middle = 0.5 * (self.lower[k] + self.upper[k])
        stuck = self.upper[k] - self.lower[k] <= 2 * np.spacing(np.abs(x))
        fresh = np.where(exact | stuck & ~newton, x, np.where(newton, better, middle))
        return fresh, exact | stuck | sharp

    def seed(self) -> Floats:
        """Solve the cubic interpolant instead: close already, and free."""
        c = self.cells
        width, rise = c.x1 - c.x0, c.v1 - c.v0
        with np.errstate(all="ignore"):
            goal = (self.y - c.v0) / rise
            goal = np.where(np.isfinite(goal), np.clip(goal, 0.0, 1.0), 0.5)
            a, b = width * c.s0 / rise, width * c.s1 / rise
            t = goal.copy()
            for _ in range(SEED_STEPS):
                off = t + t * (1 - t) * ((a - 1) * (1 - t) + (1 - b) * t) - goal
                slope = a * (1 - t) * (1 - 3 * t) + b * t * (3 * t - 2) + 6 * t * (1 - t)
                t = np.clip(t - off / slope, 0.0, 1.0)
        # Ends with an infinite slope have no cubic.
        t = np.where(np.isfinite(t), t, goal)
        return c.x0 + t * width


@dataclass(frozen=True)
class Segments:
    """What lies between neighbouring breaks; arrays of shape (n,), breaks (n - 1,)."""

    first: Nodes
    last: Nodes
    at_first: Limits
    at_last: Limits
    where: Floats  # of the breaks
    smooth: np.ndarray  # breaks that the map does not care about


@dataclass(frozen=True)
class Stretch:
    """Nodes of a smooth piece of a map, from break to break; arrays of shape (n,)."""

    x: Floats
    value: Floats
    slope: Floats
    turns: Indices  # nodes that are turning points
    numbers: tuple[int, int]  # what the stretch ends at, left and right (see `Laps`)
    guards: tuple[float, float]  # between them the map itself may be evaluated
    first_turn: int = 0  # number of turning points left of the stretch


def smooth_stretches(mesh: Mesh, segments: Segments) -> list[Stretch]:
    """Gather the nodes between breaks that matter, with a node at every turning point."""
    n = len(segments.first)
    stretches: list[Stretch] = []
    group: list[int] = []
    for i in range(n):
        if segments.first.ok[i]:
            group.append(i)
        if group and (i == n - 1 or not segments.smooth[i]):
            stretches.append(_stretch(mesh, segments, group))
            group = []
    return _with_turning_points(mesh, stretches)


def _stretch(mesh: Mesh, segments: Segments, group: list[int]) -> Stretch:
    parts = [_nodes_of(mesh, segments, i) for i in group]
    # At a break inside, both one-sided nodes agree: keep the left one.
    x, value, slope = (
        np.concatenate([parts[0][k], *(part[k][1:] for part in parts[1:])]) for k in range(3)
    )
    first, last = group[0], group[-1]
    is_lo, is_hi = first == 0, last == len(segments.first) - 1
    guard = GUARD * mesh.resolution
    at_left = 0.0 if is_lo or np.isinf(slope[0]) else guard
    at_right = 0.0 if is_hi or np.isinf(slope[-1]) else guard
    numbers = LO if is_lo else first - 1, HI if is_hi else last
    low = max(float(segments.first.x[first]), float(x[0]) + at_left)
    high = min(float(segments.last.x[last]), float(x[-1]) - at_right)
    return Stretch(x, value, slope, np.zeros(0, dtype=np.intp), numbers, (low, high))


def _nodes_of(mesh: Mesh, segments: Segments, i: int) -> tuple[Floats, Floats, Floats]:
    """Nodes of one segment: limits at its ends, and the mesh in between."""
    lo, hi = float(segments.first.x[i]), float(segments.last.x[i])
    margin = min(0.5 * mesh.resolution, 0.25 * (hi - lo))
    nodes = mesh.nodes
    inner = nodes.take((nodes.x > lo + margin) & (nodes.x < hi - margin) & nodes.ok)
    start = segments.where[i - 1] if i > 0 else lo
    stop = segments.where[i] if i < len(segments.where) else hi
    return (
        np.concatenate([[start], inner.x, [stop]]),
        np.concatenate([[segments.at_first.value[i]], inner.value, [segments.at_last.value[i]]]),
        np.concatenate([[segments.at_first.slope[i]], inner.slope, [segments.at_last.slope[i]]]),
    )


def _with_turning_points(mesh: Mesh, stretches: list[Stretch]) -> list[Stretch]:
    """Add a node of slope 0 wherever the slope changes its sign."""
    signs = (_signs(stretch) for stretch in stretches)
    brackets = [np.flatnonzero(sign[1:] * sign[:-1] < 0) for sign in signs]
    found = [
        (s.x[cells], s.x[cells + 1], s.slope[cells], s.slope[cells + 1])
        for s, cells in zip(stretches, brackets, strict=True)
    ]
    if not found:
        return stretches
    columns = np.stack([np.concatenate(column) for column in zip(*found, strict=True)])
    nodes = mesh.probe(slope_zeros(lambda x: mesh.slopes(x)[1], columns[:2], columns[2:]))
    result, done = [], 0
    for stretch, cells in zip(stretches, brackets, strict=True):
        mine = slice(done, done + len(cells))
        result.append(
            replace(
                stretch,
                x=np.insert(stretch.x, cells + 1, nodes.x[mine]),
                value=np.insert(stretch.value, cells + 1, nodes.value[mine]),
                slope=np.insert(stretch.slope, cells + 1, 0.0),
                turns=cells + 1 + np.arange(len(cells)),
                first_turn=done,
            )
        )
        done += len(cells)
    return result


def _signs(stretch: Stretch) -> Floats:
    """Sign of the slope at each node; a zero takes the sign of the node before it."""
    sign = np.sign(stretch.slope)
    known = np.flatnonzero(sign != 0)
    if not known.size:
        return sign
    place = np.searchsorted(known, np.arange(len(sign)), side="right") - 1
    return sign[known[np.maximum(place, 0)]]


def tabulate_laps(
    mesh: Mesh, stretches: list[Stretch], segments: Segments, *, harmless: bool
) -> Laps:
    """Cut smooth stretches into laps at turning points, numbered on from the breaks.

    If told to, also at the breaks that the map does not care about.
    """
    columns, cells = [np.empty((11, 0))], [np.empty((6, 0))]
    sizes = [np.zeros(1, dtype=np.intp)]
    for s in stretches:
        nodes, last = np.array([s.x, s.value, s.slope]), len(s.x) - 1
        inside = segments.smooth & (segments.where > s.x[0]) & (segments.where < s.x[-1])
        breaks = np.flatnonzero(inside & harmless)
        cuts = np.append(np.searchsorted(s.x, segments.where[breaks]), s.turns)
        turns = len(segments.where) + s.first_turn + np.arange(len(s.turns))
        order = np.argsort(cuts, kind="stable")
        bounds = np.array([0, *cuts[order], last])
        i, j = bounds[:-1], bounds[1:]
        numbers = np.array([s.numbers[0], *np.append(breaks, turns)[order], s.numbers[1]])
        ends = np.stack([nodes[:, i], nodes[:, j]], axis=1).reshape(6, -1)
        low = np.where(i == 0, s.guards[0], s.x[i])
        high = np.where(j == last, s.guards[1], s.x[j])
        direction = np.sign(s.value[j] - s.value[i])
        columns.append(np.array([*ends, low, high, direction, numbers[:-1], numbers[1:]]))
        cells.append(np.stack([nodes[:, :-1], nodes[:, 1:]], axis=1).reshape(6, -1))
        sizes.append(j - i)
    known = np.concatenate(columns, axis=1)
    with np.errstate(invalid="ignore"):  # a lap of no known slope has no direction
        numbered = known[8:].astype(np.intp)
    rest = Cells(*np.concatenate(cells, axis=1)), np.cumsum(np.concatenate(sizes))
    facts: Any = (mesh.f, *known[:8], *numbered, *rest, mesh.value_scale)
    return Laps(*facts)
