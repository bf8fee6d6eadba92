"""Motions obey the equations, whatever the model: locus, balance of forces and energy, events."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from tests.mechanics.flow.systems import (
    COULOMB,
    LAW_9,
    LAW_OF,
    STEPPERS,
    UNTRACED_LAW_9,
    models,
    needed_force,
    random_model,
    states,
)

import stickslip as ss
from stickslip.mechanics.flow import recorder

# Rounding of a force or velocity: a few operations on numbers of the size of the state, and
# of the time where the belt has carried a block.
ROUNDING = 1e-13
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def scale_of(model, x, v):
    """Size of what is added and subtracted in a balance of forces."""
    return 1.0 + model.beta + (1.0 + 2.0 * model.alpha) * np.abs(x).max() + np.abs(v).max()


@st.composite
def motions(draw, *laws, t_end=12.0):
    model = draw(models(*laws))
    x, v = draw(states(model))
    return ss.simulate(model, x, v, t_end=t_end, max_events=60)


def phases(trajectory):
    """Start, end, modes and 40 times inside, for each phase long enough to have an inside."""
    for start, end, modes in zip(trajectory.t, trajectory.t[1:], trajectory.modes, strict=False):
        if end - start > 1e-6:
            yield start, end, modes, start + (end - start) * np.linspace(0.001, 0.999, 40)


def kinetic(model, w, block, mode):
    """Friction of a slipping block straight from eqs. (8)-(10)."""
    law = model.laws[block]
    s = np.maximum(mode * w, 0.0)
    if isinstance(law, ss.Coulomb):
        force = np.full_like(s, law.mu)
    else:
        force = (1 - law.delta) / (1 + law.gamma * s) + law.delta + law.eta * s**2
    return -mode * model.limits[block] * force


@settings(max_examples=60)
@given(motion=motions(COULOMB, LAW_9))
def test_sticking_blocks_stay_inside_the_locus_and_slipping_ones_on_their_side(motion):
    for _, _, modes, t in phases(motion):
        x, v = motion.x(t), motion.v(t)
        tolerance = ROUNDING * scale_of(motion.model, x, v)
        force = needed_force(motion.model, x)
        for block, mode in enumerate(modes):
            if mode == 0:
                assert np.all(np.abs(force[:, block]) <= motion.model.limits[block] + tolerance)
                np.testing.assert_allclose(v[:, block], motion.model.V, rtol=0, atol=1e-15)
            else:
                assert np.all(mode * (v[:, block] - motion.model.V) >= -tolerance)


@settings(max_examples=40)
@given(motion=motions(COULOMB, LAW_9))
def test_the_equations_of_motion_hold(motion):
    # Integrated over pieces of phases: v' = friction - R where a block slips, x' = v.
    model = motion.model
    for start, end, modes, _ in phases(motion):
        edges = np.linspace(start, end, 2 + int((end - start) / 0.3))
        for a, b in itertools.pairwise(edges):
            t = a + (b - a) * 0.5 * (NODES + 1.0)
            x, v = motion.x(t), motion.v(t)
            # one step before an event the state at its time belongs to the next phase
            (x_a, x_b), (v_a, v_b) = motion.x([a, b]), motion.v([a, b])
            tolerance = ROUNDING * scale_of(model, x, v) * (1.0 + end)
            assert np.abs(x_b - x_a - 0.5 * (b - a) * WEIGHTS @ v).max() <= tolerance
            force = needed_force(model, x)
            for block, mode in enumerate(modes):
                if mode == 0:
                    continue
                belt = kinetic(model, v[:, block] - model.V, block, mode)
                gained = 0.5 * (b - a) * WEIGHTS @ (belt - force[:, block])
                assert abs(v_b[block] - v_a[block] - gained) <= tolerance


@settings(max_examples=40)
@given(motion=motions(COULOMB, LAW_9))
def test_friction_is_the_law_or_what_a_rider_needs(motion):
    for _, _, modes, t in phases(motion):
        x, v, friction = motion.x(t), motion.v(t), motion.friction(t)
        for block, mode in enumerate(modes):
            expected = needed_force(motion.model, x)[:, block]
            if mode != 0:
                expected = kinetic(motion.model, v[:, block] - motion.model.V, block, mode)
            tolerance = ROUNDING * scale_of(motion.model, x, v)
            np.testing.assert_allclose(friction[:, block], expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("law", ["coulomb", "law9"])
def test_the_other_blocks_slip_decides_how_fast_a_rider_is_loaded(law):
    """e' >= V while it slips backward (monotone loading), e' <= V while forward, else e' = V."""
    rng = np.random.default_rng(7)
    seen = {-1: 0, 0: 0, 1: 0}
    for _ in range(40):
        model = random_model(rng, law)
        x, v = rng.uniform(-1.5, 1.5, 2), rng.uniform(-1, 1, 2)
        motion = ss.simulate(model, x, v, t_end=40, max_events=40)
        for _, _, modes, t in phases(motion):
            force = needed_force(model, motion.x(t))
            tolerance = ROUNDING * scale_of(model, motion.x(t), motion.v(t))
            for block in np.flatnonzero(modes == 0):
                other = modes[1 - block]
                faster = np.diff(force[:, block]) - model.V * np.diff(t)
                assert np.all(other * faster <= tolerance)
                assert other or np.abs(faster).max() <= tolerance
                seen[other] += 1
    assert min(seen.values()) > 20


