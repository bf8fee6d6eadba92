"""Everything public, called with what a user may pass by mistake."""

from __future__ import annotations

import math
from typing import Any, Final

import hypothesis.extra.numpy as npst
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.fuzz.calls import LEFT, calls, public
from tests.fuzz.judge import complaint
from tests.fuzz.values import MAKERS

from stickslip.checks import shown

CALLS: Final = calls()
OPEN: Final = (
    "bifurcation_diagram",
    "bifurcations",
    "basins",
    "attractors",
    "certify",
    "continue",
    "invariant",
    "limit_cycles",
    "sweep",
    "return_region",
    "trapping",
    "periodic",
    "quasi",
    "Quasi",
    "BlocksEventMap",
    "lyap",
    "Strobo",
    "explore",
    "slips",
    "simulate",
    "find",
    "strobo",
    "Blocks",
    "Structure",
)
"""How the names begin whose arguments have not been gone through one by one yet."""
CLOSED: Final = {name: call for name, call in CALLS.items() if not name.startswith(OPEN)}

MODELS: Final = ("two blocks", "chain", "map")
"""Legal where a model or map is, and then whole searches run on them."""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    """Texts are legal names of files."""
    monkeypatch.chdir(tmp_path)


def test_everything_public_is_in_the_table():
    missing = [name for name in dict.fromkeys(public()) if name not in CALLS]
    assert not missing, f"add a good call of {missing} to tests/fuzz/calls.py"


def test_what_is_left_out_exists():
    assert all(isinstance(reason, str) and reason for reason in LEFT.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_the_good_call_is_good(name):
    CALLS[name]({})


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSED)
def test_an_unknown_keyword_is_named(name):
    with pytest.raises((TypeError, ValueError), match="spam"):
        CALLS[name]({"spam": 1})


def small_or_huge(number: float) -> bool:
    """Leave out what is a legal count and would be counted to."""
    return not math.isfinite(number) or abs(number) < 4 or abs(number) > 2**63


scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 3),
    st.integers(min_value=2**63),
    st.floats().filter(small_or_huge),
    st.complex_numbers(),
    st.text(max_size=8),
    st.binary(max_size=8),
)
anything: Final = st.one_of(
    st.sampled_from([kind for kind in MAKERS if kind not in MODELS]).map(lambda k: MAKERS[k]()),
    scalars,
    st.lists(scalars, max_size=3),
    st.tuples(scalars, scalars),
    st.dictionaries(st.text(max_size=3), scalars, max_size=2),
    npst.arrays(
        st.sampled_from(["f8", "f4", "i8", "c16", "?", "U3", "O"]),
        npst.array_shapes(max_dims=2, max_side=3, min_side=0),
    ),
)
FOUND: Final = (
    "beyond the floats",
    "beyond what is written",
    "float16",
    "beyond the floats, as longdouble",
    "long text",
    "nested",
    "nested in a dict",
    "long list of texts",
    "matrix",
)
"""Values that once met no check; every public call meets them."""

# Objects whose methods are called are made when a test asks, not when tests are collected.
parameters: Final = st.sampled_from(sorted(CALLS)).flatmap(
    lambda name: st.tuples(st.just(name), st.sampled_from(CALLS[name].names()))
)


def check(where: tuple[str, str], value: Any) -> None:
    name, parameter = where
    said = complaint(CALLS[name], parameter, value)
    assert said is None, f"{name}({parameter}={shown(value)}): {said}"


def test_a_message_does_not_repeat_a_whole_table():
    check(("Blocks", "friction"), [[RuntimeError("a long story")] * 20])


@pytest.mark.slow
@settings(max_examples=250)
@given(parameters, anything)
def test_a_bad_argument_is_told(where: tuple[str, str], value: Any):
    check(where, value)


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSED)
def test_every_bad_argument_is_told(name):
    call = CALLS[name]
    said = {
        f"{parameter} = {kind}": words
        for parameter in call.names()
        for kind, make in MAKERS.items()
        if (words := complaint(call, parameter, make())) is not None
    }
    assert not said, "\n".join(f"{name}({where}): {words}" for where, words in said.items())


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_what_was_found_is_told_everywhere(name):
    for parameter in CALLS[name].names():
        for kind in FOUND:
            check((name, parameter), MAKERS[kind]())


@pytest.mark.slow
@settings(max_examples=5000)
@given(parameters, anything)
def test_many_bad_arguments_are_told(where: tuple[str, str], value: Any):
    check(where, value)
