"""The event map of many motions at once, in lanes that take their steps together."""

# Template (`numerics.targets.instantiate`): steps generated from a law, and the scalar engine's
# decisions. Three pools hold the motions by which blocks slip; the first `LANES` of the fullest
# pool step next. A motion that needs a rare decision goes to the scalar engine, from its start; one
# that seems to last goes there as it is, to be told that it never returns.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.itinerary import GLOBAL_STICK, hashed, mode_code
from stickslip.mechanics.eventmap.records import (
    LONG,
    Asked,
    Clock,
    Controls,
    Mark,
    Models,
    Outputs,
    Pools,
    Tags,
)
from stickslip.mechanics.flow.dense import (
    OFF,
    SLACK,
    UNHEEDED,
    clearance,
    is_followed,
    keep_first,
)
from stickslip.mechanics.flow.lanes import layout as at
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    FORWARD,
    LANDING,
    STICK,
    Floats,
    Motion,
)
from stickslip.numerics.polynomial import search, signal_rounding
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.numerics.vector import LANES
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.mechanics.flow.lanes._step_kernels import (
        step_both,
        step_one,
        tangent_both,
        tangent_one,
        turns_both,
        turns_one,
    )
    from stickslip.mechanics.friction.interface import force

    CHANGING = False  # whether tangents go with a parameter, not with the start
    TELLS = False  # whether the last terms of the law's series tell how far they hold

# With this many events a motion begins again with finer steps: what steps leave out is a rounding
# of the start at first, and may grow more on the way than the start does. From then on one that
# comes back nearer from turn to turn seems to last: the scalar engine is asked, once.
MANY = 40
FINER = 1e-2  # of `rtol`
# From LONG events on it takes over one that still does; and any motion of as many events as these.
LASTS = 1024
TURNS = 3e-3  # of the contact's limit: a motion that comes back as near has made a turn
# Pools by which block rides: one of them, or none. Its row of numbers is in the order of blocks.
BOTH_SLIP = 2
# A force nearer its limit, in units of EPSILON times the terms that make it up, is a tie.
TIE = 64.0


@kernel(short_loops=True)
def advance_orbits(
    models: Models,
    orbits: Floats,
    filled: NDArray[np.int64],
    start: int,
    stop: int,
    pools: Pools,
    controls: Controls,
    watch: bool,
    outputs: Outputs,
    asked: Asked,
) -> None:
    """Fill rows ``start..stop`` of `orbits`, each from its place ``filled`` on."""
    # A row with the status `HANDED_OVER` waits for the scalar engine to carry its last place, or
    # with `LASTING` to go on from a state.
    allowed = last_term(controls.rtol)
    pools.counts[:] = 0
    pools.models[:] = -1
    point, n_ready = start, 0
    while True:
        active = pools.counts[0] + pools.counts[1] + pools.counts[2]
        while active < at.MOTIONS and (n_ready > 0 or point < stop):
            if n_ready > 0:
                n_ready -= 1
                row = pools.rows[n_ready]
            else:
                row = point
                point += 1
            active += begin(models, pools, orbits, filled, outputs, row, allowed)
        pool = fullest(pools)
        if pools.counts[pool] == 0:
            break
        step(pools, pool, watch)
        for k in range(find_flagged(pools, pool) - 1, -1, -1):
            lane = pools.flagged[k]
            row = meet(models, pools, controls, watch, orbits, filled, outputs, asked, pool, lane)
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
def step(pools: Pools, pool: int, watch: bool) -> None:
    """Take one step in every lane of a pool."""
    x, taken, numbers = pools.x[pool], pools.taken, pools.numbers[pool]
    first, second = pools.laws[pool, 0], pools.laws[pool, 1]
    tangents = pools.motion.tangent_w.shape[1] > 0
    if pool == BOTH_SLIP:
        step_both(x, taken, first, second, numbers)
        if tangents:
            tangent_both(x, taken, first, second, numbers)
        if watch:
            turns_both(x, taken, numbers)
        return
    step_one(x, taken, first, second, numbers)
    if tangents:
        tangent_one(x, taken, first, second, numbers)
    if watch:
        turns_one(x, taken, numbers)


