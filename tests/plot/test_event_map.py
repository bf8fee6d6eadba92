"""A map as a line: broken at jumps and gaps, whole at corners and harmless label changes."""

from dataclasses import dataclass

import numpy as np
import pytest

from stickslip.plot.maps import trace


@dataclass
class Values:
    value: np.ndarray
    label: np.ndarray


class Map:
    """Pieces (left end, formula) of [0, 1], each with a label of its own."""

    def __init__(self, *pieces):
        self.pieces = pieces
        self.calls = 0

    def evaluate(self, x):
        self.calls += x.size
        value, label = np.full(x.shape, np.nan), np.zeros(x.shape, dtype=np.uint64)
        for number, (left, formula) in enumerate(self.pieces, start=1):
            inside = x >= left
            value[inside], label[inside] = formula(x[inside]), number
        return Values(value, label)


def segments(curve):
    """Number of unbroken lines."""
    drawn = np.isfinite(curve.y)
    return int(drawn[0]) + int(np.sum(~drawn[:-1] & drawn[1:]))


def test_a_corner_stays_one_line_that_reaches_the_corner():
    curve = trace(Map((0.0, lambda x: x), (1 / 3, lambda x: 2 / 3 - x)), (0.0, 1.0), points=11)
    assert segments(curve) == 1
    assert curve.jumps.size == 0
    assert np.nanmax(curve.y) == pytest.approx(1 / 3, abs=1e-8)


def test_a_jump_breaks_the_line_where_it_is():
    where = np.sqrt(0.5)
    f = Map((0.0, lambda x: x), (where, lambda x: x - 0.4))
    curve = trace(f, (0.0, 1.0), points=11)
    assert segments(curve) == 2
    assert curve.jumps == pytest.approx([where], abs=1e-8)
    left = curve.x[np.flatnonzero(np.isnan(curve.x))[0] - 1]
    assert left == pytest.approx(where, abs=1e-8)
    assert f.calls < 200


def test_two_jumps_inside_one_cell_of_the_first_sample_are_both_found():
    f = Map((0.0, lambda x: x), (0.501, lambda x: x + 0.5), (0.502, lambda x: x - 0.5))
    assert trace(f, (0.0, 1.0), points=11).jumps == pytest.approx([0.501, 0.502], abs=1e-8)


def test_a_gap_is_left_blank():
    f = Map((0.0, lambda x: x), (0.3, lambda x: np.full_like(x, np.nan)), (0.6, lambda x: x))
    curve = trace(f, (0.0, 1.0), points=101)
    assert segments(curve) == 2
    drawn = curve.x[np.isfinite(curve.x)]
    assert not np.any((drawn > 0.3 + 1e-8) & (drawn < 0.6))


def test_a_square_root_beside_a_label_change_is_not_a_jump():
    f = Map((0.0, lambda x: np.zeros_like(x)), (0.4, lambda x: np.sqrt(x - 0.4)))
    curve = trace(f, (0.0, 1.0), points=101)
    assert segments(curve) == 1
    assert np.nanmax(np.abs(np.diff(curve.y))) < 0.02  # steep parts are refined


def test_points_ascend_and_values_are_the_maps():
    f = Map((0.0, lambda x: x**2), (0.5, lambda x: x**2 - 1))
    curve = trace(f, (0.0, 1.0), points=50)
    x, y = curve.x[np.isfinite(curve.x)], curve.y[np.isfinite(curve.y)]
    assert np.all(np.diff(x) > 0)
    np.testing.assert_array_equal(y, f.evaluate(x).value)


def test_a_map_without_any_value_gives_an_empty_line():
    curve = trace(Map((0.0, lambda x: np.full_like(x, np.nan))), (0.0, 1.0), points=11)
    assert segments(curve) == 0


def test_endless_changes_of_label_end():
    f = Map((0.0, lambda x: x))
    f.evaluate = lambda x: Values(x, np.arange(x.size, dtype=np.uint64))
    assert trace(f, (0.0, 1.0), points=101).x.size < 200_000
