"""Margins save evaluations and show branches that no node has met."""

from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.discontinuities import FEW, LabelBrackets, find_discontinuities
from stickslip.analysis.branches.mesh import Mesh
from stickslip.analysis.branches.table import branch_table, tables_complete_above
from stickslip.analysis.maps.derived import PowerMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import PointValues

EVALUATIONS = 30  # per edge of a gap; halving alone takes 45
CALLS = 12  # of a map per change, each of a few points; without margins 18, by halving alone 55


@dataclass(frozen=True)
class Labelled:
    """Value x on [0, 1], a label per interval, gaps where asked, and a margin."""

    changes: tuple[float, ...]
    root_on: int = 0  # margins are square roots left (-1) or right (1) of each change
    tells_margin: bool = True
    gap: int | None = None
    domain: tuple[float, float] = (0.0, 1.0)

    def evaluate(self, x, /):
        x = np.asarray(x, dtype=float)
        changes = np.array(self.changes)
        label = np.searchsorted(changes, x, side="right")
        away = x[..., None] - changes
        size = np.abs(away)
        size = np.where(np.sign(away) == self.root_on, np.sqrt(size), 3 * size + size**2)
        margin = size.min(axis=-1) if self.tells_margin else np.full(x.shape, np.nan)
        in_gap = label == (-1 if self.gap is None else self.gap)
        nothing = np.where(in_gap, np.nan, 1.0)
        return PointValues(
            x * nothing, nothing, label.astype(np.uint64), np.where(in_gap, 2, 0), margin
        )


@given(at=st.floats(0.01, 0.99), root_on=st.sampled_from([-1, 0, 1]))
def test_margins_lead_to_the_change(at, root_on):
    f = Labelled((at,), root_on)
    mesh = Mesh(f, 1e-9, crowd=9)
    ends = mesh.nodes.take(slice(0, 1)), mesh.nodes.take(slice(-1, None))
    probe, calls = mesh.probe, list[int]()
    mesh.probe = lambda x: (calls.append(x.size), probe(x))[1]
    brackets = LabelBrackets(mesh, *ends)
    brackets.close(brackets.are_open)
    assert brackets.left.x[0] < at <= brackets.right.x[0]
    assert brackets.right.x[0] - brackets.left.x[0] <= 2 * np.spacing(at)
    assert len(calls) <= CALLS
    assert max(calls) < FEW


@given(at=st.floats(0.01, 0.99), tells=st.booleans())
def test_without_a_margin_it_is_halving(at, tells):
    f = Labelled((at,), tells_margin=tells)
    (change,) = branch_table(f).breakpoints
    assert change.d == pytest.approx(at, abs=2e-16)
    assert change.kind == "smooth"


@given(at=st.floats(0.05, 0.95), width=st.floats(2e-8, 1e-3), root_on=st.sampled_from([-1, 0, 1]))
def test_a_branch_between_two_of_the_same_kind_is_seen_by_its_margin(at, width, root_on):
    # Label 1 lies inside label 0, and the values go straight on.
    class Hidden(Labelled):
        def evaluate(self, x, /):
            got = super().evaluate(x)
            return PointValues(
                got.value, got.derivative, got.label % np.uint64(2), got.status, got.margin
            )

    f = Hidden((at, at + width), root_on)
    assert [b.d for b in branch_table(f).breakpoints] == pytest.approx([at, at + width], abs=3e-16)


@given(at=st.floats(0.1, 0.6), width=st.floats(0.05, 0.3))
def test_edges_of_a_gap_take_few_evaluations_inside_it(at, width):
    assume(at + width < 0.95)
    inside = []

    class Counting(Labelled):
        def evaluate(self, x, /):
            got = super().evaluate(x)
            inside.append(int(np.isnan(got.value).sum()))
            return got

    f = Counting((at, at + width), gap=1)
    table = branch_table(f)
    assert table.gaps == pytest.approx(np.array([[at, at + width]]), abs=3e-16)
    assert sum(inside) <= 2 * 101 * width + 2 * EVALUATIONS


def test_a_window_inside_a_gap_is_seen_by_the_margin():
    @dataclass(frozen=True)
    class Window(Labelled):
        def evaluate(self, x, /):
            got = super().evaluate(x)
            outside = (got.label == 1) | (got.label == 3)
            nothing = np.where(outside, np.nan, 1.0)
            status = np.where(outside, 2, 0)
            return PointValues(
                got.value * nothing, got.derivative * nothing, got.label, status, got.margin
            )

    f = Window((0.2, 0.5, 0.5007, 0.8))
    assert branch_table(f).gaps == pytest.approx(np.array([[0.2, 0.5], [0.5007, 0.8]]), abs=1e-15)


