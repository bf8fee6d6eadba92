"""Transitions, closed forms and tangents of single kernels."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

import stickslip as ss
from stickslip.mechanics.flow._exact_kernels import (
    mode_swings,
    move_both,
    move_one,
    new_work,
    rider_touch,
)
from stickslip.mechanics.flow._sliding_kernels import energy_reach
from stickslip.mechanics.flow.dense import find_events
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.flow.oscillator import oscillator, oscillator_sharp, oscillator_tangent
from stickslip.mechanics.flow.saltation import saltation
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    FORWARD,
    LANDING,
    START,
    STICK,
    System,
    limit,
    loading_rate,
    new_motion,
)
from stickslip.mechanics.flow.transitions import (
    mode_on_belt,
    onset,
    release,
    round_landings,
    settle,
)

pytestmark = pytest.mark.kernel

SYSTEM = System(alpha=1.2, beta=1.3, V=0.1)
EPS = np.finfo(float).eps
SMALL = st.floats(-2.0, 2.0)


def motion_at(w, e, mode=(0, 0), n_columns=0):
    motion = new_motion(n_columns, 1)
    motion.w[:], motion.e[:], motion.mode[:] = w, e, mode
    return motion


@pytest.mark.parametrize("block", [0, 1])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_table_of_a_block_on_the_belt(block, side):
    end = limit(SYSTEM, block)
    slip = BACKWARD if side > 0 else FORWARD

    def mode(force, other_w):
        w, e = np.zeros(2), np.zeros(2)
        e[block], w[1 - block] = side * force, other_w
        return mode_on_belt(SYSTEM, motion_at(w, e), block)

    # e' = V - alpha w_other: outward at the upper end unless the other slips forward fast
    outward, inward = (-1.0, 1.0) if side > 0 else (1.0, -1.0)
    for other in (outward, inward):
        assert mode(0.5 * end, other) == STICK
        assert mode(end * (1 - 1e-12), other) == STICK
        assert mode(end * (1 + 1e-12), other) == slip
    assert mode(end, outward) == slip
    assert mode(end, inward) == STICK
    # equality means equal: what an engine rounds is put at the limit before
    assert mode(end * (1 - EPS), outward) == STICK
    assert mode(end * (1 + EPS), inward) == slip


@pytest.mark.parametrize("block", [0, 1])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_force_next_to_its_limit_is_put_there(block, side):
    end = limit(SYSTEM, block)

    def rounded(force, low=0.0):
        motion = motion_at(np.zeros(2), [side * force, side * force])
        motion.e_low[block] = side * low
        motion.event[block] = LANDING
        round_landings(SYSTEM, motion, 4.0)
        assert motion.e[1 - block] == side * force, "no landing, no rounding"
        return side * motion.e[block], side * motion.e_low[block]

    for force in (end * (1 - 3 * EPS), end, end * (1 + 3 * EPS)):
        assert rounded(force) == (end, 0.0)
    for force in (end * (1 - 6 * EPS), end * (1 + 6 * EPS)):
        assert rounded(force) == (force, 0.0)
    low = 0.7 * np.spacing(end)
    assert rounded(end + 4 * EPS * end, -low) == (end, 0.0)
    assert rounded(end - 4 * EPS * end, -low) != (end, 0.0)


def test_what_rounding_left_out_of_a_force_decides():
    for low, mode in ((-1e-20, STICK), (1e-20, BACKWARD)):
        motion = motion_at(np.zeros(2), [1.0, 0.0])
        motion.e_low[0] = low
        assert mode_on_belt(SYSTEM, motion, 0) == mode


def test_a_released_block_stands_exactly_at_its_limit():
    for block in range(2):
        for mode in (BACKWARD, FORWARD):
            motion = motion_at([0.3, 0.3], [0.9999, 1.2999])
            release(SYSTEM, motion, block, mode)
            assert motion.mode[block] == mode
            assert motion.w[block] == 0.0
            assert motion.e[block] == -mode * limit(SYSTEM, block)
            assert motion.mode[1 - block] == STICK


def test_blocks_at_one_event_change_together():
    motion = motion_at([-1e-17, 0.0], [0.4, 1.3], mode=(BACKWARD, STICK))
    motion.event[:] = (LANDING, AT_UPPER_LIMIT)
    settle(SYSTEM, motion)
    assert motion.mode.tolist() == [STICK, BACKWARD]
    assert motion.w.tolist() == [0.0, 0.0]
    motion = motion_at([0.0, 0.0], [-1.0, 1.3])
    motion.event[:] = (AT_LOWER_LIMIT, AT_UPPER_LIMIT)
    settle(SYSTEM, motion)
    assert motion.mode.tolist() == [FORWARD, BACKWARD]


def test_a_landing_decides_with_the_velocity_of_the_other_at_that_moment():
    # Both land in the same instant: neither loads the other any more, the belt loads both.
    motion = motion_at([1e-16, 1e-16], [-1.0, 0.2], mode=(FORWARD, FORWARD))
    motion.event[:] = (LANDING, LANDING)
    settle(SYSTEM, motion)
    assert motion.mode.tolist() == [STICK, STICK]  # -limit, moving inward at rate V
    # The other rushes forward: the force moves outward, and the block passes through.
    motion = motion_at([1e-16, 1.0], [-1.0, 0.2], mode=(BACKWARD, FORWARD))
    motion.event[:] = (LANDING, 0)
    settle(SYSTEM, motion)
    assert motion.mode.tolist() == [FORWARD, FORWARD]
    assert motion.e[0] == -1.0


@given(alpha=st.floats(0, 3), beta=st.floats(0.3, 2.5), share=st.floats(-1, 1))
def test_the_onset_is_at_the_first_upper_limit(alpha, beta, share):
    end = (1 + beta) / (1 + 2 * alpha)
    motion = motion_at([9.0, 9.0], [9.0, 9.0])
    onset(System(alpha, beta, 0.1), motion, share * end)
    limits = (1.0, beta)
    assert motion.w.tolist() == [0.0, 0.0]
    for block in range(2):
        if motion.mode[block] == BACKWARD:
            assert motion.e[block] == limits[block]
        else:
            assert motion.mode[block] == STICK
            assert -limits[block] <= motion.e[block] < limits[block]
    spread = motion.e[1] - motion.e[0]
    assert spread == pytest.approx((1 + 2 * alpha) * share * end, abs=1e-14 * (1 + beta))
    corner = (beta - 1) / (1 + 2 * alpha)
    if abs(share * end - corner) > 1e-12:
        assert motion.mode.tolist() == ([-1, 0] if share * end < corner else [0, -1])


@given(stiffness=st.floats(0.5, 5), drive=st.floats(0, 1), w=SMALL, pull=SMALL, t=st.floats(0, 6))
def test_the_oscillator_solves_its_equations(stiffness, drive, w, pull, t):
    # w' = pull, pull' = -stiffness w - drive; by a series of the matrix exponential
    h, steps = t / 64, 64
    state, exact = np.array([w, pull]), oscillator(stiffness, drive, w, pull, t)
    matrix, constant = np.array([[0.0, 1.0], [-stiffness, 0.0]]), np.array([0.0, -drive])
    for _ in range(steps):
        term, total = state, state.copy()
        for k in range(1, 14):
            term = h / k * (matrix @ term + (constant if k == 1 else 0.0))
            total = total + term
        state = total
    np.testing.assert_allclose(exact, state, rtol=0, atol=1e-12)


@given(coupling=st.floats(0, 5), drive=st.floats(0, 1), w=SMALL, pull=SMALL, t=st.floats(0, 9))
def test_the_sharp_oscillator_is_right_beyond_rounding(coupling, drive, w, pull, t):
    w_new, w_low, pull_new, pull_low = oscillator_sharp(coupling, drive, w, 0.0, pull, 0.0, t)
    with mpmath.workdps(40):
        stiffness = 1 + mpmath.mpf(coupling)
        frequency = mpmath.sqrt(stiffness)
        c, s = mpmath.cos(frequency * t), mpmath.sin(frequency * t) / frequency
        error_w = w_new + (w_low - (w * c + pull * s - drive * (1 - c) / stiffness))
        error_pull = pull_new + (pull_low - (pull * c - (stiffness * w + drive) * s))
    size = (abs(w) + abs(pull) + drive) * float(stiffness)
    allowed = 0.2 * 2**-52 * size + 1e-300  # below that the low parts have no bits
    assert abs(error_w) <= allowed
    assert abs(error_pull) <= allowed


@given(
    point=st.tuples(st.floats(0.8, 4), st.floats(0, 1), SMALL, SMALL, st.floats(0, 6)),
    direction=st.tuples(*[st.floats(-1, 1)] * 4),
)
def test_the_oscillators_tangent_is_its_derivative(point, direction):
    *arguments, t = point
    h = 1e-3
    nodes = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / h
    values = [oscillator(*(np.array(arguments) + h * k * np.array(direction)), t) for k in nodes]
    expected = weights @ np.array(values)
    np.testing.assert_allclose(
        oscillator_tangent(*arguments, t, *direction), expected, rtol=0, atol=1e-9
    )


def test_saltation_moves_the_state_by_its_velocity_times_the_delay_of_the_event():
    motion = motion_at([0.0, -0.4], [0.2, 0.7], mode=(BACKWARD, BACKWARD), n_columns=1)
    motion.directions[0, START] = 1.0
    motion.tangent_w[:, 0], motion.tangent_e[:, 0] = (0.5, -0.2), (0.3, 0.1)
    motion.event[0] = LANDING
    rates_w = (0.8, -0.1)
    rates_e = [loading_rate(SYSTEM, motion.w, block) for block in range(2)]
    saltation(SYSTEM, motion, *rates_w)
    delay = -0.5 / 0.8
    np.testing.assert_allclose(
        motion.tangent_w[:, 0], [0.0, -0.2 - 0.1 * delay], rtol=0, atol=1e-16
    )
    expected = [0.3 + rates_e[0] * delay, 0.1 + rates_e[1] * delay]
    np.testing.assert_allclose(motion.tangent_e[:, 0], expected, rtol=1e-15)


def test_saltation_at_a_touch_moves_nothing():
    motion = motion_at([0.0, -0.4], [0.2, 0.7], mode=(BACKWARD, BACKWARD), n_columns=1)
    motion.tangent_w[:, 0] = (0.5, -0.2)
    motion.event[0] = LANDING
    saltation(SYSTEM, motion, 0.0, -0.1)
    assert motion.tangent_w[:, 0].tolist() == [0.5, -0.2]


@given(y=st.tuples(SMALL, SMALL), r=st.tuples(SMALL, SMALL))
def test_the_reach_of_energy_is_attained_by_no_velocity_beyond(y, r):
    # (y.y + r K^-1 r) / 2 with K the stiffness matrix, by linear algebra
    alpha, beta, V = SYSTEM
    force = (0.4, 0.6)
    motion = motion_at(np.array(y) - V, np.array(r) + np.array([force[0], beta * force[1]]))
    K = np.array([[1 + alpha, -alpha], [-alpha, 1 + alpha]])
    expected = math.sqrt(y[0] ** 2 + y[1] ** 2 + np.array(r) @ np.linalg.solve(K, r))
    assert energy_reach(SYSTEM, motion, *force) == pytest.approx(expected, rel=1e-12, abs=1e-14)


@given(w=st.tuples(SMALL, SMALL), e=st.tuples(SMALL, SMALL), modes=st.sampled_from([1, -1]))
def test_the_swings_of_two_slipping_blocks_are_the_largest_they_come_to(w, e, modes):
    # velocities X_1' + X_2' and X_2' - X_1', sampled over a period of each
    laws = engine_for(ss.TwoBlock(*SYSTEM, friction=ss.Coulomb(0.3))).laws
    motion, work = motion_at(w, e, mode=(modes, -1)), new_work()
    swings = mode_swings(SYSTEM, laws, motion, motion.w, motion.e)
    work.start_w[:], work.start_e[:] = w, e
    for swing, sign, stiffness in zip(
        swings, (1.0, -1.0), (1.0, 1 + 2 * SYSTEM.alpha), strict=True
    ):
        reached = 0.0
        for t in np.linspace(0.0, 2 * math.pi / math.sqrt(stiffness), 100):
            move_both(SYSTEM, laws, motion, work, t)
            velocity = motion.w + SYSTEM.V
            reached = max(reached, abs(velocity[1] + sign * velocity[0]))
        assert 0.999 * swing - 1e-14 <= reached <= swing + 1e-14


def test_contacts_at_the_start_of_a_step_are_one_event():
    # Both blocks slip backward, stand on the belt and are pushed forward: they land together.
    motion = motion_at([0.0, 0.0], [0.2, 0.3], mode=(BACKWARD, BACKWARD))
    w, e, signal = np.zeros((2, 4)), np.zeros((2, 4)), np.zeros(4)
    w[:, 1], w[:, 3], e[:, 0] = 0.5, 0.1, motion.e
    assert find_events(SYSTEM, motion, w, e, signal, 1.0) == 0.0
    assert motion.event.tolist() == [LANDING, LANDING]
    # one of them moves off: the other lands alone, in no time
    w[1, 1] = -0.5
    assert find_events(SYSTEM, motion, w, e, signal, 1.0) == 0.0
    assert motion.event.tolist() == [LANDING, 0]


def test_a_rider_next_to_a_touch_reaches_its_limit_as_much_earlier_as_it_goes_beyond():
    # Block 1 slips forward, faster and faster: the force of block 2 grows until w_1 = V / alpha,
    # and falls after that.
    beyond = 1e-8
    laws = engine_for(ss.TwoBlock(*SYSTEM, friction=ss.Coulomb(0.3))).laws
    motion, work = motion_at([0.0, 0.0], [-1.0, 0.0], mode=(FORWARD, STICK)), new_work()
    motion.w[0] = work.start_w[0] = 0.05
    work.start_e[0] = -1.0

    def force(t):
        move_one(SYSTEM, laws, motion, work, 0, t)
        return motion.e[1]

    turn = minimize_scalar(lambda t: -force(t), bounds=(0.0, 0.5), options={"xatol": 1e-12}).x
    assert 0.01 < turn < 0.4
    work.start_e[1] = SYSTEM.beta + beyond - force(turn)
    expected = brentq(lambda t: force(t) - SYSTEM.beta, 0.0, turn, xtol=1e-15)
    motion.event[:] = 0
    force(turn)
    found = rider_touch(SYSTEM, laws, motion, work, 0, turn)
    assert turn - found == pytest.approx(turn - expected, rel=1e-3)
    work.start_e[1] -= 2 * beyond
    force(turn)
    assert rider_touch(SYSTEM, laws, motion, work, 0, turn) == math.inf
