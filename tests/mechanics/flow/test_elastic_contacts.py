"""Elastic contacts: closed forms, a plain integration, differences, limits; refusals."""

from __future__ import annotations

import itertools
import os
import re
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from tests.reference.dormand import Follower
from tests.reference.elastic import Elastic, random_elastic
from tests.reference.structures import LAWS
from tests.sizes import slow

import stickslip as ss
from stickslip.mechanics.cycle.shooting import Shooter, State
from stickslip.mechanics.flow.trajectory import EVENT_KINDS
from stickslip.mechanics.model.arguments import checked_state

MODES = {kind: mode for mode, kind in EVENT_KINDS.items()}
T_END = 6.0
FINE = 0.002  # steps of the reference where it may have missed a brief excursion
ACCURATE = 1e-11  # DOP853's
FULL = ss.Coulomb(mu=1.0)


def blade(
    mu: float = 1.0, force: float = 1.0, frequency: float = 1.2, damping: float = 0.05, **contact
) -> ss.Structure:
    """One mass with an underplatform damper: k = 1, k_t = 2, limit 1."""
    return ss.Structure(
        mass=[1.0],
        stiffness=[[1.0]],
        damping=[[damping]],
        contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=mu), **{"stiffness": 2.0, **contact})],
        forcing=ss.Harmonic(force, frequency) if force else None,
    )


# --- closed forms ---------------------------------------------------------------------------------


def test_a_cycle_runs_round_the_loop_of_masing() -> None:
    cycle = ss.find_cycle(blade(), [0.0], [0.0])
    t = np.linspace(0.0, cycle.period, 501)
    motion = cycle.trajectory
    x, v, force = motion.x(t)[:, 0], motion.v(t)[:, 0], -motion.friction(t)[:, 0]
    turns = [event.time for event in cycle.events if event.kind == "stick"]
    top, bottom = sorted(motion.x(turns)[:, 0], reverse=True)
    amplitude = 0.5 * (top - bottom)
    falling = np.maximum(1.0 - 2.0 * (top - x), -1.0)
    rising = np.minimum(2.0 * (x - bottom) - 1.0, 1.0)
    np.testing.assert_allclose(force, np.where(v < 0.0, falling, rising), rtol=0, atol=1e-12)
    energy = motion.energy([0.0, cycle.period])
    area = 4.0 * (amplitude - 0.5)  # 4 L (amplitude - L / k_t)
    input_work = np.diff(energy.forcing_work)[0]
    assert np.diff(energy.dissipation)[0] == pytest.approx(input_work, rel=1e-12)
    rubbed = input_work - _damper_work(motion, cycle.period)
    assert rubbed == pytest.approx(area, rel=1e-12)


def _damper_work(motion: ss.Trajectory, end: float) -> float:  # type: ignore[name-defined]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    ends = np.unique([0.0, *motion.t, end])
    cuts = np.unique(np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(ends)]))
    total = 0.0
    for a, b in pairwise(cuts):
        v = motion.v(0.5 * (b - a) * (nodes + 1.0) + a)[:, 0]
        total += 0.5 * (b - a) * float(weights @ (0.05 * v * v))
    return total


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_stuck_foot_only_stiffens_until_the_amplitude_is_the_limit_over_the_stiffness(
    share: float,
) -> None:
    model, frequency = blade(force=0.0, damping=0.0), np.sqrt(3.0)
    motion = ss.simulate(model, [0.0], [0.5 * share * frequency], t_end=10.0)
    t = np.linspace(0.0, 10.0, 101)
    if share > 1.0:
        assert motion.events[0].time < 0.5 * np.pi / frequency
        return
    assert not motion.events
    expected = 0.5 * share * np.sin(frequency * t)
    np.testing.assert_allclose(motion.x(t)[:, 0], expected, rtol=0, atol=1e-14)


def test_springs_are_relaxed_and_feet_stick_where_their_state_is_left_out() -> None:
    model = blade(force=0.0, V=0.3)
    short = ss.simulate(model, [0.7], [0.1], t_end=2.0)
    full = ss.simulate(model, [0.7, 0.7], [0.1, 0.3], t_end=2.0)
    assert short.friction(0.0) == 0.0
    assert (short.final_state.x == full.final_state.x).all()
    again = ss.simulate(model, short.final_state.x, short.final_state.v, t_end=1.0)
    whole = ss.simulate(model, [0.7], [0.1], t_end=3.0)
    np.testing.assert_allclose(again.final_state.x, whole.final_state.x, rtol=0, atol=1e-13)


