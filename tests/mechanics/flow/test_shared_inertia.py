"""Contacts that share inertia: bodies that rub on each other and on the ground."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.reference.structures import FEW_LAWS, LAWS, Plain, random_structure

import stickslip as ss
from stickslip.mechanics.cycle.shooting import Shooter, State
from stickslip.mechanics.flow.trajectory import EVENT_KINDS

MODES = {kind: mode for mode, kind in EVENT_KINDS.items()}
T_END = 6.0
FINE = 0.002  # steps of the reference where it may have missed a brief excursion
ACCURATE = 1e-10  # DOP853's; its events of dependent contacts are a linear programme's
FULL = ss.Coulomb(mu=1.0)


LINEAR = (
    *(ss.Coulomb(mu=0.4), ss.Coulomb(mu=0.6, viscous=0.1)),
    *(ss.Coulomb(mu=0.8), ss.Coulomb(mu=0.5, viscous=0.05)),
)
FALLING = tuple(ss.Stribeck(law.mu, 0.3, viscous=law.viscous) for law in LINEAR)
"""One formula each: two sets of kernels, that others here need too; mixtures are slow tests."""


def drawn(
    seed: int, laws: tuple[ss.FrictionLaw, ...] | None = None
) -> tuple[ss.Structure, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    model = random_structure(rng, laws or (LINEAR, FALLING)[seed % 2], shared=True)
    n = len(model.mass)
    return model, rng.normal(size=n) * 0.5, rng.normal(size=n) * 0.5


def two_bodies(law: ss.FrictionLaw = FULL, V: float = 0.0, **changes: float) -> ss.Structure:
    """Two masses that rub on the ground, or a belt, and on each other."""
    model = ss.Structure(
        mass=[1.0, 2.0],
        stiffness=[[2.0, -1.0], [-1.0, 1.5]],
        contacts=[
            ss.Contact(at=0, friction=law, static=0.3, V=V),
            ss.Contact(at=1, friction=law, static=0.4, V=V),
            ss.Contact(at=(0, 1), friction=law, static=0.2),
        ],
        force=[0.1, -0.2],
    )
    return model.replace(**changes)


def with_law(model: ss.Structure, law: ss.FrictionLaw) -> ss.Structure:
    """All contacts with one law."""
    return model.replace(contacts=[replace(each, friction=law) for each in model.contacts])


START = [1.0, -0.5], [0.0, 0.5]
BATCHES = [
    pytest.param(range(8), None, id="laws of one formula"),
    pytest.param(range(40), FEW_LAWS, marks=pytest.mark.slow, id="few laws"),
    *(
        pytest.param(range(k, k + 40), LAWS, marks=pytest.mark.slow, id=f"from {k}")
        for k in range(0, 240, 40)
    ),
]


def test_contacts_that_stick_do_so_in_the_states_that_are_told():
    stuck = 0
    for seed in range(80):
        model, q, v = drawn(seed)
        plant = model.plant
        if np.linalg.matrix_rank(plant.out) < len(plant.out):
            continue  # w of one contact follows from the others
        rng = np.random.default_rng(seed)
        z = plant.coordinates(q, v, 0.7)
        w = z[-plant.n_contacts :]
        w[rng.random(w.shape) < 0.7] = 0.0
        again = plant.coordinates(*plant.states(z, 0.7), 0.7)
        assert (again[-plant.n_contacts :][w == 0.0] == 0.0).all()
        np.testing.assert_allclose(again, z, rtol=1e-9, atol=1e-11)
        stuck += np.count_nonzero(w == 0.0)
    assert stuck > 30


def check_against_plain(model: ss.Structure, q: np.ndarray, v: np.ndarray) -> int:
    """Compare a motion with the reference; count the events that left a choice."""
    motion = ss.simulate(model, q, v, t_end=T_END, record="events")
    events = [(event.time, event.block - 1, MODES[event.kind]) for event in motion.events]
    for step in (0.05, FINE):
        plain = Plain(model)
        expected = plain.follow(q, v, T_END, step, events)
        if [event[1:] for event in events] == [event[1:] for event in expected.events]:
            break
    assert [event[1:] for event in events] == [event[1:] for event in expected.events]
    assert (motion.status == ss.status.CONTACT_LOST) == expected.lost
    end = motion.final_state
    off = (end.t - expected.t, *(end.x - expected.q), *(end.v - expected.v))
    scale = 1.0 if len(model.plant.independent) == model.n_blocks else 100.0
    assert np.abs(off).max() < scale * ACCURATE
    return plain.choices


@pytest.mark.parametrize(("seeds", "laws"), BATCHES)
def test_random_structures_move_as_a_plain_integration_says(
    seeds: range, laws: tuple[ss.FrictionLaw, ...] | None
) -> None:
    for seed in seeds:
        check_against_plain(*drawn(seed, laws))


@pytest.mark.parametrize(
    "seed", [pytest.param(seed, marks=[pytest.mark.slow] * (seed > 7)) for seed in range(20)]
)
def test_modes_leave_no_choice_where_static_friction_is_kinetic(seed: int) -> None:
    model, q, v = drawn(seed)
    assert check_against_plain(with_law(model, FULL), q, v) == 0


@pytest.mark.parametrize(
    ("seed", "laws"),
    [
        *((seed, None) for seed in (6, 8, 11, 50)),
        *(pytest.param(seed, FEW_LAWS, marks=pytest.mark.slow) for seed in (6, 8, 11, 50)),
    ],
)
def test_tangents_are_the_limits_of_differences(
    seed: int, laws: tuple[ss.FrictionLaw, ...] | None
) -> None:
    model, q, v = drawn(seed, laws)
    shooter = Shooter(model)
    start = shooter.start(q, v)
    leg = shooter.leg(start, 1000, max_time=2.0)
    word = [event[1:] for event in leg.events]
    assert len(word) > 2

    def end(model: ss.Structure, z: np.ndarray) -> np.ndarray | None:
        found = Shooter(model, tangents=False).leg(State(z, start.mode), 1000, max_time=2.0)
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
        assert np.abs(exact - expected).max() < 1e-9 * (1.0 + np.abs(expected).max())
        return 1

    checked = 0
    for name, value in model.parameters.items():
        change = Shooter(model, parameter=name).leg(start, 1000, max_time=2.0).parameter
        checked += check(
            change, lambda h, n=name, p=value: end(model.replace(**{n: p + h}), start.z)
        )
    for way in model.plant.jacobians[1].T:
        if not way[~start.free].any():
            checked += check(leg.tangent @ way, lambda h, w=way: end(model, start.z + h * w))
    assert checked > len(model.parameters) // 2


@pytest.mark.parametrize("law", [FULL, ss.Coulomb(mu=0.4), ss.Coulomb(mu=0.6, viscous=0.1)])
@pytest.mark.parametrize("V", [0.0, 0.1])
def test_energy_and_momentum_of_two_bodies_balance(law: ss.FrictionLaw, V: float) -> None:
    model = two_bodies(law, V)
    motion = ss.simulate(model, *START, t_end=20.0)
    assert len(motion.events) > 4
    energy = motion.energy(np.linspace(0.0, 20.0, 80))
    forcing = np.array(model.force) @ (motion.x(energy.t) - motion.x(0.0)).T
    np.testing.assert_allclose(energy.forcing_work, forcing, rtol=0, atol=1e-13)
    assert np.ptp(energy.balance) < 1e-13
    # Friction between the bodies gives as much as it takes: the rest changes their momentum.
    nodes, weights = np.polynomial.legendre.leggauss(30)
    for start, end in itertools.pairwise(motion.t):
        t = start + 0.5 * (end - start) * (nodes + 1.0)
        outer = motion.friction(t)[:, :2].sum(axis=1) - 1.0 * motion.x(t)[:, 0]
        outer += -0.5 * motion.x(t)[:, 1] + np.sum(model.force)
        change = np.array(model.mass) @ (motion.v(end) - motion.v(start))
        np.testing.assert_allclose(
            0.5 * (end - start) * weights @ outer, change, rtol=0, atol=1e-11
        )


@pytest.mark.parametrize("law", [FULL, ss.Coulomb(mu=0.4)])
def test_a_pair_that_sticks_together_moves_as_one_mass(law: ss.FrictionLaw) -> None:
    pair = two_bodies(law, 0.1, static_3=50.0).replace(damping=[[0.02, 0.0], [0.0, 0.03]])
    one = ss.Structure(
        mass=[3.0],
        stiffness=[[1.5]],
        damping=[[0.05]],
        contacts=[ss.Contact(at=0, friction=law, static=0.7, V=0.1)],
        force=[-0.1],
    )
    motion = ss.simulate(pair, [0.2, 0.2], [0.5, 0.5], t_end=40.0)
    lumped = ss.simulate(one, [0.2], [0.5], t_end=40.0)
    t = np.linspace(0.0, 40.0, 200)
    for got in motion.x(t).T:
        np.testing.assert_allclose(got, lumped.x(t)[:, 0], rtol=0, atol=1e-12)
    assert len(motion.events) == 2 * len(lumped.events) > 0  # both leave, both stick
    # Which of the contacts carries how much is open while all stick: the sum is not.
    both = motion.friction(t)[:, :2].sum(axis=1)
    np.testing.assert_allclose(both, lumped.friction(t)[:, 0], rtol=0, atol=1e-11)


@pytest.mark.parametrize("between", [0.2, 0.7])
def test_what_slips_first_is_the_weakest_mechanism(between: float) -> None:
    """On a belt, one mass held by a spring: both leave the belt, or the held one leaves both."""
    model = two_bodies(FULL, 0.1, static_3=between)
    model = model.replace(stiffness=[[2.0, 0.0], [0.0, 0.0]], force=[0.0, 0.0])
    motion = ss.simulate(model, [0.0, 0.0], [0.1, 0.1], t_end=10.0)
    np.testing.assert_allclose(motion.t[1], (0.3 + min(between, 0.4)) / (2.0 * 0.1), rtol=1e-14)
    assert motion.modes[1].tolist() == ([-1, 0, -1] if between < 0.4 else [-1, -1, 0])


def stepped(model: ss.Structure, q: np.ndarray, v: np.ndarray, h: float) -> np.ndarray:
    """Moreau's time-stepping: a complementarity problem for the impulses of each step."""
    b, inverse = Plain(model).b, np.diag(1.0 / np.array(model.mass))
    response, limit = b @ inverse @ b.T, h * np.array([c.static for c in model.contacts])
    impulse = np.zeros(len(limit))
    for _ in range(round(T_END / h)):
        q = q + 0.5 * h * v
        v = v + h * inverse @ (np.array(model.force) - model.stiffness @ q)
        w = b @ v + response @ impulse
        for _ in range(200):  # projected Gauss-Seidel
            most = 0.0
            for k in range(len(limit)):
                new = np.clip(impulse[k] - w[k] / response[k, k], -limit[k], limit[k])
                most, change = max(most, abs(new - impulse[k])), new - impulse[k]
                w, impulse[k] = w + response[:, k] * change, new
            if most < 1e-15:
                break
        v = v + inverse @ b.T @ impulse
        q = q + 0.5 * h * v
    return np.concatenate([q, v])