@settings(max_examples=40)
@given(motion=motions(COULOMB, LAW_9))
def test_energy_is_balanced_and_friction_only_takes(motion):
    t = np.linspace(0.0, motion.t[-1], 200)
    energy = motion.energy(t)
    x, v = motion.x(t), motion.v(t)
    stretch = x[:, 1] - x[:, 0]
    elastic = 0.5 * (np.sum(x * x, axis=-1) + motion.model.alpha * stretch**2)
    scale = 1.0 + np.max(energy.kinetic + energy.elastic) + np.max(np.abs(energy.belt_work))
    np.testing.assert_allclose(energy.kinetic, 0.5 * np.sum(v * v, axis=-1), rtol=1e-14)
    np.testing.assert_allclose(energy.elastic, elastic, rtol=0, atol=1e-14 * scale)
    assert np.ptp(energy.balance) <= ROUNDING * scale
    assert np.all(np.diff(energy.dissipation) >= -ROUNDING * scale)
    assert energy.belt_work[0] == energy.dissipation[0] == 0.0


def test_energies_beyond_all_floats_are_infinite():
    motion = ss.simulate(ss.examples.coulomb(), [0.0, 0.0], [1e300, 1e300], t_end=1.0)
    energy = motion.energy([0.0, motion.t[-1]])
    assert np.isposinf(energy.kinetic).all()
    assert not np.isfinite(energy.balance).any()


@settings(max_examples=40)
@given(motion=motions(COULOMB, LAW_9))
def test_state_is_continuous_at_events(motion):
    times = motion.t[1:-1]
    before = np.nextafter(times, 0.0)
    x, v = motion.x(times), motion.v(times)
    # A touch is known to the square root of rounding, and so is the velocity there (it is set
    # to the belt's); displacements do not feel it.
    tolerance = 4.0 * ROUNDING * scale_of(motion.model, x, v) if times.size else 0.0
    np.testing.assert_allclose(motion.x(before), x, rtol=0, atol=tolerance)
    np.testing.assert_allclose(motion.v(before), v, rtol=0, atol=tolerance)


@settings(max_examples=30)
@given(motion=motions(COULOMB, LAW_9), share=st.floats(0.05, 0.95))
def test_a_motion_goes_on_from_its_final_state(motion, share):
    # Cut where no event is near: there rounding may decide otherwise.
    t = share * motion.t[-1]
    if motion.status != ss.status.OK or np.abs(motion.t - t).min() < 1e-3:
        return
    model = motion.model
    start = motion.x(0.0), motion.v(0.0)
    first = ss.simulate(model, *start, t_end=t)
    state = first.final_state
    assert state.t == t
    np.testing.assert_allclose(state.x, motion.x(t), rtol=0, atol=1e-12)
    rest = ss.simulate(model, state.x, state.v, t_end=0.5 * (motion.t[-1] - t))
    until = motion.t[(motion.t > t) & (motion.t < t + rest.t[-1])]
    # up to the first event both are one phase, cut in two
    end = until[0] - t if until.size else rest.t[-1]
    times = np.linspace(0.0, end, 20)
    scale = scale_of(model, motion.x(t + times), motion.v(t + times))
    np.testing.assert_allclose(rest.x(times), motion.x(t + times), rtol=0, atol=1e-11 * scale)
    np.testing.assert_allclose(rest.v(times), motion.v(t + times), rtol=0, atol=1e-11 * scale)


