"""A motion in physical units obeys the physical equations (5)-(7)."""

import numpy as np
import pytest

from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units

PHYSICAL = {"m": 2.0, "k": 50.0, "k12": 60.0, "fs1": 10.0, "fs2": 13.0, "v_dr": 0.3}


@pytest.fixture(scope="module")
def model():
    return TwoBlock.from_physical(**PHYSICAL, friction=PoppStelter(gamma=3.0))


@pytest.fixture(scope="module")
def motion(model):
    return model.to_physical(simulate(model, d=0.3, t_end=30.0))


def test_slipping_blocks_obey_newton(model, motion):
    """Eq. (7): m a + k x + k12 (x - x') = friction, a by differences inside long slips."""
    m, k, k12 = PHYSICAL["m"], PHYSICAL["k"], PHYSICAL["k12"]
    h = 1e-5
    checked = 0
    for start, end, modes in zip(motion.t[:-1], motion.t[1:], motion.modes, strict=True):
        if end - start < 0.01:
            continue
        t = start + (end - start) * np.linspace(0.2, 0.8, 7)
        a = (motion.v(t + h) - motion.v(t - h)) / (2 * h)
        x = motion.x(t)
        force = m * a + k * x + k12 * (x - x[:, ::-1])
        np.testing.assert_allclose(force, motion.friction(t), rtol=0, atol=1e-6)
        checked += int(np.any(modes))
    assert checked >= 4


def test_riding_blocks_move_with_the_belt(motion):
    rides = np.argwhere(motion.modes == 0)
    assert rides.size
    for phase, block in rides:
        middle = 0.5 * (motion.t[phase] + motion.t[phase + 1])
        assert motion.v(middle)[block] == pytest.approx(PHYSICAL["v_dr"], rel=1e-14)


def test_friction_stays_within_the_static_limits(motion):
    force = np.abs(motion.friction(np.linspace(0.0, motion.t[-1], 2001)))
    assert np.all(force <= np.array([PHYSICAL["fs1"], PHYSICAL["fs2"]]) * (1 + 1e-12))


def test_energy_is_physical_and_balanced(motion):
    t = np.linspace(0.0, motion.t[-1], 101)
    energy, v = motion.energy(t), motion.v(t)
    np.testing.assert_allclose(energy.kinetic, 0.5 * PHYSICAL["m"] * np.sum(v**2, -1), rtol=1e-12)
    np.testing.assert_allclose(energy.balance, energy.balance[0], rtol=1e-11)


def test_events_slips_and_d_are_scaled(model, motion):
    plain, units = motion.trajectory, model.units
    time, length = units.scale("time"), units.scale("displacement")
    assert motion.events[0].time == time * plain.events[0].time
    assert motion.events[0][1:] == plain.events[0][1:]
    assert motion.slips[0].moment == length * plain.slips[0].moment
    assert motion.slips[0].blocks == plain.slips[0].blocks
    np.testing.assert_allclose(motion.d, length * plain.d, rtol=1e-14)
    assert motion.status == plain.status


def test_the_last_instant_can_be_asked_for(motion):
    assert motion.x(motion.t[-1]).shape == (2,)
    with pytest.raises(ValueError, match="outside the trajectory"):
        motion.x(motion.t[-1] * 1.001)


def test_a_dimensionless_model_needs_units():
    model = TwoBlock(1.2, 1.3, 0.1, PoppStelter(gamma=3.0))
    trajectory = simulate(model, d=0.1, until="stick")
    with pytest.raises(ValueError, match="no physical scales"):
        model.to_physical(trajectory)
    assert model.to_physical(trajectory, Units(1, 1, 2)).d[0] == 2.0 * trajectory.d[0]


def test_its_words_tell_physical_times(motion):
    head, *events = repr(motion).splitlines()[1:]
    assert f"t = 0 .. {motion.t[-1]:.6g}," in head
    assert f"t = {motion.events[0].time:<12.8g}" in events[0]
