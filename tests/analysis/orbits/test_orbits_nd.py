"""Periodic orbits of maps of R^n: against maps of which all orbits are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.known_maps_nd import delayed_logistic, henon, kinked

from stickslip.analysis.orbits.newton_nd import monodromy, shooting_matrix, solve_orbits
from stickslip.analysis.orbits.orbits_nd import Unseen
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.results.files import load, save

# Orbits of the Hénon map (1.4, 0.3) by period: Galias (1998), and the fixed point off the
# attractor.
KNOWN = (2, 1, 0, 1, 0, 2, 4, 7)


@pytest.fixture(scope="module")
def orbits():
    return periodic_orbits(henon(), len(KNOWN), n_starts=1024)


def test_all_orbits_of_the_henon_map_are_found(orbits):
    assert tuple(len(orbits.of_period(p)) for p in range(1, len(KNOWN) + 1)) == KNOWN
    assert all(item.at_least == 0.0 for item in orbits.unseen)


def test_each_orbit_is_one_by_plain_iteration(orbits):
    a, b = 1.4, 0.3
    for orbit in orbits:
        assert orbit.residual < 1e-14
        assert orbit.points[0, 0] == orbit.points[:, 0].min()
        product = np.eye(2)
        for (x, y), (next_x, next_y) in zip(
            orbit.points, np.roll(orbit.points, -1, axis=0), strict=True
        ):
            assert next_x == pytest.approx(1 - a * x * x + y, abs=1e-14)
            assert next_y == pytest.approx(b * x, abs=1e-14)
            product = np.array([[-2 * a * x, 1.0], [b, 0.0]]) @ product
        # area shrinks by b each step
        assert np.prod(orbit.multipliers) == pytest.approx((-b) ** orbit.period, rel=1e-9)
        assert orbit.multipliers.sum() == pytest.approx(np.trace(product), rel=1e-12)
        assert orbit.stable == (np.abs(orbit.multipliers) < 1).all()
        apart = np.abs(orbit.points[1:] - orbit.points[0]).max(axis=1)
        assert (apart > 1e-3).all()  # the period is minimal


def test_orbits_are_listed_once_and_their_hits_counted(orbits):
    for item in orbits.unseen:
        hits = [orbit.hits for orbit in orbits.of_period(item.period)]
        assert sum(hits) == item.n_hits
        assert (hits.count(1), hits.count(2)) == (item.once, item.twice)
    assert len(orbits[:3]) == 3
    assert orbits.stable == ()
    assert "period 3: no seed led to an orbit" in repr(orbits)


def test_the_estimate_tells_of_orbits_not_found():
    """With few seeds some orbits of period 8 stay unseen, and the estimate says so."""
    few = periodic_orbits(henon(), period=8, n_starts=100)
    assert len(few) < 7
    assert 0.05 < few.unseen[0].probability < 0.5


@given(
    st.integers(1, 60), st.lists(st.integers(0, 59), min_size=1, max_size=80), st.integers(0, 2**32)
)
def test_good_and_turing_guess_the_share_not_seen(n_kinds, draws, seed):
    """Of random draws, the mean of the estimate is the mean of the share not seen."""
    rng = np.random.default_rng(seed)
    size, total_estimate, total_share = len(draws) + 5, 0.0, 0.0
    for _ in range(200):
        counts = np.bincount(rng.integers(0, n_kinds, size=size), minlength=n_kinds)
        once, twice = int((counts == 1).sum()), int((counts == 2).sum())
        total_estimate += Unseen(1, size, once, twice).probability
        total_share += float((counts == 0).sum()) / n_kinds
    assert abs(total_estimate - total_share) / 200 < 5.0 / size + 0.05


@given(p=st.integers(1, 5), n=st.integers(1, 3), seed=st.integers(0, 2**32))
def test_the_shooting_matrix_is_singular_where_the_monodromy_has_the_eigenvalue_one(p, n, seed):
    jacobians = np.random.default_rng(seed).normal(size=(p, n, n))
    expected = np.linalg.det(monodromy(jacobians) - np.eye(n))
    found = np.linalg.det(shooting_matrix(jacobians))
    assert abs(found) == pytest.approx(abs(expected), rel=1e-8, abs=1e-10)


@settings(max_examples=20)
@given(a=st.floats(1.1, 2.4))
def test_the_fixed_points_of_the_delayed_logistic_map(a):
    found = periodic_orbits(delayed_logistic(a), 1, n_starts=32)
    points = np.array([orbit.points[0] for orbit in found])
    np.testing.assert_allclose(points, [[0, 0], [1 - 1 / a, 1 - 1 / a]], rtol=0, atol=1e-13)
    expected = np.roots([1.0, -1.0, a - 1.0])
    got = found[1].multipliers
    np.testing.assert_allclose(np.sort_complex(got), np.sort_complex(expected), rtol=0, atol=1e-7)


def test_guesses_without_a_value_are_no_orbits():
    guesses = np.array([[[np.nan, 0.0]], [[50.0, 0.0]], [[0.6, 0.2]]])
    assert solve_orbits(henon(), guesses).found.tolist() == [False, False, True]


def test_both_sides_of_a_border_have_their_orbit():
    found = periodic_orbits(kinked(mu=0.1), 1)
    assert [orbit.itinerary for orbit in found] == [("2",)]
    assert found[0].points[0] == pytest.approx([0.1 / 2.75, -0.025 / 2.75], abs=1e-14)


@pytest.mark.parametrize("bad", [{"max_period": 0}, {"period": 0}, {"n_starts": 0}])
def test_bad_numbers_are_named(bad):
    (name,) = bad
    with pytest.raises(ValueError, match=f"{name} = 0"):
        periodic_orbits(henon(), **bad)


def test_a_list_is_saved_and_loaded_exactly(orbits, tmp_path):
    save(orbits, tmp_path / "orbits")
    again = load(tmp_path / "orbits")
    assert repr(again) == repr(orbits)
    for one, other in zip(orbits, again, strict=True):
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.multipliers, other.multipliers)
