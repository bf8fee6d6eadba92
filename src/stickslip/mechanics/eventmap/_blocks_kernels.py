"""The event map of n blocks: from the differences of one global stick phase to the next."""

# Template (`numerics.targets.instantiate`): the stepper is bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.itinerary import hashed
from stickslip.mechanics.eventmap.records import BlockScratch, Controls, Outputs
from stickslip.mechanics.flow.blocks.system import BlockMotion, BlockSystem, BlockWork, Floats
from stickslip.mechanics.flow.blocks.transitions import excess_rate, onset, settle
from stickslip.mechanics.flow.system import LANDING, MAX_INSTANT, STICK
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
    from stickslip.mechanics.flow.blocks._stepper_kernels import (
        advance,
        landing_rate,
        slides_for_ever,
    )

# From this many events per block on a motion is watched for a cycle without global stick.
LONG = 32
# A state recurs when it comes back to within this distance (rule 6).
RECURRENCE = 1e-10
# Steps without an event, for each event allowed, before a motion is given up.
STEPS_PER_EVENT = 200
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
def copy_state(source: BlockMotion, target: BlockMotion) -> None:
    """Copy a state into a motion with any number of columns."""
    for i in range(source.mode.shape[0]):
        target.e[i] = source.e[i]
        target.limit[i] = source.limit[i]
        target.mode[i] = source.mode[i]
    for j in range(source.z.shape[0]):
        target.z[j] = source.z[j]
    target.clock[0] = source.clock[0]


@kernel
def copy_tangents(source: BlockMotion, target: BlockMotion, n_columns: int) -> None:
    """Copy the first tangents."""
    for column in range(n_columns):
        for j in range(source.z.shape[0]):
            target.tangent_z[j, column] = source.tangent_z[j, column]


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
def start_loop_tangent(motion: BlockMotion, n_columns: int) -> None:
    """Set the last columns to the identity on the states that share the present modes."""
    n_free, n = motion.y.shape[0], motion.z.shape[0]
    for j in range(n):
        for column in range(n_columns, n_columns + n):
            motion.tangent_z[j, column] = 0.0
        if j < n_free or motion.mode[j - n_free] != STICK:
            motion.tangent_z[j, n_columns + j] = 1.0


@kernel
def loop_norm(motion: BlockMotion, n_columns: int) -> float:
    """Largest row sum of the loop's tangent."""
    norm = 0.0
    for j in range(motion.z.shape[0]):
        row = 0.0
        for column in range(n_columns, motion.tangent_z.shape[1]):
            row += abs(motion.tangent_z[j, column])
        norm = max(norm, row)
    return norm


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


@kernel
def carry(
    system: BlockSystem,
    laws: Floats,
    d: Floats,
    scratch: BlockScratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, int, np.uint64, float, int]:
    """Follow a motion to the next global stick phase, left in ``scratch.motion``."""
    # (duration, events, label, margin, status); `itinerary` (phases, n) takes modes while it lasts.
    motion, directions, long_motion, long_directions, saved, work = scratch
    n, n_columns = motion.mode.shape[0], motion.tangent_z.shape[1]
    leaving = onset(system, directions, motion, d)
    watching = work.watch[0]
    work.margin[0] = 0.0 if leaving > 1 else math.inf
    current, current_directions = motion, directions
    label = noted(np.uint64(1), current)
    if itinerary.shape[0] > 0:
        write_modes(current, itinerary[0])
    duration = phase = 0.0
    earlier_margin = math.inf
    n_events = instant = 0
    looping = False
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
            continue
        if work.watch[0] != 0.0:
            margin = event_margin(system, laws, current, work)
            margin = 0.0 if here > 1 else min(margin, phase)
            work.margin[0] = min(work.margin[0], margin)
        instant = instant + 1 if phase == 0.0 else 0
        phase = 0.0
        if not settle(system, current, work.rates):
            if instant > MAX_INSTANT * n:
                status = UNDECIDED
                break
            continue
        label = noted(label, current)
        n_events += 1
        if n_events < itinerary.shape[0]:
            write_modes(current, itinerary[n_events])
        if all_ride(current):
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
        gap = distance(current, saved) if n_events > LONG * n else math.inf
        if gap < RECURRENCE and not looping:
            # The state recurs: from here on follow the tangent of the loop as well.
            copy_state(motion, long_motion)
            copy_tangents(motion, long_motion, n_columns)
            current, current_directions = long_motion, long_directions
            work.watch[0] = 1.0
        elif gap < RECURRENCE:
            norm = loop_norm(current, n_columns)
            if norm < 1.0 and gap < 0.1 * work.margin[0] * (1.0 - norm):
                status = NEVER_CYCLE
                break
        if n_events & (n_events - 1) == 0 or (gap < RECURRENCE and not looping):
            copy_state(current, saved)
            looping = looping or gap < RECURRENCE
            if looping:
                start_loop_tangent(current, n_columns)
                earlier_margin = min(earlier_margin, work.margin[0])
                work.margin[0] = math.inf
    work.watch[0] = watching
    if looping:
        copy_state(current, motion)
        copy_tangents(current, motion, n_columns)
    return duration, n_events, label, min(earlier_margin, work.margin[0]), status


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
    d: Floats,
    start: int,
    stop: int,
    scratch: BlockScratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    outputs: Outputs,
) -> None:
    """Evaluate the map at rows ``d[start:stop]``; `itinerary` is that of the last motion."""
    motion = scratch.motion
    for i in range(start, stop):
        if is_nan(d[i]):
            continue
        duration, n_events, label, margin, status = carry(
            system, laws, d[i], scratch, controls, itinerary
        )
        outputs.duration[i] = duration
        outputs.n_events[i] = n_events
        outputs.label[i] = label
        outputs.margin[i] = margin
        outputs.status[i] = status
        if status != OK:
            continue
        for k in range(d.shape[1]):
            outputs.value[i, k] = motion.y[k + 1] - motion.y[k]
            for column in range(motion.tangent_z.shape[1]):
                change = motion.tangent_y[k + 1, column] - motion.tangent_y[k, column]
                outputs.derivative[i, k, column] = change


@kernel
def iterate_range(
    system: BlockSystem,
    laws: Floats,
    orbits: Floats,
    start: int,
    stop: int,
    scratch: BlockScratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> None:
    """Fill rows ``start..stop`` of `orbits` (starts, steps + 1, differences) from their starts."""
    motion = scratch.motion
    for i in range(start, stop):
        for k in range(orbits.shape[1] - 1):
            if is_nan(orbits[i, k]):
                orbits[i, k + 1] = math.nan  # and stays so
                continue
            _, _, _, _, status = carry(system, laws, orbits[i, k], scratch, controls, itinerary)
            for j in range(orbits.shape[2]):
                difference = motion.y[j + 1] - motion.y[j]
                orbits[i, k + 1, j] = difference if status == OK else math.nan
