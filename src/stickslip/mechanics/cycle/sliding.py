"""Small motions about steady sliding: eigenvalues, and the friction laws' higher derivatives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from stickslip.mechanics.friction.code import law_code
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock

if TYPE_CHECKING:
    from stickslip.numerics.arrays import Complexes, Floats


Model: TypeAlias = TwoBlock | BeltModel


class Modes(NamedTuple):
    """Linear motions about steady sliding: z' = matrix z, z = (displacements, velocities)."""

    matrix: Floats
    values: Complexes  # by descending real part
    vectors: Complexes  # columns


def steady_displacements(model: Model, V: float) -> Floats:
    """Displacements of steady sliding at a belt speed: K X = limit F(V)."""
    s = model.structure
    friction = s.static * [float(law.force(V)) for law in model.laws]
    return np.asarray(np.linalg.solve(s.stiffness, friction), dtype=np.float64)


def modes(model: Model, V: float) -> Modes:
    """Small motions about steady sliding: M y'' + (C + limit F'(V)) y' + K y = 0."""
    s = model.structure
    n = s.n_blocks
    damping = s.damping + np.diag(s.static * [float(law.slope(V)) for law in model.laws])
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -s.stiffness / s.mass[:, None]
    matrix[n:, n:] = -damping / s.mass[:, None]
    values, vectors = np.linalg.eig(matrix)
    order = np.lexsort((-values.imag, -values.real))
    return Modes(matrix, values[order].astype(complex), vectors[:, order].astype(complex))


def force_derivatives(model: Model, V: float) -> Floats | None:
    """First three derivatives of every law at a slip speed, shape (N, 3); None without a series."""
    code = law_code(model.laws)
    if code.series is None:
        return None
    derivatives = np.empty((model.n_blocks, 3))
    for i, law in enumerate(model.laws):
        row = code.parameter_row(law, V)
        series = np.zeros((code.N_ROWS, 4))
        series[0, :2] = V, 1.0
        for k in range(4):
            code.series(row, -1, series, k)
        derivatives[i] = series[code.FORCE_ROW, 1:] * [math.factorial(k) for k in (1, 2, 3)]
    return derivatives