@pytest.mark.parametrize("stepper", STEPPERS)
def test_phases_are_those_of_an_ordinary_solver(stepper):
    rng = np.random.default_rng(2)
    model = random_model(rng, LAW_OF[stepper])
    motion = ss.simulate(model, d=0.3 * model.domain[1], t_end=40.0)
    checked = 0
    for start, end, modes, _ in phases(motion):

        def rates(t, y, modes=modes):
            w, force = y[2:] - model.V, needed_force(model, y[:2])
            belt = [
                -m * model.limits[i] * float(model.laws[i].force(max(m * w[i], 0.0)))
                for i, m in enumerate(modes)
            ]
            return [*y[2:], *np.where(modes == 0, 0.0, belt - force)]

        y = np.concatenate((motion.x(start), motion.v(start)))
        found = solve_ivp(rates, (start, end), y, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        np.testing.assert_allclose(found[:2], motion.x(end), rtol=0, atol=1e-9)
        np.testing.assert_allclose(found[2:], motion.v(end), rtol=0, atol=1e-9)
        # and every event is one: a velocity or a force has arrived
        gaps = np.where(
            modes == 0,
            np.array(model.limits) - np.abs(needed_force(model, found[:2])),
            np.abs(found[2:] - model.V),
        )
        assert end == motion.t[-1] or np.abs(gaps).min() < 1e-9
        checked += 1
    assert checked > 5


def test_exact_and_adaptive_engine_move_alike():
    rng = np.random.default_rng(3)
    for _ in range(10):
        model = random_model(rng, "coulomb")
        x, v = rng.uniform(-2, 2, 2), rng.uniform(-1, 1, 2)
        one = ss.simulate(model, x, v, t_end=15)
        other = ss.simulate(model, x, v, t_end=15, engine="adaptive")
        np.testing.assert_array_equal(one.modes, other.modes)
        np.testing.assert_allclose(one.t, other.t, rtol=0, atol=1e-10)
        t = np.linspace(0, 15, 50)
        np.testing.assert_allclose(one.x(t), other.x(t), rtol=0, atol=1e-10)
        a, b = one.energy(t), other.energy(t)
        np.testing.assert_allclose(a.dissipation, b.dissipation, rtol=0, atol=1e-9)


def test_taylor_and_collocation_stepper_move_alike():
    rng = np.random.default_rng(4)
    for _ in range(5):
        model = random_model(rng, "untraced")
        twin = model.replace(friction=ss.PoppStelter(gamma=model.parameters["g"]))
        x, v = rng.uniform(-2, 2, 2), rng.uniform(-1, 1, 2)
        one, other = (ss.simulate(m, x, v, t_end=15) for m in (twin, model))
        np.testing.assert_array_equal(one.modes, other.modes)
        np.testing.assert_allclose(one.t, other.t, rtol=0, atol=1e-9)
        t = np.linspace(0, 15, 50)
        np.testing.assert_allclose(one.x(t), other.x(t), rtol=0, atol=1e-9)


# --- what a trajectory tells -------------------------------------------------------------------


def test_events_phases_and_slips_tell_one_story():
    model = ss.examples.coulomb()
    motion = ss.simulate(model, d=0.1, t_end=200)
    f = ss.event_map(model)
    np.testing.assert_allclose(motion.d[1:], f(motion.d[:-1]), rtol=0, atol=1e-13)
    assert motion.t[0] == 0.0
    assert motion.t[-1] == 200.0
    assert np.all(np.diff(motion.t) > 0.0)
    assert np.all((motion.modes[1:] != motion.modes[:-1]).any(axis=1))
    modes = motion.modes[0].copy()
    kinds = {"stick": 0, "slip backward": -1, "slip forward": 1}
    for event in motion.events:
        assert modes[event.block - 1] != kinds[event.kind]
        modes[event.block - 1] = kinds[event.kind]
    np.testing.assert_array_equal(modes, motion.modes[-1])
    assert len(motion.slips) == len(motion.d) - 1
    result = f.evaluate(motion.d[:-1])
    np.testing.assert_allclose(
        [s.duration for s in motion.slips], result.duration, rtol=0, atol=1e-11
    )
    assert motion.message == "reached its end"
    assert "global stick phases" in repr(motion)


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("record", ["motion", "events"])
def test_moment_of_a_slip_is_how_far_the_belt_ran_ahead(stepper, record):
    law, engine = STEPPERS[stepper]
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    motion = ss.simulate(model, d=0.1, t_end=60, record=record, engine=engine)
    whole = ss.simulate(model, d=0.1, t_end=60, engine=engine)
    assert len(motion.slips) > 2
    for slip in motion.slips:
        edges = whole.t[(whole.t >= slip.start) & (whole.t <= slip.start + slip.duration + 1e-9)]
        pieces = np.concatenate([np.linspace(a, b, 9) for a, b in itertools.pairwise(edges)])
        behind = 0.0
        for a, b in itertools.pairwise(pieces):
            t = a + (b - a) * 0.5 * (NODES + 1.0)
            behind += 0.5 * (b - a) * WEIGHTS @ (model.V - whole.v(t)).sum(axis=1)
        assert slip.moment == pytest.approx(behind, abs=1e-10)
        assert set(slip.blocks) <= {1, 2}
        assert slip.blocks


def test_slips_are_those_that_begin_at_belt_velocity():
    model = ss.examples.coulomb()
    riding = ss.simulate(model, [0.0, 0.0], [model.V, model.V], t_end=1.0)
    assert riding.slips == ()
    assert riding.d.tolist() == [0.0]
    assert riding.modes.tolist() == [[0, 0]]
    ends_riding = ss.simulate(model, d=0.1, t_end=5.0)
    assert ends_riding.modes[-1].tolist() == [0, 0]
    assert [slip.start for slip in ends_riding.slips] == [0.0]
    let_go = ss.simulate(model, [3.0, 3.0], [model.V, model.V], t_end=20.0)  # beyond the limits
    assert let_go.slips[0].start == 0.0
    thrown = ss.simulate(model, [3.0, 3.0], [0.0, 0.0], t_end=20.0)
    assert thrown.slips[0].start > 0.0


def test_until_stick_ends_there_and_t_end_may_come_first():
    model = ss.examples.coulomb()
    motion = ss.simulate(model, d=0.1, until="stick")
    assert motion.modes[-1].any()
    assert len(motion.d) == 2
    assert len(motion.slips) == 1
    assert motion.final_state.t == motion.slips[0].duration
    assert ss.simulate(model, d=0.1, until="stick", t_end=0.5).t[-1] == 0.5
    # from a global stick phase: the next one, not this one
    later = ss.simulate(model, [0.0, 0.0], [model.V, model.V], until="stick")
    assert len(later.d) == 2


def test_a_motion_that_never_sticks_again_ends_with_its_status():
    # friction grows with speed, and the belt is fast: both blocks slide steadily
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=1.0, friction=ss.PoppStelter(0.0, 0.0, 0.2))
    motion = ss.simulate(model, d=0.1, until="stick")
    assert motion.status == ss.status.NEVER_SLIPPING
    assert "slip for ever" in motion.message
    longer = ss.simulate(model, d=0.1, t_end=300.0)
    assert longer.status == ss.status.OK
    assert longer.modes[-1].tolist() == [-1, -1]
    late = longer.v(np.linspace(200.0, 300.0, 500))
    assert np.all(late < 0.1 * model.V)  # they come to rest, far below the belt's velocity


