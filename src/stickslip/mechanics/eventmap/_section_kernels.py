"""How motions of a plant start and end: a global stick phase, an event of a contact."""

# Template (`numerics.targets.instantiate`): the stepper is bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stickslip.mechanics.eventmap.itinerary import all_have
from stickslip.mechanics.eventmap.records import STATE, Section
from stickslip.mechanics.flow.blocks.system import BlockMotion, BlockSystem, BlockWork, Floats
from stickslip.mechanics.flow.blocks.transitions import (
    excess_rate,
    onset,
    row_tangent,
    row_value,
    set_waves,
    settle,
    update_needed,
)
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    LANDING,
    STICK,
)
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.status import NO_EVENT, OK

if TYPE_CHECKING:
    from stickslip.mechanics.flow.blocks._stepper_kernels import landing_rate, rate

SECTIONS: bool  # bound in `_kernels`: whether these are the kernels of its motions

# A contact whose relative velocity changes no faster slides steadily.
AT_REST = 1e-10
TURN = 2.0 * math.pi
# Of the terms that cancel: relative velocities this small at a section are those of sticking.
NO_SLIP = 64.0 * EPSILON


@kernel(inline=True)
def change_modes(system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork) -> bool:
    """Change the modes of all blocks at an event; tell whether any changed."""
    return settle(system, laws, motion, work.rates)


@kernel(inline=True)
def copy_rest(source: Any, target: Any) -> None:
    """Copy what a motion has besides state, modes and their tangents."""
    for i in range(source.mode.shape[0]):
        target.limit[i] = source.limit[i]
    target.clock[0] = source.clock[0]
    for column in range(min(source.tangent_clock.shape[0], target.tangent_clock.shape[0])):
        target.tangent_clock[column] = source.tangent_clock[column]


@kernel
def slides_steadily(motion: BlockMotion, work: BlockWork) -> bool:
    """Whether all contacts slip at velocities that change no more."""
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] == STICK or abs(work.rates[i]) > AT_REST:
            return False
    return True


@kernel
def start_loop_tangent(
    system: BlockSystem, motion: BlockMotion, n_columns: int, _moved: Floats
) -> None:
    """Set the last columns to the identity on states of the present modes and on the clock."""
    n_free, n, n_harmonics = motion.y.shape[0], motion.z.shape[0], system.frequency.shape[0]
    for j in range(n):
        for column in range(n_columns, n_columns + n):
            motion.tangent_z[j, column] = 0.0
        if j < n_free or motion.mode[j - n_free] != STICK:
            motion.tangent_z[j, n_columns + j] = 1.0
    pace = 0.0
    for k in range(n_harmonics):
        pace += system.frequency[k] ** 2
    # The clock turns all waves together: a projection on how they move with it.
    for j in range(2 * n_harmonics):
        for k in range(2 * n_harmonics):
            both = wave_rate(system, motion, j) * wave_rate(system, motion, k)
            motion.tangent_z[j, n_columns + k] = both / pace


@kernel(inline=True)
def wave_rate(system: BlockSystem, motion: BlockMotion, j: int) -> float:
    """Rate of a wave: of the cosines, then of the sines."""
    n = system.frequency.shape[0]
    if j < n:
        return -system.frequency[j] * motion.z[n + j]
    return system.frequency[j - n] * motion.z[j - n]


@kernel
def event_margin(system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork) -> float:
    """Clearance at an event: of landings from a touch, of all blocks from their limits."""
    margin = math.inf
    for i in range(motion.mode.shape[0]):
        room = abs(motion.limit[i] - abs(motion.e[i]))
        if motion.event[i] == LANDING:
            margin = min(margin, room, abs(landing_rate(system, laws, motion, i)))
        elif motion.mode[i] == STICK and motion.event[i] == 0:
            margin = min(margin, room)
        elif motion.mode[i] == STICK:
            margin = min(margin, abs(excess_rate(system, motion, work.rates, i, 1.0)))
    return margin


