"""Bifurcation curves in two parameters whose equations are known."""

import math
import re
from itertools import accumulate
from types import SimpleNamespace

import numpy as np
import pytest
from tests.analysis.known_maps import border_collision, logistic

from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.analysis.bifurcations.conditions.conditions import Collision, Connection, Flip, Fold
from stickslip.analysis.bifurcations.curves.curve_ends import last_crisis
from stickslip.analysis.bifurcations.curves.curves import follow_bifurcation
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity, TurningPoint
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.piecewise_map import PiecewiseMap

ON_CURVE = 1e-11  # of parameters of order 1
SPECIAL = 1e-9  # of points where the type changes: roots of derivatives
RANGE_ENDS = ("end of range", "end of range")


def follow(f, condition, parameter, value, *, along, range, solve_for):
    b = SimpleNamespace(condition=condition, parameter=parameter, value=value, kind="any")
    return follow_bifurcation(b, f, along, range, solve_for=solve_for)


def quadratic(a=0.0, b=0.0):
    """Make x -> a + b x - x^2, with fixed points in closed form."""
    return PiecewiseMap(lambda x, a, b: a + b * x - x * x, (-20, 20), parameters={"a": a, "b": b})


def of_kind(curve, kind):
    return [mark for mark in curve.bifurcations if mark.kind == kind]


# ---------------------------------------------------------------- folds and flips


def test_flip_curve():
    curve = follow(
        quadratic(0.75), Flip(1, (0.5,)), "a", 0.75, along="b", range=(-0.5, 0.9), solve_for="a"
    )
    a, b = curve.parameters["a"], curve.parameters["b"]
    assert (b[0], b[-1]) == (-0.5, 0.9)
    assert np.all(np.diff(b) > 0)
    assert a == pytest.approx((1 + b) * (3 - b) / 4, abs=ON_CURVE)
    assert curve.points[:, 0] == pytest.approx((1 + b) / 2, abs=ON_CURVE)
    assert curve.multipliers == pytest.approx(-np.ones(len(a)), abs=ON_CURVE)
    assert curve.end_reasons == RANGE_ENDS
    assert not curve.bifurcations
    assert (curve.parameter, curve.solve_for, curve.period) == ("b", "a", 1)
    assert curve.kind == "bifurcation: any"


def test_fold_curve_through_its_turning_point():
    # a = -(1 - b)^2 / 4: over a the curve turns back at a = 0, b = 1.
    f = quadratic(-0.25, 0.0)
    curve = follow(f, Fold(1, (-0.5,)), "a", -0.25, along="a", range=(-0.5, 0.1), solve_for="b")
    a, b = curve.parameters["a"], curve.parameters["b"]
    assert a == pytest.approx(-((1 - b) ** 2) / 4, abs=ON_CURVE)
    assert (a[0], a[-1]) == (-0.5, -0.5)
    assert (b[0], b[-1]) == pytest.approx((1 - math.sqrt(2), 1 + math.sqrt(2)), abs=ON_CURVE)
    assert a.max() > -1e-3
    assert curve.end_reasons == RANGE_ENDS
    with pytest.raises(ValueError, match=r"passes a = -0\.25 2 times, at .*near="):
        curve.at(a=-0.25)
    assert curve.at(a=-0.25, near=1.9).value == pytest.approx(2.0, abs=ON_CURVE)
    assert curve.at(b=1.5).value == pytest.approx(-1 / 16, abs=ON_CURVE)


def test_closed_curve():
    # A fold where (a - 5)^2 + b^2 = 1.
    f = PiecewiseMap(
        lambda x, a, b: x + x * x + (a - 5) ** 2 + b * b - 1,
        (-3, 3),
        parameters={"a": 6.0, "b": 0.0},
    )
    curve = follow(f, Fold(1, (0.0,)), "a", 6.0, along="b", range=(-2, 2), solve_for="a")
    a, b = curve.parameters["a"] - 5, curve.parameters["b"]
    assert a * a + b * b == pytest.approx(np.ones(len(a)), abs=ON_CURVE)
    assert curve.end_reasons == ("closed", "closed")
    angle = np.unwrap(np.arctan2(b, a))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2 * np.pi, abs=1e-9)