@pytest.mark.parametrize("law", [ss.Coulomb(0.5), ss.PoppStelter(3.0)])
def test_blocks_ride_for_as_long_as_a_slow_belt_needs(law):
    """Steps of 1.5 made 700,000 of a phase at V = 1e-6, and gave up one at 1e-9."""
    block = ss.Oscillator(V=1e-9, friction=law)
    motion = ss.simulate(block, [0.0], [1e-9], t_end=1e9 + 1.0)
    assert motion.t[1] == pytest.approx(1e9, rel=1e-14)  # where the spring pulls with the limit
    np.testing.assert_allclose(motion.x([3e8, 9e8]), [[0.3], [0.9]], rtol=1e-14)
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=1e-9, friction=law)
    start = ss.event_map(model).evaluate(0.1).value
    motion = ss.simulate(model, d=0.1, t_end=3e9)
    assert motion.status == ss.status.OK
    assert len(motion.d) > 2
    assert motion.d[1] == pytest.approx(start, abs=1e-12)
    balance = motion.energy(np.linspace(0.0, 3e9, 9)).balance
    np.testing.assert_allclose(balance, balance[0], rtol=0, atol=1e-6)  # times are 4e-7 apart


def test_what_rides_at_rest_for_ever_is_at_rest():
    """It was given up after a time that was never given."""
    contact = ss.Contact(at=0, friction=ss.Coulomb(0.5))
    motion = ss.simulate(ss.Structure([1.0], [[1.0]], contacts=[contact]), [0], [0], until="stick")
    assert motion.status == ss.status.AT_REST


