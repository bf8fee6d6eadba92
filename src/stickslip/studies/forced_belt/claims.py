"""Kinds of motion of the shaken block: its state once per period of the forcing, checked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from stickslip.analysis.exponents.spectrum import lyapunov_spectrum
from stickslip.mechanics.cycle.stroboscopic import StroboscopicMap, stroboscopic_map
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.blocks import Oscillator
from stickslip.mechanics.model.contact import Harmonic
from stickslip.numerics.arrays import Floats
from stickslip.studies.claim import Claim, Finding, Value, claim

LAW: Final = PoppStelter(gamma=1.42, delta=0.4, eta=0.01)
SPEED: Final = 1.0
AMPLITUDE: Final = 0.5
RANGE: Final = (0.3, 1.2)
VALUES: Final = 226
TRANSIENT: Final = 100
KEPT: Final = 60
PERIODS: Final = 100
NOT_READ: Final = "source not read; parameters chosen here"
LOCKED: Final = 1.0  # frequencies
NEUTRAL: Final = 0.4
CHAOTIC: Final = 0.76


@dataclass(frozen=True)
class Sweep:
    """Displacements (values, n) once per period, and the largest exponents (values,)."""

    frequency: Floats
    x: Floats
    exponent: Floats


def shaken(frequency: float) -> StroboscopicMap:
    """Return the stroboscopic map at a frequency of the forcing."""
    forcing = Harmonic(amplitude=AMPLITUDE, frequency=frequency)
    return stroboscopic_map(Oscillator(V=SPEED, friction=LAW, forcing=forcing))


def exponent(frequency: float, periods: int = 1500) -> tuple[float, float]:
    """Largest Lyapunov exponent and its error: half the difference of two stretches."""
    f = shaken(frequency)
    here = f.iterate([0.0, 0.0], TRANSIENT)[-1]
    there = f.iterate(here, periods)[-1]
    parts = [largest(f, state, periods) for state in (here, there)]
    return sum(parts) / 2.0, abs(parts[0] - parts[1]) / 2.0


def largest(f: StroboscopicMap, state: Floats, periods: int) -> float:
    """Return the largest exponent per unit of time of the motion from a state."""
    return float(lyapunov_spectrum(f, state, periods, transient=1).per_time[0])


@cache
def sweep() -> Sweep:
    """Follow one motion as the frequency grows."""
    frequency = np.linspace(*RANGE, VALUES)
    f = shaken(RANGE[0])
    states = f.diagram("forcing.frequency", frequency, [0.0, 0.0], transient=TRANSIENT, n=KEPT)
    exponents = [
        largest(shaken(value), row[-1], PERIODS)
        for value, row in zip(frequency.tolist(), states, strict=True)
    ]
    return Sweep(frequency, states[..., 0], np.array(exponents))


def _locked() -> Iterator[Claim]:
    f = shaken(LOCKED)
    cycle = f.periodic_point([0.0, 0.0])
    times = cycle.period / f.period
    size = float(np.abs(cycle.multipliers).max())
    value, error = exponent(NEUTRAL)
    yield claim(
        "forced.locked",
        NOT_READ,
        "Shaken stick-slip can lock to the forcing, or drift against it",
        Finding(
            f"at frequency {LOCKED:g} it has the period of the forcing and attracts",
            f"{times:.0f} period, largest multiplier {size:.4f}",
            round(times) == 1 and cycle.stable,
        ),
        Finding(
            f"at frequency {NEUTRAL:g} it neither locks nor is chaotic",
            f"exponent {value:.1e} with an error of {error:.0e}",
            abs(value) < 2e-3,
        ),
        values=(Value("largest multiplier, locked", size, 1e-10, 1, "shooting over a period"),),
        mechanism="sticking forgets one direction: what is left is a map of the circle of phases",
    )


def _chaotic() -> Iterator[Claim]:
    value, error = exponent(CHAOTIC)
    yield claim(
        "forced.chaotic",
        NOT_READ,
        "Shaken stick-slip can be chaotic",
        Finding(
            f"the largest exponent is positive at frequency {CHAOTIC:g}",
            f"{value:.4f} with an error of {error:.0e}",
            value > 5.0 * error and value > 0.01,
        ),
        values=(Value("largest exponent, chaotic", value, error, 2, "3000 periods"),),
        note="The other exponent is minus infinity: a stick forgets where the block was.",
    )


CLAIMS: Final = {1: _locked, 2: _chaotic}
