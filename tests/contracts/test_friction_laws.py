"""What every friction law promises: the built-in ones, with any parameters, and users' laws."""

import copy
import math
import pickle

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from stickslip.mechanics.friction import LAWS, Coulomb, PoppStelter, friction_law
from stickslip.mechanics.friction.code import law_code
from stickslip.mechanics.friction.interface import PARAMETER_COLUMN
from stickslip.mechanics.friction.law import Choice
from stickslip.mechanics.friction.values import parse_law
from stickslip.numerics.expression import ELEMENTARY

ORDER = 10
ROUNDING = 4e-15  # of a value: a few operations on numbers of order one
# Of a Taylor coefficient, relative to the largest of any row up to it, squared.
SERIES_ROUNDING = 1e-13
# Differences of order 6 of laws that cannot be differentiated.
DIFFERENCES = 1e-9
MPMATH = {name: getattr(mpmath, name) for name in ELEMENTARY}
DIRECTIONS = (-1, 1)


def values_of(allowed):
    if isinstance(allowed, Choice):
        return st.sampled_from(allowed.values)
    smallest = allowed.low + 0.02 if allowed.above else allowed.low
    return st.floats(smallest, min(allowed.high, 4.0))


def builtin_laws(name):
    fields = {key: values_of(allowed) for key, allowed in LAWS[name].fields().items()}
    return st.fixed_dictionaries(fields).map(LAWS[name].from_values)


# --- laws that a user may write -----------------------------------------------------------------


def rational(s, a):
    return a + (1 - a) / (1 + 3 * s)


def with_numpy(s, mu, speed):
    return mu + (1 - mu) * np.exp(-s / speed) + 0.05 * np.tanh(s) ** 2


def with_math(s, mu, speed=0.4):
    return mu + (1 - mu) / math.cosh(s / speed) - 0.1 * math.atan(s) * math.exp(-s)


def powers(s, a):
    return 0.4 * (1 + s * s) ** a * math.exp(-2 * s)


def branching(s, a):
    if s < 0.5:
        return 1 - (1 - a) * s * s * 4 * (1 - s * s * 2)
    return 1 - (1 - a) * 0.5


def singular(s, a):
    return a * (1 + s**2.5) * math.exp(-s)


def forward(s, a):
    return 0.5 * a / (1 + s)


USER_LAWS = {
    "traced": friction_law(rational, parameters={"a": 0.3}),
    "numpy": friction_law(with_numpy, parameters={"mu": 0.2, "speed": 0.3}),
    "math": friction_law(with_math, parameters={"mu": 0.2}),
    "powers": friction_law(powers, parameters={"a": 0.7}),
    "asymmetric": friction_law(rational, parameters={"a": 0.3}, forward=forward),
    "constant": friction_law(lambda s: 0.4),
    "branching": friction_law(branching, parameters={"a": 0.3}),
    "singular": friction_law(singular, parameters={"a": 0.3}),
    "own slope": friction_law(
        branching,
        parameters={"a": 0.3},
        slope=lambda s, a: -(1 - a) * (8 * s - 32 * s**3) if s < 0.5 else 0.0,
    ),
    "asymmetric branching": friction_law(branching, parameters={"a": 0.3}, forward=forward),
}
UNTRACEABLE = {"branching", "singular", "own slope", "asymmetric branching"}

ANY_LAW = st.one_of(
    *(builtin_laws(name) for name in LAWS), st.sampled_from(list(USER_LAWS.values()))
)
TRACED_LAW = st.one_of(
    *(builtin_laws(name) for name in LAWS),
    st.sampled_from([law for name, law in USER_LAWS.items() if name not in UNTRACEABLE]),
)


def exact(law, s, m, arguments=None):
    """F of a traced law in the working precision of mpmath."""
    values = law.arguments if arguments is None else arguments
    return law.formula.force(s, values, m > 0, MPMATH)


# --- as values ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LAWS)
@given(data=st.data())
def test_a_law_is_a_value(name, data):
    law = data.draw(builtin_laws(name))
    assert law.name == name
    assert parse_law(str(law)) == law
    assert eval(repr(law), {type(law).__name__: type(law)}) == law
    assert law.replace() == law == copy.deepcopy(law) == pickle.loads(pickle.dumps(law))
    assert len({law, law.replace()}) == 1
    assert set(law.parameters) <= set(law.arguments) <= set(law.names)
    for parameter, value in law.arguments.items():
        assert law.replace(**{parameter: value}) == law
        assert type(value) is float
    with pytest.raises(AttributeError):
        law.name = "other"


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, True, "0.2", None, [0.2], 1j])
def test_bad_parameters_are_named(name, bad):
    law = LAWS[name]
    good = {
        key: allowed.values[0] if isinstance(allowed, Choice) else 0.5
        for key, allowed in law.fields().items()
    }
    for key, allowed in law.fields().items():
        with pytest.raises(ValueError, match=rf"^{key} = .* of the friction law {name} ") as e:
            law.from_values({**good, key: bad})
        assert repr(bad) in str(e.value) or str(bad) in str(e.value)
        if not isinstance(allowed, Choice):
            assert f"{key} must be a finite number" in str(e.value)


