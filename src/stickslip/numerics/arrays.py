"""Names of the types of arrays, and a product of many rows."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Complexes: TypeAlias = NDArray[np.complex128]


def applied(matrix: Floats, rows: Floats) -> Floats:
    """Return ``matrix @ row`` for each row, shape (..., m) for rows (..., n)."""
    # BLAS takes threads for many rows, which go on spinning for a tenth of a second beside ours.
    if rows.ndim == 1:
        return np.asarray(rows @ matrix.T)
    return np.asarray(np.einsum("...j,ij->...i", rows, matrix))
