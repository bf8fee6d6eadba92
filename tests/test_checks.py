"""What arrives from outside is checked in one place, and told in a short message."""

from fractions import Fraction

import numpy as np
import pytest

import stickslip as ss
from stickslip.checks import (
    LONGEST,
    finite_number,
    grid,
    random_generator,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.vocabulary import did_you_mean


def nested(depth=10**5):
    """Make a list in a list in a list."""
    inner = [0.1]
    for _ in range(depth):
        inner = [inner]
    return inner


DEEP = nested()
LONG = {
    "text": "x" * 10**5,
    "bytes": b"x" * 10**5,
    "list": ["a"] * 10**5,
    "nested": DEEP,
    "nested tuples": ((DEEP,),),
    "array of nested": np.array([DEEP, None], dtype=object),
    "digits": 10**5000,
    "fraction": Fraction(10**5000, 3),
    "longdouble": np.longdouble("1e4000"),
    "keys": {"x" * 10**5: DEEP},
}


@pytest.mark.parametrize("kind", LONG)
def test_what_arrived_is_shown_in_few_characters(kind):
    value = LONG[kind]
    assert len(shown(value)) < LONGEST + 20
    assert len(did_you_mean(value, ["alpha"])) < 30
    for check in (finite_number, whole_number, real_numbers, grid):
        if kind in ("digits", "fraction", "longdouble") and check is real_numbers:
            continue  # infinite as a float, which may be
        with pytest.raises(ValueError, match="spam") as error:
            check("spam", value)
        assert len(str(error.value)) < 300


def test_numbers_beyond_all_floats_are_infinite():
    given = [10**400, -(10**400), Fraction(10**400, 3), 1]
    assert real_numbers("x", given).tolist() == [np.inf, -np.inf, np.inf, 1.0]
    assert real_numbers("x", -(10**400)) == -np.inf
    with pytest.raises(ValueError, match=r"d\[1\] = inf is outside"):
        ss.event_map(ss.examples.coulomb())([0.1, 10**400])


def test_a_number_of_a_grid_is_told_with_the_grid_s_name():
    with pytest.raises(ValueError, match=r"^lo = nan of grid = \(nan, 1.0, 3\) "):
        grid("grid", (np.nan, 1.0, 3))
    with pytest.raises(ValueError, match=r"n \(values of grid = .*\) must be a whole number"):
        grid("grid", (0.0, 1.0, 1))


def test_long_numbers_show_how_many_digits_they_have():
    assert shown(10**400) == "100000000000... (401 digits)"
    assert shown(-(10**400)) == "-10000000000... (401 digits)"
    assert shown(10**5000) == "a whole number of about 5000 digits"


@pytest.mark.parametrize(
    "value", [3, 3.0, np.float16(3), np.int8(3), np.longdouble(3), Fraction(3)]
)
def test_a_whole_number_of_any_kind_is_a_count(value):
    got = whole_number("n", value)
    assert (got, type(got)) == (3, int)


NO_COUNTS = [
    10**400,
    10**5000,
    -(10**400),
    2.5,
    Fraction(7, 2),
    np.float16(2.5),
    np.longdouble("1e4000"),
]
NO_COUNTS += [
    1e300,
    np.float16("inf"),
    np.float32("nan"),
    float("inf"),
    True,
    "3",
    None,
    [3],
    3 + 0j,
]


def test_what_is_no_count_is_told():
    for value in NO_COUNTS:
        with pytest.raises(ValueError, match=r"n = .* must be a whole number"):
            whole_number("n", value)


def test_a_tuple_is_a_grid_and_everything_else_is_values():
    assert grid("V", (0.03, 0.04, 3)).tolist() == np.linspace(0.03, 0.04, 3).tolist()
    assert grid("V", (1, 2, np.int8(2))).tolist() == [1.0, 2.0]
    for values in ([0.03, 0.04, 100], np.array([0.03, 0.04, 100]), range(3)):
        assert grid("V", values).tolist() == list(values)
    for wrong in ((0.03, 0.04, 1), (0.03, 0.04, 3.0), (0.03, 0.04), (0.03, 0.04, "3"), ()):
        with pytest.raises(ValueError, match="V"):
            grid("V", wrong)
    for wrong in ((0.03, np.inf, 3), ("a", 0.04, 3), (0.03, 0.04, 10**16)):
        with pytest.raises(ValueError, match=r"of V = \("):
            grid("V", wrong)
    for wrong in ([], 0.03, "0.03", [[0.03, 0.04]], [0.03, np.nan], None, {0.1, 0.2}):
        with pytest.raises(ValueError, match="V = "):
            grid("V", wrong)


def test_what_a_generator_is_made_of():
    for seed in (0, 7, np.uint8(7), 10**5000, None):
        assert isinstance(random_generator("rng", seed), np.random.Generator)
    given = np.random.default_rng(1)
    assert random_generator("rng", given) is given


NO_SEEDS = {
    "matrix": np.array([[1, 2]]).view(np.matrix),
    "array": np.array([1, 2]),
    "list": [1, 2],
    "float": 3.0,
    "bool": True,
    "text": "1",
    "bits": np.random.PCG64(1),
    "sequence": np.random.SeedSequence(1),
    "state": np.random.RandomState(1),
    "nested": nested(),
}


@pytest.mark.parametrize("kind", NO_SEEDS)
def test_what_is_no_generator_is_a_type_error(kind):
    wrong = NO_SEEDS[kind]
    model, f = ss.examples.coulomb(), ss.PiecewiseMap(lambda x: 0.5 * x, (0.0, 1.0))
    for call in (
        lambda: random_generator("rng", wrong),
        lambda: model.sample_domain(2, rng=wrong),
        lambda: model.sample_state(wrong),
        lambda: model.chain.sample_state(wrong),
        lambda: ss.limit_cycles(model, n_starts=1, rng=wrong),
        lambda: ss.attractors(f, rng=wrong),
    ):
        with pytest.raises(TypeError, match=r"rng = .* must be None"):
            call()
    with pytest.raises(ValueError, match="rng = -1"):
        random_generator("rng", -1)


def test_a_path_is_a_text_or_a_path():
    for wrong in (3.5, 0, None, b"a.toml", ["a"], nested(), True, "x" * 10**5, "\0"):
        with pytest.raises(ValueError, match="path = "):
            ss.read_model(wrong)
        with pytest.raises(ValueError, match="path = "):
            ss.write_model(ss.examples.coulomb(), wrong)


def test_more_blocks_than_matrices_hold_are_refused():
    law = ss.Coulomb(mu=0.22)
    with pytest.raises(ValueError, match=r"len\(static\) = 20000 .* from 1 to 2000"):
        ss.Chain(static=[1.0] * 20_000, alpha=1.0, V=0.1, friction=law)
    with pytest.raises(ValueError, match=r"len\(mass\) = 20000 .* from 1 to 2000"):
        ss.Blocks([1.0] * 20_000, [[1.0]], static=1.0, friction=law, V=0.1)