def test_time_stepping_converges_to_the_motion() -> None:
    model = two_bodies()
    end = ss.simulate(model, *START, t_end=T_END).final_state
    exact = np.concatenate([end.x, end.v])
    off = [
        np.abs(stepped(model, np.array(START[0]), np.array(START[1]), h) - exact).max()
        for h in (4e-3, 1e-3)
    ]
    assert off[0] < 4e-3
    assert off[1] < 0.5 * off[0]


def test_regularised_friction_converges_to_the_motion() -> None:
    """Friction -L tanh(steepness w), which creeps where ours sticks."""
    model = two_bodies()
    plain = Plain(model)
    limit = np.array([contact.static for contact in model.contacts])
    end = ss.simulate(model, *START, t_end=T_END).final_state
    exact, off = np.concatenate([end.x, end.v]), []
    for steepness in (1e3, 1e4, 1e5, 1e6):

        def rate(t: float, state: np.ndarray, steepness: float = steepness) -> np.ndarray:
            q, v = np.split(state, 2)
            force = -limit * np.tanh(steepness * (plain.b @ v))
            return np.concatenate([v, plain.inverse @ (plain.pull(t, q, v) + plain.b.T @ force)])

        found = solve_ivp(
            rate, (0.0, T_END), np.concatenate(START), method="Radau", rtol=1e-10, atol=1e-12
        )
        off.append(np.abs(found.y[:, -1] - exact).max())
    assert off[0] < 1e-2
    for less, more in itertools.pairwise(reversed(off)):
        assert less < 0.2 * more
    assert off[-1] < 1e-5


