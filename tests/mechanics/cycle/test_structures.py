"""Steady sliding, flutter, Hopf points and cycles of structures with known answers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import stickslip as ss
from stickslip.status import CONTACT_LOST

KXX, KYY, KXY, KN = 2.0, 1.3, 0.35, 1.1
MEET = (KXY + (KXX - KYY) ** 2 / (4 * KXY)) / KN  # friction at which a brake's two modes meet


def brake(beside: list[float], damping: float = 0.0) -> ss.Structure:
    """Hoffmann et al., Mech. Res. Comm. 29 (2002): the normal force is carried by a spring."""
    n = 2 + len(beside)
    stiffness, load = np.diag([KXX, KYY, *beside]), np.zeros(n)
    stiffness[0, 1] = stiffness[1, 0] = KXY
    load[1] = KN
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), static=2.0, V=0.5, load=load)
    damped = np.diag([0.0, 0.0, *np.full(n - 2, damping)])
    return ss.Structure(np.ones(n), stiffness, damping=damped, contacts=[contact])


def test_a_brake_with_mode_coupling_flutters_where_its_modes_meet() -> None:
    model = brake([9.0])  # the third body stands by
    (sliding,) = ss.equilibria(model)
    (flutter,) = ss.follow(sliding, "mu_1", (0.1, 1.0)).bifurcations
    assert flutter.kind == "flutter"
    assert flutter.value == pytest.approx(MEET, rel=1e-12)
    frequency = flutter.multipliers[0].imag
    assert frequency**2 == pytest.approx((KXX + KYY) / 2, rel=1e-12)
    # In balance the load is that of the normal force with friction.
    x, y, _ = sliding.x
    np.testing.assert_allclose(KXX * x + KXY * y, 0.3 * (2.0 + KN * y), rtol=1e-14)


@pytest.mark.parametrize(
    ("beside", "half"), [([9.0, 9.001], 0.1), ([9.0, 9.0], 0.28), ([1.648, 1.652], 0.3)]
)
def test_bystanders_hide_no_flutter(beside: list[float], half: float) -> None:
    """Modes nearer to each other, or to the pair, than it is; the grid hits where it meets."""
    model = brake(beside).replace(mu_1=MEET)
    (flutter,) = ss.follow(ss.equilibria(model)[0], "mu_1", (MEET - half, MEET + half)).bifurcations
    assert flutter.kind == "flutter"
    assert flutter.value == pytest.approx(MEET, rel=1e-12)
    assert flutter.multipliers[0].imag == pytest.approx(np.sqrt((KXX + KYY) / 2), rel=1e-12)


@pytest.mark.parametrize("damping", [-0.1, 0.1])
def test_flutter_beside_a_mode_that_grows_or_decays(damping: float) -> None:
    (sliding,) = ss.equilibria(brake([5.0], damping))
    (flutter,) = ss.follow(sliding, "mu_1", (0.1, 1.0)).bifurcations
    assert flutter.value == pytest.approx(MEET, rel=1e-12)
    assert ("another mode" in flutter.what) == (damping < 0)


def test_a_load_that_outweighs_the_spring_leaves_no_balance() -> None:
    """The friction 2 mu x of a load outweighs the spring where 2 mu = 1: x runs to infinity."""
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.5, load=[2.0])
    model = ss.Structure([1.0], [[1.0]], damping=[[0.1]], contacts=[contact])
    (sliding,) = ss.equilibria(model)
    assert sliding.x[0] == pytest.approx(0.3 / 0.4, rel=1e-14)
    assert ss.equilibria(model.replace(mu_1=0.5)) == ()
    with pytest.raises(ValueError, match="no forces balance between mu_1 = "):
        ss.follow(sliding, "mu_1", (0.1, 0.99))


def test_steady_sliding_keeps_all_contacts_closed() -> None:
    """Forces balance at x = (mu + F) / (1 - 2 mu), where the limit 1 + 2 x is negative or not."""
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.5, load=[2.0])
    model = ss.Structure([1.0], [[1.0]], damping=[[0.1]], contacts=[contact], force=[-0.4])
    (sliding,) = ss.equilibria(model)
    assert sliding.x[0] == pytest.approx(-0.1 / 0.4, rel=1e-14)
    assert ss.equilibria(model.replace(force_1=-0.6)) == ()
    assert (
        ss.simulate(model.replace(force_1=-0.6), [-0.75], [0.0], t_end=1.0).status == CONTACT_LOST
    )
    with pytest.raises(ValueError, match=r"between force_1 = -0\.50\d* and .*, or a contact opens"):
        ss.follow(sliding, "force_1", (-0.6, 0.0))


def test_hopf_points_of_a_drill_string() -> None:
    """An upper disc with viscous friction drives a lower one through a torsion spring."""
    upper, lower, k, b = 1.0, 0.3, 2.0, 0.3
    law = ss.Stribeck(mu=0.4, speed=0.8, viscous=0.02)
    drill = ss.Structure.from_state_space(
        A=[[0, 1, -1], [-k / upper, -b / upper, 0], [k / lower, 0, 0]],
        B=[[0], [0], [1 / lower]],
        C=[[0, 0, 1]],
        a=[0, 1.5 / upper, 0],
        contacts=[ss.Contact(at=0, friction=law)],
    )

    def growth(w: float) -> float:
        matrix = [
            [0, 1, -1],
            [-k / upper, -b / upper, 0],
            [k / lower, 0, -law.slope(w) / lower],
        ]
        values = np.linalg.eigvals(np.array(matrix))
        return float(values[np.argmax(values.imag)].real)

    fast = max(ss.equilibria(drill), key=lambda each: float(each.w[0]))
    w = float(fast.w[0])
    assert b * w + law.force(w) == pytest.approx(1.5, rel=1e-14)
    np.testing.assert_allclose(fast.x, [law.force(w) / k, w, w], rtol=1e-13)
    critical = brentq(growth, 0.5 * w, w, xtol=1e-14)
    (hopf,) = ss.follow(fast, "a_2", (1.0, 1.6)).bifurcations
    assert hopf.value == pytest.approx(b * critical + law.force(critical), rel=1e-12)


def test_what_turns_freely_is_told_its_speed_by_structures_in_positions_too() -> None:
    law = ss.Stribeck(mu=0.4, speed=0.8, viscous=0.02)
    discs = ss.Structure(
        mass=[1.0, 0.3],
        stiffness=[[2.0, -2.0], [-2.0, 2.0]],
        damping=np.diag([0.3, 0.0]),
        contacts=[ss.Contact(at=1, friction=law)],
        force=[1.5, 0.0],
    )
    fast = max(ss.equilibria(discs), key=lambda each: float(each.w[0]))
    assert 0.3 * fast.w[0] + law.force(fast.w[0]) == pytest.approx(1.5, rel=1e-14)
    assert len(fast.eigenvalues) == 3
    assert fast.x[0] - fast.x[1] == pytest.approx(law.force(fast.w[0]) / 2.0, rel=1e-13)


@pytest.mark.parametrize("unit", [1.0, 1e-9])  # of length
@pytest.mark.parametrize("discs", [1, 2])
def test_what_no_damper_feels_goes_on_at_the_speed_that_friction_allows(
    discs: int, unit: float
) -> None:
    law = ss.PoppStelter(gamma=2.0 / unit, delta=0.3)  # 1/(1 + w) above slip, in its unit
    model = ss.Structure(
        mass=np.array([1.0, 0.3])[-discs:] / unit,
        stiffness=[0.0] if discs == 1 else np.array([[2.0, -2.0], [-2.0, 2.0]]) / unit,
        contacts=[ss.Contact(at=discs - 1, friction=law)],
        force=[0.5, 0.0][:discs],
    )
    speeds = np.geomspace(1e-6, 1e4, 100_001) * unit
    off = law.force(speeds) - 0.5
    expected = speeds[:-1][off[1:] * off[:-1] < 0.0]
    found = ss.equilibria(model)
    assert len(found) == len(expected) > 0
    for one, w in zip(sorted(found, key=lambda one: one.w[0]), expected, strict=True):
        assert one.w[0] == pytest.approx(w, rel=1e-3)
        assert law.force(float(one.w[0])) == pytest.approx(0.5, rel=1e-13)
        if discs == 1:
            growth = -law.slope(float(one.w[0])) / model.plant.mass[0]
            assert one.eigenvalues == pytest.approx([growth], rel=1e-12)


def test_what_neither_dampers_nor_contacts_feel_has_no_steady_speed() -> None:
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=1.0)
    free = ss.Structure(mass=[2.0, 1.0], stiffness=[0.0, 0.0], contacts=[contact])
    with pytest.raises(ValueError, match="any will do"):
        ss.equilibria(free)


@pytest.mark.slow  # tests/studies/test_drill_string.py follows such cycles in every run
@pytest.mark.parametrize("followed", [1, 2])
def test_a_drill_string_sticks_and_slips_with_and_without_its_angle(followed: int) -> None:
    """Turning goes on for ever: a cycle comes back but for the common angle."""
    law = ss.Stribeck(mu=0.5, speed=0.5)
    upper, lower, k, b, torque = 0.5, 0.04, 0.08, 2.0, 5.0
    contact = ss.Contact(at=1, friction=law, static=0.3)
    drill = ss.Structure(
        mass=[upper, lower],
        stiffness=[[k, -k], [-k, k]],
        damping=np.diag([b, 0.0]),
        force=[torque, 0.0],
        contacts=[contact],
    )
    cycle = ss.find_cycle(drill, [0.0, 0.0], [0.0, 0.0])
    without = ss.Structure.from_state_space(
        A=[[0, 1, -1], [-k / upper, -b / upper, 0], [k / lower, 0, 0]],
        B=[[0], [0], [1 / lower]],
        C=[[0, 0, 1]],
        a=[0, torque / upper, 0],
        contacts=[ss.Contact(at=0, friction=law, static=0.3)],
    )
    same = ss.find_cycle(without, [0.0, 0.0, 0.0], [])
    assert cycle.stable
    assert cycle.period == pytest.approx(same.period, rel=1e-12)
    np.testing.assert_allclose(cycle.multipliers, same.multipliers, rtol=1e-6, atol=1e-12)
    ends = cycle.trajectory.x(np.array([0.0, cycle.period]))
    turned = ends[1] - ends[0]
    assert turned[0] == pytest.approx(turned[1], rel=1e-12)
    assert turned[0] > 1.0
    ways = [(cycle, "force_1", (1.5, 40.0), 1.0), (same, "a_2", (3.0, 80.0), upper)]
    for start, name, ends, unit in ways[:followed]:
        curve = ss.follow(start, name, ends)
        # It lands at the limit and meets the cycle that never sticks, which ends at rest.
        assert curve.end_reasons == ("end of range", "vanishes")
        assert [event.kind for event in curve.bifurcations] == ["landing", "hopf"]
        landing, hopf = curve.bifurcations
        assert landing.value * unit == pytest.approx(30.36993562823, rel=1e-11)
        around = 0.9 * hopf.value, 1.1 * hopf.value  # the middle is one of the values looked at
        found = [
            event.value
            for steady in ss.equilibria(hopf.solution.model)
            for event in ss.follow(steady, name, around).bifurcations
        ]
        assert hopf.value == pytest.approx(found[0], rel=1e-12)
        assert max(row.residual for row in curve) < 1e-10
        slips = next(row for row in curve if not row.events)
        again = ss.find_cycle(slips.model, slips.x, slips.v)
        assert not again.events
        assert again.period == pytest.approx(slips.period, rel=1e-12)


@pytest.mark.parametrize("seed", [0, 3])
def test_cycles_of_structures_are_followed_to_those_found_anew(seed: int) -> None:
    """Masses that do not rub, belts of two speeds, stiffness of any symmetry, loads that vary."""
    rng = np.random.default_rng(seed)
    n = 3
    spread = rng.normal(size=(n, n))
    law = ss.PoppStelter(gamma=float(rng.uniform(1.0, 4.0)))
    model = ss.Structure(
        mass=rng.uniform(0.5, 2.0, n),
        stiffness=np.eye(n) + 0.1 * spread @ spread.T + 0.05 * rng.normal(size=(n, n)),
        damping=0.2 * np.eye(n),
        contacts=[
            ss.Contact(at=0, friction=law, V=0.1),
            ss.Contact(at=2, friction=law, V=0.15, load=[0, 0.1, 0]),
        ],
    )
    cycle = ss.limit_cycles(model, n_starts=1, max_events=1000, rng=seed)[0]
    curve = ss.follow(cycle, "V_1", (0.098, 0.102))
    assert curve.values.min() < 0.1 < curve.values.max()
    assert max(row.residual for row in curve) < 1e-9
    for end in (curve[0], curve[-1]):
        if end.stable:
            again = ss.find_cycle(end.model, end.x, end.v)
            assert again.period == pytest.approx(end.period, rel=1e-10)
            sizes = [np.sort(np.abs(each.multipliers)) for each in (again, end)]
            np.testing.assert_allclose(*sizes, rtol=0, atol=1e-7)


def test_what_slides_is_told_by_speeds_of_slip_where_belts_differ() -> None:
    contacts = [ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.2)]
    one = ss.Structure(mass=[1.0, 0.3], stiffness=[[2, -1], [-1, 1]], contacts=contacts)
    text = repr(ss.equilibria(one)[0])
    assert "steady sliding at w = -0.2" in text
    assert "belt speeds searched" not in text


def test_the_stroboscopic_map_of_a_mass_that_carries_another() -> None:
    law = ss.PoppStelter(gamma=2.0)
    model = ss.Structure(
        mass=[1.0, 0.5, 0.7],
        stiffness=[[2.0, -1.0, 0.0], [-1.0, 1.5, -0.5], [0.0, -0.5, 1.0]],
        damping=0.2 * np.eye(3),
        contacts=[ss.Contact(at=0, friction=law), ss.Contact(at=(1, 2), friction=law, static=0.3)],
        forcing=[ss.Harmonic((0.5, 0.0, 1.0), 1.0), ss.Harmonic((0.0, 1.5, 0.0), 1.5, 0.4)],
    )
    f = ss.stroboscopic_map(model)
    assert f.period == pytest.approx(4 * np.pi)
    state = np.array([0.1, 0.3, -0.2, 0.4, -0.6, 0.5])
    jacobian = f.derivative(state)
    h = 1e-4
    for j, unit in enumerate(np.eye(6)):
        far_low, low, high, far_high = (f(state + k * h * unit) for k in (-2, -1, 1, 2))
        expected = (8 * (high - low) - (far_high - far_low)) / (12 * h)
        np.testing.assert_allclose(jacobian[:, j], expected, rtol=0, atol=1e-8)
    cycle = f.periodic_point(state)
    again = f(np.concatenate([cycle.x, cycle.v]))
    assert cycle.period == pytest.approx(f.period)
    np.testing.assert_allclose(again, np.concatenate([cycle.x, cycle.v]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("small", [1e-1, 1e-3, 1e-5])
def test_an_integrator_ramps_for_as_long_as_it_takes_to_a_release(small: float) -> None:
    """A mass under PID control: slips are linear in the distance and in the drop of friction."""

    def release_to_release(drop: float, distance: float) -> float:
        axis = ss.Structure.from_state_space(
            A=[[0, 1, 0], [0, 0, 1], [-4, -6, -1.5]],
            B=[[0], [0], [1]],
            C=[[0, 0, 1]],
            contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=1.0 - drop))],
        )
        f = ss.return_map(axis, coordinates=["x_2"], domain=(1e-8, 0.1))
        return float(f(distance))

    expected = small * release_to_release(0.3, 0.01)
    assert release_to_release(0.3 * small, 0.01 * small) == pytest.approx(expected, rel=1e-9)


def test_masses_that_nothing_holds_have_no_cycle():
    stack = ss.Structure(
        mass=[2.0, 1.0],
        stiffness=np.zeros((2, 2)),
        contacts=[
            ss.Contact(at=0, static=0.6, friction=ss.Coulomb(mu=1.0)),
            ss.Contact(at=(1, 0), friction=ss.Coulomb(mu=1.0)),
        ],
    )
    with pytest.raises(ValueError, match="nothing but friction acts on the masses"):
        ss.find_cycle(stack, [0.0, 0.0], [0.0, 3.0])
    # A damper acts, but no position is felt: this was NumPy's error.
    with pytest.raises(ValueError, match="no cycle was found from this state"):
        ss.find_cycle(stack.replace(damping_2_2=0.1), [0.0, 0.0], [0.0, 3.0])


def test_of_what_rests_on_the_ground_no_belt_is_told():
    foot = ss.Contact(at=0, static=1.0, friction=ss.Coulomb(mu=0.5))
    body = ss.Structure(mass=[1.0], stiffness=[[1.0]], contacts=[foot])
    with pytest.raises(ValueError, match="all contacts stick for ever") as error:
        ss.find_cycle(body, [0.1], [0.0])
    assert "belt" not in str(error.value)


def test_a_cycle_that_attracts_slowly_is_found():
    # Beside a multiplier of 0.976 it is 41 times as far away as each return from the last one.
    model = ss.Structure(
        mass=[0.299, 2.464],
        stiffness=[[3.487, -0.76], [-0.76, 3.034]],
        contacts=[
            ss.Contact(
                at=1,
                friction=ss.Stribeck(0.667, 0.233, viscous=0.192, exponent=2),
                static=0.977,
                V=0.244,
            )
        ],
    )
    cycle = ss.find_cycle(model, [0.164, -1.58], [-0.279, 0.354], max_events=6000)
    np.testing.assert_allclose(cycle.multipliers[0], 0.97574, rtol=1e-5)
    assert cycle.stable
    assert cycle.residual < 1e-12


def test_a_cycle_that_turns_from_slip_to_slip_keeps_all_its_multipliers() -> None:
    """Damping below zero feeds a mass on the ground; the multiplier 1.88 was told as 0, stable."""
    c, mu = 0.2, 0.5
    frequency = np.sqrt(1.0 - c**2 / 4)
    growth = np.exp(0.5 * c * np.pi / frequency)  # in half a period, about the place mu
    rest = mu * (growth + 1.0) / (growth - 1.0)
    ground = ss.Contact(at=0, friction=ss.Coulomb(mu))
    model = ss.Structure([1.0], stiffness=[[1.0]], damping=[[-c]], contacts=[ground])
    cycle = ss.find_cycle(model, [rest * 1.0001], [0.0])
    assert cycle.period == pytest.approx(2 * np.pi / frequency, rel=1e-13)
    assert abs(cycle.x[0]) == pytest.approx(rest, rel=1e-12)
    np.testing.assert_allclose(cycle.multipliers, [growth**2], rtol=1e-11)
    assert not cycle.stable
    for rates in (cycle.derivative, cycle.period_derivative):  # no section is free of events
        with pytest.raises(ValueError, match="turns round only where modes change"):
            rates("mu_1")


@pytest.mark.parametrize("static", [0.3, 0.6])
def test_two_contacts_of_one_body_move_it_as_one_does(static: float) -> None:
    """They stick and slip together: of what they hold only rounding was left, and taken away."""
    found = []
    for share, count in ((2.0 * static, 1), (static, 2)):
        contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.4), static=share)
        model = ss.Structure(
            mass=[1.0, 1.0],
            stiffness=[[2.0, -1.0], [-1.0, 1.5]],
            damping=[0.05, 0.02],
            contacts=[contact] * count,
            forcing=ss.Harmonic((0.0, 1.0), frequency=0.5, phase=0.3),
        )
        found.append(ss.find_cycle(model, [0.0, 0.0], [0.0, 0.0]))
    one, two = found
    np.testing.assert_allclose(two.x, one.x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(two.multipliers, one.multipliers, rtol=0, atol=1e-11)
    assert np.count_nonzero(one.multipliers) == 3
