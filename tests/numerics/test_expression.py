"""Formulas: what is recorded, how it is simplified, what is refused."""

import math
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.numerics.expression import (
    ELEMENTARY,
    Graph,
    NotTraceable,
    derivative,
    elementary,
    evaluate,
    gathered,
    is_analytic,
    reachable,
)
from stickslip.numerics.tracing import trace

SPEEDS = st.floats(0.01, 3)
MPMATH = {name: getattr(mpmath, name) for name in ELEMENTARY}


@pytest.fixture
def graph():
    return Graph("s")


def value(expression, **symbols):
    return evaluate(expression.graph, [expression.number], symbols)[0]


def test_equal_operations_are_one_node(graph):
    s, a = graph.symbol("s"), graph.symbol("a")
    assert (1 + a * s).number == (s * a + 1.0).number
    assert (s - (-a)).number == (s + a).number


def test_constants_are_folded(graph):
    s = graph.symbol("s")
    assert ((2.0 * 3 + np.float64(1)) * s).node == (7 * s).node
    assert (s * 1).number == s.number
    assert (0 * s + 0.5).node.value == 0.5
    assert (s**0).node.value == 1.0
    assert np.exp(s * 0).node.value == 1.0


@pytest.mark.parametrize("exponent", [1, 2, 3, 7, 2.0, -1, -3])
def test_integer_powers_are_products_and_work_at_zero(graph, exponent):
    power = graph.symbol("s") ** exponent
    ops = {graph.nodes[number].op for number in reachable(graph, [power.number])}
    assert ops <= {"symbol", "constant", "multiply", "reciprocal"}
    assert value(power, s=1.25) == pytest.approx(1.25**exponent, rel=1e-15)
    assert is_analytic(graph, [power.number], {"s": 0.0}) is (exponent > 0)


@pytest.mark.parametrize(
    ("text", "regular"),
    [
        ("s**1.5", False),
        ("sqrt(s)", False),
        ("log(s)", False),
        ("1/s", False),
        ("(1+s)**1.5", True),
        ("sqrt(1+s)", True),
        ("log1p(s)", True),
        ("s**a", False),
        ("(1+s)**a", True),
        ("exp(-s)/(2-s)", True),
    ],
)
def test_singular_formulas_are_told_apart(graph, text, regular):
    names = {name: (lambda x, name=name: elementary(name, x)) for name in ELEMENTARY}
    names |= {"s": graph.symbol("s"), "a": graph.symbol("a")}
    formula = eval(text, names)
    assert is_analytic(graph, [formula.number], {"s": 0.0, "a": 1.5}) is regular


@pytest.mark.parametrize(
    "function",
    [
        lambda s: 1.0 if s > 1 else 2.0,
        lambda s: 1.0 if s == 0 else 2.0,
        lambda s: max(s, 1.0),
        lambda s: np.maximum(s, 1.0),
        lambda s: np.where(s > 1, 1.0, 2.0),
        lambda s: math.erf(s),
        lambda s: math.floor(s),
        lambda s: float(s),
        lambda s: int(s),
        lambda s: s // 1,
        lambda s: s % 1,
        lambda s: abs(s - 1),
        lambda s: s + 1j,
        lambda s: s / 0,
        lambda s: math.inf * s,
        lambda s: np.array([s]) + 1,
        lambda s: [s],
        lambda s: True,
        lambda s: "s",
        lambda s: None,
        lambda s: 1 / 0,
    ],
)
def test_what_is_no_formula_is_refused(graph, function):
    with pytest.raises(NotTraceable):
        trace(function, graph)


HELPERS = SimpleNamespace(decay=0.5)


def helper(x):
    return math.exp(-HELPERS.decay * x)


def closed_over(scale):
    root = math.sqrt

    def function(s):
        return helper(s) + root(scale + np.cos(s) ** 2) + math.pow(s, 2)

    return function


@given(s=SPEEDS)
def test_numpy_math_helpers_and_closures_are_recorded(s):
    function = closed_over(2.0)
    recorded = trace(function, Graph("s"))
    assert value(recorded, s=s) == pytest.approx(function(s), rel=1e-15)


def test_tracing_leaves_the_function_as_it_was():
    function = closed_over(2.0)
    before = function(0.7)
    trace(function, Graph("s"))
    assert function(0.7) == before
    assert math.exp(0.0) == 1.0


@pytest.mark.parametrize("name", ELEMENTARY)
@pytest.mark.parametrize("library", [np, math])
def test_every_elementary_function_is_recorded_from_both_libraries(name, library, graph):
    entry = ELEMENTARY[name]
    function = entry.ufunc if library is np else entry.scalar
    assert trace(lambda s: function(0.3 + s), graph).node.op == name
    assert value(elementary(name, graph.symbol("s")), s=0.6) == pytest.approx(
        float(MPMATH[name](0.6)), rel=1e-15
    )


@pytest.mark.parametrize("name", ELEMENTARY)
@given(s=SPEEDS)
def test_derivatives_of_elementary_functions(name, s):
    if name == "tan" and abs(math.cos(s)) < 0.1:
        s = 0.5
    graph = Graph("s")
    slope = derivative(elementary(name, graph.symbol("s")), graph.symbol("s"))
    with mpmath.workdps(40):
        expected = float(mpmath.diff(MPMATH[name], mpmath.mpf(s)))
    assert value(slope, s=s) == pytest.approx(expected, rel=1e-13)


@given(s=SPEEDS, a=st.floats(0.2, 2))
def test_derivatives_by_all_symbols(s, a):
    def function(s, a, exp=np.exp):
        return (
            (1 - a) * exp(-((s / a) ** 2)) / (a + s) - s**a + (s + a) / (1 + s * a) + (2 + s) ** a
        )

    graph = Graph("s")
    recorded = trace(function, graph, ("a",))
    with mpmath.workdps(40):
        for name, n in (("s", (1, 0)), ("a", (0, 1))):
            exact = mpmath.diff(
                lambda s, a: function(s, a, mpmath.exp), (mpmath.mpf(s), mpmath.mpf(a)), n
            )
            found = value(derivative(recorded, graph.symbol(name)), s=s, a=a)
            assert found == pytest.approx(float(exact), rel=1e-12, abs=1e-12)


@given(s=SPEEDS, a=st.floats(0.2, 2), b=st.floats(0.2, 2))
def test_what_does_not_vary_is_gathered_into_one_factor(s, a, b):
    graph = Graph("s")
    speed, one, two = (graph.symbol(name) for name in "sab")
    given_ = -(one * (two * (speed * speed))) - two * -(one * speed) + speed
    found = gathered(given_)
    fixed = [n for n in reachable(graph, [found.number]) if graph.nodes[n].op == "multiply"]
    assert sum(graph.varies[n] for n in fixed) == 3  # the square, and one for each product
    assert gathered(one * speed).number == (one * speed).number
    assert value(found, s=s, a=a, b=b) == pytest.approx(value(given_, s=s, a=a, b=b), rel=1e-14)


def test_a_formula_is_evaluated_in_the_arithmetic_of_its_arguments():
    flint = pytest.importorskip("flint", reason="needs the extra 'certify'")
    graph = Graph("s")
    recorded = trace(lambda s, a: a + (1 - a) * np.exp(-s), graph, ("a",))
    functions = {"exp": lambda x: x.exp()}
    ball = evaluate(
        graph, [recorded.number], {"s": flint.arb("1 +/- 0.1"), "a": flint.arb("0.25")}, functions
    )[0]
    assert 0.25 + 0.75 * math.exp(-1.05) in ball
    assert 0.25 + 0.75 * math.exp(-1.2) not in ball
