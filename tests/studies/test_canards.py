"""The shaken block: closed forms against the engine, both sides of a touch, smooth friction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip import simulate, studies
from stickslip.studies.canards.block import (
    BEFORE,
    FREQUENCY,
    GIVEN,
    LEAVES,
    MODEL,
    MU,
    PERIOD,
    STATIC,
    canard,
    canard_with,
    cycles,
    from_rest,
    onset,
    regular,
    slip_of,
    smooth_canard,
    smooth_law,
    touching,
    unseen,
)
from stickslip.studies.canards.claims import off


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("family", [regular, canard])
def test_a_slip_ends_in_its_mirror_image_by_another_integrator(family, seed: int) -> None:
    low, high = (touching().slip, 4.3) if family is regular else (0.3, touching().slip)
    motion = family(np.random.default_rng(seed).uniform(low, high))

    def rates(t: float, z: np.ndarray) -> list[float]:
        return [z[1], motion.force * math.cos(motion.phase + FREQUENCY * t) - z[0] - MU]

    times = np.linspace(0.0, motion.slip, 201)
    run = solve_ivp(
        rates, (0.0, motion.slip), [-motion.x, 0.0], "DOP853", times, rtol=1e-12, atol=1e-13
    )
    np.testing.assert_allclose(run.y[:, -1], [motion.x, 0.0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(motion.at(times), run.y[0], rtol=0, atol=1e-11)
    assert run.y[1, 1:-1].min() > 0.0
    held = motion.needed if family is regular else motion.force + motion.x
    assert held == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("slip", [2.72, 3.0, 3.5, 4.1])
def test_regular_motions_are_fixed_points_of_the_map_of_releases(slip: float) -> None:
    assert off(regular(slip)) < 1e-12


def test_the_onset_is_a_fold_of_what_is_followed() -> None:
    (fold,) = (event for event in cycles().bifurcations if event.kind == "fold")
    assert fold.value == pytest.approx(MU * STATIC / math.cos(math.pi * FREQUENCY / 2), rel=1e-12)
    assert onset().force == pytest.approx(fold.value, rel=1e-14)


@pytest.mark.parametrize("x", [-1.39, -0.7, -0.26, -0.24, 0.24, 0.26, 0.7, 1.39])
def test_what_holds_a_block_in_the_middle_keeps_one_in_motion_from_a_quarter_on(x: float) -> None:
    block = MODEL.replace(**{"forcing.phase": 0.5 * math.pi})
    run = simulate(block, [x], [0.0], t_end=40 * PERIOD)
    last = np.abs(run.x(np.linspace(39 * PERIOD, 40 * PERIOD, 1001))).max()
    motion = regular(3.893079629946)
    assert motion.force == pytest.approx(GIVEN, rel=1e-9)
    expected = motion.x if abs(x) > 1.0 - GIVEN else abs(x)
    assert last == pytest.approx(expected, rel=1e-4)
    assert motion.x == pytest.approx(1.28, rel=0, abs=0.005)


@pytest.mark.parametrize("phase", [0.05, 0.4, 1.0])
def test_canards_slip_at_less_than_the_limit_and_land_where_they_should(phase: float) -> None:
    motion = canard_with(phase)
    assert motion.phase == pytest.approx(phase, rel=1e-12)
    assert MU < motion.needed < 1.0
    time, x = slip_of(motion)
    assert time == pytest.approx(motion.slip, rel=1e-12)
    assert x == pytest.approx(motion.x, rel=1e-12)


def test_a_touch_slips_and_a_rounding_less_rests() -> None:
    assert not from_rest(-1e-14, 10.0).events
    for excess in (0.0, 1e-14, 1e-8):
        first = from_rest(excess).events[0]
        expected = -math.acos((GIVEN - excess) / GIVEN) + math.pi / 2
        assert first.time * FREQUENCY == pytest.approx(expected, rel=0, abs=1e-9)
    assert from_rest(-1e-6).derivative("x0").margin == pytest.approx(1e-6, rel=1e-6)
    assert 0.0 < unseen(0.01) <= GIVEN * (FREQUENCY * 0.01) ** 2 / 8


def _smooth_run(found, ends: tuple[float, float], start: np.ndarray) -> np.ndarray:
    def rates(at: float, z: np.ndarray) -> list[float]:
        pull = found.force * math.cos(at) - z[0] - float(smooth_law(z[1] / found.width))
        return [z[1] / FREQUENCY, pull / FREQUENCY]

    return solve_ivp(rates, ends, start, "LSODA", rtol=1e-9, atol=1e-12).y[:, -1]


def test_a_smooth_canard_waits_where_friction_falls_with_speed() -> None:
    # Backward in time the wait attracts, as far as the crest of the smooth law.
    found = smooth_canard(0.5, 0.01)
    x, v = _smooth_run(found, (0.5, 0.2), np.array([-found.x, LEAVES * found.width]))
    assert v > found.width
    assert smooth_law(v / found.width) == pytest.approx(found.force * math.cos(0.2) - x, rel=0.02)
    assert found.x == pytest.approx(1.0 - found.force, rel=0, abs=2.0 * found.width)


def test_a_smooth_motion_that_does_not_wait_repeats() -> None:
    found = smooth_canard(-0.1, 0.01)
    end = _smooth_run(found, (BEFORE, BEFORE + math.pi), found.start)
    np.testing.assert_allclose(end, -found.start, rtol=0, atol=1e-3)


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="canards")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 7
