"""Nothing is left out, invented or listed twice: families whose lists are known otherwise."""

import itertools
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.optimize import brentq
from tests.sizes import slow, tries

import stickslip as ss
from stickslip.analysis.bifurcations import bifurcations as lists
from stickslip.analysis.bifurcations.accounting import Look, accounted, unlike
from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange, joined_where_they_touch
from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.bifurcations.scan.nodes import returns_to_crowd
from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd
from stickslip.analysis.branches.table import branch_table, resolution_of_lists

# Fewer than by default: what lies between lists is found all the same.
bifurcations = partial(lists.bifurcations, n_lists=6)

SHARP = 1e-12  # of located values
PERIODS = 5


def assert_same(found, expected, sharp=SHARP):
    """Compare values with periods: each once, and nothing else."""
    listed = sorted((item.value, item.period) for item in found)
    assert [period for _, period in listed] == [period for _, period in expected]
    assert [value for value, _ in listed] == pytest.approx(
        [value for value, _ in expected], abs=sharp
    )


# --- maps with a gap: borders of words are affine in the parameter ------------------------------


def words(n):
    """Primitive words of L and R, one of each class of rotations."""
    for letters in itertools.product("LR", repeat=n):
        word = "".join(letters)
        turns = [word[k:] + word[:k] for k in range(n)]
        if word == min(turns) and len(set(turns)) == n:
            yield word


def borders_of_gap_map(a, b, lo, hi):
    """Values at which a cycle of x -> a x + mu (left), b x + mu - 1 (right) meets 0."""
    found = []
    for n in range(1, PERIODS + 1):
        for word in words(n):
            low, high = -np.inf, np.inf
            for k in range(n):
                slope, rise, shift = 1.0, 0.0, 0.0
                for letter in word[k:] + word[:k]:
                    s, t = (a, 0.0) if letter == "L" else (b, -1.0)
                    slope, rise, shift = s * slope, s * rise + 1.0, s * shift + t
                # The point is (rise mu + shift) / (1 - slope), with 0 < slope < 1 and rise > 0.
                if word[k] == "R":
                    low = max(low, -shift / rise)
                else:
                    high = min(high, -shift / rise)
            if low < high:
                found += [(value, n) for value in (low, high) if lo < value < hi]
    return sorted(found)


def gap_map(a, b):
    return ss.PiecewiseMap(
        lambda x, mu: np.where(x < 0, a * x + mu, b * x + mu - 1),
        (-3, 3),
        parameters={"mu": 0.3},
        derivative=lambda x, mu: np.where(x < 0, a, b),
        breakpoints=[0.0],
    )


def assert_gap_map_complete(a, b):
    found = bifurcations(gap_map(a, b), "mu", (0.01, 0.99), max_period=PERIODS)
    assert_same(found, borders_of_gap_map(a, b, 0.01, 0.99))
    assert not found.unresolved


def test_narrow_windows_of_a_map_with_a_gap():
    assert_gap_map_complete(0.4, 0.5)  # two borders of period 5 lie between two lists


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(300))
def test_windows_of_random_maps_with_a_gap(seed):
    assert_gap_map_complete(*np.random.default_rng(seed).uniform(0.2, 0.8, 2))


# --- skew tents: every orbit is born on the corner ----------------------------------------------


def corner_orbits(c, lo, hi):
    """Heights at which the corner c of a skew tent on (0, 1) is periodic, by brute force."""

    def off(height, n):
        x = np.full_like(height, c) if isinstance(height, np.ndarray) else c
        for _ in range(n):
            x = height * np.minimum(x / c, (1 - x) / (1 - c))
        return x - c

    grid = np.linspace(lo, hi, 200_001)
    found = []
    for n in range(1, PERIODS + 1):
        values = off(grid, n)
        for k in np.flatnonzero(values[:-1] * values[1:] < 0):
            zero = brentq(off, grid[k], grid[k + 1], args=(n,), xtol=1e-15, rtol=1e-15)
            shorter = (d for d in range(1, n) if n % d == 0)
            if not any(abs(off(zero, d)) < 1e-9 for d in shorter):
                found.append((zero, n))
    return sorted(found)


def skew_tent(c):
    return ss.PiecewiseMap(
        lambda x, height: height * np.minimum(x / c, (1 - x) / (1 - c)),
        (0, 1),
        parameters={"height": 0.9},
        derivative=lambda x, height: np.where(x < c, height / c, -height / (1 - c)),
        breakpoints=[c],
    )


def assert_skew_tent_complete(c, lo=None, hi=0.99):
    lo = c + 0.05 * (1 - c) if lo is None else lo
    found = bifurcations(skew_tent(c), "height", (lo, hi), max_period=PERIODS)
    borders = [b for b in found if b.kind == "border_collision"]
    assert_same(borders, corner_orbits(c, lo, hi))
    assert not found.unresolved


def test_orbits_of_a_skew_tent():
    assert_skew_tent_complete(0.37, 0.7)  # five orbits of period 5 and less


@pytest.mark.slow
@pytest.mark.parametrize(
    "c", [0.37, *(np.random.default_rng(k).uniform(0.2, 0.8) for k in range(40))]
)
def test_orbits_of_random_skew_tents(c):
    assert_skew_tent_complete(c)


