"""Tangents through events: the saltation matrix."""

from __future__ import annotations

from stickslip.mechanics.flow.system import (
    AT_UPPER_LIMIT,
    BETA,
    LANDING,
    Motion,
    System,
    limit,
    loading_rate,
)
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel


@kernel
def saltation(system: System, motion: Motion, rate_w_1: float, rate_w_2: float) -> None:
    """Move the tangents to the event that ``motion.event`` names, if any."""
    # `rate_w`: w' just before. The first block with an event sets the time; at a touch (rate 0)
    # nothing is moved.
    for block in range(2):
        event = motion.event[block]
        if event == 0:
            continue
        rate_w = rate_w_1 if block == 0 else rate_w_2
        rate = rate_w if event == LANDING else loading_rate(system, motion.w, block)
        if abs(rate) <= 8.0 * EPSILON * limit(system, block):
            continue
        rate_e_1 = loading_rate(system, motion.w, 0)
        rate_e_2 = loading_rate(system, motion.w, 1)
        side = 1.0 if event == AT_UPPER_LIMIT else -1.0
        for column in range(motion.directions.shape[0]):
            if event == LANDING:
                shift = -motion.tangent_w[block, column] / rate
            else:
                moved = side * motion.directions[column, BETA] * block
                shift = (moved - motion.tangent_e[block, column]) / rate
            motion.tangent_w[0, column] += rate_w_1 * shift
            motion.tangent_w[1, column] += rate_w_2 * shift
            motion.tangent_e[0, column] += rate_e_1 * shift
            motion.tangent_e[1, column] += rate_e_2 * shift
        return
