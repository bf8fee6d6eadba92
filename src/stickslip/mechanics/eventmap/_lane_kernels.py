"""Passes: phases of one kind, of many motions with constant kinetic friction, breadth first."""

# What a pass does not decide is left NaN for the exact engine.
# Lists lie in one buffer as streams, at constant offsets: the compiler sees that they do not
# overlap. Full groups of `LANES` items, the last one padded, give equal bits for any number of
# motions. Names of streams: ``ONE`` one block slips, ``FREED`` its rider reaches its limit, ``TWO``
# both slip, ``END`` they have stopped, ``NEXT`` what follows. ``D`` is a derivative in the starting
# d, or in a parameter: `Change`.

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow._lane_kernels import (
    NEAR,
    Change,
    CoulombConstants,
    Pair,
    Slip,
    belt_change,
    belt_modes,
    belt_of,
    blocks_of,
    clearance,
    contact_ahead,
    difference,
    dip,
    drawn,
    fall,
    falls_to_zero,
    friction_change,
    gap_bend,
    half_angle,
    largest_share,
    limit_change,
    modes_of,
    modes_polished,
    modes_turned,
    onset_changes,
    overload,
    return_bend,
    rider_change,
    safe_reach,
    shares,
    slip_bend,
    slip_of,
    slip_turned,
    smooth_share,
    value_change,
)
from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import turned, upper_angle
from stickslip.numerics.vector import wide_vectors

# Motions that are carried together (measured optimum), and how many a vector may hold.
BLOCK = 512
LANES = 8
# Streams a power of two apart would compete for the same lines of the first cache.
STRIDE = BLOCK + 24

# Indices are unsigned, for a signed one costs a test whether it counts from the end.
ZERO, ONE, STEP = np.uint64(0), np.uint64(1), np.uint64(LANES)

# What a pass says of an item: what it did, or that the exact engine is to decide.
RETURNED, FREED, CROSSED, STUCK, UNDECIDED = 0.0, 1.0, 2.0, 3.0, 4.0

N_STREAMS = 68
_STREAMS = tuple(np.uint64(i * STRIDE) for i in range(N_STREAMS))
# fmt: off
(
    ONE_GAP, ONE_SIGN, ONE_FIRST, ONE_FORCE, ONE_RIDER, ONE_TIME, ONE_GUESS,
    ONE_D_GAP, ONE_D_FORCE, ONE_D_RIDER,
    ONE_FORCE_END, ONE_RIDER_END, ONE_D_FORCE_END, ONE_D_RIDER_END,
    ONE_KIND, ONE_TURNS, ONE_VALUE, ONE_SLOPE,
    FREED_GAP, FREED_SIGN, FREED_FIRST, FREED_FORCE, FREED_RIDER, FREED_TIME, FREED_GUESS,
    FREED_D_GAP, FREED_D_FORCE, FREED_D_RIDER,
    START_W, START_E1, START_E2,
    TWO_SUM_W, TWO_SUM_PULL, TWO_GAP_W, TWO_GAP_PULL, TWO_BOUND_2, TWO_BOUND_4,
    TWO_MODE_1, TWO_MODE_2, TWO_TIME, TWO_FRESH, TWO_D_W, TWO_D_E1, TWO_D_E2, TWO_LANDS,
    END_SUM_W, END_SUM_PULL, END_GAP_W, END_GAP_PULL, END_BOUND_2, END_BOUND_4,
    END_MODE_1, END_MODE_2, END_TIME, END_FRESH, END_D_W, END_D_E1, END_D_E2, END_LANDS,
    NEXT_KIND, NEXT_W, NEXT_E1, NEXT_E2, NEXT_MODE,
    ELAPSED, MARGIN, CLEARANCE, SPARE,
) = _STREAMS
# fmt: on
# Where motions have constants of their own: those of the items of the present pass.
CONSTANTS = tuple(np.uint64((N_STREAMS + i) * STRIDE) for i in range(len(CoulombConstants._fields)))
# How many of their first numbers a pass needs: steps, starts, landings, slips of one block, all.
OF_STEPS, OF_STARTS, OF_LANDINGS, OF_SLIPS, OF_ONSETS = 4, 7, 13, 23, len(CONSTANTS)
# Streams that move with an item from list to list; the later ones with derivatives only.
FREED_VALUES, FREED_ALL = 7, 10
TWO_VALUES, TWO_ALL = 8, 13

