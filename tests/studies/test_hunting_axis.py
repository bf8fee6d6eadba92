"""The hunting axis: closed forms against the return map and a cycle found in time."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip import studies
from stickslip.studies.hunting_axis.axis import (
    DERIVATIVE,
    DROP,
    MODEL,
    PROPORTIONAL,
    axis_map,
    bristles,
    half_map,
    hunting,
)


def test_the_map_is_the_closed_form() -> None:
    for gain in (1.0, 4.0, 8.0):
        f = axis_map(gain)
        for x in (0.003, 0.02, 0.055):
            past = half_map(gain, x)  # the slip ends beyond the target; its mirror image follows
            assert past < 0.0
            expected = -half_map(gain, -past)
            assert f(x) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_the_only_orbit_has_the_distance_period_and_multiplier_of_the_formula(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gain, kinetic = rng.uniform(0.5, 10.0), rng.uniform(0.7, 0.99)
    f, exact = axis_map(gain, kinetic), hunting(gain, kinetic)
    (orbit,) = ss.periodic_orbits(f, max_period=2)
    assert orbit.points[0] == pytest.approx(exact.distance, rel=1e-12)
    assert orbit.multiplier == pytest.approx(exact.multiplier, rel=1e-9, abs=1e-12)
    assert f.evaluate(orbit.points[0]).duration == pytest.approx(exact.period, rel=1e-12)


def test_the_distance_has_a_limit_as_the_integral_gain_goes_to_zero() -> None:
    half = 0.5 * DERIVATIVE
    swing = np.exp(-half * np.pi / np.sqrt(PROPORTIONAL - half**2))
    limit = DROP * (1.0 + swing) / (2.0 * PROPORTIONAL)
    errors = [hunting(gain).distance / limit - 1.0 for gain in (1e-2, 1e-3)]
    assert errors[0] == pytest.approx(10.0 * errors[1], rel=1e-2)
    assert abs(errors[1]) < 1e-4


def test_a_motion_comes_to_the_cycle() -> None:
    cycle = ss.find_cycle(MODEL, [0.0, 0.05, 0.0], [])
    exact = hunting(4.0)
    assert cycle.period == pytest.approx(exact.period, rel=1e-12)
    assert abs(cycle.x[1]) == pytest.approx(exact.distance, rel=1e-12)
    assert [event.kind for event in cycle.events].count("stick") == 2


def test_without_an_excess_distances_shrink_by_one_factor() -> None:
    x = np.array([0.004, 0.01, 0.05])
    ratio = half_map(8.0, 1.0, 0.0)
    np.testing.assert_allclose(axis_map(8.0, mu=1.0)(x) / x, ratio**2, rtol=1e-11)
    assert not ss.periodic_orbits(axis_map(8.0, mu=1.0), max_period=1)


def test_soft_bristles_end_the_hunting() -> None:
    assert bristles(1e2).amplitude < 1e-4
    assert bristles(1e5).amplitude == pytest.approx(hunting(4.0).distance, rel=0.02)


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="hunting_axis")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 6