@kernel(inline=True)
def find_flagged(pools: Pools, pool: int) -> int:
    """List the lanes whose step has to be looked at; without a branch for each lane."""
    taken, n = pools.taken, 0
    for lane in range(min(pools.counts[pool], LANES)):
        pools.flagged[n] = lane
        n += int(taken[at.FLAG + lane] != 0.0)
    return n


@kernel(inline=True)
def begin(
    models: Models,
    pools: Pools,
    orbits: Floats,
    filled: NDArray[np.int64],
    outputs: Outputs,
    row: int,
    allowed: float,
) -> int:
    """Start the next motion of a row, if it has one for the lanes; return 1 if it has."""
    last = orbits.shape[1] - 1
    while filled[row] < last and math.isnan(orbits[row, filled[row]]):
        filled[row] += 1
        orbits[row, filled[row]] = math.nan
    if filled[row] == last:
        return 0
    motion, pair = pools.motion, models.numbers[models.of[row], BOTH_SLIP]
    if not onset(pair, motion, orbits[row, filled[row]]):
        outputs.status[row] = at.HANDED_OVER
        return 0
    code = mode_code(motion)
    tags = Tags(row, 0, code, 1 if motion.mode[0] != 0 else 2, hashed(np.uint64(1), code))
    clock, mark = Clock(0.0, 0.0, math.inf, allowed), Mark(0.0, 0.0, -1.0, math.inf)
    enter(models, pools, tags, clock, mark)
    return 1


@kernel(inline=True)
def last_term(rtol: float) -> float:
    """log2 of the last terms kept: the first one left out is about rtol^(1 / ORDER) times these."""
    return math.log2(rtol) * (at.ORDER / (at.ORDER + 1.0))


@kernel(inline=True)
def onset(pair: Floats, motion: Motion, d: float) -> bool:
    """Begin the slip from a global stick phase; False at a tie: margin and slope of its own."""
    gained = pair[at.GAIN + 1] * d
    limit = pair[at.LIMIT + 1]
    lead = pair[at.SIDE + 1] * (pair[at.BASE + 1] + gained) - limit
    first = 0 if lead < 0.0 else 1
    rider = 1 - first
    end = pair[at.LIMIT + rider]
    motion.mode[first] = -int(pair[at.SIDE + first])
    motion.mode[rider] = STICK
    motion.w[first] = motion.w[rider] = 0.0
    motion.e[first] = pair[at.SIDE + first] * pair[at.LIMIT + first]
    motion.e[rider] = min(max(pair[at.BASE + rider] + pair[at.GAIN + rider] * d, -end), end)
    for column in range(motion.tangent_w.shape[1]):
        motion.tangent_w[first, column] = motion.tangent_w[rider, column] = 0.0
        motion.tangent_e[first, column] = 0.0
        motion.tangent_e[rider, column] = pair[at.GAIN + rider]
        if CHANGING:
            changes = pair[at.CHANGE :]
            motion.tangent_e[first, column] = pair[at.SIDE + first] * changes[at.LIMIT + first]
            motion.tangent_e[rider, column] = (
                changes[at.BASE + rider] + changes[at.GAIN + rider] * d
            )
    return abs(lead) > TIE * EPSILON * (abs(pair[at.BASE + 1]) + abs(gained) + limit)


@kernel(inline=True)
def enter(models: Models, pools: Pools, tags: Tags, clock: Clock, mark: Mark) -> None:
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
    x[at.SIGN_1 + lane] = motion.mode[first]
    x[at.SIGN_2 + lane] = motion.mode[second]
    x[at.SPEED_1 + lane] = motion.mode[first] * motion.w[first]
    x[at.SPEED_2 + lane] = motion.mode[second] * motion.w[second]
    x[at.FORCE_1 + lane] = motion.e[first]
    x[at.FORCE_2 + lane] = motion.e[second]
    if motion.tangent_w.shape[1] > 0:
        x[at.D_SPEED_1 + lane] = motion.mode[first] * motion.tangent_w[first, 0]
        x[at.D_SPEED_2 + lane] = motion.mode[second] * motion.tangent_w[second, 0]
        x[at.D_FORCE_1 + lane] = motion.tangent_e[first, 0]
        x[at.D_FORCE_2 + lane] = motion.tangent_e[second, 0]
    x[at.TIME + lane] = 0.0
    x[at.STEPS + lane] = clock.steps
    x[at.DURATION + lane] = clock.duration
    x[at.MARGIN + lane] = clock.margin
    x[at.LAST_TERM + lane] = clock.last_term
    x[at.HALVED + lane] = 0.0
    x[at.MARKED_W + lane] = mark.w
    x[at.MARKED_E + lane] = mark.e
    x[at.MARKED_MODES + lane] = mark.modes
    x[at.TURN + lane] = mark.turn
    pools.tags[pool, lane, 0] = tags.row
    pools.tags[pool, lane, 1] = tags.n_events
    pools.tags[pool, lane, 2] = tags.code
    pools.tags[pool, lane, 3] = tags.before
    pools.labels[pool, lane] = tags.label
    model = models.of[tags.row]
    if pools.models[pool, lane] != model:
        bring_numbers(models, pools, pool, lane, model)


