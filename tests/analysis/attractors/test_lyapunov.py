"""Exponents against closed forms, and error bars against the spread that they claim."""

import numpy as np
import pytest
from tests.analysis.known_maps import logistic, tent, tent_with_hole

import stickslip as ss
from stickslip.analysis.attractors.lyapunov import MANY, lyapunov_exponent
from stickslip.analysis.exponents.blocking import blocking_error, settled_period
from stickslip.analysis.maps.piecewise_map import PiecewiseMap

ROUNDING = 1e-12


def dyadic():
    """Full branches of slopes 2, 4, 4: uniform density, exponent 1.5 log 2.

    Floats lose a bit or two in every step, so that each orbit ends on 0 after some 30 steps.
    """

    def func(x):
        return np.where(x < 0.5, 2 * x, np.where(x < 0.75, 4 * x - 2, 4 * x - 3))

    return PiecewiseMap(
        func,
        (0, 1),
        derivative=lambda x: np.where(x < 0.5, 2.0, 4.0),
        breakpoints=[0.5, 0.75],
    )


@pytest.mark.parametrize("slope", [1.1, 1.5, 2.0])
def test_tent_map_has_the_logarithm_of_its_slope(slope):
    got = lyapunov_exponent(tent(slope), 0.3, 2000)
    assert got.value == pytest.approx(np.log(slope), abs=ROUNDING)
    assert got.error == 0


def test_full_logistic_map_within_its_error_bars():
    got = lyapunov_exponent(logistic(4.0), [0.1, 0.2, 0.3, 0.4], 20_000)
    assert np.all(np.abs(got.value - np.log(2)) < 5 * got.error)
    assert np.all(got.error < 2e-3)


def test_cycle_is_averaged_over_whole_periods():
    r = 3.2
    got = lyapunov_exponent(logistic(r), 0.3, 1001)
    assert got.value == pytest.approx(0.5 * np.log(4 + 2 * r - r**2), abs=ROUNDING)
    assert got.error < ROUNDING


@pytest.mark.parametrize(
    ("f", "start"),
    [(ss.event_map(ss.examples.coulomb(V=V)), 0.1) for V in (0.0366, 0.03)]
    + [(logistic(3.9), 0.3)],
)
def test_long_orbits_on_an_interpolation_have_the_exponents_of_the_map(f, start, monkeypatch):
    fast = lyapunov_exponent(f, start, MANY)
    monkeypatch.setattr("stickslip.analysis.attractors.lyapunov.MANY", np.inf)
    direct = lyapunov_exponent(f, start, MANY)
    assert abs(fast.value - direct.value) <= ROUNDING + 3 * (fast.error + direct.error)


def test_a_long_orbit_on_a_cycle_has_the_multiplier_of_the_map():
    r = 3.2
    got = lyapunov_exponent(logistic(r), 0.3, MANY)
    assert got.value == pytest.approx(0.5 * np.log(4 + 2 * r - r**2), abs=ROUNDING)
    assert got.error < ROUNDING


def test_whether_long_orbits_leave_the_map_decides():
    got = lyapunov_exponent(tent_with_hole(3.0), [0.75, 0.2], MANY, transient=0)
    assert got.value[0] == pytest.approx(np.log(3))
    assert np.isnan(got.value[1])


def test_superstable_orbit_has_minus_infinity():
    f = PiecewiseMap(lambda x: 0.5 + (x - 0.5) ** 2, (0, 1), derivative=lambda x: 2 * x - 1)
    assert lyapunov_exponent(f, 0.5, 100, transient=0).value == -np.inf


def test_orbits_that_rounding_traps_are_freed():
    got = lyapunov_exponent(dyadic(), [0.1, 0.7], 4000)
    assert np.all(np.abs(got.value - 1.5 * np.log(2)) < 5 * got.error)
    assert np.all(got.error < 0.02)


def test_shapes_follow_the_starting_points():
    got = lyapunov_exponent(logistic(4.0), np.full((2, 3), 0.3), 100)
    assert got.value.shape == got.error.shape == (2, 3)
    scalar = lyapunov_exponent(logistic(4.0), 0.3, 100)
    assert float(scalar) == scalar.value
    value, error = scalar
    assert (value, error) == (scalar.value, scalar.error)
    assert "±" in repr(scalar)
    assert repr(got).count("±") == 6


def test_orbit_that_leaves_has_no_exponent():
    # 0.75 is a fixed point, 0.2 falls into the gap (1/3, 2/3) after one step.
    got = lyapunov_exponent(tent_with_hole(3.0), [0.75, 0.2], 100, transient=0)
    assert got.value[0] == pytest.approx(np.log(3))
    assert np.isnan(got.value[1])
    assert np.isnan(got.error[1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"d": 0.3, "n": 1}, "n = 1"),
        ({"d": 0.3, "n": 10, "transient": -1}, "transient = -1"),
        ({"d": 1.3, "n": 10}, "outside the domain"),
        ({"d": np.nan, "n": 10}, "outside the domain"),
    ],
)
def test_illegal_input_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        lyapunov_exponent(logistic(4.0), **arguments)


def test_error_bars_are_as_wide_as_the_spread():
    f, starts = logistic(3.8), np.linspace(0.2, 0.8, 60)
    got = lyapunov_exponent(f, starts, 4096)
    ratio = np.std(got.value, ddof=1) / np.sqrt(np.mean(got.error**2))
    assert 0.6 < ratio < 1.6


@pytest.mark.parametrize("memory", [0.0, 0.9, -0.6])
def test_blocking_sees_correlations(memory):
    # For x' = memory x + noise the error of the mean of n terms is 1 / (1 - memory) / sqrt(n).
    rng, n = np.random.default_rng(1), 1 << 14
    ratios = []
    for _ in range(30):
        noise, x = rng.standard_normal(n), np.empty(n)
        x[0] = noise[0]
        for i in range(1, n):
            x[i] = memory * x[i - 1] + noise[i]
        ratios.append(blocking_error(x) * np.sqrt(n) * (1 - memory))
    assert np.median(ratios) == pytest.approx(1, abs=0.2)


def test_blocking_of_a_constant_is_exact():
    assert blocking_error(np.full(1000, 0.3)) == 0


def test_settled_period_is_the_smallest():
    cycle = np.tile([0.1, 0.5, 0.3], 40)
    assert settled_period(cycle, 1e-12) == 3
    assert settled_period(np.arange(100.0), 1e-12) == 0
