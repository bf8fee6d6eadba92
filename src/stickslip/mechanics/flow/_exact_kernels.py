"""Exact engine: constant kinetic friction, so that motion between events is closed form."""

# Derivation of every formula: docs/theory/flow.md.

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow._sliding_kernels import CLEARANCE
from stickslip.mechanics.flow.oscillator import oscillator, oscillator_sharp, oscillator_tangent
from stickslip.mechanics.flow.saltation import saltation
from stickslip.mechanics.flow.system import (
    ALPHA,
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BETA,
    LANDING,
    LAWS,
    VELOCITY,
    Floats,
    Motion,
    Phases,
    System,
    law_parameters,
    limit,
    loading_rate,
)
from stickslip.mechanics.flow.transitions import excess_force, round_landings, round_to_limit
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.numerics.roots import (
    EPSILON,
    all_but_touches,
    contact_time,
    grazing_time,
    hides_a_turn,
    leaving_step,
    safe_step,
)
from stickslip.numerics.rounding import product, quotient, sum_of_two, two_product, two_sum
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos
from stickslip.status import OK, STEP_FAILED

# Time after which a phase is restarted from where it is, so that phases of long motions do
# not lose digits of their angle.
LONGEST_STEP = 3.0
# Steps of a first-root search: some ten are usual, a graze takes a few dozen.
MAX_SEARCH = 100_000
# Rounding of the square of a landing's rate, relative to its terms. Nearer zero than NEAR_TOUCH it
# is taken from sums of two.
ROUNDING = 8.0 * EPSILON
NEAR_TOUCH = 2.0**-20
# What may be left of the time of an event that was located; more is next to a touch.
LARGEST_REST = 1e-9
# Rounding of a needed force where a block lands, in units of EPSILON x limit.
FORCE_ROUNDING = 0.125
# Part of the rounding of doubles within which sums of two call it a touch.
SHARPER = 0.0625
# The bound on the third derivative is used over at most this time (measured optimum).
CAP = 0.85


class Work(NamedTuple):
    """Scratch of the engine: the state at the start of a step, and what the step found."""

    start_w: Floats
    start_e: Floats
    start_w_low: Floats
    start_e_low: Floats
    margin: Floats  # smallest clearance so far, if watch[0] is not 0
    watch: Floats
    sliding: Floats  # time since both blocks began to slip


def new_work() -> Work:
    """Scratch arrays for one motion."""
    start = (np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2))
    return Work(*start, np.full(1, np.inf), np.zeros(1), np.zeros(1))


@kernel(inline=True)
def landing_rate(system: System, laws: Floats, motion: Motion, block: int) -> float:
    """Rate w' of a slipping block as it reaches the belt."""
    return friction(system, laws, motion, block) - motion.e[block]


@kernel(inline=True)
def friction(system: System, laws: Floats, motion: Motion, block: int) -> float:
    """Kinetic friction on a block (eq. 8): a constant, so that mu = F(0)."""
    return -motion.mode[block] * laws[block, STATIC_COLUMN] * limit(system, block)


@kernel
def friction_direction(
    system: System, laws: Floats, motion: Motion, block: int, column: int
) -> float:
    """Differentiate `friction` in the direction of a tangent column."""
    direction = motion.directions[column]
    d_mu = direction[LAWS + block * law_parameters(motion)]
    d_limit = direction[BETA] * block
    mu = laws[block, STATIC_COLUMN]
    return -motion.mode[block] * (d_mu * limit(system, block) + mu * d_limit)


@kernel(inline=True)
def friction_low(system: System, laws: Floats, motion: Motion, block: int) -> float:
    """Return what rounding leaves out of `friction`."""
    _, low = two_product(laws[block, STATIC_COLUMN], limit(system, block))
    return -motion.mode[block] * low


@kernel(inline=True)
def sharp_pull(
    system: System, laws: Floats, motion: Motion, work: Work, block: int
) -> tuple[float, float]:
    """Rate w' of a slipping block at the start of a step, as a sum of two."""
    pull, low = two_sum(friction(system, laws, motion, block), -work.start_e[block])
    return pull, low - work.start_e_low[block] + friction_low(system, laws, motion, block)


@kernel(inline=True, short_loops=True)
def advance(
    system: System, laws: Floats, motion: Motion, work: Work, rtol: float, cap: float
) -> tuple[float, int]:
    """Carry `motion` to its next event, or on by a bounded time; return that time and a status."""
    # ``motion.event`` says what happened to each block; modes are left for `settle`.
    for block in range(2):
        work.start_w[block] = motion.w[block]
        work.start_e[block] = motion.e[block]
        work.start_w_low[block] = motion.w_low[block]
        work.start_e_low[block] = motion.e_low[block]
        motion.event[block] = 0
    if motion.mode[0] != 0 and motion.mode[1] != 0:
        t, status = next_event_both(system, laws, motion, work, cap)
        eventless = motion.event[0] == 0 and motion.event[1] == 0
        work.sliding[0] = work.sliding[0] + t if eventless else 0.0
    else:
        work.sliding[0] = 0.0
        slipper = 0 if motion.mode[0] != 0 else 1
        t, status = next_event_one(system, laws, motion, work, slipper, cap)
    round_landings(system, motion, FORCE_ROUNDING)
    return t, status


