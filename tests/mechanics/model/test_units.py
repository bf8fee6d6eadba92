"""Physical scales: definitions under eq. (6a), there and back."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Quantity, Units

SIZE = st.floats(1e-3, 1e3)
UNITS = st.builds(Units, m=SIZE, k=SIZE, fs1=SIZE)


@given(units=UNITS, quantity=st.sampled_from(get_args(Quantity)), value=st.floats(-1e3, 1e3))
def test_values_come_back(units, quantity, value):
    there = units.to_physical(quantity, value)
    assert units.to_dimensionless(quantity, there) == pytest.approx(value, rel=1e-15)


@given(units=UNITS)
def test_scales_belong_together(units):
    length, time = units.scale("displacement"), units.scale("time")
    assert units.scale("velocity") == pytest.approx(length / time, rel=1e-14)
    assert units.scale("acceleration") == pytest.approx(length / time**2, rel=1e-14)
    assert units.scale("force") == pytest.approx(units.m * length / time**2, rel=1e-14)
    assert units.scale("energy") == pytest.approx(units.scale("force") * length, rel=1e-14)
    assert units.scale("frequency") == pytest.approx(1.0 / time, rel=1e-14)


@given(m=SIZE, k=SIZE, k12=st.floats(0, 1e3), fs1=SIZE, fs2=SIZE, v_dr=SIZE)
def test_model_returns_the_physical_parameters_it_was_built_from(m, k, k12, fs1, fs2, v_dr):
    physical = {"m": m, "k": k, "k12": k12, "fs1": fs1, "fs2": fs2, "v_dr": v_dr}
    model = TwoBlock.from_physical(**physical, friction=Coulomb(mu=0.3))
    assert model.physical_parameters() == pytest.approx(physical, rel=1e-14)


def test_definitions_under_equation_6a():
    m, k, k12, fs1, fs2, v_dr = 2.0, 5.0, 6.0, 3.0, 4.0, 0.7
    model = TwoBlock.from_physical(
        m=m, k=k, k12=k12, fs1=fs1, fs2=fs2, v_dr=v_dr, friction=Coulomb(mu=0.3)
    )
    assert model.alpha == k12 / k
    assert model.beta == fs2 / fs1
    assert model.V == pytest.approx(v_dr * np.sqrt(k * m) / fs1, rel=1e-15)
    assert model.units.to_dimensionless("displacement", 0.2) == pytest.approx(k * 0.2 / fs1)
    assert model.units.to_dimensionless("time", 0.2) == pytest.approx(np.sqrt(k / m) * 0.2)


def test_dimensionless_equation_of_motion_is_the_physical_one_scaled():
    """Force balance (7) of block 1 divided by f_s1 is (7a), at an arbitrary state."""
    units = Units(m=2.0, k=5.0, fs1=3.0)
    k12, a, x1, x2, friction = 6.0, 0.4, 0.11, -0.23, 1.7
    physical = units.m * a + units.k * x1 + k12 * (x1 - x2) - friction
    alpha = k12 / units.k
    A = units.to_dimensionless("acceleration", a)
    X1, X2 = units.to_dimensionless("displacement", [x1, x2])
    F = units.to_dimensionless("force", friction)
    assert A + X1 + alpha * (X1 - X2) - F == pytest.approx(physical / units.fs1, rel=1e-14)


@pytest.mark.parametrize("name", ["m", "k", "fs1"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "1", True])
def test_bad_scales_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=rf"^{name} = .*finite number > 0"):
        Units(**({"m": 1.0, "k": 1.0, "fs1": 1.0} | {name: value}))


@pytest.mark.parametrize(
    ("name", "value"), [("k12", -1.0), ("fs2", 0.0), ("v_dr", -0.1), ("m", np.nan)]
)
def test_from_physical_names_the_physical_quantity(name, value):
    good = {"m": 1.0, "k": 1.0, "k12": 1.0, "fs1": 1.0, "fs2": 1.0, "v_dr": 0.1}
    with pytest.raises(ValueError, match=rf"^{name} = "):
        TwoBlock.from_physical(**(good | {name: value}), friction=Coulomb(mu=0.3))


def test_unknown_quantity_is_answered_with_a_suggestion():
    with pytest.raises(ValueError, match="Did you mean 'velocity'"):
        Units(1, 1, 1).scale("velocty")


def test_dimensionless_model_says_that_it_has_no_scales():
    model = TwoBlock(1.2, 1.3, 0.1, Coulomb(mu=0.3))
    with pytest.raises(ValueError, match="no physical scales"):
        model.physical_parameters()
    assert model.physical_parameters(Units(1, 2, 3))["k12"] == pytest.approx(2.4)
