"""The state once per period of the forcing, over its frequency."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.mechanics.cycle.stroboscopic import stroboscopic_map
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.chain import Oscillator
from stickslip.mechanics.model.harmonic import Harmonic

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.stroboscopic import StroboscopicMap

    Floats = NDArray[np.float64]

LAW: Final = PoppStelter(gamma=1.42, delta=0.4, eta=0.01)
SPEED: Final = 1.0
AMPLITUDE: Final = 0.5
RANGE: Final = (0.3, 1.2)
VALUES: Final = 226
TRANSIENT: Final = 100
KEPT: Final = 60
PERIODS: Final = 100


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
    parts = [float(f.lyapunov_exponents(state, periods, transient=1)[0]) for state in (here, there)]
    return sum(parts) / 2.0, abs(parts[0] - parts[1]) / 2.0


@cache
def sweep() -> Sweep:
    """Follow one motion as the frequency grows."""
    frequency = np.linspace(*RANGE, VALUES)
    f = shaken(RANGE[0])
    states = f.diagram("forcing.frequency", frequency, [0.0, 0.0], transient=TRANSIENT, n=KEPT)
    exponents = [
        shaken(value).lyapunov_exponents(row[-1], PERIODS, transient=1)[0]
        for value, row in zip(frequency.tolist(), states, strict=True)
    ]
    return Sweep(frequency, states[..., 0], np.array(exponents))
