"""Taylor recurrences against expansions in higher precision, for formulas at random."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from stickslip.numerics.expression import ELEMENTARY, Graph, derivative, elementary, evaluate, power
from stickslip.numerics.series import Scalars, SeriesText, indented, value_lines

ORDER = 7
# Rounding of a coefficient, relative to the largest coefficient of any row up to it, squared
# since a product multiplies two; a wrong recurrence is wrong in the first digit.
ROUNDING = 1e-12
MPMATH = {name: getattr(mpmath, name) for name in ELEMENTARY}

# Each keeps its argument where the function is analytic and of moderate size.
UNARY = {
    "exp": lambda f, x: f("exp", -(x * x)),
    "expm1": lambda f, x: f("expm1", 0.5 * x),
    "log": lambda f, x: f("log", x * x + 1.5),
    "log1p": lambda f, x: f("log1p", x * x),
    "sqrt": lambda f, x: f("sqrt", x * x + 0.5),
    "sin": lambda f, x: f("sin", x),
    "cos": lambda f, x: f("cos", 1.5 * x),
    "tan": lambda f, x: f("tan", 0.5 * f("sin", x)),
    "sinh": lambda f, x: f("sinh", f("sin", x)),
    "cosh": lambda f, x: f("cosh", f("cos", x)),
    "tanh": lambda f, x: f("tanh", x),
    "atan": lambda f, x: f("atan", 2.0 * x),
    "asinh": lambda f, x: f("asinh", x - 0.25),
    "reciprocal": lambda f, x: 1.0 / (x * x + 0.75),
    "cube": lambda f, x: x**3,
    "power": lambda f, x: f("power", x * x + 0.7, 1.3),
    "parameter power": lambda f, x: f("power", x * x + 0.7, f("b")),
}
BINARY = {
    "add": lambda f, x, y: x + y,
    "subtract": lambda f, x, y: x - y,
    "multiply": lambda f, x, y: x * y,
    "divide": lambda f, x, y: x / (y * y + 1.25),
    "scaled": lambda f, x, y: f("a") * x - y / f("b"),
    "power": lambda f, x, y: f("power", x * x + 0.7, f("sin", y)),
}
TREES = st.recursive(
    st.sampled_from(["s", "s", "a", "b"]) | st.floats(-2, 2).map(lambda x: round(x, 3)),
    lambda trees: (
        st.tuples(st.sampled_from(sorted(UNARY)), trees)
        | st.tuples(st.sampled_from(sorted(BINARY)), trees, trees)
    ),
    max_leaves=6,
)
POLYNOMIALS = st.lists(st.floats(-1, 1), min_size=ORDER + 1, max_size=ORDER + 1)


def build(tree, function):
    """The formula of a tree; `function` gives symbols and elementary functions."""
    if isinstance(tree, str):
        return function(tree)
    if isinstance(tree, float):
        return tree
    name, *operands = tree
    table = UNARY if len(operands) == 1 else BINARY
    return table[name](function, *(build(operand, function) for operand in operands))


def recorded(tree):
    graph = Graph("s")

    def function(name, *arguments):
        if not arguments:
            return graph.symbol(name)
        operands = [graph.constant(x) if isinstance(x, float) else x for x in arguments]
        return power(*operands) if name == "power" else elementary(name, operands[0])

    result = build(tree, function)
    return graph, graph.constant(result) if isinstance(result, float) else result


def exact(tree, symbols):
    def function(name, *arguments):
        if not arguments:
            return symbols[name]
        if name == "power":
            return mpmath.power(*arguments)
        return MPMATH[name](*arguments)

    return build(tree, function)


def advance_function(graph, outputs, first_row):
    """Run generated text as plain Python: rows and p in, coefficient k of everything out."""
    scalars = Scalars(graph, {"a": 0, "b": 1}, 2)
    series = SeriesText(scalars, outputs, {graph.symbol("s").number: 0}, first_row)
    text = [
        "def advance(rows, p, k):",
        "    if k == 0:",
        *indented(series.start or ["pass"], 2),
        "    else:",
        *indented(series.advance or ["pass"], 2),
    ]
    names = {"math": math}
    exec("\n".join(text), names)
    return names["advance"], series, scalars


def parameters(scalars, a, b):
    constants = evaluate(scalars.graph, scalars.constants, {"a": a, "b": b})
    return np.array([a, b, *constants])


@settings(max_examples=150)
@given(tree=TREES, polynomial=POLYNOMIALS, a=st.floats(0.3, 2), b=st.floats(0.3, 2))
def test_series_of_random_formulas(tree, polynomial, a, b):
    graph, formula = recorded(tree)
    advance, series, scalars = advance_function(graph, {1: formula.number}, first_row=2)
    rows = np.full((series.next_row, ORDER + 1), np.nan)
    rows[0] = polynomial
    p = parameters(scalars, a, b)
    for k in range(ORDER + 1):
        rows[0, k + 1 :] = np.nan  # nothing may be read that is not known yet
        advance(rows, p, k)
        if k < ORDER:
            rows[0, k + 1] = polynomial[k + 1]
    assume(np.nanmax(abs(rows)) < 1e6)

    with mpmath.workdps(50):
        symbols = {"a": mpmath.mpf(a), "b": mpmath.mpf(b)}

        def composed(t):
            s = sum(c * t**k for k, c in enumerate(polynomial))
            return mpmath.mpf(exact(tree, {**symbols, "s": s}))

        expected = [float(c) for c in mpmath.taylor(composed, 0, ORDER)]
    for k in range(ORDER + 1):
        size = max(1.0, np.abs(rows[:, : k + 1]).max())
        assert rows[1, k] == pytest.approx(expected[k], abs=ROUNDING * size**2), (k, tree)


@settings(max_examples=60)
@given(tree=TREES, s=st.floats(-1, 1), a=st.floats(0.3, 2), b=st.floats(0.3, 2))
def test_values_and_derivatives_of_random_formulas(tree, s, a, b):
    graph, formula = recorded(tree)
    scalars = Scalars(graph, {"a": 0, "b": 1}, 2)
    wanted = {f"out[{i}]": derivative(formula, graph.symbol(n)) for i, n in enumerate("sab")}
    wanted["out[3]"] = formula
    text = value_lines(scalars, {name: node.number for name, node in wanted.items()})
    names = {"math": math, "s": s, "p": parameters(scalars, a, b), "out": np.zeros(4)}
    exec("\n".join(text), names)
    with mpmath.workdps(40):
        point = tuple(map(mpmath.mpf, (s, a, b)))

        def function(*values):
            return exact(tree, dict(zip("sab", values, strict=True)))

        expected = [
            mpmath.diff(function, point, order) for order in [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
        ]
        expected.append(mpmath.mpf(function(*point)))
    for found, reference in zip(names["out"], expected, strict=True):
        assert found == pytest.approx(float(reference), rel=1e-10, abs=1e-10)


def test_sums_look_back_only_at_what_they_need():
    graph = Graph("s")
    s, a = graph.symbol("s"), graph.symbol("a")
    formula = a * (2 - s) + 3 * s - a  # linear: no row, no loop
    _, series, scalars = advance_function(graph, {1: formula.number}, first_row=2)
    assert series.next_row == 2
    assert not any("for" in line for line in series.advance)
    assert scalars.constants == []


def test_constants_made_of_parameters_are_computed_once():
    graph = Graph("s")
    s, a = graph.symbol("s"), graph.symbol("a")
    formula = elementary("exp", a) * s + (1 - a) / (1 + s)
    _, series, scalars = advance_function(graph, {1: formula.number}, first_row=2)
    assert len(scalars.constants) == 2
    assert not any("exp" in line for line in series.start + series.advance)


def test_the_text_of_a_formula_is_always_the_same():
    def text():
        graph = Graph("s")
        s, a = graph.symbol("s"), graph.symbol("a")
        formula = elementary("sin", a * s) / (1 + s) + elementary("tanh", s)
        slope = derivative(formula, s)
        return advance_function(graph, {1: formula.number, 2: slope.number}, 3)[1]

    assert text().advance == text().advance
    assert text().start == text().start
