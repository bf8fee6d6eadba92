"""Curves of orbits that cross, transcritical or as a pitchfork, against closed forms."""

from functools import partial

import numpy as np
import pytest
from tests.analysis import known_maps as examples
from tests.sizes import slow

import stickslip as ss
from stickslip.analysis.bifurcations import bifurcations as lists
from stickslip.analysis.bifurcations.conditions.conditions import Crossing
from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.branches.along.tracked import ConditionLost

# Fewer than by default: what lies between lists is found all the same.
bifurcations = partial(lists.bifurcations, n_lists=6)

SHARP = 1e-13  # of located values


def family(func, **parameters):
    return ss.PiecewiseMap(func, (-1.5, 1.6), parameters=parameters)


def counts(b):
    return len(b.orbits_before), len(b.orbits_after)


@pytest.mark.parametrize(("lo", "before"), [(0.0, 1), (-1.0, 2)])
def test_the_fixed_points_of_the_logistic_map_change_places(lo, before):
    # On [0, 1] the second one comes in from outside, where the crossing is.
    f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (lo, 1.0), parameters={"r": 0.9})
    found = bifurcations(f, "r", (0.7, 1.5), max_period=2)
    (crossing,) = found
    assert (crossing.kind, crossing.period) == ("transcritical", 1)
    assert crossing.value == pytest.approx(1.0, abs=SHARP)
    assert crossing.error < SHARP
    assert counts(crossing) == (before, 2)
    assert not found.unresolved


@pytest.mark.parametrize(
    ("c", "s", "t"), [*slow((0.7, 0.5, -0.6)), (-1.2, -0.3, 0.4), (0.9, 1.1, 0.2)]
)
def test_two_orbits_that_both_move_cross(c, s, t):
    # x + c (x - a)(x - b): fixed points a = s q and b = t (q - 1/4), multipliers 1 ± c (a - b).
    f = family(lambda x, q: x + c * (x - s * q) * (x - t * (q - 0.25)), q=0.1)
    at = -0.25 * t / (s - t)
    found = bifurcations(f, "q", (at - 0.3, at + 0.37), max_period=1)
    (crossing,) = found.of_kind("transcritical")
    assert crossing.value == pytest.approx(at, abs=SHARP)
    assert crossing.points == pytest.approx([s * at], abs=1e-12)
    rate = float(crossing.note.split("±")[1].split("(")[0])
    assert rate == pytest.approx(abs(c * (s - t)), rel=1e-4)  # five digits are given
    through = [branch for branch in found.curves if branch.bifurcations]
    assert len(through) == 2
    for branch in through:
        assert [item.kind for item in branch.bifurcations] == ["transcritical"]
        # Each of the two goes on as itself, a straight line here.
        slopes = np.diff(branch.points[:, 0]) / np.diff(branch.values)
        assert slopes == pytest.approx(np.full(len(slopes), slopes[0]), abs=1e-4)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_pitchfork_is_super_or_subcritical(sign):
    f = family(lambda x, r: 0.2 + r * (x - 0.2) - sign * (x - 0.2) ** 3, r=0.9)
    found = bifurcations(f, "r", (0.6, 1.37), max_period=1)
    (fork,) = found
    assert fork.kind == "pitchfork"
    assert fork.criticality == ("super" if sign > 0 else "sub")
    assert fork.value == pytest.approx(1.0, abs=SHARP)
    assert fork.points == pytest.approx([0.2], abs=1e-12)
    assert counts(fork) == ((1, 3) if sign > 0 else (3, 1))
    assert f"{-sign:.0f} u^3" in fork.note.replace("+ -", "-").replace("- 1", "-1")
    assert not found.unresolved
    trunk, arms = sorted(found.curves, key=lambda branch: np.ptp(branch.points))
    assert trunk.end_reasons == arms.end_reasons == ("end of range", "end of range")
    # Squared: at the fork a value that is off by rounding moves the root by 1e-8.
    assert (arms.points[:, 0] - 0.2) ** 2 == pytest.approx(np.abs(arms.values - 1), abs=1e-12)


def test_a_range_ends_on_a_pitchfork_at_zero_whose_value_is_rounding():
    f = family(lambda x, r: (1 + r) * x + r * r - x**3, r=0.0)
    found = bifurcations(f, "r", (-0.1, 0.0), max_period=1)
    (fork,) = found
    assert (fork.kind, fork.value) == ("pitchfork", pytest.approx(0.0, abs=SHARP))
    assert not found.unresolved


def test_the_sign_of_a_cubic_that_vanishes_is_not_told():
    f = family(lambda x, r: r * x - x**5, r=0.9)
    (fork,) = bifurcations(f, "r", (0.8, 1.05), max_period=1)
    assert (fork.kind, fork.criticality) == ("pitchfork", None)
    assert counts(fork) == (1, 3)


def test_a_cycle_of_a_symmetric_map_loses_its_symmetry():
    # -r x + x^3 has the cycle ±sqrt(r - 1), with multiplier (3 - 2 r)^2, up to r = 2.
    f = family(lambda x, r: -r * x + x**3, r=1.5)
    found = bifurcations(f, "r", (1.5, 2.1), max_period=2)
    left, fork = found
    assert (left.kind, left.value) == ("enters_gap", pytest.approx(1.56, abs=SHARP))  # at 1.6
    assert (fork.kind, fork.period, fork.criticality) == ("pitchfork", 2, "super")
    assert fork.value == pytest.approx(2.0, abs=SHARP)
    assert fork.points == pytest.approx([-1, 1], abs=1e-12)
    assert not found.unresolved


@pytest.mark.parametrize("off", [1e-6, *slow(1e-3)])
def test_what_only_almost_crosses_is_a_fold(off):
    # r x - x^3 + off folds where x^3 = off / 2.
    f = family(lambda x, r: r * x - x**3 + off, r=0.9)
    (fold,) = bifurcations(f, "r", (0.8, 1.23), max_period=1)
    assert fold.kind == "fold"
    assert fold.value == pytest.approx(1 + 3 * (off / 2) ** (2 / 3), abs=1e-11)


def test_a_condition_without_a_crossing_is_lost():
    f = examples.logistic(3.83)
    with pytest.raises(ConditionLost, match="nowhere stationary"):
        Crossing(1, (0.3,), "r").at(f)


def test_crossings_of_a_power_of_the_map_are_solved_too():
    # At r = 1 + sqrt(8) the logistic map folds: the rate of f^3 does not vanish there.
    f = examples.logistic(1 + np.sqrt(8))
    fold = 0.514355277
    with pytest.raises(ConditionLost):
        solve_near(Crossing(3, (fold,), "r"), lambda r: f.replace(r=r), 3.828, step=1e-4)


def test_a_crossing_is_not_followed_in_two_parameters():
    f = family(lambda x, r, s: r * x - s * x**3, r=0.9, s=1.0)
    (fork,) = bifurcations(f, "r", (0.8, 1.23), max_period=1)
    with pytest.raises(ValueError, match="a point in the plane of two parameters"):
        ss.follow(fork, "s", (0.5, 1.5), solve_for="r")


def test_a_neutral_fixed_point_at_the_end_of_the_domain_is_no_error():
    # At 1 - 2e-8 the logistic map creeps towards 0 through intervals without width.
    attractors = ss.attractors(examples.logistic(1 - 2e-8))
    assert [a.kind for a in attractors] != ["chaotic"]