# --- crises at the end of the domain, and at a jump ---------------------------------------------

LOGISTIC = ss.PiecewiseMap(
    lambda x, r: r * x * (1 - x),
    (0, 1),
    parameters={"r": 3.9},
    derivative=lambda x, r: r * (1 - 2 * x),
)
TENT = ss.PiecewiseMap(
    lambda x, s: s * np.minimum(x, 1 - x),
    (0, 1),
    parameters={"s": 1.9},
    derivative=lambda x, s: np.where(x < 0.5, s, -s),
    breakpoints=[0.5],
)
SINE = ss.PiecewiseMap(lambda x, r: r * np.sin(np.pi * x), (0, 1), parameters={"r": 0.9})
SQUARE = ss.PiecewiseMap(lambda x, c: x * x + c, (-2, 2), parameters={"c": -1.9})


@pytest.mark.parametrize(
    ("f", "name", "ends", "value"),
    [
        (LOGISTIC, "r", (3.98, 4.02), 4.0),
        (TENT, "s", (1.8, 2.1), 2.0),
        (SINE, "r", (0.98, 1.02), 1.0),
        (SQUARE, "c", (-2.02, -1.98), -2.0),
    ],
)
def test_chaos_that_fills_the_domain_ends_where_orbits_leave(f, name, ends, value):
    found = bifurcations(f, name, ends, max_period=1)
    (crisis,) = found.of_kind("boundary_crisis")
    assert crisis.value == pytest.approx(value, abs=SHARP)
    chaos, nothing = crisis.attractors_before, crisis.attractors_after
    if name == "c":
        chaos, nothing = nothing, chaos
    assert [a.kind for a in chaos] == ["chaotic"]
    assert nothing == ()


def test_a_band_of_a_two_block_system_that_meets_a_jump():
    model = ss.TwoBlock(alpha=3.007, beta=0.6146, V=0.0199, friction=ss.Coulomb(mu=0.542))
    found = bifurcations(model, "beta", (0.6143, 0.6152), max_period=2)
    (crisis,) = found
    assert crisis.kind == "boundary_crisis"
    assert 0.61485045929 < crisis.value < 0.61485045967
    assert crisis.points == pytest.approx([-0.0003897784], abs=1e-10)
    assert sorted(a.kind for a in crisis.attractors_before) == ["chaotic", "periodic"]
    assert [a.kind for a in crisis.attractors_after] == ["periodic"]
    assert "meets the break" in crisis.mechanism
    assert not found.unresolved


def test_where_breaks_accumulate_less_is_resolved_and_the_list_says_so():
    # Each branch is 0.95 times as wide as the one right of it; orbits never come near 0.
    def turns(x):
        return np.log(x) / np.log(0.95)

    f = ss.PiecewiseMap(
        lambda x, mu: mu + 0.05 * (turns(x) % 1),
        (1e-8, 1),
        parameters={"mu": 0.3},
        derivative=lambda x, mu: 0.05 / (np.log(0.95) * x),
        label=lambda x, mu: 1 + np.floor(turns(x)).astype(np.uint64),
    )
    assert len(ss.breakpoints(f, 1e-9)) > 300
    assert len(ss.breakpoints(f)) < 200
    found = bifurcations(f, "mu", (0.3, 0.31), max_period=1, n_lists=3)
    assert not found.unresolved
    (told,) = (told for told in found.outside if "breaks accumulate" in told.reason)
    assert "where no orbit up to period 1 passes, lists are complete above" in told.reason
    assert (told.lo, told.hi) == found.range
    # What happens, happens between 0.2 and 0.5, where there are few breaks.
    alone = bifurcations(f, "mu", (0.3, 0.31), max_period=1, window=(0.2, 0.5), n_lists=3)
    assert len(alone) > 0
    assert not alone.unresolved
    assert_same(found, [(item.value, item.period) for item in alone])


def test_breaks_that_accumulate_between_the_first_looks_are_told_too():
    # As above, but only near a value that is neither an end of the range nor its middle.
    def turns(x, mu):
        return np.log(x) / np.log(0.9 if 0.302 < mu < 0.304 else 0.1)

    f = ss.PiecewiseMap(
        lambda x, mu: mu + 0.05 * (turns(x, mu) % 1),
        (1e-8, 1),
        parameters={"mu": 0.3},
        label=lambda x, mu: 1 + np.floor(turns(x, mu)).astype(np.uint64),
    )
    found = bifurcations(f, "mu", (0.3, 0.31), max_period=1, n_lists=4)
    assert any("breaks accumulate where no orbit" in told.reason for told in found.outside)


def test_orbits_return_to_where_breaks_accumulate_or_not():
    # Branches near 0 are mapped to 0.3 and above, and that back to them.
    def turns(x):
        return np.log(x) / np.log(0.95)

    f = ss.PiecewiseMap(
        lambda x: np.where(x < 0.29, 0.3 + 0.05 * (turns(x) % 1), 0.1 * (x - 0.3) + 1e-4),
        (1e-8, 1),
        derivative=lambda x: np.where(x < 0.29, 0.05 / (np.log(0.95) * x), 0.1),
        label=lambda x: np.where(x < 0.29, 1 + np.floor(turns(x)), 0).astype(np.uint64),
    )
    table = branch_table(f)
    assert table.resolution > 1e-9
    assert [returns_to_crowd(table, period) for period in (1, 2, 3)] == [False, True, True]


