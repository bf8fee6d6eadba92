"""Motions of one block, chains and damped or forced models, in time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.sizes import sizes

import stickslip as ss
from stickslip import status


def test_one_block_with_constant_friction_has_the_closed_form_period() -> None:
    """Slip from 1 at velocity V on an arc about mu, back to V, then ride."""
    mu, V = 0.4, 0.2
    motion = ss.simulate(ss.Oscillator(V=V, friction=ss.Coulomb(mu=mu)), [1.0], [V], t_end=100)
    landings = [event.time for event in motion.events if event.kind == "stick"]
    period = 2 * math.pi - 2 * math.atan2(1 - mu, V) + 2 * (1 - mu) / V
    np.testing.assert_allclose(np.diff(landings), period, rtol=1e-13)


MODELS = {
    "free": ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3)),
    "forced": ss.Oscillator(
        V=0.2,
        friction=ss.PoppStelter(gamma=3),
        damping=0.02,
        forcing=ss.Harmonic(amplitude=0.5, frequency=1.3, phase=0.4),
    ),
    "belt at rest": ss.Oscillator(
        V=0.0, friction=ss.Coulomb(mu=0.5), forcing=ss.Harmonic(amplitude=2.0, frequency=0.7)
    ),
    "overdamped": ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.3), damping=5.0),
    "chain": ss.Chain(
        static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.PoppStelter(gamma=3), damping=0.1
    ),
}


def test_a_reversed_force_reverses_the_motion() -> None:
    """(X, V) -> -(X, V): forces change sign, numbers for slip either way change places."""

    def backward(s, a, b, c, d):
        return a / (1 + b * s)

    def forward(s, a, b, c, d):
        return c / (1 + d * s)

    def motion(sign: int, *numbers: float) -> ss.Trajectory:
        parameters = dict(zip("abcd", numbers, strict=True))
        law = ss.friction_law(backward, forward=forward, parameters=parameters)
        forcing = ss.Harmonic(amplitude=(sign * 2.0, sign * 0.3), frequency=0.7, phase=0.4)
        chain = ss.Chain(static=[1, 1.3], alpha=0.6, V=0.0, friction=law, forcing=forcing)
        return ss.simulate(chain, [0.3 * sign, 0.1 * sign], [0.2 * sign, 0.0], t_end=60)

    one, mirrored = motion(1, 1.0, 0.5, 0.8, 1.0), motion(-1, 0.8, 1.0, 1.0, 0.5)
    np.testing.assert_array_equal(mirrored.modes, -one.modes)
    assert {-1, 0, 1} == set(one.modes.ravel())
    t = np.linspace(0, 60, 100)
    np.testing.assert_allclose(mirrored.x(t), -one.x(t), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", MODELS)
def test_energy_is_accounted_for(name: str) -> None:
    model = MODELS[name]
    x, v = model.sample_state(3)
    motion = ss.simulate(model, x, v, t_end=60)
    t = np.linspace(0, 60, 200)
    balance = motion.energy(t).balance
    assert np.ptp(balance) < 1e-12 * max(1.0, np.abs(balance).max())


@pytest.mark.parametrize("name", MODELS)
def test_slip_phases_solve_the_equations(name: str) -> None:
    """Each phase again by Runge and Kutta, from its start to its end."""
    model = MODELS[name]
    s = model.plant
    motion = ss.simulate(model, *model.sample_state(5), t_end=12)
    for start, end, mode in zip(motion.t, motion.t[1:], motion.modes, strict=False):
        middle = 0.5 * (start + end)

        def rates(t: float, y: np.ndarray, mode: np.ndarray = mode) -> np.ndarray:
            x, v = np.split(y, 2)
            speed = np.maximum(mode * (v - s.V), 0.0)
            force = [law.force(u) for law, u in zip(model.laws, speed, strict=True)]
            a = (-mode * s.static * force - s.needed_force(x, v, t)) / s.mass
            return np.concatenate([v, np.where(mode == 0, 0.0, a)])

        y = np.concatenate([motion.x(start), motion.v(start)])
        found = solve_ivp(rates, (start, middle), y, "DOP853", rtol=1e-12, atol=1e-13)
        expected = np.concatenate([motion.x(middle), motion.v(middle)])
        np.testing.assert_allclose(found.y[:, -1], expected, rtol=0, atol=1e-10)


def test_a_motion_goes_on_from_where_it_ended() -> None:
    model = MODELS["chain"]
    x, v = model.sample_state(3)
    whole = ss.simulate(model, x, v, t_end=40)
    first = ss.simulate(model, x, v, t_end=17)
    rest = ss.simulate(model, first.final_state.x, first.final_state.v, t_end=23)
    np.testing.assert_allclose(rest.final_state.x, whole.final_state.x, rtol=0, atol=1e-11)
    orbit = ss.event_map(model).iterate(whole.d[0], len(whole.d) - 1)
    np.testing.assert_allclose(orbit, whole.d, rtol=0, atol=1e-11)


def test_start_on_the_belt() -> None:
    model = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.Coulomb(mu=0.22))
    d = model.sample_domain(1, 2)[0]
    motion = ss.simulate(model, d=d, until="stick")
    np.testing.assert_allclose(motion.d[-1], ss.event_map(model)(d), rtol=0, atol=1e-15)
    with pytest.raises(ValueError, match="3 finite numbers"):
        ss.simulate(model, [0.0], [0.0], t_end=1)
    with pytest.raises(ValueError, match="give x= and v="):
        ss.simulate(MODELS["forced"], d=[], t_end=1)


@pytest.mark.parametrize("limit", sizes(1_000, 20_000))
def test_a_long_chain_is_followed(limit: int) -> None:
    """All events of 100 blocks, or a return before: chaos leaves that to rounding."""
    limits = 1 + 0.3 * np.random.default_rng(1).random(100)
    chain = ss.Chain(static=limits, alpha=1.2, V=0.0366, friction=ss.Coulomb(mu=0.22))
    found = ss.event_map(chain, max_events=limit).evaluate(chain.sample_domain(1, 3))
    if found.status == status.OK:
        assert chain.contains(found.value).all()
        assert found.n_events > 100
    else:
        assert found.status == status.EVENT_LIMIT
        assert found.n_events == limit
        assert 0.025 < found.duration / limit < 0.25


@pytest.mark.parametrize(("V", "speed"), [(0.3, 0.02), (0.3, 0.1), (0.1, 0.02)])
def test_a_force_that_rises_at_low_speed_alone_is_not_stepped_over(V: float, speed: float) -> None:
    # Beyond a few times that speed its series is that of constant friction, to rounding.
    def landing(stiffness: np.ndarray, limits: np.ndarray, start: np.ndarray) -> np.ndarray:
        n = len(limits)

        def rates(_: float, y: np.ndarray) -> np.ndarray:
            friction = limits * (0.4 + 0.6 * np.exp(-(((V - y[n:]) / speed) ** 2)))
            return np.concatenate([y[n:], friction - stiffness @ y[:n]])

        def slowest(_: float, y: np.ndarray) -> float:
            return V - max(y[n:])

        slowest.terminal = True
        y = np.concatenate([start, np.zeros(n)])
        close = {"rtol": 1e-13, "atol": 1e-15, "max_step": 2e-3}
        return solve_ivp(rates, (0, 9), y, "DOP853", events=slowest, **close).t_events[0]

    law = ss.Stribeck(0.4, speed, exponent=2)
    alone = ss.Oscillator(V=V, friction=law)
    two = ss.TwoBlock(alpha=1.2, beta=1.3, V=V, friction=law)
    for model, stiffness, limits, start in (
        (alone, np.eye(1), np.ones(1), np.array([3 * V])),
        (two, np.array([[2.2, -1.2], [-1.2, 2.2]]), np.array([1.0, 1.3]), np.array([0.9, 0.7])),
    ):
        motion = ss.simulate(model, start, np.zeros(len(start)), t_end=9.0)
        expected = landing(stiffness, limits, start)
        np.testing.assert_allclose(motion.events[0].time, expected, rtol=0, atol=1e-12)
    f = ss.event_map(two.replace(V=0.1))  # all motions return
    for d in np.linspace(-0.6, 0.6, 7):
        back = ss.simulate(f.model, d=d, until="stick").d[-1]
        np.testing.assert_allclose(f(d), back, rtol=0, atol=1e-12 * max(1, abs(f.derivative(d))))