@given(law=ANY_LAW)
def test_the_force_at_rest_is_at_most_the_static_limit(law):
    for is_forward in (False, True):
        assert 0.0 <= law.static_value(forward=is_forward) <= 1.0


@given(law=ANY_LAW)
def test_shapes_and_refused_speeds(law):
    assert isinstance(law.force(0.3), float)
    assert isinstance(law.slope(0.3), float)
    grid = np.linspace(0.1, 2, 6).reshape(2, 3)
    assert law.force(grid).shape == law.slope(grid).shape == (2, 3)
    assert law.force(grid)[1, 2] == law.force(grid[1, 2])
    assert law.force(np.empty(0)).shape == (0,)
    for bad in (-1e-300, math.nan, [0.1, -0.2]):
        with pytest.raises(ValueError, match="s >= 0"):
            law.force(bad)


# --- kernels ------------------------------------------------------------------------------------


@pytest.mark.kernel
@given(law=TRACED_LAW, s=st.floats(0, 5))
def test_kernels_give_the_force_and_its_derivatives(law, s):
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    out = np.empty(code.N_PARAMETERS)
    names = list(law.arguments)
    for m in DIRECTIONS:
        code.gradient(p, m, s, out)
        with mpmath.workdps(40):
            speed = mpmath.mpf(s)
            force = float(exact(law, speed, m))
            slope = mpmath.mpf(mpmath.diff(lambda x, m=m: mpmath.mpf(exact(law, x, m)), speed))
            assert code.force(p, m, s) == pytest.approx(force, rel=ROUNDING, abs=ROUNDING)
            assert law.force(s, forward=m > 0) == pytest.approx(force, rel=ROUNDING, abs=ROUNDING)
            for found in (code.slope(p, m, s), law.slope(s, forward=m > 0)):
                assert found == pytest.approx(float(slope), rel=1e-13, abs=1e-13)
            for j, name in enumerate(names):
                derivative = mpmath.diff(
                    lambda x, m=m, name=name, speed=speed: mpmath.mpf(
                        exact(law, speed, m, {**law.arguments, name: x})
                    ),
                    mpmath.mpf(law.arguments[name]),
                )
                assert out[j] == pytest.approx(float(derivative), rel=1e-12, abs=1e-12)
                assert code.parameter_index(law, name) == j
                assert p[PARAMETER_COLUMN + code.parameter_index(law, name)] == law.arguments[name]


# dF/ds and dF/da of the laws above, by hand.
DERIVATIVES = {
    branching: (
        lambda s, a: (a - 1) * (8 * s - 32 * s**3) if s < 0.5 else 0.0,
        lambda s, a: 4 * s * s * (1 - 2 * s * s) if s < 0.5 else 0.5,
    ),
    singular: (
        lambda s, a: a * math.exp(-s) * (2.5 * s**1.5 - 1 - s**2.5),
        lambda s, a: math.exp(-s) * (1 + s**2.5),
    ),
    forward: (lambda s, a: -0.5 * a / (1 + s) ** 2, lambda s, a: 0.5 / (1 + s)),
}


@pytest.mark.kernel
@pytest.mark.parametrize("name", sorted(UNTRACEABLE))
@given(s=st.floats(0, 2))
def test_laws_known_by_values_only_are_differentiated(name, s):
    assume(abs(s - 0.5) > 1e-3)  # the corner of `branching`
    law = USER_LAWS[name]
    assert not law.traceable
    code = law_code([law])
    assert not code.traceable
    assert code.series is None
    (p,) = code.parameter_rows([law])
    out = np.empty(1)
    for m in DIRECTIONS:
        function = law.forward_function if m > 0 and law.forward_function else law.function
        slope, by_a = DERIVATIVES[function]
        assert code.force(p, m, s) == pytest.approx(function(s, 0.3), rel=1e-15)
        # The singular law has no third derivative at 0, so that differences are poor there.
        error = 1e-5 if function is singular and s < 0.02 else DIFFERENCES
        assert code.slope(p, m, s) == pytest.approx(slope(s, 0.3), abs=error)
        assert law.slope(s, forward=m > 0) == code.slope(p, m, s)
        code.gradient(p, m, s, out)
        assert out[0] == pytest.approx(by_a(s, 0.3), abs=DIFFERENCES)


