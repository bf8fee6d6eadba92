"""A map's table of laps as a very fast map: polynomials between exact values and slopes.

Cubics; beside a graze polynomials in a square root. What is found there is a guess to be confirmed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.laps import Cells
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.interpolation._kernels import (
    SQUARE_ROOT_LEFT,
    SQUARE_ROOT_RIGHT,
    STRAIGHT,
    CellPolynomials,
    evaluate_cells,
    iterate_cells,
)
from stickslip.analysis.maps.protocol import (
    UNDEFINED,
    PointValues,
    checked_points,
    sample,
    shaped,
    values_and_slopes,
)
from stickslip.analysis.scales import FINE, HALVINGS, PROBED
from stickslip.numerics.arrays import interval_of
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Integers, Labels, Map1D


HALVES: Final = 4.0  # factor by which halving a cell reduces its error at least (16 if smooth)
TILT: Final = 0.15  # of a cell's width times the wrong slope in its middle: error beside it
SAFETY: Final = 4.0  # by which errors predicted from neighbouring nodes are taken larger
MAX_CELLS: Final = 20_000
NARROW: Final = 0.25  # resolutions: cells narrower than this are left as they are
SAMPLES: Final = 16  # of an interval whose branches are too narrow for the table
APART: Final = 0.02  # of the way to the next sample: a step would make all orbits that meet one one
PROBES: Final = PROBED  # random points at which a stand-in and the true map are compared
GUIDE: Final = 4  # guide points per cell


@dataclass(frozen=True, eq=False)
class InterpolatedMap:
    """A map of the line, fit for `Map1D`, interpolated between the nodes of its table."""

    f: Map1D
    table: BranchTable
    polynomials: CellPolynomials
    cell_labels: Labels
    error: float  # largest of a value; infinite: the map has a branch that its table does not know
    asks: bool = False  # the true map, where branches are too narrow for the table

    @property
    def domain(self) -> tuple[float, float]:
        """Domain of the true map."""
        return self.f.domain

    @cached_property
    def gap_statuses(self) -> Integers:
        """Why there is no value, per gap: the true map's status in its middle."""
        gaps = self.table.gaps
        return np.asarray(sample(self.f, gaps.mean(axis=1)).status if len(gaps) else [], np.int64)

    def value_and_derivative(self, x: ArrayLike, /) -> tuple[Floats, Floats]:
        """Return value and derivative alone, sooner."""
        points = checked_points(self.domain, x)
        value, slope, _ = self._by_cells(points.ravel())
        return value.reshape(points.shape), slope.reshape(points.shape)

    def _by_cells(self, flat: Floats) -> tuple[Floats, Floats, Integers]:
        """Values, derivatives, and the cells they are from; -1 outside all of them."""
        value, slope = np.empty(flat.shape), np.empty(flat.shape)
        cell = np.empty(flat.shape, dtype=np.int64)
        evaluate_cells(self.polynomials, flat, value, slope, cell)
        if (cell < 0).any():
            outside = np.flatnonzero(cell < 0)
            asked = outside[self._are_unknown(flat[outside])]
            value[asked], slope[asked] = self._estimated(flat[asked])
        return value, slope, cell

    def evaluate(self, x: ArrayLike, /) -> PointValues:
        """Return value, derivative, label and status at points of the domain."""
        points = checked_points(self.domain, x)
        flat = points.ravel()
        value, slope, cell = self._by_cells(flat)
        known = cell >= 0
        label = np.zeros(flat.shape, dtype=np.uint64)
        label[known] = self.cell_labels[cell[known]]
        status = np.full(flat.shape, OK, dtype=np.int64)
        if not known.all():
            place = interval_of(flat[~known], *self.table.gaps.T)
            why = np.append(self.gap_statuses, UNDEFINED)[place]
            asked = self._are_unknown(flat[~known])
            why[asked | (why == OK)] = UNDEFINED
            status[~known] = np.where(asked & ~np.isnan(value[~known]), OK, why)
        return shaped(points.shape, value, slope, label, status, np.full(flat.shape, np.nan))

    def _are_unknown(self, x: Floats) -> Bools:
        """Tell which points lie where branches are too narrow for the table."""
        return interval_of(x, *self.table.unknown.T) >= 0

    @cached_property
    def _with_estimates(self) -> CellPolynomials:
        """Cells also where branches are too narrow for the table: lines about samples there."""
        ends = self.table.unknown
        # Not at regular places: parts of a fractal are alike.
        share = np.arange(SAMPLES) + np.random.default_rng(0).random((len(ends), SAMPLES))
        x = ends[:, :1] + share / SAMPLES * np.diff(ends)
        value, slope = values_and_slopes(self.f, x)
        # Values and slopes as likely as the true ones: the nearest sample's, orbits kept apart by
        # lines to either side of it, towards the next one.
        middle = 0.5 * (x[:, 1:] + x[:, :-1])
        before, after = np.column_stack([ends[:, 0], middle]), np.column_stack([middle, ends[:, 1]])
        up = 0.5 * APART * np.diff(value)
        down = np.column_stack([up[:, 0], -up])  # the outermost go towards the only one beside them
        up = np.column_stack([up, -up[:, -1]])
        left, right = np.concatenate([before, x]).ravel(), np.concatenate([x, after]).ravel()
        start, rise = np.concatenate([value + down, value]), np.concatenate([-down, up])
        rows = start, rise, np.concatenate([slope, slope]), *np.zeros((2, *start.shape))
        coefficients = np.column_stack([row.ravel() for row in rows])
        known = self.polynomials
        n = np.count_nonzero(np.isfinite(known.left)) + len(left)  # none: a cell that is no number
        order = np.argsort(np.concatenate([known.left, left]), kind="stable")[:n]
        parts = (
            (known.left, left),
            (known.right, right),
            (known.coefficients, coefficients),
            (known.kind, np.full(left.shape, STRAIGHT)),
        )
        return _guided(*(np.concatenate(both)[order] for both in parts))

    def _estimated(self, x: Floats) -> tuple[Floats, Floats]:
        """Values and slopes where branches are too narrow for the table."""
        if self.asks or not x.size:
            return values_and_slopes(self.f, x)
        value, slope = np.empty((2, x.size))
        evaluate_cells(self._with_estimates, x, value, slope, np.empty(x.shape, dtype=np.int64))
        return value, slope

    def iterate(self, x: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times; shape ``x.shape + (n + 1,)``, NaN once an orbit has left."""
        return self.iterate_with_slopes(x, n)[0]

    def iterate_with_slopes(self, x: ArrayLike, n: int) -> tuple[Floats, Floats]:
        """Apply the map ``n`` times, and tell the slope at each point but the last."""
        if n < 0:
            raise ValueError(f"n = {n} applications of a map: n must be at least 0.")
        start = checked_points(self.domain, x)
        orbit, slope = np.empty((start.size, n + 1)), np.empty((start.size, n))
        orbit[:, 0] = start.ravel()
        first = np.zeros(start.size, dtype=np.int64)
        iterate_cells(self.polynomials, orbit, slope, first)
        if len(self.table.unknown):
            self._through_unknown(orbit, slope)
        return orbit.reshape((*start.shape, n + 1)), slope.reshape((*start.shape, n))

    def _through_unknown(self, orbit: Floats, slope: Floats) -> None:
        """Go on with the orbits that ended where branches are too narrow for the table."""
        rows = np.arange(len(orbit))
        while rows.size:
            ended = np.isnan(orbit[rows])
            rows, first = rows[ended.any(axis=1)], ended.argmax(axis=1)[ended.any(axis=1)]
            at = orbit[rows, first - 1]
            asked = self._are_unknown(at)
            rows, first, at = rows[asked], first[asked], at[asked]
            if not self.asks:
                _go_on(self._with_estimates, orbit, slope, rows, first - 1)
                break
            orbit[rows, first], slope[rows, first - 1] = values_and_slopes(self.f, at)
            on = np.isfinite(orbit[rows, first])
            rows, first = rows[on], first[on]
            _go_on(self.polynomials, orbit, slope, rows, first)


def _go_on(
    cells: CellPolynomials, orbit: Floats, slope: Floats, rows: Indices, first: Integers
) -> None:
    """Follow some of the orbits from a given column on."""
    moved, tilt = orbit[rows], slope[rows]
    iterate_cells(cells, moved, tilt, first)
    orbit[rows], slope[rows] = moved, tilt


def interpolated_map(table: BranchTable) -> InterpolatedMap:
    """Make the fast map of a table.

    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.5})
    >>> fast = interpolated_map(ss.branches(f))
    >>> bool(abs(fast.evaluate(0.3).value - f(0.3)) <= fast.error < 1e-9)
    True
    """
    return _Construction(table).result()


def stand_in(f: Map1D, *, asks: bool = False) -> Map1D:
    """Return the fast map of a map's table; the map itself where that is not good enough."""
    fast = replace(interpolated_map(branch_table(f)), asks=asks)
    return fast if np.isfinite(fast.error) else f


