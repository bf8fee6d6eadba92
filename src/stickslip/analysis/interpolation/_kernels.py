"""Compiled iteration of a map given as polynomials on cells; see `interpolated`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats

# Kinds of cells: polynomials in sqrt(t), where there is a square root at the left end of the cell;
# in sqrt(1 - t), at the right end; straight lines, whose slope is the third coefficient; else (0)
# polynomials in t itself.
SQUARE_ROOT_LEFT, SQUARE_ROOT_RIGHT, STRAIGHT = 1, 2, 3
TINY: Final = 1e-100  # stands for 0 where that would have to be divided by


class CellPolynomials(NamedTuple):
    """Polynomials on ascending cells, and a guide to them; t runs from 0 to 1 in a cell."""

    left: Floats  # (n,)
    right: Floats  # (n,)
    coefficients: Floats  # (n, 5), constant first
    kind: NDArray[np.int64]  # (n,)
    guide: NDArray[np.int64]  # (m + 1,): last cell that starts at or left of each guide point
    per_unit: float  # guide points per unit of x


@kernel
def cell_of(cells: CellPolynomials, x: float) -> int:
    """Find the cell that a point lies in, -1 if none."""
    if not cells.left[0] <= x <= cells.right[-1]:
        return -1
    k = min(int((x - cells.left[0]) * cells.per_unit), len(cells.guide) - 2)
    # Rounding may put a point beside a guide point on its wrong side.
    low = cells.guide[max(k - 1, 0)]
    high = cells.guide[min(k + 2, len(cells.guide) - 1)]
    while low < high:
        middle = (low + high + 1) // 2
        if cells.left[middle] <= x:
            low = middle
        else:
            high = middle - 1
    return low if x <= cells.right[low] else -1


@kernel
def cell_value(cells: CellPolynomials, k: int, x: float) -> tuple[float, float]:
    """Value and slope of one cell's polynomial."""
    width = cells.right[k] - cells.left[k]
    t = (x - cells.left[k]) / width
    if cells.kind[k] == STRAIGHT:
        return cells.coefficients[k, 0] + cells.coefficients[k, 1] * t, cells.coefficients[k, 2]
    chain = 1.0 / width  # du / dx
    u = t
    if cells.kind[k] == SQUARE_ROOT_LEFT:
        u = max(np.sqrt(max(t, 0.0)), TINY)
        chain = chain * 0.5 / u
    elif cells.kind[k] == SQUARE_ROOT_RIGHT:
        u = max(np.sqrt(max(1.0 - t, 0.0)), TINY)
        chain = -chain * 0.5 / u
    value, slope = 0.0, 0.0
    for i in range(4, -1, -1):
        slope = slope * u + value
        value = value * u + cells.coefficients[k, i]
    return value, slope * chain


@kernel
def evaluate_cells(
    cells: CellPolynomials, x: Floats, value: Floats, slope: Floats, cell: NDArray[np.int64]
) -> None:
    """Fill in value, slope and cell of each point; NaN and -1 where there is no cell."""
    for i in range(len(x)):
        k = cell_of(cells, x[i])
        cell[i] = k
        if k < 0:
            value[i], slope[i] = np.nan, np.nan
        else:
            value[i], slope[i] = cell_value(cells, k, x[i])


@kernel
def iterate_cells(
    cells: CellPolynomials, orbit: Floats, slope: Floats, first: NDArray[np.int64]
) -> None:
    """Follow orbits from a given column on: points (m, n + 1) and slopes there (m, n)."""
    for i in range(orbit.shape[0]):
        x = orbit[i, first[i]]
        for j in range(first[i], slope.shape[1]):
            k = cell_of(cells, x)
            if k < 0:
                x = np.nan
                slope[i, j] = np.nan
            else:
                x, slope[i, j] = cell_value(cells, k, x)
            orbit[i, j + 1] = x