Indices = NDArray[np.uint64]

# Lists of numbers: whose motion an item is, and items picked from a list.
# Of each motion: hash of its itinerary (`hashed`), how many events,
# block of the last one.
N_LISTS = 9
(
    WHO_ONE, WHO_TWO, WHO_END, PICKED, REST, CROSSING, LABEL, COUNT, LAST,
) = (np.uint64(i * STRIDE) for i in range(N_LISTS))  # fmt: skip

# Halvings of the error of a release time: see `release_pass`.
RELEASE_STEPS = 3
# A last correction beyond these has not converged: of Halley's method with a state carried on by
# its Taylor series of the second order, and of two series of the fifth order.
POLISHED = 4e-6
POLISHED_LANDING = 3e-4


class Carried(NamedTuple):
    """Models of the motions of a block."""

    common: CoulombConstants
    pair: Pair | None
    rows: Floats  # the common row, or a column for each motion


@kernel(inline=True, fused=True)
def constants_of(
    common: CoulombConstants, rows: Floats, b: Floats, k: np.uint64
) -> CoulombConstants:
    """Give the constants of an item: the common one, or its own if `rows` has a column for each."""
    if rows.ndim == 1:
        return common
    # fmt: off
    return CoulombConstants(
        b[CONSTANTS[0] + k], b[CONSTANTS[1] + k], b[CONSTANTS[2] + k], b[CONSTANTS[3] + k],
        b[CONSTANTS[4] + k], b[CONSTANTS[5] + k], b[CONSTANTS[6] + k], b[CONSTANTS[7] + k],
        b[CONSTANTS[8] + k], b[CONSTANTS[9] + k], b[CONSTANTS[10] + k], b[CONSTANTS[11] + k],
        b[CONSTANTS[12] + k], b[CONSTANTS[13] + k], b[CONSTANTS[14] + k], b[CONSTANTS[15] + k],
        b[CONSTANTS[16] + k], b[CONSTANTS[17] + k], b[CONSTANTS[18] + k], b[CONSTANTS[19] + k],
        b[CONSTANTS[20] + k], b[CONSTANTS[21] + k], b[CONSTANTS[22] + k], b[CONSTANTS[23] + k],
        b[CONSTANTS[24] + k], b[CONSTANTS[25] + k], b[CONSTANTS[26] + k], b[CONSTANTS[27] + k],
    )
    # fmt: on


@kernel(fused=True)
def load_constants(
    rows: Floats,
    index: NDArray[np.uint64],
    who: np.uint64,
    n: np.uint64,
    start: np.uint64,
    fields: int,
    b: Floats,
) -> None:
    """Lay out the first fields of constants for the items of a list, if motions have their own."""
    if rows.ndim == 2:
        for field in range(fields):
            at = CONSTANTS[field]
            for i in range(n):
                k = np.uint64(i)
                b[at + k] = rows[field, start + index[who + k]]


@kernel(inline=True, fused=True)
def release_guess(slip: Slip, longest: float, gain: float, room: float) -> float:
    """About when a rider's force that gains `gain` in the time `longest` has gained `room`."""
    inverse = 1.0 / gain
    share = room * inverse
    smooth = smooth_share(share)
    steady = slip.loading_b * longest * inverse
    steady = steady if steady < 1.0 else 1.0
    return longest * (smooth + steady * (share - smooth))


