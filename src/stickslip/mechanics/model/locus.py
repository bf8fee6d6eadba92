"""The global stick locus (eq. 6a): where all blocks can ride on the belt together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import real_numbers

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.model.plant import Plant

ULP_SLACK = 4
"""How many units in the last place outside its domain a ``d`` may lie and count as its end."""


def half_width(alpha: float, beta: float) -> float:
    """Largest |d| of a global stick phase: opposite limits, R_2 - R_1 = (1 + 2 alpha) d."""
    return (1.0 + beta) / (1.0 + 2.0 * alpha)


def ends(plant: Plant) -> tuple[float, float]:
    """Least and largest d of two blocks: the locus |K x + V C 1 - g| <= L, projected on d."""
    # det(K) d = s_1 R_2 - s_2 R_1 with s = K 1 and R the springs' part of the needed forces.
    (a, b), (c, d) = plant.stiffness.tolist()
    first, second = a + b, c + d
    determinant = a * d - b * c
    load = plant.standing
    middle = (second * load[0] - first * load[1]) / determinant
    room = abs(second) * plant.static[0] + abs(first) * plant.static[1]
    half = room / abs(determinant)
    return float(middle - half), float(middle + half)


def corners(plant: Plant) -> NDArray[np.float64]:
    """Corners A, B, C, D of the locus of two blocks (the paper's figure 2), shape (4, 2)."""
    # A and C are the ends of the event map's domain; a global stick phase ends on AB (block 1
    # slips) or on BC (block 2 slips). A belt that unloads a block takes it to its lower limit.
    s = plant
    side = np.where(s.stiffness @ s.V < 0.0, -1.0, 1.0) * s.static
    forces = side * np.array([[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
    return np.asarray(np.linalg.solve(s.stiffness, (forces - s.standing).T).T)


def onset(d: ArrayLike, alpha: float, beta: float) -> NDArray[np.float64]:
    """Displacements at which the global stick phase of `d` (not checked) ends, shape (..., 2)."""
    d = np.asarray(d, dtype=np.float64)
    x1 = np.minimum(1.0 + alpha * d, beta - (1.0 + alpha) * d)
    return np.stack([x1, x1 + d], axis=-1)


def admit(d: ArrayLike, low: float, high: float, why: Callable[[], str]) -> NDArray[np.float64]:
    """Return relative displacements of the domain as floats; ValueError names the first outside."""
    # The result is the input itself where it is writable, contiguous and inside. Values up to
    # `ULP_SLACK` ulp outside become the end: ``linspace`` rounds.
    values = real_numbers("d", d)
    if not values.flags.carray:  # kernels are compiled for such arrays
        values = np.require(values, np.float64, ["C", "W"])
    # Two passes without an array between them: nearly always that is all. NaN fails both.
    if values.size == 0 or (values.max() <= high and values.min() >= low):
        return values
    slack = ULP_SLACK * np.spacing(max(abs(low), abs(high)))
    # `not <=` also catches NaN
    bad = np.flatnonzero(~((values >= low - slack) & (values <= high + slack)))
    if bad.size:
        where = np.unravel_index(bad[0], values.shape)
        index = f"[{', '.join(map(str, where))}]" if values.ndim else ""
        raise ValueError(
            f"d{index} = {float(values[where])!r} is outside the global stick locus {why()}. "
            "Take d from model.domain."
        )
    inside: NDArray[np.float64] = np.clip(values, low, high)
    return inside