# --- one block slips, the other rides ---------------------------------------------------------


@kernel(inline=True)
def ride(system: System, work: Work, slipper: int, e: float, t: float) -> float:
    """Needed force of the rider at time `t`, from that of the slipper, `e`: both by one spring."""
    stiffness = 1.0 + system.alpha
    gained = e - work.start_e[slipper]
    steady = system.V * (1.0 + 2.0 * system.alpha) * t
    return work.start_e[1 - slipper] + (steady - system.alpha * gained) / stiffness


@kernel(inline=True)
def move_one(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t: float
) -> None:
    """Put `motion` at time `t` of a phase in which one block slips."""
    force = friction(system, laws, motion, slipper)
    w, pull = oscillator(
        1.0 + system.alpha, system.V, work.start_w[slipper], force - work.start_e[slipper], t
    )
    motion.w[slipper] = w
    motion.e[slipper] = force - pull
    motion.e[1 - slipper] = ride(system, work, slipper, motion.e[slipper], t)


@kernel(inline=True)
def time_of_return(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int
) -> tuple[float, float]:
    """First time at which a slipping block is back while the other rides, and |w'| there."""
    # (inf, 0): no return. A quadratic in the tangent of half the angle, written so as not to
    # cancel.
    stiffness = 1.0 + system.alpha
    frequency = math.sqrt(stiffness)
    sign = -float(motion.mode[slipper])
    speed = abs(work.start_w[slipper])
    pull = sign * (friction(system, laws, motion, slipper) - work.start_e[slipper])
    level = 2.0 * sign * system.V
    fall = speed * (level - stiffness * speed)
    square = pull * pull - fall
    scale = pull * pull + speed * (abs(level) + stiffness * speed)
    if abs(square) <= NEAR_TOUCH * scale and speed > 0.0:
        square = sharp_square(system, laws, motion, work, slipper)
    rounding = SHARPER * ROUNDING * scale
    if square < -rounding:
        return math.inf, 0.0
    is_touch = square <= rounding and speed > 0.0
    slope = 0.0 if is_touch else math.sqrt(square)
    if pull < 0.0 or speed == 0.0:
        pull = min(pull, 0.0)
        half_angle = math.atan2(slope - pull, speed * frequency - level / frequency)
    else:
        half_angle = math.atan2(speed * frequency, slope + pull)
    return 2.0 * half_angle / frequency, slope


@kernel
def sharp_square(system: System, laws: Floats, motion: Motion, work: Work, slipper: int) -> float:
    """Square of the rate at a return, from sums of two: p^2 + w (2 V + (1 + alpha) w)."""
    pull, pull_low = sharp_pull(system, laws, motion, work, slipper)
    w, w_low = work.start_w[slipper], work.start_w_low[slipper]
    stiffness, stiffness_low = two_sum(1.0, system.alpha)
    level, level_low = product(stiffness, stiffness_low, w, w_low)
    level, level_low = sum_of_two(2.0 * system.V, level, level_low)
    fall, fall_low = product(w, w_low, level, level_low)
    square, square_low = product(pull, pull_low, pull, pull_low)
    square, square_low = sum_of_two(square, fall, square_low + fall_low)
    return square + square_low


@kernel(inline=True)
def put_slipper(
    system: System,
    laws: Floats,
    motion: Motion,
    block: int,
    w: float,
    w_low: float,
    pull: float,
    pull_low: float,
) -> None:
    """Give a slipping block its state, as sums of two."""
    motion.w[block], motion.w_low[block] = two_sum(w, w_low)
    low = friction_low(system, laws, motion, block) - pull_low
    motion.e[block], motion.e_low[block] = sum_of_two(
        friction(system, laws, motion, block), -pull, low
    )


@kernel(inline=True)
def located(rest: float) -> float:
    """Return what is left of the time of an event, or 0 next to a touch, where it says nothing."""
    return rest if abs(rest) < LARGEST_REST else 0.0


@kernel(inline=True)
def rest_of_landing(w: float, pull: float, rate: float) -> float:
    """Time from here to a landing, w' = `pull`, w'' = -`rate`; at a touch w' = 0 there."""
    if abs(pull) < LARGEST_REST * abs(rate):
        return pull / rate
    return located(-w / pull)


