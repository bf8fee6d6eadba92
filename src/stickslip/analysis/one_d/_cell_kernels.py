"""Compiled evaluation of a map by polynomials on dyadic cells; see `cell_table`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from stickslip.analysis.protocol import Floats

BITS: Final = 5
FAN: Final = 1 << BITS  # parts into which an entry of the table is cut that is no single cell
DEGREE: Final = 12
DIRECT: Final = -1  # entry of a place without polynomial
COEFFICIENTS: Final = 2  # place in a row, after the centre and 1 / half width of the cell
ROW: Final = 16  # numbers of a cell, one of them unused: two lines of the cache


class CellTable(NamedTuple):
    """Entries of equal parts of the domain, and the polynomials of the cells.

    An entry is the row of a cell, `DIRECT`, or -2 - k if it is cut into the `FAN` entries
    ``entries[FAN k:]``. The first ``n`` entries are those of the whole domain.
    """

    low: float
    high: float
    per_unit: float  # entries per unit of x
    entries: NDArray[np.int32]
    rows: Floats  # (cells, ROW)


@kernel(inline=True)
def cell_of(table: CellTable, x: float) -> int:
    """Row of the cell that holds x, or `DIRECT`."""
    if not table.low <= x < table.high:
        return DIRECT
    place = (x - table.low) * table.per_unit
    k = int(place)
    entry = table.entries[k]
    while entry < DIRECT:
        place = (place - k) * FAN
        k = int(place)
        entry = table.entries[k - FAN * (2 + entry)]
    return entry


@kernel(inline=True)
def cell_value(table: CellTable, row: int, x: float) -> tuple[float, float]:
    """Value and slope of a cell's polynomial; even and odd powers side by side."""
    c, u = table.rows[row], (x - table.rows[row, 0]) * table.rows[row, 1]
    square = u * u
    even, odd = c[COEFFICIENTS + DEGREE], c[COEFFICIENTS + DEGREE - 1]
    even_slope, odd_slope = DEGREE * even, (DEGREE - 1) * odd
    for k in range(DEGREE - 2, 0, -2):
        even = even * square + c[COEFFICIENTS + k]
        odd = odd * square + c[COEFFICIENTS + k - 1]
        even_slope = even_slope * square + k * c[COEFFICIENTS + k]
        odd_slope = odd_slope * square + (k - 1) * c[COEFFICIENTS + k - 1]
    even = even * square + c[COEFFICIENTS]
    return even + u * odd, (odd_slope + u * even_slope) * c[1]


@kernel
def follow_cells(table: CellTable, orbit: Floats, slope: Floats, done: NDArray[np.int64]) -> None:
    """Go on with orbits from column `done` until they end or meet a place without polynomial.

    `orbit` (m, n + 1) takes the points, `slope` (m, n) the slopes there. NaN stays NaN.
    """
    n = slope.shape[1]
    for i in range(orbit.shape[0]):
        j = done[i]
        x = orbit[i, j]
        while j < n:
            row = cell_of(table, x)
            if row != DIRECT:
                x, slope[i, j] = cell_value(table, row, x)
            elif x == x:
                break
            else:
                slope[i, j] = x
            j += 1
            orbit[i, j] = x
        done[i] = j
