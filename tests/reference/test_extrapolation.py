"""The quick stepper of samples of a million, against the oracle."""

import numpy as np
import pytest
from tests.reference import extrapolation
from tests.reference.law9 import Smooth
from tests.reference.laws import PoppStelter
from tests.reference.motion import NEVER_CYCLE

PLANT = extrapolation.Plant(alpha=1.2, beta=1.3, V=0.1, gamma=3.0, delta=0.2, eta=0.05)


@pytest.fixture(scope="module")
def motions():
    law = PoppStelter(gamma=PLANT.gamma, delta=PLANT.delta, eta=PLANT.eta)
    system = Smooth(PLANT.alpha, PLANT.beta, PLANT.V, law)
    end = (1 + PLANT.beta) / (1 + 2 * PLANT.alpha)
    return [(d, system.motion(d, max_time=300)) for d in np.linspace(-0.95, 0.95, 12) * end]


def test_values_are_those_of_the_oracle(motions):
    d = np.array([d for d, _ in motions])
    value, ending = extrapolation.values(PLANT, d, 400)
    assert (ending == extrapolation.RETURNED).all()
    np.testing.assert_allclose(value, [float(m.value) for _, m in motions], rtol=0, atol=2e-13)


def test_every_event_is_found(motions):
    desk = extrapolation.new_desk()
    for d, motion in motions:
        _, duration, events, _ = extrapolation.carry(PLANT, d, 400, desk)
        assert events == motion.n_events
        assert duration == pytest.approx(float(motion.duration), abs=1e-12)


def test_a_motion_in_a_cycle_is_carried_no_further():
    law = {"gamma": 0.33, "delta": 0.49, "eta": 0.08}
    plant = extrapolation.Plant(alpha=0.46, beta=0.58, V=0.26, **law)
    oracle = Smooth(plant.alpha, plant.beta, plant.V, PoppStelter(**law))
    desk = extrapolation.new_desk()
    value, _, events, ending = extrapolation.carry(plant, -0.7, 400, desk)
    assert np.isnan(value)
    assert ending == extrapolation.ENDLESS
    assert events < 400
    assert oracle.motion(-0.7).status == NEVER_CYCLE


def test_a_motion_given_up_has_no_value():
    value, ending = extrapolation.values(PLANT, np.array([0.1]), 1)
    assert np.isnan(value[0])
    assert ending[0] == extrapolation.ENDLESS