def test_cusp():
    # x + a + b x - x^3: folds where b = 3 x^2, a = -2 x^3.
    f = PiecewiseMap(
        lambda x, a, b: x + a + b * x - x**3, (-2, 2), parameters={"a": -0.128, "b": 0.48}
    )
    for along, other, width in (("b", "a", (-0.1, 0.6)), ("a", "b", (-0.2, 0.2))):
        value = f.parameters[other]
        curve = follow(f, Fold(1, (0.4,)), other, value, along=along, range=width, solve_for=other)
        x = curve.points[:, 0]
        assert curve.parameters["a"] == pytest.approx(-2 * x**3, abs=ON_CURVE)
        assert curve.parameters["b"] == pytest.approx(3 * x**2, abs=ON_CURVE)
        # Past the cusp the other branch is followed to the end of the range.
        assert x.min() < -0.4 < 0.4 < x.max()
        assert curve.end_reasons == RANGE_ENDS
        (cusp,) = curve.bifurcations
        assert cusp.kind == "cusp"
        assert list(cusp.parameters.values()) == pytest.approx([0, 0], abs=SPECIAL)
        assert cusp.points == pytest.approx((0,), abs=1e-6)
        k = cusp.row
        assert curve.parameters["a"][k] == cusp.parameters["a"]
        assert x[k - 1] * x[k + 1] < 0


def test_generalised_flip():
    # -(1 + m) x + c x^2 - x^3 flips at m = 0; cubic coefficient c^2 - 1.
    f = PiecewiseMap(
        lambda x, m, c: -(1 + m) * x + c * x * x - x**3, (-2, 2), parameters={"m": 0.0, "c": 0.3}
    )
    curve = follow(f, Flip(1, (0.0,)), "m", 0.0, along="c", range=(-0.5, 1.5), solve_for="m")
    assert curve.parameters["m"] == pytest.approx(np.zeros(len(curve.points)), abs=ON_CURVE)
    (mark,) = curve.bifurcations
    assert mark.kind == "generalised flip"
    assert mark.parameters["c"] == pytest.approx(1, abs=1e-8)


def test_fold_that_meets_a_break():
    # The left branch ends at 0.2; its fold moves there with b.
    f = PiecewiseMap(
        lambda x, a, b: np.where(x < 0.2, a + b * x - x * x, -1.0), (-2, 2),
        parameters={"a": -0.25, "b": 0.0}, breakpoints=[0.2],
    )  # fmt: skip
    curve = follow(f, Fold(1, (-0.5,)), "a", -0.25, along="b", range=(-0.5, 2.0), solve_for="a")
    assert curve.parameters["b"][-1] == pytest.approx(1.4, abs=1e-8)
    (mark,) = curve.bifurcations
    assert (mark.kind, mark.parameters["b"]) == ("breakpoint", pytest.approx(1.4, abs=SPECIAL))
    assert mark.parameters["a"] == pytest.approx(-0.04, abs=SPECIAL)
    assert "meets another break, the jump at " in mark.what
    assert curve.end_reasons == ("end of range", mark.what)


# ---------------------------------------------------------------- borders


def normal_form(**changes):
    f = border_collision(a=0.5, b=-2.0, mu=0.0, size=10.0)
    return f.replace(**changes)


def border_of(f):
    (b,) = breakpoints(f)
    return TrackedDiscontinuity.of(b)


def test_multipliers_at_a_border_pass_one_minus_one_and_zero():
    f = normal_form()
    curve = follow(
        f, Collision(1, border_of(f), -1), "mu", 0.0, along="a", range=(-1.5, 1.5), solve_for="mu"
    )
    a = curve.parameters["a"]
    assert curve.parameters["mu"] == pytest.approx(np.zeros(len(a)), abs=ON_CURVE)
    assert curve.data["multiplier_left"] == pytest.approx(a)
    assert curve.data["multiplier_right"] == pytest.approx(np.full(len(a), -2.0))
    assert curve.multipliers == pytest.approx(a)
    # Equal slopes of the two sides, at a = b = -2, are outside the range.
    marks = {mark.kind: mark.parameters["a"] for mark in curve.bifurcations}
    assert marks == {
        "multiplier 1": pytest.approx(1, abs=SPECIAL),
        "multiplier -1": pytest.approx(-1, abs=SPECIAL),
        "multiplier 0": pytest.approx(0, abs=SPECIAL),
    }
    assert "on the left of the border passes 1: the colliding orbit also folds" in str(
        of_kind(curve, "multiplier 1")[0]
    )


def test_corner_that_straightens_and_jump_that_closes():
    f = normal_form()
    curve = follow(
        f, Collision(1, border_of(f), -1), "mu", 0.0, along="a", range=(-3.0, 1.5), solve_for="mu"
    )
    (mark,) = of_kind(curve, "kind of border")
    assert mark.parameters["a"] == pytest.approx(-2, abs=SPECIAL)
    g = normal_form(jump=0.5, mu=-0.5)
    curve = follow(
        g, Collision(1, border_of(g), 1), "mu", -0.5, along="jump", range=(-1, 1), solve_for="mu"
    )
    assert curve.parameters["mu"] == pytest.approx(-curve.parameters["jump"], abs=ON_CURVE)
    assert curve.multipliers == pytest.approx(np.full(len(curve.points), -2.0))
    (mark,) = curve.bifurcations
    assert (mark.kind, mark.parameters["jump"]) == ("kind of border", pytest.approx(0, abs=SPECIAL))


