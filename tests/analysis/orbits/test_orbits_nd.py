"""Periodic orbits of maps of R^n: against maps of which all orbits are known."""

import functools
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.known_maps_nd import delayed_logistic, henon, kinked
from tests.analysis.plane_maps import henon as plane_henon
from tests.analysis.plane_maps import henon_points, ikeda, lozi, lozi_points, standard

import stickslip as ss
from stickslip.analysis.orbits.newton import monodromy, shooting_matrix, solve_orbits
from stickslip.analysis.orbits.orbits_nd import Unseen, same_points
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.results.files import load, save

# Orbits of the Hénon map (1.4, 0.3) by period: Galias (1998), and the fixed point off the
# attractor.
KNOWN = (2, 1, 0, 1, 0, 2, 4, 7, 6, 10)


@pytest.fixture(scope="module")
def orbits():
    return periodic_orbits(henon(), len(KNOWN))


def biham_and_wenzel(p, a=1.4, b=0.3, step=0.05, n_steps=4000):
    """Orbits of f^p of the Hénon map, a symbol sequence each: Phys. Rev. Lett. 63 (1989) 819.

    For signs s_i the flow x_i' = s_i (1 - a x_i^2 + b x_(i-1) - x_(i+1)) comes to rest at the
    orbit of that sequence, if there is one, and else runs away.
    """
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=p)))
    x = 0.1 * signs
    for _ in range(n_steps):
        pull = 1 - a * x**2 + b * np.roll(x, 1, axis=1) - np.roll(x, -1, axis=1)
        x = np.clip(x + step * signs * pull, -5.0, 5.0)
    at_rest = np.abs(pull).max(axis=1) < 1e-9
    return x[at_rest]


def minimal_cycles(rows):
    """Distinct cycles among rows, all of whose turns differ."""
    turns = [sorted(tuple(np.round(np.roll(x, k), 6)) for k in range(len(x))) for x in rows]
    return {all_[0] for all_ in turns if len(set(all_)) == len(all_)}


@pytest.mark.parametrize("p", [1, 2, 4, 6, 7, 8, 9, 10])
def test_symbol_sequences_of_the_henon_map_lead_to_the_same_orbits(orbits, p):
    theirs = minimal_cycles(biham_and_wenzel(p))
    ours = minimal_cycles([orbit.points[:, 0] for orbit in orbits.of_period(p)])
    assert len(ours) == KNOWN[p - 1]
    assert ours == theirs


def full_shift(p):
    """Orbits of minimal period p of two symbols."""
    shorter = sum(q * full_shift(q) for q in range(1, p) if p % q == 0)
    return (2**p - shorter) // p


def turned(f, seed):
    """Make a horseshoe of R^3: a map of the plane and a contraction, in random coordinates."""
    rng = np.random.default_rng(seed)
    basis = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.diag(rng.uniform(0.5, 2.0, 3))
    back = np.linalg.inv(basis)

    def func(z):
        u = z @ back.T
        image = f(u[..., :2], **f.keywords)
        return np.concatenate([image, 0.3 * u[..., 2:] + 0.2 * u[..., :1]], axis=-1) @ basis.T

    reach = np.abs(basis) @ np.array([3.0, 3.0, 3.0])
    return ss.Map(func, 3, domain=[(-r, r) for r in reach])


@pytest.mark.parametrize(
    ("f", "max_period"),
    [
        # full horseshoes: Devaney and Nitecki, Commun. Math. Phys. 67 (1979) 137
        (plane_henon(a=6.0, domain=((-3, 3), (-3, 3))), 9),
        (lozi(a=4.0), 8),
        (turned(functools.partial(henon_points, a=6.0, b=0.3), 1), 7),
        (turned(functools.partial(henon_points, a=5.4, b=-0.3), 2), 7),
        (turned(functools.partial(lozi_points, a=4.0, b=0.5), 3), 7),
    ],
)
def test_all_orbits_of_a_set_that_repels_are_found(f, max_period):
    """No start stays near it, and its orbits are all sequences of two symbols."""
    found = periodic_orbits(f, max_period)
    counts = [len(found.of_period(p)) for p in range(1, max_period + 1)]
    assert counts == [full_shift(p) for p in range(1, max_period + 1)]