def test_a_spring_relaxes_to_kinetic_friction_as_its_foot_breaks_away() -> None:
    """A belt at speed V stretches the spring of a body held fast; force (1 - mu) L is lost."""
    mu, speed, push, stiffness = 0.1, 0.5, 1.3, 4.0
    contacts = [
        ss.Contact(at=0, friction=FULL, static=1.0),
        ss.Contact(at=0, friction=ss.Coulomb(mu=mu), static=2.0, V=-speed, stiffness=stiffness),
    ]
    model = ss.Structure([1.0], [[1.0]], contacts=contacts, force=[push])
    start = [0.0, -1.0 / stiffness], [0.0, -speed]  # a force 1 in the spring
    motion = ss.simulate(model, *start, t_end=1.5)
    at = (2.0 - 1.0) / (stiffness * speed)  # where it is 2, the limit
    first = motion.events[:2]
    assert [(event.block, event.kind) for event in first] == [
        (1, "slip forward"),  # 1.3 - 0.2 > 1: the rigid contact gives way at the same instant
        (2, "slip forward"),
    ]
    np.testing.assert_allclose([event.time for event in first], at, rtol=1e-14)
    # x'' + x = push - mu L - 1, from rest
    t = np.linspace(at, 1.5, 20)
    expected = (push - mu * 2.0 - 1.0) * (1.0 - np.cos(t - at))
    np.testing.assert_allclose(motion.x(t)[:, 0], expected, rtol=0, atol=1e-14)
    energy = motion.energy(np.linspace(0.0, 1.5, 31))
    assert np.ptp(energy.balance) < 1e-13
    lost = np.diff(motion.energy([at - 1e-9, at]).dissipation)[0]
    assert lost == pytest.approx(0.5 * 4.0 * (1.0 - mu**2) / stiffness, abs=1e-8)


def test_two_bodies_joined_by_an_elastic_contact_keep_their_momentum() -> None:
    joint = ss.Contact(at=(0, 1), friction=ss.Coulomb(mu=0.5), static=0.3, stiffness=3.0)
    model = ss.Structure([1.0, 2.0], np.zeros((2, 2)), contacts=[joint])
    motion = ss.simulate(model, [0.0, 0.0], [1.0, -0.5], t_end=8.0)
    assert [event.kind for event in motion.events] == ["slip forward", "stick"]
    v = motion.v(np.linspace(0.0, 8.0, 50))[:, :2]
    np.testing.assert_allclose(v @ [1.0, 2.0], 0.0, rtol=0, atol=1e-14)


def test_stiff_springs_come_to_be_rigid_contacts() -> None:
    """With F(0) = 1: else vibrations of the spring let the foot go too early, however stiff."""
    rigid = blade(stiffness=None, damping=0.3)
    t = np.linspace(0.0, 20.0, 41)
    expected = ss.simulate(rigid, [1.5], [0.0], t_end=20.0).x(t)[:, 0]
    off = []
    for stiffness in (1e2, 1e4, 1e6):
        motion = ss.simulate(blade(stiffness=stiffness, damping=0.3), [1.5], [0.0], t_end=20.0)
        off.append(np.abs(motion.x(t)[:, 0] - expected).max())
    assert off[0] < 0.2
    assert off[1] < 0.02 * off[0]  # as 1 / stiffness
    assert off[2] < 0.02 * off[1]


def test_a_foot_stays_at_its_limit_while_its_body_rests() -> None:
    contacts = [
        ss.Contact(at=0, friction=FULL, static=1.0),
        ss.Contact(at=0, friction=FULL, static=0.3, stiffness=2.0),
    ]
    model = ss.Structure([1.0], [[0.1]], contacts=contacts)
    motion = ss.simulate(model, [0.0], [1.0], t_end=20.0)
    assert [(event.block, event.kind) for event in motion.events] == [
        (2, "slip forward"),
        (1, "stick"),
        (2, "stick"),
    ]
    np.testing.assert_allclose(motion.friction(20.0)[1], -0.3, rtol=1e-14)


