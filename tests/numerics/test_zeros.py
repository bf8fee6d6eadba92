"""Turning points between adjacent floats, in few calls."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.numerics.zeros import halved, middle_zero, slope_zeros

FEW = 8  # calls; halving would take some fifty
ULP = 4  # of the zero, or of the bracket's ends beside 0


class Slope:
    """A function of points that counts its calls."""

    def __init__(self, function):
        self.function, self.calls = function, 0

    def __call__(self, x):
        self.calls += 1
        return self.function(x)


def brackets(slope, lower, upper):
    ends = np.array([lower, upper])
    return ends, slope(ends)


@given(
    zero=st.floats(0.1, 0.9),
    bend=st.floats(-0.8, 0.8),
    width=st.floats(1e-6, 0.05),
    share=st.floats(0.05, 0.95),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_a_simple_zero_is_found_to_adjacent_floats(zero, bend, width, share, sign):
    def function(x):
        u = x - zero
        return sign * u * (1 + bend * u + u * u)

    slope = Slope(function)
    ends, at = brackets(function, [zero - share * width], [zero + (1 - share) * width])
    (found,) = slope_zeros(slope, ends, at)
    assert abs(found - zero) <= ULP * np.spacing(zero)
    assert slope.calls <= FEW


def test_many_brackets_at_once():
    zeros = np.arange(1, 9) * np.pi
    slope = Slope(np.sin)
    found = slope_zeros(slope, *brackets(np.sin, zeros - 0.3, zeros + 0.2))
    np.testing.assert_allclose(found, zeros, rtol=4e-16)
    assert slope.calls <= FEW


@pytest.mark.parametrize("infinite", [0, 1])
def test_an_infinite_slope_at_an_end_says_only_its_sign(infinite):
    function = lambda x: x - 0.3  # noqa: E731
    ends, at = brackets(function, [0.0], [1.0])
    at[infinite] *= np.inf
    (found,) = slope_zeros(Slope(function), ends, at)
    assert found == pytest.approx(0.3, abs=1e-16)


def test_a_jump_over_zero_is_closed_in_on_all_the_same():
    function = lambda x: np.where(x < 0.7, -1.0, 3.0)  # noqa: E731
    (found,) = slope_zeros(Slope(function), *brackets(function, [0.0], [1.0]))
    assert abs(found - 0.7) <= ULP * np.spacing(0.7)


def test_a_slope_of_zero_at_an_end_gives_a_point_inside():
    function = lambda x: x * x  # noqa: E731
    ends = np.array([[0.5], [0.75]])
    found = slope_zeros(Slope(lambda x: function(x - 0.5)), ends, np.array([[0.0], [1.0]]))
    assert 0.5 < found[0] <= 0.5 + ULP * np.spacing(0.5)


def test_no_brackets():
    assert slope_zeros(Slope(np.sin), np.empty((2, 0)), np.empty((2, 0))).size == 0


def test_halving_closes_in_on_where_something_ceases_to_hold() -> None:
    """On either side, from either side, one place or many at once."""
    inside, outside = halved(lambda x: x * x < 2.0, 1.0, 2.0, 60)
    assert outside == math.nextafter(inside, 2.0)
    assert inside**2 < 2.0 <= outside**2
    above, below = halved(lambda x: x * x > 2.0, 2.0, 1.0, 60)
    assert (above, below) == (outside, inside)
    ends = np.array([1.0, 0.0, 3.0])
    found, beyond = halved(lambda x: np.abs(x) < ends, np.zeros(3), np.full(3, 4.0), 52)
    np.testing.assert_array_less(found[[0, 2]], ends[[0, 2]])
    np.testing.assert_allclose(beyond, ends, rtol=0, atol=1e-14)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("place", [-3.0, 0.0, 1.0])
@pytest.mark.parametrize("rounding", [0.0, 1e-12])
def test_a_function_that_is_0_to_rounding_changes_its_sign_in_the_middle(sign, place, rounding):
    g = Slope(lambda x: sign * (x - place) * (abs(x - place) > rounding))
    zero = middle_zero(g, place - 0.3, place + 0.7)
    assert zero == pytest.approx(place, rel=1e-15, abs=1e-15)
    assert g.calls <= 24