class _Construction:
    """Cells that are halved where the polynomial on them is not good enough."""

    def __init__(self, table: BranchTable) -> None:
        self.table, self.f = table, table.f
        self.allowed = FINE * table.laps.value_scale
        wide = np.flatnonzero(table.laps.cells.x1 > table.laps.cells.x0)
        self.cells = table.laps.cells.take(wide)
        # Cells with an infinite slope at one end hold a square root there.
        at_left, at_right = ~np.isfinite(self.cells.s0), ~np.isfinite(self.cells.s1)
        self.kind = np.where(at_right, SQUARE_ROOT_RIGHT, 0)
        self.kind[at_left] = SQUARE_ROOT_LEFT
        lap_of_cell = np.repeat(np.arange(len(table.laps)), np.diff(table.laps.first_cell))
        self.error = _predicted_errors(self.cells, lap_of_cell[wide])
        self.label = table.labels_at(0.5 * (self.cells.x0 + self.cells.x1))
        self.breaks = np.array([b.d for b in table.breakpoints if b.kind != "smooth"])
        for _ in range(HALVINGS):
            open_cells = (self.error > self.allowed) & self._wide()
            if not open_cells.any() or len(self.kind) > MAX_CELLS:
                break
            self._halve(np.flatnonzero(open_cells))
        unknown = ~np.isfinite(self.error) & ~self._wide()
        self.error[unknown] = np.abs(self.cells.v1 - self.cells.v0)[unknown]

    def _wide(self) -> Bools:
        return np.asarray(self.cells.x1 - self.cells.x0 > NARROW * self.table.resolution)

    def _halve(self, k: Indices) -> None:
        """Compare cells with the true map in their middles and cut them there."""
        cells = self.cells.take(k)
        x = 0.5 * (cells.x0 + cells.x1)
        value, slope = values_and_slopes(self.f, x)
        kind, off, plain = self._better_kind(k, cells, x, value, slope)
        hidden = np.isnan(value)
        left = replace(cells, x1=x, v1=value, s1=slope)
        right = replace(cells, x0=x, v0=value, s0=slope)
        # The half away from a root gets a cubic again.
        at_left = np.where(kind == SQUARE_ROOT_LEFT, kind, 0)
        at_right = np.where(kind == SQUARE_ROOT_RIGHT, kind, 0)
        error = np.concatenate(
            [np.where(half == kind, off, plain)[~hidden] / HALVES for half in (at_left, at_right)]
        )
        error = np.where(np.isfinite(error), error, np.inf)
        # A gap that the table missed is nothing that halving could mend.
        self.error[k[hidden]] = np.inf
        keep = np.ones(len(self.kind), dtype=np.bool_)
        keep[k] = hidden
        cut = ~hidden
        parts = (self.cells.take(keep), left.take(cut), right.take(cut))
        joined = parts[0].joined(*parts[1:])
        order = np.argsort(joined.x0, kind="stable")
        self.cells = joined.take(order)
        self.kind = np.concatenate([self.kind[keep], at_left[cut], at_right[cut]])[order]
        self.error = np.concatenate([self.error[keep], error])[order]
        own = self.label[k][cut]
        self.label = np.concatenate([self.label[keep], own, own])[order]

    def _better_kind(
        self, k: Indices, cells: Cells, x: Floats, value: Floats, slope: Floats
    ) -> tuple[Integers, Floats, Floats]:
        """Choose the kinds that predict the middles best; return also their errors and cubics'."""
        best = self.kind[k].copy()
        plain = np.abs(_cubic(cells, x) - value)
        # Where f'''' vanishes in the middle, so does the error, but not its slope.
        with np.errstate(all="ignore"):
            mean = (cells.v1 - cells.v0) / (cells.x1 - cells.x0)
            tilt = np.abs(1.5 * mean - 0.25 * (cells.s0 + cells.s1) - slope)
            tilt *= cells.x1 - cells.x0
        plain = np.maximum(plain, TILT * tilt)
        off = np.where(best == 0, plain, np.abs(_values(cells, best, x) - value))
        for kind, ends in ((SQUARE_ROOT_LEFT, cells.x0), (SQUARE_ROOT_RIGHT, cells.x1)):
            trial = np.where(best == 0, kind, best)
            other = np.abs(_values(cells, trial, x) - value)
            # A square root must explain more than halving the cell would.
            better = (other < off / HALVES) & (off > self.allowed) & np.isin(ends, self.breaks)
            best, off = np.where(better, trial, best), np.where(better, other, off)
        return best, off, plain

    def result(self) -> InterpolatedMap:
        polynomials = _polynomials(self.cells, self.kind)
        found = InterpolatedMap(self.f, self.table, polynomials, self.label, error=0.0)
        return replace(found, error=self._checked(found))

    def _checked(self, found: InterpolatedMap) -> float:
        """Compare random points, half of them in the cells with the largest estimates."""
        rng = np.random.default_rng(0)
        cells = self.cells
        wide = np.flatnonzero(self._wide())
        if not wide.size:
            return float("inf")
        worst = wide[np.argsort(self.error[wide])[-PROBES // 2 :]]
        chosen = np.concatenate([worst, rng.choice(wide, PROBES - len(worst))])
        x = cells.x0[chosen] + rng.random(len(chosen)) * (cells.x1 - cells.x0)[chosen]
        value, _ = values_and_slopes(self.f, x)
        if np.isnan(value).any():
            return float("inf")
        off = float(np.max(np.abs(value - found.evaluate(x).value)))
        return max(off, float(np.max(self.error[wide])))


def _predicted_errors(cells: Cells, lap: Indices) -> Floats:
    """Errors of cubics: two cells predict the node between them; unknown at the ends of laps."""
    first, last = cells.take(np.arange(len(lap) - 1)), cells.take(np.arange(1, len(lap)))
    both = Cells(first.x0, last.x1, first.v0, last.v1, first.s0, last.s1)
    middle = last.x0
    with np.errstate(all="ignore"):
        off = np.abs(_cubic(both, middle) - last.v0)
        bend = off / ((middle - both.x0) ** 2 * (both.x1 - middle) ** 2)  # f'''' / 24
    inner = (lap[1:] == lap[:-1]) & np.isfinite(bend)
    bend = np.where(inner, bend, np.nan)
    own = np.maximum(np.append(bend, np.nan), np.insert(bend, 0, np.nan))
    at_end = np.ones(len(lap), dtype=np.bool_)
    at_end[1:-1] = (lap[2:] != lap[1:-1]) | (lap[:-2] != lap[1:-1])
    error = SAFETY * own * (cells.x1 - cells.x0) ** 4 / 16
    return np.where(at_end | ~np.isfinite(error), np.inf, error)


def _cubic(cells: Cells, x: Floats) -> Floats:
    """Cubic Hermite interpolant of each cell at one point of it."""
    return _values(cells, np.zeros(len(x), dtype=np.int64), x)


def _values(cells: Cells, kind: Integers, x: Floats) -> Floats:
    """Polynomial of each cell at one point of it."""
    with np.errstate(all="ignore"):
        t = (x - cells.x0) / (cells.x1 - cells.x0)
        u = np.where(kind == SQUARE_ROOT_LEFT, np.sqrt(t), t)
        u = np.where(kind == SQUARE_ROOT_RIGHT, np.sqrt(1 - t), u)
        value = np.zeros(x.shape)
        for column in _coefficients(cells, kind).T[::-1]:
            value = value * u + column
    return value


def _coefficients(cells: Cells, kind: Integers) -> Floats:
    """Coefficients, shape (n, 5), of the polynomials with the cells' values and slopes."""
    width = cells.x1 - cells.x0
    mirrored = kind == SQUARE_ROOT_RIGHT
    sign = np.where(mirrored, -width, width)
    start, end = np.where(mirrored, (cells.v1, cells.v0), (cells.v0, cells.v1))
    first = sign * np.where(mirrored, cells.s1, cells.s0)
    last = sign * np.where(mirrored, cells.s0, cells.s1)
    rise, zero = end - start, np.zeros(width.shape)
    with np.errstate(invalid="ignore"):
        cubic = (start, first, 3 * rise - 2 * first - last, first + last - 2 * rise, zero)
        # A finite slope: no term in u, the one in u^2 is the slope; d/du = 2 u d/dt.
        quartic = (start, zero, first, 4 * rise - 2 * last - 2 * first, 2 * last - 3 * rise + first)
        # An infinite one: a u + b u^2 from the other end.
        root = (start, 2 * (rise - last), 2 * last - rise, zero, zero)
    regular = np.where((kind > 0)[:, None], np.column_stack(quartic), np.column_stack(cubic))
    found = np.where(np.isfinite(first)[:, None], regular, np.column_stack(root))
    # Infinite slopes at both ends: a straight line in u.
    line = np.column_stack((start, rise, zero, zero, zero))
    return np.where(np.all(np.isfinite(found), axis=1, keepdims=True), found, line)


def _polynomials(cells: Cells, kind: Integers) -> CellPolynomials:
    if not len(kind):  # a map without any value: one cell that no point lies in
        none = np.full(1, np.nan)
        nowhere = np.zeros(1, dtype=np.int64)
        return CellPolynomials(none, none, np.zeros((1, 5)), nowhere, nowhere, np.nan)
    return _guided(cells.x0, cells.x1, _coefficients(cells, kind), kind)


def _guided(left: Floats, right: Floats, coefficients: Floats, kind: Integers) -> CellPolynomials:
    n = GUIDE * len(kind)
    lo, hi = float(left[0]), float(right[-1])
    guides = np.linspace(lo, hi, n + 1)
    guide = np.clip(np.searchsorted(left, guides, side="right") - 1, 0, len(kind) - 1)
    return CellPolynomials(
        left=np.ascontiguousarray(left),
        right=np.ascontiguousarray(right),
        coefficients=np.ascontiguousarray(coefficients),
        kind=np.ascontiguousarray(kind, dtype=np.int64),
        guide=guide.astype(np.int64),
        per_unit=n / (hi - lo),
    )
