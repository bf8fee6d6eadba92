"""Formulas as text: what is read, what is refused, and that nothing else happens."""

import math
import pickle
import random
import sys
from functools import partial

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.sizes import calls_in

from stickslip.mechanics.friction.formula import UserFunction, traced_formula
from stickslip.numerics.expression import ELEMENTARY, Graph, NotTraceable, evaluate
from stickslip.numerics.formula_text import (
    MOST_CHARACTERS,
    MOST_NESTED,
    MOST_PARAMETERS,
    FormulaText,
)
from stickslip.numerics.tracing import trace

SIGNS = ("+", "-", "*", "/", "**")


def sums(depth):
    """Texts of the grammar that Python reads alike."""
    numbers = st.sampled_from(["0", "1", "2", "3", "0.5", ".25", "1e-3", "2."])
    atoms = st.one_of(numbers, st.sampled_from(["s", "a", "b"]))
    if depth == 0:
        return atoms
    inner = sums(depth - 1)
    return st.one_of(
        atoms,
        st.builds("({})".format, inner),
        st.builds("-{}".format, inner),
        st.builds("{} {} {}".format, inner, st.sampled_from(SIGNS), inner),
        st.builds("{}({})".format, st.sampled_from(sorted(ELEMENTARY)), inner),
    )


def in_python(text, **values):
    """What Python makes of it; None where it has no real value."""
    functions = {name: entry.scalar for name, entry in ELEMENTARY.items()}
    try:
        value = eval(text, {"__builtins__": {}}, functions | values)
    except (ArithmeticError, ValueError, TypeError):  # roots of -1 are complex there
        return None
    return value if isinstance(value, (int, float)) and math.isfinite(value) else None


@given(sums(4))
@example("2**3**2")
@example("-s**2")
@example("2**-s")
@example("a - b - s")
@example("a / b / s")
@example("2 * -s")
def test_it_means_what_it_means_in_python(text):
    values = {"s": 0.7, "a": 1.3, "b": 0.4}
    expected = in_python(text, **values)
    formula, error = read(text)
    if formula is None:  # a constant part has no value, which Python may not see: 0 * exp(1e9)
        assert "fails at character" in error or "has a large exponent" in error
        return
    with np.errstate(all="ignore"):
        given = {name: np.float64(values[name]) for name in formula.names}
        found = formula(np.float64(0.7), **given)
    if expected is not None:
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)


def read(text):
    """A formula, or the reason why there is none."""
    try:
        return FormulaText(text), ""
    except ValueError as error:
        return None, str(error)


def refused(text):
    with pytest.raises(ValueError, match="the formula") as error:
        FormulaText(text)
    return str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "ends where a number, a name or ( is expected"),
        ("mu + (1 - mu", "ends where ) is expected"),
        ("s + * 2", "has '*' at character 5, where a number, a name or ( is expected"),
        ("2 s", "has 's' at character 3, where an operator or the end is expected; products are"),
        ("2(s)", "has '(' at character 2, where an operator or the end is expected; products are"),
        (
            "s % 1",
            "has '%' at character 3, where an operator or the end is expected; a formula has",
        ),
        ("s 2", "has '2' at character 3, where an operator or the end is expected; products are"),
        ("exp(-s) a = 2", "has 'a' at character 9, where an operator or the end is expected; prod"),
        ("s a", "products are written *, values follow a comma"),
        (
            "a = 2",
            "has '=' at character 3, where an operator or the end is expected; values follow",
        ),
        ("s^2", "has '^' at character 2, where an operator or the end is expected; powers are"),
        (
            "np.exp(s)",
            "has '.' at character 3, where an operator or the end is expected; functions",
        ),
        ("sin(s, 2)", "has ',' at character 6, where ) is expected; functions take one argument"),
        ("1 + exp + 1", "names exp without an argument at character 5: write exp(...)"),
        ("1 + expp(s)", "calls 'expp' at character 5, which is no function. Known: exp, expm1"),
        ("expp(s)", "Did you mean 'exp'? Products are written *."),
        ("max(s, 1)", "calls 'max' at character 1, which is no function"),
        ("s + inf", "has inf at character 5: its numbers are finite"),
        ("nan", "has nan at character 1: its numbers are finite"),
        ("1 + log(0)", "fails at character 5: math domain error"),
        ("1 + abs(s - 1)", "fails at character 5: abs() is not smooth"),
        ("2**99**2", "has a large exponent at character 2: 9801, at most 100 is allowed"),
        ("s ** -101", "has a large exponent at character 3: -101, at most 100 is allowed"),
        ("(1e9 + s * 0)**99", "fails at character 14: math range error"),
        ("s + 1e999", "fails at character 5: the constant inf is not finite"),
        ("0x" + "f" * 900, "fails at character 1: int too large to convert to float"),
        ("1 / (s - s)", "fails at character 3: it divides by zero"),
        ("s.real", "has '.' at character 2"),
        ("__import__('os')", "calls '__import__' at character 1, which is no function"),
        ("s + 'os'", """has "'" at character 5"""),
        ("s if s else s", "has 'if' at character 3"),
        ("s[0]", "has '[' at character 2"),
        ("s\N{SUPERSCRIPT TWO}", "at character 2"),
        ("1__0", "has '__0' at character 2"),
        ("1_", "has '_' at character 2"),
        ("2j", "has 'j' at character 2"),
        ("0x", "has 'x' at character 2"),
        ("(" * (MOST_NESTED + 1), "is nested more than 50 deep at character 51"),
        ("-" * MOST_CHARACTERS, "is nested more than 50 deep at character 51"),
        ("2**" * 200 + "s", "is nested more than 50 deep"),
        ("1" * (MOST_CHARACTERS + 1), "has 1001 characters: at most 1000 are read"),
        ("+".join(f"a{k}" for k in range(MOST_PARAMETERS + 1)), "has more than 20 parameters at"),
        ("*".join(f"(s+{k})**63" for k in range(60)), "takes more than 300 operations at charact"),
    ],
)
def test_what_cannot_be_read_is_told_with_its_place(text, message):
    assert message in refused(text)


