"""Adaptive engine, laws known by their values only: collocation, solved by Picard sweeps."""

# A template like ``_taylor_kernels``, with the same interface. Accelerations are a polynomial
# through Chebyshev nodes. A law is never called at s < 0: its tangent at 0 stands there, and a step
# with an event is repeated until it ends close to the event.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.dense import (
    FORCE_ROUNDING,
    find_events,
    piece_row,
    stay_on_pieces,
    watch_step,
)
from stickslip.mechanics.flow.saltation import saltation
from stickslip.mechanics.flow.system import (
    ALPHA,
    BETA,
    LAWS,
    VELOCITY,
    CollocationWork,
    Floats,
    Motion,
    System,
    law_parameters,
    limit,
)
from stickslip.mechanics.flow.transitions import round_landings
from stickslip.numerics import collocation
from stickslip.numerics.polynomial import value
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.status import LAW_FAILED, OK, STEP_FAILED

if TYPE_CHECKING:
    from stickslip.mechanics.friction.interface import (
        N_PARAMETERS,
        force,
        force_continued,
        gradient,
        slope,
    )

Rows = NDArray[np.float64]

DEGREE = 12
LONGEST_STEP = 0.5
# A step this short is taken whatever its error: the law has a kink there.
SHORTEST_STEP = 1e-9
MAX_SWEEPS = 60
# Change of a sweep, in units of EPSILON, after which the next would change nothing.
CONVERGED = 4.0
# Part of a step by which it may overshoot its event.
OVERSHOOT = 1e-8
INTEGRATE = collocation.integration(DEGREE)
COEFFICIENTS = collocation.to_coefficients(DEGREE)
POWERS = collocation.shifted_chebyshev(DEGREE)


def new_work() -> CollocationWork:
    """Scratch arrays for one motion."""
    powers = (2, DEGREE + 3)
    values = (2, DEGREE + 1)
    return CollocationWork(
        w=np.zeros(powers),
        e=np.zeros(powers),
        node_w=np.zeros(values),
        node_e=np.zeros(values),
        node_a=np.zeros(values),
        d_node_w=np.zeros(values),
        d_node_e=np.zeros(values),
        d_node_a=np.zeros(values),
        d_w=np.zeros(powers),
        d_e=np.zeros(powers),
        signal=np.zeros(DEGREE + 3),
        gradient=np.zeros(max(N_PARAMETERS, 1)),
        length=np.full(1, LONGEST_STEP),
        margin=np.full(1, np.inf),
        watch=np.zeros(1),
        sliding=np.zeros(1),
    )


@kernel(short_loops=True)
def advance(
    system: System, laws: Floats, motion: Motion, work: CollocationWork, rtol: float, cap: float
) -> tuple[float, int]:
    """Take one step, up to an event if one comes; return its length and a status."""
    if work.sliding[0] == 0.0:
        work.length[0] = LONGEST_STEP  # steps must not depend on the motion before this one
    h = min(cap, work.length[0])
    for _ in range(200):
        error = sweep_to_rest(system, laws, motion, work, h)
        if math.isnan(error):
            return 0.0, LAW_FAILED
        if error > 4.0 * rtol and h > SHORTEST_STEP:
            factor = 0.5 if math.isinf(error) else 0.9 * (rtol / error) ** (1.0 / DEGREE)
            h *= min(0.8, max(0.2, factor))
            continue
        growth = (rtol / max(error, 1e-3 * rtol)) ** (1.0 / DEGREE)
        work.length[0] = min(LONGEST_STEP, h * min(2.0, max(0.5, 0.95 * growth)))
        polynomials(system, motion, work, h)
        end = stay_on_pieces(laws, motion, work.w, work.signal, h)
        if not end > 0.0:
            return 0.0, STEP_FAILED
        end = find_events(system, motion, work.w, work.e, work.signal, end)
        if end < 0.0:
            return 0.0, STEP_FAILED
        if (motion.event[0] != 0 or motion.event[1] != 0) and h - end > OVERSHOOT * h:
            h = end * (1.0 + 0.5 * OVERSHOOT)
            if end > 0.0:
                continue
        return finish(system, laws, motion, work, h, end), OK
    return 0.0, STEP_FAILED


