"""A map that remembers: conditions that share a critical point ask for the same images."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Map1D, MapValues


class RememberingMap:
    """A map of the line whose values are kept, for a short while: nothing is ever dropped."""

    def __init__(self, f: Map1D) -> None:
        self.f = f
        self._known: dict[tuple[bytes, tuple[int, ...]], MapValues] = {}

    @cached_property
    def domain(self) -> tuple[float, float]:
        """Domain of the map."""
        return self.f.domain

    @cached_property
    def whole(self) -> RememberingMap:
        """Of a window of a map, the whole map, which remembers too."""
        whole = getattr(self.f, "whole", self.f)
        return self if whole is self.f else RememberingMap(whole)

    def evaluate(self, x: ArrayLike, /) -> MapValues:
        """Return what the map says at points, from memory if these very points were asked for."""
        points = np.asarray(x, dtype=np.float64)
        key = points.tobytes(), points.shape
        if key not in self._known:
            self._known[key] = self.f.evaluate(points)
        return self._known[key]

    def __getattr__(self, name: str) -> Any:
        """Return what else the map offers."""
        return getattr(self.f, name)