def test_a_body_between_the_ground_and_a_belt() -> None:
    """Both contacts cannot stick; the stronger holds the body."""
    for ground, belt in ((1.0, 0.6), (0.6, 1.0)):
        contacts = [
            ss.Contact(at=0, friction=FULL, static=ground),
            ss.Contact(at=0, friction=FULL, static=belt, V=0.3),
        ]
        model = ss.Structure(mass=[2.0], stiffness=[[0.0]], contacts=contacts)
        motion = ss.simulate(model, [0.0], [1.0], t_end=10.0)
        # Both brake it, then only the ground does, then one of them holds it.
        assert motion.t[1] == pytest.approx(0.7 * 2.0 / 1.6, rel=1e-14)
        held = belt > ground
        assert motion.final_state.v[0] == pytest.approx(0.3 if held else 0.0, abs=1e-15)
        assert motion.modes[-1].tolist() == ([1, 0] if held else [0, -1])


def test_cycles_have_the_multipliers_of_the_stroboscopic_map() -> None:
    law = ss.Stribeck(mu=0.4, speed=0.2)
    model = with_law(two_bodies(), law).replace(
        damping=0.05 * np.eye(2),
        forcing=ss.Harmonic((1.5, 0.0), 0.9),
        **{"static_1": 0.5, "static_2": 0.3, "static_3": 0.3},
    )
    cycle = ss.find_cycle(model, [0.0, 0.0], [0.0, 0.0])
    f, state = ss.stroboscopic_map(model), np.concatenate([cycle.x, cycle.v])
    np.testing.assert_allclose(f(state), state, rtol=0, atol=1e-12)
    expected = np.linalg.eigvals(f.derivative(state))
    for found, known in zip(
        np.sort_complex(cycle.multipliers), np.sort_complex(expected), strict=True
    ):
        assert found == pytest.approx(known, abs=1e-10)


