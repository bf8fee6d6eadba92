"""Limit cycles along a parameter: against closed forms, other integrators and the event map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tests.sizes import slow

import stickslip as ss

BLOCK = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.0)
LAW9 = ss.examples.law9()


def touching_damping() -> float:
    """Damping at which the slip from the edge of stick comes back to the belt with w' = 0 = w.

    The largest w after that slip, from an integrator of another kind.
    """

    def highest(c: float) -> float:
        def rates(_: float, z: list[float]) -> list[float]:
            return [z[1] + 0.2, 1.0 / (1.0 - 3.0 * z[1]) - z[0] - c * (z[1] + 0.2)]

        def turns(t: float, z: list[float]) -> float:
            return rates(t, z)[1] if t > 3.0 else 1.0

        turns.terminal, turns.direction = True, -1  # type: ignore[attr-defined]
        start = [1.0 - 0.2 * c, -1e-300]
        motion = solve_ivp(
            rates, (0.0, 12.0), start, "DOP853", events=turns, rtol=1e-13, atol=1e-15, max_step=0.1
        )
        return float(motion.y[1, -1])

    return float(brentq(highest, 1.28, 1.305, xtol=1e-13))


def test_from_stick_slip_over_the_discontinuous_fold_to_the_hopf_point() -> None:
    """Leine et al., Nonlinear Dynamics 16, 41 (1998): the unstable slip cycle touches the belt."""
    cycle = ss.find_cycle(BLOCK, [0.9], [0.0])
    branch = ss.follow(cycle, "damping", (0.5, 3.0))
    assert branch.end_reasons == ("end of range", "vanishes")
    touch, hopf = branch.bifurcations
    assert (touch.kind, touch.outcome) == ("landing", "fold")
    assert touch.value == pytest.approx(touching_damping(), abs=1e-10)
    assert hopf.kind == "hopf"
    assert hopf.value == pytest.approx(3 / 1.6**2, abs=1e-13)
    events = branch.table()["events"]
    np.testing.assert_array_equal(np.unique(events[: touch.row + 1]), [2])
    np.testing.assert_array_equal(events[touch.row + 1 :], 0)
    assert branch.stable[: touch.row + 1].all()
    assert not branch.stable[touch.row + 1 :].any()
    # From the other side the same touch is a slip that grazes the belt.
    slip = branch[-3]
    assert slip.events == ()
    back = ss.follow(slip, "damping", (1.0, 3.0))
    graze = next(item for item in back.bifurcations if item.kind == "grazing")
    assert graze.value == pytest.approx(touch.value, abs=1e-11)
    assert graze.outcome == "fold"


@pytest.mark.slow
def test_bifurcations_are_those_of_the_event_map() -> None:
    """The paper's P1 along alpha: flip, loss at a discontinuity, fold, the flip of S1."""
    orbit = ss.periodic_orbits(LAW9)[2]
    cycle = ss.find_cycle(LAW9, LAW9.onset(orbit.points[0]), [LAW9.V] * 2)
    branch = ss.follow(cycle, "alpha", (1.208, 1.2187))
    flip_here, loss, fold = branch.bifurcations[:3]
    other = ss.follow(orbit, "alpha", (1.208, 1.2187))
    flip = next(item for item in other.bifurcations if item.kind == "flip")
    assert flip_here.kind == "flip"
    assert flip_here.value == pytest.approx(flip.value, abs=1e-12)
    assert other.end_reasons[1] == "breakpoint"
    # A block comes to the belt where its force is exactly at the limit: it grazes and lands.
    assert loss.kind in ("grazing", "landing")
    assert (loss.block, loss.outcome) == (2, "fold")
    assert loss.value == pytest.approx(other.ends[1].value, abs=1e-11)
    assert fold.kind == "fold"
    f = ss.event_map(fold.solution.model)
    np.testing.assert_allclose(f(fold.solution.d), fold.solution.d, rtol=0, atol=1e-12)
    assert f.derivative(fold.solution.d[0]) == pytest.approx(1.0, abs=1e-5)


