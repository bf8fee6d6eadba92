"""The event map of many motions at once, in lanes that take their steps together."""

# Template (`numerics.targets.instantiate`): steps generated from a law, and the scalar engine's
# decisions. Three pools hold the motions by which blocks slip; the first `LANES` of the fullest
# pool step next. A motion that needs a rare decision goes to the scalar engine, from its start.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.itinerary import hashed
from stickslip.mechanics.eventmap.records import Clock, Controls, Outputs, Pools, Tags
from stickslip.mechanics.flow.dense import FORCE_ROUNDING, SLACK, keep_first, watch_step
from stickslip.mechanics.flow.lanes.layout import (
    D_FORCE_1,
    D_FORCE_1_BEFORE,
    D_FORCE_2,
    D_FORCE_2_BEFORE,
    D_SERIES_1,
    D_SERIES_2,
    D_SPEED_1,
    D_SPEED_2,
    DOUBTFUL,
    DURATION,
    FIRST_SLIP,
    FLAG,
    FORCE_1,
    FORCE_1_BEFORE,
    FORCE_2,
    FORCE_2_BEFORE,
    HANDED_OVER,
    KEPT,
    LENGTH,
    MARGIN,
    MOTIONS,
    ORDER,
    PLACES,
    SERIES_1,
    SERIES_2,
    SIGN_1,
    SIGN_2,
    SIZE_1,
    SIZE_2,
    SPEED_1,
    SPEED_2,
    STEPS,
    TIME,
    TIME_BEFORE,
)
from stickslip.mechanics.flow.saltation import saltation
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    LANDING,
    Floats,
    Motion,
    System,
    limit,
)
from stickslip.mechanics.flow.transitions import onset, round_landings, settle
from stickslip.numerics.polynomial import search, signal_rounding
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.numerics.vector import LANES
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._kernels import (
        blocks_of_event,
        event_margin,
        mode_code,
        value_tangent,
    )
    from stickslip.mechanics.flow._taylor_kernels import rate
    from stickslip.mechanics.flow.lanes.stub import step_both, step_one, tangent_both, tangent_one
    from stickslip.mechanics.friction.interface import force

# From this many events on the scalar engine follows a motion: it may be on a cycle, and errors of
# steps, which are smaller there, grow more than those of the start.
LONG = 16
# Pools by which block rides: one of them, or none.
BOTH_SLIP = 2
GLOBAL_STICK = 4


@kernel
def advance_orbits(
    system: System,
    laws: Floats,
    orbits: Floats,
    filled: NDArray[np.int64],
    start: int,
    stop: int,
    pools: Pools,
    controls: Controls,
    watch: bool,
    outputs: Outputs,
) -> None:
    """Fill rows ``start..stop`` of `orbits`, each from its place ``filled`` on."""
    # A row with the status `HANDED_OVER` waits for the scalar engine to carry its last place.
    steady_1 = force(laws[0], -1, system.V)
    steady_2 = system.beta * force(laws[1], -1, system.V)
    # The first term left out is about rtol^(1 / ORDER) times the last one kept.
    log_rtol = math.log2(controls.rtol) * (ORDER / (ORDER + 1.0))
    pools.counts[:] = 0
    point, n_ready = start, 0
    while True:
        active = pools.counts[0] + pools.counts[1] + pools.counts[2]
        while active < MOTIONS and (n_ready > 0 or point < stop):
            if n_ready > 0:
                n_ready -= 1
                row = pools.rows[n_ready]
            else:
                row = point
                point += 1
            active += begin(system, pools, orbits, filled, outputs, row)
        pool = fullest(pools)
        if pools.counts[pool] == 0:
            break
        step(system, pools, pool, steady_1, steady_2, log_rtol)
        for k in range(find_flagged(pools, pool) - 1, -1, -1):
            lane = pools.flagged[k]
            row = meet(system, laws, pools, controls, watch, orbits, filled, outputs, pool, lane)
            if row >= 0:
                pools.rows[n_ready] = row
                n_ready += 1


@kernel(inline=True)
def fullest(pools: Pools) -> int:
    """Return the pool with most motions."""
    pool = 0
    for k in range(1, 3):
        if pools.counts[k] > pools.counts[pool]:
            pool = k
    return pool


