"""Crises and band mergings against closed forms and independent solutions."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.analysis.bifurcations.scan.test_survey import random_family as parabolas
from tests.analysis.bifurcations.test_accounting_by_force import random_blocks
from tests.analysis.known_maps import logistic, tent
from tests.sizes import slow

import stickslip as ss
from stickslip import examples
from stickslip.analysis.bifurcations.crisis import crises as search
from stickslip.analysis.bifurcations.crisis.comparison import _is_paired, parameter_point
from stickslip.analysis.bifurcations.crisis.crises import CrisisSearch
from stickslip.analysis.bifurcations.crisis.unstable_neighbours import edges_of, meetings
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.mechanics.eventmap.event_map import EventMap

LOCATED = 1e-10  # what a located value is good for at least; most are at rounding


def crises(at, points, **options):
    search, intervals = CrisisSearch(at, **options), list(pairwise(points))
    return search.joined(intervals, (part() for part in search.parts(intervals)))


def found(at, values, **options):
    return crises(at, [parameter_point(at, value) for value in values], **options).events


def values(events, kind=None):
    return [event.value for event in events if kind in (None, event.kind)]


@pytest.mark.parametrize(("ends", "n"), [((3.99, 4.01), 1), ((3.856, 3.858), 0)])
def test_what_stays_undecided_beyond_is_a_crisis_only_if_the_edge_leaves(monkeypatch, ends, n):
    # At r = 4 the edge leaves; where three bands join, at 3.8568, it comes back.
    real = search.kind_of_change

    def undecided(*sides):
        kind = real(*sides)
        return "transient" if kind in ("boundary_crisis", "interior_crisis") else kind

    monkeypatch.setattr(search, "kind_of_change", undecided)
    events = found(logistic, list(ends), max_period=3)
    assert len(values(events, "boundary_crisis")) == n


def test_chaos_is_followed_to_its_end_on_the_scale_of_the_event_beside_it():
    # A window of period 3, 7e-6 long with a basin of 2 %, beside a stable cycle.
    model, name, _ = random_blocks(2 * 38007 + 1)

    def at(q):
        return ss.event_map(model.replace(**{name: q}))

    flips = [1.8919288863122348, 1.8919288898155047]
    points = [parameter_point(at, q) for q in (1.8885, flips[0] - 5.4e-9)]
    searched = crises(at, points, breaks=flips, max_period=3)
    assert [(event.kind, event.attractor.period) for event in searched.events] == [
        ("boundary_crisis", 3),
        ("band_merging", 6),
    ]
    assert values(searched.events) == pytest.approx([1.891927138650, 1.891928468096], abs=1e-11)
    assert len(searched.looks) < 10  # halvings alone end at 3.4e-6, after twelve


def test_beside_a_band_of_no_width_orbits_are_found_too():
    # A band that just meets a jump goes on to a band that is one point.
    point = parameter_point(logistic, 3.6)
    (chaos,) = point.attractors
    edges = [replace(edge, width=0.0) for edge in edges_of(chaos, point.table)]
    with np.errstate(all="raise"):
        found = [meeting.x for meeting in meetings(point.fast, edges, (1, 2))]
    assert set(np.round(found, 12)) == {round(1 - 1 / 3.6, 12)}


CUBIC = PiecewiseMap(
    lambda x, a: a * x - x**3,
    (-2.2, 2.2),
    parameters={"a": 2.5},
    derivative=lambda x, a: a - 3 * x**2,
)


def cubic(a):
    return CUBIC.replace(a=a)


# --- band merging -----------------------------------------------------------------------------


def test_bands_of_the_tent_map_merge_at_roots_of_two():
    events = found(tent, [1.15, 1.3, 1.5])
    assert {event.kind for event in events} == {"band_merging"}
    assert values(events) == pytest.approx([2**0.25, 2**0.5], abs=LOCATED)
    first, second = events
    assert [a.period for a in first.attractors_before] == [4]
    assert [a.period for a in first.attractors_after] == [2]
    # What attracts beside it was looked for without the list's stable cycles, and may lack them.
    assert all(side.quick for event in events for side in event.sides)
    # The orbit between the bands: the fixed point s / (1 + s), and its double.
    assert second.points == pytest.approx([2**0.5 / (1 + 2**0.5)])
    assert first.condition.period == 2
    assert all(
        abs(e.value - v) <= 10 * e.located.error
        for e, v in zip(events, (2**0.25, 2**0.5), strict=True)
    )


def image_of_top(r, n):
    x = 0.5
    for _ in range(n):
        x = r * x * (1 - x)
    return x


def two_cycle(r):
    root = np.sqrt((r + 1) * (r - 3))
    return np.array([r + 1 - root, r + 1 + root]) / (2 * r)


def test_inverse_cascade_of_the_logistic_map():
    # Where the third image of 1/2 is the fixed point: r^3 - 2 r^2 - 4 r - 8 = 0.
    (two,) = np.real([z for z in np.roots([1, -2, -4, -8]) if abs(z.imag) < 1e-12])
    four = brentq(lambda r: image_of_top(r, 7) - two_cycle(r)[1], 3.58, 3.6, xtol=1e-15)
    events = found(logistic, [3.572, 3.58, 3.62, 3.7])
    assert {event.kind for event in events} == {"band_merging"}
    assert values(events)[-2:] == pytest.approx([four, two], abs=LOCATED)
    # Feigenbaum's ratio from the other side of the accumulation.
    gaps = np.diff(values(events))
    assert len(events) == 3
    assert gaps[1] / gaps[0] == pytest.approx(4.669, rel=0.05)
    assert [a.period for e in events for a in e.attractors_after] == [4, 2, 1]


def test_a_cascade_is_followed_from_a_coarse_grid():
    events = found(logistic, [3.5, 3.7])
    periods = [event.attractors_after[0].period for event in events]
    assert periods[-4:] == [8, 4, 2, 1]


@pytest.mark.parametrize(
    "ends",
    [
        (3.5136961687321455, 3.6853957342752777),  # the first cut is in a window of long period
        # no end is chaotic: the second is in a window
        *slow(((3.4798696132818923, 3.693439897559127),)),
    ],
)
def test_windows_of_long_period_hide_no_merging(ends):
    events = found(logistic, ends)
    after = [event.attractors_after[0].period for event in events if event.kind == "band_merging"]
    assert {1, 2, 4, 8} <= set(after)


def test_what_is_not_searched_to_the_end_is_told():
    grid = [parameter_point(logistic, r) for r in (3.5, 3.7)]
    left_open = crises(logistic, grid, looks=6).left_open
    assert left_open
    assert all(3.5 <= left.value < right.value <= 3.7 for left, right in left_open)
    found = crises(logistic, grid)
    assert found.left_open == []
    # What remains of the inverse cascade ends at its accumulation.
    ((left, right),) = found.too_close
    assert left.value < 3.5699456718 < right.value


# --- interior crises --------------------------------------------------------------------------


def test_end_of_the_window_of_period_three():
    def off(r):
        # The unstable cycle of period 3 has the point right of 1/2, above the stable one's.
        cycle = brentq(lambda x: _third(r, x) - x, 0.53, 0.57, xtol=1e-16)
        return image_of_top(r, 6) - cycle

    def _third(r, x):
        for _ in range(3):
            x = r * x * (1 - x)
        return x

    expected = brentq(off, 3.855, 3.859, xtol=1e-15)
    (event,) = found(logistic, [3.853, 3.86])
    assert event.kind == "interior_crisis"
    assert event.value == pytest.approx(expected, abs=LOCATED)
    assert event.condition.period == 3
    assert [a.period for a in event.attractors_before] == [3]
    assert [a.period for a in event.attractors_after] == [1]


def test_two_attractors_become_one():
    # f(f(c)) = 0 for the symmetric cubic map: a^2 = 27 / 4.
    (event,) = found(cubic, [2.59, 2.61])
    assert event.kind == "interior_crisis"
    assert event.value == pytest.approx(np.sqrt(27 / 4), abs=LOCATED)
    assert event.points == pytest.approx([0.0], abs=1e-12)
    assert (len(event.attractors_before), len(event.attractors_after)) == (2, 1)


# --- boundary crises --------------------------------------------------------------------------


def test_attractor_meets_a_cycle_on_the_boundary_of_its_basin():
    # The cubic map's extremum 2 (a / 3)^(3/2) is on the cycle +-sqrt(a + 1) at a = 3.
    (event,) = found(cubic, [2.95, 3.05])
    assert event.kind == "boundary_crisis"
    assert event.value == pytest.approx(3.0, abs=LOCATED)
    assert sorted(event.points) == pytest.approx([-2.0, 2.0])
    assert [a.kind for a in event.attractors_before] == ["chaotic"]
    assert event.attractors_after == ()


# --- systems that nobody tuned for -------------------------------------------------------------


def random_family(seed):
    model, name, _ = random_blocks(seed)
    return lambda value: ss.event_map(model.replace(**{name: value}))


@pytest.mark.parametrize(
    ("seed", "ends", "met", "left", "above"),
    [
        (60056, (1.9827, 1.98275), 8, 9, True),  # the orbit met has twice the chaos's period
        (60004, (0.7642, 0.76421), 1, 5, False),  # a break is met, in a window of long period
    ],
)
def test_chaos_ends_at_the_border_of_its_basin_whatever_is_there(seed, ends, met, left, above):
    at = random_family(seed)
    (event,) = found(at, ends, max_period=3)
    assert event.kind == "boundary_crisis"
    assert len(event.points) == met
    aside, inside = 1e-2 * (ends[1] - ends[0]), event.attractor.bands.mean(axis=1)
    sides = (event.value - aside, event.value + aside)
    tails = [at(value).iterate(inside, 100_000)[:, -2 * left :] for value in sides]
    returned = [np.abs(tail[:, left:] - tail[:, :-left]).max() < LOCATED for tail in tails]
    assert returned == [not above, above]  # the cycle that is left takes all


def test_chaos_that_is_seen_beside_an_event_only_is_searched_for_its_end():
    """It lies between two values of the grid that show none of it."""
    model, name, ends = random_blocks(62372)
    found = ss.bifurcations(model, name, ends, max_period=3)
    assert found.unresolved == ()
    (end,) = (item for item in found if 1.9319 < item.value < 1.9322)
    assert end.kind == "boundary_crisis"
    sides = [ss.event_map(model.replace(beta=end.value + off)) for off in (-1e-4, 1e-4)]
    there = [[a.kind for a in ss.attractors(f)] for f in sides]
    assert ["chaotic" in kinds for kinds in there] == [False, True]


def test_a_break_joins_many_bands_at_once():
    (event,) = found(random_family(60050), (0.307395, 0.3073957), max_period=3)
    assert event.kind == "band_merging"
    assert [a.period for a in event.attractors_before] == [1]
    assert [a.period for a in event.attractors_after] == [8]


def bands_in_turn(f, near):
    """Tell by a cloud that starts in one band whether it fills two of them in turn."""
    cloud = np.linspace(near, near + 1e-9, 2000)
    for _ in range(500):  # it spreads by a twentieth a step
        cloud = f(cloud)
    cells = [(4000 * (x + 1) / 2).astype(int) for x in f.iterate(cloud, 200).T]
    return 1 if np.isin(np.concatenate(cells[::2]), np.concatenate(cells[1::2])).mean() > 0.1 else 2


def test_bands_merge_at_an_orbit_in_their_gaps_however_long_it_is():
    f = parabolas(np.random.default_rng(31))
    ends = (0.016, 0.0215)
    found = ss.bifurcations(f, "mu", ends, max_period=3)
    assert not found.unresolved
    assert [item.kind for item in found] == ["band_merging"] * 2
    assert [item.period for item in found] == [11, 11]  # twelve intervals, eleven gaps
    borders = [ends[0], *(item.value for item in found), ends[1]]
    for n, (a, b) in zip([1, 2, 1], pairwise(borders), strict=True):
        inside = [f.replace(mu=a + share * (b - a)) for share in (0.1, 0.9)]
        assert [bands_in_turn(g, -0.3871) for g in inside] == [n, n]


@pytest.mark.parametrize(("family", "last"), [(logistic, 4.0), (tent, 2.0)])
def test_crisis_at_the_very_end_of_the_range(family, last):
    (event,) = found(family, [last - 0.02, last])
    assert event.kind == "boundary_crisis"
    assert event.value == last
    assert event.points == pytest.approx([0.0], abs=1e-12)


def test_crisis_at_the_very_beginning_of_the_range():
    (event,) = found(lambda q: logistic(4 - q), [0.0, 0.02])
    assert (event.kind, event.value) == ("boundary_crisis", 0.0)
    assert event.attractors_before == ()


def test_events_far_closer_to_one_value_than_to_the_other_are_all_found():
    # Chaos in 24 bands at the lower value merges thrice, and dies within an eightieth of the way.
    a, b, c, d = -0.8995624615461084, 0.29289089534799806, -0.7510073465726459, -1.973822566579974
    f = PiecewiseMap(
        lambda x, m: m + a * x + b * x**2 + c * x**3 + d * x**4, (-1.5, 1.5), parameters={"m": 0.5}
    )
    events = found(
        lambda m: f.replace(m=m), [0.15520677973426847, 0.17364651783043075], max_period=3
    )
    assert [event.kind for event in events] == 3 * ["band_merging"] + ["boundary_crisis"]
    assert [event.attractor.period for event in events] == [24, 12, 6, 3]
    # By iteration: chaos stays chaos below the last value, above it orbits come to rest.
    end, start = events[-1].value, events[-1].attractor.point
    for m, rests in ((end - 1e-5, False), (end + 2e-4, True)):
        x = f.replace(m=m).iterate(start, 5000)[-3:]
        assert (np.ptp(x) < 1e-9) == rests


# --- nothing to report ------------------------------------------------------------------------


def test_chaos_that_only_changes_its_shape_is_no_event():
    assert found(tent, [1.5, 1.7, 1.9]) == []


def test_cycles_are_no_business_of_crises():
    assert found(logistic, [3.1, 3.3, 3.5]) == []


def test_changes_across_known_bifurcations_are_theirs():
    # The window of period 3 opens in a fold; its chaos is not searched for a crisis.
    fold = 1 + np.sqrt(8)
    looked = []

    def at(r):
        looked.append(r)
        return logistic(r)

    grid = [parameter_point(logistic, r) for r in (3.82, 3.84)]
    assert crises(at, grid, breaks=[fold]).events == []
    assert len(looked) < 12


@pytest.mark.slow
def test_sides_of_a_coarsely_located_change_stay_in_the_family():
    """A meeting located to within the whole range was looked at with a negative mu."""
    found = ss.bifurcations(examples.coulomb(), "mu", (0.15, 0.3), max_period=1)
    assert all(one.reason.endswith("not searched further") for one in found.unresolved)


# --- the paper's law (9) ----------------------------------------------------------------------


def law9(alpha):
    return WindowMap(EventMap(examples.law9(alpha=alpha)), (0.379, 0.390))


@pytest.mark.paper
def test_boundary_crisis_of_law_9():
    (event,) = found(law9, [1.2152, 1.2154])
    assert event.kind == "boundary_crisis"
    assert event.value == pytest.approx(1.215285651451, abs=1e-12)  # f(f(c)) = U1
    assert event.condition.k == 2
    assert event.condition.period == 1
    assert sorted(a.kind for a in event.attractors_before) == ["chaotic", "periodic"]
    assert [a.kind for a in event.attractors_after] == ["periodic"]


@pytest.mark.paper
def test_two_bands_of_law_9_merge_at_p1():
    (event,) = found(law9, [1.2121, 1.2131])
    assert event.kind == "band_merging"
    assert event.value == pytest.approx(1.2126875739476, abs=1e-12)
    f = law9(event.value)
    # The third image of the cusp is P1, by the map itself.
    cusp = f.iterate(event.located.reading.critical.x, 3)[-1]
    assert cusp == pytest.approx(event.points[0], abs=1e-10)
    assert float(f.evaluate(event.points[0]).value) == pytest.approx(event.points[0], abs=1e-13)


@pytest.mark.paper
@pytest.mark.slow
def test_chaos_after_the_cascade_of_s1():
    events = found(law9, [1.2157, 1.2158, 1.2159, 1.2161, 1.2167, 1.217])
    simple = [
        event for event in events if event.condition.period <= 2
    ]  # others end windows of chaos
    assert [(event.kind, event.condition.period) for event in simple] == [
        ("band_merging", 2),
        ("band_merging", 1),
        ("interior_crisis", 1),
        ("boundary_crisis", 2),
    ]
    assert values(simple)[-3:] == pytest.approx(
        [1.2158032077116, 1.2159799290608, 1.2169001602016], abs=1e-12
    )


@pytest.mark.parametrize(
    ("r", "period", "doubled"), [(3.566, 16, True), (3.55, 8, True), (3.9605, 4, False)]
)
def test_cycles_of_a_cascade_lie_two_by_two_and_those_of_a_window_do_not(r, period, doubled):
    x = 0.5
    for _ in range(100_000):
        x = r * x * (1 - x)
    points = logistic(r).iterate(np.array([x]), period)[0]
    assert abs(points[-1] - points[0]) < 1e-9
    assert _is_paired(points[:-1], 1) == doubled
