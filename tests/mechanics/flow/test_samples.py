"""A motion at even times in one call, as pages without a server show it."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.mechanics.flow.engine import FLOW, engine_for
from stickslip.numerics.targets import instantiate


def sampled(model, d, most):
    """Rows of a motion to t = 60, their modes, and how many there are with its status."""
    engine = engine_for(model)
    kernels = instantiate(f"{FLOW}._samples_kernels", engine.key, advance=engine.kernels.advance)
    rows, modes = np.zeros((most, 5)), np.zeros((most, 2), dtype=np.int8)
    count = np.zeros(2, dtype=np.int64)
    motion, work = engine.new_motion(engine.directions()), engine.new_work()
    system, laws = engine.system, engine.laws
    kernels.sample(system, laws, d, 60.0, 0.125, motion, work, 1e-15, rows, modes, count)
    return rows, modes, count


@pytest.mark.parametrize("law", [ss.Coulomb(mu=0.22), ss.PoppStelter(gamma=3.0)], ids=str)
@pytest.mark.parametrize("d", [0.1, -0.3])
def test_samples_are_those_of_the_motion(law, d):
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    rows, modes, (n, status) = sampled(model, d, 2000)
    assert status == ss.status.OK
    expected = ss.simulate(model, d=d, t_end=60.0)
    t = rows[:n, 0]
    assert np.isin(np.arange(481) * 0.125, t).all()
    for event in expected.t:
        assert np.abs(t - event).min() < 1e-11
    np.testing.assert_allclose(rows[:n, 1:3] + model.V, expected.v(t), rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(rows[:n, 3:], expected.needed_force(t), rtol=1e-9, atol=1e-11)
    inside = np.abs(t[:, None] - expected.t).min(axis=1) > 1e-9
    phase = np.searchsorted(expected.t, t[inside], side="right") - 1
    np.testing.assert_array_equal(modes[:n][inside][:-1], expected.modes[phase[:-1]])


def test_a_motion_that_ends_before_its_time_says_so():
    rows, _, count = sampled(ss.examples.coulomb(), 0.1, 100)
    assert rows[-1, 0] < 60.0
    assert count.tolist() == [100, ss.status.EVENT_LIMIT]