def test_where_motions_without_global_stick_begin_to_attract() -> None:
    cycle = ss.find_cycle(LAW9, LAW9.onset(0.62), [LAW9.V] * 2)
    branch = ss.follow(cycle, "V", (0.2, 0.3))
    tie, flip = branch.bifurcations
    assert (tie.kind, flip.kind) == ("tie", "flip")
    assert 0.2 < tie.value < flip.value < 0.295
    np.testing.assert_array_equal(branch.stable, branch.values > flip.value)
    riding = [cycle.d.size > 0 for cycle in branch]
    # Below the tie both blocks stick together for a while: a cycle of the event map.
    assert riding[0]
    assert not riding[-1]


def test_a_forced_block_loses_its_response_to_a_torus() -> None:
    """Weakly forced about steady sliding: growth rate and Neimark–Sacker agree to a^2."""
    block = ss.Oscillator(
        V=0.25,
        friction=ss.PoppStelter(gamma=3),
        damping=1.171875,
        forcing=ss.Harmonic(1e-3, 0.61),
    )
    x = ss.equilibria(block.replace(forcing=None))[0].x
    cycle = ss.find_cycle(block, x, [0.0])
    branch = ss.follow(cycle, "V", (0.15, 0.3))
    (torus,) = branch.bifurcations
    assert torus.kind == "neimark_sacker"
    assert torus.value == pytest.approx(0.2, abs=1e-4)
    assert torus.value != pytest.approx(0.2, abs=1e-9)
    assert branch.end_reasons == ("end of range", "end of range")


def test_along_the_frequency_of_the_forcing() -> None:
    block = ss.Oscillator(
        V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(2.0, 0.7)
    )
    cycle = ss.find_cycle(block, [0.0], [0.0])
    branch = ss.follow(cycle, "forcing.frequency", (0.65, 0.75))
    rounds = round(cycle.period * 0.7 / (2 * np.pi))
    np.testing.assert_allclose(
        branch.data["period"], rounds * 2 * np.pi / branch.values, rtol=1e-14
    )
    assert max(cycle.residual for cycle in branch) < 1e-11
    middle = branch[0]
    again = ss.find_cycle(middle.model, middle.x, middle.v)
    np.testing.assert_allclose(again.x, middle.x, rtol=0, atol=1e-10)


def test_bad_input_is_told() -> None:
    cycle = ss.find_cycle(BLOCK, [0.9], [0.0])
    with pytest.raises(ValueError, match="not a parameter"):
        ss.follow(cycle, "dampnig", (0.5, 3.0))
    with pytest.raises(ValueError, match="does not contain"):
        ss.follow(cycle, "damping", (2.0, 3.0))
    with pytest.raises(ValueError, match="damping"):
        ss.follow(cycle, "damping", (-1.0, 3.0))


