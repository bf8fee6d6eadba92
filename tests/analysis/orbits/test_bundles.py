"""Many orbits of many periods moved to another parameter value at once."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

from stickslip import examples as models
from stickslip.analysis.bifurcations.scan.nodes import velocity
from stickslip.analysis.orbits.newton import OrbitBundle, polish_on, solve_cyclic
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap

ROUNDING = 1e-13


def move_orbits(bundle, f, name, value):
    """Foretell orbits at another value of a parameter to first order, and solve for them."""
    at_value = f.replace(**{name: value})
    points = bundle.points + (value - f.parameters[name]) * velocity(bundle, f, name)
    return at_value, polish_on(at_value, points, periods=bundle.periods)


def same_labels(bundle, moved):
    """Tell which orbits have converged with all points on the branches that they were on."""
    return moved.converged & (moved.labels == bundle.labels).all(axis=1)


slopes = st.floats(-4, 4).filter(lambda s: abs(s) > 0.1)


@given(rows=st.lists(st.lists(slopes, min_size=1, max_size=6), min_size=1, max_size=5))
def test_cyclic_equations(rows):
    periods = np.array([len(row) for row in rows])
    s = np.full((len(rows), periods.max()), np.nan)
    for k, row in enumerate(rows):
        s[k, : len(row)] = row
    b = np.arange(s.size, dtype=float).reshape(s.shape) + 1
    y = solve_cyclic(s, b, periods)
    for k, row in enumerate(rows):
        product = np.prod(row)
        if abs(product - 1) < 1e-3:
            continue
        own, right = y[k, : len(row)], b[k, : len(row)]
        growth = np.abs(own).max() * np.abs(np.append(row, 1)).max() / min(abs(product - 1), 1)
        assert np.abs(row * own - np.roll(own, -1) - right).max() <= 1e-13 * (1 + growth)


def test_superstable_rows_are_solved():
    y = solve_cyclic(np.array([[0.0, 3.0]]), np.array([[1.0, 1.0]]), np.array([2]))
    # y_1 = -1, y_0 = 3 y_1 - 1
    assert y == pytest.approx(np.array([[-4.0, -1.0]]))


@pytest.fixture(scope="module")
def logistic_orbits():
    f = examples.logistic(3.9)
    return f, OrbitBundle.of(periodic_orbits(f, 4), f)


def test_moved_orbits_are_those_of_a_fresh_list(logistic_orbits):
    f, bundle = logistic_orbits
    for value in (3.91, 3.92, 3.93):
        f, moved = move_orbits(bundle, f, "r", value)
        assert moved.converged.all()
        assert same_labels(bundle, moved).all()
        assert not moved.collapsed.any()
        distance = np.nanmax(np.abs(moved.points - bundle.points), axis=1)
        assert (moved.surprise <= 0.2 * distance).all()
        bundle = moved
    fresh = periodic_orbits(f, 4)
    assert f.parameters == {"r": 3.93}
    assert len(fresh) == len(bundle)
    for orbit, row in zip(fresh, range(len(bundle)), strict=True):
        assert np.sort(bundle.orbit_points(row)) == pytest.approx(
            np.sort(orbit.points), abs=ROUNDING
        )
        assert bundle.multipliers[row] == pytest.approx(orbit.multiplier, rel=1e-10)


def test_multipliers_beyond_the_range_of_floats_are_infinite(logistic_orbits):
    _, bundle = logistic_orbits
    steep = dataclasses.replace(bundle, slopes=1e200 * np.abs(bundle.slopes))
    assert np.array_equal(np.isfinite(steep.multipliers), steep.periods == 1)


def test_rows_do_not_depend_on_their_neighbours(logistic_orbits):
    f, bundle = logistic_orbits
    _, together = move_orbits(bundle, f, "r", 3.91)
    for row in range(len(bundle)):
        _, alone = move_orbits(bundle.take(slice(row, row + 1)), f, "r", 3.91)
        p = bundle.periods[row]
        assert np.array_equal(alone.points[0, :p], together.points[row, :p])


def test_orbits_that_are_gone_do_not_converge():
    f = examples.logistic(3.84)  # the orbits of period 3 are born at 1 + sqrt(8) = 3.8284
    bundle = OrbitBundle.of(periodic_orbits(f, period=3), f)
    _, moved = move_orbits(bundle, f, "r", 3.82)
    assert len(bundle) == 2
    assert not moved.converged.any()


def test_an_orbit_that_falls_onto_one_of_half_its_period_is_told():
    f = examples.logistic(3.05)
    bundle = OrbitBundle.of(periodic_orbits(f, period=2), f)
    _, moved = move_orbits(bundle, f, "r", 2.9)  # the flip is at 3
    assert not (moved.converged & ~moved.collapsed).any()


def test_changes_of_the_label_are_told():
    f = examples.border_collision(a=0.5, b=-0.5, mu=0.1)
    bundle = OrbitBundle.of(periodic_orbits(f), f)
    _, moved = move_orbits(bundle, f, "mu", 0.2)
    assert same_labels(bundle, moved).all()
    _, moved = move_orbits(bundle, f, "mu", -0.1)
    assert moved.converged.all()
    assert not same_labels(bundle, moved).any()
    assert moved.points[0, 0] == pytest.approx(-0.2)


def test_orbits_of_an_event_map():
    f = EventMap(models.coulomb())
    bundle = OrbitBundle.of(periodic_orbits(f, 4), f)
    at_value, moved = move_orbits(bundle, f, "V", 0.0367)
    assert same_labels(bundle, moved).all()
    fresh = OrbitBundle.of(periodic_orbits(at_value, 4), at_value)
    assert np.nanmax(np.abs(np.sort(fresh.points) - np.sort(moved.points))) < ROUNDING


def test_polishing_starts_from_rough_points(logistic_orbits):
    f, bundle = logistic_orbits
    moved = polish_on(f, bundle.points + 1e-4, periods=bundle.periods)
    assert np.nanmax(np.abs(moved.points - bundle.points)) < ROUNDING


def test_no_orbits_move_too(logistic_orbits):
    f, bundle = logistic_orbits
    at_value, moved = move_orbits(bundle.take(slice(0, 0)), f, "r", 3.95)
    assert at_value.parameters == {"r": 3.95}
    assert len(moved) == 0
    assert len(OrbitBundle.of([], f)) == 0


def test_wrong_names_and_values(logistic_orbits):
    f, bundle = logistic_orbits
    with pytest.raises((ValueError, KeyError), match="nothing"):
        move_orbits(bundle, f, "nothing", 1.0)


def test_orbits_are_given_up_that_stray_or_do_not_contract(logistic_orbits):
    f, bundle = logistic_orbits
    far, near = bundle.points + 0.05, bundle.points + 1e-4
    strayed = polish_on(f, far, periods=bundle.periods, trust_radius=1e-3)
    assert strayed.given_up.all()
    assert not strayed.converged.any()
    kept = polish_on(f, near, periods=bundle.periods, trust_radius=1e-2, contraction=0.5)
    assert kept.converged.all()
    assert not kept.given_up.any()
    grown = polish_on(f, far, periods=bundle.periods, contraction=1e-3)
    assert (grown.given_up | grown.converged).all()
    assert grown.given_up.any()


def test_the_surprise_is_how_far_an_orbit_lies_from_its_guess(logistic_orbits):
    f, bundle = logistic_orbits
    moved = polish_on(f, bundle.points + 1e-4, periods=bundle.periods)
    np.testing.assert_allclose(moved.points, bundle.points, rtol=0, atol=ROUNDING)
    assert moved.surprise == pytest.approx(np.full(len(bundle), 1e-4), rel=1e-9)
