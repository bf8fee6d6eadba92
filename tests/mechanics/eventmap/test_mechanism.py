"""Breakpoints of both of the paper's maps, and what the motions beside them do."""

import functools
import re

import numpy as np
import pytest
from tests.reference.values import COULOMB_JUMPS

import stickslip as ss
from stickslip.mechanics.eventmap import mechanism
from stickslip.mechanics.eventmap.mechanism import mechanism_between

COULOMB, LAW9 = ss.examples.coulomb(), ss.examples.law9()
ENDS = r"block (\d) comes to rest at the (lower|upper) end of its stick interval, X_\d = (\S+):"
GRAZES = r"block (\d) grazes its stick interval near X_\d = (\S+), (inside|at an end point)"
COINCIDE = r"the (.+) of block (\d) and the (.+) of block (\d) coincide"
TOUCHES = r"the force on riding block (\d) touches its (lower|upper) static limit"

# (d rounded, kind, mechanism up to its first comma)
COULOMB_TABLE = [
    (-0.19798, "jump", "the coming to rest of block 1 and the release of block 2 coincide"),
    (-0.11029, "jump", "block 1 grazes its stick interval near X_1 = 0.182"),
    (0.08824, "smooth", "both blocks reach their static limits together at the onset"),
    (0.08927, "smooth", "the coming to rest of block 1 and the coming to rest of block 2 coincide"),
    (0.17070, "jump", "block 1 comes to rest at the lower end of its stick interval"),
    (0.27914, "jump", "block 2 grazes its stick interval near X_2 = 0.0258"),
    (0.30184, "jump", "block 1 comes to rest at the lower end of its stick interval"),
    (0.44937, "jump", "the release of block 1 and the coming to rest of block 2 coincide"),
]
LAW9_TABLE = [
    (-0.52575, "jump", "the coming to rest of block 1 and the release of block 2 coincide"),
    (-0.38901, "jump", "the coming to rest of block 1 and the release of block 2 coincide"),
    (-0.29626, "jump", "the coming to rest of block 1 and the release of block 2 coincide"),
    (-0.25290, "jump", "the coming to rest of block 1 and the release of block 2 coincide"),
    (-0.24839, "jump", "the release of block 1 and the coming to rest of block 2 coincide"),
    (-0.24316, "corner", "block 1 grazes its stick interval near X_1 = 0.672"),
    (-0.23915, "smooth", "the passing through rest of block 1 and the release of block 2 coincide"),
    (
        -0.23677,
        "smooth",
        "the coming to rest of block 1 and the coming to rest of block 2 coincide",
    ),
    (-0.23484, "smooth", "the force on riding block 2 touches its upper static limit"),
    (0.07360, "smooth", "block 1 comes to rest at the lower end of its stick interval"),
    (0.08811, "smooth", "both blocks reach their static limits together at the onset"),
    (0.08828, "smooth", "the coming to rest of block 1 and the coming to rest of block 2 coincide"),
    (0.28708, "smooth", "block 1 comes to rest at the lower end of its stick interval"),
    (0.37892, "jump", "the release of block 1 and the coming to rest of block 2 coincide"),
    (0.38154, "corner", "block 2 grazes its stick interval near X_2 = 0.561"),
    (0.51044, "smooth", "block 1 comes to rest at the lower end of its stick interval"),
    (0.57089, "edge", "the coming to rest of block 1 and the release of block 2 coincide"),
    (0.66729, "edge", "the coming to rest of block 1 and the release of block 2 coincide"),
]
MODELS = {
    "coulomb": COULOMB,
    "law9": LAW9,
    "weak coupling": COULOMB.replace(alpha=0.7),
    "heavy block 2, fast belt": COULOMB.replace(beta=1.8, V=0.1),
}
BESIDE = 1e-9  # how far from a breakpoint motions are compared ...
SMALL = 1e-5  # ... and how far their tie, touch or tangency may then be from exact

found = functools.lru_cache(ss.breakpoints)


def for_each(pattern):
    """Make a check of one breakpoint a test of all those of a model with such a mechanism."""

    def decorate(check):
        @pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
        def test(model):
            for item in found(model):
                if re.match(pattern, item.mechanism):
                    check(model, item)

        return test

    return decorate


def motions(model, item):
    """The motions that start on both sides of a breakpoint."""
    return [
        ss.simulate(model, d=item.d + side, until="stick", max_events=60)
        for side in (-BESIDE, BESIDE)
    ]


