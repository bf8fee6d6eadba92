"""Verdicts on orbits from stretches of them: known motions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.numerics.long_run import (
    CHAOTIC,
    LEFT,
    PERIODIC,
    UNDECIDED,
    Path,
    new_long_run,
    new_path,
    read_off,
)

pytestmark = pytest.mark.kernel

ROUNDING = 1e-12


def verdict(points, slopes, labels=None, max_period=64, domain=(0.0, 1.0)):
    """Read off an orbit in a domain."""
    n = len(points) - 1
    with np.errstate(divide="ignore"):
        logs = np.log(np.abs(np.asarray(slopes, dtype=float)))
    labels = np.zeros(n, dtype=np.uint64) if labels is None else np.asarray(labels, np.uint64)
    found = new_long_run(1)
    read_off(Path(np.asarray(points, dtype=float), labels, logs), *domain, max_period, found, 0)
    return found


def cycle(period, n, multiplier, seed):
    rng = np.random.default_rng(seed)
    points = rng.permutation(np.linspace(0.05, 0.95, period))
    slopes = rng.uniform(0.5, 2.0, period)
    slopes *= (multiplier / np.prod(slopes)) ** (1 / period)
    at = np.arange(n + 1) % period
    return points[at], slopes[at[:-1]]


@given(period=st.integers(1, 40), multiplier=st.floats(1e-6, 0.99), seed=st.integers(0, 99))
def test_a_stable_cycle_is_found_with_its_exponent(period, multiplier, seed):
    found = verdict(*cycle(period, 500, multiplier, seed))
    assert (found.kind[0], found.period[0]) == (PERIODIC, period)
    np.testing.assert_allclose(
        found.exponent[0], np.log(multiplier) / period, rtol=0, atol=ROUNDING
    )
    assert found.error[0] == 0.0


def test_a_superstable_cycle_is_periodic():
    found = verdict(*cycle(3, 300, 0.0, 0))
    assert (found.kind[0], found.period[0], found.exponent[0]) == (PERIODIC, 3, -np.inf)


@pytest.mark.parametrize("multiplier", [1.0, 3.0])
def test_a_cycle_that_does_not_attract_is_undecided(multiplier):
    # Rounding may hold an orbit there: that is no attractor.
    found = verdict(*cycle(4, 300, multiplier, 1))
    assert (found.kind[0], found.period[0]) == (UNDECIDED, 0)


def test_a_period_beyond_the_longest_is_undecided():
    orbit = cycle(40, 500, 0.5, 2)
    assert verdict(*orbit, max_period=39).kind[0] == UNDECIDED
    assert verdict(*orbit, max_period=40).period[0] == 40


def test_a_period_must_fit_twice():
    orbit = cycle(40, 79, 0.5, 2)
    assert verdict(*orbit).kind[0] == UNDECIDED


def test_equal_points_of_different_itineraries_do_not_recur():
    points, slopes = cycle(2, 400, 0.5, 3)
    labels = np.arange(400) % 4
    assert verdict(points, slopes, labels).period[0] == 4


def test_an_orbit_that_still_moves_is_undecided():
    n = 400
    points = 0.5 + 0.4 * 0.99 ** np.arange(n + 1)
    assert verdict(points, np.full(n, 0.99)).kind[0] == UNDECIDED


def logistic_orbit(n, r=4.0, x=0.2345):
    points = [x]
    for _ in range(n):
        points.append(r * points[-1] * (1 - points[-1]))
    points = np.array(points)
    return points, r * (1 - 2 * points[:-1])


def test_chaos_is_found_with_an_honest_error():
    found = verdict(*logistic_orbit(4000))
    assert found.kind[0] == CHAOTIC
    assert abs(found.exponent[0] - np.log(2)) < 5 * found.error[0]
    assert 0 < found.error[0] < 0.02


def test_cells_are_those_that_the_orbit_visits():
    points, slopes = logistic_orbit(50)
    found = verdict(points, slopes)
    bits = [(int(found.cells[0, c // 64]) >> (c % 64)) & 1 for c in range(256)]
    expected = np.zeros(256, dtype=int)
    expected[np.clip((points * 256).astype(int), 0, 255)] = 1
    np.testing.assert_array_equal(bits, expected)


def test_the_whole_line_has_no_cells():
    assert not verdict(*logistic_orbit(100), max_period=0, domain=(-np.inf, np.inf)).cells.any()


def test_a_short_stretch_has_no_error_bar_and_no_chaos():
    found = verdict(*logistic_orbit(10))
    assert found.kind[0] == UNDECIDED
    assert found.error[0] == np.inf


def test_an_orbit_has_left_until_it_is_read_off():
    assert new_long_run(2).kind.tolist() == [LEFT, LEFT]
    assert new_path(7).point.shape == (8,)