def test_it_is_recorded_as_a_function_would_be():
    formula = FormulaText("mu + (1 - mu) * exp(-s / v)")
    assert formula.names == ("mu", "v")
    one, other = Graph("s"), Graph("s")
    recorded = trace(formula, one, ("mu", "v"))
    plain = trace(lambda s, mu, v: mu + (1 - mu) * np.exp(-s / v), other, ("mu", "v"))
    assert repr(recorded) == repr(plain)
    assert pickle.loads(pickle.dumps(formula)) == formula


NUMBERS = (
    *("0", "7", "1_000", "0x1F", "0XfF", "0x_f_f", "0o17", "0b1_0", "1.", ".5", "0.25", "1_0.2_5"),
    *("1e3", "1E-3", "1.5e+1_0", ".5e0", "2.e-3", "3.14159265358979312", "4.9e-324"),
    *("1.7976931348623157e308", "9007199254740993", "123456789012345678901234567890"),
)


@pytest.mark.parametrize("text", NUMBERS)
def test_numbers_are_those_of_python(text):
    assert FormulaText(text)(0.0) == float(eval(text))
    assert FormulaText(f"s-{text}")(0.0) == -float(eval(text))


def test_functions_may_have_numpys_names_and_the_modulus_is_that_of_the_speed():
    assert FormulaText("arctan(s) + arcsinh(s)")(0.3) == FormulaText("atan(s) + asinh(s)")(0.3)
    assert FormulaText("exp(-abs(s))")(0.3) == FormulaText("exp(-s)")(0.3)


NAMES = ("s", "a", "b", "mu_2")
TERMS = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "/": lambda x, y: x / y,
    "**": lambda x, y: x**y,
}


def trees(depth):
    """A formula as a text, and as a function of the values of its names."""
    numbers = st.floats(-1e3, 1e3).map(lambda x: (f"({x!r})", lambda _: x))
    names = st.sampled_from(NAMES).map(lambda name: (name, lambda values: values[name]))
    if depth == 0:
        return st.one_of(numbers, names)
    inner = trees(depth - 1)

    def joined(one, sign, other):
        return f"({one[0]}){sign}({other[0]})", lambda v: TERMS[sign](one[1](v), other[1](v))

    def called(name, one):
        entry = ELEMENTARY[name]

        def function(values):
            x = one[1](values)
            return entry.scalar(x) if isinstance(x, float) else entry.ufunc(x)

        return f"{name}({one[0]})", function

    return st.one_of(
        numbers,
        names,
        st.builds(lambda one: (f"-({one[0]})", lambda v: -one[1](v)), inner),
        st.builds(joined, inner, st.sampled_from(SIGNS), inner),
        st.builds(called, st.sampled_from(sorted(ELEMENTARY)), inner),
    )


