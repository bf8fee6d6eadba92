"""Distributions of parameters against closed forms, draw by draw."""

from typing import Any

import numpy as np
import pytest
from tests.sizes import sizes

import stickslip as ss

BLOCK = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=1.4)


def threshold(model: Any) -> float:
    """Belt speed above which sliding is stable; IndexError where it is at all speeds."""
    return float(ss.equilibria(model)[0].hopf_points[0].V)


@pytest.mark.parametrize("n", sizes(10, 50))
def test_a_threshold_is_that_of_its_closed_form_and_absent_where_there_is_none(n: int) -> None:
    damping = np.random.default_rng(1).normal(1.5, 0.3, size=n)
    found = ss.propagate(BLOCK, {"damping": damping}, threshold)
    # F' = -c: V = speed log((1 - mu) / (c speed)), as long as it is positive.
    with np.errstate(invalid="ignore"):
        closed = 0.3 * np.log(0.5 / (0.3 * damping))
    closed[closed <= 0.0] = np.nan
    np.testing.assert_allclose(found.values, closed, rtol=1e-9)
    known = closed[np.isfinite(closed)]
    assert found.value == pytest.approx(np.median(known), rel=1e-9)
    np.testing.assert_allclose(found.interval, np.quantile(known, [0.025, 0.975]), rtol=1e-9)
    (why,) = found.absent
    assert why.startswith("IndexError")
    assert found.absent_share == np.isnan(closed).mean() > 0.0
    assert str(np.isnan(closed).sum()) in repr(found)
    assert list(found.table()) == ["damping", "quantity"]


@pytest.mark.parametrize("n", sizes(10, 50))
def test_a_share_of_a_basin_is_that_of_its_closed_form(n: int) -> None:
    # x^2 / c: orbits from above c leave the domain, the others come to 0.
    f = ss.PiecewiseMap(lambda x, c: x * x / c, (0.0, 1.0), parameters={"c": 0.5})
    c = np.random.default_rng(2).uniform(0.3, 0.7, size=n)
    found = ss.propagate(
        f, {"c": c}, ss.observables.CoexistingAttractors(n_starts=256), variable="left_share"
    )
    np.testing.assert_allclose(found.values, 1.0 - c, atol=1.0 / 256, rtol=0.0)  # one of each cell


def test_all_draws_at_once_are_what_a_sweep_computes(tmp_path: Any) -> None:
    model, V = ss.examples.coulomb(), np.array([0.0366, 0.05, 0.15])
    exponents = ss.observables.LyapunovExponent()
    at_once = ss.propagate(model, {"V": V}, exponents)
    swept = ss.sweep(model, {"V": V}, [exponents], store=tmp_path / "swept")
    (name, *_) = [output.name for output in exponents.outputs()]
    np.testing.assert_array_equal(at_once.values, swept[name].values)
    with_illegal = ss.propagate(model, {"V": [*V, -1.0]}, exponents)
    np.testing.assert_array_equal(with_illegal.values, [*at_once.values, np.nan])
    assert list(with_illegal.absent.values()) == [1]


def test_draws_that_are_not_allowed_are_absent_and_told_once() -> None:
    mu = [0.4, 0.5, 1.2, 1.3]
    found = ss.propagate(BLOCK, {"mu": mu}, lambda model: [model.friction.mu, 2 * model.V])
    np.testing.assert_array_equal(found.values[:2], [[0.4, 0.4], [0.5, 0.4]])
    assert np.isnan(found.values[2:]).all()
    np.testing.assert_allclose(found.value, [0.45, 0.4], rtol=1e-15)
    ((why, count),) = found.absent.items()
    assert "1.2" in why
    assert count == 2


def test_what_returns_nan_is_absent() -> None:
    found = ss.propagate(
        BLOCK, {"V": [0.1, 0.2]}, lambda model: np.nan if model.V > 0.15 else model.V
    )
    assert found.value == 0.1
    assert found.absent == {"NaN": 1}


def test_a_fault_of_the_function_is_not_hidden() -> None:
    with pytest.raises(AttributeError):
        ss.propagate(BLOCK, {"V": [0.1]}, lambda model: model.speed)


@pytest.mark.parametrize(
    ("draws", "quantity", "variable", "told"),
    [
        ({"V": [0.1]}, lambda model: 1 / (model.V - 0.1), None, "no draw has it"),
        ({"V": [-0.1]}, "limit_cycles", None, "no draw has it"),
        ({"V": [0.1, 0.2]}, lambda model: [1.0] * round(10 * model.V), None, "several shapes"),
        ({"v": [0.1]}, threshold, None, "not a parameter"),
        ({"V": [0.1], "mu": [0.4, 0.5]}, threshold, None, "equally many"),
        ({"V": []}, threshold, None, "at least one"),
        ({"V": [0.1], "mu": []}, threshold, None, "equally many"),
        ({}, threshold, None, "at least one"),
        ({"V": [0.1]}, threshold, "V", "is a function"),
        ({"V": [0.1]}, "attractor", None, "no event map"),
        ({"V": [0.1]}, ss.observables.LimitCycles, None, "LimitCycles.*unknown"),
        ({"V": [0.1]}, ["limit_cycles", "attractor"], None, "unknown"),
        ({"V": [0.1]}, "limit_cycles", "cycles", "variable"),
    ],
)
def test_what_is_not_allowed_is_told(
    draws: Any, quantity: Any, variable: str | None, told: str
) -> None:
    with pytest.raises(ValueError, match=told):
        ss.propagate(BLOCK, draws, quantity, variable=variable)


def test_a_histogram_is_drawn() -> None:
    found = ss.propagate(BLOCK, {"V": [0.1, 0.2, 0.3]}, lambda model: model.V)
    assert len(found.plot().lines) == 3
    pairs = ss.propagate(BLOCK, {"V": [0.1, 0.2]}, lambda model: [model.V, 1.0])
    with pytest.raises(ValueError, match="histogram"):
        pairs.plot()


def test_a_parameter_called_quantity_keeps_its_draws() -> None:
    f = ss.PiecewiseMap("quantity * x * (1 - x)", (0, 1), parameters={"quantity": 3.2})
    found = ss.propagate(f, {"quantity": [3.1, 3.3]}, lambda f: f.parameters["quantity"] ** 2)
    assert found.table()["parameter_quantity"].tolist() == [3.1, 3.3]
    assert found.table()["quantity"].tolist() == [3.1**2, 3.3**2]