@kernel
def sharpen_one(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t: float
) -> float:
    """Put `motion` at its event about time `t`, with errors below a rounding; return the time."""
    rider = 1 - slipper
    first, first_low = sharp_pull(system, laws, motion, work, slipper)
    w, w_low = work.start_w[slipper], work.start_w_low[slipper]
    w, w_low, pull, pull_low = oscillator_sharp(
        system.alpha, system.V, w, w_low, first, first_low, t
    )
    # The rider's force gains (V t + alpha (2 V t + pull - first)) / (1 + alpha).
    lost, lost_low = two_sum(pull, -first)
    lost_low += pull_low - first_low
    steady, steady_low = two_product(system.V, t)
    bent, bent_low = two_sum(2.0 * steady, lost)
    bent, bent_low = product(system.alpha, 0.0, bent, bent_low + 2.0 * steady_low + lost_low)
    gain, gain_low = two_sum(steady, bent)
    stiffness, stiffness_low = two_sum(1.0, system.alpha)
    gain, gain_low = quotient(gain, gain_low + steady_low + bent_low, stiffness, stiffness_low)
    speed = system.V - system.alpha * w
    rate = (1.0 + system.alpha) * w + system.V
    rest = 0.0
    if motion.event[slipper] == LANDING:
        rest = rest_of_landing(w + w_low, pull + pull_low, rate)
    elif motion.event[rider] != 0:
        side = 1.0 if motion.event[rider] == AT_UPPER_LIMIT else -1.0
        room, low = two_sum(side * limit(system, rider), -work.start_e[rider])
        rest = located(((room - gain) + (low - work.start_e_low[rider] - gain_low)) / speed)
    put_slipper(system, laws, motion, slipper, w, w_low + pull * rest, pull, pull_low - rate * rest)
    low = work.start_e_low[rider] + (gain_low + speed * rest)
    motion.e[rider], motion.e_low[rider] = sum_of_two(work.start_e[rider], gain, low)
    return t + rest


@kernel(inline=True)
def next_event_one(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, cap: float
) -> tuple[float, int]:
    """Next event while one block slips: it returns, or the rider reaches a static limit."""
    rider = 1 - slipper
    t, slope = time_of_return(system, laws, motion, work, slipper)
    lands = t <= cap and t < math.inf
    backward = motion.mode[slipper] < 0
    if lands:
        # The energy of the oscillator gives the force at the return without its angle.
        motion.w[slipper] = 0.0
        motion.e[slipper] = friction(system, laws, motion, slipper) + motion.mode[slipper] * slope
        motion.e[rider] = ride(system, work, slipper, motion.e[slipper], t)
    else:
        # Without a return the rider, loaded at a rate of at least V, leaves first.
        t = min(cap, (limit(system, rider) - work.start_e[rider]) / system.V) if backward else cap
        move_one(system, laws, motion, work, slipper, t)
    if backward:
        t_rider, side = rider_reaches_upper(system, laws, motion, work, slipper, t)
    else:
        t_rider, side = rider_reaches_either(system, laws, motion, work, slipper, t)
    if side != 0:
        motion.event[rider] = side
        if t_rider < t:
            t = t_rider
            lands = False
    if lands:
        motion.event[slipper] = LANDING
    if work.watch[0] != 0.0:
        watch_one(system, laws, motion, work, slipper, t)
    t = sharpen_one(system, laws, motion, work, slipper, t)
    if motion.event[slipper] == LANDING and motion.event[rider] != 0:
        round_to_limit(system, motion, rider, FORCE_ROUNDING)
        if excess_force(system, motion, rider) < 0.0:
            motion.event[rider] = 0
    if motion.directions.shape[0] > 0:
        tangents_one(system, laws, motion, work, slipper, t)
    return t, OK


@kernel(inline=True)
def rider_tolerance(system: System, work: Work, rider: int, t: float) -> float:
    """Bound the rounding of the rider's needed force at time `t`."""
    return 4.0 * EPSILON * (1.0 + limit(system, rider) + system.V * t)


@kernel(inline=True)
def rider_reaches_upper(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t: float
) -> tuple[float, int]:
    """First time up to `t` at which the rider reaches its upper limit, if it does."""
    # Its force grows, at a rate of at least V: the value at `t` (in `motion`) decides.
    rider = 1 - slipper
    end = limit(system, rider)
    excess = motion.e[rider] - end
    tolerance = rider_tolerance(system, work, rider, t)
    if excess < -tolerance:
        return t, 0
    if excess <= tolerance:
        return t, AT_UPPER_LIMIT
    low, high = 0.0, t
    stiffness = 1.0 + system.alpha
    span = excess + (end - work.start_e[rider])
    root = t * (end - work.start_e[rider]) / span
    for _ in range(100):
        move_one(system, laws, motion, work, slipper, root)
        excess = motion.e[rider] - end
        if excess > 0.0:
            high = root
        else:
            low = root
        speed = system.V - system.alpha * motion.w[slipper]
        pull = friction(system, laws, motion, slipper) - motion.e[slipper]
        step = excess / speed
        bend = step * system.alpha * pull / speed
        step /= 1.0 + 0.5 * bend  # Halley's correction
        if abs(step) * (bend * bend + stiffness * step * step) <= 0.01 * LARGEST_REST:
            return root - step, AT_UPPER_LIMIT
        root -= step
        if not low < root < high:
            root = 0.5 * (low + high)
    return root, AT_UPPER_LIMIT