@kernel(fused=True)
def onset_pass(carried: Carried, along: Change | None, b: Floats, n: np.uint64) -> None:
    """Begin the first slips of the starts in ONE_VALUE: many return at once, with a value."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            d = b[ONE_VALUE + k]
            d = d if d > -constants.end else -constants.end
            d = d if d < constants.end else constants.end
            slip = slip_of(constants, carried.pair, True)
            lead = slip.first_rider + slip.first_slope * d - slip.limit_b
            first = lead < 0.0
            slip = slip_of(constants, carried.pair, first)
            rider = slip.first_rider + slip.first_slope * d
            limit, limit_b, friction = slip.limit, slip.limit_b, slip.friction
            rider = rider if rider > -limit_b else -limit_b
            gain = slip.first_gain
            excess = rider + gain - limit_b
            unclear = abs(lead) < constants.near or abs(excess) < constants.near
            unclear = unclear or limit - friction < constants.near
            kind = UNDECIDED if unclear else (FREED if excess > 0.0 else RETURNED)
            force_end = 2.0 * friction - limit
            value = difference(constants, carried.pair, first, rider + gain, force_end)
            d_force, d_rider = onset_changes(along, slip.first_slope, first, d)
            b[ONE_VALUE + k] = value if kind == RETURNED else math.nan
            b[ONE_SLOPE + k] = 1.0 if kind == RETURNED else math.nan
            b[ONE_KIND + k] = kind
            b[ONE_GAP + k] = 0.0
            b[ONE_FIRST + k] = 1.0 if first else 0.0
            b[ONE_FORCE + k] = limit
            b[ONE_RIDER + k] = rider
            b[ONE_SIGN + k] = 1.0
            b[ONE_TIME + k] = slip.first_time
            b[ONE_GUESS + k] = release_guess(slip, slip.first_time, gain, limit_b - rider)
            b[ONE_FORCE_END + k] = force_end
            b[ONE_RIDER_END + k] = rider + gain
            b[ONE_D_GAP + k] = 0.0
            b[ONE_D_FORCE + k] = d_force
            b[ONE_D_RIDER + k] = d_rider
        base += STEP


@kernel(fused=True)
def return_pass(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Carry slips of one block to its return, or find that its rider leaves before."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            gap = b[ONE_GAP + k]
            sign = b[ONE_SIGN + k]
            first = b[ONE_FIRST + k] > 0.5
            force = b[ONE_FORCE + k]
            rider = b[ONE_RIDER + k]
            slip = slip_of(constants, carried.pair, first)
            limit, limit_b, friction = slip.limit, slip.limit_b, slip.friction
            backward = sign > 0.0
            rate = sign * force - friction
            pull = drawn(slip, sign, gap)
            square = rate * rate + gap * pull
            end = math.sqrt(square if square > 0.0 else 0.0)
            y, x = half_angle(slip, gap, rate, pull, end)
            angle = 2.0 * upper_angle(y, x)
            t = angle * slip.unit + angle * slip.unit_low
            pull = friction - end
            force_end = sign * pull
            slid = -sign * (end + rate) - slip.loading * t
            slid = slid * slip.compliance + slid * slip.compliance_low
            steady = slip.loading_b * t
            gain = steady - slip.coupling * slid
            clear = NEAR * (rate * rate + gap * (2.0 * slip.loading + slip.stiffness * gap))
            room = limit_b - rider
            # Without a return the rider leaves after about the time of steady sliding.
            for_ever = backward and square < -clear
            longest = 2.0 * room / slip.ride_time if for_ever else t
            gained = 2.0 * room if for_ever else gain
            guess = release_guess(slip, longest, gained, room)
            frees = backward and gained > room + constants.near
            # Loaded forward, the rider's force may turn: often two straight lines bound it.
            lowest = gain - steady
            inside = steady < room - constants.near and rider + lowest > constants.near - limit_b
            rides = gain < room - constants.near if backward else inside
            # Without kinetic friction a slip from rest ends at the lower limit, moving inward; else
            # a force equal to the limit is one that rounding may have put there.
            tie = backward and friction == 0.0 and gap == 0.0 and pull == -limit
            sticks = pull > constants.near - limit or tie
            sticks = sticks and pull < limit - constants.near
            crosses = pull < -limit - constants.near
            kind = RETURNED if sticks else (CROSSED if crosses else UNDECIDED)
            kind = FREED if frees else (kind if rides or not backward else UNDECIDED)
            kind = kind if square > clear or (for_ever and frees) else UNDECIDED
            turns = not backward and not inside and kind != UNDECIDED
            value = difference(constants, carried.pair, first, rider + gain, force_end)
            b[ONE_KIND + k] = kind
            b[ONE_TURNS + k] = 1.0 if turns else 0.0
            b[ONE_VALUE + k] = value if kind == RETURNED else math.nan
            b[ONE_TIME + k] = longest
            b[ONE_GUESS + k] = guess
            b[ONE_FORCE_END + k] = force_end
            b[ONE_RIDER_END + k] = rider + gain
        base += STEP


@kernel(fused=True)
def turning_pass(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Find which riders whose force turns, ONE_TURNS, reach their lower limit meanwhile."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            first = b[ONE_FIRST + k] > 0.5
            rider = b[ONE_RIDER + k]
            slip = slip_of(constants, carried.pair, first)
            limit_b = slip.limit_b
            rate = -b[ONE_FORCE + k] - slip.friction
            end = b[ONE_FORCE_END + k] + slip.friction
            t = b[ONE_TIME + k]
            gain = b[ONE_RIDER_END + k] - rider
            rise, high, turn, low = dip(slip, b[ONE_GAP + k], rate, end, t, gain)
            room = limit_b - rider - constants.near
            rides = high < room and gain < room and rider + low > constants.near - limit_b
            drops = high < room and rider + low < -limit_b - constants.near
            share = (rider + high + limit_b) / (high - low)
            guess = rise + (turn - rise) * smooth_share(share)
            turns = b[ONE_TURNS + k] > 0.5
            kind = b[ONE_KIND + k]
            kind = (FREED if drops else (kind if rides else UNDECIDED)) if turns else kind
            b[ONE_KIND + k] = kind
            drops = drops and turns
            b[ONE_TIME + k] = turn if drops else t
            b[ONE_GUESS + k] = guess if drops else b[ONE_GUESS + k]
        base += STEP


@kernel(fused=True)
def return_slopes(carried: Carried, along: Change | None, b: Floats, n: np.uint64) -> None:
    """Carry derivatives through slips that return (saltation at the landing)."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            gap = b[ONE_GAP + k]
            sign = b[ONE_SIGN + k]
            first = b[ONE_FIRST + k] > 0.5
            slip = slip_of(constants, carried.pair, first)
            rate = sign * b[ONE_FORCE + k] - slip.friction
            end = slip.friction - sign * b[ONE_FORCE_END + k]
            y, x = half_angle(slip, gap, rate, drawn(slip, sign, gap), end)
            share = 1.0 / (x * x + y * y)
            c = (x * x - y * y) * share
            s = 2.0 * x * y * share
            slow = 1.0 / end
            d_gap = b[ONE_D_GAP + k]
            d_force = b[ONE_D_FORCE + k]
            d_rate = sign * d_force + friction_change(along, first, -1.0)
            t, gained = b[ONE_TIME + k], b[ONE_FORCE_END + k] - b[ONE_FORCE + k]
            bend, _ = slip_bend(slip, along, sign, gap, rate, t, s * slip.unit, c)
            d_time = (d_gap * c + d_rate * s * slip.unit + bend) * slow
            bend = return_bend(along, sign, gap)
            d_end = rate * d_rate + (slip.stiffness * gap - sign * slip.loading) * d_gap
            d_friction = friction_change(along, first, 1.0)
            d_force_end = sign * (d_friction - (d_end + bend) * slow)
            d_gain = slip.ride_time * d_time - slip.ride_force * (d_force_end - d_force)
            d_gain = d_gain + rider_change(slip, along, t, gained)
            d_rider_end = b[ONE_D_RIDER + k] + d_gain
            slope = difference(constants, carried.pair, first, d_rider_end, d_force_end)
            slope = slope + value_change(constants, along, b[ONE_VALUE + k])
            b[ONE_D_FORCE_END + k] = d_force_end
            b[ONE_D_RIDER_END + k] = d_rider_end
            b[ONE_SLOPE + k] = slope if b[ONE_KIND + k] == RETURNED else math.nan
        base += STEP


