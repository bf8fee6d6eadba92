"""Laws written by users: how they are read, and what is said about those that are wrong."""

import functools
import json
import math
import pickle

import numba
import numpy as np
import pytest

import stickslip as ss
from stickslip.mechanics.friction import UserLaw, friction_law
from stickslip.mechanics.friction.code import law_code


def weakening(s, a):
    return a + (1 - a) / (1 + s)


def stepped(s, a):
    return 1.0 if s < 0.1 else a


def test_parameters_are_passed_by_name_and_may_have_defaults():
    def force(s, b=0.5, *, a):
        return a / (1 + b * s)

    law = friction_law(force, parameters={"a": 0.4})
    assert law.parameters == {"a": 0.4}
    assert law.force(2.0) == 0.2
    assert friction_law(force, parameters={"a": 0.4, "b": 1.0}).force(3.0) == 0.1


def test_replace_changes_the_values_only():
    law = friction_law(weakening, parameters={"a": 0.3})
    other = law.replace(a=0.5)
    assert isinstance(other, UserLaw)
    assert other == friction_law(weakening, parameters={"a": 0.5})
    assert law.parameters == {"a": 0.3}
    assert other.force(1.0) == 0.75
    assert law.replace(a=0.3) == law
    with pytest.raises(ValueError, match=r"no parameter 'b'\."):
        law.replace(b=1)
    with pytest.raises(ValueError, match=r"F\(0\) = 1.5 of the friction law peak"):
        friction_law(peak, parameters={"a": 0.3}).replace(a=1.5)


def peak(s, a):
    return a / (1 + s)


def test_replace_may_make_a_law_singular_at_rest():
    law = friction_law(lambda s, a: 0.5 * (a + s) ** 1.5, parameters={"a": 0.3})
    assert law.traceable
    assert not law.replace(a=0.0).traceable
    assert law.replace(a=0.0).replace(a=0.2).traceable


def test_a_law_compiled_by_the_user_is_traced_all_the_same():
    law = friction_law(numba.njit(weakening), parameters={"a": 0.3})  # noqa: TID251
    assert law.traceable
    assert law.force(1.0) == pytest.approx(weakening(1.0, 0.3), rel=1e-15)


def test_a_law_travels_to_another_process():
    for function in (weakening, stepped):
        law = friction_law(function, parameters={"a": 0.3})
        copy = pickle.loads(pickle.dumps(law))
        assert copy == law
        assert copy.force(0.7) == law.force(0.7)


def test_a_slope_that_is_not_the_derivative_is_refused():
    with pytest.raises(ValueError, match=r"slope of the friction law weakening is 0.7 at s = 0"):
        friction_law(weakening, parameters={"a": 0.3}, slope=lambda s, a: (1 - a) / (1 + s) ** 2)
    right = friction_law(
        weakening, parameters={"a": 0.3}, slope=lambda s, a: -(1 - a) / (1 + s) ** 2
    )
    assert right.slope(1.0) == pytest.approx(-0.175)


def test_a_function_that_answers_expressions_differently_is_compiled():
    law = friction_law(lambda s: 0.3 if isinstance(s, float) else 0.4)
    assert not law.traceable
    assert law.force(1.0) == 0.3


def worn(s, a):
    return 1 / (1 + a * s) if s < 2 else 1 / (1 + 2 * a)


def polished(s, a):
    return 1 - a * s / 8 if s < 1 else 1 - a / 8


def test_laws_known_by_values_share_kernels():
    """Those of the first serve all: kernels call the functions by their addresses."""
    laws = [friction_law(function, parameters={"a": 0.8}) for function in (worn, polished)]
    codes = [law_code([law]) for law in laws]
    assert codes[0] is not codes[1]
    assert codes[0].force is codes[1].force
    rows = [code.parameter_rows([law])[0] for code, law in zip(codes, laws, strict=True)]
    for s in (0.0, 0.5, 3.0):
        assert [codes[0].force(row, -1, s) for row in rows] == [worn(s, 0.8), polished(s, 0.8)]
    mixed = law_code(laws)
    swapped = law_code(laws[::-1])
    assert mixed is swapped
    for row, function in zip(mixed.parameter_rows(laws), (worn, polished), strict=True):
        assert mixed.force(row, -1, 0.5) == function(0.5, 0.8)


def failing(s, a):
    if s > 11:
        raise ValueError("never measured")
    return 1 / (1 + a * s)


def test_what_a_law_raises_in_a_motion_arrives():
    law = friction_law(failing, parameters={"a": 1.0})
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=15.0, friction=law)
    with pytest.raises(ValueError, match="never measured"):
        ss.event_map(model)(0.1)