def test_steady_sliding_of_two_bodies_on_belts_of_their_own() -> None:
    law = ss.Stribeck(mu=0.4, speed=0.2)
    model = with_law(two_bodies(V_1=0.2, V_2=-0.3, V_3=0.1), law)
    (sliding,) = ss.equilibria(model)
    b, limits = Plain(model).b, np.array(model.limits)
    np.testing.assert_allclose(sliding.w, [-0.2, 0.3, -0.1], rtol=1e-14)
    friction = -np.sign(sliding.w) * limits * law.force(np.abs(sliding.w))
    balance = np.array(model.force) + b.T @ friction
    np.testing.assert_allclose(model.stiffness @ sliding.x, balance, rtol=0, atol=1e-14)
    drag = b.T @ np.diag(limits * law.slope(np.abs(sliding.w))) @ b
    inverse = np.diag(1.0 / np.array(model.mass))
    matrix = np.block(
        [[np.zeros((2, 2)), np.eye(2)], [-inverse @ model.stiffness, -inverse @ drag]]
    )
    expected = np.linalg.eigvals(matrix)
    np.testing.assert_allclose(
        np.sort_complex(sliding.eigenvalues), np.sort_complex(expected), rtol=0, atol=1e-13
    )


def test_what_is_refused_says_why() -> None:
    def contact(at: object) -> ss.Contact:
        return ss.Contact(at=at, friction=FULL)  # type: ignore[arg-type]

    with pytest.raises(ValueError, match=r"nearly depend on each other.* 2\.5e-11"):
        ss.Structure([1, 2], np.eye(2), contacts=[contact(0), contact([1.0, 1e-5])])
    with pytest.raises(ValueError, match="must be symmetric"):
        ss.Structure.from_state_space(
            -np.eye(2), [[1, 0.5], [0, 1]], np.eye(2), contacts=[contact(0), contact(1)]
        )
    with pytest.raises(ValueError, match="nearly depend"):  # no geometry says that they do
        ss.Structure.from_state_space(
            [[-1]], [[1, 1]], [[1], [1]], contacts=[contact(0), contact(1)]
        )
    with pytest.raises(ValueError, match="sets of others at rest; at most 1000"):
        ss.Structure(
            np.ones(8),
            np.eye(8),
            contacts=[contact(list(b)) for b in np.random.default_rng(1).normal(size=(16, 8))],
        )
    apart = ss.Structure(np.diag([1.0, 2.0]), np.eye(2), contacts=[contact(0), contact(1)])
    with pytest.raises(ValueError, match=r"mass_1_2 = 0\.0 has no derivative"):
        apart.plant_direction("mass_1_2")
    with pytest.raises(ValueError, match="no return map as yet"):
        ss.return_map(two_bodies(V=0.1))
    with pytest.raises(ValueError, match="no event map"):
        ss.event_map(two_bodies(V=0.1))


