"""Searches from many states: each cycle once, with what the search may have missed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.mechanics.cycle.cycle import same_cycle
from stickslip.numerics.unseen import unseen_share


def test_of_the_papers_coulomb_system() -> None:
    """S1 and S4 from random states, U1 and U2 from the event map; no two the same."""
    model = ss.examples.coulomb()
    found = ss.limit_cycles(model, n_starts=12, rng=0)
    points = sorted(cycle.d[0] for cycle in found if len(cycle.d) == 1)
    orbits = ss.periodic_orbits(model)
    np.testing.assert_allclose(points, [orbit.points[0] for orbit in orbits], rtol=0, atol=1e-11)
    assert [len(cycle.d) for cycle in found if cycle.stable] == [4, 1]
    assert found.hits.sum() + found.n_sliding + found.n_undecided == 12
    np.testing.assert_array_equal(found.hits[[not cycle.stable for cycle in found]], 0)
    assert "estimated share" in repr(found)
    assert list(found.table()["global_sticks"]) == [len(cycle.d) for cycle in found]


def test_cycles_are_compared_up_to_a_shift_of_time() -> None:
    model = ss.examples.law9()
    cycle = ss.find_cycle(model, model.onset(0.62), [model.V] * 2)
    motion = cycle.trajectory
    later = ss.find_cycle(model, motion.x(1.3), motion.v(1.3))
    other = ss.find_cycle(model, model.onset(0.3834), [model.V] * 2)
    assert same_cycle(cycle, later)
    assert not same_cycle(cycle, other)


def test_a_neutral_family_is_told_and_counted() -> None:
    model = ss.Oscillator(V=0.8, friction=ss.Coulomb(mu=0.9))
    found = ss.limit_cycles(model, n_starts=20, rng=3)
    assert found.neutral_family is not None
    assert found.n_sliding > 0
    assert all(cycle.events for cycle in found)


def test_forced_models() -> None:
    model = ss.Oscillator(
        V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(2.0, 0.7)
    )
    found = ss.limit_cycles(model, n_starts=4, rng=0)
    assert len(found) == 1
    assert found[0].stable
    assert found.neutral_family is None


def test_starts_that_settle_on_steady_sliding_are_told_and_those_without_any_sliding() -> None:
    """A brake below its flutter; a mass on the ground, which has no steady sliding."""
    brake = ss.Structure(
        mass=[1.0, 1.0],
        stiffness=[[2.0, 0.35], [0.35, 1.3]],
        damping=[0.05, 0.05],
        contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=1.0), V=0.02, load=[0.0, 0.6])],
    )
    found = ss.limit_cycles(brake, n_starts=6, rng=1)
    assert (found.n_sliding, found.n_undecided) == (3, 0)
    assert [len(cycle.events) for cycle in found] == [2]
    axis = ss.Structure.from_state_space(
        A=[[0, 1, 0], [0, 0, 1], [-4, -6, -1.5]],
        B=[[0], [0], [1]],
        C=[[0, 0, 1]],
        contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=0.7))],
    )
    hunts = ss.limit_cycles(axis, n_starts=3, rng=1)
    assert hunts.hits.tolist() == [3]
    assert hunts.neutral_family is None


@pytest.mark.parametrize(
    ("hits", "share"), [([], 1.0), ([1, 1], 1.0), ([5, 3], 0.0), ([3, 1, 0], 0.25)]
)
def test_good_turing(hits: list[int], share: float) -> None:
    assert unseen_share(hits) == share


def test_the_estimate_is_right_on_average() -> None:
    """Draws from known chances: its mean is the mean chance of what was not drawn."""
    rng = np.random.default_rng(0)
    chances = np.array([0.4, 0.3, 0.2, 0.05, 0.03, 0.02])
    estimates, truths = [], []
    for _ in range(4000):
        hits = rng.multinomial(30, chances)
        estimates.append(unseen_share(hits))
        truths.append(chances[hits == 0].sum())
    assert np.mean(estimates) == pytest.approx(np.mean(truths), abs=2e-3)


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match="n_starts"):
        ss.limit_cycles(ss.examples.coulomb(), n_starts=0)


def test_a_list_comes_back_from_its_file(tmp_path: Path) -> None:
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    found = ss.limit_cycles(block, n_starts=4, rng=1)
    found.save(tmp_path / "cycles.json")
    again = ss.load(tmp_path / "cycles.json")
    assert repr(again) == repr(found)
    assert again[0].model == block
    assert again[0].trajectory.t[-1] == found[0].period
    own = ss.friction_law(lambda s, a, b: a + b * s, parameters={"a": 0.4, "b": 0.0})
    cycle = ss.find_cycle(block.replace(friction=own), [1.0], [0.2])
    with pytest.raises(ValueError, match="Python function"):
        cycle.save(tmp_path / "own.json")


def test_starts_are_told_as_they_are_done() -> None:
    told: list[float] = []
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    ss.limit_cycles(block, n_starts=4, rng=1, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
