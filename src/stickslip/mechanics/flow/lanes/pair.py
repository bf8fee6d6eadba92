"""Two contacts on inertias of their own, as the numbers that lanes take."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.flow.lanes import layout

if TYPE_CHECKING:
    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Floats


def pair_numbers(plant: Plant) -> Floats | None:
    """Rows for pools in which the first block, the second, both slip; None for other plants."""
    # Forces over the masses: docs/theory/blocks.md, "Arrays of two blocks".
    if not plant.rubs_as_one or plant.n_contacts != 2 or plant.n_waves:
        return None
    mass, V, swap = plant.reduced.mass, float(plant.V[0]), [1, 0]
    stiff, damp = plant.stiffness / mass[:, None], plant.damping / mass[:, None]
    limit, load, drag = plant.static / mass, stiff.sum(axis=1), V * damp.sum(axis=1)
    determinant = load[0] * stiff[1, 1] - load[1] * stiff[0, 1]
    if determinant == 0.0 or V == 0.0:
        return None
    cross, dragged = stiff[[0, 1], swap], damp[[0, 1], swap]
    drift = V * load
    side = np.sign(drift)
    loads_alone = (drift > 0.0) & (dragged == 0.0)
    energy = mass[:, None] * np.linalg.inv(plant.stiffness) * mass
    # A block that no common displacement loads stays until the other leaves.
    ratio = np.divide(load, load[swap], out=np.zeros(2), where=load[swap] != 0.0)
    base = ratio * (side * limit - drag)[swap] + drag
    base[load[swap] == 0.0] = side[load[swap] == 0.0] * math.inf
    row = np.zeros(layout.NUMBERS)
    for place, pair in {
        layout.LIMIT: limit,
        layout.STIFF: stiff.diagonal(),
        layout.CROSS: cross,
        layout.DAMP: damp.diagonal(),
        layout.DRAG: dragged,
        layout.DRIFT: drift,
        layout.LONE: np.where(loads_alone, cross, math.nan),
        layout.MASS: mass,
        layout.SPRING: energy.diagonal(),
        layout.SIDE: side,
        layout.BASE: base,
        layout.GAIN: stiff[:, 1] - ratio * stiff[swap, 1],
        layout.SHARE: load[swap] * [-1.0, 1.0],
    }.items():
        row[place : place + 2] = pair
    row[layout.SPRING_BOTH] = 2.0 * energy[0, 1]
    row[layout.FLOOR] = V * V * mass.min() if plant.dissipates else -math.inf
    row[layout.BELT] = V
    row[layout.SHIFT] = load[0] * drag[1] - load[1] * drag[0]
    row[layout.DETERMINANT] = determinant
    pairs = row[: layout.SPRING_BOTH].reshape(-1, 2)[:, ::-1].ravel()
    return np.array([row, [*pairs, *row[layout.SPRING_BOTH :]], row])
