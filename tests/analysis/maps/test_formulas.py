"""Maps of the line given by formulas as text: the same answers as by callables, exact slopes."""

import pickle

import numpy as np
import pytest

import stickslip as ss
from stickslip.sweeps.identity import function_identity

A = 0.45


def by_formulas(**changes):
    given = {
        "func": ["a - 1.1*x - 0.35*x**2", "0.55*x - 0.62"],
        "domain": (-1.5, 1.5),
        "parameters": {"a": A},
        "breakpoints": [0.2],
    }
    return ss.PiecewiseMap(**{**given, **changes})


def by_callables():
    return ss.PiecewiseMap(
        lambda x, a: np.where(x < 0.2, a - 1.1 * x - 0.35 * x**2, 0.55 * x - 0.62),
        (-1.5, 1.5),
        parameters={"a": A},
        derivative=lambda x, a: np.where(x < 0.2, -1.1 - 0.7 * x, 0.55),
        parameter_derivative={"a": lambda x, a: np.where(x < 0.2, 1.0, 0.0)},
        breakpoints=[0.2],
    )


def test_values_and_slopes_are_those_of_the_callable():
    x = np.append(np.linspace(-1.5, 1.5, 101), 0.2)
    f, g = by_formulas().evaluate(x), by_callables().evaluate(x)
    assert np.allclose(f.value, g.value, rtol=1e-15, atol=1e-15)
    assert np.allclose(f.derivative, g.derivative, rtol=1e-15, atol=1e-15)
    assert np.array_equal(f.label, g.label)
    assert np.array_equal(f.margin, g.margin)
    slopes = (each.parameter_derivative(x, "a") for each in (by_formulas(), by_callables()))
    assert np.array_equal(*slopes)


def test_at_a_breakpoint_the_right_branch_holds():
    f = by_formulas()
    assert f(0.2) == 0.55 * 0.2 - 0.62
    assert f.evaluate(0.2).label == 1
    assert f.derivative(0.2) == 0.55


def test_what_is_found_is_found_alike():
    f, g = by_formulas(), by_callables()
    for ours, theirs in zip(ss.periodic_orbits(f, 4), ss.periodic_orbits(g, 4), strict=True):
        assert np.allclose(ours.points, theirs.points, rtol=1e-12)
    ours, theirs = (
        ss.bifurcations(each, "a", (0.3, 0.6), max_period=3, n_lists=6) for each in (f, g)
    )
    assert [b.kind for b in ours] == [b.kind for b in theirs]
    assert np.allclose([b.value for b in ours], [b.value for b in theirs], rtol=1e-9)


def test_breakpoints_move_with_parameters():
    f = by_formulas(breakpoints=["2*b"], parameters={"a": A, "b": 0.1})
    assert f.breakpoints == [0.2]
    assert f.replace(b=0.3).breakpoints == [0.6]
    assert f.replace(b=0.3)(0.4) == pytest.approx(A - 1.1 * 0.4 - 0.35 * 0.16, rel=1e-14)
    with pytest.raises(ValueError, match="increasing"):
        by_formulas(func=["x", "x", "x"], breakpoints=["b", "a"], parameters={"a": 0.1, "b": 0.2})


def test_one_formula_is_one_branch():
    f = ss.PiecewiseMap("r * x * (1 - x)", (0, 1), parameters={"r": 3.5})
    assert f(0.5) == 0.875
    assert f.derivative(0.25) == 3.5 * 0.5
    assert len(f.breakpoints) == 0
    assert ss.PiecewiseMap(["0.5"], (0, 1))(0.25) == 0.5


def test_a_formula_without_a_value_is_a_gap():
    f = ss.PiecewiseMap(["0.1", "0.1 - sqrt(x)", "1 / (x - 0.5)"], (-1, 1), breakpoints=[0, 0.5])
    assert f(0.0) == 0.1
    assert f.derivative(0.0) == -np.inf
    assert np.isnan(f.evaluate(0.5).value)


def test_it_shows_is_compared_and_pickled_by_its_texts():
    f = by_formulas()
    told = "PiecewiseMap('a - 1.1*x - 0.35*x**2' for x < 0.2, '0.55*x - 0.62', [-1.5, 1.5], a=0.45)"
    assert repr(f) == told
    assert f == by_formulas() == pickle.loads(pickle.dumps(f))
    assert hash(f) == hash(by_formulas())
    assert f.replace(a=0.5) != f == f.replace(a=0.5).replace(a=A)
    assert f != by_formulas(breakpoints=[0.3])
    assert f != by_formulas(func=["a - 1.1*x", "0.55*x - 0.62"])


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"func": ["a - ", "x"]}, r"func\[0\]: the formula 'a -' ends"),
        ({"func": ["a", "b * x"]}, r"func\[1\] = 'b \* x' names 'b'.*Known: a"),
        ({"func": ["a", "abs(x)"]}, r"func\[1\].*calls abs, which is not smooth"),
        ({"func": ["a", 3]}, r"func\[1\] = 3"),
        ({"func": ["a"]}, "1 formulas and breakpoints has 1"),
        ({"func": []}, "0 formulas"),
        ({"func": "x"}, "1 formulas and breakpoints has 1"),
        ({"breakpoints": None}, "2 formulas and breakpoints has 0"),
        ({"breakpoints": ["x"]}, r"breakpoints\[0\] = 'x': a breakpoint cannot depend on x"),
        ({"breakpoints": ["c"]}, r"breakpoints\[0\] = 'c' names 'c'"),
        ({"breakpoints": [np.nan]}, r"breakpoints\[0\]"),
        ({"breakpoints": "b"}, "a list is needed"),
        ({"breakpoints": lambda a: [a]}, "a list is needed"),
        ({"parameters": {"x": 1.0, "a": 1.0}}, r"parameters\['x'\]"),
        ({"parameters": {"exp": 1.0, "a": 1.0}}, r"parameters\['exp'\]"),
        ({"derivative": lambda x, a: x}, "derivative goes with a callable"),
        ({"label": lambda x, a: x}, "label goes with a callable"),
    ],
)
def test_what_cannot_be_read_is_named(changes, reason):
    with pytest.raises(ValueError, match=reason):
        by_formulas(**changes)


def test_a_sweep_knows_a_map_by_its_texts():
    f = by_formulas()
    assert function_identity(f.func) == function_identity(by_formulas().func)
    assert function_identity(f.func) != function_identity(by_formulas(breakpoints=[0.3]).func)
    assert list(f.callables) == ["func"]
