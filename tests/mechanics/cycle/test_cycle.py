"""Limit cycles: closed forms, the event map's orbits, motions without global stick."""

from __future__ import annotations

import math
from functools import partial

import mpmath
import numpy as np
import pytest
import scipy.linalg
from tests.sizes import slow

import stickslip as ss
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.shooting import Shooter
from stickslip.mechanics.cycle.trapping import _Return

COULOMB = ss.examples.coulomb()


def test_one_block_with_constant_friction() -> None:
    """The arc about mu from (1, V) back to velocity V, then the ride: period in closed form."""
    mu, V = 0.4, 0.2
    cycle = ss.find_cycle(ss.Oscillator(V=V, friction=ss.Coulomb(mu=mu)), [0.9], [0.0])
    period = 2 * math.pi - 2 * math.atan2(1 - mu, V) + 2 * (1 - mu) / V
    assert cycle.period == pytest.approx(period, abs=1e-13)
    np.testing.assert_array_equal(cycle.multipliers, [0.0])
    assert cycle.stable
    assert {(event.block, event.kind) for event in cycle.events} == {
        (1, "slip backward"),
        (1, "stick"),
    }
    energy = cycle.trajectory.energy([0.0, cycle.period])
    assert energy.belt_work[1] == pytest.approx(energy.dissipation[1], abs=1e-12)


def test_a_motion_followed_in_pieces_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    model = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3.0), damping=0.01)
    whole, pieces = Shooter(model), Shooter(model)
    monkeypatch.setattr(pieces, "follow", partial(pieces.follow, steps=1))
    start = whole.start(np.array([0.9]), np.array([0.0]))
    one, other = (shooter.leg(start, 6) for shooter in (whole, pieces))
    assert one.duration == other.duration
    assert one.events == other.events
    np.testing.assert_array_equal(one.state.z, other.state.z)
    np.testing.assert_array_equal(one.tangent, other.tangent)


def test_no_piece_of_a_stiff_motion_lasts() -> None:
    """Else Ctrl-C would wait for 40 periods of the slowest mode: with this damper for days."""
    shooter = Shooter(ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3.0), damping=1e4))
    shooter.place(shooter.start(np.zeros(1), np.zeros(1)))
    time, status = shooter.follow(0.0, 1e9)
    assert status == ss.status.OK
    assert 0.0 < time < 1e9


@pytest.mark.parametrize(
    ("guess", "point", "multiplier"),
    [
        (-0.0399, -0.039914313410282, -0.5620085225),
        (0.277, 0.27739336478609, 0.7507726661),
        (0.0886133, 0.088613323894202, 9.1822953528),
        (0.3716257, 0.371625700599026, -1.7450118961),
    ],
    ids=["S1", "S4", "U1", "U2"],
)
def test_orbits_of_the_event_map_are_cycles(guess: float, point: float, multiplier: float) -> None:
    """Stable and unstable ones; what two blocks that stick together forget has exact zeros."""
    cycle = ss.find_cycle(COULOMB, COULOMB.onset(guess), [COULOMB.V] * 2)
    assert np.abs(cycle.d - point).min() < 1e-12
    assert cycle.multipliers[0].real == pytest.approx(multiplier, rel=1e-9)
    np.testing.assert_array_equal(cycle.multipliers[1:], [0.0, 0.0])
    assert cycle.stable == (abs(multiplier) < 1)


def test_a_motion_of_law_9_without_global_stick() -> None:
    """The paper's system beyond the event map: a cycle that attracts out of the gap."""
    model = ss.examples.law9()
    assert np.isnan(ss.event_map(model)(0.62))
    cycle = ss.find_cycle(model, model.onset(0.62), [model.V] * 2)
    assert cycle.d.size == 0
    assert cycle.stable
    assert abs(cycle.multipliers[0].imag) > 0.1
    again = ss.simulate(model, cycle.x, cycle.v, t_end=3 * cycle.period)
    np.testing.assert_allclose(again.final_state.x, cycle.x, rtol=0, atol=1e-12)