def needed_force(model, motion, t, block):
    """Spring force on a block, which friction must balance for it to ride (eq. 6a)."""
    x, other = motion.x(t)[..., block - 1], motion.x(t)[..., 2 - block]
    return x + model.alpha * (x - other)


def limit(model, block):
    return (1.0, model.beta)[block - 1]


def times(motion, block, *kinds):
    return np.array([e.time for e in motion.events if e.block == block and e.kind in kinds])


def alone(first, second):
    """Times of the first motion's events that the second does not make."""
    return [t for t in first if np.abs(second - t).min(initial=np.inf) > SMALL]


@pytest.mark.parametrize(
    ("model", "table"), [(COULOMB, COULOMB_TABLE), (LAW9, LAW9_TABLE)], ids=["coulomb", "law9"]
)
def test_the_papers_maps_break_where_and_as_listed(model, table):
    breakpoints = found(model)
    listed = [(round(b.d, 5), b.kind, b.mechanism.split(",")[0]) for b in breakpoints]
    assert listed == table
    assert all(b.quality == "located" for b in breakpoints)
    assert not breakpoints.unresolved


def test_branches_of_the_papers_maps():
    assert len(ss.branches(COULOMB)) == len(COULOMB_TABLE) + 1
    assert ss.event_map(COULOMB).gaps.shape == (0, 2)
    branches = ss.branches(LAW9)
    assert len(branches) == 18  # 19 intervals between 18 breakpoints, one of them a gap
    (gap,) = ss.event_map(LAW9).gaps
    edges = [b.d for b in branches.breakpoints if b.kind == "edge"]
    np.testing.assert_allclose(gap, edges, rtol=0, atol=1e-15)


def test_jumps_of_the_coulomb_map_to_1e_14():
    jumps = found(COULOMB).of_kind("jump", "corner", "edge")
    numbers = np.array([(b.d, b.left, b.right) for b in jumps])
    np.testing.assert_allclose(numbers, np.array(COULOMB_JUMPS, float), rtol=0, atol=1e-14)


@for_each(".")
def test_the_block_is_the_one_in_the_words(model, item):
    blocks = {int(number) for number in re.findall(r"block (\d)", item.mechanism)}
    assert blocks == ({1, 2} if item.block is None else {item.block}) or "both" in item.mechanism


@for_each(GRAZES)
def test_a_grazing_block_rests_on_one_side_and_turns_back_on_the_other(model, item):
    block, place, where = re.match(GRAZES, item.mechanism).groups()
    block = int(block)
    beside = motions(model, item)
    rests = [times(motion, block, "stick") for motion in beside]
    # What a jump's sides do later differs anyway; the grazing is the first difference.
    t, touches = min((t, k) for k in (0, 1) for t in alone(rests[k], rests[1 - k]))
    touching, missing = beside[touches], beside[1 - touches]
    assert touching.x(t)[block - 1] == pytest.approx(float(place), rel=5e-3)
    w = missing.v(np.linspace(t - 0.05, t + 0.05, 20_001))[:, block - 1] - model.V
    assert -SMALL < w.max() < 0.0
    spare = limit(model, block) - abs(needed_force(model, touching, t, block))
    assert (spare < 1e-3) == (where == "at an end point")


@for_each(ENDS)
def test_a_block_that_rests_at_an_end_point_sticks_on_one_side_only(model, item):
    block, end, place = re.match(ENDS, item.mechanism).groups()
    block, sign = int(block), {"upper": 1.0, "lower": -1.0}[end]
    first, second = (
        [e for e in motion.events if e.block == block] for motion in motions(model, item)
    )
    pairs = zip(first, second, strict=False)
    here, there = next(pair for pair in pairs if pair[0].kind != pair[1].kind)
    assert "stick" in (here.kind, there.kind)
    assert abs(here.time - there.time) < SMALL
    for motion, event in zip(motions(model, item), (here, there), strict=True):
        assert motion.x(event.time)[block - 1] == pytest.approx(float(place), abs=SMALL)
        force = needed_force(model, motion, event.time, block)
        assert force == pytest.approx(sign * limit(model, block), abs=SMALL)


@for_each(COINCIDE)
def test_events_that_coincide_do_so_on_both_sides(model, item):
    """One block comes to rest or leaves while the other reaches zero w or its limit."""
    what = re.match(COINCIDE, item.mechanism).groups()
    for motion in motions(model, item):
        ties = [
            t
            for block, other in ((1, 2), (2, 1))
            for t in times(motion, block, "stick", "slip backward", "slip forward")
            if reaches_border(model, motion, t, other)
        ]
        assert ties, what


