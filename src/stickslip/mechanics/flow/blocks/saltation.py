"""Tangents of n blocks through events; see `stickslip.mechanics.flow.saltation`."""

from __future__ import annotations

from stickslip.mechanics.flow.blocks.forces import force_tolerance, loading_rate
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    BlockMotion,
    BlockSystem,
    Floats,
)
from stickslip.mechanics.flow.system import AT_UPPER_LIMIT, LANDING
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos


@kernel
def needed_tangent(
    system: BlockSystem, directions: BlockDirections, motion: BlockMotion, block: int, column: int
) -> float:
    """Differentiate a block's needed force at the present state."""
    sine, cosine = sincos(motion.phase[0])
    change = system.amplitude[block] * sine * motion.tangent_phase[column]
    change -= directions.amplitude[column, block] * cosine
    for k in range(system.first[block], system.first[block + 1]):
        j = system.column[k]
        change += system.stiffness[k] * motion.tangent_x[j, column]
        change += system.damping[k] * (motion.tangent_w[j, column] + directions.V[column])
        change += directions.stiffness[column, k] * motion.x[j]
        change += directions.damping[column, k] * (motion.w[j] + system.V)
    return change


@kernel
def saltation(
    system: BlockSystem, directions: BlockDirections, motion: BlockMotion, rates: Floats
) -> None:
    """Move the tangents to the event that ``motion.event`` names, if any; `rates`: w' just before.

    The first block with an event sets the time. At a touch (rate 0) nothing is moved.
    """
    n = motion.mode.shape[0]
    for block in range(n):
        event = motion.event[block]
        if event == 0:
            continue
        landing = event == LANDING
        rate = rates[block] if landing else loading_rate(system, motion, rates, block)
        if abs(rate) <= force_tolerance(system, motion, block):
            continue
        side = 1.0 if event == AT_UPPER_LIMIT else -1.0
        for column in range(motion.tangent_w.shape[1]):
            if landing:
                shift = -motion.tangent_w[block, column] / rate
            else:
                moved = side * directions.static[column, block]
                needed = needed_tangent(system, directions, motion, block, column)
                shift = (moved - needed) / rate
            for i in range(n):
                motion.tangent_x[i, column] += (motion.w[i] + system.V) * shift
                motion.tangent_w[i, column] += rates[i] * shift
            motion.tangent_phase[column] += system.frequency * shift
        return
