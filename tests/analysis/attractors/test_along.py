"""Attractors handed on from map to map."""

import numpy as np
import pytest
from tests.analysis.known_maps import doubling, logistic, square_root, tent

from stickslip.analysis.attractors.along import Motion, Settler
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.side_by_side import side_by_side

CORNER = np.array([0.5])
NOTHING = np.empty(0)
SPREAD = np.linspace(0.05, 0.95, 8)


def at(settler, f, cycles, critical, spread):
    return side_by_side([settler.at(f, cycles, critical, spread)])[0]


def settle(f, *, cycles=(), critical=CORNER, spread=NOTHING):
    return at(Settler(64), f, list(cycles), critical, spread)


@pytest.mark.parametrize(("r", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.83, 3), (3.556, 8)])
def test_the_turning_points_orbit_finds_the_cycle(r, period):
    (motion,) = settle(logistic(r))
    assert motion.kind == "periodic"
    assert motion.period == period
    assert motion.lyapunov < 0
    np.testing.assert_allclose(
        logistic(r)(motion.points), np.roll(motion.points, -1), rtol=0, atol=1e-13
    )


@pytest.mark.parametrize("slope", [1.3, 1.5, 1.9])
def test_chaos_has_the_exponent_of_its_slope(slope):
    (motion,) = settle(tent(slope))
    assert motion.kind == "chaotic"
    assert motion.lyapunov == pytest.approx(np.log(slope))
    low, high = slope * (1 - slope / 2), slope / 2
    assert motion.points.min() >= low - 1e-12
    assert motion.points.max() <= high + 1e-12


def test_given_cycles_are_not_found_again():
    low, high = 0.5130445095326298, 0.7994554904673701  # of the logistic map at r = 3.2
    assert settle(logistic(3.2), cycles=[np.array([low, high])]) == []


def test_a_cycle_is_handed_on_by_newtons_method():
    """Without any critical point to start from."""
    settler = Settler(64)
    at(settler, logistic(3.555), [], CORNER, NOTHING)
    for r in (3.556, 3.557, 3.558):
        (motion,) = at(settler, logistic(r), [], NOTHING, NOTHING)
        assert motion.period == 8
        f = logistic(r)
        np.testing.assert_allclose(f(motion.points), np.roll(motion.points, -1), rtol=0, atol=1e-13)


def test_a_cycle_that_has_flipped_is_followed_by_the_doubled_one():
    settler = Settler(64)
    at(settler, logistic(3.44), [], CORNER, NOTHING)
    (motion,) = at(settler, logistic(3.46), [], CORNER, NOTHING)
    assert motion.period == 4


def test_a_map_without_turning_points_needs_spread_starts():
    assert settle(doubling(1.8), critical=NOTHING) == []
    (motion,) = settle(doubling(1.8), critical=NOTHING, spread=SPREAD)
    assert motion.kind == "chaotic"
    assert motion.lyapunov == pytest.approx(np.log(1.8))


def test_a_chaotic_motion_whose_critical_orbit_leaves_is_dropped():
    """Just beyond slope 2 the corner's image is outside, but few orbits leave in 100 steps."""
    over = PiecewiseMap(
        lambda x, slope: slope * np.minimum(x, 1 - x),
        (0.0, 1.0),
        parameters={"slope": 2.0},
        breakpoints=[0.5],
    )
    settler = Settler(64)
    (kept,) = at(settler, over.replace(slope=1.9999), [], CORNER, NOTHING)
    assert kept.kind == "chaotic"
    assert at(settler, over.replace(slope=2.0001), [], CORNER, NOTHING) == []


def test_orbits_beside_a_neutral_cycle_are_not_called_chaotic():
    """Nordmark's map: the 2-cycle flips at mu = 0.025; orbits beside it neither come nor go."""
    low, high = -0.075, 0.01
    motions = settle(square_root(mu=0.025), cycles=[np.array([low, high])], spread=SPREAD / 100)
    kinds = [(motion.kind, motion.period) for motion in motions]
    assert ("periodic", 3) in kinds
    assert set(kinds) <= {("periodic", 3), ("undecided", 0)}


def test_a_slow_approach_is_no_chaos():
    """At its flip the fixed point of the logistic map attracts like 1 / sqrt(n)."""
    assert settle(logistic(3.0), cycles=[np.array([2 / 3])], spread=SPREAD) == []


def test_holes_between_bands_do_not_hold():
    bands = np.concatenate([np.linspace(0.1, 0.2, 40), np.linspace(0.7, 0.8, 40)])
    motion = Motion("chaotic", bands, 0.3)
    held = motion.holds(np.array([0.05, 0.15, 0.45, 0.75, 0.9]))
    assert held.tolist() == [False, True, False, True, False]
