"""The one closed form behind the exact engine: an oscillator pulled along by the belt."""

#     w' = pull,    pull' = -stiffness w - drive,    pull = friction - e
# One slipping block among riders: stiffness 1 + alpha, drive V. Both: their sum (1, 2 V) and
# difference (1 + 2 alpha, 0). Friction as an argument would add a rounding in every phase.

from __future__ import annotations

import math

from stickslip.numerics.rounding import product, quotient, two_product, two_sum
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos, sine_and_versed


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


@kernel(inline=True)
def oscillator_sharp(
    coupling: float, drive: float, w: float, w_low: float, pull: float, pull_low: float, t: float
) -> tuple[float, float, float, float]:
    """As `oscillator` with stiffness ``1 + coupling``, each number a sum of two."""
    stiffness, stiffness_low = two_sum(1.0, coupling)
    frequency = math.sqrt(stiffness)
    square, square_low = two_product(frequency, frequency)
    frequency_low = 0.5 * ((stiffness - square) - square_low + stiffness_low) / frequency
    angle, angle_low = two_product(frequency, t)
    s, s_low, v, v_low = sine_and_versed(angle, angle_low + frequency_low * t)
    s, s_low = quotient(s, s_low, frequency, frequency_low)
    share, share_low = quotient(v, v_low, stiffness, stiffness_low)
    load, load_low = two_product(coupling, w)
    load_low += coupling * w_low + w_low
    load, rest = two_sum(load, w)
    load_low += rest
    load, rest = two_sum(load, drive)
    load_low += rest
    a, a_low = product(pull, pull_low, s, s_low)
    b, b_low = product(load, load_low, share, share_low)
    gain, gain_low = two_sum(a, -b)
    gain_low += a_low - b_low
    new_w, new_w_low = two_sum(w, gain)
    a, a_low = product(pull, pull_low, v, v_low)
    b, b_low = product(load, load_low, s, s_low)
    loss, loss_low = two_sum(a, b)
    loss_low += a_low + b_low
    new_pull, new_pull_low = two_sum(pull, -loss)
    return new_w, new_w_low + w_low + gain_low, new_pull, new_pull_low + pull_low - loss_low


@kernel(inline=True)
def oscillator_change(
    stiffness: float,
    drive: float,
    w: float,
    pull: float,
    t: float,
    s: float,
    c: float,
    d_stiffness: float,
    d_drive: float,
    d_w: float,
    d_pull: float,
) -> tuple[float, float]:
    """As `oscillator_tangent`, from the sine over the frequency and the cosine."""
    versed = (1.0 - c) / stiffness
    d_c = -0.5 * t * s * d_stiffness
    d_s = 0.5 * (t * c - s) / stiffness * d_stiffness
    d_versed = (0.5 * t * s - versed) / stiffness * d_stiffness
    gain, d_gain = stiffness * w + drive, d_stiffness * w + stiffness * d_w + d_drive
    return (
        d_w * c + w * d_c + d_pull * s + pull * d_s - d_drive * versed - drive * d_versed,
        d_pull * c + pull * d_c - d_gain * s - gain * d_s,
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
    return oscillator_change(stiffness, drive, w, pull, t, s, c, d_stiffness, d_drive, d_w, d_pull)
