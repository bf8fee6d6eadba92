import math

import numpy as np
import pytest

from stickslip.numerics.trigonometry import sincos, turn, turned, upper_angle

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