def test_forward_slip_may_have_a_law_and_parameters_of_its_own():
    law = friction_law(
        weakening, parameters={"a": 0.3, "b": 0.2}, forward=lambda s, b: b * math.exp(-s)
    )
    assert not law.symmetric
    assert law.force(0.0, forward=True) == 0.2
    assert law.static_value() == 1.0
    assert law.static_value(forward=True) == 0.2
    code = law_code([law])
    (p,) = code.parameter_rows([law.replace(b=0.25)])
    assert code.force(p, 1, 0.0) == code.static_value(p, 1) == 0.25
    assert code.force(p, -1, 0.0) == code.static_value(p, -1) == 1.0


def test_partial_functions_and_methods_are_traced():
    def force(s, a, b):
        return a * math.exp(-b * s)

    law = friction_law(functools.partial(force, b=2.0), parameters={"a": 0.5})
    assert law.traceable
    assert law.force(0.25) == pytest.approx(0.5 * math.exp(-0.5), rel=1e-15)
    assert friction_law(Scaled(0.5).force).traceable
    assert friction_law(Scaled(0.5).force).force(1.0) == 0.5 * math.exp(-1.0)


class Scaled:
    def __init__(self, scale):
        self.scale = scale

    def force(self, s):
        return self.scale * math.exp(-s)


@pytest.mark.parametrize(
    "branch",
    [
        False,
        pytest.param(
            True,
            marks=pytest.mark.skipif(
                numba.config.DISABLE_JIT, reason="without JIT it overflows in plain Python"
            ),
        ),
    ],
)
def test_a_function_that_overflows_in_plain_python_only_is_no_error(branch):
    def sech(s, speed):
        if branch and s < 0:
            return 1.0
        return 1 / math.cosh(s / speed)

    law = friction_law(sech, parameters={"speed": 0.01})
    assert law.traceable is not branch
    assert law.force(0.01) == pytest.approx(1 / math.cosh(1.0), rel=1e-14)
    assert law.force(10.0) == 0.0


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled without JIT")
def test_a_function_that_numba_understands_differently_is_refused():
    def huge(s):
        n = 2**62 if s >= 0 else 0
        return 0.5 if n * 4 > 0 else 0.25  # wraps to 0 in machine integers

    with pytest.raises(ValueError, match="gives other values when it is compiled"):
        friction_law(huge)


def test_repr_shows_the_call():
    law = friction_law(weakening, parameters={"a": 0.3})
    assert repr(law) == "friction_law(weakening, parameters={'a': 0.3})"


def reads_json(s):
    return 0.5 if s > 1 else float(json.loads("0.25"))


class Holder:
    value = 0.5


HOLDER = Holder()


@pytest.mark.parametrize(
    ("force", "options", "message"),
    [
        (lambda s: math.nan, {}, "F(0) = nan; a law must be finite"),
        (lambda s: 1 / (1 - s / 10), {}, "ZeroDivisionError"),
        (lambda s: np.float64(0.5) / s * s, {}, "F(0) = nan"),
        (lambda s: math.sqrt(1 - s), {}, "failed at s = "),
        (lambda s: 1.2, {}, "F(0) = 1.2 of the friction law <lambda>; allowed: 0 <= F(0) <= 1"),
        (lambda s: s - 0.1, {}, "F(0) = -0.1"),
        (lambda s: 0.5 + 0j, {}, "F(0) is a complex, not a float"),
        (lambda s: np.array([0.5]), {}, "F(0) is a ndarray, not a float"),
        (lambda s: "0.5", {}, "F(0) is a str, not a float"),
        (lambda s: s > 1, {}, "F(0) is a bool, not a float"),
        (lambda s: None, {}, "F(0) is a NoneType, not a float"),
        (lambda s, a: a, {}, "force of the friction law <lambda> needs a value for 'a'"),
        (lambda: 0.5, {}, "takes no speed s as its first argument"),
        (lambda s, *a: 0.5, {}, "parameter *a cannot be passed by name"),
        (lambda s, **a: 0.5, {}, "parameter **a cannot be passed by name"),
        (0.5, {}, "is no function but 0.5"),
        (
            lambda s, a: a,
            {"parameters": {"a": math.nan}},
            "a = nan of the friction law <lambda>",
        ),
        (
            lambda s, a: a,
            {"parameters": {"a": "0.3"}},
            "is not a real number: a must be",
        ),
        (lambda s, a: a, {"parameters": {"a": 0.1, "aa": 0}}, "'aa'. Known: a. Did you mean 'a'?"),
        (
            lambda s, a: a,
            {"parameters": {"a": 0.1, "a b": 0}},
            "'a b' in parameters cannot name",
        ),
        (lambda s: 0.5, {"slope": 3}, "slope of the friction law <lambda> is no function"),
        (lambda s: 0.5, {"forward": lambda s: 2.0}, "F(0) = 2.0"),
        (lambda s: 0.5, {"forward": lambda s, q: q}, "forward force of the friction law"),
    ],
)
def test_what_is_wrong_with_a_law_is_said(force, options, message):
    with pytest.raises(ValueError, match="friction law") as error:
        friction_law(force, **options)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "force",
    [
        reads_json,
        lambda s: HOLDER.value if s > 1 else 0.5,
        lambda s: 0.5 if s > 1 else sorted([s, 1], key=abs)[0] * 0,
    ],
)
@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled without JIT")
def test_a_law_that_cannot_be_compiled_is_an_error_of_one_line(force):
    with pytest.raises(ValueError, match="can be neither recorded as a formula") as error:
        friction_law(force)
    assert "its steps depend on the value of its argument" in str(error.value)
    assert "nor compiled (" in str(error.value)
    assert "\n" not in str(error.value)