@pytest.mark.kernel
@given(
    law=TRACED_LAW, s=st.floats(1e-3, 5), low=st.floats(-1, 1), scale=st.sampled_from([-53, -30])
)
def test_a_force_as_a_sum_of_two(law, s, low, scale):
    """Only what elementary functions round stays, of rational laws nothing to speak of."""
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    rational = {node.op for node in law.formula.nodes}.isdisjoint({*ELEMENTARY, "power"})
    low *= 2.0**scale * s
    for m in DIRECTIONS:
        force, rest = code.force_sharp(p, m, s, low)
        with mpmath.workdps(40):
            arguments = {name: mpmath.mpf(value) for name, value in law.arguments.items()}
            wanted = exact(law, mpmath.mpf(s) + mpmath.mpf(low), m, arguments)
            error = float(abs(mpmath.mpf(force) + mpmath.mpf(rest) - wanted))
            size = max(1.0, abs(float(wanted)))
        second_order = 1e3 * low * low
        assert error <= (1e-28 if rational else ROUNDING) * size + second_order
        assert code.force_sharp(p, m, 0.0, 0.0) == (code.static_value(p, m), 0.0)


def of_two(s, a, b):
    return a / (1 + s) + b * s if s < 9 else a


@pytest.mark.kernel
@given(s=st.floats(0, 2))
def test_each_parameter_of_a_law_known_by_values_has_its_own_place(s):
    law = friction_law(of_two, parameters={"a": 0.3, "b": 0.2})
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    out = np.empty(2)
    assert not law.traceable
    assert code.force(p, 1, s) == pytest.approx(of_two(s, 0.3, 0.2), rel=1e-15)
    code.gradient(p, 1, s, out)
    assert out == pytest.approx([1 / (1 + s), s], abs=DIFFERENCES)


@pytest.mark.kernel
@given(law=ANY_LAW, s=st.floats(0, 3))
def test_the_continuation_is_the_tangent_at_rest(law, s):
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    for m in DIRECTIONS:
        assert code.force_continued(p, m, s) == code.force(p, m, s)
        assert code.force(p, m, 0.0) == code.static_value(p, m) == law.static_value(forward=m > 0)
        expected = law.static_value(forward=m > 0) - s * code.slope(p, m, 0.0)
        assert code.force_continued(p, m, -s) == pytest.approx(expected, rel=1e-15, abs=1e-15)


def just_below_the_static_limit(s):
    return (0.7 + 0.2 + 0.1) / (1 + s)  # 1 - 1.1e-16 at s = 0


def just_above_zero(s):
    return (0.1 + 0.2 - 0.3) / (1 + s) + s


@pytest.mark.kernel
@pytest.mark.parametrize("law", [just_below_the_static_limit, just_above_zero, PoppStelter(3, 0.1)])
def test_a_force_at_rest_that_rounding_separates_from_a_limit_is_that_limit(law):
    law = friction_law(law) if callable(law) else law
    limit = round(law.static_value())
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    assert law.static_value() == code.force(p, -1, 0.0) == limit
    rows = np.zeros((code.N_ROWS, 1))
    code.series(p, -1, rows, 0)
    assert rows[code.FORCE_ROW, 0] == limit


@pytest.mark.kernel
@settings(max_examples=60)
@given(
    law=TRACED_LAW,
    start=st.floats(0, 1),
    others=st.lists(st.floats(-1, 1), min_size=ORDER, max_size=ORDER),
)
def test_series_of_the_force_and_of_its_derivatives(law, start, others):
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    scale = min([1.0, *(law.arguments.get(name, 1.0) for name in ("speed",))])
    polynomial = scale * np.array([start, *others])
    for m in DIRECTIONS:
        rows = np.full((code.N_ROWS, ORDER + 1), np.nan)
        for k in range(ORDER + 1):
            rows[0, k] = polynomial[k]
            code.series(p, m, rows, k)
        code.series_tangent(p, m, rows, ORDER, gradient=False)
        with mpmath.workdps(50):

            def speed(t):
                return sum(mpmath.mpf(c) * t**k for k, c in enumerate(polynomial))

            def force(t, m=m):
                return mpmath.mpf(exact(law, speed(t), m))

            expected = {code.FORCE_ROW: mpmath.taylor(force, 0, ORDER)}
            expected[code.SLOPE_ROW] = mpmath.taylor(
                lambda t, m=m: mpmath.mpf(
                    law.formula.slope(speed(t), law.arguments, m > 0, MPMATH)
                ),
                0,
                ORDER,
            )
        for row, coefficients in expected.items():
            for k in range(ORDER + 1):
                size = max(1.0, np.nanmax(np.abs(rows[:, : k + 1])))
                assert rows[row, k] == pytest.approx(
                    float(coefficients[k]), abs=SERIES_ROUNDING * size**2
                ), (row, k)


