"""Operations of JAX have the package's values, and derivatives that are limits of differences."""

import sys

import numpy as np
import pytest

import stickslip as ss
from stickslip.errors import MissingExtraError

V = 0.0366
MODEL = ss.examples.coulomb(V=V)
BLOCK = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1)


@pytest.fixture
def jax():
    """JAX, with double precision as long as a test runs."""
    jax = pytest.importorskip("jax", reason="the extra jax is not installed")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


def test_the_event_map_has_values_and_slopes_in_batches(jax):
    from stickslip import jax as operations

    f, exact = operations.event_map(MODEL, "mu", "V"), ss.event_map(MODEL)
    d, own = np.linspace(-0.2, 0.3, 7), np.array([0.22, V])
    np.testing.assert_array_equal(jax.jit(f)(d, own), exact(d))
    by_d, by_own = jax.vmap(jax.grad(f, argnums=(0, 1)), in_axes=(0, None))(d, own)
    np.testing.assert_allclose(by_d, exact.derivative(d), rtol=1e-12)
    np.testing.assert_allclose(by_own[:, 0], exact.parameter_derivative(d, "mu"), rtol=1e-12)
    forward = jax.jacfwd(lambda p: f(d, p))(own)
    np.testing.assert_allclose(forward, by_own, rtol=1e-12)
    several = np.array([[0.22, V], [0.25, V], [0.22, -1.0]])
    values = jax.vmap(f, in_axes=(None, 0))(0.1, several)
    np.testing.assert_array_equal(
        values[:2], [exact(0.1), ss.event_map(MODEL.replace(mu=0.25))(0.1)]
    )
    assert np.isnan(values[2])  # no such model
    assert np.isnan(f(5.0, own))  # outside the domain


def test_an_orbit_is_differentiated_through_the_map(jax):
    from stickslip import jax as operations

    f, own = operations.event_map(MODEL, "mu"), np.array([0.22])

    def last(mu):
        return jax.lax.fori_loop(0, 3, lambda _, d: f(d, mu), 0.1)

    assert last(own) == pytest.approx(ss.event_map(MODEL).iterate(0.1, 3)[-1], rel=1e-12)
    slope = jax.jacfwd(last)(own)[0]
    near = [ss.event_map(MODEL.replace(mu=0.22 + k * 1e-5)).iterate(0.1, 3)[-1] for k in (-1, 1)]
    assert slope == pytest.approx((near[1] - near[0]) / 2e-5, rel=1e-6)


def test_a_motion_and_its_gradient(jax):
    from stickslip import jax as operations

    t = np.linspace(0.0, 30.0, 40)
    f = operations.motion(BLOCK, t, "mu", "damping")
    start, own = (np.array([0.1]), np.array([0.0])), np.array([0.5, 0.1])
    trajectory = ss.simulate(BLOCK, *start, t_end=30.0)
    states = np.hstack([trajectory.x(t), trajectory.v(t)])
    np.testing.assert_array_equal(f(*start, own), states)
    by = trajectory.derivative("x0", "v0", "mu", "damping")
    expected = np.concatenate([by.x(t), by.v(t)], axis=1)
    by_x, by_v, by_own = jax.jacrev(f, argnums=(0, 1, 2))(*start, own)
    np.testing.assert_allclose(np.dstack([by_x, by_v, by_own]), expected, rtol=1e-10, atol=1e-12)
    both = jax.vmap(f, in_axes=(None, None, 0))(*start, np.array([own, own * 1.1]))
    assert both.shape == (2, 40, 2)
    np.testing.assert_array_equal(both[0], states)
    with pytest.raises(ValueError, match="ascending"):
        operations.motion(BLOCK, [1.0, 0.5])


def test_the_period_of_a_cycle(jax):
    from stickslip import jax as operations

    f, own = operations.period(BLOCK, [0.0], [0.0], "V", "mu"), np.array([0.2, 0.5])
    cycle = ss.find_cycle(BLOCK, [0.0], [0.0])
    assert f(own) == cycle.period
    np.testing.assert_allclose(
        jax.jit(jax.grad(f))(own), cycle.period_derivative("V", "mu"), rtol=1e-12
    )
    assert np.isnan(f(np.array([30.0, 0.5])))  # slides
    with pytest.raises(ValueError, match="two blocks"):
        operations.event_map(BLOCK)


def test_single_precision_is_rounded(jax):
    from stickslip import jax as operations

    jax.config.update("jax_enable_x64", False)
    f = operations.event_map(MODEL, "mu")
    value, slope = jax.value_and_grad(f)(0.1, np.array([0.22]))
    assert value.dtype == np.float32
    assert float(value) == pytest.approx(ss.event_map(MODEL)(0.1), rel=1e-5)
    assert float(slope) == pytest.approx(ss.event_map(MODEL).derivative(0.1), rel=1e-5)


def test_without_jax_the_extra_is_named(monkeypatch):
    monkeypatch.delitem(sys.modules, "stickslip.jax", raising=False)
    monkeypatch.setattr("stickslip.extras.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"stickslip\[jax\]"):
        import stickslip.jax  # noqa: F401
