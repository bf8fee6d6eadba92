"""Adaptive engine, traced laws: Taylor series of high order, whose polynomials locate events."""

# Template (`numerics.targets.instantiate`): a law's kernels are bound. Derivation:
# docs/theory/flow.md.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.flow.dense import (
    FORCE_ROUNDING,
    MOST_HALVINGS,
    OFF,
    OVERLAP,
    PLACES,
    at_place,
    find_events,
    is_followed,
    piece_row,
    stay_on_pieces,
    watch_step,
)
from stickslip.mechanics.flow.saltation import saltation
from stickslip.mechanics.flow.system import (
    ALPHA,
    BETA,
    LANDING,
    LAWS,
    VELOCITY,
    Floats,
    Motion,
    System,
    TaylorWork,
    law_parameters,
    limit,
    loading_rate,
)
from stickslip.mechanics.flow.transitions import excess_force, round_landings
from stickslip.numerics.polynomial import value, value_sharp
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.rounding import two_product, two_sum
from stickslip.numerics.targets import kernel
from stickslip.status import LAW_FAILED, OK, STEP_FAILED

if TYPE_CHECKING:
    from stickslip.mechanics.friction.interface import (
        FORCE_ROW,
        GRADIENT_ROW,
        N_ROWS,
        SLOPE_ROW,
        force,
        force_sharp,
        series,
        series_tangent,
        slope,
    )

ORDER = 22
# Of tangents that only tell whether turns contract (`eventmap.loop`): to 8 digits and more.
LOOP_ORDER = 8
# No step is longer: a Taylor polynomial that happens to end early says nothing beyond.
LONGEST_STEP = 1.0
# What is left of a step to its event is a rounding of its length; at a touch it is not.
LARGEST_REST = 1e-9
# Of `rtol`, what the last two terms of a series may add: steps would all err to one side.
SHARE = 0.01
# Coefficients that are kept as sums of two: with longer steps the next ones matter little.
N_SHARP = 4


def new_work() -> TaylorWork:
    """Scratch arrays for one motion."""
    n = ORDER + 1
    return TaylorWork(
        w=np.zeros((2, n)),
        e=np.zeros((2, n)),
        rows=np.zeros((2, N_ROWS, n)),
        signal=np.zeros(n),
        w_low=np.zeros((2, N_SHARP)),
        e_low=np.zeros((2, N_SHARP)),
        d_w=np.zeros((2, n)),
        d_e=np.zeros((2, n)),
        margin=np.full(1, np.inf),
        watch=np.zeros(1),
        sliding=np.zeros(1),
    )


@kernel(short_loops=True)
def advance(
    system: System, laws: Floats, motion: Motion, work: TaylorWork, rtol: float, cap: float
) -> tuple[float, int]:
    """Take one step, up to an event if one comes; return its length and a status."""
    expand(system, laws, motion, work)
    h = min(step_length(motion, work, rtol), cap)  # NaN stays
    if not h > 0.0:
        return 0.0, LAW_FAILED if math.isnan(h) else STEP_FAILED
    h = stay_on_pieces(laws, motion, work.w, work.signal, h)
    if not h > 0.0:
        return 0.0, STEP_FAILED
    h = find_events(system, motion, work.w, work.e, work.signal, h)
    if h < 0.0:
        return 0.0, STEP_FAILED
    for _ in range(MOST_HALVINGS):
        if follows_laws(system, laws, motion, work, h, rtol):
            break
        h = find_events(system, motion, work.w, work.e, work.signal, 0.5 * h)
        if h < 0.0:
            return 0.0, STEP_FAILED
    if work.watch[0] != 0.0:
        margin = watch_step(system, motion, work.w, work.e, work.signal, h)
        work.margin[0] = min(work.margin[0], margin)
    if motion.directions.shape[0] > 0:
        tangents(system, laws, motion, work, h)
    move(system, laws, motion, work, h)
    if motion.event[0] != 0 or motion.event[1] != 0:
        rate_1, rate_2 = rate(system, laws, motion, 0), rate(system, laws, motion, 1)
        move_to_event(system, motion, rate_1, rate_2)
        round_landings(system, motion, FORCE_ROUNDING)
        saltation(system, motion, rate_1, rate_2)
    return h, OK


@kernel
def move(system: System, laws: Floats, motion: Motion, work: TaylorWork, h: float) -> None:
    """Carry the state over a step, as sums of two doubles."""
    left_out(system, laws, motion, work)
    for block in range(2):
        if motion.mode[block] != 0:
            motion.w[block], motion.w_low[block] = value_sharp(work.w[block], work.w_low[block], h)
        motion.e[block], motion.e_low[block] = value_sharp(work.e[block], work.e_low[block], h)


@kernel
def left_out(system: System, laws: Floats, motion: Motion, work: TaylorWork) -> None:
    """Find what the first coefficients of the series leave out: `expand` in sums of two."""
    for block in range(2):
        work.w_low[block] = 0.0
        work.w_low[block, 0] = motion.w_low[block]
        work.e_low[block, 0] = motion.e_low[block]
    for k in range(N_SHARP - 1):
        for block in range(2):
            if motion.mode[block] != 0:
                friction, low = friction_sharp(laws, motion, work, block, k)
                rest = pull_left_out(system, motion, work, block, k, friction, low)
                work.w_low[block, k + 1] = rest
        for block in range(2):
            work.e_low[block, k + 1] = loading_left_out(system, work, block, k)


