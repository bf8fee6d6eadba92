"""Attractors against maps whose long-term behaviour is known."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.analysis.known_maps import (
    border_collision,
    doubling,
    logistic,
    maximal_orbit,
    square_root,
    tent,
    tent_with_hole,
)
from tests.sizes import calls_in, tries

from stickslip import Coulomb, PoppStelter, TwoBlock, examples
from stickslip.analysis.attractors.attractors import attractors, attractors_of
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.interpolation.interpolated import interpolated_map
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap

SHARES = 0.15  # chaotic transients of two almost equal maps end differently
EDGE = 1e-10  # band edges are images of breakpoints and turning points: far better than 1e-8


def cubic(a):
    return PiecewiseMap(
        lambda x, a: a * x - x**3,
        (-1.6, 1.6),
        parameters={"a": a},
        derivative=lambda x, a: a - 3 * x**2,
    )


def images(f, x, n):
    return f.iterate(x, n)[1:]


# --- cycles -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("r", "period"),
    [(2.9, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.83, 3), (3.845, 6), (3.74, 5), (3.9603, 4)],
)
def test_windows_of_the_logistic_map(r, period):
    (found,) = attractors(logistic(r))
    assert (found.kind, found.period) == ("periodic", period)
    assert found.basin_share == 1
    points = np.sort(found.orbit.points)
    assert np.allclose(np.sort(logistic(r)(points)), points, rtol=0, atol=1e-14)
    assert float(found.lyapunov) == pytest.approx(np.log(abs(found.orbit.multiplier)) / period)


def test_closed_form_of_the_two_cycle():
    r = 3.2
    (found,) = attractors(logistic(r))
    root = np.sqrt((r + 1) * (r - 3))
    assert np.sort(found.orbit.points) == pytest.approx(
        [(r + 1 - root) / (2 * r), (r + 1 + root) / (2 * r)], abs=1e-15
    )
    assert found.orbit.multiplier == pytest.approx(4 + 2 * r - r**2, abs=1e-13)


def test_superstable_orbit():
    (found,) = attractors(logistic(1 + np.sqrt(5)))
    assert (found.kind, found.period) == ("periodic", 2)
    assert abs(found.orbit.multiplier) < 1e-14


def test_cycle_just_inside_a_window_is_found_behind_its_chaotic_transient():
    # The window of period 3 opens at 1 + sqrt(8) = 3.828427...
    (found,) = attractors(logistic(3.82843))
    assert (found.kind, found.period) == ("periodic", 3)


def test_intermittency_just_below_the_window_is_chaos():
    (found,) = attractors(logistic(3.8284))
    assert found.kind == "chaotic"


def test_orbit_that_passes_a_square_root():
    lam, mu = 0.2, 0.1
    points, multiplier = maximal_orbit(lam, mu, 2)
    (found,) = attractors(square_root(lam, mu))
    assert np.sort(found.orbit.points) == pytest.approx(np.sort(points), abs=1e-14)
    assert found.orbit.multiplier == pytest.approx(multiplier, rel=1e-12)


def test_coexisting_fixed_points_beside_a_jump():
    f = border_collision(a=0.5, b=0.5, mu=-0.5, jump=1.0)
    found = attractors(f)
    assert sorted(a.orbit.points[0] for a in found) == pytest.approx([-1, 1])
    assert sum(a.basin_share for a in found) == 1


def test_period_is_minimal_at_a_flip():
    # Just before the flip at r = 3 every other point recurs much closer than every point.
    (found,) = attractors(logistic(2.999))
    assert (found.kind, found.period) == ("periodic", 1)
    (found,) = attractors(logistic(3.001))
    assert (found.kind, found.period) == ("periodic", 2)


# --- neutral ----------------------------------------------------------------------------------


def test_flip_is_undecided():
    (found,) = attractors(logistic(3.0))
    assert found.kind == "undecided"
    assert "unit circle" in found.reason
    assert found.orbit.points == pytest.approx([2 / 3], abs=1e-9)


def test_fold_is_undecided():
    (found,) = attractors(logistic(1 + np.sqrt(8)))
    assert (found.kind, found.period) == ("undecided", 3)
    assert "unit circle" in found.reason


def test_continuum_of_neutral_cycles_is_one_entry():
    f = border_collision(a=0.5, b=-2.0, mu=1.0)  # slopes of a left-right pair multiply to -1
    (found,) = attractors(f)
    assert found.kind == "neutral"


def test_rotation_is_undecided():
    f = PiecewiseMap(
        lambda x: np.where(x < 1 - 0.381966, x + 0.381966, x - 0.618034),
        (0, 1),
        derivative=np.ones_like,
        breakpoints=[1 - 0.381966],
    )
    found = attractors(f)
    assert all(a.kind == "undecided" and a.reason for a in found)


# --- chaos ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("slope", "bands"), [(1.05, 8), (1.1, 4), (1.2, 2), (1.5, 1), (2.0, 1)])
def test_bands_of_the_tent_map(slope, bands):
    # 2^k bands for 2^(1/2^(k+1)) < slope <= 2^(1/2^k), bounded by images of the top.
    f = tent(slope)
    (found,) = attractors(f)
    assert found.kind == "chaotic"
    assert found.period == len(found.bands) == bands
    assert float(found.lyapunov) == pytest.approx(np.log(slope), abs=1e-12)
    expected = np.sort(images(f, 0.5, 2 * bands))
    assert np.sort(found.bands.ravel()) == pytest.approx(expected, abs=EDGE)


def test_bands_merge_at_the_square_root_of_two():
    (found,) = attractors(tent(np.sqrt(2)))
    s = np.sqrt(2)
    assert found.bands == pytest.approx(np.array([[s * (1 - s / 2), s / 2]]), abs=EDGE)


@pytest.mark.parametrize(("r", "bands"), [(3.58, 4), (3.6, 2), (3.678, 2), (3.7, 1), (4.0, 1)])
def test_bands_of_the_logistic_map(r, bands):
    f = logistic(r)
    (found,) = attractors(f)
    assert found.kind == "chaotic"
    assert found.period == len(found.bands) == bands
    expected = np.sort(images(f, 0.5, 2 * bands))
    assert np.sort(found.bands.ravel()) == pytest.approx(expected, abs=EDGE)
    assert all(cause.startswith("image") for cause in found.edges)
    assert found.lyapunov.value > 5 * found.lyapunov.error


def weak(slope, shift):
    """Stretch by little, and cut: the fractional part of slope * x + shift."""
    cut = (1 - shift) / slope
    return PiecewiseMap(
        lambda x: slope * x + shift - (x >= cut),
        (-0.5, 1.5),
        derivative=lambda x: np.full_like(x, slope),
        breakpoints=[cut],
    )


def test_no_orbit_of_chaos_has_a_lower_period_than_is_told():
    # Ways from a band back to itself take 4 or 5 maps, and multiples of these.
    f = EventMap(TwoBlock(alpha=3.128, beta=1.511475, V=0.01434, friction=Coulomb(mu=0.1086)))
    (found,) = attractors(f)
    assert (found.kind, found.period, found.lowest_period) == ("chaotic", 1, 4)
    periods = [o.period for o in periodic_orbits(f, 9) if found.contains(o.points).all()]
    assert min(periods) >= found.lowest_period


@pytest.mark.parametrize(("slope", "period"), [(1.01, 64), (1.02, 32), (1.05, 8), (1.3, 2)])
def test_bands_of_a_symmetric_map_that_stretches_little(slope, period):
    # Its power 2 near the middle is such a map again while the square of its slope is at most 2.
    (found,) = attractors(weak(slope, 1 - slope / 2))
    assert (found.kind, found.period) == ("chaotic", period)
    assert len(found.bands) == 2 * period - 1  # the set about the middle alone is in one piece
    assert found.bands == pytest.approx(1 - found.bands[::-1, ::-1], abs=EDGE)
    assert float(found.lyapunov) == pytest.approx(np.log(slope), abs=1e-9)


@tries(4, 40)
@given(slope=st.floats(1.0004, 1.01) | st.floats(1.01, 1.4), part=st.floats(0.05, 0.95))
@example(slope=1.02, part=0.6725)  # three sets, of four bands
@example(slope=1.0004407168068103, part=0.9037845024235195)  # one band, filled after 5000 maps
def test_maps_that_stretch_little_visit_their_bands_in_turn(slope, part):
    f = weak(slope, part * (2 - slope))  # from [0, 1] to itself
    (found,) = attractors(f)  # a map that expands has no other (Lasota and Yorke)
    assert found.kind == "chaotic"
    orbit = f.iterate(found.point, 40 * found.period - 1)
    turns = np.searchsorted(found.bands[:, 0], orbit + EDGE).reshape(-1, found.period)
    sets = [set(turn) for turn in turns.T]
    assert sum(map(len, sets)) == len(set.union(*sets))


def test_exponent_of_the_full_logistic_map():
    (found,) = attractors(logistic(4.0))
    value, error = found.lyapunov
    assert abs(value - np.log(2)) < 5 * error


def test_coexisting_chaotic_attractors():
    found = attractors(cubic(2.5))
    assert [a.kind for a in found] == ["chaotic", "chaotic"]
    left, right = sorted((a.bands for a in found), key=lambda b: b[0, 0])
    assert left == pytest.approx(-right[::-1, ::-1], abs=EDGE)
    top = 2 * (2.5 / 3) ** 1.5
    assert right[0, 1] == pytest.approx(top, abs=EDGE)


@tries(6, 40)
@given(slope=st.floats(1.05, 1.99))
def test_bands_map_onto_themselves(slope):
    f = tent(slope)
    (found,) = attractors(f, n_starts=4)
    x = np.concatenate([np.linspace(low, high, 50) for low, high in found.bands])
    assert np.all(found.contains(f(x), slack=1e-10))


# --- transients -------------------------------------------------------------------------------


def test_chaotic_transient_that_leaves_is_no_attractor():
    # Past r = 4 orbits escape at the top, here after some ten thousand steps.
    found = attractors(logistic(4 + 1e-8), n_starts=8)
    assert all(a.kind == "undecided" for a in found)
    assert all("reach a gap" in a.reason or "lost" in a.reason for a in found)


def test_orbits_that_creep_over_the_end_of_the_domain_have_left():
    # One block of steps ends with an image that is just outside, and recurs as a fixed point would.
    f = PiecewiseMap(["0.96*(x + 3.00005) - 3.00005"], (-3, 3))
    found = attractors(f)
    assert len(found) == 0
    assert found.left == 1


def test_everything_leaves_through_the_gap():
    found = attractors(tent_with_hole(3.0))
    assert len(found) == 0
    assert found.left == 1
    assert sum(found.statuses.values()) >= found.n_starts


# --- on the interpolated table ------------------------------------------------------------------


def same_place(one, other):
    return one.bands.shape == other.bands.shape and np.allclose(
        one.bands, other.bands, rtol=0, atol=EDGE
    )


def check_both_ways(f):
    fast, plain = attractors(f), attractors(f, interpolate=False)
    fast_ones, plain_ones = ([a for a in found if a.basin_share > 0] for found in (fast, plain))
    assert sorted((a.kind, a.period) for a in fast_ones) == sorted(
        (a.kind, a.period) for a in plain_ones
    )
    for a in (a for a in fast_ones if a.kind != "undecided"):
        (b,) = (b for b in plain_ones if b.kind == a.kind and same_place(a, b))
        assert a.edges == b.edges
        (value, error), (other, doubt) = a.lyapunov, b.lyapunov
        assert abs(value - other) <= 5 * np.hypot(error, doubt) + 1e-9
        assert abs(a.basin_share - b.basin_share) <= SHARES
    assert abs(fast.left - plain.left) <= SHARES


@pytest.mark.parametrize(
    "f",
    [
        *(logistic(r) for r in (2.9, 3.5, 3.55, 3.6, 3.678, 3.7, 3.83, 3.845, 3.8284, 3.9603, 4.0)),
        *(tent(slope) for slope in (1.05, 1.2, 2**0.5, 1.9)),
        *(cubic(a) for a in (1.5, 2.5)),
        *(square_root(0.3, mu) for mu in (0.5, 0.05, 0.001)),
        border_collision(a=0.5, b=0.5, mu=-0.5, jump=1.0),
        border_collision(a=0.85, b=-1.19),
        doubling(2.5),
        tent_with_hole(3.0),
        *(EventMap(examples.coulomb(V=V)) for V in (0.0366, 0.03698, 0.0370, 0.0371, 0.0372)),
    ],
    ids=repr,
)
def test_interpolation_shows_what_the_map_shows(f):
    check_both_ways(f)


@tries(4, 40)
@given(
    alpha=st.floats(0.1, 3),
    beta=st.floats(0.5, 2),
    mu=st.floats(0.05, 0.9),
    V=st.floats(0.01, 0.3),
)
# Bands of the stand-in that touch: its rounding leaves a gap of 1e-11 between them.
@example(alpha=1.9375, beta=1.625, mu=0.4375, V=0.125)
# 180 bands: edges are images of one break up to the 360th.
@example(
    alpha=1.5431912206414995, beta=1.1224539629481682, mu=0.6433419220374877, V=0.1735158830599214
)
def test_interpolation_shows_what_event_maps_show(alpha, beta, mu, V):
    check_both_ways(EventMap(TwoBlock(alpha=alpha, beta=beta, V=V, friction=Coulomb(mu=mu))))


@pytest.mark.slow
@pytest.mark.parametrize("alpha", [1.2085, 1.211, 1.2155])
def test_interpolation_shows_what_law_9_shows(alpha):
    check_both_ways(WindowMap(EventMap(examples.law9(alpha=alpha)), (0.379, 0.390)))


class Counted:
    """A map that counts how often it is evaluated."""

    def __init__(self, f):
        self.f, self.count = f, 0
        self.domain = f.domain

    def evaluate(self, x):
        self.count += np.size(x)
        return self.f.evaluate(x)


@pytest.mark.parametrize("r", [3.0, 3.5, 3.6, 3.7, 3.84])  # a flip: one neutral cycle alone
def test_few_evaluations_are_enough(r):
    f = Counted(logistic(r))
    table = branch_table(f)
    f.count = 0
    attractors_of(f, table)
    assert f.count < 1000


def test_table_and_orbits_at_hand_are_used():
    f = cubic(1.5)
    found = attractors_of(f, branch_table(f), periodic_orbits(f, 2))
    assert sorted(a.orbit.points[0] for a in found) == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5)])


def test_stand_in_that_the_map_does_not_confirm_is_dropped():
    wrong = interpolated_map(branch_table(logistic(3.5)))  # a cycle of period 4
    f = logistic(3.7)
    (found,) = attractors_of(f, branch_table(f), fast=wrong)
    assert (found.kind, found.period) == ("chaotic", 1)


def test_edges_know_where_they_come_from():
    f = tent(1.2)
    (found,) = attractors(f)
    for edge, (x, side, order) in zip(found.bands.ravel(), found.sources, strict=True):
        assert x == 0.5
        assert side in (-1, 1)
        assert f.iterate(x, order)[-1] == pytest.approx(edge, abs=1e-14)


def test_edges_of_many_bands_are_explained():
    (found,) = attractors(logistic(3.56998))
    assert found.period == len(found.bands) == 64
    assert {order for _, _, order in found.sources} == set(range(1, 129))


def test_bands_that_hold_an_attractor_are_none():
    assert len(attractors(tent(1.01))) == 1


def test_orbit_that_comes_late_is_no_second_attractor():
    # Just past the flip of P1 orbits spiral away from it for thousands of steps.
    f = WindowMap(EventMap(examples.law9(alpha=1.209875)), (0.379, 0.390))
    (found,) = attractors(f)
    assert (found.kind, found.period) == ("chaotic", 2)


@pytest.mark.paper
@pytest.mark.parametrize(
    ("beyond", "period"), [(-1e-9, 4), (1e-5, 95), (1e-6, 123), (1e-7, 155), (1e-9, 215)]
)
def test_long_periods_beside_the_collision_of_s4(beyond, period):
    f = EventMap(examples.coulomb(V=0.036975923520307 + beyond))
    (found,) = (a for a in attractors_of(f, branch_table(f)) if a.period != 1)
    assert (found.kind, found.period) == ("periodic", period)
    points = found.orbit.points
    assert np.abs(f.evaluate(points).value - np.roll(points, -1)).max() < 1e-14
    assert np.diff(np.sort(points)).min() > 1e-12  # minimal: all points differ


# --- interface --------------------------------------------------------------------------------


def test_given_seeds_see_their_own_attractor_only():
    f = cubic(1.5)
    (found,) = attractors(f, starts=[0.3, 0.4])
    assert found.orbit.points == pytest.approx([np.sqrt(0.5)])
    assert found.basin_share == 1


def test_known_stable_orbits_are_attractors_without_a_seed():
    f = cubic(1.5)
    (other,) = attractors(f, starts=[-0.3])
    found = attractors(f, starts=[0.3], known=[other.orbit])
    assert sorted(a.orbit.points[0] for a in found) == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5)])
    assert sorted(a.basin_share for a in found) == [0, 1]


def test_results_repeat():
    one, two = attractors(cubic(2.5)), attractors(cubic(2.5))
    assert repr(one) == repr(two)
    assert one[0].kind == one[:1][0].kind
    assert len(list(one)) == len(one)


@pytest.mark.parametrize("name", ["n_starts", "max_period", "max_steps"])
def test_counts_below_one_are_refused(name):
    with pytest.raises(ValueError, match=f"{name} = 0"):
        attractors(logistic(3.2), **{name: 0})


@pytest.mark.parametrize("max_steps", [1, 2])
def test_orbits_that_were_hardly_followed_have_an_exponent(max_steps):
    found = attractors(logistic(3.2), max_steps=max_steps, n_starts=4)
    assert "undecided" in {item.kind for item in found}
    assert np.isfinite([item.lyapunov.value for item in found]).all()


def test_seed_outside_the_domain_is_refused():
    with pytest.raises(ValueError, match="outside the domain"):
        attractors(logistic(3.2), starts=[1.5])


def test_one_seed_is_quick():
    f = logistic(3.5)
    attractors(f, starts=[0.3])
    _, calls = calls_in(lambda: attractors(f, starts=[0.3]))
    assert calls < 20_000  # 4391 seen; a search of all starts makes 300 000


def test_plot_shows_bands_and_points():
    ax = attractors(cubic(2.5)).plot()
    assert len(ax.collections) == 2
    ax = attractors(cubic(1.5))[0].plot()
    assert len(ax.lines) == 1


def test_slow_approaches_to_two_neutral_orbits_are_told_apart():
    """What moved little in two steps was once given to the first neutral orbit found, wherever."""

    def half_stable(x):  # as of two equal blocks: neutral at a jump, approached from one side
        left = 0.5 - np.abs(x)
        to_jump = np.where(left < 0.05, np.abs(x) + 10 * left**2, 0.47)
        return np.sign(x) * np.where(left < 0, 0.3, to_jump)

    found = attractors(PiecewiseMap(half_stable, (-1, 1), breakpoints=[-0.5, 0.0, 0.5]))
    assert [a.kind for a in found] == ["undecided", "undecided"]
    assert sorted(a.point for a in found) == pytest.approx([-0.5, 0.5], abs=1e-3)
    assert [a.basin_share for a in found] == pytest.approx([0.5, 0.5], abs=0.02)


def test_bands_too_narrow_for_a_way_back_to_be_seen_are_no_chaos():
    """Beside a cycle of period 384, which attracts by 0.5 % a step, intervals shrink to points."""
    law = PoppStelter(gamma=2.3809140070063894, delta=0.08874280203939265)
    model = TwoBlock(1.5302629301914765, 1.8149596500848135, 0.09229373881606577, law)
    (only,) = attractors(model)
    assert (only.kind, only.period) == ("periodic", 384)


def test_chaos_in_a_window_within_the_capture_radius_of_a_cycle_is_told_apart():
    middle, half = 0.013, 1e-5

    def u(x):
        return (x - middle) / half

    windowed = PiecewiseMap(
        lambda x: np.where(np.abs(u(x)) < 1, middle + half * (0.99 - 1.9 * u(x) ** 2), 0.5 * x),
        (-1, 1),
        derivative=lambda x: np.where(np.abs(u(x)) < 1, -3.8 * u(x), 0.5),
        breakpoints=[middle - half, middle + half],
    )
    found = attractors(windowed)
    assert [(item.kind, item.period) for item in found] == [("periodic", 1), ("chaotic", 1)]