@pytest.mark.parametrize("seed", [3, 6])
def test_branches_pass_through_the_cycles_found_on_their_way(seed: int) -> None:
    """Random damped chains: continued in V, and searched for anew at the far end."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 4))
    chain = ss.Chain(
        static=rng.uniform(0.8, 1.4, n),
        alpha=rng.uniform(0.3, 2.0),
        V=0.2,
        friction=ss.PoppStelter(gamma=rng.uniform(1.0, 3.0)),
        damping=rng.uniform(0.0, 0.1),
    )
    cycle = ss.limit_cycles(chain, n_starts=2, max_events=400, rng=seed)[0]
    branch = ss.follow(cycle, "V", (0.19, 0.21))
    assert max(item.residual for item in branch) < 1e-10
    assert branch.values.min() < 0.2 < branch.values.max()
    for end in (branch[0], branch[-1]):
        if end.stable:
            again = ss.find_cycle(end.model, end.x, end.v)
            assert again.period == pytest.approx(end.period, abs=1e-10)
            np.testing.assert_allclose(
                np.sort(np.abs(again.multipliers)),
                np.sort(np.abs(end.multipliers)),
                rtol=0,
                atol=1e-7,
            )


def test_a_cycle_of_a_chaotic_damped_chain_closes() -> None:
    """Found at a state where all ride: nothing of the motion before it may be left."""
    rng = np.random.default_rng(5)
    chain = ss.Chain(
        static=rng.uniform(0.8, 1.4, int(rng.integers(2, 4))),
        alpha=rng.uniform(0.3, 2.0),
        V=0.2,
        friction=ss.PoppStelter(gamma=rng.uniform(1.0, 3.0)),
        damping=rng.uniform(0.0, 0.1),
    )
    found = ss.limit_cycles(chain, n_starts=2, max_events=400, rng=5)
    assert len(found) > 0
    assert max(cycle.residual for cycle in found) < 1e-11


def test_a_branch_is_drawn_and_told() -> None:
    block = BLOCK.replace(damping=1.2)
    cycle = ss.find_cycle(block, [0.9], [0.0])
    branch = ss.follow(cycle, "damping", (1.15, 1.4))
    text = repr(branch)
    assert "hopf at damping = 1.171875" in text
    assert "meets another cycle" in text
    axes = branch.plot()
    assert axes.get_xlabel() == "damping"
    assert len(axes.lines) == 2 + len(branch.bifurcations)


def test_a_landing_without_speed_ends_a_stick_slip_cycle() -> None:
    """F(0) < 1: the stick has a length up to the end, where the slip no longer reaches the belt."""
    law = ss.TabulatedFriction(speed=[0, 0.1, 0.3, 0.8, 2.0], force=[0.98, 0.76, 0.56, 0.44, 0.5])
    block = ss.Oscillator(V=0.3, friction=law, damping=0.3)
    branch = ss.follow(ss.find_cycle(block, [0.0], [0.0]), "damping", (0.2, 2.0))
    (end,) = branch.bifurcations
    assert (end.kind, branch.ends[1].reason) == ("grazing", "grazing")
    assert ss.find_cycle(block.replace(damping=end.value - 1e-9), [0.0], [0.0]).events
    with pytest.raises(ValueError, match="never to stick again"):
        ss.find_cycle(block.replace(damping=end.value + 1e-9), [0.0], [0.0])


def test_a_release_that_is_lost_ends_an_unstable_forced_cycle() -> None:
    """Near a force that only just reaches its limit multipliers grow like 1 / way to the end."""
    shaken = ss.Harmonic(amplitude=1.18, frequency=0.39)
    block = ss.Oscillator(V=0.22, friction=ss.Coulomb(mu=0.72), forcing=shaken)
    cycle = ss.find_cycle(block, [0.42776855], [0.22])
    curve = ss.follow(cycle, "forcing.amplitude", (1.1687526, 1.181))
    (end, _), event = curve.ends, curve.bifurcations[0]
    assert (end.reason, event.kind, event.value) == ("limit", "limit", end.value)
    unstable = np.abs(curve.multipliers[:, 0])
    near, far = (np.flatnonzero(unstable > size)[-1] for size in (1e4, 1e2))
    ratio = unstable[near] / unstable[far]
    expected = (ratio * curve.values[near] - curve.values[far]) / (ratio - 1.0)
    assert abs(event.value - expected) < event.error < 1e-7
    # The force x + R(t) of the rider, with R' = V + a w sin(w t), is at its limit as it turns back.
    a, w = event.value + 1e-6, shaken.frequency
    events = curve.at(**{"forcing.amplitude": a}).events
    (turn,) = (block.V + a * w * np.sin(w * e.time) for e in events if e.kind == "slip forward")
    assert abs(turn) < 1e-3


@pytest.mark.parametrize("phase", [1.0, *slow(3.0, 4.0)])
def test_events_of_a_forced_cycle_may_cross_the_phase_at_time_0(phase: float) -> None:
    """The section goes out of their way; a shift of the forcing shifts the cycle alone.

    Both branch points are pitchforks of the mirror symmetry, x(t + T/2) = -x(t).
    """
    forcing = ss.Harmonic(2.0, 0.45, phase)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.05, forcing=forcing)
    curve = ss.follow(ss.find_cycle(block, [0.0], [0.0]), "forcing.amplitude", (1.2, 4.0))
    assert curve.end_reasons == ("end of range", "end of range")
    assert [event.kind for event in curve.bifurcations] == ["branch_point", "branch_point"]
    for event, value in zip(curve.bifurcations, (2.15008, 3.84352), strict=True):
        # Between two rows, a thousandth of the range apart at most.
        assert abs(event.value - value) < event.error < 1e-3 * (4.0 - 1.2)
    cycle = curve.at(**{"forcing.amplitude": 3.0})
    assert cycle.multipliers.shape == (2,)
    half = cycle.trajectory.x(0.5 * cycle.period)
    np.testing.assert_allclose(half, -cycle.x, rtol=0, atol=1e-9)
    f = ss.stroboscopic_map(cycle.model)
    point = np.concatenate([cycle.x, cycle.v])
    np.testing.assert_allclose(f(point), point, rtol=0, atol=1e-11)


def test_a_symmetric_cycle_stays_so_where_both_halves_change_modes() -> None:
    """A slip turns twice a period; just there sticks begin, in both halves or in either one."""
    shaken = ss.Harmonic(1.407, 0.67, 1.0)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.105), damping=0.05, forcing=shaken)
    curve = ss.follow(ss.find_cycle(block, [0.1], [0.0]), "forcing.frequency", (0.645, 0.67))
    (change,) = curve.bifurcations
    assert (change.kind, change.outcome) == ("landing", "persists")
    assert "two other cycles, mirror images, meet it there" in change.what
    assert curve.end_reasons == ("end of range", "end of range")
    for cycle, n_events in ((curve[0], 4), (curve[-1], 2)):
        assert len(cycle.events) == n_events
        half = cycle.trajectory.x(0.5 * cycle.period)
        np.testing.assert_allclose(half, -cycle.x, rtol=0, atol=1e-9)


def test_a_cycle_is_no_partner_of_itself_begun_later() -> None:
    """Three periods of the forcing long, it meets a cycle of one: so do its starts at all three."""
    shaken = ss.Harmonic(1.4, 0.66, 1.0)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.105), damping=0.05, forcing=shaken)
    curve = ss.follow(ss.find_cycle(block, [0.1], [0.0]), "forcing.frequency", (0.645, 0.667))
    fold, change, *_ = curve.bifurcations
    assert (fold.kind, change.kind, change.outcome) == ("fold", "landing", "fold")
    before, beyond = curve[change.row], curve[change.row + 1]
    assert (len(before.events), len(beyond.events)) == (8, 10)
    np.testing.assert_allclose(beyond.x, before.x, rtol=0, atol=1e-4)


def two_unequal(friction: list[ss.FrictionLaw], **numbers: list[float] | float) -> ss.Blocks:
    """Two coupled blocks without dampers; stiffness as its upper triangle."""
    k11, k12, k22 = numbers.pop("stiffness")  # type: ignore[misc]
    stiffness = [[k11, k12], [k12, k22]]
    return ss.Blocks(stiffness=stiffness, friction=friction, **numbers)  # type: ignore[arg-type]


def test_a_cycle_ends_where_it_merges_with_one_of_half_its_period() -> None:
    falls = ss.friction_law(
        "a*(1 - 0.5*tanh(b*s)**2) + 0.05*log1p(s)", parameters={"a": 0.747, "b": 25.0}
    )
    model = two_unequal(
        [falls, ss.Stribeck(mu=0.7384, speed=0.2113, exponent=2)],
        mass=[0.7586, 1.8154],
        stiffness=[1.698, -0.4616, 1.6696],
        static=[1.446, 0.6207],
        V=0.0357,
    )
    curve = ss.follow(ss.find_cycle(model, [0.596, 0.5366], [0.0357, 0.0357]), "mu_2", (0.68, 0.77))
    assert curve.end_reasons == ("period halves", "end of range")
    merged = curve[0]
    half = ss.find_cycle(merged.model, merged.x, merged.v)
    np.testing.assert_allclose(2.0 * half.period, merged.period, rtol=1e-10)
    np.testing.assert_allclose(half.multipliers[0], -1.0, rtol=0, atol=1e-7)
    # Where a stick begins the multiplier jumps over -1, which is no flip.
    flips = [found for found in curve.bifurcations if found.kind == "flip"]
    assert len(flips) == 1
    np.testing.assert_allclose(flips[0].multipliers[0], -1.0, rtol=0, atol=1e-9)


def test_a_closed_curve_of_cycles_is_walked_once() -> None:
    law = ss.friction_law("a - b*s + c*s**3", parameters={"a": 0.67, "b": 0.65, "c": 0.25})
    model = two_unequal(
        [law, ss.Coulomb(mu=0.4377)],
        mass=[1.18, 0.617],
        stiffness=[0.6345, 0.0507, 1.6632],
        static=[0.757, 1.461],
        V=0.0911,
    )
    curve = ss.follow(ss.find_cycle(model, [0.5537, 0.8615], [0.0911, 0.0911]), "a_1", (0.6, 0.75))
    assert curve.end_reasons == ("closed", "closed")
    np.testing.assert_allclose(curve[-1].period, curve[0].period, rtol=1e-9)
    assert [found.kind for found in curve.bifurcations].count("fold") == 2