def test_a_foot_sticks_where_another_contact_brings_its_body_to_rest() -> None:
    """Pulled on the same way, it holds up to its limit again: it does not slide on."""
    for seed in (285, 448):
        rng = np.random.default_rng(seed)
        b, half = [rng.uniform(-2, 2)], ss.Coulomb(mu=0.5)
        contacts = [
            ss.Contact(at=b, friction=half, static=0.3, stiffness=5.0),
            ss.Contact(at=0, friction=half, static=0.8),
            ss.Contact(at=0, friction=half, static=0.3, V=ss.Harmonic(0.4, 0.7, 0.3)),
        ]
        forcing = ss.Harmonic(rng.uniform(0.5, 1.5), rng.uniform(0.3, 2.0), rng.uniform(0, 6))
        model = ss.Structure([1.0], [[1.0]], contacts=contacts, forcing=forcing)
        q, v = rng.normal(size=1), rng.normal(size=1)
        motion = ss.simulate(model, q, v, t_end=12.0, record="events")
        events = [(event.time, event.block - 1, MODES[event.kind]) for event in motion.events]
        expected = Follower(model).follow(q, v, 12.0, choices=events)
        assert len(motion.events) == len(expected.events)
        np.testing.assert_allclose(motion.final_state.x[:1], expected.q, rtol=0, atol=1e-12)


# --- against a plain integration ------------------------------------------------------------------


def drawn(seed: int, **kind) -> tuple[ss.Structure, np.ndarray, np.ndarray]:  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(seed)
    model = random_elastic(rng, **kind)
    n = len(model.mass)
    return model, rng.normal(size=n) * 0.5, rng.normal(size=n) * 0.5


def sequence(events: list[tuple[float, int, int]]) -> list[tuple[int, int]]:
    """What happens, contact by contact within an instant: there rounding alone has an order."""
    instants = itertools.groupby(events, key=lambda event: round(event[0], 11))
    return [event[1:] for _, at_once in instants for event in sorted(at_once, key=lambda e: e[1:])]


def check_against_plain(seed: int, **kind) -> None:  # type: ignore[no-untyped-def]
    model, q, v = drawn(seed, **kind)
    motion = ss.simulate(model, q, v, t_end=T_END, record="events")
    events = [(event.time, event.block - 1, MODES[event.kind]) for event in motion.events]
    for step in (0.05, FINE):
        expected = Elastic(model).follow_feet(q, v, T_END, step, events)
        if sequence(events) == sequence(expected.events):
            break
    assert sequence(events) == sequence(expected.events), seed
    assert (motion.status == ss.status.CONTACT_LOST) == expected.lost, seed
    end, n = motion.final_state, len(q)
    off = (end.t - expected.t, *(end.x[:n] - expected.q), *(end.v[:n] - expected.v))
    assert np.abs(off).max() < ACCURATE, seed


BATCHES = [
    range(8),
    *slow(range(8, 20), *(range(k, k + 20) for k in range(20, 240, 20))),
]


@pytest.mark.parametrize("seeds", BATCHES)
def test_random_structures_move_as_a_plain_integration_says(seeds: range) -> None:
    for seed in seeds:
        check_against_plain(seed)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [{"shared": True}, {"laws": LAWS}])
def test_random_structures_that_share_inertia_or_have_falling_laws(kind: dict[str, object]) -> None:
    for seed in range(60):
        check_against_plain(seed, **kind)


def test_structures_that_share_inertia_uncompiled() -> None:
    """Their kernels take long to compile: a few motions run as plain Python."""
    code = """
from tests.mechanics.flow.test_elastic_contacts import check_against_plain
for seed in (3, 23, 24): check_against_plain(seed, shared=True)
"""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)


def test_a_foot_that_is_given_a_slip_against_its_body_begins_at_rest() -> None:
    """The velocity of a sliding foot follows from the body's."""
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), stiffness=2.0, V=0.3)
    model = ss.Structure(mass=[1.0], stiffness=[[1.0]], contacts=[contact])
    motion = ss.simulate(model, [0.1, 0.0], [-0.2, 0.9], t_end=10.0)  # the body moves backward
    assert motion.modes[0].tolist() == [0]
    t = np.linspace(0.0, 10.0, 400)
    slip = motion.v(t)[:, 1] - 0.3
    assert (slip * motion._mode(t)[:, 0] >= -1e-14).all()
    assert motion.x(0.0)[1] == 0.0


# --- tangents -------------------------------------------------------------------------------------


SLOW = pytest.mark.slow


