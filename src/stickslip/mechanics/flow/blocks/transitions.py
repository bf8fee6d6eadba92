"""Transitions of n blocks: needed forces, onset, modes at an event, tangents through events."""

from __future__ import annotations

import math

from stickslip.mechanics.flow.blocks.system import BlockDirections, BlockMotion, BlockSystem, Floats
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    FORWARD,
    LANDING,
    STICK,
)
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
    """Change the modes of all blocks at an event, once; tell whether any changed."""
    # Needed forces are continuous there; `rates` (w' just before) matter exactly at a limit alone.
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