def two_breaks(a=0.0, c=0.0):
    """Return x + ... left of 0; a jump at 1 that the orbit of the border may reach."""

    def values(x, a, c):
        return np.where(x < 0, a + 0.8, np.where(x < 1, x - 0.8 + c, 0.5 * x - 2 + c))

    return PiecewiseMap(values, (-4, 4), parameters={"a": a, "c": c}, breakpoints=[0, 1])


def test_border_collision_whose_orbit_meets_another_jump():
    # 0- -> a + 0.8 -> a + c = 0, as long as a + 0.8 < 1.
    f = two_breaks()
    border = TrackedDiscontinuity.of(breakpoints(f)[0])
    curve = follow(
        f, Collision(2, border, -1), "c", 0.0, along="a", range=(-0.5, 0.5), solve_for="c"
    )
    a, c = curve.parameters["a"], curve.parameters["c"]
    assert c == pytest.approx(-a, abs=1e-8)
    assert a[0] == -0.5
    assert a[-1] == pytest.approx(0.2, abs=1e-8)
    (mark,) = of_kind(curve, "second border")
    assert mark.parameters == {
        "a": pytest.approx(0.2, abs=SPECIAL), "c": pytest.approx(-0.2, abs=SPECIAL),
    }  # fmt: skip
    assert curve.end_reasons == ("end of range", mark.what)


def test_curve_of_a_border_that_leaves_the_domain():
    f = PiecewiseMap(
        lambda x, c, h: np.where(x < c, h + 0.5 * (x - c), 0.2), (0, 1),
        parameters={"c": 0.6, "h": 0.6}, breakpoints=lambda c, h: [c] if c < 1 else [],
    )  # fmt: skip
    curve = follow(
        f, Collision(1, border_of(f), -1), "h", 0.6, along="c", range=(0.5, 1.5), solve_for="h"
    )
    assert curve.parameters["h"] == pytest.approx(curve.parameters["c"], abs=1e-8)
    assert curve.parameters["c"][-1] == pytest.approx(1.0, abs=1e-6)
    assert curve.end_reasons[0] == "end of range"
    assert "is gone" in curve.end_reasons[1]


# ---------------------------------------------------------------- crises


def test_boundary_crisis_of_a_family_of_parabolas():
    # f^2(c) = fixed point on the left: conjugate to r = 4 of the logistic map.
    f = quadratic(2.0, 0.0)
    crisis = Connection(TurningPoint(0.0), 1, 2, (-2.0,))
    curve = follow(f, crisis, "a", 2.0, along="b", range=(-0.5, 0.5), solve_for="a")
    a, b = curve.parameters["a"], curve.parameters["b"]
    # x = y + b / 2 turns it into A - y^2 with A = a - b / 2 + b^2 / 4 = 2.
    assert a == pytest.approx(2 + b / 2 - b * b / 4, abs=ON_CURVE)
    assert curve.multipliers == pytest.approx(np.full(len(a), 4.0), abs=1e-9)
    point = curve.at(b=0.25)
    assert point.value == pytest.approx(2 + 0.125 - 1 / 64, abs=ON_CURVE)
    assert abs(point.value - (2 + 0.125 - 1 / 64)) <= 4 * point.error
    assert point.error < ON_CURVE
    assert point.system.parameters == {"b": 0.25, "a": point.value}


def test_a_crisis_ends_where_chaos_meets_two_orbits_at_once():
    """Slopes p, -p, p: the edges meet the fixed points beside them at p = 3 - b and p = 3 + b."""
    f = PiecewiseMap(
        ["b + p*(x + 2)", "b - p*x", "b + p*(x - 2)"],
        (-6, 6),
        parameters={"p": 2.8, "b": 0.1},
        breakpoints=[-1, 1],
    )
    (crisis,) = bifurcations(f, "p", (2.89, 2.91), max_period=1, n_lists=4)
    curve = follow_bifurcation(crisis, f, "b", (-0.2, 0.2), solve_for="p")
    b, p = curve.parameters["b"], curve.parameters["p"]
    assert p == pytest.approx(3 - b, abs=ON_CURVE)
    assert abs(b[0]) < 0.01  # just beyond 0 what is left of the chaos lives long
    assert b[-1] == 0.2
    ceases = "the crisis ceases (no chaotic attractor with this edge changes beyond)"
    assert curve.end_reasons == (ceases, "end of range")
    assert (np.diff(b) > 0).all()


