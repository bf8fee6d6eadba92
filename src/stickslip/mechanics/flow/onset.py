"""The onset of a slip: how a global stick phase ends."""

from __future__ import annotations

from stickslip.mechanics.flow.system import (
    ALPHA,
    BACKWARD,
    BETA,
    START,
    STICK,
    Motion,
    System,
    put_exactly,
)
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel


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
