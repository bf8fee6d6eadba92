"""Transitions: the onset of a slip, modes that blocks take at an event, tangents through events."""

# Rules 1, 2, 3 and 5 of docs/design.md. Tangents at an event are those at fixed time plus the
# state's velocity times the event's shift, ``-(d g) / g'`` with ``g`` the signal that reaches zero.

from __future__ import annotations

import math

from stickslip.mechanics.flow.system import (
    ALPHA,
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    BETA,
    FORWARD,
    LANDING,
    START,
    STICK,
    Motion,
    System,
    limit,
    loading_rate,
    put_exactly,
)
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel


@kernel(inline=True)
def excess_force(system: System, motion: Motion, block: int) -> float:
    """How far the needed force of a block is beyond its static limit; negative inside."""
    sign = 1.0 if motion.e[block] > 0.0 else -1.0
    return (sign * motion.e[block] - limit(system, block)) + sign * motion.e_low[block]


@kernel(inline=True)
def round_to_limit(system: System, motion: Motion, block: int, rounding: float) -> None:
    """Put a needed force on its static limit where `rounding`, in EPSILON x limit, explains it."""
    # Otherwise chance would break ties that the system has by its symmetry.
    end = limit(system, block)
    if abs(excess_force(system, motion, block)) <= rounding * EPSILON * end:
        motion.e[block] = math.copysign(end, motion.e[block])
        motion.e_low[block] = 0.0


@kernel(inline=True)
def round_landings(system: System, motion: Motion, rounding: float) -> None:
    """Call `round_to_limit` for the blocks that land."""
    for block in range(2):
        if motion.event[block] == LANDING:
            round_to_limit(system, motion, block, rounding)


@kernel(inline=True)
def mode_on_belt(system: System, motion: Motion, block: int) -> int:
    """Mode of a block whose relative velocity is zero: rule 2."""
    excess = excess_force(system, motion, block)
    upper = motion.e[block] > 0.0
    rate = loading_rate(system, motion.w, block)
    inward = rate <= 0.0 if upper else rate >= 0.0
    if excess < 0.0 or (excess == 0.0 and inward):
        return STICK
    return BACKWARD if upper else FORWARD


@kernel(inline=True)
def release(system: System, motion: Motion, block: int, mode: int) -> None:
    """Let a riding block go: it stands exactly at its limit, which depends on beta alone."""
    end = limit(system, block)
    motion.mode[block] = mode
    put_exactly(motion, block, 0.0, -mode * end)
    for column in range(motion.directions.shape[0]):
        motion.tangent_w[block, column] = 0.0
        motion.tangent_e[block, column] = -mode * motion.directions[column, BETA] * block


@kernel(inline=True)
def land(system: System, motion: Motion, block: int) -> None:
    """Put a slipping block on the belt and give it the mode that its needed force asks for."""
    motion.w[block] = motion.w_low[block] = 0.0
    for column in range(motion.directions.shape[0]):
        motion.tangent_w[block, column] = 0.0
    motion.mode[block] = mode_on_belt(system, motion, block)


@kernel(inline=True)
def settle(system: System, motion: Motion) -> None:
    """Change the modes of all blocks that are at an event, once."""
    # Landings come first: they end the motion of w that the rates depend on.
    for block in range(2):
        if motion.event[block] == LANDING:
            motion.w[block] = 0.0
    for block in range(2):
        if motion.event[block] == LANDING:
            land(system, motion, block)
    for block in range(2):
        if motion.event[block] == AT_UPPER_LIMIT:
            release(system, motion, block, BACKWARD)
        elif motion.event[block] == AT_LOWER_LIMIT:
            release(system, motion, block, FORWARD)


@kernel(inline=True)
def onset(system: System, motion: Motion, d: float) -> None:
    """End of the global stick phase with ``X_2 - X_1 = d`` (eq. 6a): who slips, and from where."""
    end = (1.0 + system.beta) / (1.0 + 2.0 * system.alpha)
    d = min(max(d, -end), end)
    spread = (1.0 + 2.0 * system.alpha) * d  # e_2 - e_1
    lead = 1.0 + spread - system.beta  # how far block 2 is past its limit as block 1 leaves
    tie = abs(lead) <= 4.0 * EPSILON * (1.0 + abs(spread) + system.beta)
    first = lead < 0.0 or tie
    second = lead > 0.0 or tie
    motion.mode[0] = BACKWARD if first else STICK
    motion.mode[1] = BACKWARD if second else STICK
    put_exactly(motion, 0, 0.0, 1.0 if first else max(system.beta - spread, -1.0))
    put_exactly(motion, 1, 0.0, system.beta if second else max(1.0 + spread, -system.beta))
    for column in range(motion.directions.shape[0]):
        direction = motion.directions[column]
        d_spread = (1.0 + 2.0 * system.alpha) * direction[START] + 2.0 * d * direction[ALPHA]
        motion.tangent_w[0, column] = motion.tangent_w[1, column] = 0.0
        motion.tangent_e[0, column] = 0.0 if first else direction[BETA] - d_spread
        motion.tangent_e[1, column] = direction[BETA] if second else d_spread
