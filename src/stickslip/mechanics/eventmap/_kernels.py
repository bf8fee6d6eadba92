"""Motions from a point to the next, of any stepper: global stick phases, sections of a contact."""

# Template (`numerics.targets.instantiate`): the stepper is bound, and how its motions start and end
# (`_pair_kernels`, `_section_kernels`).

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.itinerary import all_have, hashed, noted
from stickslip.mechanics.eventmap.loop import Loop, excess, row_norm
from stickslip.mechanics.eventmap.records import Controls, Outputs, Scratch
from stickslip.mechanics.flow.blocks.system import BlockMotion
from stickslip.mechanics.flow.system import BACKWARD, MAX_INSTANT, STICK, Floats, Motion
from stickslip.numerics.targets import kernel
from stickslip.status import (
    EVENT_LIMIT,
    NEVER_CYCLE,
    NEVER_SLIPPING,
    OK,
    STEP_FAILED,
    TIME_LIMIT,
    UNDECIDED,
)

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._section_kernels import (
        SECTIONS,
        begin,
        change_modes,
        copy_rest,
        event_margin,
        has_arrived,
        is_state,
        is_trapped,
        read_point,
        read_tangent,
        slides_steadily,
        start_loop_tangent,
    )
    from stickslip.mechanics.flow.blocks._stepper_kernels import advance, slides_for_ever

# From this many events per block on a motion is watched for a cycle without global stick.
LONG = 8
# Up to this many, turns that contract are tested one after the other: most motions settle so.
EAGER = 64
# Steps without an event after which a motion on a section is given up.
MAX_QUIET = 20_000
# Steps on which no relative velocity changes any more, after which the motion slides steadily.
STEADY = 64
# Steps without an event, for each event allowed, before a motion is given up.
STEPS_PER_EVENT = 200


@kernel
def is_finite(motion: BlockMotion | Motion) -> bool:
    """Whether all needed forces are numbers."""
    for i in range(motion.mode.shape[0]):
        if not math.isfinite(motion.e[i]):
            return False
    return True


@kernel
def write_modes(motion: BlockMotion | Motion, row: NDArray[np.int8]) -> None:
    """Keep the modes of a phase."""
    for i in range(motion.mode.shape[0]):
        row[i] = motion.mode[i]


@kernel
def events_of(motion: BlockMotion | Motion) -> tuple[int, int]:
    """How many blocks are at an event, and a number that tells which."""
    count = which = 0
    for i in range(motion.mode.shape[0]):
        if motion.event[i] != 0:
            count += 1
            which = i + 1
    return count, which


# --- cycles -------------------------------------------------------------------------------------


@kernel
def copy_motion(source: BlockMotion | Motion, target: BlockMotion | Motion) -> None:
    """Copy the state and the tangents that both have columns for."""
    for i in range(source.mode.shape[0]):
        target.e[i] = source.e[i]
        target.mode[i] = source.mode[i]
        target.event[i] = source.event[i]
    for j in range(source.z.shape[0]):
        target.z[j] = source.z[j]
        for column in range(min(source.tangent_z.shape[1], target.tangent_z.shape[1])):
            target.tangent_z[j, column] = source.tangent_z[j, column]
    copy_rest(source, target)


@kernel
def distance(motion: BlockMotion | Motion, saved: BlockMotion | Motion) -> float:
    """Distance of two states, infinite between different modes or events."""
    largest = 0.0
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != saved.mode[i] or motion.event[i] != saved.event[i]:
            return math.inf
    for j in range(motion.z.shape[0]):
        largest = max(largest, abs(motion.z[j] - saved.z[j]))
    return largest


@kernel(inline=True)
def begins_slip(motion: BlockMotion | Motion) -> bool:
    """Whether a block begins to slip at the present event."""
    for i in range(motion.mode.shape[0]):
        if motion.event[i] != 0 and motion.mode[i] != STICK:
            return True
    return False


