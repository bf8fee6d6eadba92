"""First contact of a polynomial with zero: crossings, touches, none; root at either end."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from stickslip.numerics.polynomial import (
    NO_ROOT,
    derivative_bounds,
    first_contact,
    jet,
    lowest_minimum,
    value,
    value_sharp,
)

pytestmark = pytest.mark.kernel

SLACK = 1e-15
ROOT = st.floats(0.05, 2.0)
# Multiples of 1/64: numpy.roots loses small roots next to coefficients like 1e-20.
COEFFICIENT = st.integers(-128, 128).map(lambda n: n / 64)
# An upward factor without real roots, so that signals are not just products of lines.
BUMP = Polynomial([1.3, -0.7, 0.8])


def signal(roots: list[float], at: float = 0.0) -> np.ndarray:
    """Coefficients of a polynomial with these roots, positive just after `at`."""
    g = Polynomial.fromroots(roots) * BUMP
    return np.array((g if g(at + 1e-9) > 0 else -g).coef)


@given(c=st.lists(COEFFICIENT, min_size=3, max_size=15), t=st.floats(0.0, 1.5))
def test_value_and_jet_are_those_of_exact_arithmetic(c, t):
    exact = [Fraction(x) for x in c]
    s = Fraction(t)
    sums = (
        sum(x * s**k for k, x in enumerate(exact)),
        sum(k * x * s ** (k - 1) for k, x in enumerate(exact) if k > 0),
        sum(k * (k - 1) * x * s ** (k - 2) for k, x in enumerate(exact) if k > 1),
    )
    scale = 1e-13 * max(1.0, t) ** len(c) * len(c) ** 2
    coefficients = np.array(c)
    assert value(coefficients, t) == pytest.approx(float(sums[0]), abs=scale)
    assert jet(coefficients, t) == pytest.approx([float(x) for x in sums], abs=10 * scale)


@given(c=st.lists(COEFFICIENT, min_size=4, max_size=15), h=st.floats(0.0, 1.5))
def test_bounds_of_derivatives_are_sums_of_sizes(c, h):
    sizes = Polynomial(np.abs(c))
    expected = [float(sizes.deriv(2)(h)), float(sizes.deriv(3)(h))]
    assert derivative_bounds(np.array(c), h) == pytest.approx(expected, rel=1e-13)


@given(root=st.floats(0.1, 0.9), data=st.data())
def test_a_contact_is_where_the_signal_vanishes_but_for_rounding(root, data):
    """Of a series as a step has it: coefficients that fall, a signal that falls through zero."""
    terms = data.draw(st.lists(COEFFICIENT, min_size=3, max_size=17))
    c = [0.0, -1.0, *(x * 0.15**k for k, x in enumerate(terms, 1))]
    c[0] = -sum(x * root**k for k, x in enumerate(c))
    slopes = [sum(k * x * t ** (k - 1) for k, x in enumerate(c) if k > 0) for t in (0.0, 0.5, 1.0)]
    assume(max(slopes) < -0.2)
    assume(c[0] > 0.0)
    t = first_contact(np.array(c), 1.0, False, 0.0)
    left = sum(Fraction(x) * Fraction(t) ** k for k, x in enumerate(c))
    assert abs(left) <= 2e-16 * sum(abs(x) for x in c)


@given(data=st.data(), t=st.floats(0.0, 0.5))
def test_a_value_as_a_sum_of_two_is_that_of_exact_arithmetic(data, t):
    """Rounded are the terms of degree 4 and more, and what the others leave out."""
    c = data.draw(st.lists(COEFFICIENT, min_size=4, max_size=15))
    low = [x * 2.0**-54 for x in data.draw(st.lists(COEFFICIENT, min_size=4, max_size=4))]
    s = Fraction(t)
    exact = sum(Fraction(x) * s**k for k, x in enumerate(c))
    exact += sum(Fraction(x) * s**k for k, x in enumerate(low))
    high, rest = value_sharp(np.array(c), np.array(low), t)
    assert high == high + rest
    rounded = sum(abs(x) * t**k for k, x in enumerate(c) if k >= 4)
    assert abs(Fraction(high) + Fraction(rest) - exact) <= 4e-16 * rounded + 1e-29


@given(first=ROOT, gaps=st.tuples(st.floats(0.02, 1), st.floats(0.02, 1)), share=st.floats(0.1, 3))
def test_the_first_of_several_crossings_is_found(first, gaps, share):
    roots = [first, first + gaps[0], first + gaps[0] + gaps[1]]
    h = share * first
    assume(abs(share - 1.0) > 1e-9)
    t = first_contact(signal(roots), h, False, SLACK)
    if share < 1.0:
        assert t == NO_ROOT
    else:
        assert t == pytest.approx(first, rel=1e-10)


@given(c=st.lists(COEFFICIENT, min_size=4, max_size=12), h=st.floats(0.1, 2.0))
def test_agreement_with_numpy_roots(c, h):
    c = np.array([abs(c[0]) + 1e-3, *c[1:]])
    roots = np.roots(np.trim_zeros(c[::-1], "f"))
    assume(np.all(np.abs(roots.imag[np.abs(roots.imag) > 0.0]) > 1e-5))  # no near touch
    real = np.sort(roots.real[roots.imag == 0.0])
    assume(np.all(np.diff(real) > 1e-4))
    assume(np.all(np.abs(real - h) > 1e-6))
    ahead = real[(real > 0.0) & (real < h)]
    t = first_contact(c, h, False, SLACK)
    if ahead.size == 0:
        assert t == NO_ROOT
    else:
        assert t == pytest.approx(ahead[0], rel=1e-8)


@given(touch=ROOT, later=st.floats(0.05, 1.0))
def test_a_touch_is_a_contact(touch, later):
    t = first_contact(signal([touch, touch, touch + later]), touch + later / 2, False, SLACK)
    # a double root is known to the square root of rounding
    assert t == pytest.approx(touch, abs=3e-7 * max(1.0, 1.0 / later))


@pytest.mark.parametrize("exponent", range(3, 14))
def test_next_to_a_touch_both_sides_are_told_apart(exponent):
    gap = 10.0**-exponent
    touching = np.array((Polynomial.fromroots([0.75, 0.75]) * BUMP).coef)
    above, below = touching.copy(), touching.copy()
    above[0] += gap
    below[0] -= gap
    assert first_contact(above, 2.0, False, SLACK) == NO_ROOT
    t = first_contact(below, 2.0, False, SLACK)
    left = [r.real for r in np.roots(below[::-1]) if abs(r.imag) < 1e-12 and r.real > 0]
    assert t == pytest.approx(0.75 - math.sqrt(gap / BUMP(0.75)), rel=2 * gap**0.5)
    assert t == pytest.approx(min(left), abs=1e-7)


@given(first=ROOT, multiplicity=st.sampled_from([1, 2]), share=st.floats(0.2, 2.0))
def test_a_root_at_the_start_is_divided_out(first, multiplicity, share):
    assume(abs(share - 1.0) > 1e-9)
    c = signal([0.0] * multiplicity + [first])
    assume(c[multiplicity] > 0.0)
    c[:multiplicity] = 0.0
    t = first_contact(c, share * first, True, SLACK)
    if share < 1.0:
        assert t == NO_ROOT
    else:
        assert t == pytest.approx(first, rel=1e-10)


@given(first=ROOT, power=st.sampled_from([1, 2]), exponent=st.integers(7, 120))
def test_however_slowly_a_signal_leaves_zero_its_next_root_is_found(first, power, exponent):
    c = signal([0.0, 0.0, 0.0, first])
    c[:3] = 0.0
    c[power] = 10.0**-exponent
    assert first_contact(c, 0.9 * first, True, SLACK) == NO_ROOT
    assert first_contact(c, 1.1 * first, True, SLACK) == pytest.approx(first, rel=1e-3)


def test_a_signal_that_starts_at_zero_and_falls_is_a_contact_at_once():
    assert first_contact(np.array([0.0, -0.1, 5.0, 0.0]), 1.0, True, SLACK) == 0.0
    assert first_contact(np.array([0.0, 0.0, -0.1, 5.0]), 1.0, True, SLACK) == 0.0


@given(end=ROOT, leaving=st.booleans())
def test_a_root_at_the_end_of_the_interval_counts(end, leaving):
    # exactly zero at the end: end (1 - t / end) = end - t, without rounding
    c = np.array([0.0, end, -1.0, 0.0]) if leaving else np.array([end, -1.0, 0.0, 0.0])
    assert first_contact(c, end, leaving, SLACK) == pytest.approx(end, rel=1e-15)
    before = end * (1.0 - 1e-9)
    assert first_contact(c, before, leaving, SLACK) == NO_ROOT


def test_two_roots_in_one_step_with_both_ends_positive():
    # Every search for changes of sign overlooks these.
    for gap in 10.0 ** -np.arange(1.0, 7.0):
        c = signal([0.4, 0.4 + gap])
        assert value(c, 0.0) > 0.0
        assert value(c, 1.0) > 0.0
        assert first_contact(c, 1.0, False, SLACK) == pytest.approx(0.4, abs=1e-8)


@given(low=st.floats(0.1, 0.9), height=st.floats(-1.0, 1.0), bend=st.floats(0.1, 4.0))
def test_the_minimum_inside_a_step(low, height, bend):
    g = Polynomial([height, 0.0, bend, 0.05])(Polynomial([-low, 1.0]))
    assert lowest_minimum(np.array(g.coef), 1.0) == pytest.approx(low, abs=1e-11)


def test_no_minimum_where_a_signal_falls_or_rises_throughout():
    assert lowest_minimum(np.array([1.0, -1.0, 0.1, 0.0]), 1.0) == NO_ROOT
    assert lowest_minimum(np.array([1.0, 1.0, 0.1, 0.0]), 1.0) == NO_ROOT


@given(turn=st.floats(0.05, 0.6), width=st.floats(0.02, 0.3), height=st.floats(0.1, 2.0))
def test_a_lobe_whose_both_turns_lie_inside_a_step(turn, width, height):
    """The slope is positive at both ends: signs there tell nothing of the minimum."""
    low = turn + width
    g = Polynomial([height]) + Polynomial.fromroots([turn, low]).integ()
    c = np.array(g.coef)
    assert g.deriv()(0.0) > 0.0 < g.deriv()(1.0)
    assert lowest_minimum(c, 1.0) == pytest.approx(low, abs=1e-8)


def test_of_several_minima_the_lowest():
    slope = Polynomial.fromroots([0.2, 0.5, 0.8])
    g = Polynomial([1.0, 0.0]) + slope.integ() + 0.001 * Polynomial([0.0, -1.0])
    expected = min(
        (float(r) for r in np.real(g.deriv().roots()) if g.deriv(2)(r) > 0.0), key=lambda r: g(r)
    )
    assert lowest_minimum(np.array(g.coef), 1.0) == pytest.approx(expected, abs=1e-9)
