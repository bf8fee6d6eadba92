"""Two contacts on inertias of their own, as the numbers that lanes take."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.flow._lane_kernels import CoulombConstants, Pair, constants_at, slip_at
from stickslip.mechanics.flow.lanes import layout

if TYPE_CHECKING:
    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Floats


def pair_numbers(plant: Plant) -> Floats | None:
    """Rows for pools in which the first block, the second, both slip; None for other plants."""
    # Forces over the masses: docs/theory/blocks.md, "Arrays of two blocks".
    if not plant.rubs_as_one or plant.n_contacts != 2 or plant.n_waves:
        return None
    # Plain floats: a map is made at every value of a parameter that is looked at.
    orders = ((0, 1), (1, 0))
    mass = (plant.mass if plant.mass.ndim == 1 else plant.mass.diagonal()).tolist()
    stiff, damp = (
        [[entry / m for entry in row] for row, m in zip(matrix.tolist(), mass, strict=True)]
        for matrix in (plant.stiffness, plant.damping)
    )
    limit, drag = (
        [force / m for force, m in zip(forces.tolist(), mass, strict=True)]
        for forces in (plant.static, plant.standing)
    )
    V, load = float(plant.V[0]), [sum(row) for row in stiff]
    determinant = load[0] * stiff[1][1] - load[1] * stiff[0][1]
    if determinant == 0.0 or V == 0.0:
        return None
    drift = [V * force for force in load]
    side = [math.copysign(1.0, force) if force else 0.0 for force in drift]
    energy = np.linalg.inv(plant.stiffness).tolist()
    # A block that no common displacement loads stays until the other leaves.
    ratio = [load[i] / load[j] if load[j] else 0.0 for i, j in orders]
    row = np.zeros(layout.NUMBERS)
    for i, j in orders:
        lone = drift[i] > 0.0 and damp[i][j] == 0.0
        base = ratio[i] * (side[j] * limit[j] - drag[j]) + drag[i]
        for place, number in {
            layout.LIMIT: limit[i],
            layout.STIFF: stiff[i][i],
            layout.CROSS: stiff[i][j],
            layout.DAMP: damp[i][i],
            layout.DRAG: damp[i][j],
            layout.DRIFT: drift[i],
            layout.LONE: stiff[i][j] if lone else math.nan,
            layout.MASS: mass[i],
            layout.SPRING: mass[i] * energy[i][i] * mass[i],
            layout.SIDE: side[i],
            layout.BASE: base if load[j] else side[i] * math.inf,
            layout.GAIN: stiff[i][1] - ratio[i] * stiff[j][1],
            layout.SHARE: (-load[1], load[0])[i],
        }.items():
            row[place + i] = number
    row[layout.SPRING_BOTH] = 2.0 * (mass[0] * energy[0][1] * mass[1])
    row[layout.FLOOR] = V * V * min(mass) if plant.dissipates else -math.inf
    row[layout.BELT] = V
    row[layout.SHIFT] = load[0] * drag[1] - load[1] * drag[0]
    row[layout.DETERMINANT] = determinant
    pairs = row[: layout.SPRING_BOTH].reshape(-1, 2)[:, ::-1].ravel()
    return np.array([row, [*pairs, *row[layout.SPRING_BOTH :]], row])


def coulomb_pair(
    plant: Plant, row: Floats, mu: list[float]
) -> tuple[CoulombConstants, Pair] | None:
    """Numbers of closed forms from the first row of `pair_numbers`; None for other plants."""
    # Units of the slow mode: docs/theory/blocks.md, "Closed forms of two unequal blocks".
    K = plant.stiffness
    is_elastic = K[0, 1] == K[1, 0] and not plant.damping.any() and not plant.force.any()
    if not is_elastic or K[0, 1] > 0.0 or not K.sum(axis=1).min() > 0.0:
        return None
    places = (layout.LIMIT, layout.STIFF, layout.CROSS, layout.DRIFT, layout.MASS)
    limit, stiff, cross, drift, mass = (row[at : at + 2] for at in places)
    base, gain, share = (row[at : at + 2] for at in (layout.BASE, layout.GAIN, layout.SHARE))
    coupling, tilt = math.sqrt(cross.prod()), 0.5 * (stiff[0] - stiff[1])
    fast = 0.5 * stiff.sum() + math.hypot(tilt, coupling)
    slow = row[layout.DETERMINANT] / fast
    turn, frequency = 0.5 * math.atan2(coupling, -tilt), math.sqrt(slow)
    a, b = math.sqrt(2.0) * math.cos(turn), math.sqrt(2.0) * math.sin(turn)
    # A force over the root of its mass, limit 1 being 1; mirrored if the belt runs backward.
    scale = np.sqrt(mass / mass[0]) / limit[0]
    side = row[layout.SIDE]
    limit, belt = limit * scale, abs(row[layout.BELT]) * frequency * scale
    load, give = abs(drift) * scale / frequency, side * share / scale / row[layout.DETERMINANT]
    stiff, coupling = stiff / slow, coupling / slow
    one, two = (
        slip_at(
            alpha=max(0.0, stiff[i] - 1.0),
            coupling=coupling,
            loading=load[i],
            loading_b=load[j],
            sweep=stiff[i] * load[j] + coupling * load[i],
            friction=mu[i] * limit[i],
            limit=limit[i],
            limit_b=limit[j],
            first_rider=side * scale[j] * base[j],
            first_slope=side * scale[j] * gain[j],
        )
        for i, j in ((0, 1), (1, 0))
    )
    equal = constants_at(0.5 * (fast / slow - 1.0), limit[1], 1.0, *mu)
    pair = Pair(
        slips=(one, two),
        weights=(a, b),
        belt=(belt[0], belt[1]),
        belt_modes=(a * belt[0] + b * belt[1], a * belt[1] - b * belt[0]),
        give=(give[0], give[1]),
    )
    return equal._replace(end=abs(give) @ limit), pair
