"""Orbits followed along a parameter, against closed forms and the paper's two systems."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

from stickslip import examples as models
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.continuation import borders
from stickslip.analysis.continuation.continuation import follow_on, follow_orbit
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.friction import Coulomb
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.results.files import load

ROUNDING = 1e-13
LOCATED = 1e-12


def passed(branch, kind):
    return [item.value for item in branch.bifurcations if item.kind == kind]


def closes(branch, f):
    """Largest abs(f(x_i) - x_(i+1)) over a branch, by the map itself."""
    off = 0.0
    for value, points in zip(branch.values, branch.points, strict=True):
        at_value = f.replace(**{branch.parameter: value})
        off = max(off, np.abs(at_value.evaluate(points).value - np.roll(points, -1)).max())
    return off


# ------------------------------------------------------------------ smooth maps


def test_the_fixed_point_of_the_logistic_map():
    f = examples.logistic(2.0)
    branch = follow_orbit(periodic_orbits(f)[1], f, "r", (1.5, 3.9))
    assert branch.end_reasons == ("end of range", "end of range")
    assert (branch.values[0], branch.values[-1]) == (1.5, 3.9)
    assert branch.points[:, 0] == pytest.approx(1 - 1 / branch.values, abs=ROUNDING)
    assert branch.multipliers == pytest.approx(2 - branch.values, abs=ROUNDING)
    assert (np.diff(branch.values) > 0).all()
    assert passed(branch, "flip") == pytest.approx([3.0], abs=ROUNDING)
    (flip,) = branch.bifurcations
    assert flip.multiplier == pytest.approx(-1, abs=1e-14)
    assert abs(flip.value - 3) <= flip.error < 1e-12
    assert branch.values[flip.row] == flip.value
    assert not passed(branch, "fold")


def test_the_doubled_orbit_ends_where_its_parent_flips():
    f = examples.logistic(3.3)
    branch = follow_orbit(periodic_orbits(f, period=2)[0], f, "r", (2.5, 3.6))
    assert branch.end_reasons == ("period halves", "end of range")
    assert branch.ends[0].value == pytest.approx(3, abs=ROUNDING)
    assert branch.ends[0].points == pytest.approx([2 / 3, 2 / 3], abs=ROUNDING)
    assert branch.ends[0].multiplier == pytest.approx(1, abs=ROUNDING)
    assert passed(branch, "flip") == pytest.approx([1 + math.sqrt(6)], abs=ROUNDING)
    assert closes(branch, f) < ROUNDING
    # The multiplier of the orbit is 4 + 2 r - r^2.
    r = branch.values
    assert branch.multipliers == pytest.approx(4 + 2 * r - r * r, abs=1e-12)


def test_intervals_of_rows_contain_the_orbits():
    parabola = PiecewiseMap(lambda x, a: a - x * x, (-2, 2), parameters={"a": 0.2})
    curve = follow_orbit(periodic_orbits(parabola, 1)[1], parabola, "a", (-0.3, 0.3))
    (fold,) = (item.row for item in curve.bifurcations)
    for row in {*range(len(curve))} - {fold}:
        with localcontext(prec=40):
            root = (1 + 4 * Decimal(float(curve.values[row]))).sqrt()
            x = (-1 + root) / 2 if curve.points[row, 0] > -0.5 else (-1 - root) / 2
        low, high = curve[row].interval[0].tolist()
        assert low <= x <= high < low + 1e-9


def test_period_three_goes_through_its_fold():
    f = examples.logistic(3.9)
    one, other = periodic_orbits(f, period=3)
    branch = follow_orbit(one, f, "r", (3.8, 4.0))
    assert branch.end_reasons == ("end of range", "end of range")
    assert branch.values[0] == branch.values[-1] == 4.0
    assert passed(branch, "fold") == pytest.approx([1 + math.sqrt(8)], abs=LOCATED)
    assert len(passed(branch, "flip")) == 1
    (fold,) = (item for item in branch.bifurcations if item.kind == "fold")
    assert fold.multiplier == pytest.approx(1, abs=1e-10)
    assert fold.value == branch.values.min()
    # Both orbits of the pair are on it, and nothing else.
    found = branch.all_at(r=3.9)
    assert sorted(orbit.multiplier for orbit in found) == pytest.approx(
        sorted([one.multiplier, other.multiplier]), rel=1e-10
    )
    assert len(branch.all_at(r=fold.value)) == 1
    for aside in (1e-2, 1e-4, 1e-6, 1e-8):
        pair = branch.all_at(r=fold.value + aside)
        assert sorted(orbit.multiplier > 1 for orbit in pair) == [False, True]


def cubic(q=0.0):
    # Fixed points: q = x^3 - x, an S with folds at x = ±1/sqrt(3); multiplier 2 - 3 x^2.
    return PiecewiseMap(
        lambda x, q: 2 * x - x**3 + q,
        (-3, 3),
        parameters={"q": q},
        derivative=lambda x, q: 2 - 3 * x**2,
        parameter_derivative={"q": lambda x, q: np.ones_like(x)},
    )


def test_through_two_folds_of_a_cubic():
    f = cubic(0.1)
    start = periodic_orbits(f)[0]
    branch = follow_orbit(start, f, "q", (-1, 1))
    x, q = branch.points[:, 0], branch.values
    assert q == pytest.approx(x**3 - x, abs=ROUNDING)
    assert (np.diff(x) > 0).all() or (np.diff(x) < 0).all()
    fold = 2 / math.sqrt(27)
    assert sorted(passed(branch, "fold")) == pytest.approx([-fold, fold], abs=ROUNDING)
    assert passed(branch, "flip") == pytest.approx([0, 0], abs=ROUNDING)
    assert sorted(o.points[0] for o in branch.all_at(q=0.2)) == pytest.approx(
        sorted(np.roots([1, 0, -1, -0.2]).real), abs=ROUNDING
    )
    assert branch.at(q=0.9).points[0] ** 3 - branch.at(q=0.9).points[0] == pytest.approx(0.9)
    with pytest.raises(ValueError, match=r"passes q = 0\.2 3 times.*all_at"):
        branch.at(q=0.2)


def test_any_orbit_of_a_branch_leads_to_the_same_branch():
    f = cubic(0.1)
    ends = set()
    for orbit in periodic_orbits(f):
        branch = follow_orbit(orbit, f, "q", (-1, 1))
        ends.add(tuple(sorted(np.round([branch.points[0, 0], branch.points[-1, 0]], 12))))
        assert len(branch.bifurcations) == 4
    assert len(ends) == 1


def test_a_closed_branch():
    # Fixed points on the circle x^2 + q^2 = 1.
    f = PiecewiseMap(
        lambda x, q: x + 0.5 * (x**2 + q**2 - 1),
        (-2, 2),
        parameters={"q": 0.3},
        derivative=lambda x, q: 1 + x,
        parameter_derivative={"q": lambda x, q: q + 0 * x},
    )
    branch = follow_orbit(periodic_orbits(f)[0], f, "q", (-2, 2))
    assert branch.end_reasons == ("closed", "closed")
    assert sorted(passed(branch, "fold")) == pytest.approx([-1, 1], abs=ROUNDING)
    assert len(branch.all_at(q=0.5)) == 2
    np.testing.assert_array_equal(branch.points[0], branch.points[-1])
    # In a range that cuts the circle there are two branches.
    part = follow_orbit(periodic_orbits(f)[0], f, "q", (-0.6, 0.8))
    assert part.end_reasons == ("end of range", "end of range")
    assert len(part.bifurcations) == 0
    # Followed on, its ends meet each other.
    whole = follow_on(part, "q", (-2, 2))
    assert whole.end_reasons == ("closed", "closed")
    assert sorted(passed(whole, "fold")) == pytest.approx([-1, 1], abs=ROUNDING)


def test_an_unstable_orbit_of_long_period_loses_no_digits():
    f = examples.logistic(3.99)
    orbit = periodic_orbits(f, period=8)[3]
    branch = follow_orbit(orbit, f, "r", (3.985, 4.0))
    assert abs(branch.multipliers).max() > 200
    assert closes(branch, f) < ROUNDING


# ------------------------------------------------------------------ ends


def test_orbits_of_the_tent_map_end_at_its_corner():
    f = examples.tent(1.8)
    for orbit in periodic_orbits(f, period=3):
        branch = follow_orbit(orbit, f, "slope", (0.5, 2.0))
        assert branch.end_reasons == ("breakpoint", "end of range")
        end = branch.ends[0]
        # Period 3 of the tent map is born at the golden mean.
        assert end.value == pytest.approx((1 + math.sqrt(5)) / 2, abs=ROUNDING)
        assert end.points[end.index] == 0.5
        assert end.border.kind == "corner"
        assert end.side == (-1 if branch.points[1, end.index] < 0.5 else 1)
        assert end.multiplier == pytest.approx(math.copysign(end.value**3, orbit.multiplier))
        at_end = branch.at(slope=end.value)
        assert at_end.points == pytest.approx(np.sort(end.points)[[0, 1, 2]], abs=ROUNDING)


@given(
    a=st.integers(-29, 31).filter(lambda n: n != 10).map(lambda n: n / 10),
    b=st.integers(-29, 31).filter(lambda n: n != 10).map(lambda n: n / 10),
    jump=st.integers(-5, 5).map(lambda n: n / 10),
)
def test_fixed_points_end_at_a_border(a, b, jump):
    assume(a != b or jump)  # else there is nothing at the border
    f = examples.border_collision(a, b, mu=1.0, jump=jump)
    for orbit in periodic_orbits(f):
        branch = follow_orbit(orbit, f, "mu", (-1.0, 1.5))
        # mu / (1 - a) meets 0 at mu = 0, (mu + jump) / (1 - b) at -jump.
        (end,) = (end for end in branch.ends if end.reason == "breakpoint")
        assert end.value == pytest.approx(0 if orbit.points[0] < 0 else -jump, abs=1e-15)
        assert end.points == pytest.approx([0], abs=1e-15)
        assert end.side == (-1 if orbit.points[0] < 0 else 1)
        assert end.multiplier == pytest.approx(orbit.multiplier)
        assert closes(branch, f) < ROUNDING + abs(jump)  # the end is a one-sided limit


def test_both_points_of_a_period_two_orbit_may_meet_the_border():
    f = examples.border_collision(0.5, -3.0, mu=1.0)
    (orbit,) = periodic_orbits(f, period=2)
    branch = follow_orbit(orbit, f, "mu", (-1.0, 2.0))
    assert branch.end_reasons == ("breakpoint", "end of range")
    assert branch.ends[0].value == pytest.approx(0, abs=1e-15)


def test_a_corner_without_label_ends_a_branch_too():
    f = PiecewiseMap(
        lambda x, mu: np.where(x < 0, 0.5, -2.0) * x + mu,
        (-5, 5),
        parameters={"mu": 1.0},
        derivative=lambda x, mu: np.where(x < 0, 0.5, -2.0),
        parameter_derivative={"mu": lambda x, mu: np.ones_like(x)},
    )
    branch = follow_orbit(periodic_orbits(f)[0], f, "mu", (-1, 1.5))
    assert branch.end_reasons == ("breakpoint", "end of range")
    assert branch.ends[0].value == pytest.approx(0, abs=1e-9)
    assert branch.ends[0].border.kind == "corner"


def test_an_infinite_slope_at_the_end_does_no_harm():
    f = examples.square_root(lam=0.2, mu=0.1)
    for period in (1, 2):
        _, multiplier = examples.maximal_orbit(0.2, 0.1, period)
        (orbit,) = (
            o
            for o in periodic_orbits(f, period=period)
            if o.multiplier == pytest.approx(multiplier)
        )
        branch = follow_orbit(orbit, f, "mu", (-0.5, 0.5))
        assert "breakpoint" in branch.end_reasons
        for end in branch.ends:
            if end.reason == "breakpoint":
                exact = end.value == pytest.approx(0, abs=1e-10)
                assert exact or end.points[end.index] == pytest.approx(0, abs=1e-12)
        for value in (1e-6, 1e-4, 0.05, 0.08):
            if branch.values.min() < value < branch.values.max():
                exact_points, exact_multiplier = examples.maximal_orbit(0.2, value, period)
                found = branch.at(mu=value)
                assert np.sort(found.points) == pytest.approx(np.sort(exact_points), abs=1e-12)
                assert found.multiplier == pytest.approx(exact_multiplier)


def test_a_gap():
    f = PiecewiseMap(
        lambda x, q: np.where(x <= 0, 0.5 * x + q, np.nan),
        (-2, 1),
        parameters={"q": -0.3},
        derivative=lambda x, q: 0.5 + 0 * x,
        parameter_derivative={"q": lambda x, q: np.ones_like(x)},
    )
    branch = follow_orbit(periodic_orbits(f)[0], f, "q", (-0.5, 0.5))
    assert branch.end_reasons == ("end of range", "gap")
    assert branch.ends[1].value == pytest.approx(0, abs=1e-14)
    assert branch.ends[1].border.kind == "edge"
    assert branch.ends[1].side == -1


def test_the_end_of_the_window_and_of_the_domain():
    f = examples.logistic(3.0)
    orbit = periodic_orbits(f)[1]
    branch = follow_orbit(orbit, f, "r", (1.2, 4.0), window=(0.5, 1.0))
    assert branch.end_reasons == ("end of domain", "end of range")
    assert branch.ends[0].value == pytest.approx(2, abs=ROUNDING)  # 1 - 1/r = 1/2
    assert branch.ends[0].points[0] == 0.5
    assert branch.ends[0].border is None
    assert branch.ends[0].side == 1
    f = PiecewiseMap(lambda x, q: 0.5 * x + q, (-1, 1), parameters={"q": 0.1})
    branch = follow_orbit(periodic_orbits(f)[0], f, "q", (-3, 3))
    assert branch.end_reasons == ("end of domain", "end of domain")
    assert [end.value for end in branch.ends] == pytest.approx([-0.5, 0.5], abs=1e-12)


def test_harmless_changes_of_the_label_are_passed():
    plain = examples.logistic(3.3)
    labelled = PiecewiseMap(
        plain.func,
        plain.domain,
        parameters={"r": 3.3},
        derivative=lambda x, r: r * (1 - 2 * x),
        parameter_derivative={"r": lambda x, r: x * (1 - x)},
        breakpoints=lambda r: [0.1 * r, 0.45, 0.7],
    )
    for period in (1, 2):
        one = follow_orbit(periodic_orbits(plain, period=period)[-1], plain, "r", (2.5, 3.9))
        other = follow_orbit(
            periodic_orbits(labelled, period=period)[-1], labelled, "r", (2.5, 3.9)
        )
        assert other.end_reasons == one.end_reasons
        assert passed(other, "flip") == pytest.approx(passed(one, "flip"), abs=ROUNDING)
        assert other.ends[0].value == pytest.approx(one.ends[0].value, abs=ROUNDING)
        assert len(np.unique(other.data["labels"])) > 1


def test_a_break_that_moves_meets_an_orbit_that_stands_still():
    f = PiecewiseMap(
        lambda x, q: np.where(x < 0.3 + q**2, 0.5 * x + 0.2, 0.9),
        (0, 1),
        parameters={"q": 0.6},
        derivative=lambda x, q: np.where(x < 0.3 + q**2, 0.5, 0.0),
        parameter_derivative={"q": lambda x, q: np.zeros_like(x)},
        breakpoints=lambda q: [0.3 + q**2],
    )
    (orbit,) = (o for o in periodic_orbits(f) if o.points[0] < 0.5)
    branch = follow_orbit(orbit, f, "q", (0.0, 0.65))
    assert branch.end_reasons == ("breakpoint", "end of range")
    assert branch.ends[0].value == pytest.approx(math.sqrt(0.1), abs=1e-14)
    assert branch.ends[0].border.kind == "jump"


# ------------------------------------------------------------------ hard cases


def followed(model, name, multiplier, ends):
    f = EventMap(model)
    (orbit,) = (o for o in periodic_orbits(f) if o.multiplier == pytest.approx(multiplier))
    return f, follow_orbit(orbit, f, name, ends)


def test_a_jump_beside_which_branches_accumulate():
    # The label beyond the jump is another one at every value of mu.
    model = TwoBlock(
        alpha=2.0815320274094455,
        beta=1.6806454123322014,
        V=0.06152679641093989,
        friction=Coulomb(mu=0.7320095369643506),
    )
    f, branch = followed(model, "mu", -1.8946445740792683, (0.7, 0.86))
    assert branch.end_reasons == ("end of range", "breakpoint")
    end = branch.ends[1]
    assert end.value == pytest.approx(0.849305583855, abs=1e-11)
    assert len(branch) < 40  # solved for, not approached step by step
    c, value = end.border.x, end.points[0]
    assert value == pytest.approx(c, abs=1e-14)
    # Others come and go there, but this one is gone.
    inside, outside = (
        [o.points[0] for o in periodic_orbits(f.replace(mu=end.value + k * 1e-9))
         if o.multiplier == pytest.approx(end.multiplier, rel=1e-4)]
        for k in (-1, 1)
    )  # fmt: skip
    assert inside == pytest.approx([value], abs=1e-8)
    assert outside == []


def test_a_harmless_break_that_overtakes_the_orbit():
    model = TwoBlock(
        alpha=1.5775380564123773,
        beta=1.2663333266997996,
        V=0.22714391127214248,
        friction=Coulomb(mu=0.17573373041721307),
    )
    f, branch = followed(model, "V", -3.879850812132142, (0.22, 0.245))
    assert branch.values[-1] > 0.23503  # at 0.23502 the break passes
    assert len(np.unique(branch.data["labels"])) == 2
    for value in (0.2350, 0.2351):
        there = branch.at(V=value)
        listed = periodic_orbits(f.replace(V=value))
        assert min(abs(o.points[0] - there.points[0]) for o in listed) < 1e-14


# ------------------------------------------------------------------ the paper's systems


@pytest.fixture(scope="module")
def coulomb():
    return EventMap(models.coulomb(V=0.0366))


@pytest.mark.paper
def test_s4_meets_the_jump(coulomb):
    s4 = periodic_orbits(coulomb, period=4)[0]
    branch = follow_orbit(s4, coulomb, "V", (0.0366, 0.0372))
    assert branch.end_reasons == ("end of range", "breakpoint")
    end = branch.ends[1]
    assert end.value == pytest.approx(0.036975923520307, abs=LOCATED)
    assert end.border.kind == "jump"
    assert end.points[end.index] == end.border.x
    assert abs(end.multiplier) < 1
    # Just before the end the orbit is there, a little beyond it is not.
    before = branch.at(V=end.value - 1e-9)
    assert before.quality == "located"
    assert before.residual < 1e-14
    orbits = periodic_orbits(coulomb.replace(V=end.value + 1e-9), period=4)
    assert not any(o.stable for o in orbits)


@pytest.mark.paper
def test_the_other_orbits_go_on(coulomb):
    multipliers = [-0.5620085225, 9.1822953528, -1.7450118961]
    for orbit, multiplier in zip(periodic_orbits(coulomb), multipliers, strict=True):
        branch = follow_orbit(orbit, coulomb, "V", (0.0366, 0.0372))
        assert branch.end_reasons == ("end of range", "end of range")
        assert branch.multipliers[0] == pytest.approx(multiplier, abs=1e-9)
        last = periodic_orbits(coulomb.replace(V=0.0372))
        assert min(np.abs(o.points[0] - branch.points[-1, 0]) for o in last) < 1e-14


@pytest.fixture(scope="module")
def law9():
    return WindowMap(EventMap(models.law9(alpha=1.2175)), (0.379, 0.390))


@pytest.mark.paper
def test_s1_and_u1_are_one_branch_through_the_fold(law9):
    s1 = periodic_orbits(law9)[0]
    branch = follow_orbit(s1, law9, "alpha", (1.208, 1.21865))
    assert sorted(branch.end_reasons) == ["breakpoint", "end of range"]
    assert passed(branch, "fold") == pytest.approx([1.2151058900461], abs=LOCATED)
    (end,) = (end for end in branch.ends if end.reason == "breakpoint")
    assert end.value == pytest.approx(1.218624503830, abs=LOCATED)  # the cusp on the diagonal
    assert end.border.kind == "corner"
    (flip,) = passed(branch, "flip")
    doubled = periodic_orbits(law9.replace(alpha=flip + 1e-4), period=2)
    assert any(o.stable for o in doubled)


@pytest.mark.paper
def test_p1_and_its_double(law9):
    f = law9.replace(alpha=1.2095)
    p1 = follow_orbit(periodic_orbits(f)[0], f, "alpha", (1.208, 1.21865))
    assert p1.end_reasons == ("end of range", "breakpoint")
    assert passed(p1, "flip") == pytest.approx([1.209859795641], abs=LOCATED)
    assert p1.ends[1].value == pytest.approx(1.218624503830, abs=LOCATED)
    branches = [
        follow_orbit(orbit, f, "alpha", (1.208, 1.21865)) for orbit in periodic_orbits(f, period=2)
    ]
    (a,) = (b for b in branches if "period halves" in b.end_reasons)
    assert a.end_reasons == ("breakpoint", "period halves")
    assert a.ends[0].value == pytest.approx(1.209121691649, abs=LOCATED)
    assert a.ends[1].value == pytest.approx(1.209859795641, abs=LOCATED)
    # B ends where two of its points meet the cusp together.
    (b,) = (b for b in branches if b.end_reasons == ("breakpoint", "breakpoint"))
    assert [end.value for end in b.ends] == pytest.approx(
        [1.209121691649, 1.218624503830], abs=LOCATED
    )


# ------------------------------------------------------------------ going on


@pytest.mark.parametrize("kept", [False, True])
def test_going_on_equals_one_uninterrupted_run(tmp_path, kept):
    f = examples.logistic(3.9)
    orbit = periodic_orbits(f, period=3)[1]
    whole = follow_orbit(orbit, f, "r", (3.8, 4.0))
    part = follow_orbit(orbit, f, "r", (3.85, 3.95))
    assert part.end_reasons == ("end of range", "end of range")
    if kept:
        part.save(tmp_path / "branch.json")
        part = load(tmp_path / "branch.json", f)
    more = follow_on(part, "r", (3.8, 4.0))
    assert more.end_reasons == whole.end_reasons
    for kind in ("fold", "flip"):
        assert passed(more, kind) == pytest.approx(passed(whole, kind), abs=ROUNDING)
    for item in more.bifurcations:
        assert more.values[item.row] == item.value
        assert np.array_equal(more.points[item.row], item.points)
    for end, other in zip(more.ends, whole.ends, strict=True):
        assert end.value == other.value
        assert end.points == pytest.approx(other.points, abs=ROUNDING)
    for one, other in zip(more.all_at(r=3.88), whole.all_at(r=3.88), strict=True):
        assert one.points == pytest.approx(other.points, abs=ROUNDING)
    assert closes(more, f) < ROUNDING


@pytest.mark.paper
def test_a_loaded_branch_of_a_model_goes_on_to_the_jump(tmp_path):
    f = EventMap(models.coulomb(V=0.0366))
    s4 = periodic_orbits(f, period=4)[0]
    part = follow_orbit(s4, f, "V", (0.0364, 0.0368))
    part.save(tmp_path / "branch.json")
    more = follow_on(load(tmp_path / "branch.json", f), "V", (0.0364, 0.0372))
    whole = follow_orbit(s4, f, "V", (0.0364, 0.0372))
    assert more.end_reasons == whole.end_reasons == ("end of range", "breakpoint")
    assert more.ends[1].value == pytest.approx(whole.ends[1].value, abs=1e-15)
    assert more.ends[1].border.left_label == whole.ends[1].border.left_label


def test_a_branch_given_up_after_many_points_goes_on():
    f = examples.logistic(3.0)
    orbit = periodic_orbits(f)[1]
    part = follow_orbit(orbit, f, "r", (1.5, 4.0), max_points=5)
    assert part.end_reasons == ("point limit", "point limit")
    assert len(part) == 11
    whole = follow_on(part, "r", (1.5, 4.0))
    assert whole.end_reasons == ("end of range", "end of range")


def test_a_branch_keeps_its_window():
    f = examples.logistic(3.0)
    part = follow_orbit(periodic_orbits(f)[1], f, "r", (2.5, 3.5), window=(0.5, 1.0))
    more = follow_on(part, "r", (1.2, 4.0))
    assert more.end_reasons == ("end of domain", "end of range")


def test_shorter_steps_give_more_points():
    f = examples.logistic(3.0)
    orbit = periodic_orbits(f)[1]
    coarse, fine = (
        follow_orbit(orbit, f, "r", (2.0, 4.0), max_step=step) for step in (1 / 16, 1 / 256)
    )
    assert len(fine) > 256 > len(coarse)
    assert fine.ends[1].points == pytest.approx(coarse.ends[1].points, abs=ROUNDING)


# ------------------------------------------------------------------ refusals


@pytest.fixture(scope="module")
def stable():
    f = examples.logistic(2.5)
    return f, periodic_orbits(f)[1]


@pytest.mark.parametrize(
    ("name", "ends", "said"),
    [
        ("R", (2, 3), "'R' is not a parameter.*Known: r"),
        ("r", (3, 2), "lo < hi"),
        ("r", (2, math.nan), "finite"),
        ("r", 3, "pair of numbers"),
        ("r", (2.6, 3), "does not contain r = 2.5"),
    ],
)
def test_wrong_names_and_ranges(stable, name, ends, said):
    f, orbit = stable
    with pytest.raises(ValueError, match=said):
        follow_orbit(orbit, f, name, ends)


@pytest.mark.parametrize(
    "option", [{"max_step": 0}, {"max_step": math.nan}, {"max_points": 0}, {"max_points": 2.5}]
)
def test_wrong_options(stable, option):
    f, orbit = stable
    with pytest.raises(ValueError, match=next(iter(option))):
        follow_orbit(orbit, f, "r", (2, 3), **option)


def test_ranges_that_the_model_does_not_allow(coulomb):
    orbit = periodic_orbits(coulomb)[0]
    with pytest.raises(ValueError, match="V"):
        follow_orbit(orbit, coulomb, "V", (-0.1, 0.1))


def test_an_orbit_of_another_map_is_refused(stable):
    f, orbit = stable
    with pytest.raises(ValueError, match=r"no such orbit at r = 3\.5"):
        follow_orbit(orbit, f.replace(r=3.5), "r", (2, 4))


def test_infinitely_unstable_orbits_are_refused(coulomb):
    found = periodic_orbits(coulomb, period=4, infinitely_unstable=True)
    orbit = next(orbit for orbit in found if orbit.infinitely_unstable)
    with pytest.raises(ValueError, match="infinitely unstable"):
        follow_orbit(orbit, coulomb, "V", (0.036, 0.037))


def test_what_a_branch_refuses(stable):
    f, orbit = stable
    branch = follow_orbit(orbit, f, "r", (2, 3))
    with pytest.raises(ValueError, match=r"r = 3\.5 is outside the curve"):
        branch.at(r=3.5)
    with pytest.raises(ValueError, match=r"give its value as at\(r="):
        branch.at(q=2.5)
    with pytest.raises(ValueError, match="neither end of the curve can go on"):
        follow_on(branch, "r", (2, 3))
    g = examples.border_collision()
    other = follow_orbit(periodic_orbits(g)[0], g, "mu", (0.5, 1.5))
    with pytest.raises(ValueError, match="the curve is one along mu"):
        follow_on(other, "a", (0, 1))


def test_shown(stable):
    f, orbit = stable
    text = repr(follow_orbit(orbit, f, "r", (2, 3.5)))
    assert "period 1" in text
    assert "flip" in text
    assert text.count("end of range") == 2
    assert max(map(len, text.splitlines())) <= 100


def test_a_sliver_inside_a_branch_is_no_other_break():
    # The branch goes on beyond [0.5, 0.5 + 1e-11]; another jump is not far.
    f = PiecewiseMap(
        lambda x: np.where(x < 0.5005, 0.1, 0.9),
        (0, 1),
        label=lambda x: np.where((x >= 0.5) & (x < 0.5 + 1e-11), 1, np.where(x < 0.5005, 0, 2)),
    )
    sliver = TrackedDiscontinuity(0, 1, 0.5, "jump")
    assert borders._settled(sliver, -1, f).x == pytest.approx(0.5, abs=1e-15)
