"""The event map of one motion and of many: from one global stick phase to the next."""

# Template (`numerics.targets.instantiate`): the engine that moves a motion to its next event is
# bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.itinerary import GLOBAL_STICK, hashed, mode_code
from stickslip.mechanics.eventmap.loop import Loop, settles
from stickslip.mechanics.eventmap.records import Controls, Outputs, Scratch
from stickslip.mechanics.flow.system import (
    ALPHA,
    BETA,
    FORWARD,
    LANDING,
    MAX_INSTANT,
    START,
    STICK,
    Floats,
    Motion,
    System,
    limit,
    loading_rate,
)
from stickslip.mechanics.flow.transitions import onset, settle
from stickslip.numerics.rounding import two_sum
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
    from stickslip.mechanics.flow._exact_kernels import advance, landing_rate, slides_for_ever

# From this many events on a motion is watched for a cycle without global stick.
LONG = 64
# Steps without an event, for each event allowed, before a motion is given up.
STEPS_PER_EVENT = 200
# Bit set of an event of both blocks.
BOTH = 3


@kernel
def copy_motion(source: Motion, target: Motion) -> None:
    """Copy the state and the tangents that both have columns for."""
    for block in range(2):
        target.w[block] = source.w[block]
        target.e[block] = source.e[block]
        target.w_low[block] = source.w_low[block]
        target.e_low[block] = source.e_low[block]
        target.mode[block] = source.mode[block]
        for column in range(min(source.tangent_w.shape[1], target.tangent_w.shape[1])):
            target.tangent_w[block, column] = source.tangent_w[block, column]
            target.tangent_e[block, column] = source.tangent_e[block, column]


@kernel
def distance(motion: Motion, saved: Motion) -> float:
    """Distance of two states, infinite between different modes."""
    largest = 0.0
    for block in range(2):
        if motion.mode[block] != saved.mode[block]:
            return math.inf
        largest = max(largest, abs(motion.w[block] - saved.w[block]))
        largest = max(largest, abs(motion.e[block] - saved.e[block]))
    return largest


@kernel
def start_loop_tangent(motion: Motion, n_columns: int) -> None:
    """Set the last four columns to the identity on the states that share the present modes."""
    for block in range(2):
        for k in range(4):
            motion.tangent_w[block, n_columns + k] = 0.0
            motion.tangent_e[block, n_columns + k] = 0.0
        if motion.mode[block] != 0:
            motion.tangent_w[block, n_columns + block] = 1.0
        motion.tangent_e[block, n_columns + 2 + block] = 1.0


@kernel
def write_shift(motion: Motion, saved: Motion, shift: Floats) -> None:
    """Keep how far a state is from an earlier one."""
    for block in range(2):
        shift[block] = motion.w[block] - saved.w[block]
        shift[2 + block] = motion.e[block] - saved.e[block]


@kernel
def write_turn(motion: Motion, saved: Motion, n_columns: int, loop: Loop) -> None:
    """Keep what a turn has made of a state and its tangent."""
    write_shift(motion, saved, loop.moved)
    for block in range(2):
        for k in range(4):
            loop.turn[block, k] = motion.tangent_w[block, n_columns + k]
            loop.turn[2 + block, k] = motion.tangent_e[block, n_columns + k]


@kernel
def loop_norm(motion: Motion, n_columns: int) -> float:
    """Largest row sum of the loop's tangent."""
    norm = 0.0
    for block in range(2):
        row_w = row_e = 0.0
        for k in range(4):
            row_w += abs(motion.tangent_w[block, n_columns + k])
            row_e += abs(motion.tangent_e[block, n_columns + k])
        norm = max(norm, row_w, row_e)
    return norm


@kernel
def event_margin(system: System, laws: Floats, motion: Motion) -> float:
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
def blocks_of_event(motion: Motion) -> int:
    """Bit set of the blocks whose event it is."""
    return (1 if motion.event[0] != 0 else 0) + (2 if motion.event[1] != 0 else 0)


