"""The closed forms of forced motion against dry friction, checked by motions event by event."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.mechanics.cycle.continuation import follow_cycle
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.stroboscopic import stroboscopic_map
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.model.blocks import Oscillator
from stickslip.mechanics.model.contact import Harmonic
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.den_hartog1931 import closed_forms

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import CurveEvent

RATIOS: Final = (0.2, 0.4, 0.6)  # of friction over forcing
FREQUENCIES: Final = (0.55, 0.7, 0.85, 1.2, 1.5, 2.0)
ON_BOUNDARY: Final = (0.45, 0.7, 1.5, 2.0)
NOT_READ: Final = "1931: source not read; 1930: first page; formulas derived anew"
CLOSE: Final = 1e-12
NO_STOP: Final = (0.7, 2.0)  # frequency and forcing
ONE_STOP: Final = (0.5, 1.8)
TWO_STOPS: Final = (0.2, 3.0)
ABOVE: Final = (1.5, 5 / 3)


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
def boundaries() -> dict[float, CurveEvent]:
    """Follow motions without stops down in the forcing until they begin to stop, by frequency."""
    found = {}
    for frequency in ON_BOUNDARY:
        # The closed form says where to look, not what is found there.
        guess = closed_forms.stop_boundary(frequency)
        cycle = steady(frequency, 1.1 * guess)
        branch = follow_cycle(cycle, "forcing.amplitude", (0.97 * guess, 1.15 * guess))
        found[frequency] = max(branch.bifurcations, key=lambda item: item.value)
    return found


def _amplitude() -> Iterator[Claim]:
    pairs = [(frequency, 1.0 / ratio) for frequency in FREQUENCIES for ratio in RATIOS]
    expected = {pair: closed_forms.amplitude(*pair) for pair in pairs}
    pairs = [pair for pair in pairs if np.isfinite(expected[pair])]
    apart = [abs(largest(steady(*pair)) - expected[pair]) for pair in pairs]
    yield claim(
        "den_hartog.amplitude",
        NOT_READ,
        "Without stops the amplitude is the square root of (a V)^2 - (f U)^2",
        Finding(
            "motions followed event by event have this amplitude",
            f"{len(pairs)} of them differ from it by {max(apart):.1e} at most",
            max(apart) <= CLOSE,
        ),
        values=(_largest(*NO_STOP, 1),),
    )


def _boundary() -> Iterator[Claim]:
    found = boundaries()
    apart = [abs(change.value - closed_forms.stop_boundary(at)) for at, change in found.items()]
    kinds = ", ".join(f"{change.kind} at frequency {at:g}" for at, change in found.items())
    yield claim(
        "den_hartog.boundary",
        NOT_READ,
        "Motions begin to stop where (f/a)^2 = V^2 / (U^2 + S^2)",
        Finding(
            "branches of motions continued in the forcing change their events there",
            f"{len(found)} of them, within {max(apart):.1e}",
            max(apart) <= CLOSE,
        ),
        values=tuple(
            Value(
                f"a/f of the first stop, frequency {at:g}",
                change.value,
                max(change.error, 1e-13),
                2,
                change.kind,
            )
            for at, change in found.items()
        ),
        mechanism=f"the velocity first vanishes at the turn, or before it: {kinds}",
    )


def _stopping() -> Iterator[Claim]:
    counts = [stops(steady(*pair)) for pair in (NO_STOP, ONE_STOP, TWO_STOPS)]
    found, expected = largest(steady(*ONE_STOP)), closed_forms.one_stop_amplitude(*ONE_STOP)
    yield claim(
        "den_hartog.stops",
        NOT_READ,
        "With weaker forcing the block stops once, or twice, in each half period",
        Finding(
            "there are motions with no, two and four stops in a period",
            f"stops in a period: {', '.join(map(str, counts))}",
            counts == [0, 2, 4],
        ),
        Finding(
            "the amplitude with one stop solves its transcendental equation",
            f"it differs by {abs(found - expected):.1e}",
            abs(found - expected) <= CLOSE,
        ),
        values=(_largest(*ONE_STOP, 3),),
    )
    pairs = (NO_STOP, ONE_STOP, ABOVE)
    apart = [closed_forms.one_harmonic(*pair) / largest(steady(*pair)) - 1.0 for pair in pairs]
    told = ", ".join(
        f"{off:+.1%} at frequency {frequency:g}, a/f = {forcing:.3g}"
        for off, (frequency, forcing) in zip(apart, pairs, strict=True)
    )
    yield claim(
        "den_hartog.one_harmonic",
        "the usual tool, beside",
        "Balance of one harmonic misjudges amplitudes, and knows no stops",
        Finding("it is off by more than a tenth", told, min(map(abs, apart)) > 0.1),
        Finding(
            "it has a motion without stops where the block stops in each half period",
            f"amplitude {closed_forms.one_harmonic(*ONE_STOP):.4f}; stops in a period: {counts[1]}",
            np.isfinite(closed_forms.one_harmonic(*ONE_STOP)) and counts[1] == 2,
        ),
    )


def _largest(frequency: float, forcing: float, figure: int) -> Value:
    name = f"amplitude at frequency {frequency:g}, a/f = {forcing:g}"
    return Value(name, largest(steady(frequency, forcing)), 1e-13, figure, "event by event")


CLAIMS: Final = {1: _amplitude, 2: _boundary, 3: _stopping}