# --- points ---------------------------------------------------------------------------------------


@kernel
def begin(
    system: BlockSystem,
    laws: Floats,
    section: Section,
    motion: BlockMotion,
    work: BlockWork,
    point: Floats,
) -> int:
    """Start a motion at a point, its events in ``motion.event``; NO_EVENT if it does not."""
    own = section.contact
    if is_state(section, motion, point):
        work.margin[0] = math.inf
        start_from(system, motion, point)
        return OK
    if own < 0:
        work.margin[0] = 0.0 if onset(system, motion, point) > 1 else math.inf
        for i in range(motion.mode.shape[0]):
            motion.event[i] = 0 if motion.mode[i] == STICK else AT_UPPER_LIMIT
        return OK
    pace = start_on(section, system, laws, motion, work, point)
    work.margin[0] = pace if pace > 0.0 else -pace
    motion.event[:] = 0
    motion.event[own] = starting_event(section)
    return OK if pace > 0.0 else NO_EVENT


@kernel(inline=True)
def is_state(section: Section, motion: BlockMotion, point: Floats) -> bool:
    """Whether a point is a state of two blocks at an event on the way."""
    two = section.contact < 0 and motion.mode.shape[0] == 2  # their points are one number
    return bool(two and point.shape[0] == STATE)


@kernel
def start_from(system: BlockSystem, motion: BlockMotion, state: Floats) -> None:
    """Start two blocks from a state: where they need its forces, which are affine in places."""
    motion.clock[0] = 0.0
    for i in range(2):
        motion.mode[i], motion.event[i] = int(state[i]), int(state[2 + i])
        motion.w[i], motion.y[i] = state[4 + i], 0.0
    update_needed(system, motion)
    still, still_2 = motion.e
    motion.y[0] = 1.0
    update_needed(system, motion)
    a, a_2 = motion.e[0] - still, motion.e[1] - still_2
    motion.y[0], motion.y[1] = 0.0, 1.0
    update_needed(system, motion)
    b, b_2 = motion.e[0] - still, motion.e[1] - still_2
    force, force_2 = state[6] * motion.limit[0], state[7] * motion.limit[1]
    more, more_2, size = force - still, force_2 - still_2, a * b_2 - b * a_2
    motion.y[0], motion.y[1] = (b_2 * more - b * more_2) / size, (a * more_2 - a_2 * more) / size
    update_needed(system, motion)
    motion.e[0], motion.e[1] = force, force_2


@kernel
def starting_event(section: Section) -> int:
    """Event of the section's contact that a motion starts and ends with."""
    if not section.released:
        return LANDING
    return AT_UPPER_LIMIT if section.mode == BACKWARD else AT_LOWER_LIMIT


@kernel(inline=True)
def has_arrived(section: Section, motion: BlockMotion, before: int, point: Floats) -> bool:
    """Whether an event ends a motion; `before`: the mode of the section's contact."""
    own = section.contact
    if own < 0:
        return all_have(motion, STICK)
    if section.released:
        return motion.event[own] == starting_event(section) and before == STICK
    return motion.event[own] == LANDING and before == section.mode


@kernel(inline=True)
def is_trapped(section: Section, motion: BlockMotion) -> bool:
    """Whether a motion is known never to end: not here."""
    return False


