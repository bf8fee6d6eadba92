"""Bifurcations located along one parameter, compared with closed forms and many digits."""

import math

import mpmath
import numpy as np
import pytest
from tests.analysis.known_maps import border_collision, logistic, square_root, tent

from stickslip.analysis.bifurcations.conditions.conditions import (
    Collision,
    Connection,
    Flip,
    Fold,
    Reading,
)
from stickslip.analysis.bifurcations.conditions.locate import Readings, solve, solve_near
from stickslip.analysis.bifurcations.conditions.orbit_paths import where_slope_is
from stickslip.analysis.branches.along.tracked import (
    ConditionLost,
    TrackedDiscontinuity,
    TurningPoint,
)
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits

SHARP = 1e-13  # of parameters of order 1, from test functions of slope of order 1
CENTRE = TurningPoint(0.5)


def along(f, name):
    return lambda value: f.replace(**{name: value})


def logistic_at(r):
    return logistic(4.0).replace(r=r)


def wide_logistic(r=4.0):
    """The logistic map on more than [0, 1], so that r may exceed 4."""
    return PiecewiseMap(lambda x, r: r * x * (1 - x), (-1.0, 2.0), parameters={"r": r})


def the_break(f):
    (b,) = breakpoints(f)
    return TrackedDiscontinuity.of(b)


def assert_located(found, exact, tolerance=SHARP):
    assert found.quality == "located"
    assert found.value == pytest.approx(float(exact), abs=tolerance)
    assert abs(found.value - float(exact)) <= 4 * found.error
    assert found.error < tolerance


def orbit_of(f, p, **at):
    (orbit,) = [o for o in periodic_orbits(f.replace(**at), p) if o.period == p and o.stable]
    return tuple(orbit.points.tolist())


# ---------------------------------------------------------------- logistic map


def test_first_flips_of_the_logistic_map():
    f = logistic()
    assert_located(solve(Flip(1, orbit_of(f, 1, r=2.9)), logistic_at, 2.5, 3.4), 3)
    second = solve(Flip(2, orbit_of(f, 2, r=3.3)), logistic_at, 3.2, 3.5)
    assert_located(second, 1 + math.sqrt(6))
    # Bailey, Exp. Math. 2 (1993) 307: the third one is a root of a polynomial of degree 12.
    third = solve(Flip(4, orbit_of(f, 4, r=3.5)), logistic_at, 3.5, 3.56)
    assert_located(third, "3.544090359551922853615965986604804540583", 1e-12)


@pytest.mark.parametrize("wanted", [1.0, -1.0])
def test_a_slope_is_found_where_it_bends_within_a_billionth(wanted):
    """A step by the mean bend over much more than that leads far off, and is taken back."""
    width, steep = 1e-9, 1e3
    f = PiecewiseMap(
        lambda x: 0.3 + steep * width * np.logaddexp((x - 0.3) / width, (0.3 - x) / width),
        (-1, 2),
        derivative=lambda x: steep * np.tanh((x - 0.3) / width),
    )
    path, curvature, _ = where_slope_is(wanted, f, 1, 0.3 + 0.3 * width)
    assert path.points[0] - 0.3 == pytest.approx(width * math.atanh(wanted / steep), abs=1e-16)
    assert curvature == pytest.approx(steep / width, rel=1e-2)


def test_fold_of_period_three():
    found = solve(Fold(3, (0.514, 0.955, 0.166)), logistic_at, 3.82, 3.84)
    assert_located(found, 1 + math.sqrt(8))
    assert found.reading.multipliers == pytest.approx((1.0,), abs=1e-5)
    points = np.array(found.reading.points)
    assert logistic_at(found.value)(points) == pytest.approx(np.roll(points, -1), abs=1e-7)


def test_superstable_orbit_is_a_collision_with_a_turning_point():
    found = solve(Collision(2, CENTRE, 1), logistic_at, 3.1, 3.4)
    assert_located(found, 1 + math.sqrt(5))
    assert found.reading.multipliers == (0, 0)


