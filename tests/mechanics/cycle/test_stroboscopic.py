"""Forced models, looked at once per period of the forcing."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import stickslip as ss

BLOCK = ss.Oscillator(
    V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(2.0, 0.7)
)


def test_values_are_those_of_the_motion_in_time() -> None:
    chain = ss.Chain(
        static=[1, 1.2],
        alpha=0.8,
        V=0.3,
        friction=ss.PoppStelter(gamma=2),
        damping=0.1,
        forcing=ss.Harmonic([0.4, 0.0], 1.3, 0.5),
    )
    f = ss.stroboscopic_map(chain)
    x, v = chain.sample_state(3)
    end = ss.simulate(chain, x, v, t_end=f.period).final_state
    np.testing.assert_allclose(f(np.concatenate([x, v])), [*end.x, *end.v], rtol=0, atol=1e-14)
    later = ss.simulate(chain, x, v, t_end=4 * f.period).final_state
    orbit = f.iterate(np.concatenate([x, v]), 4)
    np.testing.assert_allclose(orbit[-1], [*later.x, *later.v], rtol=0, atol=1e-12)


def test_the_jacobian_without_events_is_that_of_the_linear_motion() -> None:
    """A block that slips all the time: the exponential of a damped oscillator's matrix."""
    block = ss.Oscillator(
        V=5.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(0.3, 1.7)
    )
    f = ss.stroboscopic_map(block)
    with mp.workdps(30):  # scipy's expm errs by 1.6e-14 here
        expected = mp.expm(mp.matrix([[0.0, 1.0], [-1.0, -0.2]]) * 2 * mp.pi / mp.mpf(1.7))
    expected = np.array(expected.tolist(), dtype=float)
    np.testing.assert_allclose(f.derivative([0.4, 0.2]), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_the_jacobian_through_events_is_the_slope_of_the_map(seed: int) -> None:
    f = ss.stroboscopic_map(BLOCK.replace(V=0.2, friction=ss.PoppStelter(gamma=3)))
    state = np.concatenate(f.model.sample_state(seed))
    h = 1e-6
    ahead, behind = (f(state + sign * h * np.eye(2)) for sign in (1, -1))
    np.testing.assert_allclose(f.derivative(state), (ahead - behind).T / (2 * h), rtol=0, atol=2e-8)


def test_sticking_forgets_exactly() -> None:
    """At rest on the belt a push of the velocity changes nothing; a stick leaves rank one."""
    f = ss.stroboscopic_map(BLOCK.replace(forcing=ss.Harmonic(1.2, 0.7, math.pi / 2)))
    jacobian = f.derivative([0.1, 0.0])
    np.testing.assert_array_equal(jacobian[:, 1], 0.0)
    assert np.isneginf(f.lyapunov_exponents([0.1, 0.0], 50)[-1])


def test_periodic_points_repeat_and_diagrams_find_them() -> None:
    f = ss.stroboscopic_map(BLOCK)
    cycle = f.periodic_point([0.0, 0.0])
    point = np.concatenate([cycle.x, cycle.v])
    times = round(cycle.period / f.period)
    np.testing.assert_allclose(f.iterate(point, times)[-1], point, rtol=0, atol=1e-12)
    visited = f.diagram("forcing.amplitude", [2.0, 2.0], [0.0, 0.0], transient=60, n=4)
    assert visited.shape == (2, 4, 2)
    np.testing.assert_allclose(visited[1, :, :], visited[0, :, :], rtol=0, atol=1e-10)
    assert f.lyapunov_exponents([0.0, 0.0], 60)[0] < 0


def test_multipliers_of_a_forced_cycle_are_slopes_of_the_map() -> None:
    """Damping 0.3 and a law that flattens: two multipliers, complex or real, none forgotten."""
    block = ss.Oscillator(
        V=0.0, friction=ss.PoppStelter(gamma=1), damping=0.1, forcing=ss.Harmonic(4.0, 1.7)
    )
    f = ss.stroboscopic_map(block)
    cycle = f.periodic_point([0.3, 0.0])
    assert cycle.events
    point, h = np.concatenate([cycle.x, cycle.v]), 1e-6
    times = round(cycle.period / f.period)
    ahead, behind = (f.iterate(point + sign * h * np.eye(2), times)[:, -1] for sign in (1, -1))
    values = np.linalg.eigvals((ahead - behind).T / (2 * h))
    expected = values[np.argsort(-np.abs(values), kind="stable")]
    np.testing.assert_allclose(np.abs(cycle.multipliers), np.abs(expected), rtol=0, atol=1e-7)
    assert 0 < abs(cycle.multipliers[1]) < 1


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match="unforced"):
        ss.stroboscopic_map(ss.examples.coulomb())
    f = ss.stroboscopic_map(BLOCK)
    with pytest.raises(ValueError, match="2 finite numbers"):
        f([0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="n = "):
        f.iterate([0.0, 0.0], 0)
    assert f.period == pytest.approx(2 * math.pi / 0.7)


@pytest.mark.parametrize("start", [0.5, 0.45, -0.6])
def test_a_cycle_with_multiplier_one_is_found_as_well_as_rounding_lets(start: float) -> None:
    """Newton's method comes to such a cycle slowly: half of the way in each step.

    Force cos(2t/3) / 0.9 on a block at rest on the ground: it sticks from t = pi/2 to pi.
    """
    forcing = ss.Harmonic(amplitude=1 / 0.9, frequency=2 / 3)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=1.0), forcing=forcing)
    cycle = ss.stroboscopic_map(block).periodic_point([start, 0.0])
    np.testing.assert_allclose(cycle.multipliers, [1.0, 0.0], rtol=0, atol=1e-4)
    times = np.sort([event.time for event in cycle.events])
    np.testing.assert_allclose(times, np.pi * np.array([0.5, 1, 2, 2.5]), rtol=0, atol=1e-4)