@pytest.mark.parametrize("x", [(-0.4, 0.0), (0.2, -0.2), (0.3, 0.0), (0.1, 0.4)])
def test_a_global_stick_phase_counts_once(x: tuple[float, float]) -> None:
    """Rounding decides whether a motion of one period from the phase meets it again."""
    model = ss.Blocks(
        mass=[1, 2],
        stiffness=[[2.2, -1.2], [-1.2, 2.7]],
        damping=[[0.05, 0], [0, 0.05]],
        static=[1, 1.3],
        V=0.1,
        friction=ss.Coulomb(mu=0.3),
    )
    cycle = ss.find_cycle(model, x, [0.1, 0.1])
    assert len(cycle.events) == 4
    np.testing.assert_allclose(
        cycle.d, [ss.periodic_orbits(model)[1].points[0]], rtol=0, atol=1e-12
    )


def test_multipliers_are_those_of_the_event_map() -> None:
    """Three blocks: the eigenvalues of the product of Jacobians over the orbit."""
    model = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.3, friction=ss.Coulomb(mu=0.22))
    f = ss.event_map(model)
    cycle = ss.find_cycle(model, model.plant.sample_sticking(1, 5)[0], np.full(3, model.V))
    assert len(cycle.d) > 1
    np.testing.assert_allclose(f(cycle.d), np.roll(cycle.d, -1, axis=0), rtol=0, atol=1e-12)
    jacobian = np.eye(2)
    for d in cycle.d:
        jacobian = f.derivative(d) @ jacobian
    values = np.linalg.eigvals(jacobian)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    assert cycle.stable
    np.testing.assert_allclose(cycle.multipliers[:2], values, rtol=1e-8, atol=1e-10)
    np.testing.assert_array_equal(cycle.multipliers[2:], 0.0)


def test_a_forced_block_repeats_with_its_forcing() -> None:
    model = ss.Oscillator(
        V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(2.0, 0.7)
    )
    cycle = ss.find_cycle(model, [0.0], [0.0])
    assert cycle.period % (2 * math.pi / 0.7) == pytest.approx(0.0, abs=1e-9)
    assert len(cycle.multipliers) == 2
    assert cycle.residual < 1e-11


@pytest.mark.parametrize("late", [0.0, 1e-9, 1e-5, -1e-5])
def test_an_event_at_the_beginning_of_a_forced_cycle_counts_once(late: float) -> None:
    """A block that turns as the forcing's period begins: Den Hartog's motion, in closed form."""
    mu, damping, w = 0.6, 0.01, 1.2
    half, amplitude = np.pi / w, 1.2
    # x = Re r e^(i w t) + mu + a part E(t) u that decays, at rest at times 0 and half a period.
    flow = scipy.linalg.expm(np.array([[0.0, 1.0], [-1.0, -damping]]) * half)
    moved = np.linalg.solve(flow + np.eye(2), (flow - np.eye(2)) @ [mu, 0.0])
    r = amplitude / (1.0 - w * w + 1j * damping * w)
    turned = np.arcsin(moved[1] / (w * abs(r)))
    x, phase = abs(r) * np.cos(turned) + moved[0], turned - np.angle(r)
    pull = x - amplitude * np.cos(phase)  # less mu before it turns, plus mu after
    jump = np.diag([1.0, (pull - mu) / (pull + mu)])
    expected = np.linalg.eigvals(jump @ flow) ** 2
    forcing = ss.Harmonic(amplitude, w, phase=phase + late)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=mu), damping=damping, forcing=forcing)
    cycle = ss.find_cycle(block, [x + 1e-4], [0.0])
    np.testing.assert_allclose(cycle.period, 2 * half, rtol=1e-14)
    np.testing.assert_allclose(cycle.x, [x], rtol=0, atol=1e-8 if late else 1e-13)
    assert sorted(event.kind for event in cycle.events) == ["slip backward", "slip forward"]
    ordered = np.sort_complex(cycle.multipliers)
    np.testing.assert_allclose(ordered, np.sort_complex(expected), rtol=0, atol=1e-12)


