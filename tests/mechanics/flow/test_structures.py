"""Plants with dry contacts nobody tuned for, against a plain integration and differences."""

from __future__ import annotations

import numpy as np
import pytest
from tests.reference.structures import FEW_LAWS, LAWS, Plain, random_structure
from tests.sizes import slow

import stickslip as ss
from stickslip.mechanics.cycle.shooting import Shooter, State
from stickslip.mechanics.flow.trajectory import EVENT_KINDS

MODES = {kind: mode for mode, kind in EVENT_KINDS.items()}
T_END = 6.0
FINE = 0.001  # steps of the reference where it may have missed a brief excursion


def drawn(
    seed: int, laws: tuple[ss.FrictionLaw, ...] = FEW_LAWS
) -> tuple[ss.Structure, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    model = random_structure(rng, laws)
    n = len(model.mass)
    return model, rng.normal(size=n) * 0.5, rng.normal(size=n) * 0.5


def events_of(motion: ss.Trajectory) -> list[tuple[int, int]]:  # type: ignore[name-defined]
    return [(event.block - 1, MODES[event.kind]) for event in motion.events]


BATCHES = [
    pytest.param(range(12), FEW_LAWS, id="few laws"),
    pytest.param(range(12, 40), FEW_LAWS, marks=pytest.mark.slow, id="few laws, from 12"),
    *(
        pytest.param(range(k, k + 40), LAWS, marks=pytest.mark.slow, id=f"from {k}")
        for k in range(0, 240, 40)
    ),
]


@pytest.mark.parametrize(("seeds", "laws"), BATCHES)
def test_random_structures_move_as_a_plain_integration_says(
    seeds: range, laws: tuple[ss.FrictionLaw, ...]
) -> None:
    for seed in seeds:
        model, q, v = drawn(seed, laws)
        motion = ss.simulate(model, q, v, t_end=T_END, record="events")
        expected = Plain(model).follow(q, v, T_END)
        if events_of(motion) != [event[1:] for event in expected.events]:
            expected = Plain(model).follow(q, v, T_END, FINE)
        assert events_of(motion) == [event[1:] for event in expected.events], seed
        assert (motion.status == ss.status.CONTACT_LOST) == expected.lost, seed
        end = motion.final_state
        off = (end.t - expected.t, *(end.x - expected.q), *(end.v - expected.v))
        assert np.abs(off).max() < 1e-11, seed


@pytest.mark.parametrize("seed", [*range(5), *slow(*range(5, 12))])
def test_tangents_are_the_limits_of_differences(seed: int) -> None:
    model, q, v = drawn(seed)
    shooter = Shooter(model)
    start = shooter.start(q, v)
    leg = shooter.leg(start, 1000, max_time=3.0)
    if leg.status:
        return
    word = [event[1:] for event in leg.events]

    def end(model: ss.Structure, z: np.ndarray) -> np.ndarray | None:
        found = Shooter(model, tangents=False).leg(State(z, start.mode), 1000, max_time=3.0)
        return found.state.z if [event[1:] for event in found.events] == word else None

    def check(exact: np.ndarray, move) -> None:  # type: ignore[no-untyped-def]
        try:
            ends = [move(k * 1e-4) for k in (-2, -1, 1, 2)]
        except ValueError:
            return  # a parameter at the end of its range
        if any(value is None for value in ends):
            return  # other modes beside
        far_low, low, high, far_high = ends
        expected = (8 * (high - low) - (far_high - far_low)) / 12e-4
        assert np.abs(exact - expected).max() < 1e-8 * (1.0 + np.abs(expected).max())

    for name, value in model.parameters.items():
        change = Shooter(model, parameter=name).leg(start, 1000, max_time=3.0).parameter
        check(change, lambda h, n=name, p=value: end(model.replace(**{n: p + h}), start.z))
    for j in np.flatnonzero(start.free):
        unit = np.eye(len(start.z))[j]
        check(leg.tangent[:, j], lambda h, unit=unit: end(model, start.z + h * unit))


@pytest.mark.parametrize("seed", range(3, 13))
def test_energy_balances(seed: int) -> None:
    model, q, v = drawn(seed)
    motion = ss.simulate(model, q, v, t_end=T_END)
    energy = motion.energy(np.linspace(0.0, motion.t[-1], 40))
    assert np.ptp(energy.balance) < 1e-12 * (1.0 + np.abs(energy.dissipation).max())


def test_two_rubbing_bodies_come_to_move_as_one() -> None:
    law = ss.Coulomb(mu=0.5)
    model = ss.Structure(
        mass=[1.0, 2.0], stiffness=np.zeros((2, 2)), contacts=[ss.Contact(at=(0, 1), friction=law)]
    )
    motion = ss.simulate(model, [0.0, 0.0], [1.0, -0.5], t_end=5.0)
    # The relative speed 1.5 falls at the rate mu (1 / m_1 + 1 / m_2); the momentum is 0.
    np.testing.assert_allclose(motion.t[1], 1.5 / (0.5 * 1.5), rtol=1e-15)
    t = np.linspace(0.0, 5.0, 50)
    np.testing.assert_allclose(motion.v(t) @ [1.0, 2.0], 0.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(motion.final_state.v, 0.0, rtol=0, atol=1e-15)
    assert motion.modes.ravel().tolist() == [1, 0]


def test_a_contact_whose_load_vanishes_ends_the_motion() -> None:
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=1.0, load=[0.0, 1.0])
    model = ss.Structure(mass=[1.0, 1.0], stiffness=np.eye(2), contacts=[contact])
    motion = ss.simulate(model, [0.0, 0.0], [0.0, -2.0], t_end=10.0)  # x_2 = -2 sin t
    assert motion.status == ss.status.CONTACT_LOST
    np.testing.assert_allclose(motion.t[-1], np.pi / 6, rtol=1e-14)
    np.testing.assert_allclose(motion.final_state.x[1], -1.0, rtol=1e-14)


@pytest.mark.parametrize("hunts", [False, True])
def test_an_axis_with_integral_action_hunts_where_friction_falls(hunts: bool) -> None:
    """x'' = -ki int x - kp x - kd x' + f: Armstrong and Amin (1996)."""
    ki, kp, kd = 1.5, 4.0, 0.6
    law = ss.Coulomb(mu=0.5 if hunts else 1.0)
    model = ss.Structure.from_state_space(
        A=[[0, 1, 0], [0, 0, 1], [-ki, -kp, -kd]],
        B=[[0], [0], [1]],
        C=[[0, 0, 1]],
        contacts=[ss.Contact(at=0, friction=law)],
    )
    with pytest.raises(ValueError, match=r"v = \[0.0\] .* the state .* is x alone. Leave v out"):
        ss.simulate(model, [0.0, 1.0, 0.0], [0.0], t_end=1.0)
    motion = ss.simulate(model, [0.0, 1.0, 0.0], t_end=200.0)
    sticks = [event.time for event in motion.events if event.kind == "stick"]
    if not hunts:  # every stick is shorter in place than the one before: it creeps to zero
        places = np.abs(motion.x(sticks)[:, 1])
        assert places[-1] < 0.1 * places[0]
        return
    cycle = ss.find_cycle(model, motion.final_state.x, None)  # type: ignore[arg-type]
    stick, leave = (e for e in cycle.trajectory.events[:2])
    if stick.kind != "stick":
        stick, leave = (e for e in cycle.trajectory.events[1:3])
    integral, x, _ = cycle.trajectory.x(stick.time)
    # While it sticks, ki times the integral grows at the rate ki x until the limit is reached.
    waiting = (np.sign(x) - (ki * integral + kp * x)) / (ki * x)
    np.testing.assert_allclose(leave.time - stick.time, waiting, rtol=1e-10)
    assert cycle.stable
    assert len(cycle.events) == 4


def test_a_harmonic_without_amplitude_moves_nothing() -> None:
    law = ss.PoppStelter(gamma=3.0)
    plain, still = (
        ss.Structure(
            mass=[1.0, 1.0],
            stiffness=[[2.2, -1.2], [-1.2, 2.2]],
            contacts=[ss.Contact(at=k, friction=law, V=V) for k in range(2)],
        )
        for V in (0.1, (0.1, ss.Harmonic(0.0, 3.0)))
    )
    start = [0.5, 0.2], [0.0, 0.1]
    motion, same = (ss.simulate(model, *start, t_end=60.0) for model in (plain, still))
    assert len(motion.events) > 10
    assert [event.kind for event in same.events] == [event.kind for event in motion.events]
    np.testing.assert_allclose(same.x(60.0), motion.x(60.0), rtol=1e-11)
    with pytest.raises(ValueError, match="forced model has no event map"):
        ss.event_map(still)


def test_a_mass_that_no_spring_holds_slips_until_it_rides_on_the_belt() -> None:
    free = ss.Structure(
        mass=[2.0],
        stiffness=[[0.0]],
        contacts=[ss.Contact(at=0, V=0.3, friction=ss.Coulomb(mu=0.5))],
    )
    motion = ss.simulate(free, [0.1], [-0.2], t_end=5.0)
    (rides,) = motion.events
    assert rides.kind == "stick"
    assert rides.time == pytest.approx(2.0, rel=1e-14)  # speed 0.5 at the rate 0.25
    assert motion.final_state.x[0] == pytest.approx(0.1 + 0.1 + 0.3 * 3.0, rel=1e-13)


def running_away(law: ss.FrictionLaw) -> ss.Structure:
    """2 x'' = 50 x, and friction."""
    return ss.Structure(
        mass=[2.0], stiffness=[[-50.0]], contacts=[ss.Contact(at=0, V=0.0, friction=law)]
    )


def test_a_motion_that_grows_without_bound_takes_no_smaller_steps_for_it() -> None:
    """Steps that kept rounding absolute took 400 times as many up to 1e60, and had no end here."""
    model = running_away(ss.Coulomb(mu=0.5))
    motion = ss.simulate(model, [0.1], [0.0], t_end=60.0)
    assert len(motion.events) == 0
    at, rate = 0.01, 5.0  # where friction and spring would balance; it starts with ten times that
    np.testing.assert_allclose(
        motion.final_state.x, at + (0.1 - at) * np.cosh(rate * 60.0), rtol=1e-11
    )
    motion = ss.simulate(model, [0.1], [0.0], t_end=200.0)  # beyond 1e308 from 142 on
    assert motion.status == ss.status.STEP_FAILED
    assert 140.0 < motion.final_state.t < 142.0
    assert np.isfinite(motion.final_state.x).all()
    with pytest.raises(ValueError, match="grew beyond all numbers"):
        ss.find_cycle(model, [0.1], [0.0])


def test_a_law_without_a_value_ends_a_motion_there() -> None:
    law = ss.friction_law("0.5 + 0.01*sqrt(12 - s)")
    motion = ss.simulate(running_away(law), [0.1], [0.0], t_end=5.0)
    assert motion.status == ss.status.LAW_FAILED
    assert motion.final_state.v[0] == pytest.approx(12.0, rel=0.1)