def test_limits_end_a_trajectory_with_their_status():
    motion = ss.simulate(ss.examples.coulomb(), d=-0.6, t_end=500, max_events=7)
    assert motion.status == ss.status.EVENT_LIMIT
    assert motion.t[-1] < 500
    assert "max_events" in motion.message


def test_a_law_that_fails_ends_the_trajectory_where_it_did():
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=10.0, friction=UNTRACED_LAW_9)
    motion = ss.simulate(model, d=0.1, t_end=5.0)
    assert motion.status == ss.status.LAW_FAILED
    assert 0.0 < motion.t[-1] < 5.0
    assert np.all(np.isfinite(motion.x(np.linspace(0.0, motion.t[-1], 50))))
    np.testing.assert_allclose(motion.final_state.x, motion.x(motion.t[-1]), rtol=0, atol=1e-12)
    speed = model.V - motion.v(motion.t[-1])
    assert speed.max() < 12.0


def test_a_motion_of_more_steps_than_memory_holds_is_given_up(monkeypatch):
    monkeypatch.setattr(recorder, "MOST_KEPT", 500)
    stiff = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4), damping=1e4)
    motion = ss.simulate(stiff, [0.5], [0.0], t_end=0.1)  # 1e3 steps
    assert (motion.status, motion.t[-1] < 0.1) == (ss.status.TIME_LIMIT, True)
    assert np.isfinite(motion.x(motion.t[-1])).all()
    assert ss.simulate(stiff, [0.5], [0.0], t_end=0.1, record="events").status == ss.status.OK


@pytest.mark.parametrize("blocks", [[1.0, 0.0], [1.0, -1.0], [-1.0, -1.0]])
@pytest.mark.parametrize("velocity", [1e153, 1e300])
def test_a_motion_beyond_all_numbers_ends_at_its_last_finite_state(velocity, blocks):
    """Squares of 1e300 overflow: the state became NaN, with the status OK at 50."""
    for law in (ss.Coulomb(0.22), ss.examples.law9().friction):
        model = ss.TwoBlock(alpha=1.2, beta=1.3, V=1e100, friction=law)
        motion = ss.simulate(model, [0.0, 0.0], velocity * np.array(blocks), t_end=50.0)
        assert np.isfinite(motion.final_state.x).all()
        assert np.isfinite(motion.final_state.v).all()
        assert np.isfinite(motion.x(0.5 * motion.t[-1])).all()
        assert (motion.t[-1] == 50.0) == (motion.status == ss.status.OK)
        assert velocity < 1e300 or motion.status in (ss.status.STEP_FAILED, ss.status.LAW_FAILED)


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_trajectory_of_no_length(stepper):
    law, engine = STEPPERS[stepper]
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    motion = ss.simulate(model, d=0.1, t_end=0.0, engine=engine)
    np.testing.assert_allclose(motion.x(0.0), model.onset(0.1), rtol=0, atol=1e-15)
    assert motion.v(0.0).tolist() == [0.1, 0.1]
    assert motion.events == motion.slips == ()
    assert motion.energy(0.0).dissipation == 0.0