@dataclass(frozen=True)
class Long(Labelled):
    """Motions of as many events as told; clearances have no pattern where they do not return."""

    lost: int = 3
    returning: int = 3

    def evaluate(self, x, /):
        got = super().evaluate(x)
        lost = np.isnan(got.value)
        spent = np.where(lost, self.lost, self.returning)
        margin = np.where(lost, (1e7 * np.asarray(x)) % 1.0, got.margin)
        return PointValues(got.value, got.derivative, got.label, got.status, margin, n_events=spent)


@pytest.mark.parametrize("of_many", [True, False])
def test_where_motions_of_a_gap_are_long_it_is_probed_less_and_the_table_says_so(of_many):
    """The search of the gap for branches took minutes; the rest is resolved as elsewhere."""
    f = Long((0.2, 0.6), gap=1, lost=5000)
    with tables_complete_above(1e-9) if of_many else nullcontext():
        table = branch_table(f)
    assert table.gaps == pytest.approx(np.array([[0.2, 0.6]]), abs=3e-16)
    assert table.n_evaluations < 700
    assert table.resolution == 1e-9
    (told,) = table.unresolved
    assert "motions that do not return are long" in told.reason
    assert told.lo >= 0.2
    assert told.hi <= 0.6
    assert branch_table(f, 1e-9).n_evaluations > 1000  # what is asked for is done
    assert branch_table(PowerMap(f, 2)).n_evaluations < 1000


def test_where_motions_are_long_less_is_resolved_and_the_table_says_so():
    f = Long((0.2, 0.2005, 0.6), returning=5000)
    with tables_complete_above(1e-9):
        table = branch_table(f)
    assert table.resolution == pytest.approx(1e-3)
    assert "motions are long: only wide branches are told apart" in str(table.unresolved)


def test_limits_are_as_sharp_where_less_is_resolved():
    f = PiecewiseMap(
        lambda x: np.where(x < 0.3, np.exp(x), np.sin(9 * x)), (-1.0, 1.0), breakpoints=[0.3]
    )
    (found,) = branch_table(f, 1e-3).breakpoints
    assert (found.left, found.right) == pytest.approx((np.exp(0.3), np.sin(2.7)), abs=1e-14)


@pytest.mark.parametrize("curved", [0.0, 30.0, -3000.0])
def test_limits_beside_a_graze_are_sharp(curved):
    """There slopes are s0 + a sqrt(distance), and none is that of the limit."""
    f = PiecewiseMap(
        lambda x: np.where(
            x < 0.3, 0.2 + 2 * (x - 0.3) + curved * np.maximum(0.3 - x, 0) ** 1.5, x - 1
        ),
        (0.29, 0.31),
        derivative=lambda x: np.where(
            x < 0.3, 2 - 1.5 * curved * np.sqrt(np.maximum(0.3 - x, 0)), 1.0
        ),
        breakpoints=[0.3],
    )
    (found,) = branch_table(f).breakpoints
    assert (found.left, found.right) == pytest.approx((0.2, -0.7), abs=1e-16 + 1e-18 * abs(curved))
    assert found.left_slope == pytest.approx(2, abs=1e-4)


def test_a_motion_that_comes_to_rest_for_a_moment_is_one_motion_with_two_returns():
    """Where a graze ends global stick as it begins, f(f(d-)) = f(d+): law (9), a random system."""
    f = ss.event_map(
        ss.TwoBlock(
            2.9470758852, 0.7554573133, 0.0215292171, ss.PoppStelter(0.6264479105, 0.10146357544)
        )
    )
    graze = min(branch_table(f).breakpoints, key=lambda b: abs(b.d + 0.0226236))
    assert graze.kind == "jump"
    assert f(graze.left) == pytest.approx(graze.right, abs=1e-14)


@pytest.mark.parametrize("aside", [3e-11, 5e-10, 3e-9, 5e-8, 1e-6])
def test_a_jump_beside_a_change_of_label_is_found(aside):
    """A motion that grazes and lands at once jumps within one itinerary."""
    f = PiecewiseMap(
        lambda x: np.where(x < 0, 0.2 - 50 * x, 0.6 + 0.4 * x), (-1.0, 1.0), breakpoints=[aside]
    )
    jump = branch_table(f).breakpoints[0]
    assert jump.kind == "jump"
    assert jump.d == (0.0 if aside > 1e-9 else pytest.approx(aside, abs=1e-18))
    assert jump.left == pytest.approx(0.2, abs=1e-14)
    assert (jump.right, jump.left_slope) == pytest.approx((0.6 + 0.4 * jump.d, -50), abs=1e-9)


