"""Signatures of the generated law kernels, for the type checker alone: see `friction.code`."""

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


def series_tangent(p: Floats, m: int, rows: NDArray[np.float64], order: int) -> None:
    """Series of dF/ds and dF/d(parameter j)."""
    raise NotImplementedError
