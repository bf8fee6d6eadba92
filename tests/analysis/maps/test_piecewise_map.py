"""The user's own map: ways to give it, derivatives, errors, powers."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

import stickslip as ss
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import (
    UNDEFINED,
    Map1D,
    MapFamily,
    MapValues,
    base_and_exponent,
)
from stickslip.analysis.orbits.newton import solve_orbit

BY_DIFFERENCES = 1e-8  # of the scale of the values
EXAMPLES = [
    examples.tent(1.8),
    examples.logistic(3.6),
    examples.doubling(2.5),
    examples.tent_with_hole(3.0),
    examples.border_collision(0.5, -2.0, 0.3, 0.2),
    examples.square_root(0.2, 0.05),
]


@pytest.mark.parametrize("f", EXAMPLES, ids=repr)
def test_examples_keep_the_protocol(f):
    assert isinstance(f, Map1D)
    assert isinstance(f, MapFamily)
    x = np.linspace(*f.domain, 12).reshape(3, 4)
    values = f.evaluate(x)
    assert isinstance(values, MapValues)
    for column in (values.value, values.derivative, values.label, values.status):
        assert column.shape == (3, 4)
    assert values.label.dtype == np.uint64
    assert np.array_equal(np.isnan(values.value), values.status != 0)


@pytest.mark.parametrize("f", EXAMPLES, ids=repr)
def test_given_derivatives_agree_with_differences(f):
    bare = PiecewiseMap(
        f.func, f.domain, parameters=f.parameters, breakpoints=[b.d for b in breakpoints(f)]
    )
    lo, hi = f.domain
    x = lo + (hi - lo) * ((0.618034 * np.arange(1, 60)) % 1)
    scale = 1 + np.abs(f.derivative(x))
    assert np.nanmax(np.abs(bare.derivative(x) - f.derivative(x)) / scale) < BY_DIFFERENCES
    for name in f.parameters:
        off = bare.parameter_derivative(x, name) - f.parameter_derivative(x, name)
        assert np.nanmax(np.abs(off)) < 10 * BY_DIFFERENCES


def test_scalar_functions_are_called_with_scalars():
    def func(x, c):
        return math.sin(x) if x < c else math.cos(x)

    f = PiecewiseMap(func, (0, 2), parameters={"c": 1.0})
    assert f(0.5) == math.sin(0.5)
    assert isinstance(f(0.5), float)
    assert f([0.5, 1.5]) == pytest.approx([math.sin(0.5), math.cos(1.5)])
    assert f.derivative([0.5, 1.5]) == pytest.approx([math.cos(0.5), -math.sin(1.5)], abs=1e-9)


def test_a_function_that_mixes_up_its_points_counts_as_scalar():
    f = PiecewiseMap(lambda x: 0.5 * np.max(x), (0, 1))
    assert f([0.2, 0.8]) == pytest.approx([0.1, 0.4])


@given(x=st.floats(0, 1))
def test_analytic_functions_are_differentiated_to_rounding(x):
    f = PiecewiseMap(lambda x: np.exp(-x) * np.sin(5 * x), (0, 1))
    known = np.exp(-x) * (5 * np.cos(5 * x) - np.sin(5 * x))
    assert f.derivative(x) == pytest.approx(known, abs=1e-14)


@given(x=st.floats(0, 1).filter(lambda x: abs(x - 0.4) > 1e-6))
def test_differences_do_not_reach_across_an_unmarked_corner(x):
    f = PiecewiseMap(lambda x: abs(x - 0.4), (0, 1))
    assert f.derivative(x) == pytest.approx(1.0 if x > 0.4 else -1.0, abs=1e-6)


def test_constant_functions():
    f = PiecewiseMap(lambda x: 0.25, (0, 1))
    assert f([0.1, 0.9]).tolist() == [0.25, 0.25]
    assert f.derivative([0.1, 0.9]).tolist() == [0.0, 0.0]


def test_nan_is_a_gap():
    values = examples.tent_with_hole(3.0).evaluate([0.2, 0.5])
    assert values.status.tolist() == [0, UNDEFINED]
    assert np.isnan(values.value[1])
    assert np.isnan(values.derivative[1])


def test_orbits_that_leave_are_nan_from_there_on():
    f = examples.border_collision(3.0, 3.0, 1.0)
    orbit = f.iterate([1.0, -0.5], 3)
    assert orbit.shape == (2, 4)
    assert orbit[0, :3].tolist() == [1.0, 4.0, 13.0]
    assert np.isnan(orbit[0, 3])
    assert orbit[1].tolist() == [-0.5] * 4


def test_labels_by_a_callable():
    f = PiecewiseMap(lambda x: x, (-1, 1), label=lambda x: -3 if x < 0 else 5)
    labels = f.evaluate([-0.5, 0.5, 0.7]).label
    assert labels[0] != labels[1] == labels[2]


def test_breakpoints_that_move_with_a_parameter():
    f = examples.doubling(2.5).replace(slope=4.0)
    assert f.evaluate([0.1, 0.3, 0.6, 0.9]).label.tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("f", EXAMPLES, ids=repr)
def test_a_copy_is_like_a_map_made_afresh(f):
    for name, value in f.parameters.items():
        changed = f.replace(**{name: value + 0.05})
        fresh = type(f)(
            f.func,
            f.domain,
            parameters=changed.parameters,
            derivative=f._given_derivative,
            parameter_derivative=f._given_parameter_derivative,
            breakpoints=f._given_breakpoints,
        )
        x = np.linspace(*f.domain, 50)
        for mine, other in zip(
            vars(changed.evaluate(x)).values(), vars(fresh.evaluate(x)).values(), strict=True
        ):
            assert np.array_equal(mine, other, equal_nan=True)


def test_a_copy_finds_out_whether_it_is_analytic():
    # At a = 0 the complex step through the modulus happens to be right.
    f = PiecewiseMap(lambda x, a: a * abs(x) + x, (0.1, 1), parameters={"a": 0.0})
    assert f.derivative(0.5) == pytest.approx(1.0, abs=1e-14)
    assert f.replace(a=1.0).derivative(0.5) == pytest.approx(2.0, abs=1e-8)
    assert f.replace(a=1.0).replace(a=0.0).derivative(0.5) == f.derivative(0.5)


def test_a_copy_tries_again_where_arrays_no_longer_work():
    def func(x, n):
        return 0.5 * x if n < 2 else 0.5 * math.sin(x)

    f = PiecewiseMap(func, (0.1, 1), parameters={"n": 1})
    assert f.replace(n=2)([0.3, 0.5]) == pytest.approx([0.5 * math.sin(0.3), 0.5 * math.sin(0.5)])
    with pytest.raises(ValueError, match=r"func\(x, n=\.\.\.\) failed at x = .*ZeroDivisionError"):
        _reciprocal().replace(n=0)


def _reciprocal():
    def func(x, n):
        return x * (1 / n)

    return PiecewiseMap(func, (0, 1), parameters={"n": 1.0})


def test_replace_leaves_the_original_alone():
    f = examples.logistic(3.5)
    g = f.replace(r=4)
    assert (f(0.5), g(0.5)) == (0.875, 1.0)
    assert g.parameters == {"r": 4.0}
    g.parameters["r"] = 0.0
    assert g(0.5) == 1.0


@given(x=st.floats(0, 1), p=st.integers(1, 5))
def test_a_power_is_repeated_application(x, p):
    f = examples.logistic(3.7)
    orbit = f.iterate(x, p)
    power = f.power(p)
    assert power(x) == orbit[-1]
    assert power.derivative(x) == pytest.approx(np.prod(f.derivative(orbit[:-1])))
    assert base_and_exponent(power) == (f, p)
    assert base_and_exponent(power.power(2)) == (f, 2 * p)


def test_labels_of_powers_tell_words_apart():
    f = examples.tent(2.0)
    x = (np.arange(8) + 0.5) / 8
    labels = f.power(3).evaluate(x).label
    assert len(set(labels.tolist())) == 8
    assert f.power(3).itinerary(0.9) == "1 | 0 | 0"
    assert f.power(3).evaluate(x + 0.01).label.tolist() == labels.tolist()


def test_a_power_has_gaps_where_an_orbit_meets_one():
    power = examples.tent_with_hole(3.0).power(2)
    assert np.isnan(power(1 / 6))
    assert power.itinerary(1 / 6).count("|") == 1


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PiecewiseMap(lambda x: x, (1, 0)), "lo < hi"),
        (lambda: PiecewiseMap(lambda x: x, (0, math.inf)), r"domain\[1\] = inf is not allowed"),
        (lambda: PiecewiseMap(lambda x: x, 3), "pair of numbers"),
        (lambda: PiecewiseMap(lambda x, a: x, (0, 1), parameters={"a": math.nan}), "finite number"),
        (lambda: PiecewiseMap(lambda x, a: x, (0, 1), parameters={"a": True}), "finite number"),
        (lambda: PiecewiseMap(lambda x: x, (0, 1), parameters={"a": 1.0}), "failed at"),
        (lambda: PiecewiseMap(lambda x: 1 // 0, (0, 1)), "ZeroDivisionError"),
        (lambda: PiecewiseMap(lambda x: x, (0, 1), breakpoints=[0.5, 0.2]), "increasing"),
        (
            lambda: PiecewiseMap(lambda x: x, (0, 1), parameter_derivative={"q": lambda x: x}),
            "not a parameter",
        ),
        (lambda: examples.tent().replace(slop=1.0), "Did you mean 'slope'"),
        (lambda: examples.tent().parameter_derivative(0.3, "r"), "not a parameter"),
        (lambda: examples.tent()(1.5), r"x = 1.5 is outside the domain \[0, 1\]"),
        (lambda: examples.tent()([0.1, math.nan]), r"x\[1\] = nan"),
        (lambda: examples.tent().iterate(0.1, -1), "n = -1 is not allowed.* from 0 to"),
        (lambda: examples.tent().power(0), "whole number from 1 to"),
    ],
)
def test_errors_say_what_is_wrong(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("wrong", [-1.0, 2.0, 0.0, math.nan, math.inf])
def test_derivatives_that_are_not_those_of_the_values_are_refused(wrong):
    def made(**given):
        return PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.8}, **given)

    def slope(x, r):
        return r * (1 - 2 * x)

    def rate(x, r):
        return x * (1 - x)

    made(derivative=slope, parameter_derivative={"r": rate})
    with pytest.raises(ValueError, match=r"^derivative is .* differences of func tell 2.90294"):
        made(derivative=lambda x, r: wrong * slope(x, r))
    for other in ({"r": lambda x, r: wrong * rate(x, r)}, lambda x, name, r: wrong * rate(x, r)):
        with pytest.raises(ValueError, match=r"parameter_derivative\['r'\] is .* tell 0.104102"):
            made(parameter_derivative=other)


def test_a_derivative_that_leaves_a_parameter_out_is_refused_where_it_moves():
    f = PiecewiseMap(
        lambda x, r, c: c + r * x * (1 - x),
        (0, 1),
        parameters={"r": 3.8, "c": 0.0},
        derivative=lambda x, r, c: 3.8 * (1 - 2 * x),
    )
    assert f.replace(c=0.01, r=3.8).derivative(0.5) == 0.0
    for _ in range(2):
        with pytest.raises(ValueError, match=r"^derivative is .* differences of func tell"):
            f.replace(c=0.02).replace(r=3.0)


def test_a_derivative_may_be_wrong_by_the_noise_of_the_function():
    def func(x):
        return np.sin(3 * np.float32(x)).astype(np.float32)

    PiecewiseMap(func, (0, 1), derivative=lambda x: 3 * np.cos(3 * x))
    with pytest.raises(ValueError, match="derivative"):
        PiecewiseMap(func, (0, 1), derivative=lambda x: np.cos(3 * x))


@pytest.mark.parametrize("half", [1e-10, 3e-9, 1e-4])
def test_a_right_derivative_is_taken_on_a_narrow_branch_beside_a_root(half):
    PiecewiseMap(
        lambda x: np.where(np.abs(x - 0.1) < half, np.sqrt(np.abs(x - 0.1 + half)), -x),
        (-1, 1),
        derivative=lambda x: np.where(
            np.abs(x - 0.1) < half, 0.5 / np.sqrt(np.abs(x - 0.1 + half)), -1.0
        ),
        breakpoints=[0.1 - half, 0.1 + half],
    )


def test_an_argument_a_few_ulp_outside_counts_as_the_end():
    assert examples.tent()(1 + 4e-16) == 0.0
    with pytest.raises(ValueError, match="outside"):
        examples.tent()(1 + 1e-14)


def test_repr_names_function_domain_and_parameters():
    assert repr(examples.logistic(3.5)) == "PiecewiseMap(_logistic, [0, 1], r=3.5)"


@given(teeth=st.integers(2, 3000), x=st.floats(0.001, 0.999))
def test_slopes_of_a_sawtooth_are_not_taken_across_its_jumps(teeth, x):
    f = PiecewiseMap(lambda x: (teeth * x) % 1, (0.0, 1.0))
    assume(0.02 < teeth * x % 1 < 0.98)
    assert f.derivative(x) == pytest.approx(teeth, rel=1e-9)


@pytest.mark.parametrize("unit", [1e-15, 1e-12, 1e-6, 1.0, 1e6, 1e12])
@pytest.mark.parametrize("share", [-0.8, 0.3, 1.0])
def test_a_parameter_has_a_derivative_in_any_unit(unit, share):
    """As of a spring in N/m or its compliance in m/N."""
    x = np.array([0.1, 0.35, 0.6])
    f = ss.PiecewiseMap(lambda x, p: np.sin(p / unit) * x, (0, 1), parameters={"p": share * unit})
    g = ss.Map(lambda x, p: np.sin(p / unit) * x, 3, parameters={"p": share * unit})
    expected = np.cos(share) * x / unit
    for found in (f.parameter_derivative(x, "p"), g.parameter_derivative(x, "p")):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=0)


@pytest.mark.parametrize("p", [1e-17, 5e-324])
def test_a_parameter_near_zero_keeps_the_scale_of_one(p):
    f = ss.PiecewiseMap(lambda x, p: (1 + p - 1) + np.sin(p) * x, (0, 1), parameters={"p": p})
    assert f.parameter_derivative(0.5, "p") == pytest.approx(1.5, rel=1e-9, abs=0)


@pytest.mark.parametrize("centre", [0.0, 1e3])
def test_no_step_in_a_parameter_is_too_long_for_the_map(centre):
    """Breaks pass each other, and a logarithm ends, a hundredth of the parameter's scale away."""
    f = PiecewiseMap(
        lambda x, p: math.log(1.0 + 400 * (p - centre)) + 0.5 * x,
        (-1, 1),
        parameters={"p": centre + 1e-3},
        breakpoints=lambda p: [0.2 * (p - centre), 1e-3 - 0.2 * (p - centre)],
    )
    found = f.parameter_derivative(np.array([-0.3, 0.4]), "p")
    np.testing.assert_allclose(found, 400 / 1.4, rtol=1e-6, atol=0)


