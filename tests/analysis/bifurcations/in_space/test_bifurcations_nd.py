"""Bifurcations of maps of R^n where they are known, and against Feigin's rules."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.analysis.known_maps import logistic
from tests.analysis.known_maps_nd import SmoothMap, delayed_logistic, henon, kinked

from stickslip.analysis.bifurcations.accounting import Look
from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange
from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.analysis.bifurcations.in_space import bifurcations_nd
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import OrbitSurvey
from stickslip.analysis.maps.map import Map
from stickslip.analysis.orbits.orbits_nd import search_orbits
from stickslip.analysis.work import Work
from stickslip.numerics.processes import in_processes
from stickslip.results.files import load, save

EXACT = 1e-11


def survey(f, name, ends, max_period=1, n_lists=4):
    found = OrbitSurvey(f, name, *ends, max_period, 64)
    found.run(n_lists, Work())
    assert found.unresolved == []
    return found.events


def border_map(tau, delta):
    """x' = tau x + y + mu, y' = -delta x, with tau and delta of each side (left, right)."""

    def of(z, pair):
        return np.where(z[..., 0] >= 0.0, pair[1], pair[0])

    def func(z, mu):
        x, y = z[..., 0], z[..., 1]
        return np.stack([of(z, tau) * x + y + mu, -of(z, delta) * x], axis=-1)

    def jacobian(z, mu):
        one = np.ones(z.shape[:-1])
        rows = [[of(z, tau), one], [-of(z, delta), 0 * one]]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    return SmoothMap(
        func,
        jacobian,
        {"mu": lambda z, mu: np.stack([np.ones(z.shape[:-1]), np.zeros(z.shape[:-1])], axis=-1)},
        ((-3.0, 3.0), (-3.0, 3.0)),
        (("mu", 0.1),),
        label=lambda z, mu: 1 + (z[..., 0] >= 0.0),
    )


# ------------------------------------------------------------------ smooth maps


@pytest.fixture(scope="module")
def cascade():
    return bifurcations(henon(0.1), "a", (-0.2, 1.04), max_period=4, n_lists=6)


def test_lists_are_made_on_all_cores(monkeypatch):
    """One after the other they were nine tenths of the time of a diagram of three blocks."""
    shared = []

    def recorded(task, values, tell):
        shared.extend(values)
        return in_processes(task, values, tell)

    monkeypatch.setattr(bifurcations_nd, "in_processes", recorded)
    survey(henon(0.1), "a", (0.0, 0.1), n_lists=4)
    assert sorted(shared) == pytest.approx([0.0125, 0.0375, 0.0625, 0.0875], rel=1e-12)


def test_an_orbit_that_comes_in_over_the_end_of_the_domain_is_told():
    # The fixed point that the fold bears at x = 2.86 reaches x = 2, a = (1 - 0.7 x) / x^2.
    f = replace(henon(0.1), box=((-2.0, 2.0), (-2.0, 2.0)))
    found = bifurcations(f, "a", (-0.2, 0.3), max_period=1)
    assert [item.kind for item in found] == ["enters_gap"]
    assert found[0].value == pytest.approx(-0.1, abs=EXACT)
    assert "end of the domain" in found[0].note
    assert [len(side) for side in (found[0].attractors_before, found[0].attractors_after)] == [0, 1]
    assert found.unresolved == ()


def test_fold_and_flips_of_the_henon_map(cascade):
    """The first three in closed form; the fourth: Derrida, Gervois, Pomeau (1979), 1.026."""
    fold, over, back, first, second, third = cascade
    kinds = ["fold", "enters_gap", "enters_gap", "flip", "flip", "flip"]
    assert [item.kind for item in cascade] == kinds
    # The unstable fixed point leaves by x = 6 and comes back by x = -6: a = (1 - 0.7 x) / x^2.
    assert over.value == pytest.approx(-3.2 / 36, abs=EXACT)
    assert back.value == pytest.approx(5.2 / 36, abs=EXACT)
    assert fold.value == pytest.approx(-0.49 / 4, abs=EXACT)
    assert first.value == pytest.approx(3 * 0.49 / 4, abs=EXACT)
    assert second.value == pytest.approx(0.49 + 1.69 / 4, abs=EXACT)
    assert third.value == pytest.approx(1.0258554, abs=1e-7)
    assert [item.period for item in cascade] == [1, 1, 1, 1, 2, 4]
    assert [item.criticality for item in cascade] == [None] * 3 + ["super"] * 3
    assert all(item.error < EXACT for item in cascade)


def test_orbits_and_attractors_on_both_sides(cascade):
    fold, _, _, first, _, third = cascade
    assert (len(fold.orbits_before), len(fold.orbits_after)) == (0, 2)
    assert [orbit.stable for orbit in first.orbits_before] == [True]
    assert [(o.period, o.stable) for o in first.orbits_after] == [(1, False), (2, True)]
    assert [(o.period, o.stable) for o in third.orbits_after] == [(4, False), (8, True)]
    assert [a.period for a in first.attractors_before] == [1]
    assert [a.period for a in first.attractors_after] == [2]
    assert cascade.unresolved == ()


def test_a_neimark_sacker_bifurcation():
    (found,) = survey(delayed_logistic(1.9), "a", (1.5, 2.2))
    assert (found.kind, found.criticality) == ("neimark_sacker", "super")
    assert found.value == pytest.approx(2.0, abs=EXACT)
    assert "rotation 0.16666666" in found.note
    assert [o.stable for o in (*found.orbits_before, *found.orbits_after)] == [True, False]


def test_an_attractor_that_is_lost_between_two_values():
    """The Henon attractor's boundary crisis: a = 1.4269 (Grebogi, Ott, Yorke 1983)."""
    found = bifurcations(henon(), "a", (1.40, 1.44), max_period=1, n_lists=2)
    (change,) = found.of_kind("attractor_change")
    assert change.quality == "bracketed"
    low, high = change.interval
    assert high - low <= 2e-4 * 0.04
    assert low == pytest.approx(1.4269, abs=2e-3)
    assert change.attractors_before
    assert change.attractors_after == ()
    assert "evidence" in change.note


