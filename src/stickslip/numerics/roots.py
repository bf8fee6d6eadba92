"""The earliest root of a signal, proved: no step is longer than a bound shows to be free of roots.

A signal ``g >= 0`` is followed until it reaches zero. Sign changes are never looked for, so a
touch (``g = g' = 0``) and a pair of near roots are found like any other contact.
"""

from __future__ import annotations

import math

from stickslip.numerics.targets import kernel

EPSILON = 2.0**-52


@kernel(inline=True)
def safe_step(
    g: float, slope: float, curvature: float, bound_2: float, bound_3: float, cap: float
) -> float:
    """Longest step, at most `cap`, over which `g` provably stays positive.

    For ``h <= cap`` the cubic term is at least ``-bound_3 h^3 / 6 >= -(bound_3 cap / 3) h^2/2``.
    So with ``m = min(bound_2, bound_3 cap / 3 - curvature)`` the signal lies above the parabola
    ``g + slope h - m h^2 / 2``, whose first root is the step: Newton's step close to a simple
    root, always from the same side.
    """
    m = min(bound_2, bound_3 * cap * (1.0 / 3.0) - curvature)
    if m <= 0.0:
        return cap if slope >= 0.0 else min(cap, -g / slope)
    root = math.sqrt(slope * slope + 2.0 * m * g)
    step = (slope + root) / m if slope > 0.0 else 2.0 * g / (root - slope)
    return min(cap, step)


@kernel(inline=True)
def leaving_step(slope: float, curvature: float, bound_3: float, cap: float) -> float:
    """Find a step after which a signal that starts at zero is positive, and was all the while.

    The root at the start is divided out: ``g / t >= slope + curvature t / 2 - bound_3 t^2 / 6``.
    Half the root of that bound is taken; 0 means that the signal does not leave zero upward.
    """
    b = 0.5 * curvature
    c = bound_3 / 6.0
    if slope < 0.0 or (slope == 0.0 and b <= 0.0):
        return 0.0
    root = math.sqrt(b * b + 4.0 * c * slope)
    first = (b + root) / (2.0 * c) if b > 0.0 else 2.0 * slope / (root - b)
    return min(cap, 0.5 * first)


@kernel(inline=True)
def all_but_touches(g: float, slope: float, curvature: float, rounding: float) -> bool:
    """Whether a signal that falls here reaches its minimum within rounding of zero."""
    return (
        curvature > 0.0 and abs(slope * slope - 2.0 * curvature * g) <= 2.0 * curvature * rounding
    )


@kernel(inline=True)
def grazing_time(t: float, lowest: float, curvature: float, rounding: float) -> float:
    """Time of contact of a signal whose minimum is `lowest`, at `t`; inf if it stays positive.

    At zero but for `rounding` it is a touch, at `t` itself.
    """
    if lowest > rounding:
        return math.inf
    return t if lowest >= -rounding else t - math.sqrt(-2.0 * lowest / curvature)


@kernel(inline=True)
def contact_time(t: float, g: float, slope: float, curvature: float, rounding: float) -> float:
    """Time of the contact just ahead of `t`, where a signal falls and is within rounding of zero.

    The first root of the parabola through the signal; where the parabola only touches zero,
    within `rounding`, its minimum: there ``g' = 0``, and what follows from that is exact.
    """
    square = slope * slope - 2.0 * curvature * g
    if curvature > 0.0 and square <= 2.0 * curvature * rounding:
        return t - slope / curvature
    if slope == 0.0:
        return t
    return t - 2.0 * g / (slope - math.sqrt(max(square, 0.0)))


@kernel(inline=True, fused=True)
def hides_a_turn(slope: float, slope_end: float, bend: float, bend_end: float, t: float) -> bool:
    """Whether a function of these slopes and curvatures may turn twice within a short time."""
    # By as much as two tangents dip, and half of that again, the slope may pass zero.
    steep, steep_end = abs(bend), abs(bend_end)
    nearer = abs(slope) if abs(slope) < abs(slope_end) else abs(slope_end)
    near = nearer * (steep + steep_end) < 1.5 * t * steep * steep_end
    return near and slope * slope_end >= 0.0 and bend * bend_end < 0.0 and slope * bend < 0.0
