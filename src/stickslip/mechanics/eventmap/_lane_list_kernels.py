"""The event map of many motions with constant kinetic friction: what passes they go through."""

# What a pass does not decide is left NaN for the exact engine; a motion without return in
# ``max_events`` gives inf. Streams, lists and passes: `_lane_kernels`.

from __future__ import annotations

import math

import numpy as np

from stickslip.mechanics.eventmap import _lane_kernels as at
from stickslip.mechanics.eventmap._lane_kernels import (
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
    m = at.ZERO
    for i in range(n):
        k = np.uint64(i)
        index[to + m] = k
        m += at.ONE if b[kinds + k] == kind else at.ZERO
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
        shift = np.uint64(stream * at.STRIDE)
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
    m = pick(b, at.ONE_KIND, at.RETURNED, n, index, at.PICKED)
    for i in range(m):
        k = index[at.PICKED + np.uint64(i)]
        value[start + index[at.WHO_ONE + k]] = b[at.ONE_VALUE + k]
        if slope.size > 0:
            slope[start + index[at.WHO_ONE + k]] = b[at.ONE_SLOPE + k]


@kernel(fused=True)
def cross_one(b: Floats, index: Indices, n: np.uint64) -> np.uint64:
    """Begin the list of one slipping block with those that crossed w = 0: mirrored slips."""
    m = pick(b, at.ONE_KIND, at.CROSSED, n, index, at.PICKED)
    for i in range(m):
        k = np.uint64(i)
        a = index[at.PICKED + k]
        b[at.ONE_GAP + k] = 0.0
        b[at.ONE_SIGN + k] = -b[at.ONE_SIGN + a]
        b[at.ONE_FIRST + k] = b[at.ONE_FIRST + a]
        b[at.ONE_FORCE + k] = b[at.ONE_FORCE_END + a]
        b[at.ONE_RIDER + k] = b[at.ONE_RIDER_END + a]
        b[at.ONE_D_GAP + k] = 0.0
        b[at.ONE_D_FORCE + k] = b[at.ONE_D_FORCE_END + a]
        b[at.ONE_D_RIDER + k] = b[at.ONE_D_RIDER_END + a]
        index[at.WHO_ONE + k] = index[at.WHO_ONE + a]
    return m


@kernel(fused=True)
def cross_two(b: Floats, index: Indices, n: np.uint64, end: np.uint64) -> None:
    """Append slips of both blocks, one of which crossed w = 0, to the list of these."""
    for i in range(n):
        a = index[at.CROSSING + np.uint64(i)]
        k = end + np.uint64(i)
        second = b[at.END_LANDS + a] > 0.0
        b[at.START_W + k] = b[at.NEXT_W + a]
        b[at.START_E1 + k] = b[at.NEXT_E1 + a]
        b[at.START_E2 + k] = b[at.NEXT_E2 + a]
        b[at.TWO_MODE_1 + k] = b[at.END_MODE_1 + a] if second else b[at.NEXT_MODE + a]
        b[at.TWO_MODE_2 + k] = b[at.NEXT_MODE + a] if second else b[at.END_MODE_2 + a]
        b[at.TWO_FRESH + k] = b[at.END_LANDS + a]
        b[at.TWO_D_W + k] = b[at.END_D_W + a]
        b[at.TWO_D_E1 + k] = b[at.END_D_E1 + a]
        b[at.TWO_D_E2 + k] = b[at.END_D_E2 + a]
        index[at.WHO_TWO + k] = index[at.WHO_END + a]


@kernel(fused=True)
def stick_one(b: Floats, index: Indices, n: np.uint64, end: np.uint64) -> np.uint64:
    """Append slips of both blocks that became slips of one; return the length of the list."""
    m = pick(b, at.NEXT_KIND, at.STUCK, n, index, at.PICKED)
    for i in range(m):
        a = index[at.PICKED + np.uint64(i)]
        k = end + np.uint64(i)
        second = b[at.END_LANDS + a] > 0.0
        mode = b[at.END_MODE_1 + a] if second else b[at.END_MODE_2 + a]
        b[at.ONE_GAP + k] = mode * b[at.NEXT_W + a]
        b[at.ONE_SIGN + k] = -mode
        b[at.ONE_FIRST + k] = 1.0 if second else 0.0
        b[at.ONE_FORCE + k] = b[at.NEXT_E1 + a] if second else b[at.NEXT_E2 + a]
        b[at.ONE_RIDER + k] = b[at.NEXT_E2 + a] if second else b[at.NEXT_E1 + a]
        b[at.ONE_D_GAP + k] = mode * b[at.END_D_W + a]
        b[at.ONE_D_FORCE + k] = b[at.END_D_E1 + a] if second else b[at.END_D_E2 + a]
        b[at.ONE_D_RIDER + k] = b[at.END_D_E2 + a] if second else b[at.END_D_E1 + a]
        index[at.WHO_ONE + k] = index[at.WHO_END + a]
    return end + m


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
    n_ended = at.ZERO
    for steps in range(MAX_STEPS):
        step_pass(carried, b, n)
        if steps < FIRST_STEPS - 1:
            continue
        going = ended = at.ZERO
        for i in range(n):
            k = np.uint64(i)
            index[at.PICKED + going] = k
            index[at.REST + ended] = k
            goes = b[at.TWO_LANDS + k] == 0.0
            going += at.ONE if goes else at.ZERO
            ended += at.ZERO if goes else at.ONE
        move(b, at.TWO_SUM_W, at.END_SUM_W + n_ended, streams, index, at.REST, ended)
        move(b, at.TWO_LANDS, at.END_LANDS + n_ended, 1, index, at.REST, ended)
        move(b, at.TWO_SUM_W, at.TWO_SUM_W, streams, index, at.PICKED, going)
        move_who(index, at.WHO_TWO, at.WHO_END + n_ended, at.REST, ended)
        move_who(index, at.WHO_TWO, at.WHO_TWO, at.PICKED, going)
        n_ended += ended
        n = going
        if n == at.ZERO:
            break
        load_constants(carried.rows, index, at.WHO_TWO, n, start, at.OF_STEPS, b)
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
        b[at.ONE_VALUE + k] = value[start + k]
        index[at.WHO_ONE + k] = k
    load_constants(carried.rows, index, at.WHO_ONE, n, start, at.OF_ONSETS, b)
    onset_pass(carried, along, b, n)
    if along is not None:
        return_slopes(carried, along, b, n)
    if told is not None:
        return_margins(carried, b, n)
    for i in range(n):
        k = np.uint64(i)
        value[start + k] = b[at.ONE_VALUE + k]
        if slopes:
            slope[start + k] = b[at.ONE_SLOPE + k]
    if traced:
        begin_trace(b, index, n)
    n_one, n_crossing = n, at.ZERO
    # A round is one event or two of each motion, so that none passes max_events in these.
    believed = min(ROUNDS, (max_events + 1) // 2)
    for lap in range(max_events + 1):
        if lap >= believed and (told is not None or n_one + n_crossing <= few):
            return
        crossed = at.ZERO
        if lap > 0:
            load_constants(carried.rows, index, at.WHO_ONE, n_one, start, at.OF_SLIPS, b)
            return_pass(carried, b, n_one)
            if pick(b, at.ONE_TURNS, 1.0, n_one, index, at.PICKED) > at.ZERO:
                turning_pass(carried, b, n_one)
            if slopes:
                return_slopes(carried, along, b, n_one)
            if told is not None:
                return_margins(carried, b, n_one)
            if lap < believed:
                leave(b, index, n_one, value, slope, start)
        if traced:
            trace_one(b, index, told, n_one)
        n_freed = pick(b, at.ONE_KIND, at.FREED, n_one, index, at.PICKED)
        streams = at.FREED_ALL if slopes else at.FREED_VALUES
        move(b, at.ONE_GAP, at.FREED_GAP, streams, index, at.PICKED, n_freed)
        move_who(index, at.WHO_ONE, at.WHO_TWO, at.PICKED, n_freed)
        load_constants(carried.rows, index, at.WHO_TWO, n_freed, start, at.OF_SLIPS, b)
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
        load_constants(carried.rows, index, at.WHO_TWO, n_two, start, at.OF_STARTS, b)
        start_pass(carried, b, n_two)
        streams = at.TWO_ALL if slopes or traced else at.TWO_VALUES
        n_ended = slip_together(carried, b, index, n_two, start, streams)
        load_constants(carried.rows, index, at.WHO_END, n_ended, start, at.OF_LANDINGS, b)
        landing_pass(carried, b, n_ended)
        if slopes:
            landing_slopes(carried, along, b, n_ended)
        if told is not None:
            landing_margins(carried, b, n_ended)
        if traced:
            trace_landings(b, index, told, n_ended)
        n_one = stick_one(b, index, n_ended, crossed)
        n_crossing = pick(b, at.NEXT_KIND, at.CROSSED, n_ended, index, at.CROSSING)
        if n_one + n_crossing == at.ZERO:
            return
    for i in range(n_one):
        value[start + index[at.WHO_ONE + np.uint64(i)]] = math.inf
    for i in range(n_crossing):
        value[start + index[at.WHO_END + index[at.CROSSING + np.uint64(i)]]] = math.inf


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
    for place in range(start, stop, at.BLOCK):
        n = np.uint64(min(at.BLOCK, stop - place))
        first = np.uint64(place)
        traced = told is not None
        carry_block(carried, b, index, n, value, slope, first, max_events, few, traced, along, told)
        tell(b, index, value, first, n, told)
