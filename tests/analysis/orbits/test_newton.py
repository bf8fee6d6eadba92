"""Newton's method with all points of an orbit as unknowns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.analysis.orbits.newton import polish


def unlabelled(x):
    return np.zeros(x.shape, dtype=np.uint64)


def solve(slopes, offsets, guess):
    """One orbit of x -> slopes[i] x + offsets[i]; the branch is given by the place."""
    p = len(slopes)
    slopes, offsets = np.array(slopes), np.array(offsets)
    return polish(
        lambda k, x: (slopes[k % p] * x + offsets[k % p], slopes[k % p], unlabelled(x)),
        np.full((1, p), guess),
        np.full((1, p), -1e9),
        np.full((1, p), 1e9),
        1.0,
    )


@given(
    slopes=st.lists(st.floats(-9, 9).filter(lambda s: abs(s) > 1.5), min_size=1, max_size=12),
    offset=st.floats(-1, 1),
)
def test_affine_orbits_in_one_step(slopes, offset):
    p = len(slopes)
    found = solve(slopes, [offset] * p, 0.3)
    # Backwards the map contracts: the reference is exact to rounding.
    x = 0.0
    for _ in range(200):
        for s in reversed(slopes):
            x = (x - offset) / s
    assert found.converged.all()
    assert found.points[0, 0] == pytest.approx(x, abs=1e-14 + found.error.max())
    assert found.error.max() < 1e-13


def test_a_multiplier_of_1e18_costs_no_digits():
    found = solve([8.0] * 20, [-1.0] * 20, 0.5)
    assert np.abs(found.points - 1 / 7).max() < 1e-15
    assert found.slopes.prod() == 8.0**20


def test_a_multiplier_of_one_is_not_solved():
    found = solve([1.0], [0.1], 0.5)
    assert not found.converged.any()
    assert np.isinf(found.error).all()


def test_points_stay_between_their_bounds():
    found = polish(
        lambda k, x: (2 * x - 1.0, np.full_like(x, 2.0), unlabelled(x)),
        np.array([[0.2]]),
        np.array([[0.0]]),
        np.array([[0.5]]),
        1.0,
    )
    assert found.points[0, 0] <= 0.5
    assert not found.converged.any()


@pytest.mark.parametrize("start", [1e-9, -3e-9])
def test_beside_a_fold_of_a_map_that_bends_sharply(start):
    # x -> x + 1e10 (x^2 - a^2): steps that halve from 1e-9 on are no rounding.
    bend, a = 1e10, 2e-10
    found = polish(
        lambda k, x: (x + bend * (x**2 - a**2), 1 + 2 * bend * x, unlabelled(x)),
        np.array([[start]]),
        np.array([[-1.0]]),
        np.array([[1.0]]),
        1.0,
    )
    assert found.converged.all()
    assert abs(found.points[0, 0]) == pytest.approx(a, rel=1e-6, abs=0)


def test_superstable_orbits():
    # x -> 1 - x^2 + ... with a point on the turning point: 0 -> 1 -> 0.
    found = polish(
        lambda k, x: (1 - x**2, -2 * x, unlabelled(x)),
        np.array([[0.1, 0.9]]),
        np.full((1, 2), -2.0),
        np.full((1, 2), 2.0),
        1.0,
    )
    assert found.points == pytest.approx(np.array([[0.0, 1.0]]), abs=1e-15)


def test_a_point_stuck_at_an_infinite_slope_is_no_solution():
    # x -> 0.7 + sqrt(x - 0.5): Newton's method from the right is thrown onto the root's end.
    found = polish(
        lambda k, x: (
            0.7 + np.sqrt(np.maximum(x - 0.5, 0)),
            0.5 / np.sqrt(np.maximum(x - 0.5, 1e-300)),
            unlabelled(x),
        ),
        np.array([[0.5]]),
        np.array([[0.5]]),
        np.array([[0.5 + 1e-9]]),
        1.0,
    )
    assert not found.converged.any()


def test_an_orbit_between_two_floats_is_found_however_steep_the_map():
    # Floats next to 0.3 have images 1.7e-6 apart, and neither is the point itself.
    found = polish(
        lambda k, x: (3e10 * (x - 0.3) + 0.300001, np.full(x.shape, 3e10), unlabelled(x)),
        np.array([[0.2999]]),
        np.array([[0.0]]),
        np.array([[1.0]]),
        1.0,
    )
    assert found.converged.all()
    assert found.points == pytest.approx(np.array([[0.3]]), abs=1e-16)
    assert found.error.max() < 1e-16