@kernel(inline=True)
def friction_sharp(
    laws: Floats, motion: Motion, work: TaylorWork, block: int, k: int
) -> tuple[float, float]:
    """Coefficient k of F as a sum of two; beyond the first only what w leaves out counts."""
    mode = motion.mode[block]
    s, low = mode * work.w[block, 0], mode * work.w_low[block, k]
    law = laws[piece_row(laws, block, s)]
    if k == 0:
        return force_sharp(law, mode, s, low)
    return work.rows[block, FORCE_ROW, k], slope(law, mode, s) * low


@kernel(inline=True)
def pull_left_out(
    system: System,
    motion: Motion,
    work: TaylorWork,
    block: int,
    k: int,
    friction: float,
    friction_low: float,
) -> float:
    """Coefficient k + 1 of w: what it leaves out."""
    mode, end = motion.mode[block], limit(system, block)
    w, e = work.w[block], work.e[block]
    if k == 0 and w[0] == 0.0 and w[1] == 0.0:
        return 0.0
    held, held_low = two_product(end, friction)
    pull, rest = two_sum(-mode * held, -e[k])
    rest -= mode * (held_low + end * friction_low) + work.e_low[block, k]
    known, known_low = two_product(k + 1.0, w[k + 1])
    return ((pull - known) - known_low + rest) / (k + 1)


@kernel(inline=True)
def loading_left_out(system: System, work: TaylorWork, block: int, k: int) -> float:
    """Coefficient k + 1 of e: what it leaves out."""
    w, w_low = work.w[block, k], work.w_low[block, k]
    gap, gap_low = two_sum(w, -work.w[1 - block, k])
    gap_low += w_low - work.w_low[1 - block, k]
    coupled, coupled_low = two_product(system.alpha, gap)
    loading, rest = two_sum(w, coupled)
    loading, more = two_sum(loading, system.V if k == 0 else 0.0)
    rest += more + coupled_low + system.alpha * gap_low + w_low
    known, known_low = two_product(k + 1.0, work.e[block, k + 1])
    return ((loading - known) - known_low + rest) / (k + 1)


@kernel
def move_to_event(system: System, motion: Motion, rate_1: float, rate_2: float) -> None:
    """Move the state from the end of a step to its event, linearly; `rate_1`, `rate_2`: w'."""
    for block in range(2):
        event = motion.event[block]
        if event == 0:
            continue
        if event == LANDING:
            gap = motion.w[block] + motion.w_low[block]
            speed = rate_1 if block == 0 else rate_2
        else:
            gap = excess_force(system, motion, block)
            loading = loading_rate(system, motion.w, block)
            speed = loading if motion.e[block] > 0.0 else -loading
        if abs(gap) < LARGEST_REST * abs(speed):
            rest = -gap / speed
            loading_1 = loading_rate(system, motion.w, 0)
            loading_2 = loading_rate(system, motion.w, 1)
            motion.w_low[0] += rest * rate_1
            motion.w_low[1] += rest * rate_2
            motion.e_low[0] += rest * loading_1
            motion.e_low[1] += rest * loading_2
        return


@kernel
def rate(system: System, laws: Floats, motion: Motion, block: int) -> float:
    """Rate w' of a block in its mode."""
    mode = motion.mode[block]
    if mode == 0:
        return 0.0
    s = max(mode * motion.w[block], 0.0)
    return (
        -mode * limit(system, block) * force(laws[piece_row(laws, block, s)], mode, s)
        - motion.e[block]
    )


@kernel(inline=True)
def expand(system: System, laws: Floats, motion: Motion, work: TaylorWork) -> None:
    """Taylor series of the state: (k + 1) w_{k+1} = -mode limit F_k - e_k, and e from w."""
    w, e = work.w, work.e
    for block in range(2):
        w[block, 0] = motion.w[block]
        e[block, 0] = motion.e[block]
        if motion.mode[block] == 0:
            w[block] = 0.0
    for k in range(ORDER):
        for block in range(2):
            mode = motion.mode[block]
            if mode != 0:
                work.rows[block, 0, k] = mode * w[block, k]
                row = piece_row(laws, block, mode * motion.w[block])
                series(laws[row], mode, work.rows[block], k)
                pull = -mode * limit(system, block) * work.rows[block, FORCE_ROW, k] - e[block, k]
                if k == 0 and w[block, 0] == 0.0:
                    # F(0) = 1: a slip starts at a double root
                    if abs(pull) <= 4.0 * EPSILON * limit(system, block):
                        pull = 0.0
                w[block, k + 1] = pull / (k + 1)
        drive = system.V if k == 0 else 0.0
        for block in range(2):
            loading = (1.0 + system.alpha) * w[block, k] - system.alpha * w[1 - block, k] + drive
            e[block, k + 1] = loading / (k + 1)


