"""The built-in laws against their equations, and laws as text."""

import copy
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from stickslip.mechanics.friction import (
    LAWS,
    Coulomb,
    FrictionLaw,
    PoppStelter,
    Stribeck,
    TabulatedFriction,
)
from stickslip.mechanics.friction.values import parse_law

SPEEDS = st.floats(0, 10)


@given(s=SPEEDS, mu=st.floats(0, 1), c=st.floats(0, 2))
def test_coulomb_is_eq_8(s, mu, c):
    assert Coulomb(mu).force(s) == mu
    assert Coulomb(mu).slope(s) == 0.0
    assert Coulomb(mu, viscous=c).force(s) == mu + c * s
    assert Coulomb(mu, viscous=c).slope(s) == c


@given(w=st.floats(-5, 5), gamma=st.floats(0, 5), delta=st.floats(0, 1), eta=st.floats(0, 1))
def test_popp_stelter_is_both_lines_of_eq_9(w, gamma, delta, eta):
    if w < 0:  # V_dr > X': the first line, in w = X' - V_dr
        paper = (1 - delta) / (1 - gamma * w) + delta + eta * w**2
    else:
        paper = -(1 - delta) / (1 + gamma * w) - delta - eta * w**2
    sign = -1.0 if w < 0 else 1.0  # of -0.0 as of 0.0, like in the equation
    force = -sign * PoppStelter(gamma, delta, eta).force(abs(w))
    assert force == pytest.approx(paper, rel=1e-15)


@given(s=SPEEDS, mu=st.floats(0, 1), speed=st.floats(0.01, 5), n=st.sampled_from([1, 2]))
def test_stribeck_falls_from_the_static_limit(s, mu, speed, n):
    law = Stribeck(mu, speed, viscous=0.1, exponent=n)
    assert law.static_value() == 1.0
    assert law.slope(0.0) == pytest.approx(0.1 - (1 - mu) / speed * (n == 1), rel=1e-14)
    expected = mu + (1 - mu) * np.exp(-((s / speed) ** n)) + 0.1 * s
    assert law.force(s) == pytest.approx(expected, rel=1e-15)


def test_viscous_friction_is_a_parameter_of_coulomb_only_where_there_is_some():
    assert Coulomb(0.22).parameters == {"mu": 0.22}
    assert Coulomb(0.22, viscous=0.1).parameters == {"mu": 0.22, "viscous": 0.1}
    assert Coulomb(0.22).replace(viscous=0.1) == Coulomb(0.22, 0.1)
    assert PoppStelter(3).parameters == {"gamma": 3.0, "delta": 0.0, "eta": 0.0}


def test_an_exponent_is_a_choice_and_no_parameter():
    law = Stribeck(0.3, 0.1, exponent=2)
    assert "exponent" not in law.parameters
    assert law.replace(exponent=1) == Stribeck(0.3, 0.1)
    assert law.replace(exponent=1).formula != law.formula


def test_numbers_of_any_kind_become_floats():
    law = PoppStelter(np.float32(3), np.int64(0), 0)
    assert law == PoppStelter(3.0)
    assert all(type(value) is float for value in law.parameters.values())
    assert repr(law) == "PoppStelter(gamma=3.0, delta=0.0, eta=0.0)"


def test_what_is_written_by_str_is_read_by_parse_law():
    assert str(Coulomb(0.22)) == "coulomb:mu=0.22"
    assert parse_law(" popp-stelter: gamma=3 , delta=1e-1 ") == PoppStelter(3, 0.1)
    assert parse_law("Popp_Stelter:gamma=3") == PoppStelter(3)
    assert parse_law("stribeck:mu=0.2,speed=0.1,exponent=2") == Stribeck(0.2, 0.1, exponent=2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "coulumb:mu=0.2",
            "stribeck. Did you mean 'coulomb'?",
        ),
        ("", "the formula '' ends where a number, a name or ( is expected"),
        ("mu", "no friction law 'mu'"),
        ("popp-stelte", "Did you mean 'popp-stelter'?"),
        ("mu + exp(-s)", "needs a value for mu: write ', mu=...' behind it"),
        (
            "mu + exp(-s / v), mue=0.3",
            "needs values for mu, v: write ', mu=..., v=...' behind it; it has no mue",
        ),
        ("exp(-s), mu=0.3", "has no parameter 'mu'. Known: none."),
        ("exp(-s) mu=0.3", "has 'mu' at character 9"),
        ("exp(-s), 0.3", "has ',' at character 8"),
        ("law * exp(-s), law=0.3", "has a parameter law: model files mean something else"),
        ("exp(-s), forward=exp(-s * forward)", "has a parameter forward"),
        ("exp(-s), forward=exp(-s", "the formula 'exp(-s' ends where ) is expected"),
        ("mu + 0*s, mu=x", "mu = 'x' of a friction law is not a number"),
        ("coulomb", "needs a value for 'mu'"),
        ("coulomb:mu", "'mu' in 'coulomb:mu' is not of the form NAME=VALUE"),
        ("coulomb:mu=", "mu = '' of a friction law is not a number"),
        ("coulomb:mu=x", "mu = 'x' of a friction law is not a number"),
        (
            "coulomb:mu=nan",
            "mu = nan of the friction law coulomb is not allowed: mu must",
        ),
        (
            "coulomb:mu=1.5",
            "coulomb is not allowed: mu must be a finite number, 0 <= mu <= 1",
        ),
        ("coulomb:mu=0.2,mu=0.3", "'mu' is given twice"),
        ("coulomb:gamma=3", "friction law coulomb has no parameter 'gamma'"),
        ("popp-stelter:gama=3", "Did you mean 'gamma'"),
        (
            "stribeck:mu=0.2,speed=0",
            "stribeck is not allowed: speed must be a finite number > 0",
        ),
        (
            "stribeck:mu=0.2,speed=1,exponent=3",
            "is not allowed: exponent must be 1 or 2",
        ),
    ],
)
def test_text_that_is_no_law(text, message):
    with pytest.raises(ValueError, match=r"law|form|twice") as error:
        parse_law(text)
    assert message in str(error.value)


