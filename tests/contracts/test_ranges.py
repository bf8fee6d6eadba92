"""The range that a message allows is the one that holds, to the last digit of its ends."""

import re

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.maps.arguments import checked_range

COULOMB = ss.Coulomb(mu=0.3, viscous=0.1)
ANY_LAW = {"friction": COULOMB, "V": 0.04}
TWO = ss.TwoBlock(alpha=1.2, beta=1.3, damping=0.1, **ANY_LAW)
LAWS = [
    ss.PoppStelter(gamma=3, delta=0.1, eta=0.1),
    ss.Stribeck(mu=0.3, speed=0.1, viscous=0.1),
    ss.friction_law("1 / (1 + a * s)", parameters={"a": 3.0}),
    (COULOMB, ss.PoppStelter(gamma=3)),
]
WAVE = ss.Harmonic(0.3, frequency=0.45)
MODELS = [
    TWO,
    *(TWO.replace(friction=law) for law in LAWS),
    ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, damping=0.1, **ANY_LAW),
    ss.Blocks([1, 2], [[2, -1], [-1, 2]], np.eye(2), static=[1, 1.3], **ANY_LAW),
    ss.Oscillator(damping=0.1, **ANY_LAW),
    ss.Oscillator(damping=0.1, forcing=WAVE, **ANY_LAW),
    ss.Structure(
        [1, 1],
        [[2, 0.5], [0.5, 1]],
        contacts=[
            ss.Contact(at=0, friction=COULOMB, V=(0.5, WAVE), load=[0, 4]),
            ss.Contact(at=1, friction=ss.Coulomb(mu=0.5), stiffness=3.0),
        ],
        forcing=WAVE,
    ),
]
NUMBERS = [(model, name) for model in MODELS for name in model.parameters]
ALLOWED = re.compile(
    r"must be a finite number(?:, (?P<low>\S+) (?P<sign><=?) \S+ <= (?P<high>\S+)| "
    r"(?P<more>>=?) (?P<least>\S+))\. "
)
FAR = [-1e100, -1.0, -1e-100, 0.0, 1e-100, 1.5, 1e100]


def told(change, value):
    """What is said of a value; nothing if it is taken."""
    try:
        change(value)
    except ValueError as error:
        return str(error)
    return ""


def checked_ranges(change):
    """Ranges told of values that are refused; each holds at its ends, and at the floats beside."""
    ranges = {found.groups() for value in FAR if (found := ALLOWED.search(told(change, value)))}
    for low, sign, high, more, least in ranges:
        end = float(low or least)
        assert bool(told(change, end)) == ("=" not in (sign or more))
        assert told(change, np.nextafter(end, -np.inf))
        if high is None:
            assert not told(change, 2.0 * abs(end) + 1e-5)
            continue
        assert not told(change, float(high))
        assert told(change, np.nextafter(float(high), np.inf))
    return ranges


@pytest.mark.parametrize(("model", "name"), NUMBERS)
def test_a_model_takes_what_its_messages_allow(model, name):
    checked_ranges(lambda value: model.replace(**{name: value}))


@pytest.mark.parametrize("name", TWO.parameters)
def test_a_search_takes_what_its_messages_allow(name):
    f = ss.event_map(TWO)
    assert checked_ranges(lambda value: checked_range(f, name, sorted((value, 0.3))))


@pytest.mark.parametrize("value", [1e101, -1e160, 1e308])
@pytest.mark.parametrize(("model", "name"), NUMBERS)
def test_a_number_whose_products_are_none_is_refused(model, name, value):
    message = told(lambda number: model.replace(**{name: number}), value)
    assert str(value) in message
    assert "at most 1e+100 in size" in message or "must be" in message


def test_a_mass_whose_inverse_has_no_square_is_refused():
    """NumPy warned of an overflow, and the block rested at a rate of 0."""
    contacts = [ss.Contact(at=0, friction=ss.Coulomb(0.5), V=0.5)]
    for mass, name in (([1e-160], "mass[0]"), ([[1e-160]], "diagonal of mass[0]")):
        message = told(lambda mass: ss.Structure(mass, [1.0], contacts=contacts), mass)
        assert message.startswith(f"{name} = 1e-160 is not allowed")
        assert "positive ones at least 1e-100" in message


@pytest.mark.parametrize("stiff", [1e16, 1e100])
def test_a_stiff_spring_is_as_good_as_a_soft_one(stiff):
    blocks = MODELS[6]
    assert blocks.replace(stiffness_1_1=stiff).parameters["stiffness_1_1"] == stiff
    with pytest.raises(ValueError, match="stiffness has the eigenvalue -"):
        blocks.replace(stiffness_1_1=stiff, stiffness_2_2=-1.0)
