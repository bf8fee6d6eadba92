"""Transitions of contacts that share inertia: forces jump as others begin or cease to slip."""

# Derivation: docs/theory/plant.md.

from __future__ import annotations

import math

from stickslip.mechanics.flow.blocks.system import BlockMotion, BlockSystem, Floats
from stickslip.mechanics.flow.blocks.transitions import (
    FORCE_ROUNDING,
    force_tolerance,
    limit_row,
    move_tangents,
    needed_row,
    put_foot,
    row_rate,
    row_tangent,
    row_value,
    saltation,
    slides,
    stop,
)
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    FORWARD,
    LANDING,
    STICK,
)
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel

COUPLED: bool  # bound in templates: whether contacts share inertia

# Of a contact's inertia, what is none: sticking contacts hold all of it.
DEPENDENT = 1e-9
# Of the fastest relative velocity, what is rounding.
RESTS = 1e-13
# Of a mechanism's overload: those that are closer to the largest begin together.
ALIKE = 1e-10


@kernel
def exchange(system: BlockSystem, motion: BlockMotion) -> None:
    """Solve ``coupling f = rates`` for the forces of sticking contacts and the rates of others."""
    # One pivot after the other exchanges a force for a rate. What sticking contacts hold already
    # has no pivot: its force is free, its rate is given.
    response, bears = motion.joint.response, motion.joint.bears
    n = motion.mode.shape[0]
    for i in range(n):
        for j in range(n):
            response[i, j] = system.joint.coupling[i, j]
    for k in range(n):
        pivot = response[k, k]
        bears[k] = motion.mode[k] == STICK and pivot > DEPENDENT
        if not bears[k]:
            continue
        for i in range(n):
            if i != k:
                response[i, k] /= pivot
                for j in range(n):
                    if j != k:
                        response[i, j] -= response[i, k] * response[k, j]
        for j in range(n):
            response[k, j] = 1.0 / pivot if j == k else -response[k, j] / pivot


@kernel
def couple(system: BlockSystem, motion: BlockMotion) -> None:
    """Find what contacts that share inertia need, each while all others go on as they do."""
    joint, n = motion.joint, motion.mode.shape[0]
    exchange(system, motion)
    for i in range(n):
        joint.own[i], joint.size[i] = row_value(system, motion, needed_row(motion, i))
        if motion.mode[i] == STICK:
            joint.drive[i] = joint.own[i] if joint.bears[i] else 0.0
    for i in range(n):
        total, size = 0.0, 0.0
        for j in range(n):
            total += joint.response[i, j] * joint.drive[j]
            terms = joint.size[j] if motion.mode[j] == STICK else abs(joint.drive[j])
            size += abs(joint.response[i, j]) * terms
        own = joint.response[i, i]
        joint.pull[i] = total - joint.own[i]
        size += joint.size[i]
        if joint.bears[i]:
            motion.e[i], joint.pull[i] = total, 0.0
        elif own > DEPENDENT:
            motion.e[i] = joint.drive[i] - joint.pull[i] / own
            size /= own
        else:
            motion.e[i] = joint.drive[i]
        # Rounding is that of all modes tried since the state was reached.
        motion.size[i] = max(motion.size[i], size)
        if abs(abs(motion.e[i]) - motion.limit[i]) <= force_tolerance(motion, i):
            motion.e[i] = math.copysign(motion.limit[i], motion.e[i])


@kernel
def overload(system: BlockSystem, motion: BlockMotion, way: int) -> tuple[float, float, float]:
    """Power of needed forces in a mechanism of sticking contacts; of limits; their rounding."""
    power = most = rounding = 0.0
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] == STICK:
            share = system.joint.mechanisms[way, i]
            power += share * motion.e[i]
            most += abs(share) * motion.limit[i]
            rounding += abs(share) * force_tolerance(motion, i)
    return power, most, rounding


@kernel
def settle_together(system: BlockSystem, laws: Floats, motion: BlockMotion) -> bool:
    """Change the modes of contacts that share inertia, at an event; tell whether any changed."""
    # Needed forces jump with the modes of others. All contacts at rest stick as far as they can:
    # the most overloaded mechanism begins to slip, forces are found anew, and so on; a slip that
    # would go against its direction is taken back. Without an answer nothing changes.
    joint, n = motion.joint, motion.mode.shape[0]
    for i in range(n):
        joint.before[i] = motion.mode[i]
        if motion.event[i] != 0:
            stop(motion, i)
    take_events(laws, motion)
    stop_with_others(system, motion)
    for i in range(n):
        if slides(system, motion, i):
            put_foot(system, laws, motion, i)
    for _ in range(4 * n + 4):
        couple(system, motion)
        if not release(system, laws, motion) and not take_back(motion):
            for i in range(n):
                if motion.mode[i] != joint.before[i]:
                    return True
            return False
    for i in range(n):
        motion.mode[i] = joint.before[i]
    return False


