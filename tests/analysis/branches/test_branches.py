"""Branches, breakpoints and gaps of maps whose shape is known."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

import stickslip as ss
from stickslip.analysis.attractors.bands import merged
from stickslip.analysis.branches.branches import branches, breakpoints
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import PointValues

ROUNDING = 1e-14
CALLS = 20  # of a map with one jump; halvings alone take 22, and 39 towards a root
LIMIT = 1e-11  # one-sided limits beside an infinite slope, extrapolated


def test_tent_has_one_corner():
    table = branches(examples.tent(2.0))
    assert [(b.left, b.value_left, b.value_right) for b in table] == [(0, 0, 1), (0.5, 1, 0)]
    (corner,) = table.breakpoints
    assert (corner.d, corner.kind, corner.quality) == (0.5, "corner", "located")
    assert (corner.left_slope, corner.right_slope) == (2.0, -2.0)
    assert np.nextafter(corner.interval[0], 1) == corner.interval[1]


def test_logistic_map_is_one_branch_with_two_laps():
    table = branches(examples.logistic(4.0))
    assert len(table) == 1
    assert not table.breakpoints
    assert table.turning_points == pytest.approx([0.5], abs=ROUNDING)
    assert len(table.laps) == 2


@given(slope=st.floats(1.5, 9.5))
def test_jumps_of_the_expanding_map(slope):
    assume(abs(slope - round(slope)) > 1e-6)
    found = breakpoints(examples.doubling(slope))
    known = np.arange(1, math.ceil(slope)) / slope
    assert [b.d for b in found] == pytest.approx(known, abs=2e-16)
    assert {b.kind for b in found} == {"jump"}
    assert [b.left for b in found] == pytest.approx([1.0] * len(known), abs=ROUNDING)
    assert [b.right for b in found] == pytest.approx([0.0] * len(known), abs=ROUNDING)


def test_edges_of_a_gap_are_the_last_points_with_a_value():
    f = examples.tent_with_hole(3.0)
    ((before, after),) = branches(f).gaps
    assert f(before) <= 1
    assert np.isnan(f(np.nextafter(before, 1)))
    assert f(after) <= 1
    assert np.isnan(f(np.nextafter(after, 0)))
    assert f.gaps.tolist() == [[before, after]]
    assert [b.kind for b in breakpoints(f)] == ["edge", "edge"]
    assert np.isnan(breakpoints(f)[0].right)
    assert np.isnan(breakpoints(f)[1].left_slope)


def test_a_gap_at_the_end_of_the_domain():
    f = PiecewiseMap(lambda x: np.where(x < 0.25, np.nan, x), (0, 1))
    table = branches(f)
    assert table.gaps[0] == pytest.approx([0.0, 0.25], abs=ROUNDING)
    assert [b.kind for b in table.breakpoints] == ["edge"]


def test_square_root_shows_an_infinite_slope_and_no_jump():
    (border,) = breakpoints(examples.square_root(0.2, 0.1))
    assert border.d == 0
    assert border.kind == "corner"
    assert border.left_slope == pytest.approx(0.2)
    assert border.right_slope == -np.inf
    assert border.left == pytest.approx(0.1, abs=LIMIT)
    assert border.right == pytest.approx(0.1, abs=LIMIT)


@given(
    at=st.floats(0.1, 0.9),
    step=st.floats(1e-6, 1) | st.floats(-1, -1e-6),
)
def test_jumps_without_a_label_are_found(at, step):
    f = PiecewiseMap(lambda x: np.sin(3 * x) + step * (x >= at), (0, 1))
    (jump,) = breakpoints(f)
    assert jump.kind == "jump"
    assert jump.d == pytest.approx(at, abs=2e-16)
    assert jump.jump == pytest.approx(step, abs=1e-9)
    assert jump.left_slope == pytest.approx(3 * math.cos(3 * at), abs=1e-6)


@given(
    at=st.floats(0.1, 0.9),
    width=st.floats(5e-9, 1e-6),
    inside=st.floats(0.1, 1) | st.floats(-1, -0.1),
    bend=st.floats(0.1, 5),
)
def test_jumps_close_to_each_other_without_a_label_are_found(at, width, inside, bend):
    # Beside the birth of a jump two of them are 1e-8 apart. Between them the map has a turning
    # point, and beyond the second it goes on almost as before the first.
    def between(x):
        return (x >= at) & (x < at + width)

    def place(x):
        return (x - at) / width - 0.5

    f = PiecewiseMap(
        lambda x: x**2 + bend * np.maximum(x - at, 0) + between(x) * (inside + 0.1 * place(x) ** 2),
        (0, 1),
        derivative=lambda x: 2 * x + bend * (x >= at) + between(x) * 0.2 * place(x) / width,
    )
    there, back = breakpoints(f)
    assert (there.kind, back.kind) == ("jump", "jump")
    assert there.d == pytest.approx(at, abs=2e-16)
    assert back.d == pytest.approx(at + width, abs=2e-16)


@given(at=st.floats(0.1, 0.9), bend=st.floats(0.01, 5))
def test_corners_without_a_label_are_found(at, bend):
    f = PiecewiseMap(
        lambda x: x**2 + bend * np.maximum(x - at, 0),
        (0, 1),
        derivative=lambda x: 2 * x + bend * (x >= at),
    )
    (corner,) = breakpoints(f)
    assert corner.kind == "corner"
    assert corner.d == pytest.approx(at, abs=2e-16)
    assert corner.right_slope - corner.left_slope == pytest.approx(bend, abs=1e-6)


@given(st.floats(1e-10, 1e-2), st.floats(-0.5, 0.5))
def test_one_sided_limits_of_branches_that_bend_on_any_scale(scale, at):
    # Beside the birth of a jump, slopes of 1e6 change by a share within 1e-9.
    def height(x):
        return np.where(x < at, -0.5, 0.3 - 0.2 * np.exp(-np.maximum(x - at, 0) / scale))

    def slope(x):
        return np.where(x < at, 0.0, 0.2 / scale * np.exp(-np.maximum(x - at, 0) / scale))

    f = PiecewiseMap(height, (-1, 1), derivative=slope, breakpoints=[at])
    (found,) = (b for b in branches(f).breakpoints if b.kind == "jump")
    ulp = np.spacing(abs(at))
    assert found.right == pytest.approx(0.1, rel=1e-12, abs=0.2 / scale * 64 * ulp)
    assert found.right_slope == pytest.approx(0.2 / scale, rel=1e-5 + 64 * ulp / scale)


def test_a_harmless_change_of_label_is_smooth_and_does_not_end_a_lap():
    f = PiecewiseMap(np.exp, (-1, 1), breakpoints=[0.3])
    table = branches(f)
    assert [b.kind for b in table.breakpoints] == ["smooth"]
    assert len(table) == 2
    assert len(table.laps) == 1
    assert len(table.pieces) == 2
    assert not breakpoints(f).of_kind("jump", "corner", "edge")
    assert "1 harmless" in repr(breakpoints(f))


def test_a_smooth_change_with_a_kink_in_the_second_derivative():
    f = PiecewiseMap(
        lambda x: np.where(x < 0.4, x**2, x**2 + 30 * (x - 0.4) ** 2),
        (0, 1),
        derivative=lambda x: np.where(x < 0.4, 2 * x, 2 * x + 60 * (x - 0.4)),
        breakpoints=[0.4],
    )
    assert [b.kind for b in breakpoints(f)] == ["smooth"]


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9])
def test_a_pair_of_turning_points_close_together(depth):
    half = math.sqrt(depth / 3)
    at = 1 / math.pi
    f = PiecewiseMap(lambda x: (x - at) ** 3 - depth * (x - at), (0, 1))
    assert branches(f).turning_points == pytest.approx([at - half, at + half], rel=1e-6)


def test_a_turning_point_close_to_a_graze():
    # On the touching side of a graze f = c0 + c1 h + c2 h^(3/2): it turns at h = (2/3)^2 1e-4.
    def func(x):
        h = np.maximum(x - 0.2, 0.0)
        return np.where(x < 0.2, x, 0.7 + 0.01 * h - h**1.5)

    def slope(x):
        return np.where(x < 0.2, 1.0, 0.01 - 1.5 * np.sqrt(np.maximum(x - 0.2, 0.0)))

    table = branches(PiecewiseMap(func, (0, 1), derivative=slope, breakpoints=[0.2]))
    (jump,) = table.breakpoints
    assert jump.kind == "jump"
    # Not the slope at the last float, nor a linear extrapolation: c1 itself.
    assert jump.right_slope == pytest.approx(0.01, abs=1e-9)
    assert table.turning_points == pytest.approx([0.2 + (2 / 3 * 0.01) ** 2], abs=1e-12)


@given(width=st.floats(1e-7, 1e-2), at=st.floats(0.1, 0.9))
def test_a_narrow_branch_between_two_others(width, at):
    f = PiecewiseMap(
        lambda x: np.where(x < at, 0.1, np.where(x < at + width, 0.5, 0.9)),
        (0, 1),
        derivative=np.zeros_like,
        breakpoints=[at, at + width],
    )
    assert [b.d for b in breakpoints(f)] == pytest.approx([at, at + width], abs=3e-16)


def test_a_sliver_below_the_resolution_is_one_breakpoint():
    f = PiecewiseMap(
        lambda x: np.where(x < 0.3, 0.1, 0.9),
        (0, 1),
        label=lambda x: 0 if x < 0.3 else 1 if x < 0.3 + 1e-11 else 2,
    )
    (jump,) = breakpoints(f)
    assert jump.interval[0] < 0.3 <= jump.interval[1]
    assert (jump.left_label, jump.right_label) == (0, 2)
    assert (jump.left, jump.right) == (0.1, 0.9)


@given(width=st.floats(1e-6, 4e-3), at=st.floats(0.1, 0.9), share=st.floats(0.01, 0.69))
def test_a_branch_inside_a_narrow_gap(width, at, share):
    """A gap was probed every 0.6 % of the domain: nobody looked into a narrower one."""
    ends = at + width * np.array([0.0, share, share + 0.3, 1.0])

    def islands(x):
        in_gap = (x > ends[0]) & (x < ends[3])
        return np.where(in_gap & ~((x > ends[1]) & (x < ends[2])), np.nan, 0.5 * x)

    slope, gap = (lambda x: 0.5 + 0 * x), [ends[0], ends[3]]  # known, what is inside is not
    table = branch_table(PiecewiseMap(islands, (0, 1), derivative=slope, breakpoints=gap))
    found = [(b.left, b.right) for b in table][1:-1]
    assert found == [pytest.approx(tuple(ends[1:3]), abs=1e-12)]


def test_accumulating_branches_stop_and_say_so():
    def gauss(x):
        return np.where(x > 0, np.mod(1 / np.where(x > 0, x, 1), 1), 0)

    f = PiecewiseMap(
        gauss,
        (0, 1),
        derivative=lambda x: np.where(x > 0, -1 / np.where(x > 0, x, 1) ** 2, 0),
        label=lambda x: np.floor(1 / np.where(x > 0, x, 1)),
    )
    table = branches(f, resolution=1e-4)
    assert table.unresolved
    assert max(item.hi for item in table.unresolved) < 0.05
    jumps = [b.d for b in table.breakpoints if b.d > 0.105 and b.kind == "jump"]
    assert jumps == pytest.approx([1 / n for n in range(9, 1, -1)], abs=ROUNDING)


def test_what_is_not_followed_overlaps_no_branch():
    friction = ss.Coulomb(mu=0.0625)
    f = ss.event_map(ss.TwoBlock(alpha=1.875, beta=1.75, V=0.140625, friction=friction))
    table = branches(f)  # most motions never return; their set is a fractal
    assert table.unresolved
    ends = np.array([(b.left, b.right) for b in table.branches])
    got = f.evaluate(ends)
    assert (got.status == 0).all()
    np.testing.assert_array_equal(got.label[:, 0], got.label[:, 1])
    left, right = ends[:, :1], ends[:, 1:]
    assert (left[1:] > right[:-1]).all()
    assert len(table.unknown)
    for between in (table.gaps, table.unknown):
        assert not ((between[:, 0] < right) & (between[:, 1] > left)).any()
    # ... and nothing wider than the usual resolution is a breakpoint where branches crowd.
    told = merged(np.concatenate([ends, table.gaps, table.unknown]), 1e-9)
    assert told == pytest.approx(np.array([f.domain]))


def steps_in_the_outer_thirds(x):
    """Steps of x -> 3 x mod 2 until a point is in the middle third, and its place there."""
    steps, inside = np.zeros(np.shape(x)), np.ones(np.shape(x), dtype=bool)
    for _ in range(40):
        inside = inside & ~((x > 1 / 3) & (x < 2 / 3))
        x, steps = np.where(inside, np.where(x < 0.5, 3 * x, 3 * x - 2), x), steps + inside
    return steps, np.where(inside, 0.0, 3 * x - 1)


# Breaks are the ends of Cantor's middle thirds: 2^19 of them are 1e-9 apart.
CANTOR = PiecewiseMap(
    lambda x: 0.05 + 0.9 * steps_in_the_outer_thirds(x)[1],
    (0, 1),
    derivative=lambda x: 0.9 * 3 ** (steps_in_the_outer_thirds(x)[0] + 1),
    label=lambda x: 1 + steps_in_the_outer_thirds(x)[0].astype(np.uint64),
)


def test_of_a_fractal_of_breaks_the_widest_branches_are_told_apart():
    table = branch_table(CANTOR)
    assert table.n_evaluations < 20_000
    assert 1e-5 < table.resolution < 1e-3
    assert (np.diff(table.unknown) > table.resolution).all()
    widths = np.array([b.right - b.left for b in table])
    for k in range(1, int(-np.log(2 * table.resolution) / np.log(3)) + 1):
        blurred = 3.0**-k - widths
        assert ((blurred > -1e-9) & (blurred < table.resolution)).sum() == 2 ** (k - 1)
    assert np.sum(widths) + np.diff(table.unknown).sum() == pytest.approx(1, abs=1e-3)
    assert len(branch_table(CANTOR, 1e-4)) > len(table)


@pytest.mark.parametrize("resolution", [0.0, -1e-9, 0.5, math.nan])
def test_resolution_is_positive_and_small(resolution):
    with pytest.raises(ValueError, match="resolution"):
        branches(examples.tent(), resolution)


def test_tables_are_made_once_per_map():
    f = examples.tent(1.9)
    assert branch_table(f) is branch_table(f)
    assert branch_table(f) is not branch_table(f.replace(slope=1.8))


@pytest.mark.parametrize("exponent", [1.0, 1.5], ids=["smooth", "root"])
def test_a_table_takes_few_calls_of_the_map(exponent):
    # Each costs as much as a handful of points. Rounding hides the curvature of narrow cells.
    @dataclass
    class Jump:
        domain: tuple[float, float] = (0.0, 1.0)
        calls: int = 0

        def evaluate(self, x, /):
            self.calls += 1
            x = np.asarray(x, dtype=float)
            off, right = np.abs(x - 0.377), x >= 0.377
            value = np.where(right, 0.3 + off**exponent, np.sin(3 * x))
            slope = np.where(right, exponent * off ** (exponent - 1), 3 * np.cos(3 * x))
            label = 1 + right.astype(np.uint64)
            return PointValues(value, slope, label, np.zeros(x.shape, dtype=np.int64), off)

    f = Jump()
    (jump,) = branch_table(f).breakpoints
    assert jump.d == 0.377
    assert f.calls <= CALLS


def test_powers_of_the_tent_map():
    table = branches(examples.tent(2.0).power(3))
    assert [b.d for b in table.breakpoints] == pytest.approx(np.arange(1, 8) / 8, abs=ROUNDING)
    assert {b.kind for b in table.breakpoints} == {"corner"}
    assert table.laps.direction.tolist() == [1, -1] * 4


def test_powers_of_the_square_root_map_have_no_jumps():
    table = branches(examples.square_root(0.2, 0.02).power(3))
    assert {b.kind for b in table.breakpoints} == {"corner"}
    assert len(table) == 8


def test_powers_of_a_map_with_a_gap():
    table = branches(examples.tent_with_hole(3.0).power(2))
    known = [[1 / 9, 2 / 9], [3 / 9, 6 / 9], [7 / 9, 8 / 9]]
    assert table.gaps == pytest.approx(np.array(known), abs=ROUNDING)


def test_repr_lists_what_there_is():
    assert "gap: no value" in repr(branches(examples.tent_with_hole()))
    assert "jump" in repr(breakpoints(examples.doubling(2.5)))


def test_a_single_point_at_the_end_of_the_domain_is_no_branch():
    f = PiecewiseMap(lambda x: np.mod(2 * x, 1), (0, 1), label=lambda x: np.floor(2 * x))
    table = branches(f)
    assert [b.d for b in table.breakpoints] == [0.5]
    assert table[-1].right == np.nextafter(1, 0)
    (item,) = table.unresolved
    assert item.lo == item.hi == 1


def test_stretches_flat_to_the_last_digit_end_the_search():
    # The slope is not 0, but the value does not change: its sign is no question of resolution.
    gauss = PiecewiseMap(lambda x: 0.3 + np.exp(-50 * x * x), (-5, 5))
    assert len(branches(gauss)) == 1
    assert branches(gauss).n_evaluations < 5000
    assert len(branches(examples.border_collision(1e-200, 2.0))) == 2
