"""Events, margins and ends of smooth pieces of laws on one step, given as polynomials in time."""

# Rows of `w` and `e` hold the coefficients of each block. A step ends where a slip speed is
# `OVERLAP` beyond the smooth piece of the law on which the step starts.

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    LANDING,
    Floats,
    Motion,
    System,
    limit,
)
from stickslip.mechanics.friction.interface import NEXT_PIECE_COLUMN, PIECE_END_COLUMN
from stickslip.numerics.polynomial import NO_ROOT, UNFINISHED, first_contact, lowest_minimum, value
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel

# Of the order of speeds + the speed of a knot: well above the rounding of a speed, well below what
# a law feels.
OVERLAP = 1e-12
# What a law does elsewhere its series need not know: a force that rises in a narrow range of speeds
# alone is flat to rounding outside. So it is looked at on the step, in so many places, ...
PLACES = 4
# ... where series of the order taken are off by at most so many `rtol`, ...
OFF = 1e2
# ... or so much of the force, which rounding of the speed may be where the law is steep; ...
UNHEEDED = 1e-12
# ... and the step is halved, at most so often, as long as one is off by more.
MOST_HALVINGS = 40


@kernel(inline=True)
def piece_row(laws: Floats, block: int, s: float) -> int:
    """Row of the piece on which the law of a block is at the speed `s`."""
    row = block
    while s > laws[row, PIECE_END_COLUMN]:
        row = int(laws[row, NEXT_PIECE_COLUMN])
    return row


@kernel
def at_place(k: int, h: float, mode: int, speed: Floats, force: Floats) -> tuple[float, float]:
    """Slip speed and force that their series tell in the k-th place of a step."""
    # Speeds well below 0 are of states that no motion has, for tangents beside one.
    t = h * k / PLACES
    return mode * value(speed, t), value(force, t)


@kernel
def is_followed(exact: float, told: float, most: float) -> bool:
    """Whether a series tells a law's value; `most`: what it may be off by, rounding aside."""
    return not abs(told - exact) > most + UNHEEDED * abs(exact)  # NaN is another's to tell


@kernel
def leaving_time(laws: Floats, block: int, speed: Floats, h: float, order: float) -> float:
    """Time at which a slip speed, a series, leaves its piece, at most `h`; <= 0 if that failed."""
    start = speed[0]
    low = 0.0
    row = block
    while start > laws[row, PIECE_END_COLUMN]:
        low = laws[row, PIECE_END_COLUMN]
        row = int(laws[row, NEXT_PIECE_COLUMN])
    high = laws[row, PIECE_END_COLUMN]
    if low > 0.0:
        speed[0] = start - low + OVERLAP * (order + low)
        t = first_contact(speed, h, False, 0.0)
        h = h if t == NO_ROOT else t
        speed[0] = start
    if high < math.inf and h > 0.0:
        for k in range(speed.shape[0]):
            speed[k] = -speed[k]
        speed[0] = high - start + OVERLAP * (order + high)
        t = first_contact(speed, h, False, 0.0)
        h = h if t == NO_ROOT else t
    return h


Rows = NDArray[np.float64]

# Rounding of a step's coefficients, in units of EPSILON.
SLACK = 4.0
# Rounding of a needed force where a block lands, in units of EPSILON x limit.
FORCE_ROUNDING = 4.0


@kernel(inline=True)
def slip_signal(motion: Motion, w: Rows, signal: Floats, block: int) -> None:
    """|w| of a slipping block, which lands where it reaches zero."""
    for k in range(signal.shape[0]):
        signal[k] = motion.mode[block] * w[block, k]


@kernel(inline=True)
def stay_on_pieces(laws: Floats, motion: Motion, w: Rows, signal: Floats, h: float) -> float:
    """Length of a step on which both laws stay smooth, at most `h`; <= 0 if a search failed."""
    if laws.shape[0] > 2:
        for block in range(2):
            if motion.mode[block] != 0 and h > 0.0:
                slip_signal(motion, w, signal, block)
                h = leaving_time(laws, block, signal, h, 1.0)
    return h


@kernel(inline=True)
def ride_signal(system: System, e: Rows, signal: Floats, block: int, event: int) -> None:
    """Distance of a rider's needed force from its upper or lower limit."""
    sign = -1.0 if event == AT_UPPER_LIMIT else 1.0
    for k in range(signal.shape[0]):
        signal[k] = sign * e[block, k]
    signal[0] += limit(system, block)
    if abs(signal[0]) <= SLACK * EPSILON * limit(system, block):
        signal[0] = 0.0


@kernel(inline=True)
def find_events(
    system: System, motion: Motion, w: Rows, e: Rows, signal: Floats, h: float
) -> float:
    """Length of the step up to its first event, or all of it; negative if a search failed."""
    # ``motion.event`` names the event of each block; events closer than rounding are one.
    motion.event[0] = motion.event[1] = 0
    slack = SLACK * EPSILON
    for block in range(2):
        if motion.mode[block] != 0:
            slip_signal(motion, w, signal, block)
            t = first_contact(signal, h, signal[0] == 0.0, slack)
            h = keep_first(motion, block, LANDING, t, h)
        else:
            for event in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
                ride_signal(system, e, signal, block, event)
                t = first_contact(signal, h, signal[0] == 0.0, slack)
                h = keep_first(motion, block, event, t, h)
        if h < 0.0:
            return h
    return h


@kernel(inline=True)
def keep_first(motion: Motion, block: int, event: int, t: float, h: float) -> float:
    """Note an event at `t` unless there is an earlier one; return the step's new length."""
    if t == NO_ROOT:
        return h
    if t == UNFINISHED:
        return t
    if t < h - 2.0 * EPSILON * h:
        motion.event[0] = motion.event[1] = 0
    motion.event[block] = event
    return min(t, h)


@kernel
def watch_step(system: System, motion: Motion, w: Rows, e: Rows, signal: Floats, h: float) -> float:
    """Smallest clearance on a step: lobes of |w| that turned back, extremes of riders."""
    margin = math.inf
    for block in range(2):
        if motion.mode[block] != 0:
            slip_signal(motion, w, signal, block)
            margin = min(margin, clearance(signal, h))
        else:
            for event in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
                ride_signal(system, e, signal, block, event)
                margin = min(margin, clearance(signal, h))
    return margin


@kernel
def clearance(signal: Floats, h: float) -> float:
    """Value of a signal at its lowest minimum inside the step, or inf."""
    t = lowest_minimum(signal, h)
    if t == NO_ROOT:
        return math.inf
    return max(value(signal, t), 0.0)
