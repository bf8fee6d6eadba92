"""Maps of a plant: from one global stick phase to the next, or from one event of a contact."""

# Template (`numerics.targets.instantiate`): the stepper is bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.itinerary import hashed
from stickslip.mechanics.eventmap.loop import Loop, row_norm, settles
from stickslip.mechanics.eventmap.records import BlockScratch, Controls, Outputs, Section
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
    MAX_INSTANT,
    STICK,
)
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.status import (
    EVENT_LIMIT,
    NEVER_CYCLE,
    NEVER_SLIPPING,
    NO_EVENT,
    OK,
    STEP_FAILED,
    TIME_LIMIT,
    UNDECIDED,
)

if TYPE_CHECKING:
    from stickslip.mechanics.flow.blocks._stepper_kernels import (
        advance,
        landing_rate,
        rate,
        slides_for_ever,
    )

# From this many events per block on a motion is watched for a cycle without global stick.
LONG = 32
# Steps without an event after which a motion is given up.
MAX_QUIET = 20_000
# Steps on which no relative velocity changes any more, after which the motion slides steadily.
STEADY = 64
# A contact whose relative velocity changes no faster slides steadily.
AT_REST = 1e-10
# Steps without an event, for each event allowed, before a motion is given up.
STEPS_PER_EVENT = 200
TURN = 2.0 * math.pi
# Of the terms that cancel: relative velocities this small at a section are those of sticking.
NO_SLIP = 64.0 * EPSILON
# Modes that a number of 64 bits tells.
CODED = 32


@kernel
def noted(label: np.uint64, motion: BlockMotion) -> np.uint64:
    """Hash of an itinerary with one more set of modes: of two blocks, that of their engines."""
    code = 0
    for i in range(motion.mode.shape[0]):
        code = 3 * code + motion.mode[i] + 1
        if i % CODED == CODED - 1:
            label, code = hashed(label, code), 0
    return hashed(label, code)


@kernel
def all_ride(motion: BlockMotion) -> bool:
    """Whether all blocks stick."""
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != STICK:
            return False
    return True


@kernel
def write_modes(motion: BlockMotion, row: NDArray[np.int8]) -> None:
    """Keep the modes of a phase."""
    for i in range(motion.mode.shape[0]):
        row[i] = motion.mode[i]


@kernel
def copy_motion(source: BlockMotion, target: BlockMotion) -> None:
    """Copy the state and the tangents that both have columns for."""
    for i in range(source.mode.shape[0]):
        target.e[i] = source.e[i]
        target.limit[i] = source.limit[i]
        target.mode[i] = source.mode[i]
    for j in range(source.z.shape[0]):
        target.z[j] = source.z[j]
        for column in range(min(source.tangent_z.shape[1], target.tangent_z.shape[1])):
            target.tangent_z[j, column] = source.tangent_z[j, column]
    target.clock[0] = source.clock[0]
    for column in range(min(source.tangent_clock.shape[0], target.tangent_clock.shape[0])):
        target.tangent_clock[column] = source.tangent_clock[column]


@kernel
def distance(motion: BlockMotion, saved: BlockMotion) -> float:
    """Distance of two states, infinite between different modes."""
    largest = 0.0
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != saved.mode[i]:
            return math.inf
    for j in range(motion.z.shape[0]):
        largest = max(largest, abs(motion.z[j] - saved.z[j]))
    return largest


@kernel
def start_loop_tangent(system: BlockSystem, motion: BlockMotion, n_columns: int) -> None:
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
def write_shift(motion: BlockMotion, saved: BlockMotion, shift: Floats) -> None:
    """Keep how far a state is from an earlier one."""
    for j in range(motion.z.shape[0]):
        shift[j] = motion.z[j] - saved.z[j]


@kernel
def write_turn(motion: BlockMotion, saved: BlockMotion, n_columns: int, loop: Loop) -> None:
    """Keep what a turn has made of a state and its tangent."""
    write_shift(motion, saved, loop.moved)
    for j in range(motion.z.shape[0]):
        for k in range(motion.z.shape[0]):
            loop.turn[j, k] = motion.tangent_z[j, n_columns + k]


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


