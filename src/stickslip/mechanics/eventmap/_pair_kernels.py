"""How motions of two undamped equal blocks start and end: from global stick to global stick."""

# Template (`numerics.targets.instantiate`): the stepper is bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stickslip.mechanics.eventmap.itinerary import all_have
from stickslip.mechanics.eventmap.records import STATE
from stickslip.mechanics.flow.system import (
    ALPHA,
    AT_UPPER_LIMIT,
    BACKWARD,
    BETA,
    FORWARD,
    LANDING,
    START,
    STICK,
    Floats,
    Motion,
    System,
    limit,
    loading_rate,
    put_exactly,
)
from stickslip.mechanics.flow.transitions import onset, settle
from stickslip.numerics.rounding import two_sum
from stickslip.numerics.targets import kernel
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.mechanics.flow._exact_kernels import landing_rate

Traps = Any  # rows of a block, then the corners of a region of its releases; or None
# Numbers of a point at which one block is released while the other slips: block, w, e.
TURN = 3


@kernel(inline=True)
def change_modes(system: System, laws: Floats, motion: Motion, work: Any) -> bool:
    """Change the modes of all blocks at an event; tell whether any changed."""
    first, second = motion.mode[0], motion.mode[1]
    settle(system, motion)
    return bool(motion.mode[0] != first or motion.mode[1] != second)


@kernel(inline=True)
def copy_rest(source: Any, target: Any) -> None:
    """Copy what a motion has besides state, modes and their tangents."""
    for block in range(2):
        target.w_low[block] = source.w_low[block]
        target.e_low[block] = source.e_low[block]


@kernel
def start_loop_tangent(system: System, motion: Motion, n_columns: int, moved: Floats) -> None:
    """Set the last four columns to the identity on the states of the present modes and event."""
    for j in range(4):
        for k in range(4):
            motion.tangent_z[j, n_columns + k] = 0.0
        # A block that starts to slip does so at w = 0 and its limit, as it did the turn before.
        block = j % 2
        begins = moved[j] == 0.0 and motion.mode[block] != STICK and motion.w[block] == 0.0
        if j >= 2:
            free = not begins or abs(motion.e[block]) != limit(system, block)
        else:
            free = not begins and motion.mode[block] != STICK
        if free:
            motion.tangent_z[j, n_columns + j] = 1.0


@kernel
def event_margin(system: System, laws: Floats, motion: Motion, work: Any) -> float:
    """Clearance at an event: of landings from a touch, of all from the static limits."""
    # A rider at its limit while the other slips forward may have come there tangentially.
    margin = math.inf
    for block in range(2):
        room = abs(limit(system, block) - abs(motion.e[block]))
        if motion.event[block] == LANDING:
            rate = abs(landing_rate(system, laws, motion, block))
            margin = min(margin, room, rate)
        elif motion.mode[block] == STICK and motion.event[block] == 0:
            margin = min(margin, room)
        elif motion.mode[block] == STICK and motion.mode[1 - block] == FORWARD:
            margin = min(margin, abs(loading_rate(system, motion.w, block)))
    return margin


@kernel
def begin(
    system: System, laws: Floats, section: Traps, motion: Motion, work: Any, point: Floats
) -> int:
    """Start a motion at a point, its events in ``motion.event``."""
    work.margin[0] = math.inf
    work.sliding[0] = 0.0
    if point.shape[0] == TURN:
        own = int(point[0])
        motion.mode[0] = motion.mode[1] = BACKWARD
        put_exactly(motion, own, 0.0, limit(system, own))
        put_exactly(motion, 1 - own, point[1], point[2])
        motion.event[own], motion.event[1 - own] = AT_UPPER_LIMIT, 0
        return OK
    if is_state(section, motion, point):
        for block in range(2):
            motion.mode[block], motion.event[block] = int(point[block]), int(point[2 + block])
            put_exactly(motion, block, point[4 + block], point[6 + block] * limit(system, block))
        return OK
    onset(system, motion, point[0])
    for block in range(2):
        motion.event[block] = 0 if motion.mode[block] == STICK else AT_UPPER_LIMIT
    if motion.mode[0] == motion.mode[1]:
        slope_of_tie(system, laws, motion, point[0])
        work.margin[0] = 0.0
    return OK