@kernel
def start_on(
    section: Section,
    system: BlockSystem,
    laws: Floats,
    motion: BlockMotion,
    work: BlockWork,
    point: Floats,
) -> float:
    """Start at a point of a section; the rate of its signal, positive where its event happens."""
    own, n_waves = section.contact, 2 * system.frequency.shape[0]
    motion.clock[0] = point[0] * section.period / TURN if section.period > 0.0 else 0.0
    set_waves(system, motion)
    n_free = motion.y.shape[0]
    for i in range(section.into.shape[0]):
        value, size = affine(section.into[i], motion.z, n_waves, point)
        at_rest = n_waves + i >= n_free and abs(value) <= NO_SLIP * size
        motion.z[n_waves + i] = 0.0 if at_rest else value
    motion.w[own] = 0.0
    update_needed(system, motion)
    for i in range(motion.mode.shape[0]):
        motion.mode[i] = 0 if motion.w[i] == 0.0 else int(math.copysign(1.0, motion.w[i]))
        motion.event[i] = LANDING if motion.w[i] == 0.0 else 0
        work.rates[i] = rate(system, laws, motion, i)
    motion.mode[own] = section.mode
    motion.event[own] = starting_event(section)
    if section.released:
        motion.e[own] = -section.mode * motion.limit[own]
        side = -1.0 * section.mode
        pace = side * excess_rate(system, motion, work.rates, own, side)
    else:
        pace = -section.mode * landing_rate(system, laws, motion, own)
    settle(system, laws, motion, work.rates)
    for column in range(motion.tangent_z.shape[1]):
        start_tangent(section, system, motion, point, column)
    return pace


@kernel(inline=True)
def affine(row: Floats, waves: Floats, n_waves: int, point: Floats) -> tuple[float, float]:
    """Row of ``Section.into`` times (waves, point, 1), and the size of its terms."""
    n_point = point.shape[0]
    total = row[n_waves + n_point]
    size = abs(total)
    for j in range(n_waves):
        total += row[j] * waves[j]
        size += abs(row[j])
    for k in range(n_point):
        term = row[n_waves + k] * point[k]
        total += term
        size += abs(term)
    return total, size


@kernel
def start_tangent(
    section: Section, system: BlockSystem, motion: BlockMotion, point: Floats, column: int
) -> None:
    """Tangent of the start in a direction: of the point, of the section, of the waves."""
    n_harmonics = system.frequency.shape[0]
    n_waves, change = 2 * n_harmonics, section.changes
    shift = 0.0
    if section.period > 0.0:
        shift = change.point[column, 0] * section.period + point[0] * change.period[column]
        shift /= TURN
    motion.tangent_clock[column] = shift
    for k in range(n_harmonics):
        turned = system.frequency[k] * shift + change.phase[column, k]
        turned += motion.clock[0] * change.frequency[column, k]
        motion.tangent_z[k, column] = -motion.z[n_harmonics + k] * turned
        motion.tangent_z[n_harmonics + k, column] = motion.z[k] * turned
    n_free = motion.y.shape[0]
    for i in range(section.into.shape[0]):
        j = n_waves + i
        total, _ = affine(change.into[column, i], motion.z, n_waves, point)
        for k in range(n_waves):
            total += section.into[i, k] * motion.tangent_z[k, column]
        for k in range(point.shape[0]):
            total += section.into[i, n_waves + k] * change.point[column, k]
        sticks = j >= n_free and motion.mode[j - n_free] == STICK
        motion.tangent_z[j, column] = 0.0 if sticks else total
    motion.tangent_w[section.contact, column] = 0.0


@kernel
def read_point(section: Section, system: BlockSystem, motion: BlockMotion, point: Floats) -> None:
    """Point of the section, or of global stick, at the present state."""
    for k in range(point.shape[0]):
        point[k], _ = row_value(section.out, motion, k)
    if section.period > 0.0:
        turns = motion.clock[0] / section.period
        point[0] = TURN * (turns - math.floor(turns))


@kernel
def read_tangent(
    section: Section, system: BlockSystem, motion: BlockMotion, slopes: Floats
) -> None:
    """Differentiate what `read_point` tells, in all directions."""
    change = section.changes
    for column in range(motion.tangent_z.shape[1]):
        for k in range(slopes.shape[0]):
            slopes[k, column] = row_tangent(section.out, change.out, motion, k, column)
        if section.period > 0.0:
            turns = motion.clock[0] / section.period
            moved = motion.tangent_clock[column] - turns * change.period[column]
            slopes[0, column] = TURN / section.period * moved