@kernel
def rider_reaches_either(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t_end: float
) -> tuple[float, int]:
    """First time up to `t_end` at which a rider reaches a limit while the other slips forward."""
    # Most often two straight lines show that it stays inside; else safe steps follow both
    # distances.
    rider = 1 - slipper
    end = limit(system, rider)
    tolerance = rider_tolerance(system, work, rider, t_end)
    start = work.start_e[rider]
    last = motion.e[rider]
    reach = system.V * t_end
    if start + reach < end - tolerance and last - reach > -end + tolerance:
        return t_end, 0
    stiffness = 1.0 + system.alpha
    swing = math.hypot(
        (work.start_w[slipper] + system.V / stiffness) * math.sqrt(stiffness),
        friction(system, laws, motion, slipper) - work.start_e[slipper],
    )
    bound_2 = system.alpha * swing
    bound_3 = bound_2 * math.sqrt(stiffness)
    best, best_side = t_end, 0
    for side in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
        sign = 1.0 if side == AT_UPPER_LIMIT else -1.0
        t = 0.0
        for _ in range(MAX_SEARCH):
            move_one(system, laws, motion, work, slipper, t)
            gap = end - sign * motion.e[rider]
            slope = -sign * (system.V - system.alpha * motion.w[slipper])
            pull = friction(system, laws, motion, slipper) - motion.e[slipper]
            curvature = sign * system.alpha * pull
            if all_but_touches(gap, slope, curvature, tolerance) and slope <= 0.0:
                contact = rider_touch(system, laws, motion, work, slipper, t - slope / curvature)
                if contact < math.inf:
                    best, best_side = contact, side
                    break
                step = leaving_step(0.0, curvature, bound_3, CAP) - slope / curvature
            elif gap <= tolerance and (slope < 0.0 or (slope == 0.0 and curvature <= 0.0)):
                best, best_side = contact_time(t, gap, slope, curvature, tolerance), side
                break
            elif gap <= tolerance:
                step = leaving_step(slope, curvature, bound_3, CAP)
            else:
                step = safe_step(gap, slope, curvature, bound_2, bound_3, CAP)
            if t >= best:
                break
            t = min(best, t + max(step, EPSILON * t))
    move_one(system, laws, motion, work, slipper, best)
    return best, best_side


@kernel
def rider_touch(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t: float
) -> float:
    """Time at which a rider, nearest to a limit at `t`, reaches it, by sums of two, or inf."""
    rider = 1 - slipper
    sharpen_one(system, laws, motion, work, slipper, t)
    curvature = abs(system.alpha * (friction(system, laws, motion, slipper) - motion.e[slipper]))
    rounding = SHARPER * rider_tolerance(system, work, rider, t)
    return grazing_time(t, -excess_force(system, motion, rider), curvature, rounding)


@kernel
def watch_one(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t: float
) -> None:
    """Margins of a phase with one slipping block: its lobes that turn back, rider's extremes."""
    rider = 1 - slipper
    stiffness = 1.0 + system.alpha
    frequency = math.sqrt(stiffness)
    a = (work.start_w[slipper] + system.V / stiffness) * frequency
    b = friction(system, laws, motion, slipper) - work.start_e[slipper]
    swing = math.hypot(a, b) / frequency
    if motion.mode[slipper] < 0:
        # The first maximum of w; it turned back if the phase went on beyond it.
        peak = math.atan2(b, a) / frequency
        if peak <= 0.0:
            peak += 2.0 * math.pi / frequency
        if peak < t:
            work.margin[0] = min(work.margin[0], system.V / stiffness - swing)
        return
    if system.alpha == 0.0:
        return
    # The rider's force turns where w = V / alpha.
    level = (system.V / system.alpha + system.V / stiffness) / swing
    if level >= 1.0:
        return
    end_w, end_e = motion.w[slipper], motion.e[slipper]
    end_rider = motion.e[rider]
    for side in (-1.0, 1.0):
        turn = (math.atan2(b, a) + side * math.acos(level)) / frequency
        if turn <= 0.0:
            turn += 2.0 * math.pi / frequency
        if turn < t:
            move_one(system, laws, motion, work, slipper, turn)
            room = limit(system, rider) - abs(motion.e[rider])
            work.margin[0] = min(work.margin[0], max(room, 0.0))
    motion.w[slipper], motion.e[slipper], motion.e[rider] = end_w, end_e, end_rider