@kernel
def bring_numbers(models: Models, pools: Pools, pool: int, lane: int, model: int) -> None:
    """Put the numbers of a motion's model beside it."""
    pools.models[pool, lane] = model
    for k in range(at.NUMBERS if CHANGING else at.CHANGE):
        pools.numbers[pool, k * at.PLACES + lane] = models.numbers[model, pool, k]
    first = 1 if pool == 1 else 0
    for k in range(2):
        row = models.rows[model, first if k == 0 else 1 - first]
        for j in range(row.size):
            pools.laws[pool, k, j * at.PLACES + lane] = row[j]
    if pool == BOTH_SLIP:
        pair = models.numbers[model, pool]
        for block in range(2):
            steady = force(models.laws[model, block], BACKWARD, abs(pair[at.BELT]))
            place = (at.STEADY + block) * at.PLACES + lane
            pools.numbers[pool, place] = pair[at.LIMIT + block] * steady


@kernel(inline=True)
def leave(models: Models, pools: Pools, pool: int, lane: int) -> None:
    """Take a motion out of its pool; the last one moves to its place."""
    x = pools.x[pool]
    last = pools.counts[pool] - 1
    pools.counts[pool] = last
    for row in range(0, at.KEPT, at.PLACES):
        x[row + lane] = x[row + last]
    for k in range(4):
        pools.tags[pool, lane, k] = pools.tags[pool, last, k]
    pools.labels[pool, lane] = pools.labels[pool, last]
    model = models.of[pools.tags[pool, lane, 0]]
    if pools.models[pool, lane] != model:
        bring_numbers(models, pools, pool, lane, model)


@kernel(inline=True)
def meet(
    models: Models,
    pools: Pools,
    controls: Controls,
    watch: bool,
    orbits: Floats,
    filled: NDArray[np.int64],
    outputs: Outputs,
    asked: Asked,
    pool: int,
    lane: int,
) -> int:
    """Deal with the signals of a step as `carry` does; return a row whose motion ended, or -1."""
    x, taken, motion = pools.x[pool], pools.taken, pools.motion
    row, n_events, code, before = pools.tags[pool, lane]
    model = models.of[row]
    laws, numbers, pair = (
        models.laws[model],
        models.numbers[model, pool],
        models.numbers[model, BOTH_SLIP],
    )
    h = first_event(pools, numbers, pool, lane)
    here = (1 if motion.event[0] != 0 else 0) + (2 if motion.event[1] != 0 else 0)
    if h >= 0.0 and here != 0:
        state_at(pools, numbers, pool, lane, h)
        if not TELLS and not follows_laws(laws, pair, pools, pool, lane, h):
            undo(pools, pool, lane)
            return -1
    if h >= 0.0 and watch:
        x[at.MARGIN + lane] = min(x[at.MARGIN + lane], watch_step(pools, numbers, pool, lane, h))
    if h >= 0.0 and here == 0:
        return -1
    phase = taken[at.TIME_BEFORE + lane] + h
    duration = x[at.DURATION + lane] + phase
    room = -1.0
    if h >= 0.0 and here != 3 and phase > 0.0 and duration <= controls.max_time:
        room = settle(pair, laws, motion, here - 1)
    if room < 0.0:
        leave(models, pools, pool, lane)
        outputs.status[row] = at.HANDED_OVER
        return -1
    margin = min(x[at.MARGIN + lane], room)
    if here != before:
        margin = min(margin, phase)
    label = pools.labels[pool, lane]
    clock = Clock(x[at.STEPS + lane], duration, margin, x[at.LAST_TERM + lane])
    mark = Mark(
        x[at.MARKED_W + lane],
        x[at.MARKED_E + lane],
        x[at.MARKED_MODES + lane],
        x[at.TURN + lane],
    )
    leave(models, pools, pool, lane)
    new_code = mode_code(motion)
    if new_code != code:
        n_events += 1
        label = hashed(label, new_code)
    if new_code == GLOBAL_STICK:
        finish(pair, motion, outputs, row, n_events, label, clock)
        filled[row] += 1
        orbits[row, filled[row]] = outputs.value[row]
        return row
    recurs = False
    if n_events >= MANY:
        mark, recurs = turned(pair, motion, 2 - here, new_code, n_events, mark)
    is_asked = asked.step[row] == filled[row]
    lasts = recurs and is_asked and n_events >= LONG
    if lasts or n_events >= min(LASTS, controls.max_events):
        outputs.status[row] = at.HANDED_OVER
    elif recurs and not is_asked:
        asked.step[row] = filled[row]
        write_state(pair, motion, asked.state[row])
        note(outputs, row, at.LASTING, n_events, label, clock)
    elif n_events == MANY and clock.last_term == last_term(controls.rtol):
        begin(models, pools, orbits, filled, outputs, row, last_term(FINER * controls.rtol))
    else:
        enter(models, pools, Tags(row, n_events, new_code, here, label), clock, mark)
    return -1


