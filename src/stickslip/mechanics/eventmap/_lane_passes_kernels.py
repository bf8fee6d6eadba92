"""Phases of many motions at once: each pass is one loop over a list of motions.

Lists lie in one buffer as streams, one for each quantity. A pass takes full groups of `LANES`
items, the last one padded with what happens to lie there, so that every motion goes through
the same machine code whatever is beside it: equal bits for any number of motions. One buffer
with constant offsets lets the compiler see that streams do not overlap.

The names of streams: ``ONE`` one block slips, ``FREED`` its rider reaches its limit, ``TWO`` both
slip, ``END`` they have stopped, ``NEXT`` what follows. ``D`` is a derivative in the starting d.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow._lane_kernels import (
    NEAR,
    Plant,
    clearance,
    contact_ahead,
    dip,
    drawn,
    fall,
    falls_to_zero,
    half_angle,
    modes_polished,
    modes_turned,
    safe_reach,
    slip_turned,
    smooth_share,
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

N_STREAMS = 65
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
    ELAPSED,
) = _STREAMS
# fmt: on
# Where motions have plants of their own: those of the items of the present pass.
PLANT = tuple(np.uint64((N_STREAMS + i) * STRIDE) for i in range(len(Plant._fields)))
# How many of their first numbers a pass needs: steps, starts, landings, slips of one block, all.
OF_STEPS, OF_STARTS, OF_LANDINGS, OF_SLIPS, OF_ONSETS = 4, 7, 13, 23, len(PLANT)
# Streams that move with an item from list to list; the later ones with derivatives only.
FREED_VALUES, FREED_ALL = 7, 10
TWO_VALUES, TWO_ALL = 8, 13

# Halvings of the error of a release time: see `release_pass`.
RELEASE_STEPS = 3
# A last correction beyond these has not converged: of Halley's method with a state carried on by
# its Taylor series of the second order, and of two series of the fifth order.
POLISHED = 4e-6
POLISHED_LANDING = 3e-4


@kernel(inline=True, fused=True)
def plant_of(common: Plant, rows: Floats, b: Floats, k: np.uint64) -> Plant:
    """Give the plant of an item: the common one, or its own if `rows` has a column for each."""
    if rows.ndim == 1:
        return common
    # fmt: off
    return Plant(
        b[PLANT[0] + k], b[PLANT[1] + k], b[PLANT[2] + k], b[PLANT[3] + k],
        b[PLANT[4] + k], b[PLANT[5] + k], b[PLANT[6] + k], b[PLANT[7] + k],
        b[PLANT[8] + k], b[PLANT[9] + k], b[PLANT[10] + k], b[PLANT[11] + k],
        b[PLANT[12] + k], b[PLANT[13] + k], b[PLANT[14] + k], b[PLANT[15] + k],
        b[PLANT[16] + k], b[PLANT[17] + k], b[PLANT[18] + k], b[PLANT[19] + k],
        b[PLANT[20] + k], b[PLANT[21] + k], b[PLANT[22] + k], b[PLANT[23] + k],
        b[PLANT[24] + k], b[PLANT[25] + k], b[PLANT[26] + k], b[PLANT[27] + k],
    )
    # fmt: on


@kernel(fused=True)
def load_plants(
    rows: Floats,
    index: NDArray[np.uint64],
    who: np.uint64,
    n: np.uint64,
    start: np.uint64,
    fields: int,
    b: Floats,
) -> None:
    """Lay out the first fields of plants for the items of a list, if motions have their own."""
    if rows.ndim == 2:
        for field in range(fields):
            at = PLANT[field]
            for i in range(n):
                k = np.uint64(i)
                b[at + k] = rows[field, start + index[who + k]]


@kernel(inline=True, fused=True)
def release_guess(plant: Plant, longest: float, gain: float, room: float) -> float:
    """About when a rider's force that gains `gain` in the time `longest` has gained `room`."""
    inverse = 1.0 / gain
    share = room * inverse
    smooth = smooth_share(share)
    steady = plant.V * longest * inverse
    steady = steady if steady < 1.0 else 1.0
    return longest * (smooth + steady * (share - smooth))