def test_where_breaks_accumulate_too_many_changes_are_told_and_not_followed():
    # As above, with values over all branches from mu on: those below lose their fixed points.
    def turns(x):
        return np.log(x) / np.log(0.95)

    f = ss.PiecewiseMap(
        lambda x, mu: mu + 0.3 * (turns(x) % 1),
        (1e-8, 1),
        parameters={"mu": 0.01},
        derivative=lambda x, mu: 0.3 / (np.log(0.95) * x),
        label=lambda x, mu: 1 + np.floor(turns(x)).astype(np.uint64),
    )
    found = bifurcations(f, "mu", (0.01, 0.03), max_period=1, n_lists=3)
    told = [item for item in found.unresolved if "more than are followed" in item.reason]
    ends = sorted({end for item in told for end in (item.lo, item.hi)})
    assert (ends[0], ends[-1], len(ends)) == (*found.range, len(told) + 1)
    # Of a range in which less happens all is found, beside the same breaks.
    few = bifurcations(f, "mu", (0.01, 0.0102), max_period=1, n_lists=3)
    (told,) = few.unresolved
    assert "breaks accumulate: lists are complete above" in told.reason


def test_a_table_of_many_full_branches_is_resolved_by_how_many_orbits_they_make():
    """Each branch of 1/x mod 1 meets all others: where n are told apart there are n^p orbits."""
    f = ss.PiecewiseMap(
        lambda x: (1 / x) % 1,
        (1e-3, 1),
        derivative=lambda x: -1 / x**2,
        label=lambda x: 1 + np.floor(1 / x).astype(np.uint64),
    )
    table = branch_table(f)
    assert len(table) > 48
    assert resolution_of_lists(table, 1) == table.resolution
    assert resolution_of_lists(table, 2) == pytest.approx(1e-3 * 0.999)
    # More ways than there are numbers, without a warning.
    assert resolution_of_lists(table, 100_000) == pytest.approx(1e-3 * 0.999)
    # Where all branches are wide none is left out, however many orbits there are.
    tent = ss.PiecewiseMap(lambda x: 1 - np.abs(2 * x - 1), (0, 1), breakpoints=[0.5])
    assert resolution_of_lists(branch_table(tent), 16) == branch_table(tent).resolution


# --- ends of orbits, and what was not asked for -------------------------------------------------


def test_an_orbit_that_leaves_the_domain_ends_in_a_solved_condition():
    # x/2 + mu has the fixed point 2 mu, stable, in (-1, 1) while mu < 1/2.
    found = bifurcations(SHIFT, "mu", (0.3, 0.8), max_period=2)
    (left,) = found
    assert (left.kind, left.period) == ("enters_gap", 1)
    assert left.value == pytest.approx(0.5, abs=SHARP)
    assert [a.period for a in left.attractors_before] == [1]
    assert left.attractors_after == ()
    assert found.curves[0].ends[1].reason == "end of domain"
    assert not found.unresolved
    assert not found.outside


def test_orbits_pass_a_harmless_break_whose_labels_meet_at_a_jump_too():
    # x/2 + mu, less 1 right of 1/2; labels change at -1/2, too, where the fixed point 2 mu passes.
    f = ss.PiecewiseMap(
        lambda x, mu: np.where(x < 0.5, 0.5 * x + mu, 0.5 * x + mu - 1),
        (-2, 2),
        parameters={"mu": 0.0},
        label=lambda x, mu: np.where(np.abs(x) < 0.5, 1, 2),
    )
    found = bifurcations(f, "mu", (-0.4, 0.35), max_period=1, n_lists=4)
    assert_same(found, [(0.25, 1)])
    assert not found.unresolved


def test_a_look_close_beside_a_flip_sees_the_slow_cycle():
    # At r = 2.999993 the multiplier is -0.999993: too slow to be followed to its end.
    found = bifurcations(LOGISTIC, "r", (3 - 1e-3, 3 + 1.3e-3), max_period=2)
    assert_same(found, [(3.0, 1)])
    assert not found.unresolved
    assert not found.outside


def test_a_search_as_narrow_as_its_step_ends_in_no_event():
    # The fixed point 2 mu of x/2 + mu meets the upper end of the domain at mu = 1/2 only.
    meets_end = Collision(1, DomainEnd(upper=True, x=1.0), -1)
    with pytest.raises(ConditionLost):
        solve_near(meets_end, lambda mu: SHIFT.replace(mu=mu), 0.0, step=3.0, within=(0.0, 0.4))


class Ending(ss.PiecewiseMap):
    """The logistic map between two values of r: there is none elsewhere."""

    def __init__(self, lo, hi):
        super().__init__(
            lambda x, r: r * x * (1 - x),
            (0, 1),
            parameters={"r": 3.2},
            derivative=lambda x, r: r * (1 - 2 * x),
        )
        self.ends = lo, hi

    def replace(self, **changes):
        if not self.ends[0] <= changes["r"] <= self.ends[1]:
            raise ValueError("r is out of range")
        return super().replace(**changes)