@kernel(inline=True)
def turned(
    pair: Floats, motion: Motion, other: int, code: int, n_events: int, mark: Mark
) -> tuple[Mark, bool]:
    """Compare a state with the marked one; return the next mark, and whether turns contract."""
    w, e, modes = motion.w[other], motion.e[other], 2.0 * code + other
    if n_events & (n_events - 1) == 0:  # by Brent: the longer a motion, the longer its turns
        return Mark(w, e, modes, math.inf), False
    turn = (abs(w - mark.w) + abs(e - mark.e)) / pair[at.LIMIT + other]
    if modes != mark.modes or turn > TURNS:
        return mark, False
    # Turns that go on to shrink like the last one lead as near; later any that shrink will do.
    ends = turn * turn <= TURNS * (mark.turn - turn) or n_events >= LONG
    return Mark(w, e, modes, turn), ends and turn <= mark.turn < math.inf


@kernel
def follows_laws(laws: Floats, pair: Floats, pools: Pools, pool: int, lane: int, h: float) -> bool:
    """Whether ``pools.motion``, at an event of a lane's last step, has the rates of its series."""
    motion, last_term = pools.motion, pools.x[pool, at.LAST_TERM + lane]
    first = 1 if pool == 1 else 0
    for k in range(2 if pool == BOTH_SLIP else 1):
        block = first if k == 0 else 1 - first
        row = (at.SERIES_1 if k == 0 else at.SERIES_2) + lane
        told = 0.0
        for j in range(at.ORDER, 0, -1):
            told = told * h + j * pools.taken[row + j * LANES]
        rate = motion.mode[block] * rate_of(pair, laws, motion, block)
        size = pair[at.LIMIT + block] + abs(motion.e[block])
        if not is_followed(rate, told, OFF * 2.0**last_term / h + UNHEEDED * size):
            return False
    return True


@kernel(inline=True)
def undo(pools: Pools, pool: int, lane: int) -> None:
    """Take a lane's last step back, for one of half its length."""
    x, taken = pools.x[pool], pools.taken
    x[at.SPEED_1 + lane] = taken[at.SERIES_1 + lane]
    if pool == BOTH_SLIP:
        x[at.SPEED_2 + lane] = taken[at.SERIES_2 + lane]
    x[at.FORCE_1 + lane] = taken[at.FORCE_1_BEFORE + lane]
    x[at.FORCE_2 + lane] = taken[at.FORCE_2_BEFORE + lane]
    x[at.TIME + lane] = taken[at.TIME_BEFORE + lane]
    x[at.HALVED + lane] += 2.0  # the step has taken 1 off, as one that went well
    if pools.motion.tangent_w.shape[1] > 0:
        x[at.D_SPEED_1 + lane] = taken[at.D_SERIES_1 + lane]
        if pool == BOTH_SLIP:
            x[at.D_SPEED_2 + lane] = taken[at.D_SERIES_2 + lane]
        x[at.D_FORCE_1 + lane] = taken[at.D_FORCE_1_BEFORE + lane]
        x[at.D_FORCE_2 + lane] = taken[at.D_FORCE_2_BEFORE + lane]


