"""Cycles proposed by recurrences: what is left out together must be none for each alone."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.known_maps import logistic

from stickslip.analysis.attractors.lyapunov import advance
from stickslip.analysis.attractors.recurrence import NEUTRAL, confirmed, promising

MOVED = 0.02


@settings(max_examples=40)
@given(r=st.floats(2.95, 4.0), start=st.floats(0.1, 0.9), steps=st.integers(150, 600))
def test_cycles_that_do_not_repel_are_never_left_out(r, start, steps):
    f = logistic(r)
    tail = advance(f, np.array([start]), steps)[0]
    starts = [tail[-period:] for period in range(1, 65)]
    chosen = promising(f, starts, MOVED)
    for k, points in enumerate(starts):
        cycle = confirmed(f, points, MOVED)
        if cycle is not None and abs(cycle.multiplier) < 1 - NEUTRAL:
            assert k in chosen


def test_repelling_cycles_and_wandering_starts_are_left_out():
    f = logistic(3.9)  # chaotic: nothing is stable
    tail = advance(f, np.array([0.3]), 2000)[0]
    starts = [tail[-period:] for period in range(1, 101)]
    assert len(promising(f, starts, MOVED)) <= 5


def test_few_starts_are_not_looked_at():
    assert promising(logistic(3.9), [np.array([0.5])], MOVED) == [0]
    assert promising(logistic(3.9), [], MOVED) == []
