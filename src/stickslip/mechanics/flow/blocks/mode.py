"""Transitions of n blocks: which mode each takes at an event (rules 1, 2 and 5 of the design)."""

from __future__ import annotations

from stickslip.mechanics.flow.blocks.forces import loading_rate
from stickslip.mechanics.flow.blocks.system import BlockMotion, BlockSystem, Floats
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    FORWARD,
    LANDING,
    STICK,
)
from stickslip.numerics.targets import kernel


@kernel(inline=True)
def mode_on_belt(system: BlockSystem, motion: BlockMotion, rates: Floats, block: int) -> int:
    """Mode of a block whose relative velocity is zero; ``motion.e`` is exact at the limits."""
    limit = system.static[block]
    force = motion.e[block]
    if abs(force) < limit:
        return STICK
    if abs(force) == limit:
        rate = loading_rate(system, motion, rates, block)
        if (rate <= 0.0) if force > 0.0 else (rate >= 0.0):
            return STICK
    return BACKWARD if force > 0.0 else FORWARD


@kernel(inline=True)
def stop(motion: BlockMotion, block: int) -> None:
    """Take away the relative velocity of a block, and how it changes with anything."""
    motion.w[block] = 0.0
    for column in range(motion.tangent_w.shape[1]):
        motion.tangent_w[block, column] = 0.0


@kernel(inline=True)
def settle(system: BlockSystem, motion: BlockMotion, rates: Floats) -> bool:
    """Change the modes of all blocks at an event, once; tell whether any changed.

    Needed forces are continuous there; `rates` (w' just before) matter exactly at a limit alone.
    """
    n = motion.mode.shape[0]
    for block in range(n):
        if motion.event[block] != 0:
            stop(motion, block)
            rates[block] = 0.0
    changed = False
    for block in range(n):
        event = motion.event[block]
        before = motion.mode[block]
        if event == LANDING:
            motion.mode[block] = mode_on_belt(system, motion, rates, block)
        elif event == AT_UPPER_LIMIT:
            motion.mode[block] = BACKWARD
        elif event == AT_LOWER_LIMIT:
            motion.mode[block] = FORWARD
        changed = changed or motion.mode[block] != before
    return changed
