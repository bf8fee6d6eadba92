"""Phases with constant kinetic friction as straight lines of arithmetic, one motion a lane."""

# The physics of `_exact_kernels` without a branch. A lane does not take a decision closer than
# `NEAR`: its motion goes to another engine. Derivations: docs/theory/flow.md, blocks.md.

from __future__ import annotations

import math
from typing import NamedTuple

from stickslip.mechanics.flow.oscillator import oscillator_change
from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.rounding import two_product, two_sum
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import ROUNDER, turn_squared, upper_angle

# Clearance from another outcome, in units of the quantity's size, below which a lane gives up.
NEAR = 1e-9
# A landing closer than this is left to the series of `contact_ahead`.
REACH = 0.1
# The bounds of `safe_reach` are used over at most this time (measured optimum), and over at
# most a quarter of the faster period, as far as `turn` reaches.
CAP = 0.85
TURN, TURNS = 2.0 * math.pi, 0.5 / math.pi


class CoulombConstants(NamedTuple):
    """Two equal blocks with constant kinetic friction, and what follows from their parameters."""

    # What steps of two slipping blocks need comes first, what only an onset needs last. The rider
    # of a slip has ``e(t) = e(0) + ride_time t - ride_force (e_slipper(t) - e_slipper(0))``.

    V: float
    spread: float
    twice: float  # alpha
    cap: float
    friction_1: float
    friction_2: float
    narrow: float  # 1 / spread
    limit_1: float
    limit_2: float
    near: float
    alpha: float
    stiffness: float
    beat: float
    frequency: float
    frequency_low: float  # what rounding left out
    unit: float  # time in which a slip turns by 1
    unit_low: float
    compliance: float  # 1 / stiffness
    compliance_low: float
    level: float
    ride_time: float
    ride_force: float
    turning: float  # speed of a forward slip at which the rider's force stops growing
    end: float
    first_time_1: float  # return of a slip from rest at the limit
    first_time_2: float
    first_gain_1: float  # of the rider's force until then
    first_gain_2: float


class Slip(NamedTuple):
    """One block slips at a velocity w, the other rides."""

    # Its needed force gains ``loading + stiffness w`` in unit time, its rider's ``loading_b -
    # coupling w``.
    loading: float
    loading_b: float
    alpha: float  # stiffness - 1
    stiffness: float
    coupling: float
    frequency: float
    frequency_low: float  # what rounding left out
    unit: float  # time in which a slip turns by 1
    unit_low: float
    compliance: float  # 1 / stiffness
    compliance_low: float
    level: float
    ride_time: float
    ride_force: float
    turning: float  # speed of a forward slip at which the rider's force stops growing
    friction: float
    limit: float
    limit_b: float
    first_rider: float  # force of the rider as the slip begins from d = 0, and its slope in d
    first_slope: float
    first_time: float
    first_gain: float


class Pair(NamedTuple):
    """Two unequal blocks: what `CoulombConstants` of equal ones with their modes do not say.

    Passes for equal blocks are compiled with None for a pair.
    """

    # Modes ``A q_1 + B q_2`` and ``A q_2 - B q_1`` of velocities q = w + belt, ``A^2 + B^2 = 2``.
    slips: tuple[Slip, Slip]
    weights: tuple[float, float]  # A, B
    belt: tuple[float, float]  # its velocity as each block's
    belt_modes: tuple[float, float]
    give: tuple[float, float]  # d = give_1 e_1 + give_2 e_2


@kernel
def slip_at(
    alpha: float,
    coupling: float,
    loading: float,
    loading_b: float,
    sweep: float,
    friction: float,
    limit: float,
    limit_b: float,
    first_rider: float,
    first_slope: float,
) -> Slip:
    """Make the numbers of a `Slip`; `sweep`: ``stiffness loading_b + coupling loading``."""
    stiffness = 1.0 + alpha
    frequency = math.sqrt(stiffness)
    level, ride_time, ride_force = loading / frequency, sweep / stiffness, coupling / stiffness
    turning = loading_b / coupling if coupling > 0.0 else math.inf
    pull = limit - friction
    first_time = 2.0 * math.atan2(2.0 * pull, -2.0 * level) / frequency
    first_gain = ride_time * first_time + 2.0 * ride_force * pull
    unit, compliance = 1.0 / frequency, 1.0 / stiffness
    _, stiffness_low = two_sum(1.0, alpha)
    square, square_low = two_product(frequency, frequency)
    frequency_low = 0.5 * unit * ((stiffness - square) - square_low + stiffness_low)
    whole, whole_low = two_product(frequency, unit)
    unit_low = unit * ((1.0 - whole) - whole_low - frequency_low * unit)
    whole, whole_low = two_product(stiffness, compliance)
    compliance_low = compliance * ((1.0 - whole) - whole_low - stiffness_low * compliance)
    # fmt: off
    return Slip(
        loading, loading_b, alpha, stiffness, coupling,
        frequency, frequency_low, unit, unit_low, compliance, compliance_low,
        level, ride_time, ride_force, turning, friction, limit, limit_b,
        first_rider, first_slope, first_time, first_gain,
    )
    # fmt: on


