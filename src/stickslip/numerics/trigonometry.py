"""Sine, cosine and angle in arithmetic of our own: the same bits on every platform.

The argument is reduced by a multiple of pi/2 in three parts (Cody and Waite); the polynomials are
those of fdlibm (1993). Error below 1.5 ulp for ``|x| < 1e3``, 2.1 ulp for ``|x| < 1e5``. `turn`,
`turned` and `upper_angle` have no branches: loops become vector instructions. Their polynomials
interpolate atan x / x at Chebyshev points in x^2 (relative error 4e-17), and fit sine and cosine
by least squares, each coefficient rounded before the rest is fitted anew (3e-19, 2e-20 to pi/2).
"""

from __future__ import annotations

import math

from stickslip.numerics.rounding import two_product, two_sum
from stickslip.numerics.targets import kernel

# pi/2 = HIGH + MIDDLE + LOW: the first two have trailing zeros, so that k times them is exact.
HIGH = 1.57079632673412561417e00
MIDDLE = 6.07710050630396597660e-11
LOW = 2.02226624879595063154e-21
TWO_OVER_PI = 0.6366197723675814
# Adding and subtracting it rounds to an integer: above 2^52 doubles have no fraction.
ROUNDER = 1.5 * 2.0**52
SLOPE_OF_PI_8 = 0.4142135623730951


@kernel(inline=True)
def beyond_parabola(r: float) -> tuple[float, float]:
    """Return (sin r - r, cos r - 1 + r^2 / 2) for ``|r| <= pi/4``."""
    z = r * r
    sine = -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10
    sine = -1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * sine)
    sine = -1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * sine)
    cosine = 2.08757232129817482790e-09 + z * -1.13596475577881948265e-11
    cosine = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * cosine)
    cosine = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * cosine)
    return r * z * sine, z * z * cosine


@kernel(inline=True)
def sincos(x: float) -> tuple[float, float]:
    """Return (sin x, cos x)."""
    k = (x * TWO_OVER_PI + ROUNDER) - ROUNDER
    r = ((x - k * HIGH) - k * MIDDLE) - k * LOW
    beyond, higher = beyond_parabola(r)
    sine = r + beyond
    half = 0.5 * (r * r)
    whole = 1.0 - half
    cosine = whole + (((1.0 - whole) - half) + higher)
    quadrant = int(k) & 3
    s, c = (cosine, sine) if quadrant & 1 else (sine, cosine)
    return -s if quadrant & 2 else s, -c if (quadrant + 1) & 2 else c


@kernel(inline=True)
def sine_and_versed(x: float, x_low: float) -> tuple[float, float, float, float]:
    """Return sin and 1 - cos of ``x + x_low``, each as a sum of two: within a tenth of an ulp."""
    k = (x * TWO_OVER_PI + ROUNDER) - ROUNDER
    r, r_low = two_sum(x - k * HIGH, -(k * MIDDLE))
    r_low += x_low - k * LOW
    beyond, higher = beyond_parabola(r)
    square, square_low = two_product(r, r)
    s, s_low = two_sum(r, beyond + r_low * (1.0 - 0.5 * square))
    v, v_low = two_sum(0.5 * square, 0.5 * square_low + r_low * (r + beyond) - higher)
    quadrant = int(k) & 3
    if quadrant & 1:
        # sin -> cos = 1 - v, cos -> -sin
        c, c_low = two_sum(1.0, -v)
        c_low -= v_low
        v, v_low = two_sum(1.0, s)
        v_low += s_low
        s, s_low = c, c_low
    if quadrant & 2:
        # sin -> -sin, cos -> -cos
        s, s_low = -s, -s_low
        v, low = two_sum(2.0, -v)
        v_low = low - v_low
    return s, s_low, v, v_low


@kernel(inline=True, fused=True)
def turn_squared(z: float) -> tuple[float, float]:
    """Return ((sin x - x) / x^3, 1 - cos x) for ``z = x^2``, ``|x| <= pi/2``."""
    sine = 1.6058937293148319e-10 + z * (-7.642927756019604e-13 + z * 2.720507444594806e-15)
    sine = 2.755731921071202e-06 + z * (-2.5052106827422383e-08 + z * sine)
    sine = -1.9841269841207676e-04 + z * sine
    sine = -0.16666666666666666 + z * (0.008333333333333196 + z * sine)
    versed = 1.1470678043803655e-11 + z * (-4.7770342714569976e-14 + z * 1.5133816817252428e-16)
    versed = 2.755731921291733e-07 + z * (-2.0876755875216908e-09 + z * versed)
    versed = -2.4801587301523164e-05 + z * versed
    versed = -0.041666666666666664 + z * (0.0013888888888888694 + z * versed)
    return sine, 0.5 * z + z * z * versed


@kernel(inline=True, fused=True)
def turn(x: float) -> tuple[float, float]:
    """Return (sin x, 1 - cos x) for ``|x| <= pi/2``."""
    z = x * x
    sine, versed = turn_squared(z)
    return x + x * z * sine, versed


@kernel(inline=True, fused=True)
def turned(x: float) -> tuple[float, float]:
    """Return (sin x, cos x) without branches, from those of half the angle: within 3 ulp of 1."""
    k = (x * (0.25 * TWO_OVER_PI) + ROUNDER) - ROUNDER
    half = 0.5 * (((x - k * (4.0 * HIGH)) - k * (4.0 * MIDDLE)) - k * (4.0 * LOW))
    s, v = turn(half)
    return 2.0 * s * (1.0 - v), 1.0 - 2.0 * s * s


@kernel(inline=True, fused=True)
def upper_angle(y: float, x: float) -> float:
    """Angle, 0 to pi, of the point (x, y) with ``y >= 0``, without branches."""
    a = abs(x)
    steep = y > a
    low, high = (a, y) if steep else (y, a)
    wide = low > SLOPE_OF_PI_8 * high  # beyond pi/8: the rest to pi/4
    u = (low - high if wide else low) / (low + high if wide else high)
    z = u * u
    rest = -0.05085240174151631 + z * (0.03922560559577717 + z * -0.019169476385268322)
    rest = -0.0666450683513317 + z * (0.058581088561060514 + z * rest)
    rest = -0.09090904564022366 + z * (0.07692182863309685 + z * rest)
    rest = -0.14285714284662226 + z * (0.11111111014909221 + z * rest)
    rest = -0.3333333333333333 + z * (0.199999999999955 + z * rest)
    angle = u + u * z * rest + (0.25 * math.pi if wide else 0.0)
    angle = 0.5 * math.pi - angle if steep else angle
    return math.pi - angle if x < 0.0 else angle
