"""One step of n blocks: Taylor series of high order, whose polynomials locate the events."""

# Template (`numerics.targets.instantiate`): a law's kernels are bound. Derivation:
# docs/theory/blocks.md. Only slipping blocks have series; a rider among riders is a straight line.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stickslip.mechanics.flow._sliding_kernels import CLEARANCE
from stickslip.mechanics.flow.blocks.saltation import saltation
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    BlockMotion,
    BlockSystem,
    BlockWork,
    Floats,
)
from stickslip.mechanics.flow.blocks.transitions import force_tolerance, loading_rate, update_needed
from stickslip.mechanics.flow.dense import clearance, leaving_time, piece_row
from stickslip.mechanics.flow.system import AT_LOWER_LIMIT, AT_UPPER_LIMIT, LANDING
from stickslip.numerics.polynomial import NO_ROOT, UNFINISHED, first_contact, value
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos
from stickslip.status import LAW_FAILED, OK, STEP_FAILED

if TYPE_CHECKING:
    from stickslip.mechanics.flow._sliding_kernels import least_slope
    from stickslip.mechanics.friction.interface import (
        FORCE_ROW,
        GRADIENT_ROW,
        SLOPE_ROW,
        force,
        series,
        series_tangent,
        static_value,
    )

ORDER = 18
# No step is longer: a Taylor polynomial that happens to end early says nothing beyond.
LONGEST_STEP = 1.0
# Rounding of a step's coefficients, in units of EPSILON.
SLACK = 4.0


@kernel
def advance(
    system: BlockSystem,
    laws: Floats,
    directions: BlockDirections,
    motion: BlockMotion,
    work: BlockWork,
    rtol: float,
    cap: float,
) -> tuple[float, int]:
    """Take one step, up to an event if one comes; return its length and a status."""
    list_active(motion, work)
    expand(system, laws, motion, work)
    h = min(cap, step_length(system, motion, work, rtol))
    if not h > 0.0:
        return 0.0, LAW_FAILED if math.isnan(h) else STEP_FAILED
    h = stay_on_pieces(laws, motion, work, h)
    if not h > 0.0:
        return 0.0, STEP_FAILED
    h = find_events(system, motion, work, h)
    if h < 0.0 or h == math.inf:
        return 0.0, STEP_FAILED
    if work.watch[0] != 0.0:
        work.margin[0] = min(work.margin[0], watch_step(system, motion, work, h))
    if motion.tangent_w.shape[1] > 0:
        tangents(system, laws, directions, motion, work, h)
    move(system, laws, motion, work, h)
    if motion.tangent_w.shape[1] > 0:
        saltation(system, directions, motion, work.rates)
    return h, OK


@kernel(inline=True)
def list_active(motion: BlockMotion, work: BlockWork) -> None:
    """Collect the blocks that slip; riders have no acceleration, whatever was moved before."""
    count = 0
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != 0:
            work.active[count] = i
            count += 1
        else:
            work.rates[i] = 0.0
    work.n_active[0] = count


@kernel(inline=True)
def rate(system: BlockSystem, laws: Floats, motion: BlockMotion, block: int) -> float:
    """Rate w' of a block in its mode."""
    mode = motion.mode[block]
    if mode == 0:
        return 0.0
    s = max(mode * motion.w[block], 0.0)
    friction = -mode * system.static[block] * force(laws[piece_row(laws, block, s)], mode, s)
    return (friction - motion.e[block]) / system.mass[block]


@kernel
def move(system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork, h: float) -> None:
    """Go to the end of the step."""
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != 0:
            motion.w[i] = value(work.w[i], h)
            motion.x[i] = value(work.x[i], h)
        else:
            motion.x[i] += system.V * h
    motion.phase[0] += system.frequency * h
    update_needed(system, motion)
    for i in range(motion.mode.shape[0]):
        if motion.event[i] == AT_UPPER_LIMIT:
            motion.e[i] = system.static[i]
        elif motion.event[i] == AT_LOWER_LIMIT:
            motion.e[i] = -system.static[i]
        work.rates[i] = rate(system, laws, motion, i)


# --- series -----------------------------------------------------------------------------------


