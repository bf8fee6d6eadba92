"""Two contacts on inertias of their own, as the numbers that lanes take."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.mechanics.flow._lane_kernels import CoulombConstants, Pair, constants_at, slip_at
from stickslip.mechanics.flow.lanes import layout
from stickslip.mechanics.model.plant import TINY

if TYPE_CHECKING:
    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Floats


def pair_numbers(plant: Plant) -> Floats | None:
    """Rows for pools in which the first block, the second, both slip; None for other plants."""
    # Forces over the masses: docs/theory/blocks.md, "Arrays of two blocks".
    if not plant.rubs_as_one or plant.n_contacts != 2 or plant.n_waves:
        return None
    found = _smooth_numbers(plant)
    V = found[layout.BELT]
    if found[layout.DETERMINANT] == 0.0 or V == 0.0:
        return None
    (a, b), (c, d) = plant.stiffness.tolist()
    mass, size = _masses(plant), a * d - b * c
    energy = (d / size, a / size)  # diagonal of the inverse
    for i, j in ORDERS:
        lone = found[layout.DRIFT + i] > 0.0 and found[layout.DRAG + i] == 0.0
        found[layout.LONE + i] = found[layout.CROSS + i] if lone else math.nan
        found[layout.MASS + i] = mass[i]
        found[layout.SPRING + i] = mass[i] * energy[i] * mass[i]
        found[layout.SIDE + i] = _side(found[layout.DRIFT + i])
        # A block that no common displacement loads stays until the other leaves.
        if not found[layout.DRIFT + j]:
            found[layout.BASE + i] = found[layout.SIDE + i] * math.inf
    found[layout.SPRING_BOTH] = -2.0 * (mass[0] * (b / size) * mass[1])
    found[layout.FLOOR] = V * V * min(mass) if plant.dissipates else -math.inf
    row = np.zeros(layout.NUMBERS)
    for place, number in found.items():
        row[place] = number
    return _in_orders(row)


def pair_changes(moved: Plant) -> Floats:
    """Return the changes of `pair_numbers` with a number of the plant, moved by ``TINY`` i."""
    row = np.zeros(layout.NUMBERS)
    for place, number in _smooth_numbers(moved).items():
        row[layout.CHANGE + place] = number.imag / TINY
    return _in_orders(row)


ORDERS = ((0, 1), (1, 0))


def _smooth_numbers(plant: Plant) -> dict[int, Any]:
    """Numbers of the first row that depend smoothly on those of the plant, by place."""
    # Plain numbers: a map is made at every value of a parameter that is looked at.
    mass = _masses(plant)
    stiff, damp = (
        [[entry / m for entry in row] for row, m in zip(matrix.tolist(), mass, strict=True)]
        for matrix in (plant.stiffness, plant.damping)
    )
    limit, drag = (
        [force / m for force, m in zip(forces.tolist(), mass, strict=True)]
        for forces in (plant.static, plant.standing)
    )
    V, load = plant.V.tolist()[0], [sum(row) for row in stiff]
    side = [_side(V * force) for force in load]
    found = {
        layout.BELT: V,
        layout.SHIFT: load[0] * drag[1] - load[1] * drag[0],
        layout.DETERMINANT: load[0] * stiff[1][1] - load[1] * stiff[0][1],
    }
    for i, j in ORDERS:
        ratio = load[i] / load[j] if load[j] else 0.0
        found |= {
            layout.LIMIT + i: limit[i],
            layout.STIFF + i: stiff[i][i],
            layout.CROSS + i: stiff[i][j],
            layout.DAMP + i: damp[i][i],
            layout.DRAG + i: damp[i][j],
            layout.DRIFT + i: V * load[i],
            layout.BASE + i: ratio * (side[j] * limit[j] - drag[j]) + drag[i],
            layout.GAIN + i: stiff[i][1] - ratio * stiff[j][1],
            layout.SHARE + i: (-load[1], load[0])[i],
        }
    return found


def _masses(plant: Plant) -> list[Any]:
    return list((plant.mass if plant.mass.ndim == 1 else plant.mass.diagonal()).tolist())


def _side(drift: Any) -> float:
    """Limit at which a force ends a global stick phase: upper 1, lower -1."""
    return math.copysign(1.0, drift.real) if drift else 0.0


def _in_orders(row: Floats) -> Floats:
    """Rows in the orders of the pools: both numbers of a pair change places in the second."""
    turned = row.copy()
    for first in (0, layout.CHANGE):
        pairs = turned[first : first + layout.SPRING_BOTH].reshape(-1, 2)
        pairs[:] = pairs[:, ::-1].copy()
    return np.array([row, turned, row])


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
