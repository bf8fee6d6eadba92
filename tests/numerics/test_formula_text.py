"""Formulas as text: what is read, what is refused, and that nothing else happens."""

import math
import pickle
import random
import time

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stickslip.numerics.expression import ELEMENTARY, Graph
from stickslip.numerics.formula_text import MOST_CHARACTERS, MOST_NESTED, FormulaText
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
        assert "has no value before" in error
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
        ("2 s", "has 's' at character 3, where an operator or the end is expected"),
        ("s^2", "has '^' at character 2, where an operator or the end is expected; powers are"),
        ("exp + 1", "names exp without an argument"),
        ("expp(s)", "Did you mean 'exp'?"),
        ("log(0)", "has no value before character 7"),
        ("2**2000", "has no value"),
        ("1e999", "has no value"),
        ("1 / (s - s)", "divides by zero"),
        ("s.real", "has '.' at character 2"),
        ("__import__('os')", "calls '__import__', which is no function. Known: exp, expm1"),
        ("s + 'os'", """has "'" at character 5"""),
        ("s if s else s", "has 'if' at character 3"),
        ("s[0]", "has '[' at character 2"),
        ("s\N{SUPERSCRIPT TWO}", "at character 2"),
        ("(" * (MOST_NESTED + 1), "nested more than 50 deep"),
        ("-" * MOST_CHARACTERS, "nested more than 50 deep"),
        ("1" * (MOST_CHARACTERS + 1), "has 1001 characters"),
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


def test_random_texts_are_read_or_refused_at_once():
    """A million of them, in `make evidence`; here some thousands."""
    check_random_texts(5000, seed=1)


@pytest.mark.slow
def test_a_million_random_texts():
    check_random_texts(1_000_000, seed=2)


def check_random_texts(n, seed):
    rng = random.Random(seed)
    longest, formulas = 0.0, 0
    for _ in range(n):
        text = "".join(rng.choices(WORDS, k=rng.choice((3, 8, 20, 200))))
        if rng.random() < 0.5:  # likelier to be a formula
            signs = rng.choices(SIGNS, k=rng.randrange(30))
            text = "s" + "".join(
                sign + rng.choice(("s", "a", "2", "exp(s)", "(1")) for sign in signs
            )
            text += ")" * text.count("(1")
        start = time.process_time()
        formula, error = read(text)
        longest = max(longest, time.process_time() - start)
        formulas += formula is not None
        assert formula is not None or error.startswith("the formula")
    assert formulas > n / 10
    assert longest < 0.05