def test_a_family_may_end_where_the_range_does():
    found = bifurcations(Ending(3.0, 3.3), "r", (3.0, 3.3), max_period=2)
    assert_same(found, [(3.0, 1)], sharp=1e-9)
    assert not found.unresolved  # nor is a fault told of


def test_a_cascade_is_followed_up_to_where_the_family_ends():
    found = bifurcations(Ending(2.9, 3.5), "r", (2.9, 3.5), max_period=2)
    assert not found.unresolved
    (cascade,) = found.cascades
    assert cascade.values == pytest.approx([3, 1 + np.sqrt(6)], abs=1e-9)


class Moving(ss.PiecewiseMap):
    """The logistic map at 3.1 < r < 3.4 in a domain that moves with s = r."""

    def replace(self, **changes):
        other = super().replace(**changes)
        s = other.parameters["s"]
        other._domain = (s, s + 1)
        return other


def test_a_window_need_not_meet_the_domain_at_the_parameter_that_the_map_was_made_with():
    f = Moving(
        lambda x, s: s + s * (x - s) * (1 + s - x),
        (10.0, 11.0),
        parameters={"s": 10.0},
        derivative=lambda x, s: s * (1 + 2 * s - 2 * x),
    )
    found = bifurcations(f, "s", (2.9, 3.2), max_period=2, window=(3.25, 4.15))
    assert not found.unresolved
    assert_same(found, [(3.0, 1)], sharp=1e-9)
    assert {curve.period for curve in found.curves} == {1, 2}


def test_a_stable_orbit_that_leaves_a_window_is_accounted_for_by_its_end():
    # The fixed point 1 - 1/r passes 0.64 at r = 2.7778.
    found = bifurcations(LOGISTIC, "r", (2.6, 2.9), max_period=1, window=(0.5, 0.64))
    assert len(found) == 0
    assert [curve.ends[1].reason for curve in found.curves] == ["end of domain"]
    assert not found.unresolved


DOUBLES = 1 + np.sqrt(6)  # where the cycle of period 2 of the logistic map does


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        ((3.0, 3.3), [(3.0, 1)]),
        ((2.9, 3.0), [(3.0, 1)]),
        ((2.9, DOUBLES), [(3.0, 1), (DOUBLES, 2)]),
    ],
)
def test_a_range_may_begin_or_end_on_a_bifurcation(ends, expected):
    found = bifurcations(LOGISTIC, "r", ends, max_period=2)
    assert_same(found, expected)
    assert not found.unresolved
    assert all(ends[0] <= q <= ends[1] for q in found.looks)
    assert all(item.hi <= ends[1] for item in found.outside)


APPEARS = 1 + np.sqrt(8)  # ... and where its cycle of period 3 appears
(CORNER_PERIODIC, _), *_ = (found for found in corner_orbits(0.37, 0.8, 0.99) if found[1] == 3)
SHIFT = ss.PiecewiseMap(lambda x, mu: 0.5 * x + mu, (-1, 1), parameters={"mu": 0.0})


@pytest.mark.parametrize(
    ("f", "name", "ends", "kind"),
    [
        (LOGISTIC, "r", (3.8, APPEARS), "fold"),
        *slow((LOGISTIC, "r", (APPEARS, 3.84), "fold")),
        (LOGISTIC, "r", (0.5, 1.0), "transcritical"),
        *slow((LOGISTIC, "r", (1.0, 1.5), "transcritical")),
        *slow((skew_tent(0.37), "height", (0.86, CORNER_PERIODIC), "border_collision")),
        (skew_tent(0.37), "height", (CORNER_PERIODIC, 0.92), "border_collision"),
        (SHIFT, "mu", (0.3, 0.5), "enters_gap"),
    ],
)
def test_orbits_that_appear_exactly_at_an_end_of_the_range(f, name, ends, kind):
    (item,) = bifurcations(f, name, ends, max_period=3)
    assert item.kind == kind
    assert min(abs(item.value - end) for end in ends) < SHARP


@tries(6, 60)
@given(logarithm=st.floats(-3.7, -2.0), side=st.sampled_from([-1, 1]), half=st.floats(0.02, 0.3))
@example(logarithm=-3.7, side=1, half=0.3)  # seven parts in 10^8 of the range apart
def test_a_fold_and_a_collision_next_to_each_other_are_both_found(logarithm, side, half):
    """One of two orbits, at plus and minus the root of mu, meets a jump just beside the fold."""
    edge = side * 10**logarithm
    f = ss.PiecewiseMap(
        lambda x, mu: mu + x - x**2 - 0.2 * side * (side * (x - edge) > 0),
        (-1, 1),
        parameters={"mu": 0.1},
        derivative=lambda x, mu: 1 - 2 * x,
        breakpoints=[edge],
    )
    found = bifurcations(f, "mu", (-half, half), max_period=1)
    assert not found.unresolved
    near = [item for item in found if abs(item.value) < 2 * edge**2]
    assert [item.kind for item in near] == ["fold", "border_collision"]
    assert_same(near, [(0.0, 1), (edge**2, 1)])