@kernel
def finish(
    system: System, laws: Floats, motion: Motion, work: CollocationWork, h: float, end: float
) -> float:
    """Move state and tangents to the end of a step of collocation length `h`."""
    if work.watch[0] != 0.0:
        margin = watch_step(system, motion, work.w, work.e, work.signal, end)
        work.margin[0] = min(work.margin[0], margin)
    if motion.directions.shape[0] > 0:
        tangents(system, laws, motion, work, h, end)
    for block in range(2):
        if motion.mode[block] != 0:
            motion.w[block] = value(work.w[block], end)
        motion.e[block] = value(work.e[block], end)
    round_landings(system, motion, FORCE_ROUNDING)
    if motion.directions.shape[0] > 0:
        saltation(system, motion, rate(system, laws, motion, 0), rate(system, laws, motion, 1))
    work.sliding[0] += end
    return end


@kernel
def acceleration(
    system: System, laws: Floats, motion: Motion, block: int, w: float, e: float
) -> float:
    """Rate w' of a block at relative velocity `w` and needed force `e` on its present piece."""
    mode = motion.mode[block]
    if mode == 0:
        return 0.0
    end = limit(system, block)
    row = piece_row(laws, block, mode * motion.w[block])
    pull = -mode * end * force_continued(laws[row], mode, mode * w) - e
    if w == 0.0 and abs(pull) <= 4.0 * EPSILON * end:
        return 0.0  # F(0) = 1: a slip starts at a double root
    return pull


@kernel
def rate(system: System, laws: Floats, motion: Motion, block: int) -> float:
    """Rate w' of a block in its mode."""
    return acceleration(system, laws, motion, block, motion.w[block], motion.e[block])


@kernel
def integrate_loading(
    system: System, node_w: Rows, node_e: Rows, start: Floats, drive: float, h: float
) -> None:
    """Needed forces at the nodes from relative velocities there: integral of e'."""
    for block in range(2):
        for i in range(DEGREE + 1):
            total = 0.0
            for j in range(DEGREE + 1):
                own = (1.0 + system.alpha) * node_w[block, j]
                total += INTEGRATE[i, j] * (own - system.alpha * node_w[1 - block, j] + drive)
            node_e[block, i] = start[block] + h * total


@kernel
def sweep_to_rest(
    system: System, laws: Floats, motion: Motion, work: CollocationWork, h: float
) -> float:
    """Solve the step by Picard sweeps; return its error, inf without convergence, NaN of a law."""
    for block in range(2):
        for i in range(DEGREE + 1):
            work.node_w[block, i] = motion.w[block]
    for _ in range(MAX_SWEEPS):
        integrate_loading(system, work.node_w, work.node_e, motion.e, system.V, h)
        change = size = 0.0
        for block in range(2):
            if motion.mode[block] == 0:
                continue
            for i in range(DEGREE + 1):
                work.node_a[block, i] = acceleration(
                    system, laws, motion, block, work.node_w[block, i], work.node_e[block, i]
                )
            for i in range(DEGREE + 1):
                total = 0.0
                for j in range(DEGREE + 1):
                    total += INTEGRATE[i, j] * work.node_a[block, j]
                new = motion.w[block] + h * total
                if math.isnan(new):
                    return math.nan
                change = max(change, abs(new - work.node_w[block, i]))
                size = max(size, abs(new), h * abs(work.node_a[block, i]))
                work.node_w[block, i] = new
        if change <= CONVERGED * EPSILON * size:
            integrate_loading(system, work.node_w, work.node_e, motion.e, system.V, h)
            return truncation(motion, work, h)
    return math.inf


@kernel
def truncation(motion: Motion, work: CollocationWork, h: float) -> float:
    """Error of a step: what the last two Chebyshev coefficients of w' add to w."""
    error = 0.0
    for block in range(2):
        if motion.mode[block] == 0:
            continue
        for k in (DEGREE - 1, DEGREE):
            total = 0.0
            for j in range(DEGREE + 1):
                total += COEFFICIENTS[k, j] * work.node_a[block, j]
            error = max(error, abs(total) * h / DEGREE)
    return error


@kernel
def polynomials(system: System, motion: Motion, work: CollocationWork, h: float) -> None:
    """State as polynomials in powers of time, from the accelerations at the nodes."""
    to_polynomial(work.node_a, work.signal, work.w, motion.w, h)
    for block in range(2):
        if motion.mode[block] == 0:
            for k in range(DEGREE + 3):
                work.w[block, k] = 0.0
    loading_polynomial(system, work.w, work.e, motion.e, system.V)


@kernel
def to_polynomial(node_a: Rows, scratch: Floats, w: Rows, start: Floats, h: float) -> None:
    """Integral of a function given at the nodes, in powers of time."""
    for block in range(2):
        for k in range(DEGREE + 1):
            scratch[k] = 0.0
            for j in range(DEGREE + 1):
                scratch[k] += COEFFICIENTS[k, j] * node_a[block, j]
        w[block, 0] = start[block]
        w[block, 1] = node_a[block, 0]  # exact, also where a slip starts at a double root
        scale = 1.0
        for k in range(1, DEGREE + 1):
            total = 0.0
            for j in range(k, DEGREE + 1):
                total += POWERS[k, j] * scratch[j]
            scale /= h
            w[block, k + 1] = total * scale / (k + 1)
        w[block, DEGREE + 2] = 0.0


