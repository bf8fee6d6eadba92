"""The event map of many motions with constant kinetic friction: what passes they go through."""

# What a pass does not decide is left NaN for the exact engine; a motion without return in
# ``max_events`` gives inf. Streams, lists and passes: `_lane_kernels`.

from __future__ import annotations

import math

import numpy as np

from stickslip.mechanics.eventmap._lane_kernels import (
    BLOCK,
    CROSSED,
    CROSSING,
    END_D_E1,
    END_D_E2,
    END_D_W,
    END_LANDS,
    END_MODE_1,
    END_MODE_2,
    END_SUM_W,
    FREED,
    FREED_ALL,
    FREED_GAP,
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
    ONE_TURNS,
    ONE_VALUE,
    PICKED,
    REST,
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
    WHO_END,
    WHO_ONE,
    WHO_TWO,
    ZERO,
    Carried,
    Indices,
    landing_pass,
    landing_slopes,
    load_constants,
    onset_pass,
    release_pass,
    release_slopes,
    return_pass,
    return_slopes,
    start_pass,
    step_pass,
    turning_pass,
)
from stickslip.mechanics.eventmap._lane_trace_kernels import (
    begin_trace,
    landing_margins,
    release_margins,
    return_margins,
    tell,
    trace_freed,
    trace_landings,
    trace_one,
)
from stickslip.mechanics.eventmap.records import Outputs
from stickslip.mechanics.flow._lane_kernels import Change, Pair, constants_of_row
from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.targets import kernel

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
    carried: Carried,
    b: Floats,
    index: Indices,
    n: np.uint64,
    start: np.uint64,
    streams: int,
) -> np.uint64:
    """Step slips of both blocks until each is proved to land; they gather in the END list."""
    n_ended = ZERO
    for steps in range(MAX_STEPS):
        step_pass(carried, b, n)
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
        load_constants(carried.rows, index, WHO_TWO, n, start, OF_STEPS, b)
    return n_ended


@kernel(fused=True)
def carry_block(
    carried: Carried,
    b: Floats,
    index: Indices,
    n: np.uint64,
    value: Floats,
    slope: Floats,
    start: np.uint64,
    max_events: int,
    few: int,
    traced: bool,
    along: Change | None,
    told: Outputs | None,
) -> None:
    """Carry starts ``value[start : start + n]`` to their values, and slopes if there is room."""
    # Motions fewer than `few` stop at `ROUNDS`; `traced` keeps LABEL, COUNT, ELAPSED of each, and
    # MARGIN if it is to be `told`. Slopes are those in a parameter if it is given.
    slopes = slope.size > 0
    for i in range(n):
        k = np.uint64(i)
        b[ONE_VALUE + k] = value[start + k]
        index[WHO_ONE + k] = k
    load_constants(carried.rows, index, WHO_ONE, n, start, OF_ONSETS, b)
    onset_pass(carried, along, b, n)
    if along is not None:
        return_slopes(carried, along, b, n)
    if told is not None:
        return_margins(carried, b, n)
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
        if lap >= believed and (told is not None or n_one + n_crossing <= few):
            return
        crossed = ZERO
        if lap > 0:
            load_constants(carried.rows, index, WHO_ONE, n_one, start, OF_SLIPS, b)
            return_pass(carried, b, n_one)
            if pick(b, ONE_TURNS, 1.0, n_one, index, PICKED) > ZERO:
                turning_pass(carried, b, n_one)
            if slopes:
                return_slopes(carried, along, b, n_one)
            if told is not None:
                return_margins(carried, b, n_one)
            if lap < believed:
                leave(b, index, n_one, value, slope, start)
        if traced:
            trace_one(b, index, told, n_one)
        n_freed = pick(b, ONE_KIND, FREED, n_one, index, PICKED)
        move(b, ONE_GAP, FREED_GAP, FREED_ALL if slopes else FREED_VALUES, index, PICKED, n_freed)
        move_who(index, WHO_ONE, WHO_TWO, PICKED, n_freed)
        load_constants(carried.rows, index, WHO_TWO, n_freed, start, OF_SLIPS, b)
        release_pass(carried, b, n_freed)
        if slopes:
            release_slopes(carried, along, b, n_freed)
        if told is not None:
            release_margins(carried, b, n_freed)
        if traced:
            trace_freed(b, index, told, n_freed)
        if lap > 0:
            crossed = cross_one(b, index, n_one)
        cross_two(b, index, n_crossing, n_freed)
        n_two = n_freed + n_crossing
        load_constants(carried.rows, index, WHO_TWO, n_two, start, OF_STARTS, b)
        start_pass(carried, b, n_two)
        streams = TWO_ALL if slopes or traced else TWO_VALUES
        n_ended = slip_together(carried, b, index, n_two, start, streams)
        load_constants(carried.rows, index, WHO_END, n_ended, start, OF_LANDINGS, b)
        landing_pass(carried, b, n_ended)
        if slopes:
            landing_slopes(carried, along, b, n_ended)
        if told is not None:
            landing_margins(carried, b, n_ended)
        if traced:
            trace_landings(b, index, told, n_ended)
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
    pair: Pair | None,
    b: Floats,
    index: Indices,
    value: Floats,
    slope: Floats,
    start: int,
    stop: int,
    max_events: int,
    along: Change | None,
    told: Outputs | None,
) -> None:
    """Turn starts into values: NaN asks the exact engine, inf: no return within `max_events`."""
    carried = Carried(constants_of_row(row), pair, row)
    few = max_events // EVENTS_PER_LANE
    for at in range(start, stop, BLOCK):
        n = np.uint64(min(BLOCK, stop - at))
        first = np.uint64(at)
        traced = told is not None
        carry_block(carried, b, index, n, value, slope, first, max_events, few, traced, along, told)
        tell(b, index, value, first, n, told)