@tries(6, 60)
@given(logarithm=st.floats(-15.0, -3.0), half=st.floats(0.02, 0.2))
@example(logarithm=-10.5, half=0.1)  # lists between would be too close to each other
def test_two_orbits_that_meet_two_jumps_next_to_each_other(logarithm, half):
    """Fixed points at -1/2 + 2 mu and 1/2 + 2 (mu - later) meet the jumps at -1/2 and 1/2."""
    later = 10**logarithm

    def func(x, mu):
        parts = [0.5 * x - 0.25 + mu, 0.1 * x + 0.8, 0.5 * x + 0.25 + mu - later]
        return np.select([x < -0.5, x < 0.0, x < 0.5], parts, 0.1 * x - 0.4)

    f = ss.PiecewiseMap(
        func,
        (-1, 1),
        parameters={"mu": 0.0},
        derivative=lambda x, mu: np.where((x < -0.5) | (x >= 0) & (x < 0.5), 0.5, 0.1),
        breakpoints=[-0.5, 0.0, 0.5],
    )
    found = bifurcations(f, "mu", (-half, 1.1 * half), max_period=1)
    assert not found.unresolved
    near = [item for item in found if -1e-12 < item.value < later + 1e-12]
    assert [item.kind for item in near] == ["border_collision"] * 2
    assert_same(near, [(0.0, 1), (later, 1)])


def test_a_corner_that_vanishes_where_an_orbit_meets_it():
    """The fixed point, 2 mu, passes the corner at 0, whose bend is mu."""
    f = ss.PiecewiseMap(
        lambda x, mu: mu + 0.5 * x + mu * np.maximum(x, 0),
        (-1, 1),
        parameters={"mu": 0.05},
        derivative=lambda x, mu: 0.5 + mu * (x > 0),
        breakpoints=[0.0],
    )
    found = bifurcations(f, "mu", (-0.1, 0.11), max_period=1)
    assert not found.unresolved
    assert all(len(item.orbits_before) == len(item.orbits_after) == 1 for item in found)
    (orbit,) = ss.periodic_orbits(f, 1)
    curve = ss.follow(orbit, "mu", (-0.1, 0.11))
    assert {end.reason for end in curve.ends} == {"end of range"}


@pytest.mark.parametrize("half", [1e-6, 1e-9, 1e-14, *slow(1e-7, 1e-12)])
def test_a_range_as_narrow_as_rounding_about_a_flip_is_not_halved_for_ever(half):
    ends = 3 - half, 3 + 1.3 * half
    found = lists.bifurcations(LOGISTIC, "r", ends, max_period=2)
    assert_same(found, [(3.0, 1)])
    assert found.n_lists < 40
    # Below 1e-8 the cycle of period 2 is not told from the fixed point.
    assert not found.unresolved or half < 1e-8


@pytest.mark.parametrize("half", [1e-14, *slow(1e-6, 1e-7, 1e-9, 1e-12)])
def test_a_range_as_narrow_as_rounding_about_a_fold_is_not_halved_for_ever(half):
    fold = bifurcations(LOGISTIC, "r", (APPEARS - half, APPEARS + 1.3 * half), max_period=3)
    assert_same(fold, [(APPEARS, 3)])


def test_attractors_beyond_the_longest_period_are_told():
    found = bifurcations(LOGISTIC, "r", (3.3, 3.56), max_period=2)
    told = [(item.lo, item.hi) for item in found.outside]
    assert told == [(pytest.approx(1 + np.sqrt(6), abs=SHARP), 3.56)]
    assert "period 4, 8" in found.outside[0].reason
    assert "outside the question" in repr(found)
    assert not found.unresolved
    assert (found.looks[0], found.looks[-1]) == found.range
    apart = np.diff(found.looks)
    assert (apart > 0).all()
    assert f"{apart.max():.3g} apart" in repr(found)


@pytest.mark.parametrize("ends", [(0.2, 0.9), *slow(((0.435, 0.445),))])
def test_attractors_beside_a_collision_do_not_hang_on_the_range(ends):
    # A cycle of period 2 ends 9e-4 below the collision; chaos goes on to a crisis 6e-5 above it.
    f = ss.PiecewiseMap(
        ["a - 0.9*x - 0.2*x**2", "0.7*x - 0.55", "1.9*(1 - x) - 0.3*x**3"],
        (-1.2, 1.3),
        parameters={"a": 0.55},
        breakpoints=[-0.15, 0.6],
    )
    found = ss.bifurcations(f, "a", ends, max_period=4)
    (item,) = (each for each in found if abs(each.value - 0.441795881562) < 1e-9)
    for seen in (item.attractors_before, item.attractors_after):
        assert [(each.kind, each.period) for each in seen] == [("chaotic", 1)]
    below, above = item.looks
    assert 0.440928571428572 < below < item.value < above < 0.441852544076097
    assert f"(at {below:.9g} and {above:.9g})" in repr(item)
    assert not item.disagreement
    (span,) = (each for each in found.outside if each.lo < item.value < each.hi)
    assert "period 5, 8; chaos" in span.reason


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_an_interrupted_list_says_what_it_left_out(share):
    def interrupt(done):
        if done > share:
            shares.append(done)
            if len(shares) == 1:
                raise KeyboardInterrupt

    shares = []
    ask = partial(bifurcations, LOGISTIC, "r", (2.9, 3.5), max_period=2, progress=interrupt)
    with pytest.raises(KeyboardInterrupt):
        ask()
    shares.clear()
    found = ask(partial=True)
    assert [item.kind for item in found] == (["flip"] if share else [])
    told = {item.reason.removeprefix("interrupted: "): item for item in found.unresolved}
    left_out = [f"{what} left out" for what in ("the cascades", "the crises", "attractors")]
    assert set(told) == {"not looked at", *left_out}
    rest = told["not looked at"]
    assert rest.hi == 3.5
    assert (rest.lo > 3) == bool(share)
    values = [curve.values for curve in found.curves]
    assert all(value.max() <= rest.lo for value in values)