@pytest.mark.parametrize("seed", [0, 3, pytest.param(6, marks=SLOW), pytest.param(7, marks=SLOW)])
def test_tangents_are_the_limits_of_differences(seed: int) -> None:
    model, q, v = drawn(seed)
    start = Shooter(model).start(*checked_state(model, q, v))
    leg = Shooter(model).leg(start, 1000, max_time=3.0)
    word = [event[1:] for event in leg.events]
    assert len(word) > 5
    checked = 0

    def end(model: ss.Structure, z: np.ndarray) -> np.ndarray | None:
        found = Shooter(model, tangents=False).leg(State(z, start.mode), 1000, max_time=3.0)
        return found.state.z if [event[1:] for event in found.events] == word else None

    def check(exact: np.ndarray, move) -> int:  # type: ignore[no-untyped-def]
        try:
            ends = [move(k * 1e-4) for k in (-2, -1, 1, 2)]
        except ValueError:
            return 0  # a parameter at the end of its range
        if any(value is None for value in ends):
            return 0  # other modes beside
        far_low, low, high, far_high = ends
        expected = (8 * (high - low) - (far_high - far_low)) / 12e-4
        assert np.abs(exact - expected).max() < 1e-8 * (1.0 + np.abs(expected).max())
        return 1

    for name, value in model.parameters.items():
        change = Shooter(model, parameter=name).leg(start, 1000, max_time=3.0).parameter
        checked += check(
            change, lambda h, n=name, p=value: end(model.replace(**{n: p + h}), start.z)
        )
    for j in np.flatnonzero(start.free):
        unit = np.eye(len(start.z))[j]
        checked += check(leg.tangent[:, j], lambda h, unit=unit: end(model, start.z + h * unit))
    assert checked > 0.9 * (len(model.parameters) + len(start.z))


@pytest.mark.parametrize("seed", range(6))
def test_energy_balances(seed: int) -> None:
    model, q, v = drawn(seed)
    motion = ss.simulate(model, q, v, t_end=T_END)
    energy = motion.energy(np.linspace(0.0, motion.t[-1], 40))
    assert np.ptp(energy.balance) < 1e-12 * (1.0 + np.abs(energy.dissipation).max())


# --- as arguments ---------------------------------------------------------------------------------


def test_a_model_with_a_spring_is_told_changed_and_kept() -> None:
    model = blade()
    assert model.parameters["contact_stiffness_1"] == 2.0
    assert model.replace(contact_stiffness_1=3.0).contacts[0].stiffness == 3.0
    assert eval(repr(model), {**vars(ss), "Coulomb": ss.Coulomb}) == model
    with pytest.raises(ValueError, match=r"contact_stiffness_1|stiffness = -1"):
        model.replace(contact_stiffness_1=-1.0)


def test_model_files_hold_the_spring(tmp_path) -> None:  # type: ignore[no-untyped-def]
    ss.write_model(blade(), tmp_path / "blade.toml")
    assert "stiffness = 2.0" in (tmp_path / "blade.toml").read_text()
    assert ss.read_model(tmp_path / "blade.toml") == blade()


@pytest.mark.parametrize("stiffness", [0.0, -1.0, np.nan, np.inf, "2", [1.0]])
def test_a_stiffness_is_positive(stiffness: object) -> None:
    with pytest.raises(ValueError, match="stiffness"):
        ss.Contact(at=0, friction=FULL, stiffness=stiffness)  # type: ignore[arg-type]


@pytest.mark.parametrize("law", [ss.PoppStelter(gamma=1.0), ss.Coulomb(mu=0.5, viscous=0.1)])
def test_a_foot_without_mass_has_constant_kinetic_friction(law: ss.FrictionLaw) -> None:
    with pytest.raises(ValueError, match="foot has no mass"):
        ss.Contact(at=0, friction=law, stiffness=1.0)


def test_what_elastic_contacts_do_not_do_is_refused_with_the_reason() -> None:
    contact = ss.Contact(at=0, friction=FULL, stiffness=1.0)
    with pytest.raises(ValueError, match="state-space form tells no displacement"):
        ss.Structure.from_state_space([[-1.0]], [[1.0]], [[1.0]], contacts=[contact])
    model = blade(force=0.0, V=0.2)
    with pytest.raises(ValueError, match="elastic contacts"):
        ss.return_map(model)
    with pytest.raises(ValueError, match="no event map"):
        ss.event_map(model)
    beside = ss.Contact(at=0, friction=FULL, V=0.2)
    both = ss.Structure([1.0], [[1.0]], contacts=[beside, *model.contacts])
    with pytest.raises(ValueError, match="no event map"):
        ss.event_map(both)
    for x, v in (([0.0, 0.0, 0.0], [0.0, 0.0]), ([0.0], [0.0, 0.0]), ([np.nan], [0.0])):
        with pytest.raises(ValueError, match=re.escape("x = ") + "|" + re.escape("v = ")):
            ss.simulate(model, x, v, t_end=1.0)