def test_two_jumps_close_together_are_both_found():
    f = PiecewiseMap(
        lambda x: np.where(x < 0, 0.3, np.where(x < 4e-8, -0.2, 0.1)) + 0.5 * x, (-1.0, 1.0)
    )
    assert [item.d for item in branch_table(f).breakpoints] == pytest.approx([0, 4e-8], abs=1e-18)


@pytest.mark.parametrize(
    "flipped", [[], [4, 5, 6], [2, 3], [-2, -1], [-4, -1, 2, 5], [-1, 0, 3, 4]]
)
def test_a_jump_at_which_rounding_chooses_the_side_is_found(flipped):
    """Law (9) with a jump within one itinerary took either value on some ten floats about it."""

    def sides(x):
        floats = np.round((x - 0.3) / np.spacing(0.3))
        return (floats > 0) ^ np.isin(floats, flipped)

    f = PiecewiseMap(
        lambda x: np.where(sides(x), 0.7 - 2 * x, -0.1 - 2 * x),
        (-1.0, 1.0),
        derivative=lambda x: np.full_like(x, -2.0),
    )
    (jump,) = branch_table(f).breakpoints
    assert jump.kind == "jump"
    assert jump.d == pytest.approx(0.3, abs=1e-15)
    assert (jump.left, jump.right) == pytest.approx((-0.7, 0.1), abs=1e-9)


def singular_jump(at):
    """A jump whose sides are logarithms of the distance, left of a change of label at 0.3."""
    return PiecewiseMap(
        lambda x: np.where(x < at, 0.016, 0.187) + 2.5e-4 * np.log(np.maximum(abs(x - at), 1e-17)),
        (-1.0, 1.0),
        derivative=lambda x: 2.5e-4 / np.where(x == at, 1e-17, x - at),
        breakpoints=[0.3],
    )


@pytest.mark.parametrize("off", [-1e-11, -1e-12, -1e-13, 0.0, 1e-13, 1e-12, 1e-11])
def test_a_singular_jump_is_found_wherever_a_mesh_meets_it(off):
    """Beside it a slope is as steep as the step: law of Stribeck, blocks that creep and let go."""
    at = 0.3 - 1.6e-9
    find_discontinuities(mesh := Mesh(singular_jump(at), 1e-9, 64))
    at = mesh.nodes.x[np.abs(mesh.nodes.x - at).argmin()] + off
    jump = branch_table(singular_jump(at)).breakpoints[0]
    assert (jump.kind, jump.quality) == ("jump", "located")
    assert jump.d == pytest.approx(at, abs=1e-16)
    # A logarithm has no limit: what is known is how far its values get.
    assert (jump.left, jump.right) == pytest.approx((0.0068, 0.1778), abs=1e-3)
    assert jump.scatter == pytest.approx((2.5e-4, 2.5e-4), rel=1e-3)


@pytest.mark.parametrize(
    ("power", "known"), [(0.5, 1e-12), (1 / 3, 1e-9), (0.25, 1e-7), (0.03, None)]
)
def test_limits_are_told_where_values_come_near_them(power, known):
    """The small power: law of Stribeck, alpha = 3.14; taken for a limit it moved with the float."""
    f = PiecewiseMap(
        lambda x: np.where(x < 0.3, 0.5 * x, 0.6 + 0.1 * np.maximum(x - 0.3, 1e-17) ** power),
        (0.0, 1.0),
        derivative=lambda x: np.where(
            x < 0.3, 0.5, 0.1 * power * np.maximum(x - 0.3, 1e-17) ** (power - 1)
        ),
        breakpoints=[0.3],
    )
    (jump,) = branch_table(f).breakpoints
    assert jump.right_slope == np.inf
    if known is not None:
        assert jump.right == pytest.approx(0.6, abs=known)
        assert jump.scatter == (0.0, 0.0)
        return
    assert jump.right == f(0.3)
    assert jump.scatter[1] == pytest.approx(1e-9**power * 0.1 * power, rel=1e-2)
    collision = Collision(1, TrackedDiscontinuity.of(jump), 1)
    assert collision.at(f).noise > jump.scatter[1]