@kernel
def constants_at(alpha: float, beta: float, V: float, mu_1: float, mu_2: float) -> CoulombConstants:
    """Make the numbers of a `CoulombConstants`; `mu`: kinetic friction of each block."""
    spread = 1.0 + 2.0 * alpha
    beat, narrow, friction_2 = math.sqrt(spread), 1.0 / spread, mu_2 * beta
    cap, near, end = min(CAP, 0.5 * math.pi / beat), NEAR * (1.0 + beta), (1.0 + beta) / spread
    one = slip_at(alpha, alpha, V, V, V * spread, mu_1, 1.0, beta, 1.0, spread)
    two = slip_at(alpha, alpha, V, V, V * spread, friction_2, beta, 1.0, beta, -spread)
    # fmt: off
    return CoulombConstants(
        V, spread, 2.0 * alpha, cap, mu_1, friction_2, narrow,
        1.0, beta, near, alpha, one.stiffness, beat,
        one.frequency, one.frequency_low, one.unit, one.unit_low,
        one.compliance, one.compliance_low, one.level, one.ride_time, one.ride_force, one.turning,
        end, one.first_time, two.first_time, one.first_gain, two.first_gain,
    )
    # fmt: on


@kernel(inline=True)
def constants_of_row(row: Floats) -> CoulombConstants:
    """Read a `CoulombConstants` from an array."""
    # fmt: off
    return CoulombConstants(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7],
        row[8], row[9], row[10], row[11], row[12], row[13], row[14], row[15],
        row[16], row[17], row[18], row[19], row[20], row[21], row[22], row[23],
        row[24], row[25], row[26], row[27],
    )
    # fmt: on


# --- one block slips --------------------------------------------------------------------------


@kernel(inline=True, fused=True)
def slip_of(constants: CoulombConstants, pair: Pair | None, first: bool) -> Slip:
    """Give the numbers of a slip of block 1, or of block 2."""
    if pair is None:
        c = constants
        # fmt: off
        return Slip(
            c.V, c.V, c.alpha, c.stiffness, c.alpha,
            c.frequency, c.frequency_low, c.unit, c.unit_low, c.compliance, c.compliance_low,
            c.level, c.ride_time, c.ride_force, c.turning,
            c.friction_1 if first else c.friction_2,
            c.limit_1 if first else c.limit_2,
            c.limit_2 if first else c.limit_1,
            c.limit_1 if first else c.limit_2,
            c.spread if first else -c.spread,
            c.first_time_1 if first else c.first_time_2,
            c.first_gain_1 if first else c.first_gain_2,
        )
        # fmt: on
    return pair.slips[0] if first else pair.slips[1]


@kernel(inline=True, fused=True)
def difference(
    constants: CoulombConstants, pair: Pair | None, first: bool, rider: float, force: float
) -> float:
    """Give d from the needed forces of a rider and of the block that slipped."""
    if pair is None:
        value = (rider - force) * constants.narrow
        return value if first else -value
    e_1, e_2 = (force, rider) if first else (rider, force)
    return pair.give[0] * e_1 + pair.give[1] * e_2


@kernel(inline=True, fused=True)
def overload(slip: Slip, pair: Pair | None, t: float, gained: float, room: float) -> float:
    """Gain of a rider's force beyond `room`, times the stiffness; the slipper's has `gained`."""
    short = slip.loading_b * t - room
    if pair is None:
        slid = (short + slip.loading * t) - gained
        return short + slip.alpha * slid
    return short + (slip.alpha * short + slip.coupling * (slip.loading * t - gained))


@kernel(inline=True, fused=True)
def drawn(slip: Slip, sign: float, gap: float) -> float:
    """Give ``stiffness gap - 2 v`` of a slip, gap = |w|, v = sign loading (1 if backward)."""
    # ``gap'^2 + gap (stiffness gap - 2 v)`` stays: the square of the rate at the return.
    return (gap + slip.alpha * gap) - 2.0 * sign * slip.loading


