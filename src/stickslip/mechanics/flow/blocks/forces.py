"""Needed forces of the blocks and how fast they grow."""

from __future__ import annotations

from stickslip.mechanics.flow.blocks.system import BlockMotion, BlockSystem, Floats
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos

# Rounding of a needed force, in units of EPSILON x the terms that make it up.
FORCE_ROUNDING = 16.0


@kernel(inline=True)
def force_tolerance(system: BlockSystem, motion: BlockMotion, block: int) -> float:
    """How near its static limit the needed force of a block counts as being there."""
    return FORCE_ROUNDING * EPSILON * (system.static[block] + motion.size[block])


@kernel
def update_needed(system: BlockSystem, motion: BlockMotion) -> None:
    """Compute the needed forces from the state; exactly the limit where rounding explains it."""
    _, cosine = sincos(motion.phase[0])
    for i in range(motion.x.shape[0]):
        force = -system.amplitude[i] * cosine
        size = abs(force)
        for k in range(system.first[i], system.first[i + 1]):
            j = system.column[k]
            spring = system.stiffness[k] * motion.x[j]
            damper = system.damping[k] * (motion.w[j] + system.V)
            force += spring + damper
            size += abs(spring) + abs(damper)
        motion.size[i] = size
        limit = system.static[i]
        if abs(abs(force) - limit) <= force_tolerance(system, motion, i):
            force = limit if force > 0.0 else -limit
        motion.e[i] = force


@kernel(inline=True)
def loading_rate(system: BlockSystem, motion: BlockMotion, rates: Floats, block: int) -> float:
    """Rate e' of a block's needed force; `rates`: w' of all blocks."""
    sine, _ = sincos(motion.phase[0])
    rate = system.amplitude[block] * system.frequency * sine
    for k in range(system.first[block], system.first[block + 1]):
        j = system.column[k]
        rate += system.stiffness[k] * (motion.w[j] + system.V) + system.damping[k] * rates[j]
    return rate