def test_a_slow_belt_has_a_cycle_however_long_the_block_rides() -> None:
    """After 2000 periods of the block the search gave up."""
    V, mu = 1e-7, 0.5
    cycle = ss.find_cycle(ss.Oscillator(V=V, friction=ss.Coulomb(mu)), [0.9], [V])
    slip = 2.0 * (np.pi - np.arctan((1.0 - mu) / V))
    assert cycle.period == pytest.approx(2.0 * (1.0 - mu) / V + slip, rel=1e-13)


def test_a_block_that_creeps_to_rest_has_no_cycle() -> None:
    """Beyond x = 1 - 0.848 it slips by the square of what is left in every period, ever less."""
    force = ss.Harmonic(0.848, 1.2)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=1.0), damping=0.221, forcing=force)
    near = "in 100 periods of the forcing: the motion came back to within .*e-05 of its size"
    with pytest.raises(ValueError, match=near):
        ss.find_cycle(block, [0.4], [0.0], max_events=100, progress=(told := []).append)
    assert told == sorted(told)
    assert told[0] == 0.0
    assert 0.99 < told[-1] <= 1.0


def test_a_forced_search_goes_on_for_whole_periods_however_few_it_may() -> None:
    force = ss.Harmonic(2.0, frequency=0.2)  # so slow that the block sticks several times in each
    model = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=force)
    known = ss.find_cycle(model, [0.0], [0.0])
    few = ss.find_cycle(model, known.x + 1e-4, known.v, max_events=1)
    assert few.period == pytest.approx(force.period)
    np.testing.assert_allclose([few.x, few.v], [known.x, known.v], rtol=0, atol=1e-12)


def test_a_cycle_of_many_periods_of_the_forcing_is_found() -> None:
    force = ss.Harmonic(3.36, frequency=0.4626)
    model = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.81), forcing=force)
    cycle = ss.find_cycle(model, [4.1702155], [0.0], max_events=150)
    assert cycle.period == pytest.approx(113 * force.period)
    assert cycle.stable


@pytest.mark.parametrize("seed", range(8))
def test_a_shaken_block_that_never_stops_moves_as_the_closed_form_says(seed: int) -> None:
    """From one turn to the next friction is constant; half a period later the motion is -x."""
    rng = np.random.default_rng(seed)
    mu, damper, viscous = rng.uniform(0.1, 1.0), *rng.uniform(0.0, 0.5, 2)
    omega, force = rng.uniform(0.6, 2.5), rng.uniform(4.0, 8.0)
    flow = np.array([[0.0, 1.0], [-1.0, -damper - viscous]])
    half = scipy.linalg.expm(flow * math.pi / omega)
    # x = mu + p + y, p = Re(swing exp(i (omega t + lead))), y' = flow y, turning at t = 0.
    rest, rate = np.linalg.solve(half + np.eye(2), (half - np.eye(2)) @ [mu, 0.0])
    swing = force / (1.0 - omega**2 + 1j * omega * (damper + viscous))
    lead = math.asin(rate / (abs(swing) * omega))
    x, phase = rest + abs(swing) * math.cos(lead), lead - np.angle(swing)
    needed = x - force * math.cos(phase)
    assert needed > 1.0  # it slips on at once
    turn = np.diag([1.0, (needed - mu) / (needed + mu)]) @ half
    model = ss.Oscillator(
        V=0.0,
        friction=ss.Coulomb(mu=mu, viscous=viscous),
        damping=damper,
        forcing=ss.Harmonic(force, omega, phase - 0.5 * omega),
    )
    cycle = ss.find_cycle(model, [0.9 * x], [0.0])
    assert [event.time for event in cycle.events] == pytest.approx([0.5, 0.5 + math.pi / omega])
    assert cycle.trajectory.x(cycle.events[0].time) == pytest.approx([x], rel=1e-11)
    known = np.linalg.eigvals(turn @ turn)
    apart = np.abs(np.sort_complex(cycle.multipliers) - np.sort_complex(known))
    assert apart.max() < 1e-11