def test_a_change_that_nothing_explains_is_told():
    looks = [look(0.0, ("periodic", 1)), look(1.0), look(2.0)]
    unresolved, outside = accounted(looks, [1.5], max_period=2)
    (change,) = unresolved
    assert (change.lo, change.hi) == (0.0, 1.0)
    assert "period 1 before, nothing after" in change.reason
    assert not outside


def test_lost_chaos_is_told_and_cycles_that_are_too_long_are_set_apart():
    looks = [look(0.0, ("chaotic", 1)), look(1.0, ("periodic", 7)), look(2.0), look(3.0)]
    unresolved, outside = accounted(looks, [], max_period=4)
    assert not unresolved
    assert [(item.lo, item.hi) for item in outside] == [(0.0, 2.0)]
    lost = [look(0.0, ("chaotic", 1)), look(1.0)]
    assert len(accounted(lost, [], max_period=4)[0]) == 1
    # The last of a cascade have more bands than are searched for, as windows have.
    many = [look(0.0, ("chaotic", 104)), look(1.0)]
    unresolved, (outside,) = accounted(many, [], max_period=4)
    assert not unresolved
    assert "chaos in 104 bands" in outside.reason


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ([("chaotic", 12)], [], True),  # of the cascade of a cycle of period 3
        ([("chaotic", 26), ("periodic", 26)], [("periodic", 26)], False),  # of a window of it
        ([("chaotic", 1)], [("chaotic", 26)], False),
        ([("chaotic", 1), ("chaotic", 26)], [], True),
        ([("chaotic", 1), ("periodic", 7)], [("periodic", 2)], True),
        ([("undecided", 0)], [("chaotic", 1), ("undecided", 0)], False),  # which may be that
        ([("chaotic", 1)], [("chaotic", 1), ("chaotic", 1), ("undecided", 0)], True),
    ],
)
def test_chaos_counts_unless_longer_cycles_or_what_is_undecided_stand_for_it(before, after, told):
    for looks in ([look(0.0, *before), look(1.0, *after)], [look(0.0, *after), look(1.0, *before)]):
        unresolved, _ = accounted(looks, [], max_period=3)
        assert [item for item in unresolved if "chaos" in item.reason] == unresolved
        assert bool(unresolved) is told


def test_a_look_where_a_cycle_repels_too_slowly_to_be_left_tells_nothing():
    cycle = SimpleNamespace(
        kind="undecided", period=2, orbit=SimpleNamespace(multiplier=-1.00001), lowest_period=2
    )
    looks = [look(0.0, ("chaotic", 1)), Look(1.0, [cycle]), look(2.0, ("periodic", 2))]
    assert accounted(looks, [1.5], max_period=3)[0] == []
    assert len(accounted(looks, [], max_period=3)[0]) == 1
    cycle.orbit.multiplier = -0.99999
    assert len(accounted(looks, [1.5], max_period=3)[0]) == 1


def test_chaos_that_holds_no_cycle_asked_for_is_set_apart_however_few_its_sets_of_bands():
    # Bands that maps cut out of a window of long cycles: ways back take 28 maps, or 30, or more.
    in_pairs = look(0.0, ("chaotic", 2, 28))
    unresolved, (outside,) = accounted([in_pairs, look(1.0)], [], max_period=3)
    assert not unresolved
    assert "chaos in 28 bands" in outside.reason
    assert not unlike([in_pairs, look(1.0, ("chaotic", 1, 29))], [], max_period=3)
    assert accounted([look(0.0, ("chaotic", 1, 12)), look(1.0)], [], max_period=3)[0]


def look(value, *sorts):
    attractors = [
        SimpleNamespace(kind=kind, period=period, orbit=None, lowest_period=sum(lowest))
        for kind, period, *lowest in sorts
    ]
    return Look(value, attractors)


# --- twins --------------------------------------------------------------------------------------


def mirrored(points):
    return tuple(np.sort(-np.asarray(points)))


