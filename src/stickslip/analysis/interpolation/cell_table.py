"""A map as a table of polynomials that repeat its values to rounding: for very long orbits.

See docs/theory/many-maps.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.polynomial import chebyshev

from stickslip.analysis.interpolation._cell_kernels import (
    BITS,
    COEFFICIENTS,
    DEGREE,
    DIRECT,
    FAN,
    ROW,
    CellTable,
    follow_cells,
)
from stickslip.analysis.maps.protocol import checked_points, iterate, sample, values_and_slopes
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats, Map1D, MapValues, PointValues

    Bools = NDArray[np.bool_]
    Integers = NDArray[np.int64]

ERROR: Final = 3e-15  # of a value: what a cell's polynomial may be off at its nodes
CHECKS: Final = 32  # random points of each cell at which polynomial and map are compared
ALLOWED: Final = 5e-15  # ... and the largest difference there
FIRST: Final = 6  # the domain is cut into 2^FIRST cells; these are halved again and again
ROOT: Final = 10  # entries of the table are 2^-ROOT of the domain, 1 / FAN, 1 / FAN^2 of that
DEEPEST: Final = ROOT + 2 * BITS
MOST: Final = 256  # cells of one size that are halved: more, and the map is not made for this
DIPS: Final = 3.0  # the margin may change this much faster between nodes than from node to node
LEAST_MARGIN: Final = 1e-10
USEFUL: Final = 0.98  # share of the points of an orbit that cells must serve
STOPS: Final = 0.05  # of an orbit's steps: with more stops the map itself is faster ...
FEW_STOPS: Final = 10  # ... but for the first few


def _integration() -> tuple[Floats, Floats]:
    """Nodes on [-1, 1], and what turns slopes there into coefficients 1 to DEGREE."""
    nodes: Floats = -np.cos(np.pi * np.arange(DEGREE) / (DEGREE - 1))
    series = np.linalg.inv(chebyshev.chebvander(nodes, DEGREE - 1)).T
    powers = [chebyshev.cheb2poly(chebyshev.chebint(column)) for column in series]
    return nodes, np.array(powers, dtype=np.float64).T[1:]


NODES, INTEGRATE = _integration()


class TabulatedMap:
    """A `Map1D` whose orbits are followed on a table; ``evaluate`` is the map's own."""

    def __init__(self, f: Map1D, table: CellTable) -> None:
        self.f, self.table = f, table

    @property
    def domain(self) -> tuple[float, float]:
        """Domain of the map."""
        return self.f.domain

    def evaluate(self, x: ArrayLike, /) -> MapValues:
        """Return what the map itself says."""
        return self.f.evaluate(x)

    def iterate(self, x: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times; shape ``x.shape + (n + 1,)``, NaN once an orbit has left."""
        return self.iterate_with_slopes(x, n)[0]

    def iterate_with_slopes(self, x: ArrayLike, n: int) -> tuple[Floats, Floats]:
        """Apply the map ``n`` times; return orbits, and the slope at each point but the last."""
        start = checked_points(self.domain, x)
        orbit, slope = np.empty((start.size, n + 1)), np.empty((start.size, n))
        orbit[:, 0] = start.ravel()
        done = np.zeros(start.size, dtype=np.int64)
        follow_cells(self.table, orbit, slope, done)
        stops = 0
        while (rows := np.flatnonzero(done < n)).size:
            if stops > FEW_STOPS + STOPS * n:
                self._follow(orbit, slope, rows, done[rows])
                break
            self._step(orbit, slope, rows, done[rows])
            done[rows] += 1
            follow_cells(self.table, orbit, slope, done)
            stops += 1
        return orbit.reshape((*start.shape, n + 1)), slope.reshape((*start.shape, n))

    def _step(self, orbit: Floats, slope: Floats, rows: Integers, at: Integers) -> None:
        """Take one step of orbits from columns `at`; NaN leads to NaN."""
        orbit[rows, at + 1], slope[rows, at] = values_and_slopes(self.f, orbit[rows, at])

    def _follow(self, orbit: Floats, slope: Floats, rows: Integers, at: Integers) -> None:
        """Follow orbits to their ends from columns `at`."""
        for row, first in zip(rows.tolist(), at.tolist(), strict=True):
            if np.isfinite(orbit[row, first]):
                orbit[row, first:] = _orbit(self.f, orbit[row, first], slope.shape[1] - first)
            else:
                orbit[row, first:] = np.nan
            slope[row, first:] = values_and_slopes(self.f, orbit[row, first:-1])[1]


def tabulated(f: Map1D, past: Floats) -> TabulatedMap | None:
    """Make the fast map for orbits that go on where ``past``, a few thousand points, have been."""
    # None where it is of no use: no margins are known, or too few of the points lie in cells.
    points = past[np.isfinite(past)]
    if not points.size or np.isnan(sample(f, points[:1]).margin).all():
        return None
    return _Construction(f, points).result()


class _Construction:
    """Cells that are halved until their polynomials fit."""

    def __init__(self, f: Map1D, past: Floats) -> None:
        self.f, self.past = f, past
        self.low, high = f.domain
        self.width = high - self.low
        self.been = np.sort((past - self.low) / self.width)
        self.cells: list[tuple[int, Integers, Floats]] = []  # depth, places, rows
        place = self._visited(FIRST, np.arange(1 << FIRST))
        for depth in range(FIRST, DEEPEST + 1):
            place = self._refined(depth, place)
            if not place.size or place.size > 2 * MOST:
                break

    def _visited(self, depth: int, place: Integers) -> Integers:
        """Choose the cells where the orbits have been."""
        first, last = (np.searchsorted(self.been, (place + k) / (1 << depth)) for k in (0, 1))
        return place[first < last]

    def _refined(self, depth: int, place: Integers) -> Integers:
        """Accept cells; return the halves of the others. Orbits decide on cells without a value."""
        half = 0.5 * self.width / (1 << depth)
        centre = np.asarray(self.low + (2 * place + 1) * half, dtype=np.float64)
        x = centre[:, None] + half * NODES
        values = sample(self.f, np.clip(x, *self.f.domain))
        with np.errstate(invalid="ignore"):  # infinite slopes at square roots fit nothing
            rows, error = _fitted(centre, half, x, values)
        fits = (error <= ERROR) & _one_branch(x, values)
        self.cells.append((depth, place[fits], rows[fits]))
        whole = (values.status == OK).all(axis=1)
        torn = place[~whole & (values.status == OK).any(axis=1)]
        rest = np.concatenate([place[whole & ~fits], self._visited(depth, torn)])
        return np.concatenate([2 * rest, 2 * rest + 1])

    def result(self) -> TabulatedMap | None:
        """Put the table together, and try it."""
        rows = np.concatenate([rows for _, _, rows in self.cells])
        good = np.ones(len(rows), dtype=np.bool_)
        table = self._table(rows, good)
        good = self._confirmed(table)
        if not good.all():
            table = self._table(rows, good)
        orbit = np.column_stack([self.past, self.past])
        served = _one_step(table, orbit)
        return TabulatedMap(self.f, table) if served.mean() >= USEFUL else None

    def _confirmed(self, table: CellTable) -> Bools:
        """Compare cells with the map at random points."""
        rng, half = np.random.default_rng(0), 1 / table.rows[:, 1]
        u = rng.uniform(-1, 1, (len(half), CHECKS))
        x = np.clip(table.rows[:, :1] + half[:, None] * u, *self.f.domain).ravel()
        orbit = np.column_stack([x, x])
        served = _one_step(table, orbit)
        off = np.abs(orbit[:, 1] - _orbit(self.f, x, 1)[:, 1])
        return np.asarray((~served | (off <= ALLOWED)).reshape(u.shape).all(axis=1))

    def _table(self, rows: Floats, good: Bools) -> CellTable:
        entries, row = [DIRECT] * (1 << ROOT), 0
        for depth, places, _ in self.cells:
            for place in places.tolist():
                if good[row]:
                    _enter(entries, depth, place, row)
                row += 1
        per_unit = (1 << ROOT) / self.width
        end = self.f.domain[1]
        return CellTable(self.low, end, per_unit, np.array(entries, np.int32), _aligned(rows))


def _fitted(centre: Floats, half: float, x: Floats, values: PointValues) -> tuple[Floats, Floats]:
    """Rows of cells, and the largest error at the nodes."""
    rows = np.zeros((len(centre), ROW))
    rows[:, 0], rows[:, 1] = centre, 1 / half
    mean = values.derivative.mean(axis=1, keepdims=True)
    rows[:, COEFFICIENTS + 1 : COEFFICIENTS + DEGREE + 1] = (
        half * (values.derivative - mean) @ INTEGRATE.T
    )
    rows[:, COEFFICIENTS + 1] += half * mean[:, 0]
    u = (x - centre[:, None]) / half
    polynomial = np.zeros_like(u)
    for k in range(DEGREE, 0, -1):
        polynomial = (polynomial + rows[:, COEFFICIENTS + k, None]) * u
    off = values.value - polynomial
    top, bottom = off.max(axis=1), off.min(axis=1)
    rows[:, COEFFICIENTS] = 0.5 * (top + bottom)
    return rows, 0.5 * (top - bottom)


def _one_branch(x: Floats, values: PointValues) -> Bools:
    """Tell the cells of which nodes and margins show no end of a branch."""
    same = (values.status == OK).all(axis=1) & (values.label == values.label[:, :1]).all(axis=1)
    margin, step = values.margin, np.diff(x, axis=1)
    change = np.abs(np.diff(margin, axis=1))
    steepest = (change / step).max(axis=1, keepdims=True)
    clear = (margin[:, 1:] + margin[:, :-1] > DIPS * steepest * step).all(axis=1)
    return same & clear & (margin > LEAST_MARGIN).all(axis=1)


def _enter(entries: list[int], depth: int, place: int, row: int) -> None:
    """Note a cell in the entries that it fills; cut entries that are larger."""
    first, size, level = 0, 1 << ROOT, ROOT
    while level < depth:
        at = first + (place >> (depth - level)) % size
        if entries[at] == DIRECT:
            entries[at] = -2 - len(entries) // FAN
            entries += [DIRECT] * FAN
        first, size, level = FAN * (-2 - entries[at]), FAN, level + BITS
    count = 1 << (level - depth)
    at = first + (place * count) % size
    entries[at : at + count] = [row] * count


def _one_step(table: CellTable, orbit: Floats) -> Bools:
    """Fill column 1 of `orbit` (m, 2) where cells serve; tell where."""
    done = np.zeros(len(orbit), dtype=np.int64)
    follow_cells(table, orbit, np.empty((len(orbit), 1)), done)
    return done > 0


def _orbit(f: Map1D, x: Floats, n: int) -> Floats:
    """Iterate by the map's own loop, if it has one."""
    native = getattr(f, "iterate", None)
    return np.asarray(iterate(f, x, n) if native is None else native(x, n))


def _aligned(rows: Floats) -> Floats:
    """Copy rows so that each begins with a line of the cache."""
    store = np.zeros(rows.size + 8)
    first = (-store.ctypes.data // 8) % 8
    held = store[first : first + rows.size].reshape(rows.shape)
    held[:] = rows
    return held