FORMULA = "mu + (1 - mu) * exp(-s / v)"
VALUES = {"mu": 0.3, "v": 0.1}


def test_a_formula_shares_its_kernels_with_the_same_function():
    law = friction_law(FORMULA, parameters=VALUES)
    same = friction_law(lambda s, mu, v: mu + (1 - mu) * np.exp(-s / v), parameters=VALUES)
    assert law.formula == same.formula
    assert law_code([law]) is law_code([same])
    backwards = friction_law(FORMULA, parameters=dict(reversed(VALUES.items())))
    assert law_code([backwards]) is law_code([law])
    assert backwards == law
    both = friction_law("a + 0*s", forward=FORMULA, parameters={**VALUES, "a": 0.5})
    assert list(both.parameters) == ["a", "mu", "v"]
    assert repr(law) == f"friction_law({FORMULA!r}, parameters={VALUES!r})"


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("exp(-s", {}, "the formula 'exp(-s' ends where ) is expected"),
        ("exp(-s)", {"forward": "1 +"}, "the formula '1 +' ends where a number, a name or ("),
        (
            "mu + 0*s",
            {},
            "needs a value for 'mu': parameters={'mu': ...} (a formula calls the speed s)",
        ),
        ("mu + s*0", {"parameters": {"mu": 0.3, "mue": 1}}, "no parameter 'mue'. Known: mu. Did"),
        ("mu / v", {"parameters": {"mu": 0.3, "v": 0.0}}, "failed at s = 0: ZeroDivisionError"),
        ("mu / v", {"parameters": {"mu": 0.3, "v": math.inf}}, "v must be a finite number"),
        ("sqrt(s)", {}, "'sqrt(s)' cannot be used: it has no Taylor series at s = 0"),
        ("s**p", {"parameters": {"p": 0.5}}, "it has no Taylor series at s = 0"),
        ("exp(s**4)", {}, "a law must be finite for 0 <= s <= 10"),
        ("2 - s", {}, "F(0) = 2.0 of the friction law '2 - s'; allowed: 0 <= F(0) <= 1"),
        ("law + 0*s", {"parameters": {"law": 0.3}}, "has a parameter law: model files mean"),
    ],
)
def test_what_is_wrong_with_a_formula_is_said(text, options, message):
    with pytest.raises(ValueError, match=r"friction law|the formula") as error:
        friction_law(text, **options)
    assert message in str(error.value)


def test_a_law_has_no_parameter_that_is_a_number_of_its_model():
    """It hid that number: `parameters` told the law's value for it."""
    for name in ("V", "damping", "units"):
        law = friction_law(f"{name} + 0*s", parameters={name: 0.3})
        with pytest.raises(ValueError, match=f" {name}: TwoBlock has one of that name"):
            ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
        assert ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=[law, law]).parameters
    law = friction_law("static + 0*s", parameters={"static": 0.3})
    with pytest.raises(ValueError, match=" static_1: Structure has one of"):
        ss.Structure([1.0], [1.0], contacts=[ss.Contact(at=0, friction=law, V=0.5)])


def test_a_formula_is_no_law_by_itself():
    with pytest.raises(ValueError, match=r"or a formula, in friction_law"):
        ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction="1 - s")
