"""Several points of an orbit that meet breaks at one value: odd maps, and two blocks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.sizes import tries

import stickslip as ss
from stickslip.analysis.bifurcations.conditions.conditions import Collision, Meeting
from stickslip.analysis.bifurcations.conditions.locate import solve_together, turned
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.maps.piecewise_map import PiecewiseMap

SHARP = 1e-13
GRAZES = (
    "block 1 grazes its stick interval near X_1 = 0.334, inside",
    "block 2 grazes its stick interval near X_2 = 0.296, inside",
)


def odd_map(slope, beyond, jump, twist=0.0):
    """An odd map of slope -``slope`` between its breaks at -1 and 1, -``beyond`` outside.

    Its symmetric orbit (x, -x), x = p / (1 - slope), meets both at p = 1 - slope. ``twist`` moves
    the right break and takes the symmetry away.
    """

    def half(x, p, end):
        outer = -(p + slope * end + beyond * (x - end)) + jump
        return np.where(x < end, -(p + slope * x), outer)

    def func(x, p):
        return np.where(x < 0, -half(-x, p, 1.0), half(x, p, 1.0 + twist))

    def derivative(x, p):
        return np.where((x > -1) & (x < 1 + twist), -slope, -beyond)

    breaks = [-1.0, 0.0, 1.0 + twist]
    settings = {"parameters": {"p": 0.4}, "derivative": derivative, "breakpoints": breaks}
    return PiecewiseMap(func, (-4, 4), **settings)


def beside(p, width=0.03):
    return p - width, p + 0.9 * width


@tries(2, 12)
@given(slope=st.floats(0.1, 0.8), beyond=st.floats(-0.9, 0.9), jump=st.floats(0.2, 0.7))
def test_a_symmetric_orbit_meets_both_jumps_at_once(slope, beyond, jump):
    f = odd_map(slope, beyond, jump)
    found = ss.bifurcations(f, "p", beside(1 - slope), max_period=2, n_lists=3)
    assert not found.unresolved
    (item,) = [b for b in found if b.points == pytest.approx([-1, 1])]
    assert item.value == pytest.approx(1 - slope, abs=SHARP)
    assert abs(item.value - (1 - slope)) <= item.error < SHARP
    assert len(item.condition.others) == 1
    side = item.condition.side
    assert item.multipliers[side > 0] == pytest.approx(slope**2)
    assert (len(item.orbits_before), len(item.orbits_after)) == (1, 0)
    assert item.outcome.orbits == item.predicted_outcome.orbits == "lost at a jump"


def test_both_corners_at_once_give_twins():
    """On the quotient by the symmetry the corner doubles an orbit: here, two mirror images."""
    found = ss.bifurcations(odd_map(0.5, -1.8, 0.0), "p", beside(0.5), max_period=2, n_lists=6)
    (item,) = found
    assert not found.unresolved
    assert item.value == pytest.approx(0.5, abs=SHARP)
    assert item.multipliers == pytest.approx((1.8**2, 0.25))
    assert [o.stable for o in item.orbits_after] == [True, False, True]
    one, symmetric, other = sorted(item.orbits_after, key=lambda o: o.points[0])
    assert symmetric.points == pytest.approx(-symmetric.points[::-1])
    assert one.points == pytest.approx(-other.points[::-1])


def test_without_the_symmetry_one_break_comes_first():
    twist = 1e-6
    found = ss.bifurcations(
        odd_map(0.5, 0.3, 1.2, twist), "p", beside(0.5), max_period=2, n_lists=6
    )
    (item,) = [b for b in found if b.points == pytest.approx([-1, 1], abs=1e-5)]
    assert item.value == pytest.approx(0.5, abs=SHARP)
    assert item.condition.others == ()


def test_each_border_gives_the_same_value():
    f = odd_map(0.5, 0.3, 1.2)
    left, right = (
        TrackedDiscontinuity.of(b) for b in ss.breakpoints(f) if abs(abs(b.d) - 1) < 1e-9
    )
    both = Collision(2, left, 1, (Meeting(1, right, -1),))
    there = turned(both, 0)
    assert there == Collision(2, right, -1, (Meeting(1, left, 1),))
    assert turned(there, 0) == both
    for one in (both, there):
        found = solve_together(one, lambda p: f.replace(p=p), 0.45, step=0.05, within=(0.2, 0.8))
        assert found.value == pytest.approx(0.5, abs=SHARP)
        assert len(found.reading.condition.others) == 1


def test_a_break_that_is_missed_is_dropped():
    f = odd_map(0.5, 0.3, 1.2, twist=1e-9)
    near = [b for b in ss.breakpoints(f) if abs(abs(b.d) - 1) < 1e-6]
    left, right = map(TrackedDiscontinuity.of, near)
    guess = Collision(2, left, 1, (Meeting(1, right, -1),))
    found = solve_together(guess, lambda p: f.replace(p=p), 0.45, step=0.05, within=(0.2, 0.8))
    assert found.value == pytest.approx(0.5, abs=SHARP)
    assert found.reading.condition.others == ()


def test_no_collision_is_no_answer():
    f = odd_map(0.5, 0.3, 1.2)
    left, right = (
        TrackedDiscontinuity.of(b) for b in ss.breakpoints(f) if abs(abs(b.d) - 1) < 1e-9
    )
    both = Collision(2, left, 1, (Meeting(1, right, -1),))
    with pytest.raises(ConditionLost):
        solve_together(both, lambda p: f.replace(p=p), 0.3, step=0.01, within=(0.2, 0.4))


def test_the_mirror_cycle_of_two_blocks_grazes_twice():
    """beta is not 1. The value is that of a computation with 40 digits (reversing_symmetry.md)."""
    m = ss.TwoBlock(alpha=2, beta=1.1, V=0.05, friction=ss.Coulomb(mu=0.3))
    found = ss.bifurcations(m, "alpha", (2.246, 2.2475), max_period=2, n_lists=3)
    assert not found.unresolved
    (item,) = found.of_kind("border_collision")
    assert item.value == pytest.approx(2.2467727308364087589, abs=2e-14)
    assert abs(item.value - 2.2467727308364087589) <= item.error
    assert all(graze in item.mechanism for graze in GRAZES)
    assert item.block is None
    assert [o.stable for o in item.orbits_before] == [True]
    assert item.orbits_after == ()
    assert item.condition.others[0].place == 1