@kernel(fused=True)
def onset_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Begin the first slips of the starts in ONE_VALUE: many return at once, with a value."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            d = b[ONE_VALUE + k]
            d = d if d > -plant.end else -plant.end
            d = d if d < plant.end else plant.end
            spread = plant.spread * d
            lead = plant.limit_1 + spread - plant.limit_2
            first = lead < 0.0
            rider = plant.limit_1 + spread if first else plant.limit_2 - spread
            limit = plant.limit_1 if first else plant.limit_2
            limit_b = plant.limit_2 if first else plant.limit_1
            rider = rider if rider > -limit_b else -limit_b
            friction = plant.friction_1 if first else plant.friction_2
            gain = plant.first_gain_1 if first else plant.first_gain_2
            excess = rider + gain - limit_b
            unclear = abs(lead) < plant.near or abs(excess) < plant.near
            unclear = unclear or limit - friction < plant.near
            kind = UNDECIDED if unclear else (FREED if excess > 0.0 else RETURNED)
            value = (rider + gain - (2.0 * friction - limit)) * plant.narrow
            value = value if first else -value
            b[ONE_VALUE + k] = value if kind == RETURNED else math.nan
            b[ONE_SLOPE + k] = 1.0 if kind == RETURNED else math.nan
            b[ONE_KIND + k] = kind
            b[ONE_GAP + k] = 0.0
            b[ONE_FIRST + k] = 1.0 if first else 0.0
            b[ONE_FORCE + k] = limit
            b[ONE_RIDER + k] = rider
            t = plant.first_time_1 if first else plant.first_time_2
            b[ONE_SIGN + k] = 1.0
            b[ONE_TIME + k] = t
            b[ONE_GUESS + k] = release_guess(plant, t, gain, limit_b - rider)
            b[ONE_D_GAP + k] = 0.0
            b[ONE_D_FORCE + k] = 0.0
            b[ONE_D_RIDER + k] = plant.spread if first else -plant.spread
        base += STEP


@kernel(fused=True)
def return_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Carry slips of one block to its return, or find that its rider leaves before."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            gap = b[ONE_GAP + k]
            sign = b[ONE_SIGN + k]
            first = b[ONE_FIRST + k] > 0.5
            force = b[ONE_FORCE + k]
            rider = b[ONE_RIDER + k]
            friction = plant.friction_1 if first else plant.friction_2
            limit = plant.limit_1 if first else plant.limit_2
            limit_b = plant.limit_2 if first else plant.limit_1
            backward = sign > 0.0
            rate = sign * force - friction
            pull = drawn(plant, sign, gap)
            square = rate * rate + gap * pull
            end = math.sqrt(square if square > 0.0 else 0.0)
            y, x = half_angle(plant, gap, rate, pull, end)
            angle = 2.0 * upper_angle(y, x)
            t = angle * plant.unit + angle * plant.unit_low
            pull = friction - end
            force_end = sign * pull
            steady = plant.V * t
            slid = -sign * (end + rate) - steady
            slid = slid * plant.compliance + slid * plant.compliance_low
            gain = steady - plant.alpha * slid
            clear = NEAR * (rate * rate + gap * (2.0 * plant.V + plant.stiffness * gap))
            room = limit_b - rider
            # Without a return the rider leaves after about the time of steady sliding.
            for_ever = backward and square < -clear
            longest = 2.0 * room / plant.ride_time if for_ever else t
            gained = 2.0 * room if for_ever else gain
            guess = release_guess(plant, longest, gained, room)
            frees = backward and gained > room + plant.near
            # Loaded forward, the rider's force may turn: often two straight lines bound it.
            lowest = gain - steady
            inside = steady < room - plant.near and rider + lowest > plant.near - limit_b
            rides = gain < room - plant.near if backward else inside
            # Without kinetic friction a slip from rest ends at the lower limit, moving inward; else
            # a force equal to the limit is one that rounding may have put there.
            tie = backward and friction == 0.0 and gap == 0.0 and pull == -limit
            sticks = pull > plant.near - limit or tie
            sticks = sticks and pull < limit - plant.near
            crosses = pull < -limit - plant.near
            kind = RETURNED if sticks else (CROSSED if crosses else UNDECIDED)
            kind = FREED if frees else (kind if rides or not backward else UNDECIDED)
            kind = kind if square > clear or (for_ever and frees) else UNDECIDED
            turns = not backward and not inside and kind != UNDECIDED
            value = (rider + gain - force_end) * plant.narrow
            value = value if first else -value
            b[ONE_KIND + k] = kind
            b[ONE_TURNS + k] = 1.0 if turns else 0.0
            b[ONE_VALUE + k] = value if kind == RETURNED else math.nan
            b[ONE_TIME + k] = longest
            b[ONE_GUESS + k] = guess
            b[ONE_FORCE_END + k] = force_end
            b[ONE_RIDER_END + k] = rider + gain
        base += STEP


