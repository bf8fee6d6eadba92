"""The global stick locus (eq. 6a): where both blocks can ride on the belt together."""

# ``x[..., 0]`` is X_1, ``x[..., 1]`` is X_2; a rider needs R_i = X_i + alpha (X_i - X_j).

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import real_numbers

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

ULP_SLACK = 4
"""How many units in the last place outside its domain a ``d`` may lie and count as its end."""


def spring_force(x: ArrayLike, alpha: float) -> NDArray[np.float64]:
    """Force R_i = X_i + alpha (X_i - X_j) that the springs ask of the belt, shape (..., 2)."""
    x = np.asarray(x, dtype=np.float64)
    force: NDArray[np.float64] = x + alpha * (x - x[..., ::-1])
    return force


def displacement(force: ArrayLike, alpha: float) -> NDArray[np.float64]:
    """Displacements that need given forces, shape (..., 2): the inverse of `spring_force`."""
    force = np.asarray(force, dtype=np.float64)
    return ((1.0 + alpha) * force + alpha * force[..., ::-1]) / (1.0 + 2.0 * alpha)


def half_width(alpha: float, beta: float) -> float:
    """Largest |d| of a global stick phase: opposite limits, R_2 - R_1 = (1 + 2 alpha) d."""
    return (1.0 + beta) / (1.0 + 2.0 * alpha)


def corners(alpha: float, beta: float) -> NDArray[np.float64]:
    """Corners A, B, C, D of the locus, counterclockwise (the paper's figure 2), shape (4, 2)."""
    # A and C are the ends of the event map's domain; a global stick phase ends on AB (block 1
    # slips) or on BC (block 2 slips).
    limits = np.array([[1.0, -beta], [1.0, beta], [-1.0, beta], [-1.0, -beta]])
    return displacement(limits, alpha)


def contains(x: ArrayLike, alpha: float, beta: float) -> NDArray[np.bool_]:
    """Whether both blocks can ride (eq. 6a, open inequalities), shape (...); False for NaN."""
    force = spring_force(x, alpha)
    inside: NDArray[np.bool_] = np.all(np.abs(force) < np.array([1.0, beta]), axis=-1)
    return inside


def onset(d: ArrayLike, alpha: float, beta: float) -> NDArray[np.float64]:
    """Displacements at which the global stick phase of `d` (not checked) ends, shape (..., 2)."""
    d = np.asarray(d, dtype=np.float64)
    x1 = np.minimum(1.0 + alpha * d, beta - (1.0 + alpha) * d)
    return np.stack([x1, x1 + d], axis=-1)


def admit(d: ArrayLike, alpha: float, beta: float) -> NDArray[np.float64]:
    """Return relative displacements of the domain as floats; ValueError names the first outside."""
    # The result is the input itself where it is writable, contiguous and inside. Values up to
    # `ULP_SLACK` ulp outside become the end: ``linspace`` rounds.
    values = np.require(
        real_numbers("d", d), np.float64, ["C", "W"]
    )  # kernels are compiled for such arrays
    end = half_width(alpha, beta)
    # Two passes without an array between them: nearly always that is all. NaN fails both.
    if values.size == 0 or (values.max() <= end and values.min() >= -end):
        return values
    # `not <=` also catches NaN
    bad = np.flatnonzero(~(np.abs(values) <= end + ULP_SLACK * np.spacing(end)))
    if bad.size:
        where = np.unravel_index(bad[0], values.shape)
        index = f"[{', '.join(map(str, where))}]" if values.ndim else ""
        raise ValueError(
            f"d{index} = {float(values[where])!r} is outside the global stick locus "
            f"|d| <= {end:.17g} (alpha={alpha:g}, beta={beta:g}, eq. 6a). "
            "Take d from model.domain."
        )
    inside: NDArray[np.float64] = np.clip(values, -end, end)
    return inside
