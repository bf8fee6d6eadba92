"""Event maps whose work can be called off between pieces of it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.app.jobs import checkpoint
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.eventmap.records import Outputs

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.maps.protocol import Floats
    from stickslip.mechanics.eventmap.carrier import Carrier
    from stickslip.mechanics.eventmap.records import Controls
    from stickslip.mechanics.model.two_block import TwoBlock

SLOW: Final = 0.05  # seconds between two checks: from then on fewer motions are followed at once
QUICK: Final = 0.01  # ... more of them
FIRST: Final = 16  # motions before the second check
MOST: Final = 4096  # between any two


class WatchedCarrier:
    """A carrier that checks before each piece of its work whether the answer is still wanted."""

    def __init__(self, carrier: Carrier) -> None:
        self._carrier = carrier
        self.name = carrier.name
        self._piece = FIRST

    def _pieces(self, d: Floats) -> Iterator[Floats]:
        """Cut points into pieces that take a moment each, with a checkpoint before each."""
        start = 0
        while start < d.size or not start:
            checkpoint()
            stop, since = start + self._piece, time.monotonic()
            yield d[start:stop]
            start = stop
            self._adapt(time.monotonic() - since)

    def _adapt(self, seconds: float) -> None:
        if seconds > SLOW:
            self._piece = max(1, self._piece // 4)
        elif seconds < QUICK:
            self._piece = min(MOST, self._piece * 2)

    def value(self, d: float) -> float:
        """Value at one d."""
        checkpoint()
        return self._carrier.value(d)

    def values(self, d: Floats) -> Floats:
        """Value at each d."""
        return np.concatenate([self._carrier.values(some) for some in self._pieces(d)])

    def slopes(self, d: Floats) -> Floats:
        """Slope at each d."""
        return np.concatenate([self._carrier.slopes(some) for some in self._pieces(d)])

    def values_and_slopes(self, d: Floats) -> tuple[Floats, Floats]:
        """Value and slope at each d."""
        found = [self._carrier.values_and_slopes(some) for some in self._pieces(d)]
        value, slope = np.concatenate(found, axis=1)
        return value, slope

    def evidence(self, d: Floats) -> Outputs:
        """Everything of each d."""
        found = [self._carrier.evidence(some) for some in self._pieces(d)]
        return Outputs(*map(np.concatenate, zip(*found, strict=True)))

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        found = [self._carrier.parameter_slope(some, name) for some in self._pieces(d)]
        return np.concatenate(found)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows from their first entries on, some steps at a time."""
        start = 0
        while start < orbits.shape[1] - 1:
            checkpoint()
            stop, since = start + max(1, self._piece // max(1, len(orbits))), time.monotonic()
            part = np.ascontiguousarray(orbits[:, start : stop + 1])
            self._carrier.iterate(part)
            orbits[:, start : stop + 1] = part
            start = stop
            self._adapt(time.monotonic() - since)

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        checkpoint()
        return self._carrier.itinerary(d)


class WatchedMap(EventMap):
    """An event map that asks at every evaluation whether the answer is still wanted.

    Values, and what branches, orbits and basins are found from them, are those of the event map.
    """

    def _carrier_of(self, controls: Controls) -> Carrier:
        return WatchedCarrier(super()._carrier_of(controls))


def watched_map(model: TwoBlock, **settings: Any) -> WatchedMap:
    """Make the event map of a model; one thread, since other users want the others."""
    return WatchedMap(model, threads=1, **settings)