@kernel
def tangents_one(
    system: System, laws: Floats, motion: Motion, work: Work, slipper: int, t: float
) -> None:
    """Carry the tangents through a phase with one slipping block, and through its event."""
    rider = 1 - slipper
    stiffness = 1.0 + system.alpha
    force = friction(system, laws, motion, slipper)
    for column in range(motion.directions.shape[0]):
        d_alpha = motion.directions[column, ALPHA]
        d_V = motion.directions[column, VELOCITY]
        d_start = motion.tangent_e[slipper, column]
        d_force = friction_direction(system, laws, motion, slipper, column)
        d_w, d_pull = oscillator_tangent(
            stiffness,
            system.V,
            work.start_w[slipper],
            force - work.start_e[slipper],
            t,
            d_alpha,
            d_V,
            motion.tangent_w[slipper, column],
            d_force - d_start,
        )
        d_e = d_force - d_pull
        # e_b = e_b(0) + V t - alpha x,  x = (e_a - e_a(0) - V t) / stiffness = integral of w_a
        slipped = (motion.e[slipper] - work.start_e[slipper] - system.V * t) / stiffness
        d_slipped = (d_e - d_start - d_V * t - d_alpha * slipped) / stiffness
        motion.tangent_w[slipper, column] = d_w
        motion.tangent_e[slipper, column] = d_e
        motion.tangent_e[rider, column] += d_V * t - d_alpha * slipped - system.alpha * d_slipped
    tangents_to_event(system, laws, motion)


# --- both blocks slip -------------------------------------------------------------------------


@kernel(inline=True)
def move_both(system: System, laws: Floats, motion: Motion, work: Work, t: float) -> None:
    """Put `motion` at time `t` of a phase in which both blocks slip: sum and difference."""
    friction_1 = friction(system, laws, motion, 0)
    friction_2 = friction(system, laws, motion, 1)
    w_1, w_2 = work.start_w[0], work.start_w[1]
    pull_1, pull_2 = friction_1 - work.start_e[0], friction_2 - work.start_e[1]
    sum_w, sum_pull = oscillator(1.0, 2.0 * system.V, w_1 + w_2, pull_1 + pull_2, t)
    difference_w, difference_pull = oscillator(
        1.0 + 2.0 * system.alpha, 0.0, w_2 - w_1, pull_2 - pull_1, t
    )
    motion.w[0] = 0.5 * (sum_w - difference_w)
    motion.w[1] = 0.5 * (sum_w + difference_w)
    motion.e[0] = friction_1 - 0.5 * (sum_pull - difference_pull)
    motion.e[1] = friction_2 - 0.5 * (sum_pull + difference_pull)


@kernel(inline=True)
def away_from_belt(system: System, laws: Floats, motion: Motion, block: int) -> tuple[float, float]:
    """Rate of change of a slipping block's |w|, and that of the rate."""
    sign = float(motion.mode[block])
    pull = friction(system, laws, motion, block) - motion.e[block]
    return sign * pull, -sign * loading_rate(system, motion.w, block)


@kernel(inline=True)
def mode_swings(
    system: System, laws: Floats, motion: Motion, w: Floats, e: Floats
) -> tuple[float, float]:
    """Amplitudes of the sum and the difference of the relative velocities."""
    friction_1 = friction(system, laws, motion, 0)
    friction_2 = friction(system, laws, motion, 1)
    sum_w = w[0] + w[1] + 2.0 * system.V
    sum_pull = friction_1 + friction_2 - e[0] - e[1]
    difference_w = w[1] - w[0]
    difference_pull = friction_2 - friction_1 - e[1] + e[0]
    frequency = math.sqrt(1.0 + 2.0 * system.alpha)
    return math.hypot(sum_w, sum_pull), math.hypot(difference_w, difference_pull / frequency)


@kernel
def common_period(alpha: float) -> float:
    """Period of two slipping blocks where their frequencies 1 and W have a small ratio, or inf."""
    # A period without a contact proves that there is none; else `mode_swings` decides.
    frequency = math.sqrt(1.0 + 2.0 * alpha)
    for turns in range(1, 33):
        if abs(turns * frequency - round(turns * frequency)) <= 4.0 * EPSILON * turns * frequency:
            return 2.0 * math.pi * turns * (1.0 + 1e-12)
    return math.inf


@kernel
def slides_for_ever(system: System, laws: Floats, motion: Motion, work: Work) -> bool:
    """Whether two blocks slipping backward can be shown never to reach the belt again."""
    if work.sliding[0] > common_period(system.alpha):
        return True
    swing_1, swing_2 = mode_swings(system, laws, motion, motion.w, motion.e)
    return 0.5 * (swing_1 + swing_2) < system.V * (1.0 - CLEARANCE)


