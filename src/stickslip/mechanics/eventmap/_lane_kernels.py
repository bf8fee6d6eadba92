"""The event map of many motions with constant kinetic friction, breadth first.

Motions whose next phase is of one kind are carried through it together (`_lane_passes_kernels`),
then listed anew by what happened to them. What a pass does not decide is left NaN for the exact
engine; a motion that does not return within ``max_events`` gives inf.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap._label_kernels import hashed
from stickslip.mechanics.eventmap._lane_passes_kernels import (
    BLOCK,
    CROSSED,
    ELAPSED,
    END_D_E1,
    END_D_E2,
    END_D_W,
    END_LANDS,
    END_MODE_1,
    END_MODE_2,
    END_SUM_W,
    END_TIME,
    FREED,
    FREED_ALL,
    FREED_GAP,
    FREED_SIGN,
    FREED_TIME,
    FREED_VALUES,
    NEXT_E1,
    NEXT_E2,
    NEXT_KIND,
    NEXT_MODE,
    NEXT_W,
    OF_LANDINGS,
    OF_ONSETS,
    OF_SLIPS,
    OF_STARTS,
    OF_STEPS,
    ONE,
    ONE_D_FORCE,
    ONE_D_FORCE_END,
    ONE_D_GAP,
    ONE_D_RIDER,
    ONE_D_RIDER_END,
    ONE_FIRST,
    ONE_FORCE,
    ONE_FORCE_END,
    ONE_GAP,
    ONE_KIND,
    ONE_RIDER,
    ONE_RIDER_END,
    ONE_SIGN,
    ONE_SLOPE,
    ONE_TIME,
    ONE_TURNS,
    ONE_VALUE,
    RETURNED,
    START_E1,
    START_E2,
    START_W,
    STRIDE,
    STUCK,
    TWO_ALL,
    TWO_D_E1,
    TWO_D_E2,
    TWO_D_W,
    TWO_FRESH,
    TWO_LANDS,
    TWO_MODE_1,
    TWO_MODE_2,
    TWO_SUM_W,
    TWO_VALUES,
    ZERO,
    landing_pass,
    landing_slopes,
    load_plants,
    onset_pass,
    release_pass,
    release_slopes,
    return_pass,
    return_slopes,
    start_pass,
    step_pass,
    turning_pass,
)
from stickslip.mechanics.flow._lane_kernels import Plant, plant_of_row
from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.targets import kernel

Indices = NDArray[np.uint64]

# Lists of numbers: whose motion an item is, and items picked from a list.
# Of each motion: hash of its itinerary (`hashed`) and how many events.
N_LISTS = 8
(
    WHO_ONE, WHO_TWO, WHO_END, PICKED, REST, CROSSING, LABEL, COUNT,
) = (np.uint64(i * STRIDE) for i in range(N_LISTS))  # fmt: skip

# Rounds of phases in which a returned motion is believed: the rounding of long ones is left to
# one engine, so that it does not matter how many motions are asked together. Beyond them lanes
# go on only to show that motions do not return, and only where there are many for the number
# of events: one at a time the exact engine is faster, which knows cycles.
ROUNDS = 64
EVENTS_PER_LANE = 128
# Steps of slips of both blocks before a motion is left to the exact engine, and how many are
# taken before the first look whether some are over.
MAX_STEPS = 64
FIRST_STEPS = 3


@kernel(fused=True)
def pick(
    b: Floats, kinds: np.uint64, kind: float, n: np.uint64, index: Indices, to: np.uint64
) -> np.uint64:
    """List the items of one kind at `to`; return how many there are."""
    m = ZERO
    for i in range(n):
        k = np.uint64(i)
        index[to + m] = k
        m += ONE if b[kinds + k] == kind else ZERO
    return m


@kernel(fused=True)
def move(
    b: Floats,
    source: np.uint64,
    target: np.uint64,
    streams: int,
    index: Indices,
    picked: np.uint64,
    n: np.uint64,
) -> None:
    """Copy listed items of several streams to the beginning of others, or of the same."""
    for stream in range(streams):
        shift = np.uint64(stream * STRIDE)
        for i in range(n):
            k = np.uint64(i)
            b[target + shift + k] = b[source + shift + index[picked + k]]


@kernel(fused=True)
def move_who(
    index: Indices, source: np.uint64, target: np.uint64, picked: np.uint64, n: np.uint64
) -> None:
    """Copy listed items of a list of motions."""
    for i in range(n):
        k = np.uint64(i)
        index[target + k] = index[source + index[picked + k]]


@kernel(fused=True)
def leave(
    b: Floats, index: Indices, n: np.uint64, value: Floats, slope: Floats, start: np.uint64
) -> None:
    """Write down the motions that returned to global stick."""
    m = pick(b, ONE_KIND, RETURNED, n, index, PICKED)
    for i in range(m):
        k = index[PICKED + np.uint64(i)]
        value[start + index[WHO_ONE + k]] = b[ONE_VALUE + k]
        if slope.size > 0:
            slope[start + index[WHO_ONE + k]] = b[ONE_SLOPE + k]


@kernel(fused=True)
def cross_one(b: Floats, index: Indices, n: np.uint64) -> np.uint64:
    """Begin the list of one slipping block with those that crossed w = 0: mirrored slips."""
    m = pick(b, ONE_KIND, CROSSED, n, index, PICKED)
    for i in range(m):
        k = np.uint64(i)
        a = index[PICKED + k]
        b[ONE_GAP + k] = 0.0
        b[ONE_SIGN + k] = -b[ONE_SIGN + a]
        b[ONE_FIRST + k] = b[ONE_FIRST + a]
        b[ONE_FORCE + k] = b[ONE_FORCE_END + a]
        b[ONE_RIDER + k] = b[ONE_RIDER_END + a]
        b[ONE_D_GAP + k] = 0.0
        b[ONE_D_FORCE + k] = b[ONE_D_FORCE_END + a]
        b[ONE_D_RIDER + k] = b[ONE_D_RIDER_END + a]
        index[WHO_ONE + k] = index[WHO_ONE + a]
    return m


@kernel(fused=True)
def cross_two(b: Floats, index: Indices, n: np.uint64, at: np.uint64) -> None:
    """Append slips of both blocks, one of which crossed w = 0, to the list of these."""
    for i in range(n):
        a = index[CROSSING + np.uint64(i)]
        k = at + np.uint64(i)
        second = b[END_LANDS + a] > 0.0
        b[START_W + k] = b[NEXT_W + a]
        b[START_E1 + k] = b[NEXT_E1 + a]
        b[START_E2 + k] = b[NEXT_E2 + a]
        b[TWO_MODE_1 + k] = b[END_MODE_1 + a] if second else b[NEXT_MODE + a]
        b[TWO_MODE_2 + k] = b[NEXT_MODE + a] if second else b[END_MODE_2 + a]
        b[TWO_FRESH + k] = b[END_LANDS + a]
        b[TWO_D_W + k] = b[END_D_W + a]
        b[TWO_D_E1 + k] = b[END_D_E1 + a]
        b[TWO_D_E2 + k] = b[END_D_E2 + a]
        index[WHO_TWO + k] = index[WHO_END + a]


@kernel(fused=True)
def stick_one(b: Floats, index: Indices, n: np.uint64, at: np.uint64) -> np.uint64:
    """Append slips of both blocks that became slips of one; return the length of the list."""
    m = pick(b, NEXT_KIND, STUCK, n, index, PICKED)
    for i in range(m):
        a = index[PICKED + np.uint64(i)]
        k = at + np.uint64(i)
        second = b[END_LANDS + a] > 0.0
        mode = b[END_MODE_1 + a] if second else b[END_MODE_2 + a]
        b[ONE_GAP + k] = mode * b[NEXT_W + a]
        b[ONE_SIGN + k] = -mode
        b[ONE_FIRST + k] = 1.0 if second else 0.0
        b[ONE_FORCE + k] = b[NEXT_E1 + a] if second else b[NEXT_E2 + a]
        b[ONE_RIDER + k] = b[NEXT_E2 + a] if second else b[NEXT_E1 + a]
        b[ONE_D_GAP + k] = mode * b[END_D_W + a]
        b[ONE_D_FORCE + k] = b[END_D_E1 + a] if second else b[END_D_E2 + a]
        b[ONE_D_RIDER + k] = b[END_D_E2 + a] if second else b[END_D_E1 + a]
        index[WHO_ONE + k] = index[WHO_END + a]
    return at + m


@kernel(fused=True)
def slip_together(
    common: Plant,
    rows: Floats,
    b: Floats,
    index: Indices,
    n: np.uint64,
    start: np.uint64,
    streams: int,
) -> np.uint64:
    """Step slips of both blocks until each is proved to land; they gather in the END list."""
    n_ended = ZERO
    for steps in range(MAX_STEPS):
        step_pass(common, rows, b, n)
        if steps < FIRST_STEPS - 1:
            continue
        going = ended = ZERO
        for i in range(n):
            k = np.uint64(i)
            index[PICKED + going] = k
            index[REST + ended] = k
            goes = b[TWO_LANDS + k] == 0.0
            going += ONE if goes else ZERO
            ended += ZERO if goes else ONE
        move(b, TWO_SUM_W, END_SUM_W + n_ended, streams, index, REST, ended)
        move(b, TWO_LANDS, END_LANDS + n_ended, 1, index, REST, ended)
        move(b, TWO_SUM_W, TWO_SUM_W, streams, index, PICKED, going)
        move_who(index, WHO_TWO, WHO_END + n_ended, REST, ended)
        move_who(index, WHO_TWO, WHO_TWO, PICKED, going)
        n_ended += ended
        n = going
        if n == ZERO:
            break
        load_plants(rows, index, WHO_TWO, n, start, OF_STEPS, b)
    return n_ended


@kernel(fused=True)
def begin_trace(b: Floats, index: Indices, n: np.uint64) -> None:
    """Note the first phase of each motion: one block slips backward."""
    for i in range(n):
        k = np.uint64(i)
        code = 1 if b[ONE_FIRST + k] > 0.5 else 3
        index[LABEL + k] = hashed(ONE, code)
        index[COUNT + k] = ZERO
        b[ELAPSED + k] = 0.0


@kernel(inline=True, fused=True)
def note(b: Floats, index: Indices, who: np.uint64, mode_1: float, mode_2: float, t: float) -> None:
    """Note an event of a motion, after a time t."""
    code = int(3.0 * mode_1 + mode_2) + 4
    index[LABEL + who] = hashed(index[LABEL + who], code)
    index[COUNT + who] += ONE
    b[ELAPSED + who] += t


@kernel(fused=True)
def trace_one(b: Floats, index: Indices, n: np.uint64) -> None:
    """Note returns and crossings of slips of one block."""
    for i in range(n):
        k = np.uint64(i)
        kind = b[ONE_KIND + k]
        if kind == RETURNED:
            note(b, index, index[WHO_ONE + k], 0.0, 0.0, b[ONE_TIME + k])
        elif kind == CROSSED:
            first = b[ONE_FIRST + k] > 0.5
            mode = b[ONE_SIGN + k]
            mode_1, mode_2 = (mode, 0.0) if first else (0.0, mode)
            note(b, index, index[WHO_ONE + k], mode_1, mode_2, b[ONE_TIME + k])


@kernel(fused=True)
def trace_freed(b: Floats, index: Indices, n: np.uint64) -> None:
    """Note the times at which riders were freed: both blocks then slip the same way."""
    for i in range(n):
        k = np.uint64(i)
        mode = -b[FREED_SIGN + k]
        note(b, index, index[WHO_TWO + k], mode, mode, b[FREED_TIME + k])


@kernel(fused=True)
def trace_landings(b: Floats, index: Indices, n: np.uint64) -> None:
    """Note the ends of slips of both blocks."""
    for i in range(n):
        k = np.uint64(i)
        mode = b[NEXT_MODE + k] if b[NEXT_KIND + k] == CROSSED else 0.0
        second = b[END_LANDS + k] > 0.0
        mode_1 = b[END_MODE_1 + k] if second else mode
        mode_2 = mode if second else b[END_MODE_2 + k]
        note(b, index, index[WHO_END + k], mode_1, mode_2, b[END_TIME + k])


@kernel(fused=True)
def carry_block(
    common: Plant,
    rows: Floats,
    b: Floats,
    index: Indices,
    n: np.uint64,
    value: Floats,
    slope: Floats,
    start: np.uint64,
    max_events: int,
    few: int,
    traced: bool,
) -> None:
    """Carry starts ``value[start : start + n]`` to their values, and slopes if there is room.

    Motions fewer than `few` stop at `ROUNDS`; `traced` keeps LABEL, COUNT, ELAPSED of each.
    """
    slopes = slope.size > 0
    for i in range(n):
        k = np.uint64(i)
        b[ONE_VALUE + k] = value[start + k]
        index[WHO_ONE + k] = k
    load_plants(rows, index, WHO_ONE, n, start, OF_ONSETS, b)
    onset_pass(common, rows, b, n)
    for i in range(n):
        k = np.uint64(i)
        value[start + k] = b[ONE_VALUE + k]
        if slopes:
            slope[start + k] = b[ONE_SLOPE + k]
    if traced:
        begin_trace(b, index, n)
    n_one, n_crossing = n, ZERO
    # A round is one event or two of each motion, so that none passes max_events in these.
    believed = min(ROUNDS, (max_events + 1) // 2)
    for lap in range(max_events + 1):
        if lap >= believed and n_one + n_crossing <= few:
            return
        crossed = ZERO
        if lap > 0:
            load_plants(rows, index, WHO_ONE, n_one, start, OF_SLIPS, b)
            return_pass(common, rows, b, n_one)
            if pick(b, ONE_TURNS, 1.0, n_one, index, PICKED) > ZERO:
                turning_pass(common, rows, b, n_one)
            if slopes:
                return_slopes(common, rows, b, n_one)
            if lap < believed:
                leave(b, index, n_one, value, slope, start)
        if traced:
            trace_one(b, index, n_one)
        n_freed = pick(b, ONE_KIND, FREED, n_one, index, PICKED)
        move(b, ONE_GAP, FREED_GAP, FREED_ALL if slopes else FREED_VALUES, index, PICKED, n_freed)
        move_who(index, WHO_ONE, WHO_TWO, PICKED, n_freed)
        load_plants(rows, index, WHO_TWO, n_freed, start, OF_SLIPS, b)
        release_pass(common, rows, b, n_freed)
        if slopes:
            release_slopes(common, rows, b, n_freed)
        if traced:
            trace_freed(b, index, n_freed)
        if lap > 0:
            crossed = cross_one(b, index, n_one)
        cross_two(b, index, n_crossing, n_freed)
        n_two = n_freed + n_crossing
        load_plants(rows, index, WHO_TWO, n_two, start, OF_STARTS, b)
        start_pass(common, rows, b, n_two)
        streams = TWO_ALL if slopes else TWO_VALUES
        n_ended = slip_together(common, rows, b, index, n_two, start, streams)
        load_plants(rows, index, WHO_END, n_ended, start, OF_LANDINGS, b)
        landing_pass(common, rows, b, n_ended)
        if slopes:
            landing_slopes(common, rows, b, n_ended)
        if traced:
            trace_landings(b, index, n_ended)
        n_one = stick_one(b, index, n_ended, crossed)
        n_crossing = pick(b, NEXT_KIND, CROSSED, n_ended, index, CROSSING)
        if n_one + n_crossing == ZERO:
            return
    for i in range(n_one):
        value[start + index[WHO_ONE + np.uint64(i)]] = math.inf
    for i in range(n_crossing):
        value[start + index[WHO_END + index[CROSSING + np.uint64(i)]]] = math.inf


@kernel(fused=True)
def carry_lanes(
    row: Floats,
    b: Floats,
    index: Indices,
    value: Floats,
    slope: Floats,
    start: int,
    stop: int,
    max_events: int,
) -> None:
    """Turn starts into values: NaN asks the exact engine, inf: no return within `max_events`."""
    plant = plant_of_row(row)
    few = max_events // EVENTS_PER_LANE
    for at in range(start, stop, BLOCK):
        n = np.uint64(min(BLOCK, stop - at))
        carry_block(plant, row, b, index, n, value, slope, np.uint64(at), max_events, few, False)
