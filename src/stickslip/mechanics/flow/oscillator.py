"""The one closed form behind the exact engine: an oscillator pulled along by the belt.

    w' = pull,    pull' = -stiffness w - drive

with ``pull = friction - e`` is one slipping block among riders (stiffness 1 + alpha, drive V) as
well as each normal mode of two slipping blocks: the sum (1, 2 V) and the difference (1 + 2 alpha,
0). Friction is not an argument of its own: sums of the friction of two blocks would be rounded,
in every phase alike, and in motions of hundreds of phases that adds up.
"""

from __future__ import annotations

import math

from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos


@kernel(inline=True)
def oscillator(
    stiffness: float, drive: float, w: float, pull: float, t: float
) -> tuple[float, float]:
    """State (w, pull) after time `t`."""
    frequency = math.sqrt(stiffness)
    s, c = sincos(frequency * t)
    s /= frequency
    return (
        w * c + pull * s - drive * (1.0 - c) / stiffness,
        pull * c - (stiffness * w + drive) * s,
    )


@kernel
def oscillator_tangent(
    stiffness: float,
    drive: float,
    w: float,
    pull: float,
    t: float,
    d_stiffness: float,
    d_drive: float,
    d_w: float,
    d_pull: float,
) -> tuple[float, float]:
    """Differentiate `oscillator` at fixed `t`, given the derivatives of its arguments."""
    frequency = math.sqrt(stiffness)
    s, c = sincos(frequency * t)
    s /= frequency
    versed = (1.0 - c) / stiffness
    d_c = -0.5 * t * s * d_stiffness
    d_s = 0.5 * (t * c - s) / stiffness * d_stiffness
    d_versed = (0.5 * t * s - versed) / stiffness * d_stiffness
    gain, d_gain = stiffness * w + drive, d_stiffness * w + stiffness * d_w + d_drive
    return (
        d_w * c + w * d_c + d_pull * s + pull * d_s - d_drive * versed - drive * d_versed,
        d_pull * c + pull * d_c - d_gain * s - gain * d_s,
    )
