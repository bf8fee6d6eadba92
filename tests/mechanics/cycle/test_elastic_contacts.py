"""Cycles of structures with elastic contacts: a blade with an underplatform damper."""

from __future__ import annotations

import numpy as np
import pytest
from tests.mechanics.flow.test_elastic_contacts import blade
from tests.sizes import slow

import stickslip as ss
from stickslip.mechanics.cycle.mode_changes import touches
from stickslip.mechanics.cycle.shooting import Shooter


def response(force: float, frequencies: np.ndarray) -> np.ndarray:
    """Amplitudes of the blade's cycles over the frequency of the force."""
    found = []
    x, v = [0.0], [0.0]
    for frequency in frequencies:
        cycle = ss.find_cycle(blade(force=force, frequency=frequency, damping=0.1), x, v)
        assert np.abs(cycle.multipliers).max() <= 1.0 + 1e-9  # 1: a foot that never slips
        x, v = cycle.x, cycle.v
        places = cycle.trajectory.x(np.linspace(0.0, cycle.period, 401))[:, 0]
        found.append(np.ptp(places) / 2.0)
    return np.array(found)


def test_the_resonance_moves_from_that_of_the_stuck_blade_to_that_of_the_free_one() -> None:
    frequencies = np.linspace(0.8, 1.9, 23)
    weak, medium, strong = (response(force, frequencies) for force in (0.02, 0.4, 20.0))
    linear = 0.02 / np.abs(3.0 - frequencies**2 + 0.1j * frequencies)  # never slips
    assert weak.max() < 0.5  # L / k_t
    np.testing.assert_allclose(weak, linear, rtol=1e-4)  # maxima among samples
    peaks = [frequencies[np.argmax(each)] for each in (weak, medium, strong)]
    assert peaks[0] == pytest.approx(np.sqrt(3.0), abs=0.05)
    assert peaks[2] == pytest.approx(1.0, abs=0.05)
    assert peaks[2] < peaks[1] < peaks[0]
    # Friction of amplitude L takes energy 4 L (X - L / k_t) a period: near resonance it bounds X.
    assert medium.max() / 0.4 < 0.6 * min(weak.max() / 0.02, strong.max() / 20.0)


@pytest.mark.parametrize("mu", [1.0, 0.7])
def test_a_forced_cycle_is_a_point_of_the_stroboscopic_map_and_is_followed(mu: float) -> None:
    cycle = ss.find_cycle(blade(mu), [0.0], [0.0])
    f = ss.stroboscopic_map(cycle.model)
    state = np.concatenate([cycle.x, cycle.v])
    np.testing.assert_allclose(f(state), state, rtol=0, atol=1e-12)
    assert [event.kind for event in cycle.events].count("stick") == 2
    free = 2 if cycle.events[0].kind == "stick" else 3  # a sliding foot has no state of its own
    values = f.derivative(state)
    steps = np.eye(4)[[0, 2] if free == 2 else [0, 1, 2]] * 1e-4
    for step in steps:
        far_low, low, high, far_high = (f(state + k * step) for k in (-2, -1, 1, 2))
        expected = (8 * (high - low) - (far_high - far_low)) / 12e-4
        exact = values @ (step / 1e-4)
        np.testing.assert_allclose(exact, expected, rtol=0, atol=1e-8)
    curve = ss.follow(cycle, "contact_stiffness_1", (1.9, 2.1))
    beside = ss.find_cycle(cycle.model.replace(contact_stiffness_1=2.05), [0.0], [0.0])
    there = curve.at(contact_stiffness_1=2.05)
    np.testing.assert_allclose(there.x[0], beside.x[0], rtol=0, atol=1e-11)


@pytest.mark.parametrize("start", [1.075, *slow(1.12)])
def test_a_cycle_is_followed_past_events_at_the_phase_of_its_section(start: float) -> None:
    # A foot comes to rest at its limit always, which is no change of modes: following ended there.
    model = ss.Structure(
        mass=[1.0],
        stiffness=[1.0],
        damping=[0.02],
        contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=1.0), stiffness=1.0)],
        forcing=ss.Harmonic(1.0, start),
    )
    curve = ss.follow(ss.find_cycle(model, [0.0], [0.0]), "forcing.frequency", (1.01, 1.13))
    assert curve.end_reasons == ("end of range", "end of range")
    there = curve.at(**{"forcing.frequency": 1.03})
    beside = ss.find_cycle(model.replace(**{"forcing.frequency": 1.03}), there.x, there.v)
    np.testing.assert_allclose(there.x, beside.x, rtol=0, atol=1e-10)


def test_a_mass_on_a_belt_sticks_and_slips_by_a_spring() -> None:
    """Free cycles begin at an event; at a breakaway with mu < 1 a spring has just relaxed."""
    model = blade(0.4, force=0.0, damping=0.02, V=0.08, stiffness=20.0)
    cycle = ss.find_cycle(model, [0.0], [0.08])
    assert [event.kind for event in cycle.events] == ["slip backward", "stick"]
    assert cycle.stable
    # A start beside comes nearer by the multiplier each time round.
    (largest, *_) = cycle.multipliers
    off = 1e-6
    motion = ss.simulate(
        model, cycle.x + off * np.array([1.0, 0.0]), cycle.v, t_end=3.5 * cycle.period
    )
    sticks = [event.time for event in motion.events if event.kind == "stick"]
    first, second, third = (motion.x(time)[0] - cycle.x[0] for time in sticks[:3])
    assert second / first == pytest.approx(largest.real, abs=1e-4)
    assert third / second == pytest.approx(largest.real, abs=1e-4)


def test_touches_are_collected_after_a_step_without_length() -> None:
    """A foot on a body that rests with another contact rests at once."""
    belt = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.2)
    elastic = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), static=0.5, V=0.2, stiffness=2.0)
    model = ss.Structure(mass=[1], stiffness=[[1]], contacts=[belt, elastic])
    shooter = Shooter(model, tangents=False)
    state = shooter.start(np.array([0.9, 0.0]), np.array([0.2, 0.2]))
    assert max(touch.time for touch in touches(shooter, state, 15.0)) > 12.0


def test_steady_sliding_does_not_feel_a_spring_between() -> None:
    """Friction is constant then: eigenvalues are those of the rigid contact."""
    load = [0.3, 0.0]
    contact = ss.Contact(at=1, friction=ss.Coulomb(mu=0.4), V=0.5, load=load, stiffness=3.0)
    model = ss.Structure(
        [1.0, 2.0], [[2.0, -1.0], [-1.0, 1.5]], 0.1 * np.eye(2), contacts=[contact]
    )
    rigid = model.replace(contacts=[ss.Contact(at=1, friction=contact.friction, V=0.5, load=load)])
    (own,), (other,) = ss.equilibria(model), ss.equilibria(rigid)
    np.testing.assert_allclose(own.eigenvalues, other.eigenvalues, rtol=1e-13)
    np.testing.assert_allclose(own.x[:2], other.x, rtol=1e-14)
    limit = 1.0 + 0.3 * own.x[0]
    np.testing.assert_allclose(3.0 * (own.x[2] - own.x[1]), 0.4 * limit, rtol=1e-14)