@pytest.mark.kernel
@given(law=TRACED_LAW, start=st.floats(0.05, 1), rate=st.floats(-0.5, 0.5))
def test_series_of_parameter_derivatives_sum_to_the_gradient(law, start, rate):
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    order, t = 24, 0.02 * min(1.0, law.arguments.get("speed", 1.0))
    out = np.empty(code.N_PARAMETERS)
    for m in DIRECTIONS:
        rows = np.zeros((code.N_ROWS, order + 1))
        rows[0, :2] = start, rate
        for k in range(order + 1):
            code.series(p, m, rows, k)
        code.series_tangent(p, m, rows, order, gradient=True)
        s = start + rate * t
        code.gradient(p, m, s, out)
        sums = np.polynomial.polynomial.polyval(t, rows.T)
        assert sums[code.FORCE_ROW] == pytest.approx(code.force(p, m, s), rel=1e-13)
        assert sums[code.SLOPE_ROW] == pytest.approx(code.slope(p, m, s), rel=1e-12, abs=1e-13)
        gradient = sums[code.GRADIENT_ROW : code.GRADIENT_ROW + code.N_PARAMETERS]
        assert gradient == pytest.approx(out, rel=1e-12, abs=1e-13)


# --- several laws together ----------------------------------------------------------------------


@pytest.mark.kernel
@pytest.mark.parametrize("other", ["asymmetric", "numpy", "branching"])
def test_two_laws_share_kernels_that_tell_them_apart(other):
    laws = [PoppStelter(3.0, 0.1, 0.05), USER_LAWS[other]]
    code = law_code(laws)
    rows = code.parameter_rows(laws)
    assert code.traceable is (other not in UNTRACEABLE)
    assert rows.shape[0] == 2
    work = np.zeros((code.N_ROWS, 3))
    alone_work = np.zeros((20, 3))
    work[0] = alone_work[0] = 0.3, -0.2, 0.1
    for law, p in zip(laws, rows, strict=True):
        alone = law_code([law])
        (p_alone,) = alone.parameter_rows([law])
        out = np.full(code.N_PARAMETERS, np.nan)
        out_alone = np.full(alone.N_PARAMETERS, np.nan)
        for m in DIRECTIONS:
            assert code.force(p, m, 0.3) == alone.force(p_alone, m, 0.3)
            assert code.slope(p, m, 0.3) == alone.slope(p_alone, m, 0.3)
            code.gradient(p, m, 0.3, out)
            alone.gradient(p_alone, m, 0.3, out_alone)
            assert out[: out_alone.size].tolist() == out_alone.tolist()
            assert not out[out_alone.size :].any()
            if code.traceable:
                for k in range(3):
                    code.series(p, m, work, k)
                    alone.series(p_alone, m, alone_work, k)
                assert work[code.FORCE_ROW] == pytest.approx(
                    alone_work[alone.FORCE_ROW], rel=1e-15, abs=1e-15
                )
                code.series_tangent(p, m, work, 2, gradient=True)
                unused = work[code.GRADIENT_ROW + out_alone.size : code.GRADIENT_ROW + out.size]
                assert not unused.any()


def test_parameters_do_not_make_new_kernels():
    first = law_code([PoppStelter(3.0)])
    assert law_code([PoppStelter(1.0, 0.2, 0.1)]) is first
    assert law_code([PoppStelter(3.0), PoppStelter(2.0)]) is first
    pair = [PoppStelter(3.0), Coulomb(0.2)]
    assert law_code(pair) is law_code(pair[::-1])
    mixed = law_code(pair)
    in_turn = mixed.parameter_rows(pair), mixed.parameter_rows(pair[::-1])
    assert np.array_equal(in_turn[0], in_turn[1][::-1])
    law = USER_LAWS["traced"]
    assert law_code([law.replace(a=0.5)]) is law_code([law])
    branching_law = USER_LAWS["branching"]
    assert law_code([branching_law.replace(a=0.5)]) is law_code([branching_law])


def test_equal_formulas_from_different_functions_are_one():
    law = friction_law(lambda s, a: a + (1 - a) / (1 + 3 * s), parameters={"a": 0.1})
    assert law.formula == USER_LAWS["traced"].formula


@pytest.mark.kernel
@given(law=TRACED_LAW, s=st.floats(0, 4))
def test_compiled_kernels_compute_what_their_text_says(law, s):
    """Fused multiply-adds are the only difference."""
    code = law_code([law])
    (p,) = code.parameter_rows([law])
    for name in ("force", "slope"):
        kernel = getattr(code, name)
        plain = getattr(kernel, "py_func", kernel)
        for m in DIRECTIONS:
            assert kernel(p, m, s) == pytest.approx(plain(p, m, s), rel=ROUNDING, abs=ROUNDING)
