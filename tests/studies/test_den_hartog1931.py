"""Closed forms of a shaken block against motions followed event by event."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stickslip import studies
from stickslip.studies.den_hartog1931.claims import largest, steady, stops
from stickslip.studies.den_hartog1931.closed_forms import (
    amplitude,
    one_harmonic,
    one_stop_amplitude,
    stop_boundary,
)

FREQUENCIES = [0.505, 0.58, 0.77, 1.3, 1.9]


@pytest.mark.parametrize("frequency", FREQUENCIES)
@pytest.mark.parametrize("excess", [1.03, 1.6])
def test_the_amplitude_above_the_boundary_is_the_closed_form(
    frequency: float, excess: float
) -> None:
    forcing = excess * stop_boundary(frequency)
    cycle, size = steady(frequency, forcing), amplitude(frequency, forcing)
    assert stops(cycle) == 0
    # What rounds the return is off by moves the cycle 250 times as far where a multiplier is 0.996.
    rounding = 16.0 * np.finfo(float).eps / (1.0 - np.abs(cycle.multipliers).max())
    assert largest(cycle) == pytest.approx(size, rel=rounding)


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_below_the_boundary_it_stops(frequency: float) -> None:
    forcing = 0.98 * stop_boundary(frequency)
    assert stops(steady(frequency, forcing)) == 2
    assert math.isnan(amplitude(frequency, forcing))


@pytest.mark.parametrize(("frequency", "forcing"), [(0.5, 1.8), (0.4, 1.5)])
def test_one_stop_in_each_half_period(frequency: float, forcing: float) -> None:
    cycle = steady(frequency, forcing)
    assert stops(cycle) == 2
    assert largest(cycle) == pytest.approx(one_stop_amplitude(frequency, forcing), abs=1e-12)


@pytest.mark.parametrize(("frequency", "forcing"), [(0.7, 2.0), (0.5, 1.8), (1.5, 1.6)])
def test_one_harmonic_balances_force_and_friction(frequency: float, forcing: float) -> None:
    a = one_harmonic(frequency, forcing)
    t = (np.arange(4096) + 0.5) * 2.0 * np.pi / 4096  # of a cos(t): friction is sign(sin t)
    friction = 2.0 * np.mean(np.sign(np.sin(t)) * np.exp(1j * t))
    assert abs((1.0 - frequency**2) * a + friction) == pytest.approx(forcing, rel=1e-6)
    assert math.isnan(one_harmonic(frequency, 1.27))


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="den_hartog1931")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 4