@kernel
def count_events(motion: BlockMotion) -> int:
    """How many blocks are at an event."""
    count = 0
    for i in range(motion.mode.shape[0]):
        if motion.event[i] != 0:
            count += 1
    return count


# --- a section ----------------------------------------------------------------------------------


@kernel
def starting_event(section: Section) -> int:
    """Event of the section's contact that a motion starts and ends with."""
    if not section.released:
        return LANDING
    return AT_UPPER_LIMIT if section.mode == BACKWARD else AT_LOWER_LIMIT


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
def read_point(section: Section, motion: BlockMotion, point: Floats) -> None:
    """Point of the section, or of global stick, at the present state."""
    for k in range(point.shape[0]):
        point[k], _ = row_value(section.out, motion, k)
    if section.period > 0.0:
        turns = motion.clock[0] / section.period
        point[0] = TURN * (turns - math.floor(turns))


@kernel
def read_tangent(section: Section, motion: BlockMotion, slopes: Floats) -> None:
    """Differentiate what `read_point` tells, in all directions."""
    change = section.changes
    for column in range(motion.tangent_z.shape[1]):
        for k in range(slopes.shape[0]):
            slopes[k, column] = row_tangent(section.out, change.out, motion, k, column)
        if section.period > 0.0:
            turns = motion.clock[0] / section.period
            moved = motion.tangent_clock[column] - turns * change.period[column]
            slopes[0, column] = TURN / section.period * moved


@kernel(inline=True)
def has_arrived(section: Section, motion: BlockMotion, before: int) -> bool:
    """Whether an event ends a motion; `before`: the mode of the section's contact."""
    own = section.contact
    if own < 0:
        return all_ride(motion)
    if section.released:
        return motion.event[own] == starting_event(section) and before == STICK
    return motion.event[own] == LANDING and before == section.mode


# --- motions ------------------------------------------------------------------------------------


@kernel
def slides_steadily(motion: BlockMotion, work: BlockWork) -> bool:
    """Whether all contacts slip at velocities that change no more."""
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] == STICK or abs(work.rates[i]) > AT_REST:
            return False
    return True