@kernel
def carry(
    system: System,
    laws: Floats,
    d: float,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, float, int, np.uint64, float, int]:
    """Follow a motion to the next global stick phase."""
    # (value, duration, events, label, margin, status); tangents of the last state stay in `motion`.
    motion, long_motion, saved, loop, work = scratch
    n_columns = motion.directions.shape[0]
    onset(system, motion, d)
    watching = work.watch[0]
    work.margin[0] = math.inf
    work.sliding[0] = 0.0
    if motion.mode[0] == motion.mode[1]:
        slope_of_tie(system, laws, motion, d)
        work.margin[0] = 0.0
    current = motion
    code = mode_code(current)
    label = hashed(np.uint64(1), code)
    if itinerary.shape[0] > 0:
        itinerary[0] = code
    duration = phase = 0.0
    earlier_margin = math.inf
    n_events = instant = 0
    # A state is kept, now and then; two turns from it on, the second with its tangent, may tell.
    kept, next_look, turn_ends = 0, LONG, 0
    near, growth, looping = math.inf, 1.0, False
    before = (1 if motion.mode[0] != 0 else 0) + (2 if motion.mode[1] != 0 else 0)
    status = TIME_LIMIT
    for _ in range(STEPS_PER_EVENT * (controls.max_events + LONG)):
        if code == 0 and slides_for_ever(system, laws, current, work):
            status = NEVER_SLIPPING
            break
        t, status = advance(system, laws, current, work, controls.rtol, math.inf)
        duration += t
        phase += t
        if status != OK:
            break
        if not (math.isfinite(current.e[0]) and math.isfinite(current.e[1])):
            status = STEP_FAILED
            break
        status = TIME_LIMIT
        if duration > controls.max_time:
            break
        here = blocks_of_event(current)
        if here == 0:
            continue
        if work.watch[0] != 0.0:
            margin = event_margin(system, laws, current)
            if here == BOTH:
                margin = 0.0
            elif here != before:
                margin = min(margin, phase)
            work.margin[0] = min(work.margin[0], margin)
        before = here
        instant = instant + 1 if phase == 0.0 else 0
        phase = 0.0
        settle(system, current)
        new_code = mode_code(current)
        if new_code == code:
            if instant > 2 * MAX_INSTANT:
                status = UNDECIDED
                break
            continue
        code = new_code
        n_events += 1
        label = hashed(label, code)
        if n_events < itinerary.shape[0]:
            itinerary[n_events] = code
        if code == GLOBAL_STICK:
            status = OK
            break
        if instant > 2 * MAX_INSTANT:
            status = UNDECIDED
            break
        if n_events >= controls.max_events:
            status = EVENT_LIMIT
            break
        if n_events < LONG:
            continue
        if looping:
            growth = max(growth, loop_norm(current, n_columns))
            if n_events < turn_ends:
                continue
            if distance(current, saved) < math.inf:
                write_turn(current, saved, n_columns, loop)
                if settles(loop, work.margin[0] / growth):
                    status = NEVER_CYCLE
                    break
            copy_motion(current, motion)
            current, looping = motion, False
            work.watch[0] = watching
            next_look = n_events
        elif kept > 0:
            gap = distance(current, saved)
            if gap < near:
                write_shift(current, saved, loop.earlier)
                turn_ends, near, growth = 2 * n_events - kept, 0.5 * gap, 1.0
                copy_motion(motion, long_motion)
                current, looping = long_motion, True
                start_loop_tangent(current, n_columns)
                copy_motion(current, saved)
                earlier_margin = min(earlier_margin, work.margin[0])
                work.margin[0], work.watch[0] = math.inf, 1.0
        if n_events >= next_look and not looping:
            copy_motion(current, saved)
            kept, next_look = n_events, n_events + n_events // 4
    work.watch[0] = watching
    margin = min(earlier_margin, work.margin[0])
    value = math.nan
    if status == OK:
        gap, low = two_sum(current.e[1], -current.e[0])
        low += current.e_low[1] - current.e_low[0]
        value = (gap + low) / (1.0 + 2.0 * system.alpha)
        if looping:
            copy_motion(current, motion)
    return value, duration, n_events, label, margin, status


@kernel
def value_tangent(system: System, motion: Motion, value: float, column: int) -> float:
    """Differentiate d = (e_2 - e_1) / (1 + 2 alpha) in the direction of a column."""
    difference = motion.tangent_e[1, column] - motion.tangent_e[0, column]
    growth = 2.0 * value * motion.directions[column, ALPHA]
    return (difference - growth) / (1.0 + 2.0 * system.alpha)


@kernel
def carry_range(
    system: System,
    laws: Floats,
    d: Floats,
    start: int,
    stop: int,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    outputs: Outputs,
) -> None:
    """Evaluate the map at ``d[start:stop]``; `itinerary` is that of the last motion."""
    for i in range(start, stop):
        if math.isnan(d[i]):
            continue
        value, duration, n_events, label, margin, status = carry(
            system, laws, d[i], scratch, controls, itinerary
        )
        outputs.value[i] = value
        outputs.duration[i] = duration
        outputs.n_events[i] = n_events
        outputs.label[i] = label
        outputs.margin[i] = margin
        outputs.status[i] = status
        for column in range(scratch.motion.directions.shape[0]):
            slope = value_tangent(system, scratch.motion, value, column)
            outputs.derivative[i, column] = slope if status == OK else math.nan


@kernel
def iterate_range(
    system: System,
    laws: Floats,
    orbits: Floats,
    start: int,
    stop: int,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> None:
    """Fill rows ``start..stop`` of `orbits` (starts, n + 1) from their first entries on."""
    for i in range(start, stop):
        for k in range(orbits.shape[1] - 1):
            value = orbits[i, k]
            if not math.isnan(value):
                value, _, _, _, _, _ = carry(system, laws, value, scratch, controls, itinerary)
            orbits[i, k + 1] = value