@kernel(inline=True)
def step(
    system: System,
    pools: Pools,
    pool: int,
    steady_1: float,
    steady_2: float,
    log_rtol: float,
) -> None:
    """Take one step in every lane of a pool."""
    x, V, alpha, beta = pools.x[pool], system.V, system.alpha, system.beta
    tangents = pools.motion.directions.shape[0] > 0
    if pool == BOTH_SLIP:
        p, q = pools.laws[0], pools.laws[1]
        step_both(x, pools.taken, p, q, alpha, V, 1.0, beta, steady_1, steady_2, log_rtol)
        if tangents:
            tangent_both(x, pools.taken, p, q, alpha, V, 1.0, beta, steady_1, steady_2, log_rtol)
        return
    p, q = pools.laws[pool], pools.laws[1 - pool]
    own, other = limit(system, pool), limit(system, 1 - pool)
    step_one(x, pools.taken, p, q, alpha, V, own, other, steady_1, steady_2, log_rtol)
    if tangents:
        tangent_one(x, pools.taken, p, q, alpha, V, own, other, steady_1, steady_2, log_rtol)


@kernel(inline=True)
def find_flagged(pools: Pools, pool: int) -> int:
    """List the lanes whose step has to be looked at; without a branch for each lane."""
    taken = pools.taken
    n = 0
    for lane in range(min(pools.counts[pool], LANES)):
        pools.flagged[n] = lane
        n += int(taken[FLAG + lane] != 0.0)
    return n


@kernel(inline=True)
def begin(
    system: System,
    pools: Pools,
    orbits: Floats,
    filled: NDArray[np.int64],
    outputs: Outputs,
    row: int,
) -> int:
    """Start the next motion of a row, if it has one for the lanes; return 1 if it has."""
    last = orbits.shape[1] - 1
    while filled[row] < last and math.isnan(orbits[row, filled[row]]):
        filled[row] += 1
        orbits[row, filled[row]] = math.nan
    if filled[row] == last:
        return 0
    motion = pools.motion
    onset(system, motion, orbits[row, filled[row]])
    if motion.mode[0] == motion.mode[1]:  # a tie, with a margin and a slope of its own
        outputs.status[row] = HANDED_OVER
        return 0
    code = mode_code(motion)
    tags = Tags(row, 0, code, 1 if motion.mode[0] != 0 else 2, hashed(np.uint64(1), code))
    enter(pools, tags, Clock(0.0, 0.0, math.inf))
    return 1


@kernel(inline=True)
def enter(pools: Pools, tags: Tags, clock: Clock) -> None:
    """Put ``pools.motion`` into the pool of its modes."""
    motion = pools.motion
    pool = BOTH_SLIP
    for block in range(2):
        if motion.mode[block] == 0:
            pool = 1 - block
    first = 1 if pool == 1 else 0
    second = 1 - first
    x = pools.x[pool]
    lane = pools.counts[pool]
    pools.counts[pool] = lane + 1
    x[SIGN_1 + lane] = motion.mode[first]
    x[SIGN_2 + lane] = motion.mode[second]
    x[SPEED_1 + lane] = motion.mode[first] * motion.w[first]
    x[SPEED_2 + lane] = motion.mode[second] * motion.w[second]
    x[FORCE_1 + lane] = motion.e[first]
    x[FORCE_2 + lane] = motion.e[second]
    if motion.directions.shape[0] > 0:
        x[D_SPEED_1 + lane] = motion.mode[first] * motion.tangent_w[first, 0]
        x[D_SPEED_2 + lane] = motion.mode[second] * motion.tangent_w[second, 0]
        x[D_FORCE_1 + lane] = motion.tangent_e[first, 0]
        x[D_FORCE_2 + lane] = motion.tangent_e[second, 0]
    x[TIME + lane] = 0.0
    x[STEPS + lane] = clock.steps
    x[DURATION + lane] = clock.duration
    x[MARGIN + lane] = clock.margin
    pools.tags[pool, lane, 0] = tags.row
    pools.tags[pool, lane, 1] = tags.n_events
    pools.tags[pool, lane, 2] = tags.code
    pools.tags[pool, lane, 3] = tags.before
    pools.labels[pool, lane] = tags.label


@kernel(inline=True)
def leave(pools: Pools, pool: int, lane: int) -> None:
    """Take a motion out of its pool; the last one moves to its place."""
    x = pools.x[pool]
    last = pools.counts[pool] - 1
    pools.counts[pool] = last
    for row in range(0, KEPT, PLACES):
        x[row + lane] = x[row + last]
    for k in range(4):
        pools.tags[pool, lane, k] = pools.tags[pool, last, k]
    pools.labels[pool, lane] = pools.labels[pool, last]