def test_the_table_of_laws_names_each_by_its_own_name():
    assert {name: law.name for name, law in LAWS.items()} == {name: name for name in LAWS}


def test_what_laws_are_made_of_is_no_law():
    with pytest.raises(TypeError, match="FrictionLaw has no equation"):
        FrictionLaw()


def test_replace_suggests_the_parameter_that_was_meant():
    with pytest.raises(ValueError, match=r"no parameter 'gama'\. Known: .* Did you mean 'gamma'\?"):
        PoppStelter(3).replace(gama=2)


TABLE = {"speed": [0, 0.1, 0.5, 2], "force": [1, 0.6, 0.3, 0.35]}


def test_a_table_is_a_value():
    law = TabulatedFriction(**TABLE)
    assert eval(repr(law)) == law == law.replace() == copy.deepcopy(law)
    assert law == pickle.loads(pickle.dumps(law))
    assert len({law, TabulatedFriction(np.array(TABLE["speed"]), np.array(TABLE["force"]))}) == 1
    assert law.replace(force=[1, 1, 1, 1]).force(0.3) == 1.0
    assert law.parameters == {}
    assert law.knots == (0.1, 0.5, 2.0)
    assert law.traceable
    assert law.symmetric


@given(
    steps=st.lists(st.floats(1e-3, 1), min_size=1, max_size=8),
    # not below normal numbers: there scipy's curve overflows
    forces=st.lists(st.floats(0, 1, allow_subnormal=False), min_size=9, max_size=9),
)
def test_a_table_is_scipys_monotone_curve(steps, forces):
    speed = np.concatenate([[0.0], np.cumsum(steps)])
    force = np.array(forces[: speed.size])
    law = TabulatedFriction(speed, force)
    s = np.linspace(0.0, speed[-1], 501)
    curve = PchipInterpolator(speed, force)
    steepest = np.abs(np.diff(force) / np.diff(speed)).max()
    np.testing.assert_allclose(law.force(s), curve(s), rtol=0, atol=1e-15)
    np.testing.assert_allclose(law.slope(s), curve(s, 1), rtol=0, atol=1e-14 * (1 + steepest))
    assert law.force(speed[-1] + 1.0) == force[-1]
    assert law.slope(speed[-1] + 1.0) == 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": [0, 0.1, 0.5]}, "3 speeds and 4 forces"),
        ({"speed": [0.0], "force": [1.0]}, "two or more"),
        ({"speed": [0.01, 0.1, 0.5, 2]}, r"speed\[0\] = 0\.01 .* must be 0"),
        ({"speed": [0, 0.5, 0.1, 2]}, r"speed\[2\] = 0\.1 .* larger than speed\[1\] = 0\.5"),
        ({"speed": [0, 0.1, 0.1, 2]}, r"speed\[2\] = 0\.1"),
        ({"speed": [0, 0.1, math.nan, 2]}, r"speed\[2\] = nan"),
        ({"speed": 3.0}, "speed = 3.0 .* list"),
        ({"force": [1, 0.6, -0.3, 0.35]}, r"force\[2\] = -0\.3 .* >= 0"),
        ({"force": [1.2, 0.6, 0.3, 0.35]}, r"F\(0\) = 1\.2"),
        ({"force": "abcd"}, "force = 'abcd'"),
        ({"force": [1, 0.6, None, 0.35]}, r"force\[2\] = None"),
    ],
)
def test_bad_tables_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        TabulatedFriction(**{**TABLE, **change})
