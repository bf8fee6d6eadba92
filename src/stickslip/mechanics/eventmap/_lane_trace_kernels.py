"""What is told of motions in lanes besides their values: itinerary, events, time and margin."""

# The margin is that of one motion at a time: rule 7 of docs/design.md, docs/theory/flow.md.

from __future__ import annotations

import math

import numpy as np

from stickslip.mechanics.eventmap import _lane_kernels as at
from stickslip.mechanics.eventmap._lane_kernels import Carried, Indices, constants_of
from stickslip.mechanics.eventmap.itinerary import hashed
from stickslip.mechanics.eventmap.records import UNTOLD, Outputs
from stickslip.mechanics.flow._lane_kernels import (
    CoulombConstants,
    Pair,
    belt_modes,
    clearance,
    dip,
    shares,
    slip_of,
)
from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.roots import hides_a_turn
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import ROUNDER, turned, upper_angle
from stickslip.numerics.vector import wide_vectors


@kernel(fused=True)
def begin_trace(b: Floats, index: Indices, n: np.uint64) -> None:
    """Note the first phase of each motion: one block slips backward."""
    for i in range(n):
        k = np.uint64(i)
        code = 1 if b[at.ONE_FIRST + k] > 0.5 else 3
        index[at.LABEL + k] = hashed(at.ONE, code)
        index[at.COUNT + k] = at.ZERO
        index[at.LAST + k] = at.ONE if code == 1 else at.ZERO
        b[at.ELAPSED + k] = 0.0
        b[at.MARGIN + k] = math.inf


@kernel(inline=True, fused=True)
def note(b: Floats, index: Indices, who: np.uint64, mode_1: float, mode_2: float, t: float) -> None:
    """Note an event of a motion, after a time t."""
    code = int(3.0 * mode_1 + mode_2) + 4
    index[at.LABEL + who] = hashed(index[at.LABEL + who], code)
    index[at.COUNT + who] += at.ONE
    b[at.ELAPSED + who] += t


@kernel(inline=True)
def note_margin(
    b: Floats,
    index: Indices,
    told: Outputs | None,
    who: np.uint64,
    k: np.uint64,
    first: bool,
    t: float,
) -> None:
    """Note the clearance of an event of a block, a time t after the last one, if it is told."""
    if told is None:
        return
    block = at.ONE if first else at.ZERO
    margin = smaller(b[at.MARGIN + who], b[at.CLEARANCE + k])
    b[at.MARGIN + who] = margin if index[at.LAST + who] == block else smaller(margin, t)
    index[at.LAST + who] = block


@kernel(fused=True)
def trace_one(b: Floats, index: Indices, told: Outputs | None, n: np.uint64) -> None:
    """Note returns and crossings of slips of one block."""
    for i in range(n):
        k = np.uint64(i)
        kind, who, t = b[at.ONE_KIND + k], index[at.WHO_ONE + k], b[at.ONE_TIME + k]
        first = b[at.ONE_FIRST + k] > 0.5
        if kind == at.RETURNED or kind == at.CROSSED:
            mode = b[at.ONE_SIGN + k] if kind == at.CROSSED else 0.0
            mode_1, mode_2 = (mode, 0.0) if first else (0.0, mode)
            note(b, index, who, mode_1, mode_2, t)
            note_margin(b, index, told, who, k, first, t)


@kernel(fused=True)
def trace_freed(b: Floats, index: Indices, told: Outputs | None, n: np.uint64) -> None:
    """Note the times at which riders were freed: both blocks then slip the same way."""
    for i in range(n):
        k = np.uint64(i)
        mode, who, t = -b[at.FREED_SIGN + k], index[at.WHO_TWO + k], b[at.FREED_TIME + k]
        note(b, index, who, mode, mode, t)
        note_margin(b, index, told, who, k, b[at.FREED_FIRST + k] < 0.5, t)


@kernel(fused=True)
def trace_landings(b: Floats, index: Indices, told: Outputs | None, n: np.uint64) -> None:
    """Note the ends of slips of both blocks."""
    for i in range(n):
        k = np.uint64(i)
        mode = b[at.NEXT_MODE + k] if b[at.NEXT_KIND + k] == at.CROSSED else 0.0
        second = b[at.END_LANDS + k] > 0.0
        mode_1 = b[at.END_MODE_1 + k] if second else mode
        mode_2 = mode if second else b[at.END_MODE_2 + k]
        who, t = index[at.WHO_END + k], b[at.END_TIME + k]
        note(b, index, who, mode_1, mode_2, t)
        note_margin(b, index, told, who, k, not second, t)