def test_a_merging_of_bands_deep_in_a_window_is_followed_through_the_range():
    # f^25(c) falls on an orbit of period 8: 1e-5 of a parameter farther its slope is another.
    f = PiecewiseMap(["r*x*(1 - x) + e"], (-0.6, 1.6), parameters={"r": 3.9, "e": 0.01})
    start = 3.9345235046469607
    images = list(accumulate(range(32), lambda x, _: start * x * (1 - x) + 0.01, initial=0.5))
    merging = Connection(TurningPoint(0.5), 1, 25, tuple(images[25:]))
    curve = follow(f, merging, "r", start, along="e", range=(0.0, 0.02), solve_for="r")
    r, e = curve.parameters["r"], curve.parameters["e"]
    assert curve.end_reasons == RANGE_ENDS
    # x = 1/2 - y / r turns it into A + y^2.
    assert r / 2 - r * r / 4 - r * e == pytest.approx(-1.9422022848778, abs=ON_CURVE)
    for between in (0.0001, 0.0042, 0.0103, 0.0171, 0.01999):  # rows are 1e-3 apart
        r = curve.at(e=between).value
        assert r / 2 - r * r / 4 - r * between == pytest.approx(-1.9422022848778, abs=ON_CURVE)


@pytest.mark.parametrize("until", [3.0, 3.6, 3.97, 0.0])
def test_points_are_kept_up_to_the_last_in_no_doubt_each_once(until):
    rows = [float(k) for k in range(9)]
    lost, kept, why = last_crisis(
        rows, lambda x: "doubt" if x > until else "", lambda a, b: 0.5 * (a + b)
    )
    assert lost == int(until) + 1
    assert why == "doubt"
    assert kept[:lost] == rows[:lost]
    assert until - 1 / 16 <= kept[-1] <= until
    assert len(kept) == lost + (until > lost - 1 + 1 / 16)


def test_looks_that_doubt_a_known_crisis_end_no_curve():
    assert last_crisis([0.0, 1.0, 2.0], lambda x: "doubt", lambda a, b: 0.5 * (a + b)) is None


# ---------------------------------------------------------------- arguments and files


def test_curve_passes_through_its_start_exactly():
    f = quadratic(0.75)
    curve = follow(f, Flip(1, (0.5,)), "a", 0.75, along="b", range=(-0.5, 0.9), solve_for="a")
    assert 0.0 in curve.parameters["b"]
    assert "flip" not in repr(curve)
    assert "Curve: bifurcation: any of period 1" in repr(curve)
    assert "a over b" in repr(curve)
    assert repr(curve).count("end of range") == 2


def test_arguments_are_checked():
    f, flip = quadratic(0.75), Flip(1, (0.5,))
    with pytest.raises(ValueError, match="'r' is not a parameter"):
        follow(f, flip, "a", 0.75, along="r", range=(0, 1), solve_for="a")
    with pytest.raises(ValueError, match="two different parameters"):
        follow(f, flip, "a", 0.75, along="a", range=(0, 1), solve_for="a")
    with pytest.raises(ValueError, match="lo < hi"):
        follow(f, flip, "a", 0.75, along="b", range=(1, 0), solve_for="a")
    with pytest.raises(ValueError, match="does not contain b = 0"):
        follow(f, flip, "a", 0.75, along="b", range=(0.5, 1), solve_for="a")
    with pytest.raises(ValueError, match="no such bifurcation near"):
        follow(f, flip, "a", 9.0, along="b", range=(-0.5, 0.5), solve_for="a")
    curve = follow(f, flip, "a", 0.75, along="b", range=(-0.5, 0.5), solve_for="a")
    with pytest.raises(ValueError, match=r"give its value as at\(b="):
        curve.at(a=0.75, b=0.0)
    for b in (0.7, 1e300):
        with pytest.raises(
            ValueError, match=rf"b = {re.escape(format(b, 'g'))} is outside the curve"
        ):
            curve.at(b=b)
    with pytest.raises(ValueError, match=r"b = 'spam' .* is not a real number"):
        curve.at(b="spam")
    with pytest.raises(ValueError, match=r"near = \(0, 1\) .* is not a real number"):
        curve.at(b=0.1, near=(0, 1))


def test_curve_and_its_loaded_copy_are_the_same(tmp_path):
    from stickslip.results.files import load

    f = quadratic(0.75)
    curve = follow(f, Flip(1, (0.5,)), "a", 0.75, along="b", range=(-0.5, 0.9), solve_for="a")
    curve.save(tmp_path / "flip.json")
    copy = load(tmp_path / "flip.json", f)
    assert np.array_equal(copy.parameters["a"], curve.parameters["a"])
    assert copy.problem.conditions == curve.problem.conditions
    assert copy.at(b=0.3).value == curve.at(b=0.3).value
    alone = load(tmp_path / "flip.json")
    with pytest.raises(ValueError, match="without its system"):
        alone.at(b=0.3)


def test_logistic_map_has_one_parameter_only():
    with pytest.raises(ValueError, match="'s' is not a parameter"):
        follow(logistic(3.0), Flip(1, (2 / 3,)), "r", 3.0, along="r", range=(2, 4), solve_for="s")
