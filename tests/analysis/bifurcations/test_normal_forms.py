"""Coefficients of folds and flips against closed forms, and the orbits that they foretell."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

import stickslip as ss
from stickslip.analysis.bifurcations.normal_forms import (
    CubicCoefficient,
    flip_coefficient,
    fold_coefficient,
)
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits

EXACT = 1e-11  # relative, where slopes are exact: what differences of them leave


def _cubic(c2, c3):
    """-x + c2 x^2 + c3 x^3 around 0, with its exact slope."""
    return PiecewiseMap(
        lambda x, c2, c3: x * (-1 + x * (c2 + c3 * x)),
        (-1, 1),
        parameters={"c2": c2, "c3": c3},
        derivative=lambda x, c2, c3: -1 + x * (2 * c2 + 3 * c3 * x),
    )


@given(c2=st.floats(-3, 3), c3=st.floats(-10, 10))
def test_flip_of_a_cubic(c2, c3):
    found = flip_coefficient(_cubic(c2, c3), [0.0])
    exact = c2**2 + c3  # (g'')^2 / 4 + g''' / 6
    assert abs(found.value - exact) <= max(found.error, EXACT)
    assert found.error < 1e-9
    if abs(exact) > 1e-6:
        assert found.criticality == ("super" if exact > 0 else "sub")


def test_a_sign_within_the_error_is_open():
    assert CubicCoefficient(1e-3, 2e-3).criticality is None
    assert CubicCoefficient(math.nan, math.inf).criticality is None


def test_without_neighbours_on_the_branch_nothing_is_known():
    f = PiecewiseMap(lambda x: -x, (-1, 1), breakpoints=[0.0, np.nextafter(0.0, 1)])
    assert flip_coefficient(f, [0.0]).criticality is None


@pytest.mark.parametrize(("r", "p"), [(3.0, 1), (1 + math.sqrt(6), 2)])
def test_logistic_flips_are_supercritical(r, p):
    f = examples.logistic(r)
    orbit = next(o for o in periodic_orbits(f, p) if o.period == p and abs(o.multiplier + 1) < 1e-6)

    def power(x):
        for _ in range(p):
            x = r * x * (1 - x)
        return x

    for start in range(p):
        points = np.roll(orbit.points, -start)
        found = flip_coefficient(f, points)
        second, third = (mpmath.diff(power, points[0], n) for n in (2, 3))
        exact = float(second**2 / 4 + third / 6)
        assert found.value == pytest.approx(exact, rel=EXACT)
        assert found.criticality == "super"


def _doubling_cubic(c):
    return PiecewiseMap(lambda x, m: -(1 + m) * x + c * x**3, (-0.3, 0.3), parameters={"m": 0.0})


def test_the_double_is_on_the_side_that_the_flip_foretells():
    # -(1 + m) x + c x^3: doubled points at x^2 = m / c.
    for c, there in ((2.0, 0.01), (-2.0, -0.01)):
        f = _doubling_cubic(c)
        assert flip_coefficient(f, [0.0]).criticality == ("super" if c > 0 else "sub")
        assert len(periodic_orbits(f.replace(m=there), period=2)) == 1
        assert len(periodic_orbits(f.replace(m=-there), period=2)) == 0


def test_the_period_3_fold_of_the_logistic_map():
    r = 1 + math.sqrt(8)
    f = examples.logistic(r)
    # The smallest point solves a cubic (Gordon, Math. Mag. 69, 118, 1996); polished here.
    x = 0.159928818446
    for _ in range(60):
        points = f.iterate(x, 3)[:3]
        slope = float(np.prod(f.derivative(points)))
        bend = fold_coefficient(f, points, "r").curvature
        x -= (slope - 1) / bend
    found = fold_coefficient(f, points, "r")

    def power(x, r):
        for _ in range(3):
            x = r * x * (1 - x)
        return x

    assert slope == pytest.approx(1, abs=1e-12)
    assert found.curvature == pytest.approx(
        float(mpmath.diff(lambda x: power(x, r), x, 2)), rel=1e-10
    )
    assert found.speed == pytest.approx(float(mpmath.diff(lambda r: power(x, r), r)), rel=1e-10)
    assert found.speed * found.curvature < 0 < abs(found.curvature) - found.error
    for shift, number in ((1e-6, 2), (-1e-6, 0)):
        orbits = periodic_orbits(examples.logistic(r + shift), period=3)
        assert len(orbits) == number
        for orbit in orbits:
            away = np.abs(orbit.points - x).min()
            opened = math.sqrt(2 * abs(found.speed / found.curvature * shift))
            assert away == pytest.approx(opened, rel=1e-2)


@pytest.mark.paper
def test_the_flip_of_law_9_is_subcritical():
    f = WindowMap(ss.event_map(ss.examples.law9(alpha=1.209859795641)), (0.379, 0.390))
    (orbit,) = ss.periodic_orbits(f, period=1)
    assert orbit.multiplier == pytest.approx(-1, abs=1e-8)
    found = flip_coefficient(f, orbit.points)
    assert found.criticality == "sub"
    assert found.value == pytest.approx(-6607.5419, abs=1e-3)
    assert found.error < 1e-3


@pytest.mark.paper
def test_the_fold_of_law_9_opens_towards_larger_alpha():
    f = WindowMap(ss.event_map(ss.examples.law9(alpha=1.2151058900461)), (0.379, 0.390))
    fold = fold_coefficient(f, [0.3803378423], "alpha")
    assert fold.speed * fold.curvature < 0 < abs(fold.curvature) - fold.error
