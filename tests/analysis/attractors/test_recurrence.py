"""Cycles proposed by recurrences: what is left out together must be none for each alone."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.analysis.known_maps import logistic
from tests.sizes import tries

from stickslip.analysis.attractors.recurrence import (
    NEUTRAL,
    ROUNDING,
    capture_radius,
    confirmed,
    promising,
)
from stickslip.analysis.attractors.search import AttractorSearch
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import advance
from stickslip.analysis.scales import CLOSE

MOVED = 0.02


@tries(15, 100)
@given(r=st.floats(2.95, 4.0), start=st.floats(0.1, 0.9), steps=st.integers(150, 600))
def test_cycles_that_do_not_repel_are_never_left_out(r, start, steps):
    f = logistic(r)
    tail = advance(f, np.array([start]), steps)[0]
    starts = [tail[-period:] for period in range(1, 65)]
    chosen = promising(f, starts, MOVED)
    for k, points in enumerate(starts):
        # From further away Newton's steps may grow, and one start come to a cycle by chance.
        cycle = confirmed(f, points, 0.25 * MOVED)
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


@pytest.mark.parametrize(("r", "period"), [(2.9, 1), (3.5001, 4), (3.84, 3), (3.7389, 5)])
def test_a_capture_radius_is_the_first_of_the_halved_ones_that_comes_closer(r, period):
    f = logistic().replace(r=r)
    cycle = confirmed(f, advance(f, np.array([0.5]), 3000)[0, -period:])
    assert cycle.stable
    share = 0.5 * (1 + max(abs(cycle.multiplier), 0.5))
    turns, radius = math.ceil(math.log(CLOSE) / math.log(share)), 0.02
    beside = np.array([-1.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6, 1.0])
    while True:
        x = np.clip(cycle.points[0] + radius * beside, 0.0, 1.0)
        off = np.abs(np.stack([x, advance(f, x, turns * period)[:, -1]]) - cycle.points[0])
        if (off[1] <= share**turns * off[0] + ROUNDING).all():
            break
        radius *= 0.5
    assert capture_radius(f, cycle) == radius


def test_a_cycle_that_a_stand_in_has_beyond_the_unit_circle_captures_what_it_does_there():
    def turning(a):
        return PiecewiseMap(lambda x: -a * x, (-1, 1), derivative=lambda x: np.full_like(x, -a))

    f, stand_in = turning(0.9999), turning(1.0001)
    search = AttractorSearch(f, branch_table(f), 8, 100, stand_in)
    known = search.known[search.add_cycle(confirmed(f, np.array([0.0])))]
    assert not known.captures(np.array([[0.5, -0.5]])).any()