@kernel(inline=True)
def settle(pair: Floats, laws: Floats, motion: Motion, block: int) -> float:
    """Change the mode of the block with an event; return the clearance, < 0 if rounding decides."""
    other = 1 - block
    event = motion.event[block]
    rate, rate_other = rate_of(pair, laws, motion, block), rate_of(pair, laws, motion, other)
    loading = loading_rate(pair, motion.w, block, rate, rate_other)
    excess = abs(motion.e[block]) - pair[at.LIMIT + block]
    margin = math.inf
    if motion.mode[other] == STICK:
        margin = pair[at.MASS + other] * abs(pair[at.LIMIT + other] - abs(motion.e[other]))
    if event == LANDING:
        if abs(excess) <= TIE * EPSILON * (pair[at.LIMIT + block] + abs(motion.e[block])):
            return -1.0
        margin = min(margin, pair[at.MASS + block] * abs(excess), abs(rate))
    elif (loading - pair[at.DRIFT + block]) * pair[at.DRIFT + block] < 0.0:
        # The other block unloads this one, which may turn back.
        margin = min(margin, pair[at.MASS + block] * abs(loading))
    signal_rate = rate if event == LANDING else loading
    transversal = abs(signal_rate) > 8.0 * EPSILON * pair[at.LIMIT + block]
    loading_other = loading_rate(pair, motion.w, other, rate_other, rate)
    end = 0.0
    if CHANGING and event != LANDING:
        end = pair[at.CHANGE + at.LIMIT + block] * (1.0 if event == AT_UPPER_LIMIT else -1.0)
    for column in range(motion.tangent_w.shape[1]):
        changes = motion.tangent_w if event == LANDING else motion.tangent_e
        shift = (end - changes[block, column]) / signal_rate if transversal else 0.0
        motion.tangent_w[block, column] = 0.0
        motion.tangent_e[block, column] += loading * shift
        motion.tangent_w[other, column] += rate_other * shift
        motion.tangent_e[other, column] += loading_other * shift
        if event != LANDING:
            motion.tangent_e[block, column] = end
    motion.w[block] = 0.0
    if event == LANDING:
        outside = BACKWARD if motion.e[block] > 0.0 else FORWARD
        motion.mode[block] = STICK if excess < 0.0 else outside
    else:
        motion.mode[block] = BACKWARD if event == AT_UPPER_LIMIT else FORWARD
        motion.e[block] = -motion.mode[block] * pair[at.LIMIT + block]
    return margin


@kernel(inline=True)
def rate_of(pair: Floats, laws: Floats, motion: Motion, block: int) -> float:
    """Rate w' of a block in its mode."""
    mode = motion.mode[block]
    if mode == STICK:
        return 0.0
    s = max(mode * motion.w[block], 0.0)
    return -mode * pair[at.LIMIT + block] * force(laws[block], mode, s) - motion.e[block]


@kernel(inline=True)
def loading_rate(pair: Floats, w: Floats, block: int, rate: float, rate_other: float) -> float:
    """Rate e' of a block; `rate`: its own w'."""
    loading = pair[at.STIFF + block] * w[block] + pair[at.CROSS + block] * w[1 - block]
    damping = pair[at.DAMP + block] * rate + pair[at.DRAG + block] * rate_other
    return loading + pair[at.DRIFT + block] + damping


@kernel(inline=True)
def finish(
    pair: Floats,
    motion: Motion,
    outputs: Outputs,
    row: int,
    n_events: int,
    label: np.uint64,
    clock: Clock,
) -> None:
    """Note a return to global stick."""
    value = (difference(pair, motion.e[0], motion.e[1]) - pair[at.SHIFT]) / pair[at.DETERMINANT]
    outputs.value[row] = value
    note(outputs, row, OK, n_events, label, clock)
    for column in range(motion.tangent_e.shape[1]):
        slope = difference(pair, motion.tangent_e[0, column], motion.tangent_e[1, column])
        if CHANGING:
            changes = pair[at.CHANGE :]
            slope += difference(changes, motion.e[0], motion.e[1])
            slope -= changes[at.SHIFT] + value * changes[at.DETERMINANT]
        outputs.derivative[row, column] = slope / pair[at.DETERMINANT]


