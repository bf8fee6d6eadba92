"""Sums of two doubles: what rounding leaves out is kept."""

from fractions import Fraction

import numpy as np
import pytest

from stickslip.numerics.rounding import product, quotient, sum_of_two, two_product, two_sum

pytestmark = pytest.mark.kernel

RELATIVE = 2.0**-100


@pytest.fixture
def pairs():
    rng = np.random.default_rng(0)
    return (rng.uniform(-3, 3, (300, 2)) * 10.0 ** rng.integers(-8, 8, (300, 2))).tolist()


def exact(*numbers):
    return sum(map(Fraction, numbers))


def test_a_sum_and_a_product_and_their_errors_are_exact(pairs):
    for a, b in pairs:
        total, low = two_sum(a, b)
        assert total == a + b
        assert exact(total, low) == exact(a, b)
        total, low = two_product(a, b)
        assert total == a * b
        assert exact(total, low) == Fraction(a) * Fraction(b)


def test_sums_of_two_are_added_multiplied_and_divided(pairs):
    for a, b in pairs:
        a_low, b_low = 1e-17 * a, -3e-17 * b
        left, right = exact(a, a_low), exact(b, b_low)
        for found, wanted in (
            (product(a, a_low, b, b_low), left * right),
            (quotient(a, a_low, b, b_low), left / right),
        ):
            assert abs(exact(*found) - wanted) <= RELATIVE * abs(wanted)
        total, low = sum_of_two(a, b, a_low)
        assert abs(exact(total, low) - exact(a, b, a_low)) <= RELATIVE * (abs(a) + abs(b))
        assert total == total + low