def test_a_look_that_fails_leaves_other_changes_to_be_bisected(monkeypatch):
    """Attractors come at q = 0.3 and 0.7, and where the first is bisected a look fails."""

    def look(f, name, place):
        q, _ = place
        if 0.2 < q < 0.3:
            return UnresolvedChange("a fault of the program left out attractors", q, q)
        count = (q > 0.3) + (q > 0.7)
        return Look(q, (SimpleNamespace(kind="chaotic", period=1, lowest_period=0),) * count)

    monkeypatch.setattr(bifurcations_nd, "_look", look)
    found = OrbitSurvey(henon(), "a", 0.0, 1.0, 1, 8)
    looks = bifurcations_nd._Looks(found)
    looks.at([0.0, 0.5, 1.0], lambda share: None)
    monkeypatch.setattr(looks, "_change", lambda item: item)
    (bracketed,), (left,), _ = looks.changes(lambda share: None)
    assert bracketed.lo < 0.7 < bracketed.hi < bracketed.lo + 2e-4
    assert (left.lo, left.hi) == (0.0, 0.5)
    assert [item.lo for item in found.unresolved] == [0.25]


def test_the_orbit_that_another_shrinks_onto_is_followed_too():
    """No list may have shown it: here only the orbit of period 2 is known at first."""
    found = OrbitSurvey(henon(0.1), "a", 0.3, 0.9, 2, 64)
    (pair,) = search_orbits(found.at(0.7), 2, 2)
    found._follow(pair, 0.7)
    found.run(0, Work())
    (flip,) = found.events
    assert flip.value == pytest.approx(3 * 0.49 / 4, abs=EXACT)
    assert [[o.period for o in flip.orbits_before], [o.period for o in flip.orbits_after]] == [
        [1],
        [1, 2],
    ]


# ------------------------------------------------------------------ border collisions


def test_a_corner_that_doubles_the_period():
    (found,) = survey(kinked(-0.1), "mu", (-0.3, 0.3))
    assert (found.kind, found.outcome.orbits) == ("border_collision", "period-doubled")
    assert found.value == pytest.approx(0.0, abs=EXACT)
    assert {o.period for o in found.orbits_after} == {1, 2, 4} or [
        o.period for o in found.orbits_after
    ] == [1, 2]