def test_motions_that_slide_for_ever_are_no_cycle() -> None:
    model = ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.4))
    with pytest.raises(ValueError, match="neutral family"):
        ss.find_cycle(model, [0.4], [0.1])


def test_a_block_that_friction_holds_is_no_cycle_to_follow() -> None:
    forcing = ss.Harmonic(amplitude=0.3, frequency=0.7)
    held = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.6), damping=0.05, forcing=forcing)
    cycle = ss.find_cycle(held, [0.1], [0.0])
    with pytest.raises(ValueError, match="holds its contacts wherever they are"):
        ss.follow(cycle, "forcing.amplitude", (0.1, 2.0))


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match="2 finite numbers"):
        ss.find_cycle(COULOMB, [0.1], [0.0])
    with pytest.raises(ValueError, match="max_events"):
        ss.find_cycle(COULOMB, [0.1, 0.1], [0.0, 0.0], max_events=0)


def test_the_period_is_the_least_one() -> None:
    """Law (9) without global stick: complex multipliers, so that a second return is nearer."""
    model = ss.examples.law9()
    cycle = ss.find_cycle(model, model.onset(0.62), [model.V] * 2)
    motion = cycle.trajectory
    t = np.linspace(0, 1, 50) * cycle.period
    for part in (2, 3, 4):
        shifted = motion.x((t + cycle.period / part) % cycle.period)
        assert np.abs(shifted - motion.x(t)).max() > 0.01
    # Their squares are those of two rounds.
    assert abs((cycle.multipliers[0] ** 2).imag) == pytest.approx(0.633325, abs=1e-6)
    assert cycle.period == pytest.approx(4.380753446647, abs=1e-11)


def test_a_cycle_without_events_is_found_from_a_near_guess() -> None:
    """Leine et al. (1998): between steady sliding and stick–slip lies a cycle that repels."""
    block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.25)
    (sliding,) = ss.equilibria(block)
    cycle = ss.find_cycle(block, sliding.x + 0.198, [0.0])
    assert cycle.events == ()
    assert not cycle.stable
    assert cycle.residual < 1e-13
    with pytest.raises(ValueError, match="no cycle was found"):
        ss.find_cycle(block, sliding.x + 0.1, [0.0])
    outside = ss.find_cycle(block, sliding.x + 0.23, [0.0])
    assert outside.stable
    assert len(outside.events) == 2


def at_time(series: list[mpmath.mpf], h: mpmath.mpf) -> mpmath.mpf:
    """Value of a Taylor series."""
    return sum(c * h**k for k, c in enumerate(series))


def period_in_many_digits(gamma: float, V: float, step: float = 0.0625) -> mpmath.mpf:
    """Slip from the edge of stick, x = 1, back to the belt, by Taylor series; then the ride."""
    x, w, t, order = mpmath.mpf(1), mpmath.mpf(0), mpmath.mpf(0), 30
    while True:
        xs, ws, qs, forces = [x], [w], [1 - gamma * w], []
        for k in range(order):
            tail = sum(qs[j] * forces[k - j] for j in range(1, k + 1))
            forces.append(((1 if k == 0 else 0) - tail) / qs[0])
            xs.append((ws[k] + (V if k == 0 else 0)) / (k + 1))
            ws.append((forces[k] - xs[k]) / (k + 1))
            qs.append(-gamma * ws[k + 1])
        end = at_time(ws, step)
        if t > 1 and end > 0:
            at = mpmath.findroot(partial(at_time, ws), (0, step), "anderson")
            return t + at + (1 - at_time(xs, at)) / V
        x, w, t = at_time(xs, step), end, t + step


