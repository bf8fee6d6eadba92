"""What the driver of a motion asks of a law: rates at landings, and whether sliding ever ends.

A template, like the steppers of the adaptive engine, which offer these kernels with their own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.mechanics.flow.pieces import piece_row
from stickslip.mechanics.flow.sliding import CLEARANCE, energy_reach
from stickslip.mechanics.flow.system import Floats, Motion, System, limit
from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.mechanics.flow._least_slope_kernels import least_slope
    from stickslip.mechanics.friction.stub import force, static_value


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
