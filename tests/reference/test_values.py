"""The recorded digits are those that the oracles give; and `settle` tells right from wrong."""

import math

import pytest
from flint import arb
from tests.reference import values
from tests.reference.settle import EXCUSED, GAVE_UP, RIGHT, WRONG, settle


def test_the_recorded_constants_are_what_the_oracles_give():
    made = [line for line in values.lines() if not line.startswith("#")]
    with open(values.__file__) as source:
        recorded = source.read()
    for line in made:
        assert line in recorded


@pytest.mark.paper
def test_fixed_points_are_where_the_paper_draws_them():
    near = {"S1": -0.0399, "U1": 0.0886, "U2": 0.3716, "S4": 0.2774}
    for name, (point, multiplier) in values.COULOMB_ORBITS.items():
        assert float(point) == pytest.approx(near[name], abs=1e-4)
        assert (abs(float(multiplier)) < 1) == name.startswith("S")
    assert float(values.LAW9_ORBITS["P1"][0]) == pytest.approx(0.3833, abs=1e-4)


def test_a_value_near_rounding_is_right_and_one_off_by_more_is_wrong():
    system, d = values.paper_coulomb(), 0.3
    exact = system.motion(d).value
    assert settle(system, d, float(exact), "OK", 1e-14).verdict == RIGHT
    assert settle(system, d, float(exact) + 1e-11, "OK", 1e-14).verdict == WRONG
    assert settle(system, d, math.nan, "OK", 1e-14).verdict == WRONG
    assert settle(system, d, math.nan, "NEVER_CYCLE", 1e-14).verdict == WRONG
    assert settle(system, d, math.nan, "EVENT_LIMIT", 1e-14).verdict == GAVE_UP


@pytest.mark.parametrize("jump", values.COULOMB_JUMPS)
def test_the_other_side_of_a_jump_is_excused_only_next_to_it(jump):
    system = values.paper_coulomb()
    d, left, right = (arb(part) for part in jump)
    below = float(d)
    below = below if arb(below) < d else math.nextafter(below, -1)
    assert settle(system, below, float(left), "OK", 1e-14).verdict == RIGHT
    assert settle(system, below, float(right), "OK", 1e-14).verdict == EXCUSED
    assert settle(system, below - 1e-12, float(right), "OK", 1e-14).verdict == WRONG


def test_a_status_is_judged():
    system = values.Coulomb(1.2, 1.3, 0.2, 0.05)
    assert settle(system, 0.48, math.nan, "NEVER_CYCLE", 1e-14).verdict == RIGHT
    assert settle(system, 0.48, 0.1, "OK", 1e-14).verdict == WRONG
    assert settle(system, 0.48, math.nan, "NEVER_SLIPPING", 1e-14).verdict == WRONG
