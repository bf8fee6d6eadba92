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
    from stickslip.mechanics.eventmap.backend import Backend
    from stickslip.mechanics.eventmap.records import Controls
    from stickslip.mechanics.model.two_block import TwoBlock

SLOW: Final = 0.05  # seconds between two checks: from then on fewer motions are followed at once
QUICK: Final = 0.01  # ... more of them
FIRST: Final = 16  # motions before the second check
MOST: Final = 4096  # between any two


class WatchedBackend:
    """A backend that checks before each piece of its work whether the answer is still wanted."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self.name = backend.name
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
        return self._backend.value(d)

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        found = [self._backend.carry(some, slope=slope, watch=watch) for some in self._pieces(d)]
        return Outputs(*map(np.concatenate, zip(*found, strict=True)))

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        found = [self._backend.parameter_slope(some, name) for some in self._pieces(d)]
        return np.concatenate(found)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows from their first entries on, some steps at a time."""
        start = 0
        while start < orbits.shape[1] - 1:
            checkpoint()
            stop, since = start + max(1, self._piece // max(1, len(orbits))), time.monotonic()
            part = np.ascontiguousarray(orbits[:, start : stop + 1])
            self._backend.iterate(part)
            orbits[:, start : stop + 1] = part
            start = stop
            self._adapt(time.monotonic() - since)

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        checkpoint()
        return self._backend.itinerary(d)


class WatchedMap(EventMap):
    """An event map that asks at every evaluation whether the answer is still wanted.

    Values, and what branches, orbits and basins are found from them, are those of the event map.
    """

    def _backend_of(self, controls: Controls) -> Backend:
        return WatchedBackend(super()._backend_of(controls))


def watched_map(model: TwoBlock, **settings: Any) -> WatchedMap:
    """Make the event map of a model; one thread, since other users want the others."""
    return WatchedMap(model, threads=1, **settings)