@kernel
def write_shift(motion: BlockMotion | Motion, saved: BlockMotion | Motion, shift: Floats) -> None:
    """Keep how far a state is from an earlier one."""
    for j in range(motion.z.shape[0]):
        shift[j] = motion.z[j] - saved.z[j]


@kernel
def write_turn(
    motion: BlockMotion | Motion, saved: BlockMotion | Motion, n_columns: int, loop: Loop
) -> None:
    """Keep what a turn has made of a state and its tangent."""
    write_shift(motion, saved, loop.moved)
    for j in range(motion.z.shape[0]):
        for k in range(motion.z.shape[0]):
            loop.turn[j, k] = motion.tangent_z[j, n_columns + k]


# --- motions ------------------------------------------------------------------------------------


@kernel
def carry(
    system: Any,
    laws: Floats,
    point: Floats,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, int, np.uint64, float, int]:
    """Follow a motion from a point to the next, left in ``scratch.motion``."""
    # (duration, events, label, margin, status); `itinerary` (phases, n) takes modes while it lasts.
    told, whole = follow(system, laws, point, scratch, controls, itinerary, True)
    if told[4] == OK and not whole:
        told, _ = follow(system, laws, point, scratch, controls, itinerary, False)
    return told


@kernel
def follow(
    system: Any,
    laws: Floats,
    point: Floats,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    lighten: bool,
) -> tuple[tuple[float, int, np.uint64, float, int], bool]:
    """As `carry`, and whether the tangents were carried to the end.

    `lighten`: not once turns contract, for then hardly a motion returns.
    """
    motion, long_motion, light, long_light, saved, loop, work, section, _ = scratch
    n, n_columns = motion.mode.shape[0], motion.tangent_z.shape[1]
    status = begin(system, laws, section, motion, work, point)
    if status != OK:
        return (0.0, 0, np.uint64(0), work.margin[0], status), True
    watching = work.watch[0]
    current = motion
    label = noted(np.uint64(1), current)
    if itinerary.shape[0] > 0:
        write_modes(current, itinerary[0])
    duration = phase = 0.0
    earlier_margin = math.inf
    n_events = instant = quiet = steady = before = 0
    count, last = events_of(motion)
    last = 0 if count > 1 else last
    # A state is kept, now and then; two turns from it on, the second with its tangent, may tell.
    first = 1 if is_state(section, motion, point) else LONG * n
    kept, next_look, span, turn_ends = 0, first, LONG * n // 4, 0
    near, growth, looping = math.inf, 1.0, False
    status = TIME_LIMIT
    for _ in range(STEPS_PER_EVENT * (controls.max_events + LONG * n)):
        if all_have(current, BACKWARD) and slides_for_ever(system, laws, current, work):
            status = NEVER_SLIPPING
            break
        t, status = advance(system, laws, current, work, controls.rtol, math.inf)
        duration += t
        phase += t
        if status != OK:
            break
        if not is_finite(current):
            status = STEP_FAILED
            break
        status = TIME_LIMIT
        if duration > controls.max_time:
            break
        count, here = events_of(current)
        if count == 0:
            if SECTIONS:
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
            if count > 1:
                margin = 0.0
            elif here != last:
                margin = min(margin, phase)
            work.margin[0] = min(work.margin[0], margin)
        last = 0 if count > 1 else here
        instant = instant + 1 if phase == 0.0 else 0
        phase = 0.0
        if SECTIONS:
            before = current.mode[section.contact]
        if not change_modes(system, laws, current, work):
            if instant > MAX_INSTANT * n:
                status = UNDECIDED
                break
            continue
        label = noted(label, current)
        n_events += 1
        if n_events < itinerary.shape[0]:
            write_modes(current, itinerary[n_events])
        if has_arrived(section, current, before, point):
            status = OK
            break
        if is_trapped(section, current):
            status = NEVER_CYCLE
            break
        if instant > MAX_INSTANT * n:
            status = UNDECIDED
            break
        if n_events >= controls.max_events:
            status = EVENT_LIMIT
            break
        if n_events < first:
            continue
        gap, goes_on = distance(current, saved) if kept > 0 else math.inf, False
        if looping:
            growth = max(growth, row_norm(current.tangent_z[:, n_columns:]))
            if n_events < turn_ends:
                continue
            times = math.inf
            if gap < math.inf:
                write_turn(current, saved, n_columns, loop)
                times = excess(loop, work.margin[0] / growth)
            if times < 1.0:
                status = NEVER_CYCLE
                break
            goes_on = times < math.inf and n_events < EAGER * n
            if times > 4.0 and not goes_on:
                near *= 0.5
            if lighten and n_columns > 0 and times < math.inf:
                motion, long_motion, n_columns = light, long_light, 0
            copy_motion(current, motion)
            current, looping = motion, False
            work.watch[0] = watching
            next_look = n_events
        if goes_on or gap < near:  # this turn is the first of two
            write_shift(current, saved, loop.earlier)
            turn_ends, near, growth = 2 * n_events - kept, min(near, gap), 1.0
            span = max(n_events - kept, LONG * n // 4)
            copy_motion(motion, long_motion)
            current, looping = long_motion, True
            start_loop_tangent(system, current, n_columns, loop.earlier)
            copy_motion(current, saved)
            kept = n_events
            earlier_margin = min(earlier_margin, work.margin[0])
            work.margin[0], work.watch[0] = math.inf, 1.0
        if n_events >= next_look and not looping and begins_slip(current):
            copy_motion(current, saved)
            kept, next_look = n_events, n_events + span
            span += 1 + span // 8
    work.watch[0] = watching
    if looping:
        copy_motion(current, motion)
    margin = min(earlier_margin, work.margin[0])
    if SECTIONS:
        if section.period > 0.0:  # where the phase passes 0, the next point jumps
            turns = math.floor(motion.clock[0] / section.period)
            label = hashed(label, turns - 1)
            past = motion.clock[0] - turns * section.period
            margin = min(margin, past, section.period - past)
    whole = n_columns == scratch.motion.tangent_z.shape[1]
    return (duration, n_events, label, margin, status), whole


@kernel
def carry_number(
    system: Any,
    laws: Floats,
    d: float,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, float, int, np.uint64, float, int]:
    """As `carry` where points are numbers: (value, duration, events, label, margin, status)."""
    scratch.point[0] = d
    duration, n_events, label, margin, status = carry(
        system, laws, scratch.point, scratch, controls, itinerary
    )
    value = math.nan
    if status == OK:
        read_point(scratch.section, system, scratch.motion, scratch.point)
        value = scratch.point[0]
    return value, duration, n_events, label, margin, status


@kernel
def is_nan(d: Floats) -> bool:
    """Whether an entry is NaN."""
    for k in range(d.shape[0]):
        if math.isnan(d[k]):
            return True
    return False


@kernel(short_loops=True)
def carry_range(
    system: Any,
    laws: Floats,
    points: Floats,
    start: int,
    stop: int,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    outputs: Outputs,
) -> None:
    """Iterate the map at rows ``points[start:stop]`` into `value` (starts, steps, numbers).

    All else is of the last motion. One kernel for all that Python asks: each that holds `carry`
    takes as long to compile as that.
    """
    for i in range(start, stop):
        point = points[i]
        for k in range(outputs.value.shape[1]):
            if is_nan(point):
                break
            duration, n_events, label, margin, status = carry(
                system, laws, point, scratch, controls, itinerary
            )
            outputs.duration[i] = duration
            outputs.n_events[i] = n_events
            outputs.label[i] = label
            outputs.margin[i] = margin
            outputs.status[i] = status
            if status != OK:
                break
            read_point(scratch.section, system, scratch.motion, outputs.value[i, k])
            read_tangent(scratch.section, system, scratch.motion, outputs.derivative[i])
            point = outputs.value[i, k]
