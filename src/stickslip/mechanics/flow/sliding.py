"""A proof that two slipping blocks never stick again."""

from __future__ import annotations

import math

from stickslip.mechanics.flow.system import Motion, System
from stickslip.numerics.targets import kernel

# What has to be left of V for a proof: more than rounding adds up to in a million steps. (Just
# after a release the bounds are V or more, and without damping they would stay so.)
CLEARANCE = 1e-6


@kernel
def energy_reach(system: System, motion: Motion, force_1: float, force_2: float) -> float:
    """Largest deviation from steady sliding that the energy of two slipping blocks allows.

    ``(y.y + r.K^-1 r) / 2``, y = w + V, r = e - limit F(V), cannot grow while F rises with speed.
    """
    y_1 = motion.w[0] + system.V
    y_2 = motion.w[1] + system.V
    r_1 = motion.e[0] - force_1
    r_2 = motion.e[1] - system.beta * force_2
    spread = (r_2 - r_1) * (r_2 - r_1) / (1.0 + 2.0 * system.alpha)
    return math.sqrt(y_1 * y_1 + y_2 * y_2 + 0.5 * ((r_1 + r_2) * (r_1 + r_2) + spread))
