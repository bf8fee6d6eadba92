"""Curves with known shapes, followed."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.numerics.continuation import (
    ArclengthCurve,
    LeavesRegion,
    StepControl,
    StepTooLong,
    turns_back,
    zero_between,
)

ROUNDING = 1e-14
ONE = np.ones(2)


def circle(y):
    x, q = y
    return np.array([x * x + q * q - 1]), np.array([[2 * x, 2 * q]]), None


def parabola(y):
    x, q = y
    return np.array([q - x * x]), np.array([[-2 * x, 1.0]]), None


def helix(y):
    # Two equations: a circle in (x, z) that the parameter winds along.
    x, z, q = y
    f = [x - math.cos(q), z - math.sin(q)]
    return np.array(f), np.array([[1, 0, math.sin(q)], [0, 1, -math.cos(q)]]), (x, z)


def follow(curve, start, most=10_000):
    """All points of a walk, the start first, and how it ended."""
    points, walk = [start], curve.walk(start)
    while len(points) < most:
        try:
            points.append(next(walk))
        except StopIteration as stop:
            return points, stop.value
    return points, None


def test_goes_round_a_circle():
    curve = ArclengthCurve(circle, ONE)
    start = curve.point(np.array([1.0, 0.0]))
    points, end = follow(curve, start, 400)
    assert end is None
    angles = np.unwrap([math.atan2(p.y[1], p.y[0]) for p in points])
    assert np.abs([np.hypot(*p.y) - 1 for p in points]).max() < ROUNDING
    assert (np.diff(angles) > 0).all()
    assert angles[-1] > 2 * math.pi
    # The tangent is exact, length 1, and never turns round.
    for p in points:
        assert p.tangent == pytest.approx([-p.y[1], p.y[0]], abs=1e-10)


def test_steps_ahead_are_foretold_and_noise_is_recognised():
    rng, evaluations = np.random.default_rng(1), []

    def noisy(y):
        f, jacobian, _ = circle(y)
        evaluations.append(1)
        return f + 1e-12 * rng.standard_normal(1), jacobian, None

    counts = []
    for foretell in (False, True):
        curve = ArclengthCurve(noisy, ONE, control=StepControl(foretell=foretell))
        start = curve.point(np.array([1.0, 0.0]))
        evaluations.clear()
        points, _ = follow(curve, start, 100)
        counts.append(len(evaluations))
        assert np.abs([np.hypot(*p.y) - 1 for p in points]).max() < 1e-11
    assert counts[1] < 0.8 * counts[0]


def test_turning_points_are_found_to_rounding():
    curve = ArclengthCurve(circle, ONE)
    points, _ = follow(curve, curve.point(np.array([1.0, 0.0])), 400)
    pairs = [(a, b) for a, b in pairwise(points) if turns_back(a, b)]
    first, second = (curve.turning_point(a, b) for a, b in pairs[:2])
    assert first.y == pytest.approx([0, 1], abs=ROUNDING)
    assert second.y == pytest.approx([0, -1], abs=ROUNDING)


def test_both_directions_and_landing_on_the_ends_of_the_range():
    low, high = -0.3, 1.7
    curve = ArclengthCurve(helix, np.ones(3), low, high)
    start = curve.point(np.array([0.9, 0.1, 0.2]))
    assert start.parameter == 0.2
    assert start.tangent[-1] > 0
    for ahead, last in ((start, high), (start.reversed(), low)):
        points, end = follow(curve, ahead)
        assert end.reason == "end of range"
        assert points[-1].parameter == last  # exactly
        assert points[-1].y[:2] == pytest.approx([math.cos(last), math.sin(last)], abs=ROUNDING)
        steps = np.diff([p.parameter for p in points])
        assert (np.sign(steps) == np.sign(last - 0.2)).all()
        assert end.last is points[-1]


def test_nothing_is_evaluated_outside_the_range():
    seen = []

    def equations(y):
        seen.append(y[-1])
        return parabola(y)

    curve = ArclengthCurve(equations, ONE, 0.25, 1.0)
    start = curve.point(np.array([0.8, 0.64]))
    for ahead in (start, start.reversed()):
        points, end = follow(curve, ahead)
        assert end.reason == "end of range"
        assert points[-1].y[0] == pytest.approx(math.sqrt(points[-1].y[-1]), abs=ROUNDING)
    assert min(seen) == 0.25
    assert max(seen) == 1.0


def test_through_a_fold_and_out_of_the_range_again():
    curve = ArclengthCurve(parabola, ONE, -1.0, 1.0)
    points, end = follow(curve, curve.point(np.array([1.0, 1.0])).reversed())
    assert end.reason == "end of range"
    assert points[-1].y == pytest.approx([-1.0, 1.0], abs=ROUNDING)
    (fold,) = [curve.turning_point(a, b) for a, b in pairwise(points) if turns_back(a, b)]
    assert fold.y == pytest.approx([0, 0], abs=ROUNDING)


def test_a_start_at_a_fold():
    curve = ArclengthCurve(parabola, ONE, -1.0, 1.0)
    start = curve.point(np.array([1e-3, 0.0]))
    assert np.abs(parabola(start.y)[0]) < ROUNDING
    ends = {follow(curve, s)[0][-1].y[0] for s in (start, start.reversed())}
    assert sorted(ends) == pytest.approx([-1, 1])


def test_a_start_at_the_end_of_the_range_that_leads_out():
    curve = ArclengthCurve(parabola, ONE, 0.0, 1.0)
    points, end = follow(curve, curve.point(np.array([1.0, 1.0])))
    assert len(points) == 1
    assert end.reason == "end of range"


def test_leaving_the_region_ends_the_walk_with_the_cause():
    def equations(y):
        if y[0] > 0.5:
            raise LeavesRegion(("x", y[0]))
        return parabola(y)

    curve = ArclengthCurve(equations, ONE, 0.0, 1.0)
    points, end = follow(curve, curve.point(np.array([0.1, 0.01])))
    assert end.reason == "region"
    assert end.cause[0] == "x"
    assert end.cause[1] > 0.5
    assert 0.4 < points[-1].y[0] <= 0.5
    assert end.last.step < points[-1].step


def test_a_region_that_only_newton_oversteps_is_no_end():
    # The first guess beside the curve leaves, the curve itself does not.
    def equations(y):
        if abs(y[1] - y[0] ** 2) > 2e-4:
            raise LeavesRegion
        return parabola(y)

    curve = ArclengthCurve(equations, ONE, 0.0, 1.0)
    points, end = follow(curve, curve.point(np.array([0.1, 0.01])))
    while end.reason == "region":
        more, end = follow(curve, end.last)
        points += more[1:]
    assert points[-1].y == pytest.approx([1, 1], abs=ROUNDING)


def test_a_corner_ends_at_the_smallest_step():
    def equations(y):
        x, q = y
        return np.array([abs(x) - q]), np.array([[np.sign(x), -1.0]]), None

    control = StepControl(smallest=1e-6)
    curve = ArclengthCurve(equations, ONE, -1, 1, control)
    points, end = follow(curve, curve.point(np.array([0.7, 0.7])).reversed())
    assert end.reason == "step limit"
    assert abs(points[-1].y[0]) < 1e-5


def test_steps_grow_where_the_curve_is_straight_and_shrink_where_it_bends():
    def equations(y):
        x, q = y
        return np.array([math.tanh(20 * q) - x]), np.array([[-1, 20 / math.cosh(20 * q) ** 2]]), 0

    control = StepControl(largest=0.2)
    curve = ArclengthCurve(equations, ONE, -2, 2, control)
    points, _ = follow(curve, curve.point(np.array([-1.0, -2.0])))
    y = np.array([p.y for p in points])
    steps = np.hypot(*np.diff(y, axis=0).T)
    assert steps.max() == pytest.approx(0.2, rel=0.01)
    assert steps.min() < 0.05
    turns = np.diff(np.unwrap([math.atan2(p.tangent[1], p.tangent[0]) for p in points]))
    assert np.abs(turns).max() <= control.angle


def test_the_caller_may_refuse_a_step():
    def accept(a, b):
        if abs(b.y[0] - a.y[0]) > 0.01:
            raise StepTooLong

    curve = ArclengthCurve(parabola, ONE, 0.0, 1.0, accept=accept)
    points, _ = follow(curve, curve.point(np.array([0.1, 0.01])))
    assert np.abs(np.diff([p.y[0] for p in points])).max() <= 0.01
    assert points[-1].parameter == 1.0


def test_the_scale_decides_what_is_far():
    # The same curve in other units: the same steps.
    units = np.array([1e-6, 1e3])

    def equations(y):
        f, jacobian, note = parabola(y / units)
        return f, jacobian / units, note

    plain = ArclengthCurve(parabola, ONE, 0.0, 1.0)
    scaled = ArclengthCurve(equations, units, 0.0, 1e3)
    there = [p.y for p in follow(plain, plain.point(np.array([0.1, 0.01])))[0]]
    here = [p.y / units for p in follow(scaled, scaled.point(np.array([0.1, 0.01]) * units))[0]]
    assert np.array(here) == pytest.approx(np.array(there), abs=1e-12)


def test_notes_stay_with_their_points():
    curve = ArclengthCurve(helix, np.ones(3), 0, 1)
    for p in follow(curve, curve.point(np.array([1.0, 0.0, 0.0])))[0]:
        assert p.note == pytest.approx(tuple(p.y[:2]), abs=1e-7)


def test_no_solution_is_no_point():
    def equations(y):
        f, jacobian, note = circle(y)
        return f + 2, jacobian, note

    with pytest.raises(StepTooLong):
        ArclengthCurve(equations, ONE).point(np.array([0.3, 0.2]))


@given(root=st.floats(-0.9, 0.9), power=st.sampled_from([1, 3, 5]), steep=st.floats(0.1, 10))
def test_zeros(root, power, steep):
    seen = []

    def g(x):
        seen.append(x)
        return steep * (x - root) ** power * math.exp(x)

    found = zero_between(g, -1, 1, g(-1), g(1))
    if power == 1:
        assert found == pytest.approx(root, abs=2e-15)
        assert len(seen) < 16
    else:
        assert abs(g(found)) <= 1e-40


def test_zeros_at_the_ends():
    assert zero_between(lambda x: x, 0.0, 1.0, 0.0, 1.0) == 0.0
    assert zero_between(lambda x: x - 1, 0.0, 1.0, -1.0, 0.0) == 1.0


def test_steps_that_round_to_nothing_are_walked():
    """The cubic through two points that coincide divided by their distance."""
    steps = StepControl(first=1e-20, smallest=0.0, largest=1e-20, foretell=True)
    curve = ArclengthCurve(parabola, ONE, control=steps)
    points, end = follow(curve, curve.point(np.array([1.0, 1.0])), 5)
    assert end is None
    assert all(np.allclose(point.y, 1.0, rtol=0, atol=1e-15) for point in points)