def test_twins_of_a_symmetric_map_each_have_their_own_entries():
    f = ss.PiecewiseMap(
        lambda x, r: r * x - x**3,
        (-2.2, 2.2),
        parameters={"r": 1.5},
        derivative=lambda x, r: r - 3 * x * x,
    )
    found = bifurcations(f, "r", (1.9, 2.4), max_period=2, n_lists=3)
    assert [len(cascade.flips) for cascade in found.cascades] == [8, 8]
    assert {item.kind for item in found} >= {"flip", "band_merging"}
    for kind in ("flip", "band_merging"):
        items = [(item.value, tuple(np.sort(item.points))) for item in found if item.kind == kind]
        for value, points in items:
            same = [
                (v, p)
                for v, p in items
                if abs(v - value) < SHARP and p == pytest.approx(mirrored(points), abs=1e-8)
            ]
            assert len(same) == 1, (kind, value, points)


@pytest.mark.parametrize(
    ("model", "name", "ends", "values"),
    [
        # A branch that ends at a tie of events goes on as rounding: three floats of its label.
        (
            {
                "alpha": 1.6461618767844564,
                "beta": 1.0736336202179904,
                "V": 0.20418837586320968,
                "mu": 0.410087353956968,
            },
            "alpha",
            (1.6270225835663483, 1.6653011700025644),
            [1.64939258187553, 1.6514475927023, 1.65199184796403],
        ),
        # A branch gets narrower than what is told apart: another break takes its border's place.
        (
            {
                "alpha": 1.9880347952124338,
                "beta": 0.7270834157969708,
                "V": 0.09199498040206107,
                "mu": 0.5869163419474344,
            },
            "alpha",
            (1.9749182001406398, 2.0011513902842277),
            [1.98214041414713, 1.98853597823925],
        ),
        # Both ends of a branch meet, and the same two branches meet once more elsewhere.
        (
            {
                "alpha": 2.3540110414724364,
                "beta": 1.7939074071308116,
                "V": 0.11800245408174169,
                "mu": 0.6118529901613016,
            },
            "beta",
            (1.7825415493458083, 1.805273264915815),
            [],
        ),
    ],
)
def test_a_branch_that_ends_is_no_collision(model, name, ends, values):
    mu = model.pop("mu")
    found = bifurcations(ss.TwoBlock(**model, friction=ss.Coulomb(mu)), name, ends, max_period=3)
    assert [item.value for item in found] == pytest.approx(values, abs=1e-13)
    assert not found.unresolved


def test_changes_left_open_for_one_reason_at_many_breaks_are_one_entry():
    told = [UnresolvedChange("an orbit ends", a, b, 1, 0.5) for a, b in ((2, 3), (0, 1), (1, 2))]
    other = UnresolvedChange("another", 1.5, 1.75, 2, 0.25)
    apart = UnresolvedChange("an orbit ends", 5, 6, 3, 0.75)
    joined = joined_where_they_touch([*told, other, apart])
    assert [(item.reason, item.lo, item.hi) for item in joined] == [
        ("an orbit ends", 0, 3),
        ("an orbit ends", 5, 6),
        ("another", 1.5, 1.75),
    ]
    assert joined[1:] == [apart, other]


@pytest.mark.parametrize("noise", [0.0, 1e-14, 3e-14])
def test_noise_of_a_map_hides_nothing(noise):
    """Values of long motions are off by more than roundings of their size: residuals stay."""
    family = ss.PiecewiseMap(
        lambda x, r: r * x * (1 - x) + noise * np.sin(1e14 * x),
        (0, 1),
        parameters={"r": 3.2},
        derivative=lambda x, r: r * (1 - 2 * x),
    )
    found = bifurcations(family, "r", (2.9, 3.5), max_period=2)
    assert_same(found, [(3.0, 1), (1 + np.sqrt(6), 2)])
    assert not found.unresolved


@pytest.mark.parametrize("apart", [1e-6, 3e-8])
def test_two_orbits_of_large_multipliers_meet_a_jump_close_to_each_other(apart: float) -> None:
    steep = 1e6
    f = ss.PiecewiseMap(
        lambda x, mu: np.where(x < 0, steep * x + mu, steep * x + mu - apart),
        (-1, 1),
        parameters={"mu": 0.1},
        derivative=lambda x, mu: np.full_like(x, steep),
        breakpoints=[0.0],
    )
    found = ss.bifurcations(f, "mu", (-0.9, 1.1), max_period=1)
    assert [item.kind for item in found] == ["border_collision"] * 2
    np.testing.assert_allclose([item.value for item in found], [0.0, apart], rtol=0, atol=1e-15)
    assert found.unresolved == ()


def narrow_branch(half: float) -> ss.PiecewiseMap:
    """A fold at mu = 0, its branch cut off on both sides, and a flip at mu = half^2 / 9e-6."""
    middle, bend = 0.1, 9e-6 / half**2
    return ss.PiecewiseMap(
        lambda x, mu: np.where(
            np.abs(x - middle) < half, x + mu - bend * (x - middle) ** 2, 0.45 - 0.5 * x
        ),
        (-1, 1),
        parameters={"mu": 1e-6},
        derivative=lambda x, mu: np.where(
            np.abs(x - middle) < half, 1.0 - 2.0 * bend * (x - middle), -0.5
        ),
        breakpoints=[middle - half, middle + half],
    )


def test_a_fold_on_a_branch_narrower_than_a_difference_of_slopes() -> None:
    found = bifurcations(narrow_branch(3e-8), "mu", (-5e-6, 3e-6), max_period=1)
    assert [item.kind for item in found] == ["fold", "flip"]
    np.testing.assert_allclose([item.value for item in found], [0.0, 1e-10], rtol=0, atol=1e-15)
    assert found.unresolved == ()