def test_band_merging_of_the_logistic_map():
    # f^3(1/2) is the unstable fixed point: a cubic, Misiurewicz.
    r = mpmath.findroot(lambda r: r**3 - 2 * r**2 - 4 * r - 8, 3.7)
    found = solve(Connection(CENTRE, 1, 3, (1 - 1 / 3.7,)), logistic_at, 3.6, 3.75)
    assert_located(found, r)


def test_boundary_crisis_of_the_logistic_map():
    found = solve(Connection(CENTRE, 1, 2, (0.0,)), wide_logistic, 3.9, 4.1)
    assert_located(found, 4)


def test_interior_crisis_at_the_end_of_the_period_three_window():
    # The attractor's band around 1/2 reaches the unstable orbit that was born with it.
    f = logistic(3.85)
    unstable = [o for o in periodic_orbits(f, 3) if o.period == 3 and not o.stable]
    (orbit,) = [o for o in unstable if o.multiplier > 0 and abs(o.multiplier) < 10]
    nearest = int(np.argmin(np.abs(orbit.points - 0.5)))
    points = tuple(np.roll(orbit.points, -nearest).tolist())
    found = solve(Connection(CENTRE, 1, 6, points), logistic_at, 3.855, 3.858)
    mpmath.mp.dps = 40

    def equations(r, u):
        def image(x, n):
            for _ in range(n):
                x = r * x * (1 - x)
            return x

        return image(u, 3) - u, image(mpmath.mpf(1) / 2, 6) - u

    exact = mpmath.findroot(equations, (mpmath.mpf("3.8568"), mpmath.mpf(points[0])))
    assert_located(found, exact[0])
    assert found.value == pytest.approx(3.8568, abs=1e-4)


# ---------------------------------------------------------------- piecewise maps


def test_band_merging_of_the_tent_map():
    f = tent(1.6)
    found = solve(Connection(the_break(f), -1, 3, (1.6 / 2.6,)), along(f, "slope"), 1.2, 1.6)
    assert_located(found, math.sqrt(2))


def test_border_collisions_of_the_normal_form():
    f = border_collision(a=0.5, b=-2.0, mu=0.3)
    border = the_break(f)
    for side in (-1, 1):
        found = solve(Collision(1, border, side), along(f, "mu"), -0.2, 0.3)
        assert_located(found, 0)
        assert found.reading.multipliers == pytest.approx((0.5, -2.0))
    # With a jump the two sides collide one after the other.
    g = border_collision(a=0.5, b=-2.0, mu=0.3, jump=0.1)
    found = solve(Collision(1, the_break(g), 1), along(g, "mu"), -0.25, 0.3)
    assert_located(found, -0.1)
    # Period 2: f(f(0)) = b mu + mu vanishes for all mu at b = -1 only.
    h = border_collision(a=0.5, b=-0.9, mu=0.3)
    found = solve(Collision(2, the_break(h), -1), along(h, "b"), -1.2, -0.8)
    assert_located(found, -1, 1e-12)
    assert found.reading.multipliers == pytest.approx((-0.5, 1.0))


def test_grazing_of_the_square_root_map():
    f = square_root(0.2, 0.1)
    found = solve(Collision(1, the_break(f), -1), along(f, "mu"), -0.1, 0.1)
    assert found.value == pytest.approx(0, abs=1e-12)
    assert found.reading.multipliers == (pytest.approx(0.2), -math.inf)


def test_orbit_that_enters_a_gap():
    f = PiecewiseMap(
        lambda x, a: np.where(x <= 0.5, a * x * (1.5 - x), np.nan), (0, 1), parameters={"a": 1.0},
    )  # fmt: skip
    border = the_break(f)
    assert border.kind == "edge"
    found = solve(Collision(1, border, -1), along(f, "a"), 0.8, 1.2)
    # a (1.5 - 1/2) / 2 = 1/2
    assert_located(found, 1)
    assert math.isnan(found.reading.multipliers[1])
    with pytest.raises(ConditionLost, match="has no value on that side"):
        Collision(1, border, 1).at(f)


# ---------------------------------------------------------------- how it is solved