@kernel(inline=True, fused=True)
def half_angle(slip: Slip, gap: float, rate: float, pull: float, end: float) -> tuple[float, float]:
    """Give y, x of half the angle in which a slip returns at a rate `end`; `pull`: `drawn`."""
    leaves = rate > 0.0
    y = end + rate if leaves else gap
    return slip.frequency * y + slip.frequency_low * y, pull if leaves else end - rate


@kernel(inline=True, fused=True)
def slip_turned(slip: Slip, t: float) -> tuple[float, float]:
    """Return versed sine and sine of ``W t`` over W^2 and W, from half the angle: W is rounded."""
    k = (t * slip.frequency * TURNS + ROUNDER) - ROUNDER
    half = 0.5 * ((t - k * (TURN * slip.unit)) - k * (TURN * slip.unit_low))
    square = half * half
    turned = square + slip.alpha * square
    sine, versed = turn_squared(turned)
    s = half + half * turned * sine
    return 2.0 * s * s, 2.0 * s * (1.0 - versed)


@kernel(inline=True, fused=True)
def smooth_share(share: float) -> float:
    """Inverse of ``3 t^2 - 2 t^3`` within 0.003, exact at 0, 1/2 and 1: a guess."""
    u = 1.0 - 2.0 * share
    square = 1.0 - u * u
    bend = math.sqrt(square if square > 0.0 else 0.0)
    return 0.5 - u * (0.5 - bend * (0.28868 - 0.122 * bend))


@kernel(inline=True, fused=True)
def dip(
    slip: Slip, gap: float, rate: float, end: float, time: float, gain: float
) -> tuple[float, float, float, float]:
    """Fall of the rider's force in a forward slip: (begin, its gain there, end, gain there)."""
    # Both times are 0 where the slip never becomes faster than `turning`: past its crest, too.
    fast = slip.turning
    square = rate * rate + (gap - fast) * (slip.stiffness * (gap + fast) + 2.0 * slip.loading)
    bound = math.sqrt(square if square > 0.0 else 0.0)
    swing = slip.frequency * gap + slip.level
    top = slip.frequency * fast + slip.level
    rise = top * rate - bound * swing
    first = upper_angle(rise if rise > 0.0 else 0.0, top * swing + bound * rate) * slip.unit
    first = first if gap < fast else 0.0
    leaving = rate if gap >= fast else bound
    sink = end * top - slip.level * bound
    rest = upper_angle(sink if sink > 0.0 else 0.0, top * slip.level + bound * end)
    last = time - rest * slip.unit
    high = slip.ride_time * first - slip.ride_force * (rate - leaving)
    low = gain - (slip.ride_time * (time - last) - slip.ride_force * (end - bound))
    falls = square > 0.0 and (gap >= fast or rate > 0.0)
    return (
        first if falls else 0.0,
        high if falls else 0.0,
        last if falls else 0.0,
        low if falls else 0.0,
    )


# --- both blocks slip -------------------------------------------------------------------------


@kernel(inline=True, fused=True)
def modes_turned(
    constants: CoulombConstants,
    t: float,
    sum_w: float,
    sum_pull: float,
    gap_w: float,
    gap_pull: float,
) -> tuple[float, float, float, float]:
    """Carry sum and difference of both blocks through a time of at most `CoulombConstants.cap`."""
    # ``sum_w = w_1 + w_2 + 2 V``, ``gap_w = w_2 - w_1``; the pulls are their rates.
    square = t * t
    wide = square + constants.twice * square
    s, v = turn_squared(square)
    z, u = turn_squared(wide)
    s, z = t + t * square * s, t + t * wide * z
    return modes_moved(constants, s, v, z, u, sum_w, sum_pull, gap_w, gap_pull)


@kernel(inline=True, fused=True)
def modes_moved(
    constants: CoulombConstants,
    s: float,
    v: float,
    z: float,
    u: float,
    sum_w: float,
    sum_pull: float,
    gap_w: float,
    gap_pull: float,
) -> tuple[float, float, float, float]:
    """Give sum and difference after a turn; of the latter, z is the sine over its frequency."""
    moved = gap_w * z
    return (
        sum_w + (sum_pull * s - sum_w * v),
        sum_pull - (sum_w * s + sum_pull * v),
        gap_w + (gap_pull * z - gap_w * u),
        gap_pull - (moved + (constants.twice * moved + gap_pull * u)),
    )