@kernel
def take_events(laws: Floats, motion: BlockMotion) -> None:
    """Give contacts at rest the modes that events name; slips have the friction of a start."""
    for i in range(motion.mode.shape[0]):
        event = motion.event[i]
        motion.event[i] = 0
        if event == LANDING:
            motion.mode[i] = STICK
        elif event != 0:
            mode = BACKWARD if event == AT_UPPER_LIMIT else FORWARD
            motion.mode[i] = mode
            static = laws[i, STATIC_COLUMN + (mode == FORWARD)]
            motion.joint.drive[i] = -mode * motion.limit[i] * static


@kernel
def stop_with_others(system: BlockSystem, motion: BlockMotion) -> None:
    """Put contacts to rest that those at rest hold: their velocity is rounding."""
    exchange(system, motion)
    joint = motion.joint
    for i in range(motion.mode.shape[0]):
        joint.fastest[0] = max(joint.fastest[0], abs(motion.w[i]))
    for i in range(motion.mode.shape[0]):
        held = motion.mode[i] != STICK and joint.response[i, i] <= DEPENDENT
        if held and abs(motion.w[i]) <= RESTS * joint.fastest[0]:
            stop(motion, i)
            motion.mode[i] = STICK


@kernel
def release(system: BlockSystem, laws: Floats, motion: BlockMotion) -> bool:
    """Let the most overloaded mechanism of sticking contacts slip; tell whether there is one."""
    joint, n, n_ways = motion.joint, motion.mode.shape[0], system.joint.mechanisms.shape[0]
    for i in range(n):  # others carry it along, and what it rubs on turns away
        carried = motion.mode[i] == STICK and not joint.bears[i]
        if carried and abs(joint.pull[i]) > FORCE_ROUNDING * EPSILON * motion.size[i]:
            motion.event[i] = AT_LOWER_LIMIT if joint.pull[i] > 0.0 else AT_UPPER_LIMIT
            take_events(laws, motion)
            return True
    most = 1.0
    for way in range(n_ways):
        power, limit, rounding = overload(system, motion, way)
        if abs(power) > limit + rounding:
            most = max(most, abs(power) / limit)
    for way in range(n_ways):
        power, limit, rounding = overload(system, motion, way)
        if abs(power) > limit + rounding and abs(power) >= most * (1.0 - ALIKE) * limit:
            begin(system, motion, way, power)
    take_events(laws, motion)
    return most > 1.0


@kernel
def begin(system: BlockSystem, motion: BlockMotion, way: int, side: float) -> None:
    """Note the events of sticking contacts that begin to slip in a mechanism."""
    for i in range(motion.mode.shape[0]):
        share = side * system.joint.mechanisms[way, i]
        if motion.mode[i] == STICK and share != 0.0:
            motion.event[i] = AT_UPPER_LIMIT if share > 0.0 else AT_LOWER_LIMIT


@kernel
def take_back(motion: BlockMotion) -> bool:
    """Let contacts at rest stick whose slip would go against its direction; tell whether any."""
    joint, taken = motion.joint, False
    for i in range(motion.mode.shape[0]):
        mode = motion.mode[i]
        if mode != STICK and motion.w[i] == 0.0:
            rounding = 2.0 * force_tolerance(motion, i)  # of this sum, and of that while it stuck
            if joint.response[i, i] <= DEPENDENT:  # others hold it
                back = abs(joint.pull[i]) <= rounding
            else:
                back = mode * (joint.drive[i] - motion.e[i]) < -rounding
            if back:
                motion.mode[i] = STICK
                taken = True
    return taken


@kernel
def saltation_together(system: BlockSystem, motion: BlockMotion, rates: Floats) -> None:
    """Move the tangents to an event, as `saltation`; a mechanism's overload reaches 0 there."""
    joint, n = motion.joint, motion.mode.shape[0]
    if joint.way[0] == 0:
        saltation(system, motion, rates)
        return
    side = 1.0 if joint.way[0] > 0 else -1.0
    rate = rounding = 0.0
    motion.shift[:] = 0.0
    for i in range(n):
        share = side * system.joint.mechanisms[abs(joint.way[0]) - 1, i]
        if motion.mode[i] != STICK or share == 0.0:
            continue
        rounding += abs(share) * force_tolerance(motion, i)
        rate -= abs(share) * row_rate(system, motion, rates, limit_row(motion, i))
        for column in range(motion.shift.shape[0]):
            moved = row_tangent(system, motion.directions, motion, limit_row(motion, i), column)
            motion.shift[column] += abs(share) * moved
        for j in range(n):
            part = share * joint.response[i, j] if joint.bears[i] else 0.0
            rate += part * joint.rate[j]
            for column in range(motion.shift.shape[0]):
                motion.shift[column] -= part * joint.tangent[j, column]
    if abs(rate) > rounding:
        for column in range(motion.shift.shape[0]):
            motion.shift[column] /= rate
        move_tangents(system, motion, rates)
    else:
        motion.shift[:] = math.nan
