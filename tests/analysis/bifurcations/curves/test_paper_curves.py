"""Two-parameter curves of the paper's systems, against solutions by independent routes.

The curves follow borders by labels and solve by secants from point to point. Here each value is
found again by Brent's method from complete tables, plain bisection and plain root finding.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.sizes import slow

from stickslip import examples
from stickslip.analysis.bifurcations.conditions.conditions import Collision, Connection, Flip, Fold
from stickslip.analysis.bifurcations.conditions.locate import solve
from stickslip.analysis.bifurcations.curves.breakpoint_curves import follow_breakpoint
from stickslip.analysis.bifurcations.curves.curves import follow_bifurcation
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.derived import WindowMap
from stickslip.mechanics.eventmap.event_map import EventMap

SAME = 1e-12  # of parameters, between the two routes
V_STAR = 0.036975923520307
WINDOW = (0.379, 0.390)
ULP = 4 * np.finfo(float).eps

pytestmark = pytest.mark.paper


@pytest.fixture(scope="module")
def coulomb():
    return EventMap(examples.coulomb())


@pytest.fixture(scope="module")
def grazing(coulomb):
    """The orbit of period 4 on the jump at which block 2 grazes."""
    (b,) = [b for b in breakpoints(coulomb) if abs(b.d - 0.279) < 1e-3]
    return Collision(4, TrackedDiscontinuity.of(b), -1)


@pytest.fixture(scope="module")
def law9():
    return EventMap(examples.law9())


@pytest.fixture(scope="module")
def corner(law9):
    (b,) = breakpoints(WindowMap(law9, WINDOW)).of_kind("corner")
    return TrackedDiscontinuity.of(b)


def follow(f, condition, parameter, value, *, along, range, solve_for):
    b = SimpleNamespace(condition=condition, parameter=parameter, value=value, kind="any")
    return follow_bifurcation(b, f, along, range, solve_for=solve_for)


def root(g, near, width):
    return brentq(g, near - width, near + width, xtol=1e-300, rtol=ULP)


# ---------------------------------------------------------------- Coulomb friction


def grazing_by_table(f, V):
    """f^4(c-) - c from a complete table of the map."""
    g = f.replace(V=V)
    (b,) = [b for b in breakpoints(g) if b.kind == "jump" and 0.25 < b.d < 0.295]
    x = b.left
    for _ in range(3):
        x = g(x)
    return x - b.d


def test_grazing_orbit_of_period_four(coulomb, grazing):
    found = solve(grazing, lambda V: coulomb.replace(V=V), 0.0368, 0.0371)
    assert found.value == pytest.approx(V_STAR, abs=1e-14)
    assert found.error < 1e-13
    # The slope of f^4 on the side that the orbit comes from, and on the other one.
    assert found.reading.multipliers == pytest.approx((0.734183885663, 1.483126930457), abs=1e-9)


@pytest.mark.parametrize(
    ("along", "ends", "others"),
    [
        ("alpha", (1.198, 1.204), (1.1993, 1.2027)),
        *slow(("beta", (1.296, 1.304), (1.2975, 1.3031))),
    ],
)
def test_grazing_over_alpha_and_beta(coulomb, grazing, along, ends, others):
    curve = follow(coulomb, grazing, "V", V_STAR, along=along, range=ends, solve_for="V")
    assert (curve.parameters[along][0], curve.parameters[along][-1]) == ends
    assert curve.end_reasons == ("end of range", "end of range")
    # Nothing happens to its type there: the multiplier stays between 0 and 1.
    assert not curve.bifurcations
    assert 0.68 < curve.multipliers.min() < curve.multipliers.max() < 0.78
    for value in (*ends, *others):
        point = curve.at(**{along: value})
        f = coulomb.replace(**{along: value})
        exact = root(lambda V, f=f: grazing_by_table(f, V), point.value, 1e-7)
        assert point.value == pytest.approx(exact, abs=SAME)
        assert point.error < SAME
    # The points of the curve are as good as those solved for one by one.
    k = len(curve.points) // 3
    there = curve.at(**{along: curve.parameters[along][k]})
    assert there.value == pytest.approx(curve.parameters["V"][k], abs=SAME)


def test_grazing_orbit_also_folds_far_from_the_papers_parameters(coulomb, grazing):
    over_alpha = follow(
        coulomb, grazing, "V", V_STAR, along="alpha", range=(1.0, 1.21), solve_for="V"
    )
    over_v = follow(
        coulomb, grazing, "V", V_STAR, along="V", range=(0.03, 0.038), solve_for="alpha"
    )
    (first,), (second,) = over_alpha.bifurcations, over_v.bifurcations
    assert first.kind == second.kind == "multiplier 1"
    for name in ("alpha", "V"):
        assert first.parameters[name] == pytest.approx(second.parameters[name], abs=1e-10)
    assert first.parameters["alpha"] == pytest.approx(1.041922285651, abs=1e-10)


def test_the_jump_splits_and_ends_the_curve(coulomb, grazing):
    over_alpha = follow(
        coulomb, grazing, "V", V_STAR, along="alpha", range=(1.19, 1.5), solve_for="V"
    )
    over_v = follow(
        coulomb, grazing, "V", V_STAR, along="V", range=(0.0365, 0.05), solve_for="alpha"
    )
    ends = [curve.bifurcations[-1] for curve in (over_alpha, over_v)]
    assert [end.kind for end in ends] == ["end of border", "end of border"]
    assert "splits: a new branch comes up on its left" in over_alpha.end_reasons[1]
    for name in ("alpha", "V"):
        assert ends[0].parameters[name] == pytest.approx(ends[1].parameters[name], abs=1e-10)
    # Beyond, complete tables show one more break there.
    values = ends[0].parameters
    for shift, expected in ((-1e-6, 1), (1e-6, 2)):
        f = coulomb.replace(V=values["V"], alpha=values["alpha"] + shift)
        assert sum(0.27 < b.d < 0.29 for b in breakpoints(f)) == expected


def test_the_jump_is_smoothed_out_at_the_other_end(coulomb, grazing):
    curve = follow(
        coulomb, grazing, "V", V_STAR, along="V", range=(0.02, 0.0375), solve_for="alpha"
    )
    # On its way the curve turns back: V has a minimum.
    assert curve.parameters["V"].min() < 0.0248
    end = curve.bifurcations[0]
    assert end.kind == "kind of border"
    assert curve.end_reasons[0] == end.what
    V, alpha = end.parameters["V"], end.parameters["alpha"]
    assert (V, alpha) == pytest.approx((0.02554376574, 0.8593243268), abs=1e-9)
    # Complete tables agree: a jump on one side, a harmless change of itinerary on the other
    # (beside which the jump lives on for a while, between branches of one itinerary).
    for shift, kind in ((2e-6, "smooth"), (-2e-6, "jump")):
        found = breakpoints(coulomb.replace(V=V + shift, alpha=alpha - 7.7 * shift))
        near = [b for b in found if abs(b.d - end.points[0]) < 1e-4]
        (b,) = [b for b in near if b.left_label != b.right_label]
        assert b.kind == kind


def test_line_of_the_jump(coulomb, grazing):
    curve = follow_breakpoint(grazing.border, coulomb, "V", (0.0366, 0.0372))
    assert (curve.values[0], curve.values[-1]) == (0.0366, 0.0372)
    for V in (0.0366, 0.03687, 0.0372):
        (b,) = [b for b in breakpoints(coulomb.replace(V=V)) if 0.25 < b.d < 0.295]
        assert curve.at(V=V).d == pytest.approx(b.d, abs=1e-14)
    # S4 meets it at V*.
    point = solve(grazing, lambda V: coulomb.replace(V=V), 0.0368, 0.0371)
    assert curve.at(V=point.value).d == pytest.approx(point.reading.points[0], abs=1e-14)


# ---------------------------------------------------------------- law (9)


def fixed_point(f, low, high):
    return brentq(lambda x: f(x) - x, low, high, xtol=1e-300, rtol=ULP)


def corner_by_bisection(f, low, high):
    """Last point of the left branch, first one of the right, by nothing but labels."""
    label = f.evaluate(low).label
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if f.evaluate(middle).label == label else (low, middle)
    return low, high


def test_flip_over_belt_velocity(law9):
    flip = Flip(1, (0.38235,))
    start = solve(flip, lambda a: law9.replace(alpha=a), 1.2085, 1.211)
    assert start.value == pytest.approx(1.209859795641, abs=1e-11)
    curve = follow(
        law9, flip, "alpha", start.value, along="V", range=(0.291, 0.299), solve_for="alpha"
    )
    assert curve.end_reasons == ("end of range", "end of range")
    # Subcritical all along.
    assert not curve.bifurcations
    for V in (0.291, 0.2977):
        point = curve.at(V=V)
        f = law9.replace(V=V)
        x = point.points[0]

        def multiplier(alpha, f=f, x=x):
            g = f.replace(alpha=alpha)
            return g.derivative(fixed_point(g, x - 1e-5, x + 1e-5)) + 1

        assert point.value == pytest.approx(root(multiplier, point.value, 1e-7), abs=SAME)


def test_fold_over_belt_velocity(law9):
    fold = Fold(1, (0.38035,))
    start = solve(fold, lambda a: law9.replace(alpha=a), 1.214, 1.216)
    assert start.value == pytest.approx(1.2151058900461, abs=1e-12)
    curve = follow(
        law9, fold, "alpha", start.value, along="V", range=(0.2942, 0.2958), solve_for="alpha"
    )
    assert curve.end_reasons == ("end of range", "end of range")
    for V in (0.2942, 0.29571):
        point = curve.at(V=V)
        f = law9.replace(V=V)
        x = point.points[0]

        def least(alpha, f=f, x=x):
            g = f.replace(alpha=alpha)
            steep = brentq(lambda y: g.derivative(y) - 1, x - 1e-5, x + 1e-5, xtol=1e-300, rtol=ULP)
            return g(steep) - steep

        assert point.value == pytest.approx(root(least, point.value, 1e-7), abs=SAME)


@pytest.mark.parametrize(("period", "value"), [(1, 1.218624503830), (2, 1.209121691649)])
def test_cusps_on_the_diagonal_over_belt_velocity(law9, corner, period, value):
    cusp = Collision(period, corner, -1)
    start = solve(cusp, lambda a: law9.replace(alpha=a), value - 5e-4, value + 5e-4)
    assert start.value == pytest.approx(value, abs=1e-11)
    curve = follow(
        law9, cusp, "alpha", start.value, along="V", range=(0.291, 0.299), solve_for="alpha"
    )
    assert curve.end_reasons == ("end of range", "end of range")
    point = curve.at(V=0.2967)
    f = law9.replace(V=0.2967)
    c = point.points[0]

    def above(alpha):
        g = f.replace(alpha=alpha)
        last, _ = corner_by_bisection(g, c - 1e-5, c + 1e-5)
        return g.iterate(last, period)[-1] - last

    # Bisected labels and values beside the corner: a few roundings, stretched by the slopes.
    assert point.value == pytest.approx(root(above, point.value, 1e-7), abs=1e-11)


def test_cusp_of_the_second_iterate_changes_its_type_once(law9, corner):
    curve = follow(
        law9, Collision(2, corner, -1), "alpha", 1.209121691649,
        along="V", range=(0.291, 0.299), solve_for="alpha",
    )  # fmt: skip
    (mark,) = curve.bifurcations
    # Below, the orbit of period 2 on the left of the corner is born stable.
    assert mark.kind == "multiplier -1"
    assert mark.parameters["V"] == pytest.approx(0.2911569224348, abs=1e-9)
    f = law9.replace(**mark.parameters)
    c = mark.points[0]
    last, _ = corner_by_bisection(f, c - 1e-5, c + 1e-5)
    slopes = f.derivative(last - 1e-9), f.derivative(f(last))
    assert slopes[0] * slopes[1] == pytest.approx(-1, abs=1e-4)


def test_crisis_over_belt_velocity(law9, corner):
    crisis = Connection(corner, -1, 2, (0.38044,))
    curve = follow(
        law9, crisis, "alpha", 1.215285651451, along="V", range=(0.2942, 0.2958), solve_for="alpha"
    )
    assert curve.end_reasons == ("end of range", "end of range")
    point = curve.at(V=0.2955)
    f = law9.replace(V=0.2955)
    u, c = point.points[0], point.condition.critical.x

    def above(alpha):
        g = f.replace(alpha=alpha)
        last, _ = corner_by_bisection(g, c - 1e-5, c + 1e-5)
        return g.iterate(last, 2)[-1] - fixed_point(g, u - 1e-6, u + 1e-6)

    assert point.value == pytest.approx(root(above, point.value, 1e-8), abs=1e-11)


def test_fold_ends_where_the_orbit_on_the_corner_folds(law9, corner):
    # One point of codimension two, met along two different curves.
    fold = follow(
        law9, Fold(1, (0.38035,)), "alpha", 1.2151058900461,
        along="V", range=(0.285, 0.2955), solve_for="alpha",
    )  # fmt: skip
    cusp = follow(
        law9, Collision(1, corner, -1), "alpha", 1.218624503830,
        along="V", range=(0.2865, 0.2955), solve_for="alpha",
    )  # fmt: skip
    (end,) = fold.bifurcations
    (mark,) = cusp.bifurcations
    assert (end.kind, mark.kind) == ("breakpoint", "multiplier 1")
    assert fold.end_reasons[0] == end.what
    for name in ("alpha", "V"):
        assert end.parameters[name] == pytest.approx(mark.parameters[name], abs=1e-10)