@kernel(inline=True)
def next_event_both(
    system: System, laws: Floats, motion: Motion, work: Work, cap: float
) -> tuple[float, int]:
    """First return of one of two slipping blocks, by steps that provably skip none."""
    swing_1, swing_2 = mode_swings(system, laws, motion, work.start_w, work.start_e)
    stiffness = 1.0 + 2.0 * system.alpha
    bound_2 = 0.5 * (swing_1 + stiffness * swing_2)
    bound_3 = 0.5 * (swing_1 + stiffness * math.sqrt(stiffness) * swing_2)
    tolerance = 4.0 * EPSILON * (system.V + swing_1 + swing_2)
    longest = min(cap, LONGEST_STEP)
    t = 0.0
    for _ in range(MAX_SEARCH):
        step = longest
        found = False
        first = second = math.inf
        for block in range(2):
            sign = float(motion.mode[block])
            gap = sign * motion.w[block]
            slope, curvature = away_from_belt(system, laws, motion, block)
            if t == 0.0 and work.start_w[block] == 0.0:
                if abs(slope) <= 4.0 * EPSILON * limit(system, block):
                    slope = 0.0  # F(0) = 1: the slip starts at a double root
                reach = leaving_step(slope, curvature, bound_3, CAP)
                if reach == 0.0:
                    motion.event[block] = LANDING
                    found = True
            elif gap <= tolerance and slope <= 0.0:
                contact = landing_time(system, laws, motion, work, block, t, tolerance)
                if contact < math.inf:
                    motion.event[block] = LANDING
                    found = True
                    reach = CAP
                else:  # it all but touches the belt
                    reach = leaving_step(0.0, curvature, bound_3, CAP) - slope / curvature
                if block == 0:
                    first = contact
                else:
                    second = contact
            else:
                reach = safe_step(max(gap, 0.0), slope, curvature, bound_2, bound_3, CAP)
            step = min(step, reach)
        if found:
            t = finish_both(system, laws, motion, work, t, first, second)
            return t, OK
        if t >= longest:
            if work.watch[0] != 0.0:
                watch_both(system, laws, motion, work, t)
            t = sharpen_both(system, laws, motion, work, t)
            tangents_both(system, laws, motion, work, t)
            return t, OK
        t = min(longest, t + max(step, 2.0 * EPSILON * t))
        move_both(system, laws, motion, work, t)
    return t, STEP_FAILED


@kernel
def sharpen_both(system: System, laws: Floats, motion: Motion, work: Work, t: float) -> float:
    """Put `motion` at its event about time `t`, if it has one: see `sharpen_one`."""
    p_1, p_1_low = sharp_pull(system, laws, motion, work, 0)
    p_2, p_2_low = sharp_pull(system, laws, motion, work, 1)
    pull, pull_low = two_sum(p_1, p_2)
    w, w_low = two_sum(work.start_w[0], work.start_w[1])
    w_low += work.start_w_low[0] + work.start_w_low[1]
    sum_w, sum_w_low, sum_pull, sum_low = oscillator_sharp(
        0.0, 2.0 * system.V, w, w_low, pull, pull_low + (p_1_low + p_2_low), t
    )
    pull, pull_low = two_sum(p_2, -p_1)
    w, w_low = two_sum(work.start_w[1], -work.start_w[0])
    w_low += work.start_w_low[1] - work.start_w_low[0]
    gap_w, gap_w_low, gap_pull, gap_low = oscillator_sharp(
        2.0 * system.alpha, 0.0, w, w_low, pull, pull_low + (p_2_low - p_1_low), t
    )
    w_1, w_1_low = two_sum(0.5 * sum_w, -0.5 * gap_w)
    w_2, w_2_low = two_sum(0.5 * sum_w, 0.5 * gap_w)
    w_1_low += 0.5 * (sum_w_low - gap_w_low)
    w_2_low += 0.5 * (sum_w_low + gap_w_low)
    p_1, p_1_low = two_sum(0.5 * sum_pull, -0.5 * gap_pull)
    p_2, p_2_low = two_sum(0.5 * sum_pull, 0.5 * gap_pull)
    p_1_low += 0.5 * (sum_low - gap_low)
    p_2_low += 0.5 * (sum_low + gap_low)
    rate_1, rate_2 = loading_rate(system, motion.w, 0), loading_rate(system, motion.w, 1)
    rest = 0.0
    if motion.event[0] == LANDING:
        rest = rest_of_landing(w_1 + w_1_low, p_1 + p_1_low, rate_1)
    elif motion.event[1] == LANDING:
        rest = rest_of_landing(w_2 + w_2_low, p_2 + p_2_low, rate_2)
    p_1_low -= rate_1 * rest
    p_2_low -= rate_2 * rest
    put_slipper(system, laws, motion, 0, w_1, w_1_low + p_1 * rest, p_1, p_1_low)
    put_slipper(system, laws, motion, 1, w_2, w_2_low + p_2 * rest, p_2, p_2_low)
    return t + rest


