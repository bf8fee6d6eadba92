"""Bodies that rub on each other: rational times, mechanisms, clutches in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import studies
from stickslip.studies.rubbing_bodies.bodies import (
    PULLED,
    THROWN,
    WALLED,
    break_away,
    creep_speed,
    largest_error,
    mechanism,
    random_stacks,
    stages,
    stepped,
)
from stickslip.studies.rubbing_bodies.clutches import Engaging, closed_form, train


def test_times_of_two_stacks_by_hand() -> None:
    assert [str(stage.t) for stage in stages(THROWN)] == ["0", "5/2", "5"]
    assert [str(stage.t) for stage in stages(PULLED)] == ["0", "20/7", "100/21", "40/7"]
    for given in (THROWN, PULLED):
        (m1, m2), (v1, v2) = given.mass, given.v
        assert sum(stages(given)[-1].heat) == (m1 * v1**2 + m2 * v2**2) / 2


def test_random_stacks_move_as_exact_arithmetic_says() -> None:
    assert max(largest_error(given) for given in random_stacks(12)) < 1e-12


def test_time_stepping_converges_to_the_rational_way() -> None:
    exact = float(stages(PULLED)[-1].x[0])
    off = [stepped(PULLED.model, [3.0, 0.0], h, 6.0)[1][-1, 0] - exact for h in (0.02, 0.01)]
    assert off[0] == pytest.approx(2.0 * off[1], rel=0.1)
    assert abs(off[1]) < 0.02


@pytest.mark.parametrize("between", [0.1, 0.35, 0.45, 0.9])
def test_the_weaker_mechanism_breaks_away(between: float) -> None:
    force, slipping = break_away(between)
    assert force == pytest.approx(mechanism(between)[0], rel=1e-13)
    assert slipping == mechanism(between)[1]


def test_creep_is_in_proportion_to_the_width() -> None:
    assert creep_speed(1e-2) == pytest.approx(10.0 * creep_speed(1e-3), rel=1e-9)
    grounds = sum(contact.static for contact in WALLED.contacts[:2])
    assert 0.0 < creep_speed(1e-3) < 1e-2 * grounds


@pytest.mark.parametrize("seed", range(4))
def test_a_clutch_locks_when_and_as_the_formula_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    j1, j2, drive, load = rng.uniform([0.5, 0.5, 0.1, -0.6], [3.0, 3.0, 0.9, 0.2])
    clutch = Engaging((j1, j2), (drive, load), 1.0, (2.0, 0.3))
    run = clutch.motion(2.0 * clutch.lock)
    assert [event.kind for event in run.events] == ["stick"]
    assert run.events[0].time == pytest.approx(clutch.lock, rel=1e-13)
    assert run.energy([run.t[-1]]).dissipation[0] == pytest.approx(clutch.heat, rel=1e-12)
    assert -run.friction([run.t[-1]])[0, 0] == pytest.approx(clutch.carried, rel=1e-12)


def test_the_train_of_clutches_is_its_closed_form_and_keeps_momentum() -> None:
    times, speeds = closed_form()
    found = train()
    events = [time for time in times if time not in (0.4, 0.9, 1.25, 1.5)]
    np.testing.assert_allclose([event[0] for event in found.events], events, rtol=1e-13)
    np.testing.assert_allclose(found.speeds(1.5), speeds, rtol=1e-13)
    assert speeds.sum() == pytest.approx(10.0 + 2.0 / np.pi, rel=1e-14)
    assert [clutch for _, clutch, _ in found.events] == [1, 0, 0, 0, 0, 2]


@pytest.mark.slow
def test_its_claims_and_what_was_published() -> None:
    report = studies.check(source="rubbing_bodies")
    verdicts = {claim.key: claim.verdict for claim in report.claims}
    assert verdicts.pop("rubbing.dymola") == "holds with a correction"
    assert verdicts.pop("rubbing.mworks") == "does not hold"
    assert set(verdicts.values()) == {"holds"}