@pytest.mark.parametrize("corner", [0.0, 0.3])
def test_slopes_are_right_close_to_a_root_like_corner(corner):
    """Nor are there gaps where differences over both sides of the corner seem smooth."""
    f = ss.PiecewiseMap(lambda x: 0.6 * np.sqrt(np.abs(x - corner)) - 0.1, (-1.0, 1.0))
    x = np.concatenate([corner + np.geomspace(1e-11, 0.1, 41) * side for side in (-1.0, 1.0)])
    off = x - corner
    wanted = 0.3 * np.sign(off) / np.sqrt(np.abs(off))
    np.testing.assert_allclose(f.derivative(x), wanted, rtol=1e-6)
    assert not len(f.gaps)
    assert not ss.breakpoints(f).of_kind("edge")


@pytest.mark.parametrize("corner", [0.0, 0.3, -0.7])
def test_both_derivatives_are_right_close_to_a_root_like_corner_that_moves(corner):
    f = ss.PiecewiseMap(
        lambda x, c: 0.6 * np.sqrt(np.abs(x - c)) - 0.1,
        (-1.0, 1.0),
        parameters={"c": corner},
        breakpoints=lambda c: [c],
    )
    x = np.concatenate([corner + np.geomspace(1e-12, 0.1, 23) * side for side in (-1.0, 1.0)])
    wanted = 0.3 * np.sign(x - corner) / np.sqrt(np.abs(x - corner))
    np.testing.assert_allclose(f.derivative(x), wanted, rtol=1e-6)
    np.testing.assert_allclose(f.parameter_derivative(x, "c"), -wanted, rtol=1e-6)


@pytest.mark.parametrize(("power", "slope"), [(1 / 2, np.inf), (1 / 3, np.inf), (1, 1.0)])
def test_the_slope_at_a_root_is_infinite_and_no_orbit_is_taken_to_be_there(power, slope):
    """By complex step it was 7e14, so large that an orbit 1e-3 away counted as rounding."""
    f = ss.PiecewiseMap(lambda x: 1e-3 + x**power, (0.0, 1.0))
    wanted = [slope, power * 0.25 ** (power - 1)]
    np.testing.assert_allclose(f.derivative([0.0, 0.25]), wanted, rtol=1e-12)
    assert solve_orbit(f, np.array([0.0])).quality == "failed"