@kernel
def follows_laws(
    system: System, laws: Floats, motion: Motion, work: TaylorWork, h: float, rtol: float
) -> bool:
    """Whether the series of both laws are those of the laws, as far as places on a step tell."""
    for block in range(2):
        mode = motion.mode[block]
        if mode == 0:
            continue
        row = piece_row(laws, block, mode * motion.w[block])
        most = OFF * rtol / (limit(system, block) * h)
        for k in range(1, PLACES + 1):
            s, told = at_place(k, h, mode, work.w[block], work.rows[block, FORCE_ROW, :ORDER])
            exact = force(laws[row], mode, max(s, 0.0))
            if s >= -OVERLAP and not is_followed(exact, told, most):
                return False
    return True


@kernel(inline=True)
def step_length(motion: Motion, work: TaylorWork, rtol: float) -> float:
    """Step after which the last two terms of every series are below their `SHARE` of `rtol`."""
    h = LONGEST_STEP
    for block in range(2):
        if motion.mode[block] == 0:
            continue
        for k in (ORDER - 1, ORDER):
            size = max(abs(work.w[block, k]), abs(work.e[block, k]))
            if math.isnan(size):
                return math.nan
            if size > 0.0:
                h = min(h, math.exp(math.log(SHARE * rtol / size) / k))
    return h


@kernel
def tangents(system: System, laws: Floats, motion: Motion, work: TaylorWork, h: float) -> None:
    """Carry every tangent column over the step by its own Taylor series."""
    varied = varies_laws(motion)
    most = 0
    for column in range(motion.directions.shape[0]):
        most = max(most, order_of(motion, column))
    for block in range(2):
        mode = motion.mode[block]
        if mode != 0:
            row = piece_row(laws, block, mode * motion.w[block])
            if most == ORDER:
                work.rows[block, 0, ORDER] = mode * work.w[block, ORDER]
                series(laws[row], mode, work.rows[block], ORDER)
            series_tangent(laws[row], mode, work.rows[block], most, varied)
    for column in range(motion.directions.shape[0]):
        order = order_of(motion, column)
        if order == 0:
            continue
        tangent_series(system, motion, work, column, order, varied)
        for block in range(2):
            motion.tangent_w[block, column] = value(work.d_w[block, : order + 1], h)
            motion.tangent_e[block, column] = value(work.d_e[block, : order + 1], h)


@kernel(inline=True)
def varies_laws(motion: Motion) -> bool:
    """Whether a parameter of a law changes in some direction."""
    for column in range(motion.directions.shape[0]):
        for k in range(LAWS, motion.directions.shape[1]):
            if motion.directions[column, k] != 0.0:
                return True
    return False


@kernel(inline=True)
def order_of(motion: Motion, column: int) -> int:
    """Order of a tangent's series; 0 if nothing changes: of a loop, what its section has not."""
    for k in range(motion.directions.shape[1]):
        if motion.directions[column, k] != 0.0:
            return ORDER
    for j in range(4):
        if motion.tangent_z[j, column] != 0.0:
            return LOOP_ORDER
    return 0


@kernel
def tangent_series(
    system: System, motion: Motion, work: TaylorWork, column: int, order: int, varied: bool
) -> None:
    """Series of one tangent column: the linearised equations, driven by its direction."""
    d_w, d_e = work.d_w, work.d_e
    direction = motion.directions[column]
    for block in range(2):
        d_w[block] = 0.0
        d_w[block, 0] = motion.tangent_w[block, column]
        d_e[block, 0] = motion.tangent_e[block, column]
    for k in range(order):
        for block in range(2):
            if motion.mode[block] != 0:
                pull = friction_tangent(system, motion, work, direction, block, k, varied)
                d_w[block, k + 1] = (pull - d_e[block, k]) / (k + 1)
        d_drive = direction[VELOCITY] if k == 0 else 0.0
        for block in range(2):
            loading = (1.0 + system.alpha) * d_w[block, k] - system.alpha * d_w[1 - block, k]
            loading += direction[ALPHA] * (work.w[block, k] - work.w[1 - block, k])
            d_e[block, k + 1] = (loading + d_drive) / (k + 1)


@kernel
def friction_tangent(
    system: System,
    motion: Motion,
    work: TaylorWork,
    direction: Floats,
    block: int,
    k: int,
    varied: bool,
) -> float:
    """Give coefficient k of the derivative of the force -mode limit F(mode w; parameters)."""
    mode = motion.mode[block]
    rows = work.rows[block]
    changed = 0.0
    for i in range(k):  # upwards: only the last term waits for the newest coefficient
        changed += rows[SLOPE_ROW, k - i] * work.d_w[block, i]
    changed = mode * (changed + rows[SLOPE_ROW, 0] * work.d_w[block, k])
    n = law_parameters(motion) if varied else 0
    for j in range(n):
        d_parameter = direction[LAWS + block * n + j]
        if d_parameter != 0.0:
            changed += d_parameter * rows[GRADIENT_ROW + j, k]
    grown = direction[BETA] * block * rows[FORCE_ROW, k]
    return -mode * (limit(system, block) * changed + grown)