def reaches_border(model, motion, t, block):
    """Whether a block is just coming to rest, or its force just reaches the limit."""
    w = abs(motion.v(t)[block - 1] - model.V)
    spare = abs(limit(model, block) - abs(needed_force(model, motion, t, block)))
    rests = np.abs(times(motion, block, "stick", "slip backward", "slip forward") - t)
    return rests.min(initial=np.inf) < SMALL or (w < SMALL and spare < SMALL)


@for_each(TOUCHES)
def test_a_force_that_touches_the_limit_releases_on_one_side_only(model, item):
    block, end = re.match(TOUCHES, item.mechanism).groups()
    block, sign = int(block), {"upper": 1.0, "lower": -1.0}[end]
    released = [times(motion, block, "slip backward") for motion in motions(model, item)]
    extra = [alone(*released), alone(*released[::-1])]
    assert sorted(map(len, extra)) == [0, 1]
    missing = motions(model, item)[1 if extra[0] else 0]
    (t,) = extra[0] or extra[1]
    around = np.linspace(t - 0.01, t + 0.01, 2001)
    force = sign * needed_force(model, missing, around, block)
    assert -SMALL < force.max() - limit(model, block) < 0.0
    assert 0 < np.argmax(force) < 2000  # it turns back, rather than go on rising


def test_at_the_edge_of_a_gap_the_global_stick_phase_is_just_missed():
    """Two events in one instant are a coincidence, though one motion alone makes the second."""
    left, right = ss.breakpoints(LAW9).of_kind("edge")
    assert left.block is None
    assert right.block is None
    returning, missing = motions(LAW9, left)
    assert returning.events[-1].time == pytest.approx(missing.events[6].time, abs=SMALL)
    assert missing.events[6][1:] == (2, "slip backward")
    assert missing.events[7][1:] == (1, "stick")


def test_breaks_of_a_power_are_those_of_its_iterates():
    f = ss.event_map(COULOMB)
    base = {round(b.d, 12): b for b in ss.breakpoints(f)}
    found = ss.breakpoints(f.power(2))
    numbers = [int(re.search(r"\(iterate (\d)\)$", b.mechanism)[1]) for b in found]
    assert set(numbers) == {1, 2}
    for number, item in zip(numbers, found, strict=True):
        reached = base[round(float(f(item.d)) if number == 2 else item.d, 12)]
        assert item.mechanism == f"{reached.mechanism} (iterate {number})"
        assert item.block == reached.block


@pytest.mark.parametrize(("d", "told"), [(row[0], row[2]) for row in LAW9_TABLE[4:10]])
def test_a_map_with_a_loose_tolerance_is_explained_too(d, told):
    f = ss.event_map(LAW9, rtol=1e-6)
    left, right = d - 2e-5, d + 2e-5
    label = f.evaluate(left).label
    while left < (middle := (left + right) / 2) < right:
        left, right = (middle, right) if f.evaluate(middle).label == label else (left, middle)
    assert f.explain_break(left, right).text.startswith(told)


def test_neighbours_inside_a_branch_have_nothing_to_tell():
    same = mechanism_between(ss.event_map(LAW9), 0.383, np.nextafter(0.383, 1.0))
    assert same == ("the motions on both sides make the same events", None)


def test_a_difference_that_comes_too_late_is_not_denied(monkeypatch):
    cusp = next(b for b in ss.breakpoints(LAW9).of_kind("corner") if b.block == 2)
    monkeypatch.setattr(mechanism, "MAX_EVENTS", 2)
    late = mechanism_between(ss.event_map(LAW9), *cusp.interval)
    assert late == ("the motions on both sides make the same first 400 events", None)


def test_motions_are_followed_no_further_than_itineraries_say(monkeypatch):
    # To the right of the last break but one no motion returns.
    gap = ss.branches(ss.event_map(LAW9)).breakpoints[-2]
    assert gap.kind == "edge"
    followed, slip_from = [], ss.event_map(LAW9).__class__.slip_from

    def counted(f, d, n):
        motion = slip_from(f, d, n)
        followed.append(len(motion.events))
        return motion

    monkeypatch.setattr(ss.event_map(LAW9).__class__, "slip_from", counted)
    assert mechanism_between(ss.event_map(LAW9), *gap.interval).text == gap.mechanism
    assert sum(followed) < 200


def test_maps_of_ones_own_have_no_mechanism():
    f = ss.PiecewiseMap(lambda x: abs(x - 0.25), (0, 1))
    (corner,) = ss.breakpoints(f)
    assert (corner.mechanism, corner.block) == ("", None)