def test_orbits_of_the_ikeda_map_are_found_in_boxes_that_hold_another_attractor():
    """The box that holds the fixed point (2.97, 4.15), where most orbits end, holds them all."""
    small = periodic_orbits(ikeda(domain=((-1, 2.2), (-2.5, 1.2))), 8)
    large = periodic_orbits(ikeda(domain=((-2, 5), (-3.5, 6))), 8)
    assert [len(small.of_period(p)) for p in range(1, 9)] == [2, 1, 2, 3, 4, 7, 10, 14]
    assert [len(large.of_period(p)) for p in range(1, 9)] == [3, 1, 2, 3, 4, 7, 10, 14]
    stable = large.stable[0].points
    assert stable == pytest.approx(np.array([[2.97213, 4.14595]]), abs=1e-5)


@pytest.fixture(scope="module")
def standard_orbits():
    return periodic_orbits(standard(1.0), 7)


def test_orbits_of_the_standard_map(standard_orbits):
    """Areas are kept; the map is reversible; and orbits of each period balance (Lefschetz).

    The fixed points of f^p of a map of the torus that twists it have indices of the sum 0; at
    k = 1 the fixed point (pi, 0) has the multipliers exp(±i pi / 3) and degenerates for p = 6.
    """
    found = standard_orbits
    assert [len(found.of_period(p)) for p in range(1, 8)] == [2, 2, 4, 4, 8, 4, 16]
    assert [item.degenerate > 0 for item in found.unseen] == [p == 6 for p in range(1, 8)]
    for orbit in found:
        # roots of m^2 - t m + 1 lose half the digits where they coincide
        assert np.prod(orbit.multipliers) == pytest.approx(1.0, abs=1e-9)
    for p in (1, 2, 3, 4, 5, 7):
        traces = [orbit.multipliers.sum().real for orbit in found.of_period(p)]
        assert sum(np.sign(2.0 - trace) for trace in traces) == 0


def test_the_standard_map_is_symmetric_and_so_is_the_list(standard_orbits):
    for orbit in standard_orbits:
        angle, p = orbit.points.T
        mirror = np.stack([-angle, -p], axis=1)  # commutes with the map
        reverse = np.stack([-angle, p + np.sin(angle)], axis=1)[::-1]  # turns it round
        for image in (mirror, reverse):
            same = [same_points(orbit.system, image, o.points) for o in standard_orbits]
            assert sum(same) == 1


def test_a_family_of_orbits_is_no_orbit():
    """Every point but 0 is of period 4, 0 is fixed; a list of some of them would say nothing."""
    f = ss.Map(lambda z: np.stack([-z[..., 1], z[..., 0]], axis=-1), 2, domain=[(-1, 1)] * 2)
    found = periodic_orbits(f, 4)
    assert [orbit.period for orbit in found] == [1]
    assert [item.degenerate > 0 for item in found.unseen] == [False, False, False, True]
    assert "near a degenerate orbit" in repr(found)


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
    assert "period 3: none of 1024 seeds led to an orbit" in repr(orbits)


def test_the_estimate_tells_of_orbits_not_found(monkeypatch):
    """With few seeds some orbits of period 8 stay unseen, and the estimate says so."""
    monkeypatch.setattr("stickslip.analysis.orbits.orbits_nd.ROUNDS", 1)
    few = periodic_orbits(plane_henon(a=6.0), period=8, n_starts=60)
    (told,) = few.unseen
    assert told.n_seeds == 60
    assert len(few) < full_shift(8)
    assert 0.05 < told.probability < 0.5
    assert 0.0 < told.at_least <= full_shift(8) - len(few)


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
        total_estimate += Unseen(1, size, size, once, twice).probability
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