@kernel(inline=True, fused=True)
def modes_polished(
    constants: CoulombConstants,
    t: float,
    sum_w: float,
    sum_pull: float,
    gap_w: float,
    gap_pull: float,
) -> tuple[float, float, float, float]:
    """As `modes_turned`, for a time so short that five terms of a series are exact."""
    v = t * t
    u = constants.spread * v
    s, z = t - t * v * (1.0 / 6.0), t - t * u * (1.0 / 6.0)
    v, u = v * (0.5 - v * (1.0 / 24.0)), u * (0.5 - u * (1.0 / 24.0))
    return modes_moved(constants, s, v, z, u, sum_w, sum_pull, gap_w, gap_pull)


@kernel(inline=True, fused=True)
def shares(pair: Pair | None, side: float) -> tuple[float, float]:
    """Twice the shares of sum and difference in a block; `side`: -1 for block 1, 1 for 2."""
    if pair is None:
        return 1.0, side
    a, b = pair.weights
    return (b, a) if side > 0.0 else (a, -b)


@kernel(inline=True, fused=True)
def largest_share(pair: Pair | None) -> float:
    """Bound `shares`."""
    return 1.0 if pair is None else max(pair.weights)


@kernel(inline=True, fused=True)
def modes_of(pair: Pair | None, x_1: float, x_2: float) -> tuple[float, float]:
    """Sum and difference of the blocks' numbers."""
    if pair is None:
        return x_1 + x_2, x_2 - x_1
    a, b = pair.weights
    return a * x_1 + b * x_2, a * x_2 - b * x_1


@kernel(inline=True, fused=True)
def blocks_of(pair: Pair | None, x_sum: float, x_gap: float) -> tuple[float, float]:
    """Invert `modes_of`."""
    if pair is None:
        return 0.5 * (x_sum - x_gap), 0.5 * (x_sum + x_gap)
    a, b = pair.weights
    return 0.5 * (a * x_sum - b * x_gap), 0.5 * (b * x_sum + a * x_gap)


@kernel(inline=True, fused=True)
def belt_of(constants: CoulombConstants, pair: Pair | None, side: float) -> float:
    """Give the belt's velocity as a block's."""
    if pair is None:
        return constants.V
    return pair.belt[1] if side > 0.0 else pair.belt[0]


@kernel(inline=True, fused=True)
def belt_modes(constants: CoulombConstants, pair: Pair | None) -> tuple[float, float]:
    """Give the belt's velocity as those of the modes; to add -0 is to do nothing."""
    if pair is None:
        return 2.0 * constants.V, -0.0
    return pair.belt_modes


@kernel(inline=True, fused=True)
def clearance(
    constants: CoulombConstants,
    pair: Pair | None,
    mode: float,
    side: float,
    sum_w: float,
    sum_pull: float,
    gap_w: float,
    gap_pull: float,
) -> tuple[float, float, float, float, float]:
    """Distance |w| of a block from the belt, four derivatives; `side`: -1 for block 1, 1 for 2."""
    of_sum, of_gap = shares(pair, side)
    half, gap_rate = 0.5 * mode, of_gap * gap_pull
    return (
        half * (of_sum * sum_w + of_gap * gap_w) - mode * belt_of(constants, pair, side),
        half * (of_sum * sum_pull + gap_rate),
        -half * (of_sum * sum_w + of_gap * constants.spread * gap_w),
        -half * (of_sum * sum_pull + constants.spread * gap_rate),
        half * (of_sum * sum_w + of_gap * constants.spread * constants.spread * gap_w),
    )


@kernel(inline=True, fused=True)
def fall(
    constants: CoulombConstants, f_2: float, f_3: float, bound_2: float, bound_4: float
) -> float:
    """Sharpest m with ``f(h) >= f + f' h - m h^2 / 2`` for every h up to the cap."""
    sinking = -f_3 if f_3 < 0.0 else 0.0
    m = constants.cap * (sinking * (1.0 / 3.0) + bound_4 * constants.cap * (1.0 / 12.0)) - f_2
    m = m if m < bound_2 else bound_2
    return m if m > 1e-6 else 1e-6


@kernel(inline=True, fused=True)
def safe_reach(constants: CoulombConstants, f: float, f_1: float, m: float) -> float:
    """Time, at most the cap, in which ``f > 0`` provably stays positive."""
    root = math.sqrt(f_1 * f_1 + 2.0 * m * f)
    rises = f_1 > 0.0
    h = (f_1 + root if rises else 2.0 * f) / (m if rises else root - f_1)
    return h if h < constants.cap else constants.cap