@kernel(inline=True)
def note(
    outputs: Outputs, row: int, status: int, n_events: int, label: np.uint64, clock: Clock
) -> None:
    """Note what is known of a motion at its last event."""
    outputs.duration[row] = clock.duration
    outputs.n_events[row] = n_events
    outputs.label[row] = label
    outputs.margin[row] = clock.margin
    outputs.status[row] = status


@kernel(inline=True)
def write_state(pair: Floats, motion: Motion, state: Floats) -> None:
    """Keep a state at an event, as `begin` takes it: forces in units of the limits."""
    for block in range(2):
        state[block], state[2 + block] = motion.mode[block], motion.event[block]
        state[4 + block] = motion.w[block]
        state[6 + block] = motion.e[block] / pair[at.LIMIT + block]


@kernel(inline=True)
def difference(pair: Floats, e_1: float, e_2: float) -> float:
    """Numerator of the relative displacement that goes with needed forces."""
    return pair[at.SHARE + 1] * e_2 + pair[at.SHARE] * e_1


@kernel(inline=True)
def first_event(pools: Pools, numbers: Floats, pool: int, lane: int) -> float:
    """Time of the first contact on a lane's last step, else its length; negative if that failed."""
    x, taken, motion = pools.x[pool], pools.taken, pools.motion
    flag = int(taken[at.FLAG + lane])
    first = 1 if pool == 1 else 0
    second = 1 - first
    motion.mode[first] = int(x[at.SIGN_1 + lane])
    motion.mode[second] = int(x[at.SIGN_2 + lane]) if pool == BOTH_SLIP else STICK
    motion.event[0] = motion.event[1] = 0
    h = -1.0 if flag & at.DOUBTFUL else taken[at.LENGTH + lane]
    for k in range(3):
        if flag & (at.FIRST_SLIP << k) == 0 or h < 0.0:
            continue
        event = LANDING
        if k > 0 and pool != BOTH_SLIP:
            event = AT_UPPER_LIMIT if k == 1 else AT_LOWER_LIMIT
        write_signal(pools, numbers, pool, lane, k)
        start = pools.signal[0]
        size = taken[(at.SIZE_1 if k == 0 else at.SIZE_2) + lane]
        rounding = signal_rounding(start, size, SLACK * EPSILON)
        t = search(pools.signal, h, start == 0.0, rounding)
        h = keep_first(motion, first if k == 0 else second, event, t, h)
    return h


@kernel
def watch_step(pools: Pools, numbers: Floats, pool: int, lane: int, h: float) -> float:
    """Smallest clearance on a lane's last step: lobes that turned back, extremes of a rider."""
    margin = math.inf
    for k in range(2 if pool == BOTH_SLIP else 3):
        write_signal(pools, numbers, pool, lane, k)
        scale = 1.0 if k == 0 or pool == BOTH_SLIP else numbers[at.MASS + 1]
        margin = min(margin, scale * clearance(pools.signal, h))
    return margin


@kernel(inline=True)
def write_signal(pools: Pools, pair: Floats, pool: int, lane: int, k: int) -> None:
    """Series of the first speed (k = 0); of the second; or a rider's room to either limit."""
    x, taken, signal = pools.x[pool], pools.taken, pools.signal
    if k == 0 or pool == BOTH_SLIP:
        row = at.SERIES_1 if k == 0 else at.SERIES_2
        for j in range(at.ORDER + 1):
            signal[j] = taken[row + j * LANES + lane]
        return
    side = -1.0 if k == 1 else 1.0
    signal[0] = pair[at.LIMIT + 1] + side * taken[at.FORCE_2_BEFORE + lane]
    if abs(signal[0]) <= SLACK * EPSILON * pair[at.LIMIT + 1]:
        signal[0] = 0.0
    pull = side * pair[at.CROSS + 1] * x[at.SIGN_1 + lane]
    drag = side * pair[at.DRAG + 1] * x[at.SIGN_1 + lane]
    for j in range(1, at.ORDER + 1):
        signal[j] = pull * taken[at.SERIES_1 + (j - 1) * LANES + lane] * pools.reciprocals[j]
        signal[j] += drag * taken[at.SERIES_1 + j * LANES + lane]
    signal[1] += side * pair[at.DRIFT + 1]