@pytest.mark.parametrize(("gamma", "V"), [(3.0, 0.3), (1.0, 0.05)])
def test_one_block_with_law_9_against_many_digits(gamma: float, V: float) -> None:
    cycle = ss.find_cycle(ss.Oscillator(V=V, friction=ss.PoppStelter(gamma=gamma)), [0.9], [0.0])
    with mpmath.workdps(30):
        expected = period_in_many_digits(gamma, mpmath.mpf(V))
        assert abs(cycle.period - expected) < 1e-12


def balanced(cycle: Cycle) -> None:
    """Over one period belt and forcing put in what friction and dampers take out."""
    energy = cycle.trajectory.energy([0.0, cycle.period])
    put_in = energy.belt_work[1] + energy.forcing_work[1]
    assert energy.dissipation[1] > 0.1
    assert put_in == pytest.approx(energy.dissipation[1], abs=1e-12)
    assert energy.kinetic[1] == pytest.approx(energy.kinetic[0], abs=1e-12)
    assert energy.elastic[1] == pytest.approx(energy.elastic[0], abs=1e-12)


@pytest.mark.parametrize(
    "model",
    [
        COULOMB,
        ss.examples.law9(),
        ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3, eta=0.05), damping=0.1),
        ss.Chain(
            static=[1, 1.3, 1.1], alpha=1.2, V=0.3, friction=ss.Coulomb(mu=0.22), damping=0.02
        ),
        ss.Oscillator(
            V=0.3, friction=ss.PoppStelter(gamma=1), damping=0.1, forcing=ss.Harmonic(0.5, 1.7)
        ),
    ],
    ids=["coulomb", "law9", "damped", "chain", "forced"],
)
def test_energy_balances_over_a_period(model: ss.TwoBlock | ss.Chain | ss.Oscillator) -> None:
    x, v = model.sample_state(2)
    balanced(ss.find_cycle(model, x, v))


def test_energy_balances_over_a_cycle_that_repels() -> None:
    block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.25)
    balanced(ss.find_cycle(block, ss.equilibria(block)[0].x + 0.198, [0.0]))


@pytest.mark.parametrize("kind", ["one block", "two blocks", "drill string"])
def test_the_derivative_of_a_period_is_the_limit_of_differences(kind):
    law = ss.Stribeck(mu=0.5, speed=0.3)
    spring = 0.08 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    rock = ss.Contact(at=1, static=0.3, friction=ss.Stribeck(mu=0.5, speed=2.0, viscous=0.02))
    model, names = {
        "one block": (ss.Oscillator(V=0.2, friction=law, damping=0.1), ("V", "damping", "speed")),
        "two blocks": (
            ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.3)),
            ("mu", "V", "beta"),
        ),
        "drill string": (
            ss.Structure(
                mass=np.diag([0.4, 0.04]),
                stiffness=spring,
                damping=np.diag([2.0, 0.0]),
                force=[12.0, 0.0],
                contacts=[rock],
            ),
            ("mass_2_2", "damping_1_1", "static_1"),
        ),
    }[kind]
    rest = np.zeros(len(model.plant.mass))
    found = ss.find_cycle(model, rest, rest)
    for name, slope in zip(names, found.period_derivative(*names), strict=True):
        own = model.parameters[name]
        step = 1e-3 * own
        near = [model.replace(**{name: own + k * step}) for k in (-3, -2, -1, 1, 2, 3)]
        periods = [ss.find_cycle(each, found.x, found.v).period for each in near]
        expected = np.dot([-1, 9, -45, 45, -9, 1], periods) / (60 * step)
        assert slope == pytest.approx(expected, rel=1e-8)


def test_the_period_of_a_forced_cycle_is_that_of_the_forcing():
    forcing = ss.Harmonic(amplitude=2.0, frequency=0.7)
    model = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.3), damping=0.1, forcing=forcing)
    found = ss.find_cycle(model, [0.0], [0.0])
    by_frequency, by_mu = found.period_derivative("forcing.frequency", "mu")
    assert by_frequency == pytest.approx(-found.period / 0.7, rel=1e-12)
    assert by_mu == 0.0
    with pytest.raises(ValueError, match="at least one"):
        found.period_derivative()


