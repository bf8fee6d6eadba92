"""Compiled evaluation of a map by polynomials on dyadic cells; see `cell_table`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats

BITS: Final = 5
FAN: Final = 1 << BITS  # parts into which an entry of the table is cut that is no single cell
DEGREE: Final = 12  # as `cell_value` is written
DIRECT: Final = -1  # entry of a place without polynomial
COEFFICIENTS: Final = 2  # place in a row, after the centre and 1 / half width of the cell
ROW: Final = 16  # numbers of a cell, one of them unused: two lines of the cache


class CellTable(NamedTuple):
    """Entries of equal parts of the domain, the first ``n``, and the polynomials of the cells.

    An entry is the row of a cell, `DIRECT`, or -2 - k: cut into `FAN` entries ``entries[FAN k:]``.
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
def cubic(c: Floats, k: int, u: float, square: float) -> float:
    """c[k] + c[k + 1] u + c[k + 2] u^2 + c[k + 3] u^3."""
    return (c[k] + c[k + 1] * u) + (c[k + 2] + c[k + 3] * u) * square


@kernel(inline=True)
def cubic_slope(c: Floats, k: int, u: float, square: float) -> float:
    """Terms of c[k + 1] u^(k + 1) to c[k + 4] u^(k + 4), differentiated, over u^k."""
    first = (k + 1) * c[k + 1] + (k + 2) * c[k + 2] * u
    return first + ((k + 3) * c[k + 3] + (k + 4) * c[k + 4] * u) * square


@kernel(inline=True)
def cell_value(table: CellTable, row: int, x: float) -> tuple[float, float]:
    """Value and slope of a cell's polynomial (Estrin's scheme: few operations wait for others)."""
    cell, c = table.rows[row], table.rows[row, COEFFICIENTS:]
    u = (x - cell[0]) * cell[1]
    square = u * u
    fourth = square * square
    low = cubic(c, 0, u, square) + fourth * cubic(c, 4, u, square)
    high = cubic(c, 8, u, square) + fourth * c[12]
    slope = cubic_slope(c, 4, u, square) + fourth * cubic_slope(c, 8, u, square)
    slope = cubic_slope(c, 0, u, square) + fourth * slope
    return low + (fourth * fourth) * high, slope * cell[1]


@kernel
def follow_cells(table: CellTable, orbit: Floats, slope: Floats, done: NDArray[np.int64]) -> None:
    """Go on with orbits (m, n + 1) from column `done`, up to a place without polynomial."""
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