def test_a_flip_on_a_branch_narrower_than_a_difference_of_slopes() -> None:
    found = bifurcations(narrow_branch(1e-8), "mu", (-5e-6, 3e-6), max_period=1)
    assert [item.kind for item in found] == ["fold", "flip"]
    for item, value in zip(found, (0.0, 1e-16 / 9e-6), strict=True):
        assert abs(item.value - value) <= item.error < 1e-14
    assert found.unresolved == ()


def test_a_branch_that_becomes_too_narrow_between_two_jumps_is_no_collision() -> None:
    # The two jumps at its ends and the one that is left have branches of one label on their left.
    model = ss.TwoBlock(
        alpha=3.771239277838237,
        beta=1.5708,
        V=0.00669498711735279,
        friction=ss.PoppStelter(gamma=0.6960060752778576, delta=0.3030360978963351),
    )
    found = ss.bifurcations(model, "beta", (1.54084, 1.54086), max_period=3)
    assert len(found) == len(found.unresolved) == 0


@pytest.mark.parametrize(
    ("bend", "shift", "ends"), [(1e10, 0.0, (-0.7, 1.0)), (1e10, 1.0, (-5e-6, 7e-6))]
)
def test_a_flip_nearer_to_a_fold_than_lists_are_made_is_solved_for(bend, shift, ends) -> None:
    sharp = ss.PiecewiseMap(
        lambda x, mu: x + (mu - shift) - bend * x**2,
        (-2 / bend**0.5, 2 / bend**0.5),
        parameters={"mu": 0.3 + shift},
        derivative=lambda x, mu: 1 - 2 * bend * x,
    )
    found = bifurcations(sharp, "mu", (ends[0] + shift, ends[1] + shift), max_period=1)
    fold, flip = found[:2]
    assert [fold.kind, flip.kind] == ["fold", "flip"]
    for item, value in ((fold, 0.0), (flip, 1 / bend)):
        assert abs(item.value - shift - value) <= item.error + 2 * np.spacing(shift) + 1e-21
    (before,), (after, doubled) = flip.orbits_before, flip.orbits_after
    assert after.multiplier < -1 < before.multiplier < 0
    assert doubled.period == 2
    assert found.unresolved == ()
    (curve,) = (each for each in found.curves if each.period == 1)
    assert [item.kind for item in curve.bifurcations] == ["fold", "flip"]


def test_a_flip_beside_a_fold_is_not_one_of_another_orbit_near_by() -> None:
    bend, other = 1e10, 5e-4

    def beside(x: np.ndarray, steep: object, sharp: object, far: float) -> np.ndarray:
        inside = [np.abs(x - other) < 1e-5, np.abs(x) < 2e-5]
        return np.select(inside, [steep, sharp], far)

    f = ss.PiecewiseMap(
        lambda x, mu: beside(x, other - 50 * (x - other), x + mu - bend * x**2, 0.5),
        (-1, 1),
        parameters={"mu": 0.3},
        derivative=lambda x, mu: beside(x, -50.0, 1 - 2 * bend * x, 0.0),
        breakpoints=[-2e-5, 2e-5, other - 1e-5, other + 1e-5],
    )
    found = bifurcations(f, "mu", (-0.7, 1.0), max_period=1)
    (flip,) = (item for item in found if item.kind == "flip" and item.period == 1)
    before, after = (
        [orbit.multiplier for orbit in side if orbit.period == 1]
        for side in (flip.orbits_before, flip.orbits_after)
    )
    assert len(before) == len(after) == 1
    assert after[0] < -1 < before[0] < 0


def test_what_begins_at_a_flip_that_hides_beside_a_fold_is_told() -> None:
    found = bifurcations(narrow_branch(3e-9), "mu", (-5e-6, 3e-6), max_period=2)
    assert "fold" in [item.kind for item in found]
    assert any(
        item.lo < 1e-12 < item.hi and "do not add up" in item.reason for item in found.unresolved
    )


def test_orbits_on_branches_that_lists_do_not_resolve_are_outside_the_question():
    """A branch grows beyond 1e-9 of the domain, from where on lists have the orbit on it."""

    def width(mu):
        return 1e-9 * (0.5 + mu)

    def func(x, mu):
        narrow = 1.2 * x / width(mu) - 0.6
        return np.where(x < 0, 0.1 * x + 0.3, np.where(x < width(mu), narrow, 0.1 * x - 0.4))

    f = ss.PiecewiseMap(
        func,
        (-1, 1),
        parameters={"mu": 0.3},
        derivative=lambda x, mu: np.where((x < 0) | (x >= width(mu)), 0.1, 1.2 / width(mu)),
        breakpoints=lambda mu: [0.0, width(mu)],
    )
    found = ss.bifurcations(f, "mu", (0.1, 0.9), max_period=1)
    assert len(found) == 0
    assert found.unresolved == ()
    (told,) = (item for item in found.outside if "narrower than 1e-09" in item.reason)
    assert told.period == 1
    assert told.lo < 0.5 < told.hi
