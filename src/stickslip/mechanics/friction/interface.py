"""What kernels see of friction laws: parameter rows, signatures of generated kernels."""

# A row belongs to one smooth piece of a law; after PARAMETER_COLUMN stand its formula's parameters,
# then constants made of them.

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

N_ROWS: int
N_PARAMETERS: int
FORCE_ROW: int
SLOPE_ROW: int
GRADIENT_ROW: int


def static_value(p: Floats, m: int) -> float:
    """F(0)."""
    raise NotImplementedError


def force(p: Floats, m: int, s: float) -> float:
    """F(s)."""
    raise NotImplementedError


def force_continued(p: Floats, m: int, s: float) -> float:
    """F(s), and its tangent at 0 for s < 0."""
    raise NotImplementedError


def force_sharp(p: Floats, m: int, s: float, s_low: float) -> tuple[float, float]:
    """F(s + s_low), and what rounding leaves out of it."""
    raise NotImplementedError


def slope(p: Floats, m: int, s: float) -> float:
    """dF/ds."""
    raise NotImplementedError


def gradient(p: Floats, m: int, s: float, out: Floats) -> None:
    """dF/d(parameter j) into ``out[j]``."""
    raise NotImplementedError


def series(p: Floats, m: int, rows: NDArray[np.float64], k: int) -> None:
    """Coefficient k of F along the speed in row 0."""
    raise NotImplementedError


def series_tangent(
    p: Floats, m: int, rows: NDArray[np.float64], order: int, gradient: bool
) -> None:
    """Series of dF/ds and, if `gradient`, dF/d(parameter j)."""
    raise NotImplementedError


LAW_COLUMN, STATIC_COLUMN, FORWARD_STATIC_COLUMN = 0, 1, 2
PIECE_END_COLUMN, NEXT_PIECE_COLUMN = 3, 4
PARAMETER_COLUMN = 5