@kernel(inline=True)
def meet(
    system: System,
    laws: Floats,
    pools: Pools,
    controls: Controls,
    watch: bool,
    orbits: Floats,
    filled: NDArray[np.int64],
    outputs: Outputs,
    pool: int,
    lane: int,
) -> int:
    """Deal with the signals of a step as `carry` does; return a row whose motion ended, or -1."""
    x, taken, motion = pools.x[pool], pools.taken, pools.motion
    h = first_event(system, pools, pool, lane)
    if h >= 0.0 and watch:
        polynomials(system, x, taken, pools.w, pools.e, pool, lane)
        margin = watch_step(system, motion, pools.w, pools.e, pools.signal, h)
        x[MARGIN + lane] = min(x[MARGIN + lane], margin)
    here = blocks_of_event(motion)
    if h >= 0.0 and here == 0:
        return -1
    row, n_events, code, before = pools.tags[pool, lane]
    phase = taken[TIME_BEFORE + lane] + h
    duration = x[DURATION + lane] + phase
    if h < 0.0 or here == 3 or phase == 0.0 or duration > controls.max_time:
        leave(pools, pool, lane)
        outputs.status[row] = HANDED_OVER
        return -1
    state_at(system, pools, pool, lane, h)
    round_landings(system, motion, FORCE_ROUNDING)
    margin = x[MARGIN + lane]
    if motion.directions.shape[0] > 0:
        saltation(system, motion, rate(system, laws, motion, 0), rate(system, laws, motion, 1))
    if watch:
        margin = min(margin, event_margin(system, laws, motion))
        if here != before:
            margin = min(margin, phase)
    settle(system, motion)
    label = pools.labels[pool, lane]
    clock = Clock(x[STEPS + lane], duration, margin)
    leave(pools, pool, lane)
    new_code = mode_code(motion)
    if new_code != code:
        n_events += 1
        label = hashed(label, new_code)
    if new_code == GLOBAL_STICK:
        finish(system, motion, outputs, row, n_events, label, clock)
        filled[row] += 1
        orbits[row, filled[row]] = outputs.value[row]
        return row
    if n_events >= min(LONG, controls.max_events):
        outputs.status[row] = HANDED_OVER
    else:
        enter(pools, Tags(row, n_events, new_code, here, label), clock)
    return -1


@kernel(inline=True)
def finish(
    system: System,
    motion: Motion,
    outputs: Outputs,
    row: int,
    n_events: int,
    label: np.uint64,
    clock: Clock,
) -> None:
    """Note a return to global stick."""
    value = (motion.e[1] - motion.e[0]) / (1.0 + 2.0 * system.alpha)
    outputs.value[row] = value
    outputs.duration[row] = clock.duration
    outputs.n_events[row] = n_events
    outputs.label[row] = label
    outputs.margin[row] = clock.margin
    outputs.status[row] = OK
    if motion.directions.shape[0] > 0:
        outputs.derivative[row, 0] = value_tangent(system, motion, value, 0)


@kernel(inline=True)
def first_event(system: System, pools: Pools, pool: int, lane: int) -> float:
    """Time of the first contact on a lane's last step, else its length; negative if that failed."""
    x, taken, motion = pools.x[pool], pools.taken, pools.motion
    flag = int(taken[FLAG + lane])
    first = 1 if pool == 1 else 0
    second = 1 - first
    motion.mode[first] = int(x[SIGN_1 + lane])
    motion.mode[second] = int(x[SIGN_2 + lane]) if pool == BOTH_SLIP else 0
    motion.event[0] = motion.event[1] = 0
    h = -1.0 if flag & DOUBTFUL else taken[LENGTH + lane]
    for k in range(3):
        if flag & (FIRST_SLIP << k) == 0 or h < 0.0:
            continue
        block, event = (first, LANDING) if k == 0 else (second, LANDING)
        if k > 0 and pool != BOTH_SLIP:
            event = AT_UPPER_LIMIT if k == 1 else AT_LOWER_LIMIT
            rider_signal(system, pools, pool, lane, event)
        else:
            row = SERIES_1 if k == 0 else SERIES_2
            for j in range(ORDER + 1):
                pools.signal[j] = taken[row + j * LANES + lane]
        start = pools.signal[0]
        size = taken[(SIZE_1 if k == 0 else SIZE_2) + lane]
        rounding = signal_rounding(start, size, SLACK * EPSILON)
        t = search(pools.signal, h, start == 0.0, rounding)
        h = keep_first(motion, block, event, t, h)
    return h


