"""Slips of any motion: who takes part, how much, and that a stream of them keeps nothing."""

from __future__ import annotations

import gc
import itertools
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import stickslip as ss

CHAIN = ss.Chain(static=[1.0, 1.3, 1.1, 1.2, 0.9], alpha=0.4, V=0.05, friction=ss.Coulomb(mu=0.3))


def slips_of(motion: ss.Trajectory) -> set[tuple[float, float, tuple[int, ...]]]:
    """Slips once more: components of the graph of all intervals in which a block moves."""
    intervals = []
    n = motion.model.n_blocks
    modes = np.vstack([motion.modes, motion.modes[-1:]])
    for block in range(n):
        moves = np.concatenate([[0], modes[:-1, block] != 0, [0]])
        for a, b in zip(*(np.flatnonzero(np.diff(moves) == s) for s in (1, -1)), strict=True):
            intervals.append((motion.t[a], motion.t[b], block))
    together = {k: {k} for k in range(len(intervals))}
    for k, m in itertools.combinations(range(len(intervals)), 2):
        (a, b, i), (c, d, j) = intervals[k], intervals[m]
        if abs(i - j) == 1 and max(a, c) < min(b, d) and together[k] is not together[m]:
            together[k] |= together[m]
            for other in together[m]:
                together[other] = together[k]
    found = set()
    for group in {id(group): group for group in together.values()}.values():
        start, end = (f(intervals[k][s] for k in group) for s, f in ((0, min), (1, max)))
        if start > 0.0 and end < motion.t[-1]:
            found.add((start, end, tuple(sorted({intervals[k][2] + 1 for k in group}))))
    return found


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000))
def test_coupled_blocks_that_move_at_the_same_time_are_one_slip(seed):
    motion = ss.simulate(CHAIN, *CHAIN.sample_state(seed), t_end=60, record="events")
    told = {(s.start, s.start + s.duration, s.blocks) for s in motion.slips}
    expected = slips_of(motion)
    assert {x[2] for x in told} == {x[2] for x in expected}
    np.testing.assert_allclose(
        sorted(x[:2] for x in told), sorted(x[:2] for x in expected), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("model", [CHAIN, ss.examples.coulomb(), ss.examples.law9()])
def test_a_stream_tells_the_slips_of_the_trajectory(model):
    x, v = model.sample_state(4)
    motion = ss.simulate(model, x, v, t_end=80, record="events")
    stream = ss.slips(model, x, v, t_end=80)
    assert list(stream) == list(motion.slips)
    assert stream.status == ss.status.OK
    np.testing.assert_array_equal(stream.state.x, motion.final_state.x)


@pytest.mark.parametrize(
    ("x", "v", "blocks"),
    [
        ([1.0, 0.5, 0.0, 0.0, 0.0], [0.05] * 5, (1,)),  # block 1 is let go, the others ride
        ([0.0, 0.0, 0.0, 0.0, 1.0], [0.5, 0.05, 0.05, 0.05, 0.05], (5,)),  # far from one that moves
        ([2.0, 0.5, 0.0, 0.0, 0.0], [0.05, 0.5, 0.05, 0.05, 0.05], None),  # beside one that moves
    ],
)
def test_a_block_that_is_let_go_beyond_its_limit_begins_to_slip(x, v, blocks):
    motion = ss.simulate(CHAIN, x, v, t_end=20, record="events")
    assert motion.modes[0, 4 if blocks == (5,) else 0] == -1
    first = [slip for slip in motion.slips if slip.start == 0.0]
    assert [slip.blocks for slip in first] == ([] if blocks is None else [blocks])
    stream = ss.slips(CHAIN, x, v, t_end=20)
    assert [slip for slip in stream if slip.start == 0.0] == first
    if first:
        assert motion.derivative("x0_3").slip_starts[motion.slips.index(first[0])] == 0.0


def test_blocks_lag_behind_the_belt_by_their_slips():
    """Moments of all slips, and of those cut by the ends, add up to the travel of the belt."""
    start = np.zeros(5), np.full(5, CHAIN.V)
    stream = ss.slips(CHAIN, *start, t_end=3000)
    moments = [slip.moment for slip in stream]
    left = 5 * CHAIN.V * stream.state.t - (stream.state.x - start[0]).sum()
    assert sum(moments) == pytest.approx(left, abs=5.0)
    assert len(moments) > 150
    # ... exactly, if the motion ends with all blocks on the belt
    ends = ss.simulate(CHAIN, *start, until="stick")
    travel = 5 * CHAIN.V * ends.t[-1] - (ends.final_state.x - start[0]).sum()
    assert sum(slip.moment for slip in ends.slips) == pytest.approx(travel, abs=1e-13)


def test_slips_of_two_blocks_are_steps_of_the_event_map():
    model = ss.examples.law9()
    f = ss.event_map(model)
    d = 0.3
    for slip in itertools.islice(ss.slips(model, d=d, max_events=400), 12):
        step = f.evaluate(d)
        assert slip.duration == pytest.approx(step.duration, abs=1e-10)
        d = step.value


def test_a_lone_slip_is_that_of_one_block_on_a_stiffer_spring():
    """Its neighbours ride and pull ever harder: e' = (1 + 2 alpha) w + V."""
    mu, alpha, V = 0.3, 0.4, 0.05

    def rates(_, y):
        return [mu - y[1], (1 + 2 * alpha) * y[0] + V, y[0]]

    def back(t, y):
        return y[0] if t > 0.1 else -1.0

    back.terminal, back.direction = True, 1
    run = solve_ivp(rates, (0, 20), [0.0, 1.0, 0.0], "DOP853", rtol=1e-13, atol=1e-14, events=back)
    chain = ss.Chain(static=[9.0, 1.0, 9.0], alpha=alpha, V=V, friction=ss.Coulomb(mu=mu))
    slip = next(ss.slips(chain, np.zeros(3), np.full(3, V), t_end=50))
    assert slip.blocks == (2,)
    assert slip.duration == pytest.approx(run.t_events[0][0], abs=1e-9)
    assert slip.moment == pytest.approx(-run.y[2, -1], abs=1e-10)


def kept_by(follow: Callable[[], object]) -> int:
    """Bytes taken in a call that are still in use after it, as long as its result is."""
    gc.freeze()  # what was there before, all tests that are still to run too, is not looked at
    tracemalloc.start()
    result = follow()
    gc.collect()
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    gc.unfreeze()
    del result
    return kept


def test_memory_does_not_grow_with_the_motion():
    """What a stream keeps of the motion's second half is little beside what a trajectory keeps."""
    start, t_end = CHAIN.sample_state(1), 2000.0

    def trajectory():
        return ss.simulate(CHAIN, *start, t_end=t_end, record="events")

    trajectory()  # once before: what is compiled or loaded on the way stays as well
    whole = kept_by(trajectory)
    stream = ss.slips(CHAIN, *start, t_end=t_end)
    assert any(slip.start > 0.5 * t_end for slip in stream)
    assert kept_by(lambda: next(slip for slip in stream if slip.start > 0.95 * t_end)) < 0.1 * whole


def test_why_the_slips_end():
    stream = ss.slips(CHAIN, *CHAIN.sample_state(1), max_events=40)
    assert stream.state.t == 0.0
    assert len(list(stream)) > 2
    assert stream.status == ss.status.EVENT_LIMIT
    with pytest.raises(ValueError, match="give an end"):
        ss.slips(CHAIN, *CHAIN.sample_state(1))
    with pytest.raises(ValueError, match="t_end = -1"):
        ss.slips(CHAIN, *CHAIN.sample_state(1), t_end=-1)