@kernel(fused=True)
def turning_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Find which riders whose force turns, ONE_TURNS, reach their lower limit meanwhile."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            first = b[ONE_FIRST + k] > 0.5
            rider = b[ONE_RIDER + k]
            friction = plant.friction_1 if first else plant.friction_2
            limit_b = plant.limit_2 if first else plant.limit_1
            rate = -b[ONE_FORCE + k] - friction
            end = b[ONE_FORCE_END + k] + friction
            t = b[ONE_TIME + k]
            gain = b[ONE_RIDER_END + k] - rider
            rise, high, turn, low = dip(plant, b[ONE_GAP + k], rate, end, t, gain)
            room = limit_b - rider - plant.near
            rides = high < room and gain < room and rider + low > plant.near - limit_b
            drops = high < room and rider + low < -limit_b - plant.near
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
def return_slopes(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Carry derivatives through slips that return (saltation at the landing)."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            gap = b[ONE_GAP + k]
            sign = b[ONE_SIGN + k]
            first = b[ONE_FIRST + k] > 0.5
            friction = plant.friction_1 if first else plant.friction_2
            rate = sign * b[ONE_FORCE + k] - friction
            end = friction - sign * b[ONE_FORCE_END + k]
            y, x = half_angle(plant, gap, rate, drawn(plant, sign, gap), end)
            share = 1.0 / (x * x + y * y)
            c = (x * x - y * y) * share
            s = 2.0 * x * y * share
            slow = 1.0 / end
            d_gap = b[ONE_D_GAP + k]
            d_force = b[ONE_D_FORCE + k]
            d_rate = sign * d_force
            d_time = (d_gap * c + d_rate * s * plant.unit) * slow
            d_end = (rate * d_rate + (plant.stiffness * gap - sign * plant.V) * d_gap) * slow
            d_force_end = -sign * d_end
            d_gain = plant.ride_time * d_time - plant.ride_force * (d_force_end - d_force)
            d_rider_end = b[ONE_D_RIDER + k] + d_gain
            slope = (d_rider_end - d_force_end) * plant.narrow
            slope = slope if first else -slope
            b[ONE_D_FORCE_END + k] = d_force_end
            b[ONE_D_RIDER_END + k] = d_rider_end
            b[ONE_SLOPE + k] = slope if b[ONE_KIND + k] == RETURNED else math.nan
        base += STEP


@kernel(fused=True)
def release_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Slips up to FREED_TIME, at which the rider reaches a limit: the upper one if backward.

    Its force changes one way between the ends of the search: Halley's method from a good guess.
    """
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            sign = b[FREED_SIGN + k]
            first = b[FREED_FIRST + k] > 0.5
            friction = plant.friction_1 if first else plant.friction_2
            target = sign * (plant.limit_2 if first else plant.limit_1)
            rate = sign * b[FREED_FORCE + k] - friction
            gap = b[FREED_GAP + k]
            pull = sign * plant.V - gap - plant.alpha * gap
            room = target - b[FREED_RIDER + k]
            longest = b[FREED_TIME + k]
            t = b[FREED_GUESS + k]
            turning = sign * plant.alpha
            step = gap_now = rate_now = speed = 0.0
            for _ in range(RELEASE_STEPS):
                t = t - step
                t = t if t > 0.0 else 0.0
                t = t if t < longest else longest
                s, v = slip_turned(plant, t)
                gained = pull * s - rate * (v + plant.alpha * v)
                rate_now = rate + gained
                gap_now = gap + (rate * s + pull * v)
                short = plant.V * t - room
                slid = (short + plant.V * t) - sign * gained
                excess = (short + plant.alpha * slid) * plant.compliance
                speed = plant.V + turning * gap_now
                step = excess * speed / (speed * speed - 0.5 * excess * turning * rate_now)
            pull = sign * plant.V - plant.stiffness * gap_now
            gap_end = gap_now - step * (rate_now - 0.5 * step * pull)
            rate_end = rate_now - step * (pull + 0.5 * step * plant.stiffness * rate_now)
            force_end = sign * (friction + rate_end)
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
def release_slopes(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Carry derivatives through slips whose rider was freed."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            sign = b[FREED_SIGN + k]
            first = b[FREED_FIRST + k] > 0.5
            friction = plant.friction_1 if first else plant.friction_2
            gap = -sign * b[START_W + k]
            rate = sign * (b[START_E1 + k] if first else b[START_E2 + k]) - friction
            s, c = turned(plant.frequency * b[FREED_TIME + k])
            d_swing = plant.frequency * b[FREED_D_GAP + k]
            d_rate = sign * b[FREED_D_FORCE + k]
            d_swing_now = d_swing * c + d_rate * s
            d_rate_now = d_rate * c - d_swing * s
            d_rider = b[FREED_D_RIDER + k] - sign * plant.ride_force * (d_rate_now - d_rate)
            shift = -d_rider / (plant.V + sign * plant.alpha * gap)
            pull = sign * plant.V - plant.stiffness * gap
            d_force = sign * (d_rate_now + pull * shift)
            b[TWO_D_W + k] = -sign * (d_swing_now * plant.unit + rate * shift)
            b[TWO_D_E1 + k] = d_force if first else 0.0
            b[TWO_D_E2 + k] = 0.0 if first else d_force
        base += STEP


@kernel(fused=True)
def start_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Begin of slips of both blocks, TWO_FRESH of which (-1 or 1) from rest, and a first step.

    Divided by time the distance of the latter is at least ``f' - m t / 2``: no root until 2 f' / m.
    """
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            fresh = b[TWO_FRESH + k]
            w = b[START_W + k]
            m_1 = b[TWO_MODE_1 + k]
            m_2 = b[TWO_MODE_2 + k]
            pull_1 = -m_1 * plant.friction_1 - b[START_E1 + k]
            pull_2 = -m_2 * plant.friction_2 - b[START_E2 + k]
            sum_w = w + 2.0 * plant.V
            sum_pull = pull_1 + pull_2
            gap_w = -fresh * w
            gap_pull = pull_2 - pull_1
            swing_1 = math.sqrt(sum_w * sum_w + sum_pull * sum_pull)
            swing_2 = math.sqrt(gap_w * gap_w + gap_pull * gap_pull * plant.narrow)
            bound_2 = 0.5 * (swing_1 + plant.spread * swing_2)
            bound_4 = 0.5 * (swing_1 + plant.spread * plant.spread * swing_2)
            own, other = (m_2, m_1) if fresh > 0.0 else (m_1, m_2)
            _, f_1, f_2, f_3 = clearance(plant, own, fresh, sum_w, sum_pull, gap_w, gap_pull)
            h = 1.25 * f_1 / fall(plant, f_2, f_3, bound_2, bound_4)
            leaves = f_1 > 1e-6
            f, f_1, f_2, f_3 = clearance(plant, other, -fresh, sum_w, sum_pull, gap_w, gap_pull)
            reach = safe_reach(plant, f, f_1, fall(plant, f_2, f_3, bound_2, bound_4))
            h = h if h < reach else reach
            h = h if leaves else math.nan
            sum_w, sum_pull, gap_w, gap_pull = modes_turned(
                plant, h, sum_w, sum_pull, gap_w, gap_pull
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
def step_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Carry slips of both blocks as far as bounds prove that neither touches the belt.

    TWO_LANDS: the block (-1, 1) proved to land next, 0 none, `UNDECIDED` next to a touch; it stays.
    """
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            sum_w = b[TWO_SUM_W + k]
            sum_pull = b[TWO_SUM_PULL + k]
            gap_w = b[TWO_GAP_W + k]
            gap_pull = b[TWO_GAP_PULL + k]
            bound_2 = b[TWO_BOUND_2 + k]
            bound_4 = b[TWO_BOUND_4 + k]
            f, f_1, f_2, f_3 = clearance(
                plant, b[TWO_MODE_1 + k], -1.0, sum_w, sum_pull, gap_w, gap_pull
            )
            g, g_1, g_2, g_3 = clearance(
                plant, b[TWO_MODE_2 + k], 1.0, sum_w, sum_pull, gap_w, gap_pull
            )
            reach_f = safe_reach(plant, f, f_1, fall(plant, f_2, f_3, bound_2, bound_4))
            reach_g = safe_reach(plant, g, g_1, fall(plant, g_2, g_3, bound_2, bound_4))
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
                plant, h, sum_w, sum_pull, gap_w, gap_pull
            )
            b[TWO_SUM_W + k] = sum_w
            b[TWO_SUM_PULL + k] = sum_pull
            b[TWO_GAP_W + k] = gap_w
            b[TWO_GAP_PULL + k] = gap_pull
            b[TWO_TIME + k] = b[TWO_TIME + k] + h
            b[TWO_LANDS + k] = lands
        base += STEP


@kernel(fused=True)
def landing_pass(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Carry slips of both blocks to the landing of END_LANDS at END_TIME; NEXT_MODE is its mode."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            sum_w = b[END_SUM_W + k]
            sum_pull = b[END_SUM_PULL + k]
            gap_w = b[END_GAP_W + k]
            gap_pull = b[END_GAP_PULL + k]
            m_1 = b[END_MODE_1 + k]
            m_2 = b[END_MODE_2 + k]
            side = b[END_LANDS + k]
            second = side > 0.0
            own, other = (m_2, m_1) if second else (m_1, m_2)
            f, f_1, f_2, f_3 = clearance(plant, own, side, sum_w, sum_pull, gap_w, gap_pull)
            f_4 = 0.5 * own * (sum_w + side * plant.spread * plant.spread * gap_w)
            t = contact_ahead(f, f_1, f_2, f_3, f_4)
            sum_w, sum_pull, gap_w, gap_pull = modes_turned(
                plant, t, sum_w, sum_pull, gap_w, gap_pull
            )
            f, f_1, f_2, f_3 = clearance(plant, own, side, sum_w, sum_pull, gap_w, gap_pull)
            f_4 = 0.5 * own * (sum_w + side * plant.spread * plant.spread * gap_w)
            rest = contact_ahead(f, f_1, f_2, f_3, f_4)
            sum_w, sum_pull, gap_w, gap_pull = modes_polished(
                plant, rest, sum_w, sum_pull, gap_w, gap_pull
            )
            e_1 = -m_1 * plant.friction_1 - 0.5 * (sum_pull - gap_pull)
            e_2 = -m_2 * plant.friction_2 - 0.5 * (sum_pull + gap_pull)
            w = 0.5 * (sum_w - side * gap_w) - plant.V
            limit = plant.limit_2 if second else plant.limit_1
            force = e_2 if second else e_1
            sticks = abs(force) < limit - plant.near
            crosses = abs(force) > limit + plant.near
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
def landing_slopes(common: Plant, rows: Floats, b: Floats, n: np.uint64) -> None:
    """Carry derivatives through slips of both blocks to a landing, in END_D (saltation)."""
    wide_vectors()
    base = ZERO
    while base < n:
        for lane in range(LANES):
            k = base + np.uint64(lane)
            plant = plant_of(common, rows, b, k)
            side = b[END_LANDS + k]
            fresh = b[END_FRESH + k]
            w = b[NEXT_W + k]
            sum_pull = b[END_SUM_PULL + k]
            gap_pull = b[END_GAP_PULL + k]
            d_w = b[END_D_W + k]
            d_e1 = b[END_D_E1 + k]
            d_e2 = b[END_D_E2 + k]
            t = b[END_TIME + k]
            s, c = turned(t)
            d_sum_w = d_w * c - (d_e1 + d_e2) * s
            d_sum_e = (d_e1 + d_e2) * c + d_w * s
            s, c = turned(plant.beat * t)
            s = s * plant.beat
            d_gap_w = -fresh * d_w * c - (d_e2 - d_e1) * (s * plant.narrow)
            d_gap_e = (d_e2 - d_e1) * c - fresh * d_w * s
            shift = -(d_sum_w + side * d_gap_w) / (sum_pull + side * gap_pull)
            rate_1 = plant.V + (-plant.alpha if side < 0.0 else plant.stiffness) * w
            rate_2 = plant.V + (plant.stiffness if side < 0.0 else -plant.alpha) * w
            d_w = 0.5 * (d_sum_w - side * d_gap_w) + 0.5 * (sum_pull - side * gap_pull) * shift
            b[END_D_W + k] = d_w
            b[END_D_E1 + k] = 0.5 * (d_sum_e - d_gap_e) + rate_1 * shift
            b[END_D_E2 + k] = 0.5 * (d_sum_e + d_gap_e) + rate_2 * shift
        base += STEP