@kernel
def landing_time(
    system: System,
    laws: Floats,
    motion: Motion,
    work: Work,
    block: int,
    t: float,
    tolerance: float,
) -> float:
    """Time at which a block next to the belt lands, just after `t`; inf if it does not."""
    sign = float(motion.mode[block])
    gap = sign * motion.w[block]
    slope, curvature = away_from_belt(system, laws, motion, block)
    if not all_but_touches(gap, slope, curvature, tolerance):
        return contact_time(t, gap, slope, curvature, tolerance)
    events = motion.event[0], motion.event[1]
    motion.event[0] = motion.event[1] = 0
    nearest = t - slope / curvature
    sharpen_both(system, laws, motion, work, nearest)
    lowest = sign * (motion.w[block] + motion.w_low[block])
    move_both(system, laws, motion, work, t)
    motion.event[0], motion.event[1] = events
    return grazing_time(nearest, lowest, curvature, SHARPER * tolerance)


@kernel(inline=True)
def finish_both(
    system: System,
    laws: Floats,
    motion: Motion,
    work: Work,
    t: float,
    first: float,
    second: float,
) -> float:
    """Carry everything to the earlier of the times at which two slipping blocks land."""
    if t > 0.0:
        t = min(first, second)
        for block in range(2):
            if (first if block == 0 else second) > t * (1.0 + 2.0 * EPSILON):
                motion.event[block] = 0  # it lands a little later, in a step of its own
    if work.watch[0] != 0.0:
        watch_both(system, laws, motion, work, t)
    if t > 0.0:
        t = sharpen_both(system, laws, motion, work, t)
    tangents_both(system, laws, motion, work, t)
    return t


@kernel
def watch_both(system: System, laws: Floats, motion: Motion, work: Work, t_end: float) -> None:
    """Margins of lobes that turned back within a step: minima of |w| with w' = 0."""
    if t_end == 0.0:
        return
    frequency = math.sqrt(1.0 + 2.0 * system.alpha)
    pieces = 1 + int(4.0 * t_end * frequency)
    s, c = sincos(t_end / pieces)
    z, u = sincos(frequency * t_end / pieces)
    w_1, w_2 = work.start_w[0], work.start_w[1]
    pull_1 = friction(system, laws, motion, 0) - work.start_e[0]
    pull_2 = friction(system, laws, motion, 1) - work.start_e[1]
    # Sum and difference turn by the same angles from look to look.
    sum_w, sum_pull = w_1 + w_2 + 2.0 * system.V, pull_1 + pull_2
    gap_w, gap_pull = frequency * (w_2 - w_1), pull_2 - pull_1
    mode_1, mode_2 = 0.5 * motion.mode[0], 0.5 * motion.mode[1]
    slope_1 = slope_2 = 1.0
    bend_1 = bend_2 = right = 0.0
    for piece in range(pieces + 1):
        left, right = right, t_end * piece / pieces
        later_1, later_2 = mode_1 * (sum_pull - gap_pull), mode_2 * (sum_pull + gap_pull)
        bent_1 = mode_1 * (frequency * gap_w - sum_w)
        bent_2 = -mode_2 * (frequency * gap_w + sum_w)
        if slope_1 < 0.0 <= later_1:
            lobe_margin(system, laws, motion, work, 0, left, right)
        elif hides_a_turn(slope_1, later_1, bend_1, bent_1, right - left):
            short_lobe_margin(system, laws, motion, work, 0, left, right)
        if slope_2 < 0.0 <= later_2:
            lobe_margin(system, laws, motion, work, 1, left, right)
        elif hides_a_turn(slope_2, later_2, bend_2, bent_2, right - left):
            short_lobe_margin(system, laws, motion, work, 1, left, right)
        # A slip starts by leaving zero.
        slope_1 = 1.0 if piece == 0 and w_1 == 0.0 else later_1
        slope_2 = 1.0 if piece == 0 and w_2 == 0.0 else later_2
        bend_1, bend_2 = bent_1, bent_2
        sum_w, sum_pull = sum_w * c + sum_pull * s, sum_pull * c - sum_w * s
        gap_w, gap_pull = gap_w * u + gap_pull * z, gap_pull * u - gap_w * z
    move_both(system, laws, motion, work, t_end)


@kernel
def short_lobe_margin(
    system: System,
    laws: Floats,
    motion: Motion,
    work: Work,
    block: int,
    left: float,
    right: float,
) -> None:
    """As `lobe_margin`, if |w| turns twice between two times at which it rises, or falls."""
    low, high, side = left, right, 0.0
    slope = 0.0
    for k in range(40):
        middle = high if k == 0 else 0.5 * (low + high)
        move_both(system, laws, motion, work, middle)
        slope, curvature = away_from_belt(system, laws, motion, block)
        if k == 0:
            side = curvature
        elif (curvature > 0.0) == (side > 0.0):
            high = middle
        else:
            low = middle
    # Here the slope is extreme.
    if side > 0.0 and slope < 0.0:
        lobe_margin(system, laws, motion, work, block, low, right)
    elif side < 0.0 and slope >= 0.0:
        lobe_margin(system, laws, motion, work, block, left, low)