@given(at=st.floats(0.1, 0.9))
def test_beside_a_jump_values_that_scatter_do_not_lead_away_from_it(at):
    def value(x):
        scatter = 1e-15 * np.sin(1e19 * x)
        return np.where(x < at, 0.1 - 9 * (x - at), 0.4 + 0.8 * (x - at) + scatter)

    f = PiecewiseMap(value, (0.0, 1.0), derivative=lambda x: np.where(x < at, -9.0, 0.8))
    (jump,) = (b for b in ss.breakpoints(f) if b.kind == "jump")
    assert jump.d == pytest.approx(at, abs=1e-15)
    assert jump.quality == "located"


@pytest.mark.parametrize("width", [1e-9, 4e-9, 1e-8, 1e-7])
def test_a_steep_smooth_function_has_no_break(width):
    f = PiecewiseMap(
        lambda x: 0.3 * np.tanh((x - 0.3) / width),
        (-1.0, 1.0),
        derivative=lambda x: 0.3 / width / np.cosh(np.clip((x - 0.3) / width, -300, 300)) ** 2,
    )
    assert not branch_table(f).breakpoints


def test_values_that_scatter_make_no_break():
    """Where motions are sensitive, neighbouring floats differ by more than slopes explain."""

    def sensitive(x):
        return 0.3 * np.tanh((x - 0.3) / 4e-9) + 4e-8 * ((1e16 * x) % 1.0)

    def slope(x):
        return 0.3 / 4e-9 / np.cosh(np.clip((x - 0.3) / 4e-9, -300, 300)) ** 2

    f = PiecewiseMap(sensitive, (-1.0, 1.0), derivative=slope)
    assert not branch_table(f).breakpoints


def rounded_and_steep(place, **options):
    """Steep at a place near 0, where for a hundred floats sums are one, and then another."""
    width = 1.4e-8
    return PiecewiseMap(
        lambda x: -0.03 * np.arctan((x + 1 - (1 + place)) / width),
        (-0.11, 0.11),
        derivative=lambda x: -0.03 / width / (1 + ((x - place) / width) ** 2),
        **options,
    )


@pytest.mark.parametrize("place", np.linspace(0.008, 0.009, 8))
def test_what_rounding_of_sums_makes_of_a_steep_function_is_no_break(place):
    assert not branch_table(rounded_and_steep(place)).breakpoints


@pytest.mark.parametrize("off", np.linspace(0, 1e-8, 8))
def test_nor_is_it_a_jump_where_the_label_changes(off):
    place = 0.0082
    f = rounded_and_steep(place, label=lambda x: np.where(x < place + off, 1, 2))
    assert [b.kind for b in branch_table(f).breakpoints] == ["smooth"]
    (border,) = branch_table(f).breakpoints
    assert TrackedDiscontinuity.of(border).at(f).kind == "smooth"


def test_limits_at_a_bracket_are_those_at_its_ends():
    """Branches accumulate at 0, ever steeper; what lies within a billionth is not told apart."""

    def f(x):
        turns = np.log(np.maximum(np.abs(x - 0.1), 1e-300)) / np.log(6.0)
        return np.where(x < 0.1, 0.2, -0.3) + 0.1 * (turns - np.floor(turns))

    aside = 6.0 ** -np.arange(16)
    table = branch_table(
        PiecewiseMap(f, (-1.0, 1.0), breakpoints=sorted([*(0.1 - aside[1:]), *(0.1 + aside[1:])]))
    )
    assert "bracketed" in {b.quality for b in table.breakpoints}
    sides = np.array([(b.left, b.right) for b in table.breakpoints])
    inside = (np.abs(sides - 0.25) < 0.0501) | (np.abs(sides + 0.25) < 0.0501)
    assert (inside | np.isnan(sides)).all()


def test_of_infinitely_many_branches_without_labels_the_widest_are_told_and_no_orbit_elsewhere():
    """Gauss's map has the fixed points (sqrt(n^2 + 4) - n) / 2, of multiplier -1 / x^2."""
    gauss = PiecewiseMap(lambda x: 1 / np.where(x > 0, x, np.nan) % 1, (0.0, 1.0))
    orbits = ss.periodic_orbits(gauss, 1)
    n = np.arange(1, 1000)
    x = 2 / (n + np.sqrt(n**2 + 4))
    open_to = np.array([(u.lo, u.hi) for u in orbits.unresolved]).T[:, :, None]
    told = ~((open_to[0] <= x) & (x <= open_to[1])).any(axis=0)
    assert np.count_nonzero(told) > 240
    np.testing.assert_allclose([o.points[0] for o in orbits[::-1]], x[told], rtol=1e-12)
    np.testing.assert_allclose([o.multiplier for o in orbits[::-1]], -(x[told] ** -2), rtol=1e-7)
    assert branch_table(gauss).n_evaluations < 1e5