def test_change_of_sign_without_a_zero_is_not_called_located():
    # f(f(c-)) leaps over c where f(c-) passes the second jump.
    def steps(x, a):
        return np.where(x < 0.5, 0.2 + a, np.where(x < 0.7, 0.1, 0.9))

    f = PiecewiseMap(steps, (0, 1), parameters={"a": 0.45}, breakpoints=[0.5, 0.7])
    border = TrackedDiscontinuity.of(breakpoints(f)[0])
    found = solve(Collision(2, border, -1), along(f, "a"), 0.4, 0.6)
    assert found.quality == "failed"
    assert found.value == pytest.approx(0.5)


@pytest.mark.parametrize("every", [3, 5])
def test_a_change_of_sign_there_and_back_within_rounding_is_not_called_located(every):
    class Flickers:  # as at a break, where a label is an accident
        def at(self, a):
            here = abs(a - 0.5) < 1e-13 and round((a - 0.5) / np.spacing(0.5)) % every == 0
            value = 0.01 + 0.1 * (0.5 - a) if a < 0.5 - 1e-13 or here else -0.2
            return Reading(value, 1e-15, (0.0,), (1.0,), self, (1,), (0.0,))

    assert solve(Flickers(), lambda a: a, 0.4, 0.6).quality == "failed"


def test_solve_near_finds_the_same_as_solve_between():
    f = logistic()
    flip = Flip(2, orbit_of(f, 2, r=3.3))
    for guess, step in ((3.4, 0.01), (3.45, 0.001), (3.5, 0.1), (1 + math.sqrt(6), 1e-3)):
        assert_located(solve_near(flip, logistic_at, guess, step=step), 1 + math.sqrt(6))
    assert_located(solve_near(flip, logistic_at, 3.44, step=0.01, slope=-5.0), 1 + math.sqrt(6))


@pytest.mark.parametrize("seed", range(5))
def test_a_slope_that_noise_hides_is_taken_further_away(seed):
    rng = np.random.default_rng(seed)

    class Noisy:  # as the multiplier of an orbit on a narrow branch
        def at(self, a):
            value = 1e9 * (a - 0.5) + rng.uniform(-1e-3, 1e-3)
            return Reading(value, 1e-3, (0.0,), (1.0,), self, (1,), (0.0,))

    found = solve_near(Noisy(), lambda a: a, 0.5 + 1e-11, step=1e-10)
    assert found.slope == pytest.approx(1e9, rel=0.1)
    assert abs(found.value - 0.5) <= found.error < 3e-12


def test_solve_near_stays_within_its_bounds():
    f = logistic()
    asked = []

    def at(r):
        asked.append(r)
        return logistic_at(r)

    flip = Flip(2, orbit_of(f, 2, r=3.3))
    with pytest.raises(ConditionLost, match="no zero near"):
        solve_near(flip, at, 3.3, step=0.1, within=(3.25, 3.35))
    assert min(asked) >= 3.25
    assert max(asked) <= 3.35


def test_reading_far_away_is_reached_in_steps():
    # Newton's method alone does not get from r = 3.1 to 3.9 along the unstable orbit.
    f = logistic()
    readings = Readings(Flip(2, orbit_of(f, 2, r=3.1)), logistic_at)
    readings(3.1)
    value = readings(3.9)
    assert value == pytest.approx(1 + 4 + 2 * 3.9 - 3.9**2, abs=1e-11)


def test_lost_conditions_say_so():
    f = logistic(3.5)
    with pytest.raises(ConditionLost, match=r"slope of f\^3 is not 1"):
        Fold(3, (0.3, 0.7, 0.7)).at(f.replace(r=0.5))
    with pytest.raises(ConditionLost, match="period 3"):
        Flip(3, (0.5, 0.9, 0.2)).at(f.replace(r=2.0))
    with pytest.raises(ConditionLost, match="has left the domain or lies in a gap"):
        Collision(3, TurningPoint(0.5), 1).at(PiecewiseMap(lambda x: 5 * x * (1 - x), (0, 1)))
    with pytest.raises(ValueError, match="a zero between them is not certain"):
        solve(Flip(1, (0.6,)), logistic_at, 2.5, 2.9)

    # A parameter that the map does not allow is a lost condition as well.
    def refused(_):
        raise ValueError("r is too large")

    with pytest.raises(ConditionLost, match="r is too large"):
        solve_near(Flip(1, (0.6,)), refused, 2.9, step=0.1)