def test_results_have_the_shape_of_the_times():
    motion = ss.simulate(ss.examples.law9(), d=0.1, t_end=10)
    times = np.linspace(0, 10, 6).reshape(2, 3)
    for method in (motion.x, motion.v, motion.friction):
        assert method(times).shape == (2, 3, 2)
        assert method(3.0).shape == (2,)
        assert method([]).shape == (0, 2)
        np.testing.assert_array_equal(method(times)[1, 2], method(10.0))
    assert motion.energy(times).belt_work.shape == (2, 3)
    assert motion.energy(1.0).balance.shape == ()


# --- ties and degenerate models ----------------------------------------------------------------


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
@pytest.mark.parametrize(
    ("alpha", "beta", "mu"), [(1.2, 1.3, 0.22), (0.0, 1.3, 0.3), (1.5, 1.0, 0.4), (1.2, 1.0, 0.0)]
)
def test_at_the_corner_both_blocks_leave_together(alpha, beta, mu, engine):
    model = ss.TwoBlock(alpha=alpha, beta=beta, V=0.1, friction=ss.Coulomb(mu))
    d = (beta - 1) / (1 + 2 * alpha)
    motion = ss.simulate(model, d=d, until="stick", engine=engine)
    assert motion.modes[0].tolist() == [-1, -1]
    if beta == 1.0:  # equal blocks at d = 0 move as one
        assert motion.modes.tolist() == [[-1, -1]]
        assert motion.d[1] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
@pytest.mark.parametrize("mu", [0.0, 0.3, 0.8])
def test_one_free_block_is_the_textbook_stick_slip(mu, engine):
    # alpha = 0: X'' + X = mu from X = 1, X' = V; back at V after 2 (pi - atan((1 - mu) / V))
    V = 0.1
    model = ss.TwoBlock(alpha=0.0, beta=1.3, V=V, friction=ss.Coulomb(mu))
    motion = ss.simulate(model, d=-1.5, until="stick", engine=engine)
    duration = 2.0 * (np.pi - np.arctan((1.0 - mu) / V))
    assert motion.t[-1] == pytest.approx(duration, abs=1e-14)
    assert motion.modes.tolist() == [[-1, 0]]
    # it lands at its mirror image about mu, while the other rode on
    ahead = V * duration + 2.0 * (1.0 - mu)
    assert motion.d[1] == pytest.approx(-1.5 + ahead, abs=1e-14)
    assert motion.slips[0].moment == pytest.approx(ahead, abs=1e-14)


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_without_kinetic_friction_a_return_at_the_lower_limit_sticks(engine):
    # mu = 0: R = -limit exactly, and the belt moves it inward (rule 2)
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(0.0))
    motion = ss.simulate(model, d=-0.6, until="stick", engine=engine)
    assert motion.modes.tolist() == [[-1, 0]]
    force = needed_force(model, motion.final_state.x)
    assert force[0] == pytest.approx(-1.0, abs=1e-14)


@pytest.mark.parametrize("law", [ss.Coulomb(1.0), ss.PoppStelter(0.0)])
def test_friction_as_large_as_the_static_limit_starts_slips_tangentially(law):
    # F(0) = 1: w = -(V / W^2) (1 - cos W t), a double root at t = 0, back at 2 pi / W
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    W = np.sqrt(2.2)
    motion = ss.simulate(model, d=model.domain[0], t_end=4.0)
    assert motion.t[0:2] == pytest.approx([0.0, 4.0])
    t = np.linspace(0.0, 4.0, 50)
    w = -(model.V / 2.2) * (1.0 - np.cos(W * t))
    np.testing.assert_allclose(motion.v(t)[:, 0] - model.V, w, rtol=0, atol=1e-15)


