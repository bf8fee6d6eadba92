"""Tangents of N blocks through events: the saltation matrix."""

from __future__ import annotations

from stickslip.mechanics.flow.blocks.system import BlockDirections, BlockMotion, BlockSystem, Floats
from stickslip.mechanics.flow.blocks.transitions import (
    force_tolerance,
    loading_rate,
    needed_tangent,
)
from stickslip.mechanics.flow.system import (
    AT_UPPER_LIMIT,
    LANDING,
)
from stickslip.numerics.targets import kernel

# Rounding of a needed force, in units of EPSILON x the terms that make it up.
FORCE_ROUNDING = 16.0


@kernel
def saltation(
    system: BlockSystem, directions: BlockDirections, motion: BlockMotion, rates: Floats
) -> None:
    """Move the tangents to the event that ``motion.event`` names, if any."""
    # `rates`: w' just before. The first block with an event sets the time; at a touch (rate 0)
    # nothing is moved.
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
