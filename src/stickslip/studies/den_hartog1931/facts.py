"""Steady motions computed event by event, once for all figures and claims."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

from stickslip.mechanics.cycle.continuation import follow_cycle
from stickslip.mechanics.cycle.stroboscopic import stroboscopic_map
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.model.chain import Oscillator
from stickslip.mechanics.model.harmonic import Harmonic
from stickslip.studies.den_hartog1931.closed_forms import stop_boundary

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.cycle import Cycle

RATIOS: Final = (0.2, 0.4, 0.6)  # of friction over forcing
FREQUENCIES: Final = (0.55, 0.7, 0.85, 1.2, 1.5, 2.0)
ON_BOUNDARY: Final = (0.45, 0.7, 1.5, 2.0)


@dataclass(frozen=True)
class Boundary:
    """Smallest forcing without stops at a frequency: where the branch of motions changes."""

    frequency: float
    forcing: float
    error: float
    kind: str


@cache
def steady(frequency: float, forcing: float) -> Cycle:
    """Steady motion that a block takes up from rest."""
    shaken = Harmonic(amplitude=forcing, frequency=frequency)
    model = Oscillator(V=0.0, friction=Coulomb(mu=1.0), forcing=shaken)
    return stroboscopic_map(model).periodic_point([0.5, 0.0])


def stops(cycle: Cycle) -> int:
    """Count the stops in one period."""
    return sum(event.kind == "stick" for event in cycle.events)


def largest(cycle: Cycle) -> float:
    """Largest displacement: the block is there as it turns or stops."""
    return max(abs(float(cycle.trajectory.x(event.time)[0])) for event in cycle.events)


@cache
def boundaries() -> tuple[Boundary, ...]:
    """Follow motions without stops down in the forcing until they begin to stop."""
    found = []
    for frequency in ON_BOUNDARY:
        # The closed form says where to look, not what is found there.
        guess = stop_boundary(frequency)
        cycle = steady(frequency, 1.1 * guess)
        branch = follow_cycle(cycle, "forcing.amplitude", (0.97 * guess, 1.15 * guess))
        change = max(branch.bifurcations, key=lambda item: item.value)
        found.append(Boundary(frequency, change.value, change.error, change.kind))
    return tuple(found)
