"""When turns of a loop count as going on for ever: on maps whose future is computed beside."""

import math

import numpy as np
import pytest
from tests.sizes import sizes

import stickslip as ss
from stickslip.mechanics.eventmap.loop import Loop, excess, row_norm
from stickslip.mechanics.flow.engine import engine_for

pytestmark = pytest.mark.kernel


def told(turn, earlier, moved, room):
    n = len(earlier)
    rows = (np.array(earlier, float), np.array(moved, float), np.array(turn, float))
    with np.errstate(over="ignore", invalid="ignore"):  # powers of turns that expand
        return excess(Loop(*rows, *np.zeros((2, n, n)), np.ones(n)), room) < 1.0


def random_turn(rng, n, radius):
    """A matrix of that spectral radius, often far from normal."""
    turn = rng.normal(size=(n, n)) * np.exp(rng.uniform(0, 1.5) * np.arange(n))
    return turn * radius / np.abs(np.linalg.eigvals(turn)).max()


@pytest.mark.parametrize("n_turns", sizes(80, 800))
def test_straight_turns_that_contract_stay_within_the_room_they_are_given(n_turns):
    rng = np.random.default_rng(1)
    verdicts = []
    for _ in range(n_turns):
        n, radius = rng.integers(1, 6), 1 - 10 ** rng.uniform(-2.5, -0.1)
        turn, earlier = random_turn(rng, n, radius), rng.normal(size=n)
        moved = turn @ earlier
        room = 10 ** rng.uniform(0, 6)
        verdicts.append(told(turn, earlier, moved, room))
        if verdicts[-1]:
            step, place, farthest = moved.copy(), np.zeros(n), 0.0
            for _ in range(3000):
                place += step
                step = turn @ step
                farthest = max(farthest, np.abs(place).max())
            assert farthest < room
            assert np.abs(step).max() < 1e-3 * np.abs(moved).max()
    assert 0.2 < np.mean(verdicts) < 0.9


@pytest.mark.parametrize("radius", [1.0, 1.001, 2.0])
def test_turns_that_do_not_contract_settle_nowhere(radius):
    rng = np.random.default_rng(2)
    for _ in range(50):
        turn, earlier = random_turn(rng, 3, radius), rng.normal(size=3)
        assert not told(turn, earlier, turn @ earlier, 1e12)


def test_turns_that_bend_settle_only_where_the_bend_leaves_a_fixed_point():
    # x -> a x + c x^2: contracting at 0, repelling at (1 - a) / c, from where starts are lost.
    rng = np.random.default_rng(3)
    kept = lost = 0
    for _ in range(2000):
        a, c, start = rng.uniform(-0.95, 0.95), 10 ** rng.uniform(-2, 2), rng.uniform(-1, 1)
        x = [start]
        for _ in range(2):
            x.append(a * x[-1] + c * x[-1] ** 2)
        slope = a + 2 * c * x[1]
        if told([[slope]], [x[1] - x[0]], [x[2] - x[1]], 1e9):
            last = x[2]
            for _ in range(3000):
                last = a * last + c * last**2
            assert abs(last) < 1e-9
            kept += 1
        else:
            lost += 1
    assert min(kept, lost) > 300


def test_turns_that_bend_settle_on_no_fixed_point_that_repels_by_turning_over():
    # The same with a < -1: beside 0 the slope may still be one of contraction.
    rng = np.random.default_rng(5)
    contract = 0
    for _ in range(2000):
        a, c, start = rng.uniform(-1.1, -1.0), 10 ** rng.uniform(-2, 2), rng.uniform(-1, 1)
        start *= 0.1 / c
        x = [start, (a + c * start) * start]
        x.append((a + c * x[1]) * x[1])
        slope = a + 2 * c * x[1]
        contract += abs(slope) < 1
        assert not told([[slope]], [x[1] - x[0]], [x[2] - x[1]], 1e9)
    assert contract > 500


def test_a_state_that_recurs_exactly_settles_if_it_contracts():
    assert told([[0.5]], [0.0], [0.0], 1e-9)
    assert not told([[1.0]], [0.0], [0.0], 1e-9)
    assert not told([[math.nan]], [0.0], [0.0], 1e-9)


def test_the_norm_bounds_how_far_states_are_carried_apart():
    rng = np.random.default_rng(4)
    for n in (1, 2, 5):
        matrix = rng.uniform(-1, 1, (n, n))
        assert row_norm(matrix) == pytest.approx(np.linalg.norm(matrix, math.inf), rel=1e-14)


@pytest.mark.parametrize("mode", [(-1, -1), (-1, 0), (0, 1)])
def test_tangents_of_turns_tell_as_much_as_they_have_to(mode):
    # They take fewer terms than those of the start, which are the same at a state in flight.
    engine = engine_for(ss.examples.law9())
    kernels, work = engine.kernels, engine.new_work()
    tangents = []
    for directions in (engine.directions(np.eye(4)), engine.widened(engine.directions(), 4)):
        motion = engine.new_motion(directions)
        motion.mode[:] = mode
        motion.w[:] = 0.3 * np.array(mode)
        motion.e[:] = (0.2, -0.1)
        motion.tangent_z[:] = np.eye(4)
        for _ in range(3):
            length, _ = kernels.advance(engine.system, engine.laws, motion, work, 1e-15, math.inf)
            assert length > 0.0
            assert not motion.event.any()
        tangents.append(motion.tangent_z)
    full, short = tangents
    assert 0.0 < np.abs(short - full).max() < 1e-6 * np.abs(full).max()