@kernel
def lobe_margin(
    system: System,
    laws: Floats,
    motion: Motion,
    work: Work,
    block: int,
    low: float,
    high: float,
) -> None:
    """Smallest |w| between `low` and `high`, where it falls at first and rises at last."""
    t = 0.5 * (low + high)
    for _ in range(60):
        move_both(system, laws, motion, work, t)
        slope, curvature = away_from_belt(system, laws, motion, block)
        if slope < 0.0:
            low = t
        else:
            high = t
        if curvature > 0.0 and abs(slope) <= 1e-12 * curvature:
            break
        t = t - slope / curvature if curvature > 0.0 else low
        if not low < t < high:
            t = 0.5 * (low + high)
    nearest = float(motion.mode[block]) * motion.w[block]
    work.margin[0] = min(work.margin[0], max(nearest, 0.0))


@kernel
def tangents_both(system: System, laws: Floats, motion: Motion, work: Work, t: float) -> None:
    """Carry the tangents through a phase with two slipping blocks, and through its event."""
    pull_1 = friction(system, laws, motion, 0) - work.start_e[0]
    pull_2 = friction(system, laws, motion, 1) - work.start_e[1]
    w_1, w_2 = work.start_w[0], work.start_w[1]
    for column in range(motion.directions.shape[0]):
        d_friction_1 = friction_direction(system, laws, motion, 0, column)
        d_friction_2 = friction_direction(system, laws, motion, 1, column)
        d_w_1, d_w_2 = motion.tangent_w[0, column], motion.tangent_w[1, column]
        d_pull_1 = d_friction_1 - motion.tangent_e[0, column]
        d_pull_2 = d_friction_2 - motion.tangent_e[1, column]
        sum_w, sum_pull = oscillator_tangent(
            1.0,
            2.0 * system.V,
            w_1 + w_2,
            pull_1 + pull_2,
            t,
            0.0,
            2.0 * motion.directions[column, VELOCITY],
            d_w_1 + d_w_2,
            d_pull_1 + d_pull_2,
        )
        difference_w, difference_pull = oscillator_tangent(
            1.0 + 2.0 * system.alpha,
            0.0,
            w_2 - w_1,
            pull_2 - pull_1,
            t,
            2.0 * motion.directions[column, ALPHA],
            0.0,
            d_w_2 - d_w_1,
            d_pull_2 - d_pull_1,
        )
        motion.tangent_w[0, column] = 0.5 * (sum_w - difference_w)
        motion.tangent_w[1, column] = 0.5 * (sum_w + difference_w)
        motion.tangent_e[0, column] = d_friction_1 - 0.5 * (sum_pull - difference_pull)
        motion.tangent_e[1, column] = d_friction_2 - 0.5 * (sum_pull + difference_pull)
    tangents_to_event(system, laws, motion)


# --- shared -----------------------------------------------------------------------------------


@kernel
def tangents_to_event(system: System, laws: Floats, motion: Motion) -> None:
    """Move the tangents from a fixed time to the time of the event (the saltation)."""
    rate_w_1 = rate_w_2 = 0.0
    if motion.mode[0] != 0:
        rate_w_1 = friction(system, laws, motion, 0) - motion.e[0]
    if motion.mode[1] != 0:
        rate_w_2 = friction(system, laws, motion, 1) - motion.e[1]
    saltation(system, motion, rate_w_1, rate_w_2)


# --- evaluation inside a phase ----------------------------------------------------------------


@kernel
def states(
    system: System,
    laws: Floats,
    motion: Motion,
    work: Work,
    starts: Phases,
    index: NDArray[np.int64],
    t: Floats,
    w: NDArray[np.float64],
    e: NDArray[np.float64],
) -> None:
    """State at times `t` after the start of the phases `index`: rows of `w`, `e` (n, 2)."""
    for i in range(t.shape[0]):
        phase = index[i]
        for block in range(2):
            motion.mode[block] = starts.mode[phase, block]
            motion.w[block] = work.start_w[block] = starts.w[phase, block]
            motion.e[block] = work.start_e[block] = starts.e[phase, block]
        if motion.mode[0] != 0 and motion.mode[1] != 0:
            move_both(system, laws, motion, work, t[i])
        elif motion.mode[0] != 0 or motion.mode[1] != 0:
            move_one(system, laws, motion, work, 0 if motion.mode[0] != 0 else 1, t[i])
        else:
            motion.e[0] += system.V * t[i]
            motion.e[1] += system.V * t[i]
        for block in range(2):
            w[i, block] = motion.w[block]
            e[i, block] = motion.e[block]
