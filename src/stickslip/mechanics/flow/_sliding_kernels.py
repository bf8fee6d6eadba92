"""What the driver of a motion asks of a law: rates at landings, and whether sliding ever ends."""

# A template; the steppers of the adaptive engine offer these kernels with their own.

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stickslip.mechanics.flow.dense import piece_row
from stickslip.mechanics.flow.system import Floats, Motion, System, limit
from stickslip.mechanics.friction.interface import NEXT_PIECE_COLUMN, PIECE_END_COLUMN
from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.mechanics.friction.interface import force, slope, static_value

# What has to be left of V for a proof: more than rounding adds up to in a million steps. (Just
# after a release the bounds are V or more, and without damping they would stay so.)
CLEARANCE = 1e-6


@kernel
def energy_reach(system: System, motion: Motion, force_1: float, force_2: float) -> float:
    """Largest deviation from steady sliding that the energy of two slipping blocks allows."""
    # ``(y.y + r.K^-1 r) / 2``, y = w + V, r = e - limit F(V), cannot grow while F rises with speed.
    y_1 = motion.w[0] + system.V
    y_2 = motion.w[1] + system.V
    r_1 = motion.e[0] - force_1
    r_2 = motion.e[1] - system.beta * force_2
    spread = (r_2 - r_1) * (r_2 - r_1) / (1.0 + 2.0 * system.alpha)
    return math.sqrt(y_1 * y_1 + y_2 * y_2 + 0.5 * ((r_1 + r_2) * (r_1 + r_2) + spread))


@kernel
def least_slope(laws: Floats, block: int, low: float, high: float) -> float:
    """Least slope of a block's law between two speeds, of 33 on each of its pieces."""
    row = piece_row(laws, block, low)
    least = math.inf
    while True:
        end = min(high, laws[row, PIECE_END_COLUMN])
        for k in range(33):
            least = min(least, slope(laws[row], -1, low + (end - low) * k / 32.0))
        if end == high:
            return least
        low = end
        row = int(laws[row, NEXT_PIECE_COLUMN])


@kernel
def landing_rate(system: System, laws: Floats, motion: Motion, block: int) -> float:
    """Rate w' of a slipping block as it reaches the belt."""
    mode = motion.mode[block]
    return -mode * limit(system, block) * static_value(laws[block], mode) - motion.e[block]


@kernel
def slides_for_ever(system: System, laws: Floats, motion: Motion, work: Any) -> bool:
    """Whether two blocks slipping backward can be shown never to reach the belt again."""
    force_1 = force(laws[piece_row(laws, 0, system.V)], -1, system.V)
    force_2 = force(laws[piece_row(laws, 1, system.V)], -1, system.V)
    reach = energy_reach(system, motion, force_1, force_2)
    if not reach < system.V * (1.0 - CLEARANCE):
        return False
    low, high = system.V - reach, system.V + reach
    return min(least_slope(laws, 0, low, high), least_slope(laws, 1, low, high)) >= 0.0