@kernel
def tell(
    b: Floats, index: Indices, value: Floats, start: np.uint64, n: np.uint64, told: Outputs | None
) -> None:
    """Write down what is known of the motions that returned."""
    if told is None:
        return
    for i in range(n):
        k = np.uint64(i)
        if math.isfinite(value[start + k]):
            told.duration[start + k] = b[at.ELAPSED + k]
            told.n_events[start + k] = index[at.COUNT + k]
            told.label[start + k] = index[at.LABEL + k]
            told.margin[start + k] = b[at.MARGIN + k]


# --- margins ------------------------------------------------------------------------------------


@kernel(fused=True)
def return_margins(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Clearances of slips of one block that return: of the landing, and where its rider turned."""
    wide_vectors()
    base = at.ZERO
    while base < n:
        for lane in range(at.LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            gap = b[at.ONE_GAP + k]
            sign = b[at.ONE_SIGN + k]
            first = b[at.ONE_FIRST + k] > 0.5
            slip = slip_of(constants, carried.pair, first)
            rate = sign * b[at.ONE_FORCE + k] - slip.friction
            force_end = b[at.ONE_FORCE_END + k]
            end = slip.friction - sign * force_end
            rider = b[at.ONE_RIDER + k]
            rider_end = b[at.ONE_RIDER_END + k]
            rise, high, turn, low = dip(slip, gap, rate, end, b[at.ONE_TIME + k], rider_end - rider)
            turns = sign < 0.0 and turn > 0.0
            margin = smaller(end, abs(slip.limit - abs(force_end)))
            margin = smaller(margin, abs(slip.limit_b - abs(rider_end)))
            highest = slip.limit_b - abs(rider + high)
            lowest = slip.limit_b - abs(rider + low)
            margin = smaller(margin, highest if turns and rise > 0.0 else math.inf)
            b[at.CLEARANCE + k] = smaller(margin, lowest if turns else math.inf)
        base += at.STEP


@kernel(fused=True)
def release_margins(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Clearances of slips whose rider is freed: of a lobe that turned back, of the release."""
    wide_vectors()
    base = at.ZERO
    while base < n:
        for lane in range(at.LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            sign = b[at.FREED_SIGN + k]
            first = b[at.FREED_FIRST + k] > 0.5
            slip = slip_of(constants, carried.pair, first)
            gap = b[at.FREED_GAP + k]
            t = b[at.FREED_TIME + k]
            rate = sign * b[at.FREED_FORCE + k] - slip.friction
            # Backward: where the block came nearest to the belt.
            middle = slip.loading * slip.compliance
            swing = math.sqrt((middle - gap) * (middle - gap) + rate * rate * slip.compliance)
            nearest = upper_angle(abs(rate), (middle - gap) * slip.frequency)
            nearest = (nearest if rate < 0.0 else 2.0 * math.pi - nearest) * slip.unit
            back = middle - swing if nearest < t else math.inf
            # Forward: where the rider's force turned before, and how it meets the limit.
            rise, high, _, _ = dip(slip, gap, rate, slip.friction, 0.0, 0.0)
            speed = abs(slip.loading_b - slip.coupling * b[at.START_W + k])
            highest = slip.limit_b - abs(b[at.FREED_RIDER + k] + high)
            ahead = smaller(speed, highest if rise > 0.0 else math.inf)
            b[at.CLEARANCE + k] = back if sign > 0.0 else ahead
        base += at.STEP


@kernel(inline=True)
def smaller(a: float, b: float) -> float:
    """Return the smaller one."""
    return a if a < b else b


@kernel(inline=True, fused=True)
def turned_back(
    constants: CoulombConstants,
    s: float,
    c: float,
    z: float,
    u: float,
    sum_w: float,
    sum_pull: float,
    gap_w: float,
    gap_pull: float,
) -> tuple[float, float, float, float]:
    """Sum and difference some time ago; (s, c), (z, u): sine and cosine, z over the frequency."""
    return (
        sum_w * c - sum_pull * s,
        sum_pull * c + sum_w * s,
        gap_w * u - gap_pull * z,
        gap_pull * u + constants.spread * gap_w * z,
    )


# Numbers of the lanes while the times before their landings are gone through: all in SPARE, for
# LLVM does not look whether places of several streams overlap in a loop as short as this.
(
    LANDS, END_W, SUM_PULL, GAP_PULL, E_1, E_2, TIME, AT_SUM_W, AT_SUM_PULL, AT_GAP_W, AT_GAP_PULL,
    BACK, SINE, COSINE, GAP_SINE, GAP_COSINE, PIECES, LEAST, MODES, SLOPE, BEND, LOWEST, NEAREST,
) = (at.SPARE + np.uint64(i * at.LANES) for i in (*range(18), 18, 20, 22, 24, 26))  # fmt: skip
# How near to the bottom of a lobe three steps have to come, in intervals.
NEAR_BOTTOM = 1e-4
# Intervals in the time in which the faster mode turns by 1: `watch_both` takes as many.
FINE = 4.0


@kernel(inline=True, fused=True)
def end_of(
    constants: CoulombConstants, pair: Pair | None, b: Floats, i: np.uint64
) -> tuple[float, float, float, float]:
    """Sum and difference of two blocks as one lands."""
    of_sum, of_gap = shares(pair, -b[LANDS + i])
    belt_sum, belt_gap = belt_modes(constants, pair)
    w = b[END_W + i]
    return of_sum * w + belt_sum, b[SUM_PULL + i], of_gap * w + belt_gap, b[GAP_PULL + i]


@kernel(inline=True, fused=True)
def look_back(carried: Carried, b: Floats, base: np.uint64, block: int, piece: float) -> None:
    """Note where a block came nearest to the belt, if it turned back in this interval."""
    side = -1.0 if block == 0 else 1.0
    place = np.uint64(block * at.LANES)
    for lane in range(at.LANES):
        i = np.uint64(lane)
        constants = constants_of(carried.common, carried.rows, b, base + i)
        f, f_1, f_2, _, _ = clearance(
            constants,
            carried.pair,
            b[MODES + place + i],
            side,
            b[AT_SUM_W + i],
            b[AT_SUM_PULL + i],
            b[AT_GAP_W + i],
            b[AT_GAP_PULL + i],
        )
        # Read before any branch: what is read in one is gathered, lane by lane.
        later, bend, back = b[SLOPE + place + i], b[BEND + place + i], b[BACK + i]
        lowest, nearest, least = b[LOWEST + place + i], b[NEAREST + place + i], b[LEAST + i]
        inside = piece > 0.0 and piece <= b[PIECES + i]
        turns = f_1 < 0.0 and later >= 0.0 and inside
        ahead = back * f_1 / (f_1 - later)
        bottom = f + 0.5 * ahead * f_1
        lower = turns and bottom < lowest
        b[LOWEST + place + i] = bottom if lower else lowest
        b[NEAREST + place + i] = piece * back - ahead if lower else nearest
        hidden = hides_a_turn(f_1, later, f_2, bend, back) and inside
        b[LEAST + i] = UNTOLD if hidden else least
        b[SLOPE + place + i] = f_1
        b[BEND + place + i] = f_2


@kernel(inline=True, fused=True)
def bottom_step(
    constants: CoulombConstants,
    pair: Pair | None,
    b: Floats,
    i: np.uint64,
    mode: float,
    side: float,
    t: float,
    low: float,
    high: float,
) -> tuple[float, float, float, float, float]:
    """One step of Newton's method to the bottom of a lobe: (t, low, high, clearance, step)."""
    sum_w, sum_pull, gap_w, gap_pull = end_of(constants, pair, b, i)
    s, c = turned(t)
    z, u = turned(constants.beat * t)
    z = z * constants.beat * constants.narrow
    now = turned_back(constants, s, c, z, u, sum_w, sum_pull, gap_w, gap_pull)
    f, f_1, f_2, _, _ = clearance(constants, pair, mode, side, *now)
    step = f_1 / f_2 if f_2 > 0.0 else math.inf
    high = t if f_1 < 0.0 else high
    low = low if f_1 < 0.0 else t
    ahead = t + step
    ahead = ahead if low <= ahead and ahead <= high else 0.5 * (low + high)
    return ahead, low, high, f - 0.5 * f_1 * step, step


@kernel(inline=True, fused=True)
def nearest_clearance(carried: Carried, b: Floats, base: np.uint64, lane: int, block: int) -> float:
    """Clearance of the lobe that `look_back` found; infinite without one."""
    side = -1.0 if block == 0 else 1.0
    i, place = np.uint64(lane), np.uint64(block * at.LANES + lane)
    constants, pair = constants_of(carried.common, carried.rows, b, base + i), carried.pair
    mode, t, back = b[MODES + place], b[NEAREST + place], b[BACK + i]
    low = back * (((t / back - 0.5) + ROUNDER) - ROUNDER)
    high = low + back
    # Written out: a loop inside one over lanes is left scalar.
    t, low, high, _, _ = bottom_step(constants, pair, b, i, mode, side, t, low, high)
    t, low, high, _, _ = bottom_step(constants, pair, b, i, mode, side, t, low, high)
    _, _, _, least, step = bottom_step(constants, pair, b, i, mode, side, t, low, high)
    least = least if least > 0.0 else 0.0
    least = least if abs(step) < NEAR_BOTTOM * back else UNTOLD
    return least if b[LOWEST + place] < math.inf else math.inf


@kernel(inline=True, fused=True)
def add_nearest(carried: Carried, b: Floats, base: np.uint64, block: int) -> None:
    """Let the lobes of a block count, if any was found: they are few."""
    place = np.uint64(block * at.LANES)
    lobes = 0
    for lane in range(at.LANES):
        lobes += int(b[LOWEST + place + np.uint64(lane)] < math.inf)
    if lobes > 0:
        for lane in range(at.LANES):
            i = np.uint64(lane)
            b[LEAST + i] = smaller(b[LEAST + i], nearest_clearance(carried, b, base, lane, block))


@kernel(fused=True)
def lay_out_landings(b: Floats, base: np.uint64, n: np.uint64) -> None:
    """Gather what is known of some landings in SPARE; what pads a group took no time."""
    for lane in range(at.LANES):
        i = np.uint64(lane)
        k = base + i
        b[LANDS + i] = b[at.END_LANDS + k]
        b[END_W + i] = b[at.NEXT_W + k]
        b[SUM_PULL + i] = b[at.END_SUM_PULL + k]
        b[GAP_PULL + i] = b[at.END_GAP_PULL + k]
        b[E_1 + i] = b[at.NEXT_E1 + k]
        b[E_2 + i] = b[at.NEXT_E2 + k]
        b[TIME + i] = b[at.END_TIME + k] if k < n and b[at.NEXT_KIND + k] != at.UNDECIDED else 0.0
        b[MODES + i] = b[at.END_MODE_1 + k]
        b[MODES + at.STEP + i] = b[at.END_MODE_2 + k]


@kernel(inline=True, fused=True)
def begin_at_landings(carried: Carried, b: Floats, base: np.uint64) -> None:
    """Clearances of landings, and all that leads back from them."""
    for lane in range(at.LANES):
        i = np.uint64(lane)
        constants = constants_of(carried.common, carried.rows, b, base + i)
        side = b[LANDS + i]
        second = side > 0.0
        sum_w, sum_pull, gap_w, gap_pull = end_of(constants, carried.pair, b, i)
        e_1, e_2 = b[E_1 + i], b[E_2 + i]
        force = e_2 if second else e_1
        limit = constants.limit_2 if second else constants.limit_1
        of_sum, of_gap = shares(carried.pair, side)
        rate = 0.5 * (of_sum * sum_pull + of_gap * gap_pull)
        b[LEAST + i] = smaller(abs(limit - abs(force)), abs(rate))
        pieces = 1.0 + ((FINE * b[TIME + i] * constants.beat + ROUNDER) - ROUNDER)
        back = b[TIME + i] / pieces
        s, c = turned(back)
        z, u = turned(constants.beat * back)
        b[AT_SUM_W + i] = sum_w
        b[AT_SUM_PULL + i] = sum_pull
        b[AT_GAP_W + i] = gap_w
        b[AT_GAP_PULL + i] = gap_pull
        b[BACK + i] = back
        b[PIECES + i] = pieces
        b[SINE + i] = s
        b[COSINE + i] = c
        b[GAP_SINE + i] = z * constants.beat * constants.narrow
        b[GAP_COSINE + i] = u
        b[LOWEST + i] = b[LOWEST + at.STEP + i] = math.inf
        b[NEAREST + i] = b[NEAREST + at.STEP + i] = 0.0


@kernel(fused=True)
def landing_margins(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Clearances of slips of both blocks up to a landing: of this, and of lobes before."""
    wide_vectors()
    base = at.ZERO
    while base < n:
        lay_out_landings(b, base, n)
        begin_at_landings(carried, b, base)
        longest = 1.0
        for lane in range(at.LANES):
            longest = max(longest, b[PIECES + np.uint64(lane)])
        look_back(carried, b, base, 0, 0.0)
        look_back(carried, b, base, 1, 0.0)
        for piece in range(1, int(longest) + 1):
            for lane in range(at.LANES):
                i = np.uint64(lane)
                constants = constants_of(carried.common, carried.rows, b, base + i)
                sum_w, sum_pull, gap_w, gap_pull = turned_back(
                    constants,
                    b[SINE + i],
                    b[COSINE + i],
                    b[GAP_SINE + i],
                    b[GAP_COSINE + i],
                    b[AT_SUM_W + i],
                    b[AT_SUM_PULL + i],
                    b[AT_GAP_W + i],
                    b[AT_GAP_PULL + i],
                )
                b[AT_SUM_W + i] = sum_w
                b[AT_SUM_PULL + i] = sum_pull
                b[AT_GAP_W + i] = gap_w
                b[AT_GAP_PULL + i] = gap_pull
            look_back(carried, b, base, 0, float(piece))
            look_back(carried, b, base, 1, float(piece))
        add_nearest(carried, b, base, 0)
        add_nearest(carried, b, base, 1)
        for lane in range(at.LANES):
            b[at.CLEARANCE + base + np.uint64(lane)] = b[LEAST + np.uint64(lane)]
        base += at.STEP