def test_all_attractors_that_a_collision_makes_are_in_its_outcome():
    """Skew tents about 0 and 10: the slopes of one make chaos, those of the other a cycle."""

    def func(x, mu):
        y = np.where(x < 5, x, x - 10)
        slope = np.where(y < 0, np.where(x < 5, 0.9, 0.4), np.where(x < 5, -1.7, -1.3))
        return x - y + mu + slope * y

    f = Map(func, 1, parameters={"mu": 0.1}, domain=[(-3, 13)])
    two = bifurcations(f, "mu", (-0.2, 0.3), max_period=2, n_lists=4)
    for item in two:
        assert {a.kind for a in item.attractors_after} == {"periodic", "chaotic"}
        assert item.outcome.attractors == "undecided"
    f = Map(func, 1, parameters={"mu": 0.1}, domain=[(-3, 3)])
    (one,) = bifurcations(f, "mu", (-0.2, 0.3), max_period=2, n_lists=4)
    assert (len(two), one.outcome.attractors) == (2, "chaotic")


def test_a_jump_at_which_orbits_are_lost():
    lost = {item.value: item for item in survey(kinked(-0.1, 0.2), "mu", (-0.3, 0.3))}
    (first, second) = sorted(lost)
    assert (first, second) == pytest.approx((-0.2, 0.0), abs=EXACT)
    assert lost[first].outcome.orbits == "born at a jump"
    assert lost[second].outcome.orbits == "lost at a jump"


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=[pytest.mark.slow] * (seed > 2)) for seed in range(6)]
)
def test_random_corners_follow_feigins_rules(seed):
    """Parities of the real multipliers above 1 and below -1 (di Bernardo and others, 2008, 3.3)."""
    rng = np.random.default_rng(seed)
    tau, delta = rng.uniform(-2.2, 2.2, 2), rng.uniform(-0.5, 0.9, 2)
    above = below = 0
    for t, d in zip(tau, delta, strict=True):
        multipliers = np.roots([1.0, -t, d])
        real = multipliers[np.abs(multipliers.imag) < 1e-12].real
        above, below = above + np.sum(real > 1), below + np.sum(real < -1)
    found = survey(border_map(tau, delta), "mu", (-0.31, 0.3))
    (item,) = [item for item in found if item.kind == "border_collision"]
    fixed = [sum(o.period == 1 for o in side) for side in (item.orbits_before, item.orbits_after)]
    doubled = sum(o.period == 2 for o in (*item.orbits_before, *item.orbits_after))
    assert sorted(fixed) == ([0, 2] if above % 2 else [1, 1])
    assert doubled == below % 2
    assert item.value == pytest.approx(0.0, abs=EXACT)


# ------------------------------------------------------------------ answers and refusals


def test_a_list_tells_how_much_its_last_lists_found_again(cascade):
    told = cascade.coverage
    assert (told.n_lists, told.n_starts, told.new) == (6, 64, 0)
    assert told.again == told.known > 0
    assert "found" in repr(cascade)
    assert "others may be missing" in repr(cascade)
    few = bifurcations(henon(0.1), "a", (0.5, 1.04), max_period=4, n_lists=2, n_starts=1)
    assert few.coverage.n_starts == 1
    one = bifurcations(henon(0.1), "a", (0.5, 1.04), max_period=2, n_lists=1)
    assert np.isnan(one.coverage.share)
    assert "how many are missing is not known" in repr(one)


def test_a_list_is_saved_shown_and_loaded(cascade, tmp_path):
    save(cascade, tmp_path / "found")
    again = load(tmp_path / "found")
    assert [item.value for item in again] == [item.value for item in cascade]
    assert again[3].criticality == "super"
    assert again[3].multipliers == pytest.approx(cascade[3].multipliers, abs=0.0)
    assert "(2.857142857" in repr(cascade[0])
    assert "flip (super)" in repr(cascade)
    assert cascade.table().n_rows == 6


@pytest.mark.parametrize(
    ("f", "options", "words"),
    [
        (henon(), {"window": (0.0, 1.0)}, "window is for maps of a line"),
        (logistic(3.0), {"n_starts": 3}, "n_starts is for maps of R"),
        (henon(), {"n_starts": 0}, "n_starts = 0"),
        (henon(), {"n_lists": 0}, "n_lists = 0"),
    ],
)
def test_options_of_the_other_kind_of_map_are_refused(f, options, words):
    name = next(iter(f.parameters))
    with pytest.raises(ValueError, match=words):
        bifurcations(f, name, (1.0, 1.1), **options)
