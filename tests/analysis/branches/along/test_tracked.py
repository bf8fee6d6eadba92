"""Borders and turning points find themselves in a changed map."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from tests.analysis.known_maps import (
    border_collision,
    doubling,
    logistic,
    square_root,
    tent_with_hole,
)
from tests.sizes import sizes

from stickslip import Coulomb, TwoBlock, examples
from stickslip.analysis.bifurcations.curves.breakpoint_curves import follow_breakpoint
from stickslip.analysis.branches.along import change_search, tracked
from stickslip.analysis.branches.along.tracked import (
    ConditionLost,
    TrackedDiscontinuity,
    TurningPoint,
)
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import PointValues, sample
from stickslip.mechanics.eventmap.event_map import EventMap

ROUNDING = 1e-14
TIE = 1e-13  # labels flicker within that of a tie of two events
LIMIT = 1e-12  # one-sided values are extrapolated over 1e-11
SLOPE = 1e-6  # ... slopes over 1e-9, beside grazes with a square root in them


def borders_of(f):
    return [TrackedDiscontinuity.of(b) for b in breakpoints(f)]


def assert_agrees(reading, b):
    """A border found by itself and a breakpoint of a complete table are the same."""
    assert reading.x == pytest.approx(b.d, abs=TIE)
    assert reading.kind == b.kind
    assert reading.left == pytest.approx(b.left, abs=LIMIT, nan_ok=True)
    assert reading.right == pytest.approx(b.right, abs=LIMIT, nan_ok=True)
    assert reading.left_slope == pytest.approx(b.left_slope, rel=SLOPE, abs=SLOPE, nan_ok=True)
    assert reading.right_slope == pytest.approx(b.right_slope, rel=SLOPE, abs=SLOPE, nan_ok=True)


def test_moving_jump():
    f = doubling(1.5)
    (border,) = borders_of(f)
    reading = border.at(f.replace(slope=1.6))
    assert reading.x == pytest.approx(1 / 1.6, abs=ROUNDING)
    assert (reading.left, reading.right) == pytest.approx((1.0, 0.0), abs=ROUNDING)
    assert reading.kind == "jump"
    # Where it is now is where the next search starts.
    assert reading.critical.x == reading.x
    assert reading.critical.reach == pytest.approx(1 / 1.5 - 1 / 1.6)


def test_a_border_is_found_once_in_a_map(monkeypatch):
    """Conditions on one border are read off together, in a list by the hundred."""
    f = examples.coulomb().as_map()
    border = borders_of(f)[0]
    other, asked, plain = f.replace(V=0.03671234), [], EventMap.evaluate
    monkeypatch.setattr(EventMap, "evaluate", lambda self, d: asked.append(d) or plain(self, d))
    first = border.at(other)
    n = len(asked)
    assert n > 0
    assert border.at(f.replace(V=0.03671234)) == first
    assert len(asked) == n


def test_one_sided_values_and_slopes_of_a_corner_and_of_a_root():
    corner = borders_of(border_collision(a=0.5, b=-2.0, mu=1.0))[0]
    reading = corner.at(border_collision(a=0.7, b=-3.0, mu=-0.25))
    assert (reading.x, reading.kind) == (0.0, "corner")
    assert (reading.value(-1), reading.value(1)) == pytest.approx((-0.25, -0.25), abs=ROUNDING)
    assert (reading.slope(-1), reading.slope(1)) == pytest.approx((0.7, -3.0), abs=ROUNDING)
    root = borders_of(square_root(0.2, 0.1))[0].at(square_root(0.3, 0.05))
    assert (root.left_slope, root.right_slope) == pytest.approx((0.3, -math.inf))
    assert (root.left, root.right) == pytest.approx((0.05, 0.05), abs=LIMIT)


def test_edges_of_a_gap():
    f = tent_with_hole(3.0)
    left, right = (b for b in borders_of(f) if b.kind == "edge")
    assert (left.right_label, right.left_label) == (None, None)
    moved = f.replace(slope=2.5)
    assert left.at(moved).x == pytest.approx(0.4, abs=ROUNDING)
    assert right.at(moved).x == pytest.approx(0.6, abs=ROUNDING)
    assert left.at(moved).left == pytest.approx(1.0, abs=ROUNDING)
    assert math.isnan(left.at(moved).right)
    assert math.isnan(left.at(moved).right_slope)


def test_jump_that_becomes_a_corner_and_a_smooth_change():
    f = border_collision(a=0.5, b=-2.0, mu=0.1, jump=0.3)
    (border,) = borders_of(f)
    assert border.at(f).kind == "jump"
    assert border.at(f.replace(jump=0.0)).kind == "corner"
    assert border.at(f.replace(jump=0.0, b=0.5)).kind == "smooth"


def test_jump_without_a_label_that_has_moved_far():
    f = PiecewiseMap(
        lambda x, c: np.where(x < c, x * x, 0.5 - 0.5 * x), (0, 1), parameters={"c": 0.3}
    )
    (border,) = borders_of(f)
    assert not border.labelled
    reading = border.at(f.replace(c=0.38))
    assert reading.x == pytest.approx(0.38, abs=ROUNDING)
    assert (reading.left, reading.right) == pytest.approx((0.38**2, 0.31), abs=LIMIT)


def sliver_map(width=0.0, c=0.4):
    """Two long branches with a third one, ``width`` wide, between them."""
    return PiecewiseMap(
        lambda x, c, width: np.where(x < c, x, np.where(x < c + width, 0.9, x - 0.2)),
        (0, 1),
        parameters={"c": c, "width": width},
        label=lambda x, c, width: np.where(x < c, 1, np.where(x < c + width, 2, 3)),
    )


@pytest.mark.parametrize("step", [1e-3, 0.3])
@pytest.mark.parametrize("c", [0.0, 0.4 + 1e-9, 0.4 - 2e-4])
def test_jump_without_a_label_needs_no_table(monkeypatch, c, step):
    f = PiecewiseMap(
        lambda x, c: np.sin(x) + np.where(x < c, 0.0, step), (-1, 1), parameters={"c": 0.4}
    )
    border = TrackedDiscontinuity(0, 0, f.parameters["c"] if c else 1e-4, "jump")
    (expected,) = breakpoints(f.replace(c=c))
    monkeypatch.setattr(tracked, "branch_table", None)
    reading = border.at(f.replace(c=c))
    assert_agrees(reading, expected)
    assert (reading.critical.x, reading.labels) == (reading.x, (0, 0))


@pytest.mark.parametrize("share", [1e-3, 1e-2, 0.05])
def test_a_singular_jump_without_a_label_needs_no_table(monkeypatch, share):
    """Law of Stribeck, of a block that creeps and lets go: 8 ms instead of 100 ms."""
    f = PiecewiseMap(
        lambda x, at: (
            np.where(x < at, -0.1, 0.2) + 0.3 * share * np.log(np.maximum(abs(x - at), 1e-17))
        ),
        (-1.0, 1.0),
        parameters={"at": 0.3},
        derivative=lambda x, at: 0.3 * share / np.where(x == at, 1e-17, x - at),
    )
    (border,) = borders_of(f)
    monkeypatch.setattr(tracked, "_by_table", refuse)
    for off in (1e-9, -1e-6, 1e-4, -1e-3):
        reading = border.at(f.replace(at=0.3 + off))
        assert reading.x == pytest.approx(0.3 + off, abs=TIE)
        assert reading.kind == "jump"


def refuse(*_):
    raise AssertionError("a table was asked")


def test_small_jump_without_a_label_is_found_among_steep_branches():
    # Its step is less than the values rise beside it; that of a jump close by is more.
    f = PiecewiseMap(
        lambda x, c: np.where(x < 0.4, -2.5, np.where(x < c, 0.1 - 2e7 * (x - 0.4), -1.8)),
        (-3, 3),
        parameters={"c": 0.4 + 1e-7},
    )
    border = TrackedDiscontinuity(0, 0, 0.4 + 8e-8, "jump")
    assert border.at(f).x == pytest.approx(0.4 + 1e-7, abs=ROUNDING)


@pytest.mark.parametrize("width", [0.0, 1e-15, 1e-12, 1e-10])
def test_third_label_narrower_than_the_resolution_is_none(width):
    (border,) = borders_of(sliver_map())
    reading = border.at(sliver_map(width, c=0.41))
    assert reading.x == pytest.approx(0.41, abs=2e-10)
    assert (reading.left, reading.right) == pytest.approx((0.41, 0.21), abs=2e-10)


def test_border_goes_on_with_the_side_that_is_left():
    # A wider third branch splits the border: one of the two breaks takes over.
    (border,) = borders_of(sliver_map())
    reading = border.at(sliver_map(1e-4))
    assert {reading.critical.left_label, reading.critical.right_label} in ({1, 2}, {2, 3})


def test_border_that_is_gone():
    f = doubling(2.5)
    second = borders_of(f)[1]
    with pytest.raises(ConditionLost, match=r"the jump at 0\.8 is gone"):
        second.at(f.replace(slope=1.5))


def test_border_near_the_end_of_the_domain_and_outside_a_window():
    f = doubling(1.5)
    (border,) = borders_of(f)
    near_the_end = f.replace(slope=1.0 + 1e-12)
    assert border.at(near_the_end).x == pytest.approx(1 - 1e-12, abs=ROUNDING)
    inside = WindowMap(f, (0.1, 0.7))
    assert border.at(inside).x == pytest.approx(2 / 3, abs=ROUNDING)
    assert border.at(inside.replace(slope=1.0 / 0.7)).x == pytest.approx(0.7, abs=ROUNDING)
    with pytest.raises(ConditionLost, match="has left the window"):
        border.at(inside.replace(slope=1.3))


@dataclass(frozen=True)
class Crowded:
    """Branches ever narrower towards a wide one: x + 0.1 there, on the other side any value."""

    at: float
    side: int  # of the wide branch
    domain: tuple[float, float] = (0.0, 1.0)
    asked: list[int] = field(default_factory=list, compare=False)

    def evaluate(self, x, /):
        x = np.asarray(x, dtype=float)
        self.asked.append(x.size)
        away = self.side * (x - self.at)
        turn = np.floor(-np.log(np.maximum(-away, 1e-300)) / np.log(1.2)) + 50
        label = np.where(away >= 0, 7, 10 + turn).astype(np.uint64)
        value = np.where(away >= 0, x + 0.1, 0.3 + 0.2 * np.sin(turn))
        nothing = np.full(x.shape, np.nan)
        return PointValues(value, (away >= 0) * 1.0, label, np.zeros(x.shape, dtype=int), nothing)


@pytest.mark.parametrize("side", [-1, 1])
def test_an_edge_beside_a_crowd_is_found_without_telling_its_branches_apart(side):
    labels = (7, None) if side < 0 else (None, 7)

    def edge(f):
        return next(b for b in borders_of(f) if (b.left_label, b.right_label) == labels)

    f = Crowded(0.4001, side)
    reading = edge(Crowded(0.4, side)).at(f)
    assert sum(f.asked) < 600  # a table takes some thousands
    assert (reading.labels, reading.kind) == (tuple(label or 0 for label in labels), "edge")
    assert edge(f).x == pytest.approx(0.4001, abs=1e-6)  # with less resolved, as nearly
    assert reading.x == pytest.approx(0.4001, abs=TIE)
    assert reading.value(side) == pytest.approx(0.5001, abs=LIMIT)
    assert np.isnan(reading.value(-side))
    assert reading.critical.at(Crowded(0.4, side)).x == pytest.approx(0.4, abs=TIE)


def test_turning_point():
    f = PiecewiseMap(lambda x, c: 0.9 - (x - c) ** 2, (0, 1), parameters={"c": 0.3})
    reading = TurningPoint(0.3).at(f.replace(c=0.45))
    assert reading.x == pytest.approx(0.45, abs=1e-12)
    assert (reading.left, reading.right) == (reading.right, reading.left)
    assert reading.left == pytest.approx(0.9, abs=ROUNDING)
    assert (reading.left_slope, reading.right_slope, reading.kind) == (0, 0, "turning point")
    assert reading.critical == TurningPoint(reading.x)
    with pytest.raises(ConditionLost, match="has left the window"):
        TurningPoint(0.3).at(WindowMap(f, (0.4, 0.6)))
    with pytest.raises(ConditionLost, match="is gone"):
        TurningPoint(0.3).at(PiecewiseMap(lambda x: 0.5 * x, (0, 1)))


def test_conditions_on_one_turning_point_search_for_it_once():
    asked = []

    def parabola(x):
        asked.append(x)
        return 0.9 - (x - 0.45) ** 2

    f = PiecewiseMap(parabola, (0, 1))
    reading = TurningPoint(0.3).at(f)
    n = len(asked)
    assert TurningPoint(0.3).at(WindowMap(f, (0.1, 0.9))) == reading
    assert len(asked) == n
    far = TurningPoint(0.3, reach=0.2).at(f)  # how far is looked does not count as the same point
    assert far.x == pytest.approx(reading.x, rel=1e-12)
    assert len(asked) > n


def test_corner_is_no_turning_point():
    f = border_collision(a=0.5, b=-2.0, mu=1.0)
    with pytest.raises(ConditionLost, match="jumps over 0"):
        TurningPoint(0.1).at(f)


def test_logistic_turning_point_does_not_move():
    assert TurningPoint(0.5).at(logistic(3.9)).x == pytest.approx(0.5, abs=1e-15)


# ---------------------------------------------------------------- event maps


@pytest.mark.parametrize("name", ["alpha", "beta", "V", "mu"])
@pytest.mark.parametrize("n", sizes(4, 10))
def test_borders_of_random_event_maps_agree_with_their_tables(n, name):
    rng = np.random.default_rng(11)
    compared = 0
    for _ in range(n):
        model = TwoBlock(
            alpha=rng.uniform(0.5, 2), beta=rng.uniform(0.7, 1.6), V=rng.uniform(0.02, 0.1),
            friction=Coulomb(mu=rng.uniform(0.1, 0.6)),
        )  # fmt: skip
        f = EventMap(model)
        g = f.replace(**{name: f.parameters[name] * (1 + 1e-6)})
        after = {(b.left_label, b.right_label): [] for b in breakpoints(g)}
        for b in breakpoints(g):
            after[b.left_label, b.right_label].append(b)
        for border in borders_of(f):
            same = after.get((border.left_label, border.right_label), [])
            # Two pairs of branches with the same labels are told apart by their place only.
            if len(same) == 1:
                assert_agrees(border.at(g), same[0])
                compared += 1
    assert compared > 6 * n


def test_a_border_is_looked_for_where_it_is_expected(monkeypatch):
    f = EventMap(examples.coulomb())
    looks = []

    def counted(*arguments):
        looks.append(1)
        return sample(*arguments)

    monkeypatch.setattr(change_search, "sample", counted)
    # Not what other tests have found of this map.
    monkeypatch.setattr(tracked, "_by_labels", tracked._by_labels.__wrapped__)
    # Others are ties of events: a third label flickers between their ends.
    clean = [b for b in breakpoints(f) if np.nextafter(*b.interval) == b.interval[1]]
    assert len(clean) == 5
    for item in clean:
        looks.clear()
        assert TrackedDiscontinuity.of(item).at(f.replace()).interval == item.interval
        assert len(looks) == 1


def test_border_followed_there_and_back_is_the_same():
    f = EventMap(examples.law9(alpha=1.208))
    (border,) = [b for b in borders_of(WindowMap(f, (0.379, 0.390))) if b.kind == "corner"]
    there = border.at(f.replace(alpha=1.2085))
    back = there.critical.at(f)
    assert back.x == pytest.approx(border.x, abs=TIE)
    assert there.x != pytest.approx(border.x, abs=1e-5)


# ---------------------------------------------------------------- curves of breakpoints


def test_breakpoint_curve_in_closed_form():
    f = doubling(1.5)
    (b,) = breakpoints(f)
    curve = follow_breakpoint(b, f, "slope", (1.1, 1.9))
    assert (curve.values[0], curve.values[-1]) == (1.1, 1.9)
    assert curve.end_reasons == ("end of range", "end of range")
    assert np.all(np.diff(curve.values) > 0)
    assert curve.points[:, 0] == pytest.approx(1 / curve.values, abs=ROUNDING)
    assert curve.data["left"] == pytest.approx(np.ones(len(curve.values)), abs=LIMIT)
    assert curve.data["left_slope"] == pytest.approx(curve.values, rel=SLOPE)
    assert curve.at(slope=1.3).d == pytest.approx(1 / 1.3, abs=ROUNDING)
    # Cubic through neighbours: as dense as the line is bent.
    middle = 0.5 * (curve.values[1:] + curve.values[:-1])
    straight = 0.5 * (curve.points[1:, 0] + curve.points[:-1, 0])
    assert np.max(np.abs(straight - 1 / middle)) < 2e-3


def test_breakpoint_curve_ends_where_the_breakpoint_leaves_the_domain():
    f = doubling(2.5)
    second = breakpoints(f)[1]
    curve = follow_breakpoint(second, f, "slope", (1.5, 3.0))
    # The second jump, at 2 / slope, is at the end of the domain for slope 2.
    assert curve.values[0] == pytest.approx(2.0, abs=1e-9)
    assert "is gone" in curve.end_reasons[0]
    assert curve.end_reasons[1] == "end of range"
    with pytest.raises(ValueError, match="outside the curve"):
        curve.at(slope=1.9)


def test_breakpoint_curve_checks_its_arguments():
    f = doubling(1.5)
    (b,) = breakpoints(f)
    with pytest.raises(ValueError, match="'slop' is not a parameter"):
        follow_breakpoint(b, f, "slop", (1.1, 1.9))
    with pytest.raises(ValueError, match=r"does not contain slope = 1\.5"):
        follow_breakpoint(b, f, "slope", (1.6, 1.9))
    with pytest.raises(ValueError, match="lo < hi"):
        follow_breakpoint(b, f, "slope", (1.9, 1.1))
    with pytest.raises(ValueError, match=r"give its value as at\(slope="):
        follow_breakpoint(b, f, "slope", (1.4, 1.6)).at(r=1)


def test_floats_of_a_third_branch_at_a_tie_of_events_are_none():
    """Rounding takes the events in an order that occurs nowhere else: on three floats, say."""
    tie = 0.3
    after = tie + 3 * float(np.spacing(tie))

    def value(x, a):
        return np.where(x < tie, a, np.where(x < after, a + 1.0, a + 2.0))

    f = PiecewiseMap(value, (-1.0, 5.0), parameters={"a": 0.1}, breakpoints=[tie, after])
    left, third, right = f.evaluate(np.array([0.0, tie, 1.0])).label.tolist()
    assert TrackedDiscontinuity(left, right, 0.31, "jump").at(f).right == 2.1
    for flicker in (
        TrackedDiscontinuity(left, third, 0.301, "jump"),
        TrackedDiscontinuity(third, right, 0.301, "jump"),
    ):
        with pytest.raises(ConditionLost):
            flicker.at(f, successors=False)
        assert (flicker.at(f).left, flicker.at(f).right) == (0.1, 2.1)
