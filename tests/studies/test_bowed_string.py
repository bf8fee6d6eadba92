"""The bowed string: Helmholtz motion, limits of the bow force, exact cycles and their pitch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

import stickslip as ss
from stickslip import studies
from stickslip.studies.bowed_string.string import (
    KINDS,
    MODEL,
    ORDERS,
    PERIOD,
    PITCH,
    PLACE,
    RATE,
    RESISTANCE,
    Sound,
    bowed,
    cents,
    cycle,
    heard,
    helmholtz,
    largest,
    smallest,
    sounds,
    stepped,
    write_sounds,
)


def test_the_series_of_helmholtz_motion_is_that_of_a_pulse() -> None:
    place, n = 0.3, np.arange(1, 20_001)
    for t, speed in ((0.0, 1.0 - 1.0 / place), (0.2, 1.0 - 1.0 / place), (0.4, 1.0), (1.0, 1.0)):
        modes = -2.0 / (np.pi * n * place) * np.cos(n * np.pi * t)
        assert modes @ np.sin(n * np.pi * place) == pytest.approx(speed, rel=1e-3)


def test_the_minimum_is_the_sum_of_what_damping_needs() -> None:
    place, n = 0.07, np.arange(1, 200_001)
    needed = 2.0 / (np.pi**2 * RESISTANCE * place**2 * n**2) * (1.0 - (-1.0) ** n)
    kinetic = MODEL.parameters["mu_1"]
    assert needed.sum() / (1.0 - kinetic) == pytest.approx(smallest(place), rel=1e-5)
    lowest = MODEL.damping[0, 0] / MODEL.mass[0]
    assert lowest == pytest.approx(2.0 / RESISTANCE * (1.0 + 0.01), rel=1e-12)


def test_the_start_sticks_to_the_bow() -> None:
    _, v = helmholtz(PLACE, 15.0)
    assert v @ np.sin(ORDERS * np.pi * PLACE) == pytest.approx(1.0, rel=1e-12)
    assert bowed(PLACE, 15.0) == MODEL


@pytest.mark.parametrize("place", [0.11, 0.2])
def test_helmholtz_motion_lives_below_the_maximum_only(place: float) -> None:
    forces = [0.5 * smallest(place), 0.6 * largest(place), 1.3 * largest(place)]
    found = sounds(place, forces)
    assert [each.kind == KINDS[0] for each in found] == [False, True, False]
    assert (found[2].slips, found[2].share) == heard(bowed(place, forces[2]), np.nan)


def test_kinds_of_motion() -> None:
    kinds = [Sound(0.1, 1.0, *pair).kind for pair in ((1, 0.12), (1, 0.5), (2, 0.1), (0, 0.0))]
    assert tuple(kinds) == KINDS


def test_the_exact_cycle_repeats_and_fixed_steps_come_to_its_period() -> None:
    found = cycle(0.5)
    force = 0.5 * largest(PLACE)
    run = ss.simulate(bowed(PLACE, force), found.x, found.v, t_end=found.period)
    np.testing.assert_allclose(run.final_state.x, found.x, rtol=1e-8, atol=1e-10)
    off = [abs(cents(float(stepped(0.5, n).mean())) - cents(found.period)) for n in (225, 1800)]
    assert off[1] < 0.1 < off[0]
    assert np.ptp(stepped(0.6, 225)) == pytest.approx(PERIOD / 225, rel=1e-9)


def test_sounds_are_written_at_their_pitch(tmp_path: Path) -> None:
    first = write_sounds(tmp_path, 0.15)[0]
    rate, samples = wavfile.read(first)
    assert (rate, samples.dtype) == (RATE, np.int16)
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(len(samples)), 1 << 16))
    assert np.argmax(spectrum) * rate / (1 << 16) == pytest.approx(PITCH, rel=0.02)


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="bowed_string")
    verdicts = [claim.verdict for claim in report.claims]
    assert verdicts == ["holds", "holds with a correction", "holds", "holds"]