@kernel
def loading_polynomial(system: System, w: Rows, e: Rows, start: Floats, drive: float) -> None:
    """Needed forces in powers of time from relative velocities."""
    for block in range(2):
        e[block, 0] = start[block]
        for k in range(DEGREE + 2):
            own = (1.0 + system.alpha) * w[block, k]
            constant = drive if k == 0 else 0.0
            e[block, k + 1] = (own - system.alpha * w[1 - block, k] + constant) / (k + 1)


@kernel
def tangents(
    system: System, laws: Floats, motion: Motion, work: CollocationWork, h: float, end: float
) -> None:
    """Carry every tangent column over the step: the linearised equations at the same nodes."""
    for column in range(motion.directions.shape[0]):
        sweep_tangent(system, laws, motion, work, column, h)
        start = motion.tangent_w[:, column]
        to_polynomial(work.d_node_a, work.signal, work.d_w, start, h)
        d_drive = motion.directions[column, VELOCITY]
        loading_polynomial(system, work.d_w, work.d_e, motion.tangent_e[:, column], d_drive)
        d_alpha = motion.directions[column, ALPHA]
        for block in range(2):
            for k in range(DEGREE + 2):
                spread = work.w[block, k] - work.w[1 - block, k]
                work.d_e[block, k + 1] += d_alpha * spread / (k + 1)
        for block in range(2):
            motion.tangent_w[block, column] = value(work.d_w[block], end)
            motion.tangent_e[block, column] = value(work.d_e[block], end)


@kernel
def sweep_tangent(
    system: System, laws: Floats, motion: Motion, work: CollocationWork, column: int, h: float
) -> None:
    """Solve the linearised step for one column by Picard sweeps."""
    direction = motion.directions[column]
    for block in range(2):
        for i in range(DEGREE + 1):
            work.d_node_w[block, i] = motion.tangent_w[block, column]
            work.d_node_a[block, i] = 0.0
    for _ in range(MAX_SWEEPS):
        change = size = 0.0
        for block in range(2):
            for i in range(DEGREE + 1):
                total = 0.0
                for j in range(DEGREE + 1):
                    loading = (1.0 + system.alpha) * work.d_node_w[block, j]
                    loading -= system.alpha * work.d_node_w[1 - block, j]
                    spread = work.node_w[block, j] - work.node_w[1 - block, j]
                    loading += direction[ALPHA] * spread + direction[VELOCITY]
                    total += INTEGRATE[i, j] * loading
                work.d_node_e[block, i] = motion.tangent_e[block, column] + h * total
        for block in range(2):
            if motion.mode[block] == 0:
                continue
            for i in range(DEGREE + 1):
                pull = friction_tangent(system, laws, motion, work, direction, block, i)
                work.d_node_a[block, i] = pull - work.d_node_e[block, i]
            for i in range(DEGREE + 1):
                total = 0.0
                for j in range(DEGREE + 1):
                    total += INTEGRATE[i, j] * work.d_node_a[block, j]
                new = motion.tangent_w[block, column] + h * total
                change = max(change, abs(new - work.d_node_w[block, i]))
                size = max(size, abs(new), abs(work.d_node_e[block, i]))
                work.d_node_w[block, i] = new
        if change <= CONVERGED * EPSILON * size:
            return


@kernel
def friction_tangent(
    system: System,
    laws: Floats,
    motion: Motion,
    work: CollocationWork,
    direction: Floats,
    block: int,
    node: int,
) -> float:
    """Differentiate the friction force -mode limit F(mode w; parameters) at a node."""
    mode = motion.mode[block]
    s = max(mode * work.node_w[block, node], 0.0)
    row = piece_row(laws, block, mode * motion.w[block])
    changed = slope(laws[row], mode, s) * mode * work.d_node_w[block, node]
    n = law_parameters(motion)
    wanted = False
    for j in range(n):
        wanted = wanted or direction[LAWS + block * n + j] != 0.0
    if wanted:
        gradient(laws[row], mode, s, work.gradient)
        for j in range(n):
            changed += direction[LAWS + block * n + j] * work.gradient[j]
    grown = direction[BETA] * block * force(laws[row], mode, s)
    return -mode * (limit(system, block) * changed + grown)