@kernel
def slope_of_tie(system: System, laws: Floats, motion: Motion, d: float) -> None:
    """Tangents where both blocks leave together: those of smaller d, block 1 a little earlier."""
    # Block 2 then leaves once its force, 1 + spread at the onset, has grown to beta at rate V.
    rate = landing_rate(system, laws, motion, 0)
    for column in range(motion.directions.shape[0]):
        direction = motion.directions[column]
        d_spread = (1.0 + 2.0 * system.alpha) * direction[START] + 2.0 * d * direction[ALPHA]
        delay = (direction[BETA] - d_spread) / system.V
        motion.tangent_w[0, column] = rate * delay
        motion.tangent_e[0, column] = system.V * delay


@kernel(inline=True)
def is_state(section: Traps, motion: Motion, point: Floats) -> bool:
    """Whether a point is a state at an event on the way."""
    return bool(point.shape[0] == STATE)


@kernel(inline=True)
def has_arrived(section: Traps, motion: Motion, before: int, point: Floats) -> bool:
    """Whether an event ends a motion."""
    if point.shape[0] == TURN and leaves_alone(motion, int(point[0])):
        return True
    return all_have(motion, STICK)


@kernel(inline=True)
def leaves_alone(motion: Motion, own: int) -> bool:
    """Whether a block has just been released backward, and the other slips backward already."""
    other = 1 - own
    if motion.event[own] != AT_UPPER_LIMIT or motion.event[other] != 0:
        return False
    return bool(motion.mode[own] == BACKWARD and motion.mode[other] == BACKWARD)


@kernel(inline=True)
def is_trapped(section: Traps, motion: Motion) -> bool:
    """Whether a motion has entered a region of releases that no motion leaves."""
    if section is None:
        return False
    for k in range(section.shape[0]):
        trap = section[k]
        own = int(trap[0])
        if leaves_alone(motion, own) and is_within(trap[1:], motion.w[1 - own], motion.e[1 - own]):
            return True
    return False


@kernel(inline=True)
def is_within(corners: Floats, x: float, y: float) -> bool:
    """Whether a point lies within a polygon, x and y of its corners one after the other."""
    inside = False
    n = corners.shape[0]
    x_1, y_1 = corners[n - 2], corners[n - 1]
    for k in range(0, n, 2):
        x_2, y_2 = corners[k], corners[k + 1]
        if (y_1 > y) != (y_2 > y) and x < x_1 + (x_2 - x_1) * (y - y_1) / (y_2 - y_1):
            inside = not inside
        x_1, y_1 = x_2, y_2
    return inside


@kernel
def difference(system: System, motion: Motion) -> float:
    """D = (e_2 - e_1) / (1 + 2 alpha) at the present state."""
    gap, low = two_sum(motion.e[1], -motion.e[0])
    low += motion.e_low[1] - motion.e_low[0]
    return (gap + low) / (1.0 + 2.0 * system.alpha)


@kernel(inline=True)
def read_point(section: Traps, system: System, motion: Motion, point: Floats) -> None:
    """Point at the present state."""
    if point.shape[0] == TURN:
        own = 0 if motion.event[0] == AT_UPPER_LIMIT else 1
        point[0] = math.nan if all_have(motion, STICK) else own
        point[1], point[2] = motion.w[1 - own], motion.e[1 - own]
        return
    point[0] = difference(system, motion)


@kernel
def read_tangent(section: Traps, system: System, motion: Motion, slopes: Floats) -> None:
    """Differentiate what `read_point` tells, in all directions."""
    value = difference(system, motion)
    for column in range(slopes.shape[1]):
        slopes[0, column] = value_tangent(system, motion, value, column)


@kernel
def value_tangent(system: System, motion: Motion, value: float, column: int) -> float:
    """Differentiate d = (e_2 - e_1) / (1 + 2 alpha) in the direction of a column."""
    difference = motion.tangent_e[1, column] - motion.tangent_e[0, column]
    growth = 2.0 * value * motion.directions[column, ALPHA]
    return (difference - growth) / (1.0 + 2.0 * system.alpha)