@kernel(inline=True)
def rider_signal(system: System, pools: Pools, pool: int, lane: int, event: int) -> None:
    """Distance of the rider's force from one of its limits, as `dense.ride_signal`."""
    x, taken, signal, block = pools.x[pool], pools.taken, pools.signal, 1 - pool
    side = -1.0 if event == AT_UPPER_LIMIT else 1.0
    signal[0] = limit(system, block) + side * taken[FORCE_2_BEFORE + lane]
    if abs(signal[0]) <= SLACK * EPSILON * limit(system, block):
        signal[0] = 0.0
    pull = -side * system.alpha * x[SIGN_1 + lane]
    for k in range(1, ORDER + 1):
        signal[k] = pull * taken[SERIES_1 + (k - 1) * LANES + lane] * pools.reciprocals[k]
    signal[1] += side * system.V


@kernel
def polynomials(
    system: System, x: Floats, taken: Floats, w: Floats, e: Floats, pool: int, lane: int
) -> None:
    """Copy a lane's last step to `w` and `e`, by blocks."""
    first = 1 if pool == 1 else 0
    second = 1 - first
    sign_1 = x[SIGN_1 + lane]
    sign_2 = x[SIGN_2 + lane] if pool == BOTH_SLIP else 0.0
    for k in range(ORDER + 1):
        w[first, k] = sign_1 * taken[SERIES_1 + k * LANES + lane]
        w[second, k] = sign_2 * taken[SERIES_2 + k * LANES + lane]
    e[first, 0] = taken[FORCE_1_BEFORE + lane]
    e[second, 0] = taken[FORCE_2_BEFORE + lane]
    for k in range(1, ORDER + 1):
        drive = system.V if k == 1 else 0.0
        for block in range(2):
            loading = (1.0 + system.alpha) * w[block, k - 1] - system.alpha * w[1 - block, k - 1]
            e[block, k] = (loading + drive) / k


@kernel(inline=True)
def state_at(system: System, pools: Pools, pool: int, lane: int, t: float) -> None:
    """Set ``pools.motion`` to the state at a time inside a lane's last step."""
    x, taken, motion = pools.x[pool], pools.taken, pools.motion
    first = 1 if pool == 1 else 0
    second = 1 - first
    sign_1 = x[SIGN_1 + lane]
    sign_2 = x[SIGN_2 + lane] if pool == BOTH_SLIP else 0.0
    speed, path = sum_and_integral(pools.reciprocals, taken, SERIES_1 + lane, t)
    speed_2 = path_2 = 0.0
    if pool == BOTH_SLIP:
        speed_2, path_2 = sum_and_integral(pools.reciprocals, taken, SERIES_2 + lane, t)
    motion.w[first] = sign_1 * speed
    motion.w[second] = sign_2 * speed_2
    load_1, load_2 = loads(system, sign_1 * path, sign_2 * path_2)
    motion.e[first] = taken[FORCE_1_BEFORE + lane] + (system.V * t + load_1)
    motion.e[second] = taken[FORCE_2_BEFORE + lane] + (system.V * t + load_2)
    if motion.directions.shape[0] == 0:
        return
    speed, path = sum_and_integral(pools.reciprocals, taken, D_SERIES_1 + lane, t)
    speed_2 = path_2 = 0.0
    if pool == BOTH_SLIP:
        speed_2, path_2 = sum_and_integral(pools.reciprocals, taken, D_SERIES_2 + lane, t)
    motion.tangent_w[first, 0] = sign_1 * speed
    motion.tangent_w[second, 0] = sign_2 * speed_2
    load_1, load_2 = loads(system, sign_1 * path, sign_2 * path_2)
    motion.tangent_e[first, 0] = taken[D_FORCE_1_BEFORE + lane] + load_1
    motion.tangent_e[second, 0] = taken[D_FORCE_2_BEFORE + lane] + load_2


@kernel(inline=True)
def loads(system: System, path_1: float, path_2: float) -> tuple[float, float]:
    """How displacements relative to the belt change the needed forces."""
    stiff = 1.0 + system.alpha
    return stiff * path_1 - system.alpha * path_2, stiff * path_2 - system.alpha * path_1


@kernel
def sum_and_integral(reciprocals: Floats, taken: Floats, row: int, t: float) -> tuple[float, float]:
    """Value of a polynomial and of its integral from 0 to `t`."""
    u = t * t
    even = odd = even_path = odd_path = 0.0
    for k in range(ORDER // 2, 0, -1):
        c, c_odd = taken[row + 2 * k * LANES], taken[row + (2 * k - 1) * LANES]
        even = even * u + c
        odd = odd * u + c_odd
        even_path = even_path * u + c * reciprocals[2 * k + 1]
        odd_path = odd_path * u + c_odd * reciprocals[2 * k]
    c = taken[row]
    total = even * u + c + t * odd
    path = even_path * u + c + t * odd_path
    return total, path * t