@pytest.mark.parametrize("top", [1 - 2**-52, 1 + 2**-52, 1 + 2**-50])
def test_so_does_a_law_by_values_that_starts_at_the_limit_but_for_rounding(top):
    law = ss.friction_law(lambda s, top: top if s < 12 else np.nan, parameters={"top": top})
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    motion = ss.simulate(model, d=0.3, t_end=0.4)
    assert motion.t.tolist() == [0.0, 0.4]
    w = -(model.V / 2.2) * (1.0 - np.cos(np.sqrt(2.2) * 0.4))
    assert motion.v(0.4)[1] - model.V == pytest.approx(w, rel=1e-12)


def test_at_the_ends_of_the_domain_the_other_block_keeps_sticking():
    for friction in (ss.Coulomb(0.22), ss.Coulomb(0.0), ss.PoppStelter(3.0)):
        model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=friction)
        for d, slipper in zip(model.domain, (0, 1), strict=True):
            motion = ss.simulate(model, d=d, t_end=1e-3)
            expected = [0, 0]
            expected[slipper] = -1
            assert motion.modes.tolist() == [expected]


# --- errors ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"d": 0.1}, r"give an end: t_end= a time, until='stick', or both"),
        ({"t_end": 1.0}, r"give either d=, .*, or both x and v"),
        ({"d": 0.1, "x": [0, 0], "v": [0, 0], "t_end": 1.0}, r"give either d="),
        ({"x": [0.0, 0.0], "t_end": 1.0}, r"both x and v"),
        ({"d": 0.1, "t_end": -1.0}, r"t_end = -1\.0 is not allowed.*>= 0"),
        ({"d": 0.1, "t_end": float("nan")}, r"t_end = nan is not allowed"),
        ({"d": 0.9, "t_end": 1.0}, r"d = 0\.9 is outside the global stick locus"),
        ({"d": float("nan"), "t_end": 1.0}, r"d = nan is not allowed"),
        ({"d": 0.1, "until": "slip"}, r"until = 'slip' is unknown. Known: stick. Or give t_end"),
        (
            {"d": 0.1, "t_end": 1.0, "record": "all"},
            r"record = 'all' is unknown. Known: motion, events",
        ),
        ({"x": [0.0, 0.0, 0.0], "v": [0.0, 0.0], "t_end": 1.0}, r"x = .*2 finite numbers"),
        ({"x": [0.0, 0.0], "v": [np.inf, 0.0], "t_end": 1.0}, r"v = .*2 finite numbers"),
        ({"d": 0.1, "t_end": 1.0, "engine": "rk"}, r"engine = 'rk' is unknown. Known: auto, exact"),
        ({"d": 0.1, "t_end": 1.0, "rtol": -1.0}, r"rtol = -1\.0 is not allowed"),
        (
            {"d": 0.1, "t_end": 1.0, "rtol": 0.1},
            r"rtol = 0\.1 is not allowed: .*0 < rtol <= 0\.001",
        ),
        ({"d": 0.1, "t_end": 1.0, "max_events": 0}, r"max_events = 0 .*whole number >= 1"),
        ({"d": 0.1, "t_end": 1.0, "max_events": 2.5}, r"max_events = 2\.5 .*whole number >= 1"),
    ],
)
def test_wrong_calls_are_explained(arguments, message):
    with pytest.raises(ValueError, match=message):
        ss.simulate(ss.examples.coulomb(), **arguments)


def test_wrong_models_and_times_are_explained():
    with pytest.raises(ValueError, match=r"model = 'coulomb' is not a model"):
        ss.simulate("coulomb", d=0.1, t_end=1.0)
    with pytest.raises(ValueError, match=r"constant kinetic friction"):
        ss.simulate(ss.examples.law9(), d=0.1, t_end=1.0, engine="exact")
    motion = ss.simulate(ss.examples.law9(), d=0.1, t_end=1.0)
    for bad in (-0.1, 1.1, np.nan, [0.5, 2.0]):
        with pytest.raises(ValueError, match=r"outside the trajectory; allowed: 0 <= t <= 1\.0"):
            motion.x(bad)
    events = ss.simulate(ss.examples.law9(), d=0.1, t_end=9.0, record="events")
    assert len(events.events) > 2
    with pytest.raises(ValueError, match=r"record='motion'"):
        events.x(0.5)
