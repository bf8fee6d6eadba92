"""Event maps whose work can be called off between pieces of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.app.jobs import checkpoint
from stickslip.mechanics.eventmap.result import EventMapResult
from stickslip.study.event_map import EventMap

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

    from stickslip.analysis.protocol import Floats
    from stickslip.mechanics.model.two_block import TwoBlock

__all__ = ["WatchedMap", "watched_map"]

PIECE: Final = 128  # points between two checks: a tenth of a second where no motion returns
FIELDS: Final = ("value", "derivative", "duration", "n_events", "label", "margin", "status")


class WatchedMap(EventMap):
    """An event map that asks at every evaluation whether the answer is still wanted.

    Values, and what branches, orbits and basins are found from them, are those of the event map.
    """

    def evaluate(self, d: ArrayLike) -> EventMapResult:
        """Evaluate piece by piece, with a checkpoint before each."""
        points = np.asarray(d, dtype=np.float64)
        checkpoint()
        if points.size <= PIECE:
            return super().evaluate(points)
        pieces = [super(WatchedMap, self).evaluate(some) for some in _pieces(points)]
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(piece, name) for piece in pieces]).reshape(points.shape)
            for name in FIELDS
        }
        return EventMapResult(**columns)

    def value_and_derivative(self, d: ArrayLike) -> tuple[Any, Any]:
        """Values and slopes piece by piece, with a checkpoint before each."""
        points = np.asarray(d, dtype=np.float64)
        checkpoint()
        if points.size <= PIECE:
            return super().value_and_derivative(points)
        found = [super(WatchedMap, self).value_and_derivative(some) for some in _pieces(points)]
        value, slope = np.concatenate(found, axis=1).reshape(2, *points.shape)
        return value, slope


def _pieces(points: Floats) -> Iterator[Floats]:
    """Cut points into pieces, with a checkpoint before each."""
    for start in range(0, points.size, PIECE):
        checkpoint()
        yield points.ravel()[start : start + PIECE]


def watched_map(model: TwoBlock, **settings: Any) -> WatchedMap:
    """Make the event map of a model; one thread, since other users want the others."""
    return WatchedMap(model, threads=1, **settings)