def test_releases_are_where_needed_forces_reach_limits() -> None:
    """Forces that hold a contact follow from rates, which series tell less accurately."""
    law = ss.Stribeck(mu=0.5, speed=0.13)
    rng = np.random.default_rng(45)
    contacts = [
        ss.Contact(at=0, friction=law, static=1.2, V=-0.2),
        ss.Contact(at=0, friction=law, static=0.6, V=ss.Harmonic(0.3, 2.8, rng.uniform(0, 6))),
    ]
    forcing = ss.Harmonic(0.7, 1.7, rng.uniform(0, 6))
    model = ss.Structure([0.6], [[0.6]], contacts=contacts, forcing=forcing)
    q, v = rng.normal(size=1), rng.normal(size=1)
    motion = ss.simulate(model, q, v, t_end=10.0)
    expected = Plain(model).follow(q, v, 10.0)
    times = [event.time for event in motion.events]
    np.testing.assert_allclose(times, [t for t, *_ in expected.events], rtol=0, atol=1e-11)


def test_a_body_between_belts_of_nearly_one_velocity_rests_on_one_of_them() -> None:
    law = ss.Coulomb(mu=0.4)
    ground = ss.Contact(at=0, friction=law, static=1.0)
    belt = ss.Contact(at=0, friction=law, static=0.8, V=5e-12)
    model = ss.Structure([1.0], [[0.0]], contacts=[ground, belt])
    motion = ss.simulate(model, [0.0], [1.0], t_end=5.0)
    assert motion.modes[-1].tolist() == [1, 0]  # kinetic friction 0.4 does not reach 0.8
    np.testing.assert_allclose(motion.friction(4.0), [-0.4, 0.4], rtol=1e-12)


@pytest.mark.parametrize("seed", [11, 21, 42, 52])
def test_a_contact_at_its_limit_to_rounding_slips_or_sticks_and_is_not_given_up(seed: int) -> None:
    """Let go at F(0) = 1 it was taken back: its force is a sum of other terms once it slips."""
    rng = np.random.default_rng(seed)
    mass, weight = rng.uniform(0.5, 2.0, 2), rng.uniform(-1.0, 1.0)
    across = ss.Contact(
        at=[1.0, weight], friction=ss.Coulomb(mu=0.5), static=rng.uniform(0.3, 2.0), V=-0.2
    )
    belt = ss.Contact(at=0, friction=ss.PoppStelter(gamma=2.0), V=0.3)
    model = ss.Structure(mass, [[2.0, -1.0], [-1.0, 2.0]], contacts=[belt, across])
    v, x_2 = np.array([0.3, rng.uniform(-1.0, 1.0)]), rng.uniform(-0.5, 0.5)
    # The belt has to carry 1 = 2 x_1 - x_2 and what the other contact pulls body 1 with.
    pull = -0.5 * across.static * np.sign(v[0] + weight * v[1] + 0.2)
    at_limit = 0.5 * (1.0 + x_2 + pull)
    for step in range(-60, 61, 2):
        start = [at_limit * (1.0 + step * np.finfo(float).eps), x_2]
        motion = ss.simulate(model, start, v, t_end=0.05, record="events")
        assert motion.status == ss.status.OK