@given(trees(4))
def test_a_printed_tree_is_recorded_as_the_function_it_was_made_of(tree):
    """The same graph: the same values bit for bit, and the same kernels."""
    text, function = tree
    formula, _ = read(text)
    if formula is None:
        return
    parameters = NAMES[1:]

    def plain(s, a, b, mu_2):
        return function({"s": s, "a": a, "b": b, "mu_2": mu_2})

    try:
        with np.errstate(all="ignore"):
            expected = traced_formula(parameters, UserFunction(plain, parameters))
    except NotTraceable:  # a complex constant part
        return
    found = traced_formula(parameters, UserFunction(formula, formula.names))
    assert found == expected
    values = {"s": np.float64(0.7), "a": np.float64(1.3), "b": np.float64(0.4)}
    values["mu_2"] = np.float64(0.9)
    with np.errstate(all="ignore"):
        graph, numbers = found.graph(), range(len(found.nodes))
        one, other = (evaluate(each, numbers, values) for each in (graph, expected.graph()))
        again = formula(values["s"], **{name: values[name] for name in formula.names})
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(again, one[found.backward])


WORDS = (
    *("s", "mu", "v", "1", "0", "2.5", ".", "1e308", "1e-400", "(", ")", "((", "+", "-", "*", "**"),
    *(
        "/",
        " ",
        "exp",
        "log",
        "sqrt",
        "tan",
        "exp(",
        "log1p(",
        "^",
        ",",
        "=",
        "_",
        "__class__",
        "[",
    ),
    *("lambda", "import", "'", '"', ";", "\n", "\\", "\x00", "\N{GREEK SMALL LETTER MU}", "999999"),
)


def random_texts(n, seed):
    """Half of the grammar; the rest mutated, of words, of characters, very long or deep."""
    rng = random.Random(seed)
    for k in range(n):
        text = random_formula(rng, rng.randrange(7))
        if k % 2:
            kind = rng.random()
            if kind < 0.5:
                for _ in range(rng.randrange(1, 6)):
                    at = rng.randrange(len(text) + 1)
                    text = text[:at] + rng.choice(WORDS) + text[at + rng.randrange(3) :]
            elif kind < 0.8:
                text = "".join(rng.choices(WORDS, k=rng.choice((3, 8, 20, 200))))
            elif kind < 0.98:
                text = "".join(map(chr, rng.choices(range(1, 0x3000), k=rng.randrange(60))))
            else:
                text = rng.choice(WORDS) * rng.choice((50, 900, 100_000))
        yield text


def random_formula(rng, depth):
    """A text of the grammar."""
    kind = rng.random()
    if depth == 0 or kind < 0.1:
        return rng.choice(("s", "mu", "v", "2", "0.5", "1e-3", "0x1F", "1_0."))
    one = random_formula(rng, depth - 1)
    if kind < 0.3:
        return f"{rng.choice(sorted(ELEMENTARY))}({one})"
    if kind < 0.4:
        return f"-{one}"
    if kind < 0.5:
        return f"({one})"
    return f"{one}{rng.choice((' + ', ' - ', '*', '/', '**'))}{random_formula(rng, depth - 1)}"


RAN: list[str] = []
WATCHED = {"on": False}


def watch(event, _):
    if WATCHED["on"] and event in ("compile", "exec", "import", "open", "os.system"):
        RAN.append(event)


sys.addaudithook(watch)


def test_the_watch_sees_what_python_evaluates():
    WATCHED["on"] = True
    eval("1 + 1")
    WATCHED["on"] = False
    assert {"compile", "exec"} <= set(RAN)
    RAN.clear()


def test_random_texts_are_read_or_refused_in_work_that_grows_as_their_length():
    """A million of them, in `make evidence`; here some thousands."""
    check_random_texts(10_000, seed=1)


@pytest.mark.slow
def test_a_million_random_texts():
    check_random_texts(1_000_000, seed=2)


def check_random_texts(n, seed):
    most, formulas = 0.0, 0
    read("s")
    RAN.clear()
    for text in random_texts(n, seed):
        WATCHED["on"] = True
        (formula, error), calls = calls_in(partial(read, text))
        WATCHED["on"] = False
        most = max(most, calls / (len(text) + 20))
        formulas += formula is not None
        assert formula is not None or error.startswith("the formula")
    print(f"{n} texts, {formulas} formulas, at most {most:.0f} calls a character")
    assert not RAN
    assert formulas > n / 10
    assert most < 50  # 25 seen
