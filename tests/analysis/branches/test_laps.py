"""Laps: inverses to rounding, one-sided values, bounds of slopes, preimages."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

from stickslip.analysis.branches.pieces import TooManyPiecesError, pieces_of_powers
from stickslip.analysis.branches.table import branch_table, preimages
from stickslip.analysis.maps.piecewise_map import PiecewiseMap

ROUNDING = 1e-15
MAPS = [
    examples.tent(1.7),
    examples.logistic(3.7),
    examples.doubling(3.3),
    examples.square_root(0.2, 0.02),
    examples.tent_with_hole(2.5),
    examples.border_collision(0.7, -1.9, 0.3, 0.4),
    PiecewiseMap(lambda x: np.sin(9 * x) * np.exp(-x), (-1, 2)),
]


@pytest.mark.parametrize("f", MAPS, ids=repr)
@given(share=st.floats(0, 1), which=st.integers(0, 100))
def test_inverse_of_each_lap(f, share, which):
    laps = branch_table(f).laps
    lap = np.array([which % len(laps)])
    y = laps.value_min[lap] + share * (laps.value_max - laps.value_min)[lap]
    x = laps.inverse(lap, y)
    assert laps.left[lap] <= x <= laps.right[lap]
    value, slope = laps.evaluate(lap, x)
    # The next float may be a whole slope away.
    ulp = np.spacing(max(abs(end) for end in f.domain))
    steep = np.where(np.isfinite(slope), np.abs(slope), 0)
    on_a_root = np.sqrt(ulp) if np.isinf(slope) else 0.0
    assert np.abs(value - y) <= 8 * ulp * (1 + steep) + on_a_root


@pytest.mark.parametrize("f", MAPS, ids=repr)
def test_inverse_takes_few_evaluations(f):
    laps = branch_table(f).laps
    calls = []
    counted = PiecewiseMap(
        lambda x: (calls.append(np.size(x)), f.evaluate(x).value)[1],
        f.domain,
        derivative=lambda x: f.evaluate(x).derivative,
    )
    object.__setattr__(laps, "f", counted)
    calls.clear()
    n = 500
    lap = np.arange(n) % len(laps)
    share = (0.618034 * np.arange(n)) % 1
    laps.inverse(lap, laps.value_min[lap] + share * (laps.value_max - laps.value_min)[lap])
    object.__setattr__(laps, "f", f)
    assert sum(calls) <= 1.5 * n


@pytest.mark.parametrize("f", MAPS, ids=repr)
@given(a=st.floats(0, 1), b=st.floats(0, 1), which=st.integers(0, 100))
def test_slope_bounds_hold(f, a, b, which):
    laps = branch_table(f).laps
    lap = np.array([which % len(laps)])
    left, right = laps.left[lap], laps.right[lap]
    lower, upper = left + min(a, b) * (right - left), left + max(a, b) * (right - left)
    least, most = laps.steepness(lap, lower, upper)
    x = np.linspace(lower[0], upper[0], 50)
    slopes = np.abs(laps.evaluate(np.repeat(lap, 50), x)[1])
    # Beside a turning point all that counts is that the slope is small.
    small = 1e-6 * np.abs(laps.evaluate(lap, 0.5 * (left + right))[1])
    assert np.all(slopes >= least - small)
    assert np.all(slopes <= most + small)


def test_values_at_a_jump_are_one_sided():
    laps = branch_table(examples.doubling(2.5)).laps
    at = np.array([0.4, 0.4])
    value, slope = laps.evaluate(np.array([0, 1]), at)
    assert value == pytest.approx([1.0, 0.0], abs=ROUNDING)
    assert slope.tolist() == [2.5, 2.5]


def test_locate_takes_the_right_one_of_two_laps():
    laps = branch_table(examples.tent_with_hole(3.0)).laps
    assert laps.locate(np.array([0.0, 0.2, 0.5, 0.9, 1.0, 1.1, -0.1, np.nan])).tolist() == [
        0, 0, -1, 1, 1, -1, -1, -1,
    ]  # fmt: skip
    laps = branch_table(examples.tent()).laps
    assert laps.locate(np.array([0.5])).tolist() == [1]


@pytest.mark.parametrize(
    ("f", "x", "known"),
    [
        (examples.tent(), 0.5, [0.25, 0.75]),
        (examples.tent(), 1.0, [0.5]),
        (examples.logistic(4.0), 0.75, [0.25, 0.75]),
        (examples.doubling(2.5), 0.25, [0.1, 0.5, 0.9]),
        (examples.tent_with_hole(3.0), 1.0, [1 / 3, 2 / 3]),
        (examples.tent().power(2), 0.5, [0.125, 0.375, 0.625, 0.875]),
        (examples.logistic(2.0), 0.7, []),
        (PiecewiseMap(lambda x: 0.5 * x, (0, 1e-7)), 2e-8, [4e-8]),
        (examples.border_collision(0.5, -2.0, 1.0), -30.0, []),
    ],
)
def test_preimages(f, x, known):
    assert preimages(f, x) == pytest.approx(np.array(known), abs=1e-14)
    assert f.preimages(x) == pytest.approx(np.array(known), abs=1e-14)


def test_preimages_of_a_constant_are_the_ends_of_its_lap():
    f = PiecewiseMap(
        lambda x: np.where(x < 0.5, 0.2, x),
        (0, 1),
        derivative=lambda x: 1.0 * (x >= 0.5),
        breakpoints=[0.5],
    )
    assert preimages(f, 0.2) == pytest.approx([0.0, 0.5])


@pytest.mark.parametrize("x", [np.nan, np.inf])
def test_preimages_of_nothing(x):
    with pytest.raises(ValueError, match="finite"):
        preimages(examples.tent(), x)


@pytest.mark.parametrize("f", MAPS, ids=repr)
def test_pieces_of_powers_agree_with_iteration(f):
    table = branch_table(f)
    for pieces in pieces_of_powers(table.laps, 4):
        left, right = pieces.left.orbit, pieces.right.orbit
        assert np.all(left[:, 0] < right[:, 0])
        assert np.all(right[:-1, 0] <= left[1:, 0])
        middle = 0.5 * (left[:, 0] + right[:, 0])
        orbit = f.iterate(middle, pieces.power)
        wide = right[:, 0] - left[:, 0] > 1e-9
        low, high = np.minimum(left, right), np.maximum(left, right)
        assert np.all(orbit[wide] >= low[wide] - 1e-12)
        assert np.all(orbit[wide] <= high[wide] + 1e-12)
        words = table.laps.locate(orbit[wide, :-1].ravel()).reshape(-1, pieces.power)
        assert np.array_equal(words, pieces.word[wide])


def test_pieces_cover_the_domain_of_the_power():
    *_, pieces = pieces_of_powers(branch_table(examples.logistic(3.7)).laps, 6)
    assert pieces.left.orbit[0, 0] == 0
    assert pieces.right.orbit[-1, 0] == 1
    assert np.array_equal(pieces.right.orbit[:-1, 0], pieces.left.orbit[1:, 0])


def test_too_many_pieces_raise():
    with pytest.raises(TooManyPiecesError, match="power 3"):
        list(pieces_of_powers(branch_table(examples.doubling(90.5)).laps, 3))