@kernel(inline=True)
def state_at(pools: Pools, pair: Floats, pool: int, lane: int, t: float) -> None:
    """Set ``pools.motion`` to the state at a time inside a lane's last step."""
    taken, motion = pools.taken, pools.motion
    first = 1 if pool == 1 else 0
    second = 1 - first
    w_1, w_2, gained_1, gained_2 = moved(pools, pair, pool, lane, t, at.SERIES_1, at.SERIES_2)
    motion.w[first], motion.w[second] = w_1, w_2
    motion.e[first] = taken[at.FORCE_1_BEFORE + lane] + (pair[at.DRIFT] * t + gained_1)
    motion.e[second] = taken[at.FORCE_2_BEFORE + lane] + (pair[at.DRIFT + 1] * t + gained_2)
    if motion.tangent_w.shape[1] == 0:
        return
    w_1, w_2, gained_1, gained_2 = moved(pools, pair, pool, lane, t, at.D_SERIES_1, at.D_SERIES_2)
    motion.tangent_w[first, 0], motion.tangent_w[second, 0] = w_1, w_2
    if CHANGING:
        changes = pair[at.CHANGE :]
        _, _, more_1, more_2 = moved(pools, changes, pool, lane, t, at.SERIES_1, at.SERIES_2)
        gained_1 += changes[at.DRIFT] * t + more_1
        gained_2 += changes[at.DRIFT + 1] * t + more_2
    motion.tangent_e[first, 0] = taken[at.D_FORCE_1_BEFORE + lane] + gained_1
    motion.tangent_e[second, 0] = taken[at.D_FORCE_2_BEFORE + lane] + gained_2


@kernel(inline=True)
def moved(
    pools: Pools, pair: Floats, pool: int, lane: int, t: float, row_1: int, row_2: int
) -> tuple[float, float, float, float]:
    """Relative velocities at a time inside a step, and how they have changed the forces."""
    x, taken = pools.x[pool], pools.taken
    sign = x[at.SIGN_1 + lane]
    w_1, path_1 = sum_and_integral(pools.reciprocals, taken, row_1 + lane, t)
    faster_1 = sign * (w_1 - taken[row_1 + lane])
    w_1, path_1 = sign * w_1, sign * path_1
    w_2 = path_2 = faster_2 = 0.0
    if pool == BOTH_SLIP:
        sign = x[at.SIGN_2 + lane]
        w_2, path_2 = sum_and_integral(pools.reciprocals, taken, row_2 + lane, t)
        faster_2 = sign * (w_2 - taken[row_2 + lane])
        w_2, path_2 = sign * w_2, sign * path_2
    load_1 = pair[at.STIFF] * path_1 + pair[at.CROSS] * path_2
    load_2 = pair[at.STIFF + 1] * path_2 + pair[at.CROSS + 1] * path_1
    drag_1 = pair[at.DAMP] * faster_1 + pair[at.DRAG] * faster_2
    drag_2 = pair[at.DAMP + 1] * faster_2 + pair[at.DRAG + 1] * faster_1
    return w_1, w_2, load_1 + drag_1, load_2 + drag_2


@kernel
def sum_and_integral(reciprocals: Floats, taken: Floats, row: int, t: float) -> tuple[float, float]:
    """Value of a polynomial and of its integral from 0 to `t`."""
    u = t * t
    even = odd = even_path = odd_path = 0.0
    for k in range(at.ORDER // 2, 0, -1):
        c, c_odd = taken[row + 2 * k * LANES], taken[row + (2 * k - 1) * LANES]
        even = even * u + c
        odd = odd * u + c_odd
        even_path = even_path * u + c * reciprocals[2 * k + 1]
        odd_path = odd_path * u + c_odd * reciprocals[2 * k]
    c = taken[row]
    total = even * u + c + t * odd
    path = even_path * u + c + t * odd_path
    return total, path * t
