"""The closed forms of forced motion against dry friction, checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.studies.claim import Claim, Finding
from stickslip.studies.den_hartog1931.closed_forms import (
    amplitude,
    one_stop_amplitude,
    stop_boundary,
)
from stickslip.studies.den_hartog1931.facts import (
    FREQUENCIES,
    RATIOS,
    boundaries,
    largest,
    steady,
    stops,
)
from stickslip.studies.values import Value

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

NOT_READ: Final = "1931: source not read; 1930: first page; formulas derived anew"
CLOSE: Final = 1e-12
NO_STOP: Final = (0.7, 2.0)  # frequency and forcing
ONE_STOP: Final = (0.5, 1.8)
TWO_STOPS: Final = (0.2, 3.0)


def compute(figures: Iterable[int] | None = None) -> tuple[Claim, ...]:
    """Check the claims that belong to some figures, by figure."""
    made = {1: _amplitude, 2: _boundary, 3: _stops}
    wanted = made if figures is None else [number for number in made if number in set(figures)]
    return tuple(claim for number in wanted for claim in made[number]())


def _amplitude() -> Iterator[Claim]:
    pairs = [(frequency, 1.0 / ratio) for frequency in FREQUENCIES for ratio in RATIOS]
    expected = {pair: amplitude(*pair) for pair in pairs}
    pairs = [pair for pair in pairs if np.isfinite(expected[pair])]
    apart = [abs(largest(steady(*pair)) - expected[pair]) for pair in pairs]
    frequency, forcing = NO_STOP
    yield Claim(
        key="den_hartog.amplitude",
        figure=1,
        place=NOT_READ,
        statement="Without stops the amplitude is the square root of (a V)^2 - (f U)^2",
        findings=(
            Finding(
                "motions followed event by event have this amplitude",
                f"{len(pairs)} of them differ from it by {max(apart):.1e} at most",
                max(apart) <= CLOSE,
            ),
        ),
        values=(
            Value(
                f"amplitude at frequency {frequency:g}, a/f = {forcing:g}",
                largest(steady(*NO_STOP)),
                1e-13,
                1,
                "event by event",
            ),
        ),
    )


def _boundary() -> Iterator[Claim]:
    found = boundaries()
    apart = [abs(item.forcing - stop_boundary(item.frequency)) for item in found]
    kinds = ", ".join(f"{item.kind} at frequency {item.frequency:g}" for item in found)
    yield Claim(
        key="den_hartog.boundary",
        figure=2,
        place=NOT_READ,
        statement="Motions begin to stop where (f/a)^2 = V^2 / (U^2 + S^2)",
        findings=(
            Finding(
                "branches of motions continued in the forcing change their events there",
                f"{len(found)} of them, within {max(apart):.1e}",
                max(apart) <= CLOSE,
            ),
        ),
        values=tuple(
            Value(
                f"a/f of the first stop, frequency {item.frequency:g}",
                item.forcing,
                max(item.error, 1e-13),
                2,
                item.kind,
            )
            for item in found
        ),
        mechanism=f"the velocity first vanishes at the turn, or before it: {kinds}",
    )


def _stops() -> Iterator[Claim]:
    counts = [stops(steady(*pair)) for pair in (NO_STOP, ONE_STOP, TWO_STOPS)]
    found, expected = largest(steady(*ONE_STOP)), one_stop_amplitude(*ONE_STOP)
    frequency, forcing = ONE_STOP
    yield Claim(
        key="den_hartog.stops",
        figure=3,
        place=NOT_READ,
        statement="With weaker forcing the block stops once, or twice, in each half period",
        findings=(
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
        ),
        values=(
            Value(
                f"amplitude at frequency {frequency:g}, a/f = {forcing:g}",
                found,
                1e-13,
                3,
                "event by event",
            ),
        ),
    )
