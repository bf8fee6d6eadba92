"""The onset of a slip of n blocks: how a global stick phase ends."""

from __future__ import annotations

import math

from stickslip.mechanics.flow.blocks.forces import force_tolerance, update_needed
from stickslip.mechanics.flow.blocks.saltation import needed_tangent
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    BlockMotion,
    BlockSystem,
    Floats,
)
from stickslip.mechanics.flow.system import BACKWARD, FORWARD, STICK
from stickslip.numerics.targets import kernel


@kernel(inline=True)
def growth(system: BlockSystem, block: int) -> float:
    """Growth of a needed force per displacement of all blocks together."""
    total = 0.0
    for k in range(system.first[block], system.first[block + 1]):
        total += system.stiffness[k]
    return total


@kernel
def onset(system: BlockSystem, directions: BlockDirections, motion: BlockMotion, d: Floats) -> int:
    """End of the global stick phase with differences `d`; return how many blocks leave."""
    n = motion.mode.shape[0]
    motion.x[0] = 0.0
    for i in range(n):
        if i > 0:
            motion.x[i] = motion.x[i - 1] + d[i - 1]
        motion.w[i] = 0.0
        motion.mode[i] = STICK
        motion.event[i] = 0
    update_needed(system, motion)
    shift = math.inf
    leader = 0
    for i in range(n):
        room = room_to_limit(system, motion, i)
        if room < shift:
            shift, leader = room, i
    for i in range(n):
        motion.x[i] += shift
    update_needed(system, motion)
    leaving = 0
    for i in range(n):
        side = 1.0 if growth(system, i) > 0.0 else -1.0
        limit = side * system.static[i]
        if i == leader or abs(motion.e[i] - limit) <= force_tolerance(system, motion, i):
            leaving += 1
            motion.mode[i] = BACKWARD if side > 0.0 else FORWARD
            motion.e[i] = limit
        else:
            motion.e[i] = min(max(motion.e[i], -system.static[i]), system.static[i])
    onset_tangents(system, directions, motion, leader)
    return leaving


@kernel(inline=True)
def room_to_limit(system: BlockSystem, motion: BlockMotion, block: int) -> float:
    """How far all blocks can move together before this one is at a limit."""
    per_length = growth(system, block)
    if per_length == 0.0:
        return math.inf
    side = 1.0 if per_length > 0.0 else -1.0
    return (side * system.static[block] - motion.e[block]) / per_length


@kernel
def onset_tangents(
    system: BlockSystem, directions: BlockDirections, motion: BlockMotion, leader: int
) -> None:
    """Differentiate the displacements at the onset, which keeps the leader at its limit."""
    side = 1.0 if growth(system, leader) > 0.0 else -1.0
    for column in range(motion.tangent_x.shape[1]):
        change = 0.0
        for i in range(motion.mode.shape[0]):
            if i > 0:
                change += directions.start[column, i - 1]
            motion.tangent_x[i, column] = change
            motion.tangent_w[i, column] = 0.0
        motion.tangent_phase[column] = directions.phase[column]
        needed = needed_tangent(system, directions, motion, leader, column)
        shift = (side * directions.static[column, leader] - needed) / growth(system, leader)
        for i in range(motion.mode.shape[0]):
            motion.tangent_x[i, column] += shift
