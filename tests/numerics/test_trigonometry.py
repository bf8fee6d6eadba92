import math

import mpmath
import numpy as np
import pytest

from stickslip.numerics.trigonometry import (
    sincos,
    sine_and_versed,
    turn,
    turn_squared,
    turned,
    upper_angle,
)

ULP = 2.0**-52

pytestmark = pytest.mark.kernel


def worst(values, exact):
    return max(abs(a - b) for a, b in zip(values, exact, strict=True))


@pytest.mark.parametrize("function", [sincos, turned])
@pytest.mark.parametrize("reach", [1.0, 10.0, 1e3])
def test_sine_and_cosine_together(function, reach):
    """Far from 0 the reduction costs a rounding more where products are not fused (no JIT)."""
    allowed = (3 if reach <= 10.0 else 4) * ULP
    x = np.random.default_rng(0).uniform(-reach, reach, 500)
    for value in x.tolist():
        exact = math.sin(value), math.cos(value)
        assert worst(function(value), exact) <= allowed


def test_a_turn_of_at_most_a_quarter_keeps_the_digits_of_small_angles():
    x = np.concatenate([np.linspace(-math.pi / 2, math.pi / 2, 401), [1e-9, -3e-5, 0.0]])
    for value in x.tolist():
        sine, versed = turn(value)
        assert abs(sine - math.sin(value)) <= 2 * ULP * abs(math.sin(value))
        exact = 2.0 * math.sin(value / 2) ** 2
        assert abs(versed - exact) <= 4 * ULP * exact


def test_angle_of_a_point_in_the_upper_half_plane():
    rng = np.random.default_rng(1)
    angle = np.concatenate([rng.uniform(0, math.pi, 500), [1e-12, math.pi / 8, 3 * math.pi / 8]])
    for value in angle.tolist():
        size = math.exp(rng.uniform(-20, 20))
        y, x = size * math.sin(value), size * math.cos(value)
        assert abs(upper_angle(y, x) - math.atan2(y, x)) <= 2 * ULP * math.atan2(y, x)


def test_sine_and_versed_sine_within_a_tenth_of_a_rounding():
    rng = np.random.default_rng(2)
    with mpmath.workdps(40):
        for x, low in zip(rng.uniform(0, 30, 500).tolist(), rng.uniform(-1, 1, 500), strict=True):
            s, s_low, v, v_low = sine_and_versed(x, 1e-16 * float(low))
            angle = mpmath.mpf(x) + 1e-16 * float(low)
            assert abs(mpmath.mpf(s) + s_low - mpmath.sin(angle)) <= 0.1 * ULP
            assert abs(mpmath.mpf(v) + v_low - (1 - mpmath.cos(angle))) <= 0.1 * ULP


@pytest.mark.parametrize("x", [0.5, 1.0, 1.3, 1.55])
def test_turns_near_an_angle_err_both_ways_alike(x):
    """Long motions repeat the same steps: errors of one sign would add up."""
    errors = []
    with mpmath.workdps(40):
        for angle in (x * np.linspace(1, 1.01, 400)).tolist():
            z = angle * angle
            exact, (sine, versed) = mpmath.sqrt(z), turn_squared(z)
            error_of_sine = exact + exact**3 * sine - mpmath.sin(exact)
            errors.append((error_of_sine, versed - 1 + mpmath.cos(exact)))
    mean = np.abs(np.mean(np.array(errors, dtype=float), axis=0))
    assert (mean <= 0.06 * ULP).all(), mean / ULP
