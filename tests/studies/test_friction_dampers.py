"""Friction dampers: closed form, exact cycles and harmonic balance agree where they should."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stickslip import studies
from stickslip.studies.friction_dampers.claims import strays
from stickslip.studies.friction_dampers.dampers import (
    BLADE,
    LEAST,
    MODEL,
    TIP,
    describing,
    jenkins,
    many_harmonics,
    one_harmonic,
    peak,
    peak_of_one_harmonic,
    response,
    symmetric,
)


@pytest.mark.parametrize("seed", range(4))
def test_cycles_found_in_time_are_the_closed_form(seed: int) -> None:
    rng = np.random.default_rng(seed)
    load = rng.uniform(1.0, 3.0)
    frequency = math.sqrt(2.0 + rng.uniform(-0.9, 0.9) / load)  # the contact has to slip
    (exact,) = symmetric(load, frequency)
    (found,), (cycle,) = response(MODEL, load, (frequency,))
    lost = cycle.trajectory.energy([cycle.period]).dissipation[0]
    assert found == pytest.approx(exact.amplitude, rel=1e-11)
    assert lost == pytest.approx(exact.lost, rel=1e-10)
    assert lost == pytest.approx(4.0 * load * (exact.amplitude - load), rel=1e-10)
    assert strays(exact) < 1e-12


def test_both_cycles_with_less_friction_in_motion_return() -> None:
    for cycle in symmetric(2.0, 1.12, 0.5):
        assert strays(cycle) < 1e-12
    assert len(symmetric(2.0, 1.12, 0.5)) == 2
    assert not symmetric(2.0, 1.05, 0.5)


def test_the_complex_stiffness_is_the_first_harmonic_of_the_force() -> None:
    theta = 2.0 * np.pi * np.arange(20_000) / 20_000
    for amplitude in (0.7, 1.3, 4.0):
        force = jenkins(amplitude * np.cos(theta), 0.9)
        found = 2.0 * np.mean(force * np.exp(-1j * theta)) / amplitude
        assert found == pytest.approx(describing(amplitude, 0.9), rel=1e-6)


def test_the_peak_by_one_harmonic_is_near_the_exact_one() -> None:
    assert peak_of_one_harmonic(0.5 * math.pi) == pytest.approx(LEAST, rel=1e-14)
    assert peak(1.5)[1] == pytest.approx(peak_of_one_harmonic(1.5), rel=2e-3)
    highest = max(one_harmonic(MODEL, 1.5, w) for w in np.linspace(1.15, 1.25, 400).tolist())
    assert highest == pytest.approx(peak_of_one_harmonic(1.5), rel=1e-4)


def test_many_harmonics_come_to_the_exact_cycle_of_the_blade_and_one_does_not() -> None:
    frequency = 0.46
    (exact,), _ = response(BLADE, 2.0, (frequency,), TIP)
    assert many_harmonics(BLADE, 2.0, frequency, TIP) == pytest.approx(exact, rel=1e-3)
    assert one_harmonic(BLADE, 2.0, frequency, TIP) > 1.3 * exact


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="friction_dampers")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 5
