"""Steps that provably skip no root: against polynomials whose roots are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from stickslip.numerics.roots import (
    EPSILON,
    all_but_touches,
    contact_time,
    grazing_time,
    leaving_step,
    safe_step,
)

pytestmark = pytest.mark.kernel

ROOT = st.floats(0.05, 3.0)
GAP = st.floats(0.0, 1.0)
CAP = st.floats(0.01, 4.0)
COARSE = st.integers(-64, 64).map(lambda n: n / 32)
# The step is worked out in a dozen roundings, and its root may be ill conditioned.
ROUNDING = 1e-7


def bounds(g: Polynomial, cap: float) -> tuple[float, float]:
    """Largest |g''| and |g'''| on [0, cap], from the coefficients."""
    return tuple(
        float(sum(abs(c) * cap**k for k, c in enumerate(g.deriv(order).coef))) for order in (2, 3)
    )


def step_of(g: Polynomial, cap: float) -> float:
    return safe_step(g(0.0), g.deriv()(0.0), g.deriv(2)(0.0), *bounds(g, cap), cap)


@given(first=ROOT, gap=GAP, third=ROOT, scale=st.floats(0.1, 10.0), cap=CAP)
def test_a_safe_step_stays_before_the_first_root(first, gap, third, scale, cap):
    g = -scale * Polynomial.fromroots([-third, first, first + gap, first + gap + third])
    step = step_of(g, cap)
    assert 0.0 < step <= min(cap, first * (1.0 + ROUNDING))
    between = np.linspace(0.0, step, 33)[1:-1]
    assert np.all(g(between) > 0.0) or step > 0.999 * first


@given(slope=COARSE, curvature=COARSE, value=st.floats(0.01, 2), cap=CAP)
def test_a_safe_step_is_exact_for_a_parabola(slope, curvature, value, cap):
    # With g''' = 0 the bound is the signal: the step is its first root, or the cap.
    step = safe_step(value, slope, curvature, abs(curvature), 0.0, cap)
    ahead = [
        r.real
        for r in np.roots(np.trim_zeros([curvature / 2, slope, value], "f"))
        if r.real > 0 and r.imag == 0
    ]
    if curvature < 0.0:
        assert step == pytest.approx(min([*ahead, cap]), rel=1e-6)
    else:
        assert all(step <= root * (1.0 + 1e-9) for root in ahead)


@given(first=ROOT, gap=st.floats(0.01, 1.0), third=ROOT)
def test_safe_steps_converge_to_a_simple_root_like_newton(first, gap, third):
    g = Polynomial.fromroots([-third, first, first + gap])
    g = g if g(0.0) > 0 else -g
    t, cap, n = 0.0, 2.0 * first + 1.0, 0
    bound_2, bound_3 = bounds(g, cap)
    while g(t) > 1e-13 * abs(g(0.0)) and n < 200:
        step = safe_step(g(t), g.deriv()(t), g.deriv(2)(t), bound_2, bound_3, cap - t)
        assert step > 0.0
        t, n = t + step, n + 1
    assert t == pytest.approx(first, rel=1e-9)
    assert n < 60


def test_a_safe_step_without_downward_bend_is_newtons_or_the_cap():
    assert safe_step(1.0, 0.5, 3.0, 10.0, 1.0, 2.0) == 2.0
    assert safe_step(1.0, -0.5, 3.0, 10.0, 1.0, 3.0) == 2.0
    assert safe_step(1.0, -0.25, 3.0, 10.0, 1.0, 3.0) == 3.0


@given(
    slope=st.just(0.0) | st.floats(1e-100, 2.0),  # smaller ones have no square
    bend=st.just(0.0) | st.floats(1e-100, 3.0) | st.floats(-3.0, -1e-100),
    rest=st.floats(-3.0, 3.0),
    cap=CAP,
)
def test_a_leaving_step_ends_before_the_next_root(slope, bend, rest, cap):
    # g = slope t + bend t^2 + rest t^3 starts at zero
    bound_3 = 6.0 * abs(rest) + 1e-3
    step = leaving_step(slope, 2.0 * bend, bound_3, cap)
    if step == 0.0:
        assert slope == 0.0
        assert bend <= 0.0
        return
    assert step <= cap
    # g / t is decided by subtraction, so next to its root rounding may win
    share = np.linspace(0.0, 1.0, 17)[1:] * step
    assert np.all(slope + bend * share + rest * share**2 >= -1e-300)


def test_a_signal_that_does_not_leave_zero_has_no_leaving_step():
    assert leaving_step(-1e-3, 5.0, 1.0, 1.0) == 0.0
    assert leaving_step(0.0, 0.0, 1.0, 1.0) == 0.0
    assert leaving_step(0.0, -1.0, 1.0, 1.0) == 0.0


def test_a_double_root_at_the_start_is_left_like_a_simple_one():
    # g = t^2 - t^3: half of the way to the root at 1 (bound 6 on g''')
    assert leaving_step(0.0, 2.0, 6.0, 10.0) == pytest.approx(0.5)


def test_a_contact_is_the_first_root_of_the_parabola():
    # g = (h - 1e-4) (h - 1): value 1e-4, slope -(1 + 1e-4), second derivative 2
    assert contact_time(3.0, 1e-4, -1.0001, 2.0, 1e-16) == pytest.approx(3.0001, abs=1e-15)
    assert contact_time(1.0, 1e-9, -0.5, 0.0, 1e-16) == 1.0 + 2e-9


@pytest.mark.parametrize("depth", [-9e-17, 0.0, 9e-17])
def test_a_touch_within_rounding_is_at_the_minimum(depth):
    # g = depth + (h - 1e-8)^2: a root, if any, is up to 1e-8 early, where g' is not zero
    t = contact_time(0.0, depth + 1e-16, -2e-8, 2.0, 1e-16)
    assert t == pytest.approx(1e-8, rel=1e-15)


@pytest.mark.parametrize(("lowest", "touches"), [(2e-16, True), (-2e-16, True), (2e-15, False)])
def test_a_signal_that_all_but_touches_is_told_from_one_that_crosses(lowest, touches):
    # g = lowest + (h - 1e-8)^2
    assert all_but_touches(lowest + 1e-16, -2e-8, 2.0, 1e-15) == touches
    assert not all_but_touches(1e-16, -1.0, 2.0, 1e-15)
    assert not all_but_touches(1e-16, -1e-8, -2.0, 1e-15)


def test_contact_next_to_a_minimum_is_told_by_its_depth():
    # g = lowest + (h - 3)^2
    assert grazing_time(3.0, 2e-16, 2.0, 1e-16) == np.inf
    assert grazing_time(3.0, 5e-17, 2.0, 1e-16) == 3.0
    assert grazing_time(3.0, -5e-17, 2.0, 1e-16) == 3.0
    assert grazing_time(3.0, -1e-8, 2.0, 1e-16) == pytest.approx(3.0 - 1e-4, rel=1e-15)


def test_a_signal_that_rests_at_zero_is_in_contact_now():
    assert contact_time(1.0, 0.0, 0.0, 0.0, 1e-16) == 1.0


def test_epsilon_is_the_spacing_of_doubles_at_one():
    assert EPSILON == math.ulp(1.0)