@kernel
def expand(system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork) -> None:
    """Taylor series: (k + 1) m w_{k+1} = -mode limit F_k - e_k and (k + 1) x_{k+1} = w_k."""
    x, w = work.x, work.w
    for i in range(motion.mode.shape[0]):
        x[i] = 0.0
        w[i] = 0.0
        x[i, 0] = motion.x[i]
        x[i, 1] = system.V
        w[i, 0] = motion.w[i]
    expand_forcing(system, motion, work)
    for k in range(ORDER):
        for a in range(work.n_active[0]):
            i = work.active[a]
            mode = motion.mode[i]
            work.rows[i, 0, k] = mode * w[i, k]
            row = piece_row(laws, i, mode * motion.w[i])
            series(laws[row], mode, work.rows[i], k)
            needed = motion.e[i] if k == 0 else needed_coefficient(system, work, i, k)
            pull = -mode * system.static[i] * work.rows[i, FORCE_ROW, k] - needed
            if k == 0 and w[i, 0] == 0.0 and abs(pull) <= force_tolerance(system, motion, i):
                pull = 0.0  # F(0) = 1: a slip starts at a double root
            w[i, k + 1] = pull / (system.mass[i] * (k + 1))
        for a in range(work.n_active[0]):
            i = work.active[a]
            x[i, k + 1] = (w[i, k] + (system.V if k == 0 else 0.0)) / (k + 1)


@kernel(inline=True)
def expand_forcing(system: BlockSystem, motion: BlockMotion, work: BlockWork) -> None:
    """Taylor series of cos(phase) and sin(phase)."""
    sine, cosine = sincos(motion.phase[0])
    work.cosine[0], work.sine[0] = cosine, sine
    for k in range(ORDER):
        work.cosine[k + 1] = -system.frequency * work.sine[k] / (k + 1)
        work.sine[k + 1] = system.frequency * work.cosine[k] / (k + 1)


@kernel(inline=True)
def needed_coefficient(system: BlockSystem, work: BlockWork, block: int, k: int) -> float:
    """Coefficient k >= 1 of a block's needed force."""
    needed = -system.amplitude[block] * work.cosine[k]
    for entry in range(system.first[block], system.first[block + 1]):
        j = system.column[entry]
        needed += system.stiffness[entry] * work.x[j, k] + system.damping[entry] * work.w[j, k]
    return needed


@kernel(inline=True)
def step_length(system: BlockSystem, motion: BlockMotion, work: BlockWork, rtol: float) -> float:
    """Step after which the last two terms of every series are below `rtol`; inf if none slips."""
    if work.n_active[0] == 0 and not system.forced:
        return math.inf
    largest = 0.0
    for k in (ORDER - 1, ORDER):
        size = 0.0
        for a in range(work.n_active[0]):
            i = work.active[a]
            size = max(size, abs(work.w[i, k]))
            if math.isnan(work.w[i, k]):
                return math.nan
        if system.forced:
            size = max(size, abs(work.cosine[k]) + abs(work.sine[k]))
        if size > 0.0:
            largest = max(largest, math.exp(math.log(size / rtol) / k))
    return min(LONGEST_STEP, 1.0 / largest) if largest > 0.0 else LONGEST_STEP


# --- events -----------------------------------------------------------------------------------


@kernel(inline=True)
def stay_on_pieces(laws: Floats, motion: BlockMotion, work: BlockWork, h: float) -> float:
    """Length of a step on which all laws stay smooth, at most `h`; <= 0 if a search failed."""
    if laws.shape[0] > motion.mode.shape[0]:
        for a in range(work.n_active[0]):
            i = work.active[a]
            if h > 0.0:
                for k in range(ORDER + 1):
                    work.e[k] = motion.mode[i] * work.w[i, k]
                h = leaving_time(laws, i, work.e, h)
    return h


@kernel
def find_events(system: BlockSystem, motion: BlockMotion, work: BlockWork, h: float) -> float:
    """Length of the step up to its first event, or all of it; negative if a search failed."""
    # ``motion.event`` names the event of each block; events closer than rounding are one.
    motion.event[:] = 0
    for i in range(motion.mode.shape[0]):
        mode = motion.mode[i]
        if mode != 0:
            for k in range(ORDER + 1):
                work.e[k] = mode * work.w[i, k]
            t = first_contact(work.e, h, work.e[0] == 0.0, SLACK * EPSILON)
            h = keep_first(motion, i, LANDING, t, h)
        elif is_exposed(system, motion, i):
            for event in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
                ride_signal(system, motion, work, i, event)
                t = first_contact(work.e, h, work.e[0] == 0.0, SLACK * EPSILON * system.static[i])
                h = keep_first(motion, i, event, t, h)
        else:
            growth = loading_rate(system, motion, work.rates, i)
            event = AT_UPPER_LIMIT if growth > 0.0 else AT_LOWER_LIMIT
            side = 1.0 if growth > 0.0 else -1.0
            if growth != 0.0:
                t = max((side * system.static[i] - motion.e[i]) / growth, 0.0)
                h = keep_first(motion, i, event, t if t <= h else NO_ROOT, h)
        if h < 0.0:
            return h
    return h


