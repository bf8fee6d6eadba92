"""Motions that do not return: a status with its evidence, and no false alarm on slow returns."""

import math

import numpy as np
import pytest
from tests.mechanics.flow.systems import LAW_OF, random_model
from tests.reference.coulomb import Coulomb

import stickslip as ss
from stickslip.status import (
    EVENT_LIMIT,
    NEVER_CYCLE,
    NEVER_SLIPPING,
    OK,
    TIME_LIMIT,
)

# Returns after hundreds of events (found by search among random systems).
SLOW = (
    {"alpha": 2.5606954684958043, "beta": 0.98579196171059, "V": 0.24085821950439618},
    0.8894575712471463,
    -0.121265,
)


def recurrence(motion) -> float:
    """Smallest distance of the last state at an event from an earlier one in the same modes."""
    events = np.array([np.concatenate((motion.x(t), motion.v(t))) for t in motion.t[1:-1]])
    same = (motion.modes[1:-1] == motion.modes[-1]).all(axis=1)
    return float(np.abs(events[:-1][same] - events[-1]).max(axis=1).min())


def test_a_cycle_without_global_stick_is_one():
    rng = np.random.default_rng(41)
    settled = 0
    while settled < 3:
        model = random_model(rng, "coulomb")
        f = ss.event_map(model, max_events=3000)
        d = rng.uniform(-1, 1, 40) * f.domain[1]
        result = f.evaluate(d)
        for k in np.flatnonzero(result.status == NEVER_CYCLE)[:2]:
            # followed twenty times as long in another engine: it comes back, and never sticks
            motion = ss.simulate(
                model, d=d[k], t_end=20.0 * result.duration[k], engine="adaptive", max_events=10**5
            )
            assert motion.status == OK
            assert motion.d.size == 1
            assert recurrence(motion) < 1e-9
            assert result.n_events[k] >= 16
            assert np.isnan(result.value[k])
            settled += 1


def test_in_the_gap_of_the_paper_motions_are_known_soon():
    f = ss.event_map(ss.examples.law9())
    gap = np.linspace(0.572, 0.666, 40)
    result = f.evaluate(gap)
    assert (result.status == NEVER_CYCLE).all()
    assert np.isnan(result.derivative).all()
    assert np.median(result.n_events) < 200
    assert result.n_events.max() < 300
    alone = f._backend.scalar.carry(gap)
    assert np.median(alone.n_events) < 80
    assert alone.n_events.max() < 128


def test_steady_sliding_is_proved_where_friction_grows_with_speed():
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=1.0, friction=ss.PoppStelter(0.0, 0.0, 0.2))
    f = ss.event_map(model)
    result = f.evaluate(np.linspace(-0.6, 0.6, 21))
    never = result.status == NEVER_SLIPPING
    assert never.sum() > 10
    assert np.all(np.isfinite(result.duration))
    for d in np.linspace(-0.6, 0.6, 21)[never][::5]:
        motion = ss.simulate(model, d=d, t_end=400.0)
        assert motion.modes[-1].tolist() == [-1, -1]
        assert np.all(motion.v(np.linspace(motion.t[-2] + 1e-3, 400.0, 4000)) < model.V)
        assert f.itinerary(d).endswith("--")


@pytest.mark.parametrize("mu", [1.0, 0.9])
def test_undamped_sliding_is_never_called_endless_for_rounding(mu):
    # Just after a release w = 0, so the amplitudes of sum and difference add up to V or more
    # and keep doing so: some time the belt is reached again, however late.
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu))
    result = ss.event_map(model, max_events=200).evaluate(np.linspace(-0.67, 0.67, 6))
    assert not np.any(result.status == NEVER_SLIPPING)


def test_slow_returns_are_returns():
    parameters, mu, d = SLOW
    f = ss.event_map(ss.TwoBlock(**parameters, friction=ss.Coulomb(mu)))
    result = f.evaluate(d)
    assert result.status == OK
    assert result.n_events > 500
    reference = Coulomb(*parameters.values(), mu).motion(d, max_events=3000)
    assert reference.status == "OK"
    assert reference.n_events == result.n_events
    assert result.value == pytest.approx(float(reference.value), abs=1e-9)
    assert f.derivative(d) == result.derivative
    assert math.isfinite(result.derivative)


def test_motions_that_stay_beside_a_cycle_that_repels_are_returns():
    # Next to a crisis; at first turns seem to contract, by an eigenvalue near -1.
    law = ss.PoppStelter(3.8434627456797505)
    f = ss.event_map(ss.TwoBlock(1.0778539639283231, 1.3381733953886172, 0.3278758051631935, law))
    result = f.evaluate([0.7399307770000393, -0.40472980970002254, 0.7394911495834515])
    assert (result.status == OK).all()
    assert result.n_events.min() > 900


@pytest.mark.parametrize("stepper", LAW_OF)
def test_small_limits_give_up_and_say_so(stepper):
    model = random_model(np.random.default_rng(8), LAW_OF[stepper])
    d = np.linspace(-0.5, 0.5, 21) * model.domain[1]
    free = ss.event_map(model).evaluate(d)
    few = ss.event_map(model, max_events=2).evaluate(d)
    longer = free.n_events > 2
    assert 0 < longer.sum()
    assert np.all(few.status[longer] == EVENT_LIMIT)
    assert np.all(few.n_events[longer] == 2)
    np.testing.assert_array_equal(few.value[~longer], free.value[~longer])
    # Many single slips last equally long, but for rounding, which two engines do differently.
    short = float(np.median(free.duration)) * (1 + 1e-12)
    brief = ss.event_map(model, max_time=short).evaluate(d)
    late = free.duration > short
    assert 0 < late.sum() < late.size
    assert np.all(brief.status[late] == TIME_LIMIT)
    # With a limit on time motions under constant friction go one by one: other roundings.
    np.testing.assert_allclose(brief.value[~late], free.value[~late], rtol=0, atol=1e-15)
    for result in (few, brief):
        lost = result.status != OK
        assert np.all(np.isnan(result.value[lost]))
        assert np.all(np.isnan(result.derivative[lost]))


def test_a_law_that_fails_is_a_status():
    from tests.mechanics.flow.systems import UNTRACED_LAW_9

    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=10.0, friction=UNTRACED_LAW_9)
    result = ss.event_map(model).evaluate([0.1, 0.2])
    assert result.status.tolist() == [ss.status.LAW_FAILED] * 2
    assert np.isnan(result.value).all()