@kernel(fused=True)
def release_pass(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Slips up to FREED_TIME, at which the rider reaches a limit: the upper one if backward."""
    # Its force changes one way between the ends of the search: Halley's method from a good guess.
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            sign = b[FREED_SIGN + k]
            first = b[FREED_FIRST + k] > 0.5
            slip = slip_of(constants, carried.pair, first)
            target = sign * slip.limit_b
            rate = sign * b[FREED_FORCE + k] - slip.friction
            gap = b[FREED_GAP + k]
            pull = sign * slip.loading - gap - slip.alpha * gap
            room = target - b[FREED_RIDER + k]
            longest = b[FREED_TIME + k]
            t = b[FREED_GUESS + k]
            turning = sign * slip.coupling
            step = gap_now = rate_now = speed = 0.0
            for _ in range(RELEASE_STEPS):
                t = t - step
                t = t if t > 0.0 else 0.0
                t = t if t < longest else longest
                v, s = slip_turned(slip, t)
                gained = pull * s - rate * (v + slip.alpha * v)
                rate_now = rate + gained
                gap_now = gap + (rate * s + pull * v)
                excess = overload(slip, carried.pair, t, sign * gained, room) * slip.compliance
                speed = slip.loading_b + turning * gap_now
                step = excess * speed / (speed * speed - 0.5 * excess * turning * rate_now)
            pull = sign * slip.loading - slip.stiffness * gap_now
            gap_end = gap_now - step * (rate_now - 0.5 * step * pull)
            rate_end = rate_now - step * (pull + 0.5 * step * slip.stiffness * rate_now)
            force_end = sign * (slip.friction + rate_end)
            found = abs(step) < POLISHED and sign * speed > 0.0
            b[FREED_TIME + k] = t - step
            b[START_W + k] = -sign * gap_end if found else math.nan
            b[START_E1 + k] = force_end if first else target
            b[START_E2 + k] = target if first else force_end
            b[TWO_MODE_1 + k] = -sign
            b[TWO_MODE_2 + k] = -sign
            b[TWO_FRESH + k] = 1.0 if first else -1.0
        base += STEP


@kernel(fused=True)
def release_slopes(carried: Carried, along: Change | None, b: Floats, n: np.uint64) -> None:
    """Carry derivatives through slips whose rider was freed."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            sign = b[FREED_SIGN + k]
            first = b[FREED_FIRST + k] > 0.5
            slip = slip_of(constants, carried.pair, first)
            gap = -sign * b[START_W + k]
            force, t = b[START_E1 + k] if first else b[START_E2 + k], b[FREED_TIME + k]
            rate = sign * force - slip.friction
            s, c = turned(slip.frequency * t)
            d_swing = slip.frequency * b[FREED_D_GAP + k]
            d_rate = sign * b[FREED_D_FORCE + k] + friction_change(along, first, -1.0)
            started = sign * b[FREED_FORCE + k] - slip.friction
            bend, rate_bend = slip_bend(
                slip, along, sign, b[FREED_GAP + k], started, t, s * slip.unit, c
            )
            d_swing_now = d_swing * c + d_rate * s
            d_rate_now = d_rate * c - d_swing * s + rate_bend
            d_rider = b[FREED_D_RIDER + k] - sign * slip.ride_force * (d_rate_now - d_rate)
            d_rider = d_rider + rider_change(slip, along, t, force - b[FREED_FORCE + k])
            d_limit = limit_change(along, not first, sign)
            shift = (d_limit - d_rider) / (slip.loading_b + sign * slip.coupling * gap)
            pull = sign * slip.loading - slip.stiffness * gap
            d_force = sign * (d_rate_now + friction_change(along, first, 1.0) + pull * shift)
            b[TWO_D_W + k] = -sign * (d_swing_now * slip.unit + bend + rate * shift)
            b[TWO_D_E1 + k] = d_force if first else d_limit
            b[TWO_D_E2 + k] = d_limit if first else d_force
        base += STEP


@kernel(fused=True)
def start_pass(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Begin of slips of both blocks, TWO_FRESH of which (-1 or 1) from rest, and a first step."""
    # Divided by time the distance of the latter is at least ``f' - m t / 2``: no root until 2 f' /
    # m.
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            fresh = b[TWO_FRESH + k]
            w = b[START_W + k]
            m_1 = b[TWO_MODE_1 + k]
            m_2 = b[TWO_MODE_2 + k]
            pull_1 = -m_1 * constants.friction_1 - b[START_E1 + k]
            pull_2 = -m_2 * constants.friction_2 - b[START_E2 + k]
            of_sum, of_gap = shares(carried.pair, -fresh)
            belt_sum, belt_gap = belt_modes(constants, carried.pair)
            sum_w, gap_w = of_sum * w + belt_sum, of_gap * w + belt_gap
            sum_pull, gap_pull = modes_of(carried.pair, pull_1, pull_2)
            swing_1 = math.sqrt(sum_w * sum_w + sum_pull * sum_pull)
            swing_2 = math.sqrt(gap_w * gap_w + gap_pull * gap_pull * constants.narrow)
            half = 0.5 * largest_share(carried.pair)
            bound_2 = half * (swing_1 + constants.spread * swing_2)
            bound_4 = half * (swing_1 + constants.spread * constants.spread * swing_2)
            own, other = (m_2, m_1) if fresh > 0.0 else (m_1, m_2)
            _, f_1, f_2, f_3, _ = clearance(
                constants, carried.pair, own, fresh, sum_w, sum_pull, gap_w, gap_pull
            )
            h = 1.25 * f_1 / fall(constants, f_2, f_3, bound_2, bound_4)
            leaves = f_1 > 1e-6
            f, f_1, f_2, f_3, _ = clearance(
                constants, carried.pair, other, -fresh, sum_w, sum_pull, gap_w, gap_pull
            )
            reach = safe_reach(constants, f, f_1, fall(constants, f_2, f_3, bound_2, bound_4))
            h = h if h < reach else reach
            h = h if leaves else math.nan
            sum_w, sum_pull, gap_w, gap_pull = modes_turned(
                constants, h, sum_w, sum_pull, gap_w, gap_pull
            )
            b[TWO_SUM_W + k] = sum_w
            b[TWO_SUM_PULL + k] = sum_pull
            b[TWO_GAP_W + k] = gap_w
            b[TWO_GAP_PULL + k] = gap_pull
            b[TWO_BOUND_2 + k] = bound_2
            b[TWO_BOUND_4 + k] = bound_4
            b[TWO_TIME + k] = h
        base += STEP


@kernel(fused=True)
def step_pass(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Carry slips of both blocks as far as bounds prove that neither touches the belt."""
    # TWO_LANDS: the block (-1, 1) proved to land next, 0 none, `UNDECIDED` next to a touch; it
    # stays.
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            sum_w = b[TWO_SUM_W + k]
            sum_pull = b[TWO_SUM_PULL + k]
            gap_w = b[TWO_GAP_W + k]
            gap_pull = b[TWO_GAP_PULL + k]
            bound_2 = b[TWO_BOUND_2 + k]
            bound_4 = b[TWO_BOUND_4 + k]
            f, f_1, f_2, f_3, _ = clearance(
                constants, carried.pair, b[TWO_MODE_1 + k], -1.0, sum_w, sum_pull, gap_w, gap_pull
            )
            g, g_1, g_2, g_3, _ = clearance(
                constants, carried.pair, b[TWO_MODE_2 + k], 1.0, sum_w, sum_pull, gap_w, gap_pull
            )
            reach_f = safe_reach(constants, f, f_1, fall(constants, f_2, f_3, bound_2, bound_4))
            reach_g = safe_reach(constants, g, g_1, fall(constants, g_2, g_3, bound_2, bound_4))
            falls_f = falls_to_zero(f, f_1, bound_2)
            falls_g = falls_to_zero(g, g_1, bound_2)
            near = NEAR * bound_2
            touches = (not falls_f and not f > near) or (not falls_g and not g > near)
            # The root of a signal that falls to zero is at most 1.2 f / |f'| away.
            lands = 1.0 if falls_g and -g_1 * reach_f > 1.25 * g else 0.0
            lands = -1.0 if falls_f and -f_1 * reach_g > 1.25 * f else lands
            lands = UNDECIDED if touches else lands
            h = reach_f if reach_f < reach_g else reach_g
            h = h if lands == 0.0 else 0.0
            sum_w, sum_pull, gap_w, gap_pull = modes_turned(
                constants, h, sum_w, sum_pull, gap_w, gap_pull
            )
            b[TWO_SUM_W + k] = sum_w
            b[TWO_SUM_PULL + k] = sum_pull
            b[TWO_GAP_W + k] = gap_w
            b[TWO_GAP_PULL + k] = gap_pull
            b[TWO_TIME + k] = b[TWO_TIME + k] + h
            b[TWO_LANDS + k] = lands
        base += STEP


@kernel(fused=True)
def landing_pass(carried: Carried, b: Floats, n: np.uint64) -> None:
    """Carry slips of both blocks to the landing of END_LANDS at END_TIME; NEXT_MODE is its mode."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            sum_w = b[END_SUM_W + k]
            sum_pull = b[END_SUM_PULL + k]
            gap_w = b[END_GAP_W + k]
            gap_pull = b[END_GAP_PULL + k]
            m_1 = b[END_MODE_1 + k]
            m_2 = b[END_MODE_2 + k]
            side = b[END_LANDS + k]
            second = side > 0.0
            own, other = (m_2, m_1) if second else (m_1, m_2)
            f, f_1, f_2, f_3, f_4 = clearance(
                constants, carried.pair, own, side, sum_w, sum_pull, gap_w, gap_pull
            )
            t = contact_ahead(f, f_1, f_2, f_3, f_4)
            sum_w, sum_pull, gap_w, gap_pull = modes_turned(
                constants, t, sum_w, sum_pull, gap_w, gap_pull
            )
            f, f_1, f_2, f_3, f_4 = clearance(
                constants, carried.pair, own, side, sum_w, sum_pull, gap_w, gap_pull
            )
            rest = contact_ahead(f, f_1, f_2, f_3, f_4)
            sum_w, sum_pull, gap_w, gap_pull = modes_polished(
                constants, rest, sum_w, sum_pull, gap_w, gap_pull
            )
            pull_1, pull_2 = blocks_of(carried.pair, sum_pull, gap_pull)
            e_1 = -m_1 * constants.friction_1 - pull_1
            e_2 = -m_2 * constants.friction_2 - pull_2
            of_sum, of_gap = shares(carried.pair, -side)
            w = 0.5 * (of_sum * sum_w + of_gap * gap_w) - belt_of(constants, carried.pair, -side)
            limit = constants.limit_2 if second else constants.limit_1
            force = e_2 if second else e_1
            sticks = abs(force) < limit - constants.near
            crosses = abs(force) > limit + constants.near
            clear = abs(side) == 1.0 and abs(rest) < POLISHED_LANDING
            clear = clear and other * w > NEAR * b[END_BOUND_2 + k] and (sticks or crosses)
            b[NEXT_KIND + k] = (STUCK if sticks else CROSSED) if clear else UNDECIDED
            b[NEXT_W + k] = w
            b[NEXT_E1 + k] = e_1
            b[NEXT_E2 + k] = e_2
            b[NEXT_MODE + k] = -1.0 if force > 0.0 else 1.0
            b[END_SUM_PULL + k] = sum_pull
            b[END_GAP_PULL + k] = gap_pull
            b[END_TIME + k] = b[END_TIME + k] + t + rest
        base += STEP


@kernel(fused=True)
def landing_slopes(carried: Carried, along: Change | None, b: Floats, n: np.uint64) -> None:
    """Carry derivatives through slips of both blocks to a landing, in END_D (saltation)."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            constants = constants_of(carried.common, carried.rows, b, k)
            side = b[END_LANDS + k]
            fresh = b[END_FRESH + k]
            w = b[NEXT_W + k]
            sum_pull = b[END_SUM_PULL + k]
            gap_pull = b[END_GAP_PULL + k]
            d_w = b[END_D_W + k]
            m_1 = b[END_MODE_1 + k]
            m_2 = b[END_MODE_2 + k]
            d_e1 = b[END_D_E1 + k] + friction_change(along, True, m_1)
            d_e2 = b[END_D_E2 + k] + friction_change(along, False, m_2)
            t = b[END_TIME + k]
            s, c = turned(t)
            d_sum, d_gap = modes_of(carried.pair, d_e1, d_e2)
            of_sum, of_gap = shares(carried.pair, -fresh)
            w_sum, w_gap = of_sum * d_w + belt_change(along, 2.0), of_gap * d_w
            d_sum_w, d_sum_e = w_sum * c - d_sum * s, d_sum * c + w_sum * s
            s, c = turned(constants.beat * t)
            s = s * constants.beat
            of_sum, of_gap = shares(carried.pair, -side)
            bend, rate_bend = gap_bend(
                constants, along, of_gap * w, gap_pull, t, s * constants.narrow, c
            )
            d_gap_w = w_gap * c - d_gap * (s * constants.narrow) + bend
            d_gap_e = d_gap * c + w_gap * s - rate_bend
            of_sum, of_gap = shares(carried.pair, side)
            rate = of_sum * sum_pull + of_gap * gap_pull
            shift = (belt_change(along, 2.0) - (of_sum * d_sum_w + of_gap * d_gap_w)) / rate
            one = slip_of(constants, carried.pair, True)
            two = slip_of(constants, carried.pair, False)
            rate_1 = one.loading + (-one.coupling if side < 0.0 else one.stiffness) * w
            rate_2 = two.loading + (two.stiffness if side < 0.0 else -two.coupling) * w
            of_sum, of_gap = shares(carried.pair, -side)
            d_w = 0.5 * (of_sum * d_sum_w + of_gap * d_gap_w) + belt_change(along, -1.0)
            b[END_D_W + k] = d_w + 0.5 * (of_sum * sum_pull + of_gap * gap_pull) * shift
            d_e1, d_e2 = blocks_of(carried.pair, d_sum_e, d_gap_e)
            b[END_D_E1 + k] = d_e1 + friction_change(along, True, -m_1) + rate_1 * shift
            b[END_D_E2 + k] = d_e2 + friction_change(along, False, -m_2) + rate_2 * shift
        base += STEP