@kernel(inline=True)
def is_exposed(system: BlockSystem, motion: BlockMotion, block: int) -> bool:
    """Whether the needed force of a rider is anything but a straight line."""
    if system.amplitude[block] != 0.0:
        return True
    for entry in range(system.first[block], system.first[block + 1]):
        if motion.mode[system.column[entry]] != 0:
            return True
    return False


@kernel(inline=True)
def ride_signal(
    system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int, event: int
) -> None:
    """Distance of a rider's needed force from its upper or lower limit, a series."""
    sign = -1.0 if event == AT_UPPER_LIMIT else 1.0
    work.e[0] = system.static[block] + sign * motion.e[block]
    for k in range(1, ORDER + 1):
        work.e[k] = sign * needed_coefficient(system, work, block, k)


@kernel(inline=True)
def keep_first(motion: BlockMotion, block: int, event: int, t: float, h: float) -> float:
    """Note an event at `t` unless there is an earlier one; return the step's new length."""
    if t == NO_ROOT:
        return h
    if t == UNFINISHED:
        return t
    if h == math.inf or t < h - 2.0 * EPSILON * h:
        motion.event[:] = 0
    motion.event[block] = event
    return min(t, h)


@kernel
def watch_step(system: BlockSystem, motion: BlockMotion, work: BlockWork, h: float) -> float:
    """Smallest clearance on a step: lobes of |w| that turned back, extremes of riders."""
    margin = math.inf
    for i in range(motion.mode.shape[0]):
        mode = motion.mode[i]
        if mode != 0:
            for k in range(ORDER + 1):
                work.e[k] = mode * work.w[i, k]
            margin = min(margin, clearance(work.e, h))
        elif is_exposed(system, motion, i):
            for event in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
                ride_signal(system, motion, work, i, event)
                margin = min(margin, clearance(work.e, h))
    return margin


# --- tangents ---------------------------------------------------------------------------------


@kernel
def tangents(
    system: BlockSystem,
    laws: Floats,
    directions: BlockDirections,
    motion: BlockMotion,
    work: BlockWork,
    h: float,
) -> None:
    """Carry every tangent column over the step by its own Taylor series."""
    for a in range(work.n_active[0]):
        i = work.active[a]
        mode = motion.mode[i]
        work.rows[i, 0, ORDER] = mode * work.w[i, ORDER]
        row = piece_row(laws, i, mode * motion.w[i])
        series(laws[row], mode, work.rows[i], ORDER)
        series_tangent(laws[row], mode, work.rows[i], ORDER)
    for column in range(motion.tangent_w.shape[1]):
        tangent_series(system, directions, motion, work, column)
        for i in range(motion.mode.shape[0]):
            motion.tangent_x[i, column] = value(work.d_x[i], h)
            motion.tangent_w[i, column] = value(work.d_w[i], h)
        motion.tangent_phase[column] += directions.frequency[column] * h


@kernel
def tangent_series(
    system: BlockSystem,
    directions: BlockDirections,
    motion: BlockMotion,
    work: BlockWork,
    column: int,
) -> None:
    """Series of one tangent column: the linearised equations, driven by its direction."""
    d_x, d_w = work.d_x, work.d_w
    d_V = directions.V[column]
    for i in range(motion.mode.shape[0]):
        d_x[i] = 0.0
        d_w[i] = 0.0
        d_x[i, 0] = motion.tangent_x[i, column]
        d_w[i, 0] = motion.tangent_w[i, column]
        d_x[i, 1] = d_V
    for k in range(ORDER):
        for a in range(work.n_active[0]):
            i = work.active[a]
            pull = friction_tangent(system, directions, motion, work, i, column, k)
            pull -= needed_tangent_coefficient(system, directions, motion, work, i, column, k)
            pull -= directions.mass[column, i] * (k + 1) * work.w[i, k + 1]
            d_w[i, k + 1] = pull / (system.mass[i] * (k + 1))
        for a in range(work.n_active[0]):
            i = work.active[a]
            d_x[i, k + 1] = (d_w[i, k] + (d_V if k == 0 else 0.0)) / (k + 1)