@kernel(inline=True, fused=True)
def falls_to_zero(f: float, f_1: float, bound_2: float) -> bool:
    """Whether f, with ``|f''| <= bound_2``, provably falls until it is zero, and that is near."""
    return f_1 < -1e-4 * bound_2 and 6.0 * f * bound_2 < f_1 * f_1 and f < -REACH * f_1


@kernel(inline=True, fused=True)
def contact_ahead(f: float, f_1: float, f_2: float, f_3: float, f_4: float) -> float:
    """Root of the Taylor series of f next to 0, by reversion; error of the fifth order."""
    inverse = -1.0 / f_1
    d = f * inverse
    a = (-1.0 / 2.0) * f_2 * inverse
    b = (-1.0 / 6.0) * f_3 * inverse
    c = (-1.0 / 24.0) * f_4 * inverse
    square = a * a
    third = (2.0 * square - b) + d * (5.0 * a * b - 5.0 * a * square - c)
    return d * (1.0 - d * (a - d * third))


# --- in a parameter -----------------------------------------------------------------------------


class Change(NamedTuple):
    """Derivatives of what two equal blocks are made of, in a parameter; None: in the start."""

    # With None all of the following is -0, and adding that is nothing.

    alpha: float
    V: float
    friction_1: float
    friction_2: float
    limit_2: float


@kernel(inline=True, fused=True)
def friction_change(along: Change | None, first: bool, by: float) -> float:
    """Differentiate the friction of a block, times `by`."""
    if along is None:
        return -0.0
    return by * (along.friction_1 if first else along.friction_2)


@kernel(inline=True, fused=True)
def limit_change(along: Change | None, first: bool, by: float) -> float:
    """Differentiate the static limit of a block, times `by`."""
    if along is None:
        return -0.0
    return 0.0 if first else by * along.limit_2


@kernel(inline=True, fused=True)
def belt_change(along: Change | None, by: float) -> float:
    """Differentiate the belt's velocity, times `by`."""
    return -0.0 if along is None else by * along.V


@kernel(inline=True, fused=True)
def onset_changes(along: Change | None, slope: float, first: bool, d: float) -> tuple[float, float]:
    """Differentiate the needed forces, as the first slip begins, of its block and of its rider."""
    if along is None:
        return 0.0, slope
    wider = 2.0 * d * along.alpha
    return limit_change(along, first, 1.0), wider if first else along.limit_2 - wider


@kernel(inline=True, fused=True)
def slip_bend(
    slip: Slip,
    along: Change | None,
    sign: float,
    gap: float,
    rate: float,
    t: float,
    s: float,
    c: float,
) -> tuple[float, float]:
    """Differentiate gap and rate after a time, their start fixed; s: sine over the frequency."""
    if along is None:
        return -0.0, -0.0
    drive, d_drive = -sign * slip.loading, -sign * along.V
    return oscillator_change(
        slip.stiffness, drive, gap, rate, t, s, c, along.alpha, d_drive, 0.0, 0.0
    )


@kernel(inline=True, fused=True)
def gap_bend(
    constants: CoulombConstants,
    along: Change | None,
    gap_w: float,
    gap_pull: float,
    t: float,
    s: float,
    c: float,
) -> tuple[float, float]:
    """As `slip_bend`, the difference of two slipping blocks, whose end is given."""
    if along is None:
        return -0.0, -0.0
    first_w = gap_w * c - gap_pull * s
    first_pull = gap_pull * c + constants.spread * gap_w * s
    return oscillator_change(
        constants.spread, 0.0, first_w, first_pull, t, s, c, 2.0 * along.alpha, 0.0, 0.0, 0.0
    )


@kernel(inline=True, fused=True)
def return_bend(along: Change | None, sign: float, gap: float) -> float:
    """Differentiate half the square of the rate at a return, the start of the slip fixed."""
    if along is None:
        return -0.0
    return gap * (0.5 * gap * along.alpha - sign * along.V)


@kernel(inline=True, fused=True)
def rider_change(slip: Slip, along: Change | None, t: float, gained: float) -> float:
    """Differentiate the gain of a rider's force, its time and the slipper's gain fixed."""
    if along is None:
        return -0.0
    # ride_time = V (1 + 2 alpha) / (1 + alpha), ride_force = alpha / (1 + alpha)
    bent = slip.loading * t - gained
    shared = along.alpha * slip.compliance * bent + (1.0 + 2.0 * slip.alpha) * along.V * t
    return slip.compliance * shared


@kernel(inline=True, fused=True)
def value_change(constants: CoulombConstants, along: Change | None, value: float) -> float:
    """Differentiate d, the needed forces fixed."""
    return -0.0 if along is None else -2.0 * along.alpha * constants.narrow * value