@kernel
def carry(
    system: BlockSystem,
    laws: Floats,
    section: Section,
    point: Floats,
    scratch: BlockScratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, int, np.uint64, float, int]:
    """Follow a motion from a point of a section to the next, left in ``scratch.motion``."""
    # (duration, events, label, margin, status); `itinerary` (phases, n) takes modes while it lasts.
    motion, directions, long_motion, long_directions, saved, loop, work = scratch
    n, n_columns = motion.mode.shape[0], motion.tangent_z.shape[1]
    own = section.contact
    if own < 0:
        work.margin[0] = 0.0 if onset(system, directions, motion, point) > 1 else math.inf
    else:
        work.margin[0] = start_on(section, system, laws, motion, work, point)
        if not work.margin[0] > 0.0:
            return 0.0, 0, np.uint64(0), -work.margin[0], NO_EVENT
    watching = work.watch[0]
    current, current_directions = motion, directions
    label = noted(np.uint64(1), current)
    if itinerary.shape[0] > 0:
        write_modes(current, itinerary[0])
    duration = phase = 0.0
    earlier_margin = math.inf
    n_events = instant = quiet = steady = 0
    # A state is kept, now and then; two turns from it on, the second with its tangent, may tell.
    kept, next_look, turn_ends = 0, LONG * n, 0
    near, growth, looping = math.inf, 1.0, False
    status = TIME_LIMIT
    for _ in range(STEPS_PER_EVENT * (controls.max_events + LONG * n)):
        if slides_for_ever(system, laws, current, work):
            status = NEVER_SLIPPING
            break
        t, status = advance(
            system, laws, current_directions, current, work, controls.rtol, math.inf
        )
        duration += t
        phase += t
        if status != OK:
            break
        if not math.isfinite(current.e[0]):
            status = STEP_FAILED
            break
        status = TIME_LIMIT
        if duration > controls.max_time:
            break
        here = count_events(current)
        if here == 0:
            quiet += 1
            steady = steady + 1 if slides_steadily(current, work) else 0
            if steady == STEADY:
                status = NEVER_CYCLE
            if quiet == MAX_QUIET or steady == STEADY:
                break
            continue
        quiet = 0
        if work.watch[0] != 0.0:
            margin = event_margin(system, laws, current, work)
            margin = 0.0 if here > 1 else min(margin, phase)
            work.margin[0] = min(work.margin[0], margin)
        instant = instant + 1 if phase == 0.0 else 0
        phase = 0.0
        before = current.mode[own]
        if not settle(system, laws, current, work.rates):
            if instant > MAX_INSTANT * n:
                status = UNDECIDED
                break
            continue
        label = noted(label, current)
        n_events += 1
        if n_events < itinerary.shape[0]:
            write_modes(current, itinerary[n_events])
        if has_arrived(section, current, before):
            status = OK
            break
        if instant > MAX_INSTANT * n:
            status = UNDECIDED
            break
        if n_events >= controls.max_events:
            status = EVENT_LIMIT
            break
        if n_events < LONG * n:
            continue
        if looping:
            growth = max(growth, row_norm(current.tangent_z[:, n_columns:]))
            if n_events < turn_ends:
                continue
            if distance(current, saved) < math.inf:
                write_turn(current, saved, n_columns, loop)
                if settles(loop, work.margin[0] / growth):
                    status = NEVER_CYCLE
                    break
            copy_motion(current, motion)
            current, current_directions, looping = motion, directions, False
            work.watch[0] = watching
            next_look = n_events
        elif kept > 0:
            gap = distance(current, saved)
            if gap < near:
                write_shift(current, saved, loop.earlier)
                turn_ends, near, growth = 2 * n_events - kept, 0.5 * gap, 1.0
                copy_motion(motion, long_motion)
                current, current_directions, looping = long_motion, long_directions, True
                start_loop_tangent(system, current, n_columns)
                copy_motion(current, saved)
                earlier_margin = min(earlier_margin, work.margin[0])
                work.margin[0], work.watch[0] = math.inf, 1.0
        if n_events >= next_look and not looping:
            copy_motion(current, saved)
            kept, next_look = n_events, n_events + n_events // 4
    work.watch[0] = watching
    if looping:
        copy_motion(current, motion)
    margin = min(earlier_margin, work.margin[0])
    if section.period > 0.0:  # where the phase passes 0, the next point jumps
        turns = math.floor(motion.clock[0] / section.period)
        label = hashed(label, turns - 1)
        past = motion.clock[0] - turns * section.period
        margin = min(margin, past, section.period - past)
    return duration, n_events, label, margin, status


@kernel
def is_nan(d: Floats) -> bool:
    """Whether an entry is NaN."""
    for k in range(d.shape[0]):
        if math.isnan(d[k]):
            return True
    return False


@kernel
def carry_range(
    system: BlockSystem,
    laws: Floats,
    section: Section,
    points: Floats,
    start: int,
    stop: int,
    scratch: BlockScratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    outputs: Outputs,
) -> None:
    """Evaluate the map at rows ``points[start:stop]``; `itinerary`: of the last motion."""
    motion = scratch.motion
    for i in range(start, stop):
        if is_nan(points[i]):
            continue
        duration, n_events, label, margin, status = carry(
            system, laws, section, points[i], scratch, controls, itinerary
        )
        outputs.duration[i] = duration
        outputs.n_events[i] = n_events
        outputs.label[i] = label
        outputs.margin[i] = margin
        outputs.status[i] = status
        if status == OK:
            read_point(section, motion, outputs.value[i])
            read_tangent(section, motion, outputs.derivative[i])


@kernel
def iterate_range(
    system: BlockSystem,
    laws: Floats,
    section: Section,
    orbits: Floats,
    start: int,
    stop: int,
    scratch: BlockScratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> None:
    """Fill rows ``start..stop`` of `orbits` (starts, steps + 1, numbers) from their starts."""
    for i in range(start, stop):
        for k in range(orbits.shape[1] - 1):
            status = EVENT_LIMIT
            if not is_nan(orbits[i, k]):
                _, _, _, _, status = carry(
                    system, laws, section, orbits[i, k], scratch, controls, itinerary
                )
            if status == OK:
                read_point(section, scratch.motion, orbits[i, k + 1])
            else:
                orbits[i, k + 1] = math.nan  # and stays so