@kernel(inline=True)
def needed_tangent_coefficient(
    system: BlockSystem,
    directions: BlockDirections,
    motion: BlockMotion,
    work: BlockWork,
    block: int,
    column: int,
    k: int,
) -> float:
    """Coefficient k of the derivative of a block's needed force."""
    change = 0.0
    varies = directions.varies[column]
    for entry in range(system.first[block], system.first[block + 1]):
        j = system.column[entry]
        d_w = work.d_w[j, k]
        if varies:
            w = work.w[j, k]
            if k == 0:
                w += system.V
                d_w += directions.V[column]
            change += directions.stiffness[column, entry] * work.x[j, k]
            change += directions.damping[column, entry] * w
        change += system.stiffness[entry] * work.d_x[j, k] + system.damping[entry] * d_w
    if system.forced:
        earlier = work.sine[k - 1] if k > 0 else 0.0
        turned = work.sine[k] * motion.tangent_phase[column]
        turned += earlier * directions.frequency[column]
        change += system.amplitude[block] * turned
        change -= directions.amplitude[column, block] * work.cosine[k]
    return change


@kernel
def friction_tangent(
    system: BlockSystem,
    directions: BlockDirections,
    motion: BlockMotion,
    work: BlockWork,
    block: int,
    column: int,
    k: int,
) -> float:
    """Coefficient k of the derivative of the force -mode limit F(mode w; parameters)."""
    mode = motion.mode[block]
    rows = work.rows[block]
    changed = 0.0
    for j in range(k + 1):
        changed += rows[SLOPE_ROW, j] * work.d_w[block, k - j]
    changed *= mode * system.static[block]
    if directions.varies[column]:
        for j in range(directions.laws.shape[2]):
            d_parameter = directions.laws[column, block, j]
            if d_parameter != 0.0:
                changed += system.static[block] * d_parameter * rows[GRADIENT_ROW + j, k]
        changed += directions.static[column, block] * rows[FORCE_ROW, k]
    return -mode * changed


# --- what the driver of a motion asks ------------------------------------------------------------


@kernel
def landing_rate(system: BlockSystem, laws: Floats, motion: BlockMotion, block: int) -> float:
    """Rate w' of a slipping block as it reaches the belt."""
    mode = motion.mode[block]
    friction = -mode * system.static[block] * static_value(laws[block], mode)
    return (friction - motion.e[block]) / system.mass[block]


@kernel
def slides_for_ever(
    system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork
) -> bool:
    """Whether blocks that all slip backward can be shown never to reach the belt again."""
    # The energy of deviations from steady sliding bounds every speed: docs/theory/blocks.md.
    n = motion.mode.shape[0]
    if system.forced:
        return False
    deviation = work.deviation
    energy = 0.0
    for i in range(n):
        if motion.mode[i] != -1:
            return False
        v = motion.w[i] + system.V
        energy += system.mass[i] * v * v
        deviation[i] = motion.e[i] - system.static[i] * force(
            laws[piece_row(laws, i, system.V)], -1, system.V
        )
        for entry in range(system.first[i], system.first[i + 1]):
            j = system.column[entry]
            deviation[i] -= system.damping[entry] * (motion.w[j] + system.V)
    for i in range(n):
        for j in range(n):
            energy += deviation[i] * system.inverse[i, j] * deviation[j]
    falls = False
    for i in range(n):
        reach = math.sqrt(energy / system.mass[i])
        if not reach < system.V * (1.0 - CLEARANCE):
            return False
        steepest = least_slope(laws, i, system.V - reach, system.V + reach)
        work.deviation[i] = system.static[i] * steepest
        falls = falls or steepest < 0.0
    return damping_outweighs(system, work) if falls else True


@kernel
def damping_outweighs(system: BlockSystem, work: BlockWork) -> bool:
    """Whether C plus the slopes in ``work.deviation`` is positive definite (by Cholesky)."""
    factor = work.factor
    for i in range(factor.shape[0]):
        factor[i] = 0.0
        for entry in range(system.first[i], system.first[i + 1]):
            factor[i, system.column[entry]] = system.damping[entry]
        factor[i, i] += work.deviation[i]
        for j in range(i + 1):
            rest = factor[i, j]
            for k in range(j):
                rest -= factor[i, k] * factor[j, k]
            if j < i:
                factor[i, j] = rest / factor[j, j]
            elif not rest > 0.0:
                return False
            else:
                factor[i, i] = math.sqrt(rest)
    return True
