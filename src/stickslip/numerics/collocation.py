"""Matrices of collocation on the step [0, 1], its nodes Chebyshev-Lobatto points with both ends."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


def nodes(degree: int) -> NDArray[np.float64]:
    """Ascending nodes on [0, 1], ``degree + 1`` of them."""
    return np.sin(0.5 * np.pi * np.arange(degree + 1) / degree) ** 2


def to_coefficients(degree: int) -> Matrix:
    """Chebyshev coefficients (of 2 t - 1) from values at the nodes."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(2.0 * nodes(degree) - 1.0, degree)))


def integration(degree: int) -> Matrix:
    """Integrals from 0 to each node, from values at the nodes."""
    columns = [
        chebyshev.chebval(2.0 * nodes(degree) - 1.0, chebyshev.chebint(column, scl=0.5, lbnd=-1))
        for column in to_coefficients(degree).T
    ]
    matrix: Matrix = np.column_stack(columns)
    matrix[0] = 0.0  # a step starts where it starts, and not a rounding away
    return matrix


def shifted_chebyshev(degree: int) -> Matrix:
    """Column k: coefficients of ``T_k(2 t - 1)`` in powers of ``t``, exact integers."""
    # Coefficients decay: this ill-conditioned change of basis stays accurate where its product with
    # `to_coefficients` would not.
    shifted = np.zeros((degree + 1, degree + 1))
    shifted[0, 0] = 1.0
    if degree >= 1:
        shifted[:2, 1] = (-1.0, 2.0)
    for k in range(2, degree + 1):
        # T_k(2 t - 1) = 2 (2 t - 1) T_{k-1} - T_{k-2}
        shifted[:, k] = -2.0 * shifted[:, k - 1] - shifted[:, k - 2]
        shifted[1:, k] += 4.0 * shifted[:-1, k - 1]
    return shifted