def at_events(cycle: Cycle, first: tuple[int, str]) -> np.ndarray:
    """States at events, from the first of a kind on."""
    motion, found = cycle.trajectory, [(event.block, event.kind) for event in cycle.events]
    t = np.minimum([event.time for event in cycle.events], cycle.period)
    return np.roll(np.hstack([motion.x(t), motion.v(t)]), -found.index(first), axis=0)


def slope(model, name: str, step: float, quantity, begin: Cycle, nodes: range) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Derivative at node 0 of the polynomial through what cycles beside one have."""
    own = model.parameters[name]
    near = [model.replace(**{name: own + k * step}) for k in nodes]
    values = np.array([quantity(ss.find_cycle(each, begin.x, begin.v)) for each in near])
    powers = np.vander(np.array(nodes, dtype=float), increasing=True)
    grown = values - values[nodes.index(0)]  # rounded weights do not sum to zero
    return np.asarray(np.tensordot(np.linalg.inv(powers)[1], grown, 1) / step)


@pytest.mark.parametrize("kind", ["one block", "forced", *slow("two blocks")])
def test_derivatives_of_a_cycle_are_the_limits_of_differences(kind: str) -> None:
    law, forcing = ss.Stribeck(mu=0.5, speed=0.3), ss.Harmonic(amplitude=2.0, frequency=0.7)
    model, names = {
        "one block": (ss.Oscillator(V=0.2, friction=law, damping=0.1), ("V", "damping", "speed")),
        "two blocks": (
            ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.3)),
            ("mu", "V", "beta"),
        ),
        "forced": (
            ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.3), damping=0.1, forcing=forcing),
            ("mu", "forcing.frequency"),
        ),
    }[kind]
    n = len(model.plant.mass)
    found = ss.find_cycle(model, np.zeros(n), np.zeros(n))
    by = found.derivative(*names)
    assert by.status == ss.status.OK
    assert by.names == names
    np.testing.assert_array_equal(by.period, found.period_derivative(*names))
    first = (found.events[0].block, found.events[0].kind)
    for k, name in enumerate(names):
        step = 1e-3 * model.parameters[name]
        states = slope(model, name, step, lambda c: at_events(c, first), found, range(-3, 4))
        known = np.hstack([by.x[..., k], by.v[..., k]])
        np.testing.assert_allclose(known, states, rtol=1e-8, atol=1e-9)
        multipliers = slope(model, name, step, lambda c: c.multipliers, found, range(-3, 4))
        np.testing.assert_allclose(by.multipliers[:, k], multipliers, rtol=1e-8)


def test_multipliers_that_change_places_have_the_derivatives_of_their_own() -> None:
    law = ss.friction_law("a - b*s + c*s**3", parameters={"a": 0.775, "b": 0.366, "c": 0.23})
    model = ss.Blocks(
        mass=[1.49, 1.44],
        stiffness=[[1.366, 0.0], [0.0, 1.858]],
        damping=[[0.394, 0.0035], [0.0035, 0.337]],
        static=[1.076, 0.75],
        friction=[law, ss.Coulomb(mu=0.0123)],
        V=0.0978,
        forcing=ss.Harmonic((0.72, 0.587), frequency=0.307, phase=4.418),
    )
    found = ss.find_cycle(model, [0.118, 0.29], [0.0978, 0.034])
    by = found.derivative("forcing.frequency").multipliers[:, 0]
    near = slope(model, "forcing.frequency", 1e-7, lambda c: c.multipliers, found, range(-1, 2))
    np.testing.assert_allclose(by, near, rtol=1e-5)


def test_derivatives_next_to_grazing_and_at_grazing() -> None:
    motion = ss.simulate(COULOMB, d=0.27739336478609, t_end=200)
    branch = ss.follow(
        ss.find_cycle(COULOMB, motion.x(60.0), motion.v(60.0)), "V", (0.0366, 0.0372)
    )
    graze = branch.bifurcations[-1]
    assert graze.kind == "grazing"
    near = COULOMB.replace(V=graze.value - 1e-8)
    found = ss.find_cycle(near, branch[graze.row - 1].x, branch[graze.row - 1].v)
    by = found.derivative("V", "mu")
    assert by.status == ss.status.OK
    assert by.margin < 1e-6
    one_sided = range(0, -9, -1)
    period = slope(near, "V", 3e-5, lambda c: c.period, found, one_sided)
    np.testing.assert_allclose(by.period[0], period, rtol=1e-8)
    largest = slope(near, "V", 3e-5, lambda c: c.multipliers[0].real, found, one_sided)
    # The last digit of V moves the derivative, by 1.4e-8 (standard deviation): the mean tells.
    values = near.V + np.spacing(near.V) * np.arange(-20, 21)
    cycles = [ss.find_cycle(near.replace(V=V), found.x, found.v) for V in values.tolist()]
    mean = np.mean([cycle.derivative("V").multipliers[0, 0].real for cycle in cycles])
    np.testing.assert_allclose(mean, largest, rtol=1e-8)
    touching = branch[graze.row].derivative("V")
    assert touching.margin < by.margin / 100
    assert touching.status == ss.status.ONE_SIDED
    assert found.derivative("V").multipliers[1:].any() == 0.0  # what sticking forgets


def test_two_blocks_that_land_and_leave_at_once_have_derivatives_on_one_side_alone() -> None:
    """A stronger or a weaker block has its events later: the period becomes 10 longer."""
    model = ss.Chain(static=[1, 1], alpha=1.2, V=0.2, friction=ss.Coulomb(mu=0.3))
    found = ss.find_cycle(model, [0.9, 0.9], [0.2, 0.2])
    by = found.derivative("static_1")
    assert (by.margin, by.status) == (0.0, ss.status.ONE_SIDED)
    beside = ss.find_cycle(model.replace(static_1=1 + 1e-4), found.x, found.v)
    assert beside.period > found.period + 9.0


@pytest.mark.parametrize("v", [[0.0, 0.1, 0.0], [0.1, 0.1, 0.1]])
def test_events_at_one_time_may_be_settled_one_after_the_other(v: list[float]) -> None:
    """Outer blocks of three are alike; rounding tells their events apart, or does not."""
    model = ss.Blocks(
        mass=[1, 1, 1],
        stiffness=[[3, -1, 0], [-1, 3, -1], [0, -1, 3]],
        damping=0.1 * np.eye(3),
        static=[1, 1, 1],
        friction=ss.Coulomb(mu=0.5),
        V=0.1,
    )
    found = ss.find_cycle(model, [0.8, 0.6, 0.8], v)
    by = found.derivative("V")
    assert by.x.shape == (len(found.events), 3, 1)
    # Who sticks has the velocity of the belt.
    for event, v in zip(found.events, by.v[..., 0], strict=True):
        if event.kind == "stick":
            assert v[event.block - 1] == pytest.approx(1.0)
    back = _Return(found)
    assert back.leg(np.zeros(back.free.sum())).duration == pytest.approx(found.period)
    assert ss.trapping_ball(found) is None  # beside it the outer blocks take turns


def test_a_search_that_waits_for_an_event_says_how_far_apart_the_modes_are(monkeypatch):
    """A stiff model takes as long as its slowest mode does in periods of its fastest."""
    said = []
    monkeypatch.setattr("stickslip.mechanics.cycle.search.doing", said.append)
    block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5), damping=10.0)
    with pytest.raises(ss.errors.NoCycleError):
        ss.find_cycle(block, [0.9], [0.05])
    ratio = (5.0 + 24.0**0.5) ** 2
    told = f"event awaited for 0 of 2000 periods of the slowest mode, {ratio:.2g} of the fastest"
    assert said[0] == f"{told} each"
