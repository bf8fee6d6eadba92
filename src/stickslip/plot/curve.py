"""A piecewise-smooth map as a line with gaps: sampled where it bends, broken where it jumps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_ROUNDS = 40  # bisections; enough for 1e-9 of the window, and a bound in every case
_MOST_POINTS = 50_000


class _Map(Protocol):
    def evaluate(self, x: Any, /) -> Any: ...


@dataclass(frozen=True)
class Curve:
    """Graph of a map, ready to draw: points in ascending order, NaN between segments."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    jumps: NDArray[np.float64]  # where the value jumps, or the map becomes undefined


def trace(
    f: _Map, window: tuple[float, float], *, points: int = 801, resolution: float = 1e-9
) -> Curve:
    """Sample a map for drawing: broken where the label changes *and* the value jumps."""
    # Branches thinner than the first sample of so many `points` can be missed: ask `branches` for a
    # complete list. Changes of label are bisected to a share `resolution` of the window.
    x = np.linspace(*window, points)
    y, label = _evaluate(f, x)
    width = x[-1] - x[0]
    for _ in range(_ROUNDS):
        gap = np.diff(x)
        changes = (label[1:] != label[:-1]) & (gap > resolution * width)
        steep = (np.abs(np.diff(y)) > 0.01 * _height(y)) & (gap > 1e-6 * width)
        (where,) = np.nonzero(changes | steep)
        if where.size == 0 or x.size > _MOST_POINTS:
            break
        middle = 0.5 * (x[where] + x[where + 1])
        y_middle, label_middle = _evaluate(f, middle)
        x = np.insert(x, where + 1, middle)
        y = np.insert(y, where + 1, y_middle)
        label = np.insert(label, where + 1, label_middle)
    return _broken(x, y, label)


def _evaluate(f: _Map, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.uint64]]:
    result = f.evaluate(x)
    return np.asarray(result.value, dtype=np.float64), np.asarray(result.label)


def _height(y: NDArray[np.float64]) -> float:
    finite = y[np.isfinite(y)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _broken(x: NDArray[np.float64], y: NDArray[np.float64], label: NDArray[np.uint64]) -> Curve:
    """Put NaN between neighbours that a change of label and a jump separate."""
    # A bisected change is 1e-9 of the window wide; across it even a square root moves by less than
    # 1e-4 of the height. So a larger difference is a jump.
    jumps = (label[1:] != label[:-1]) & ~(np.abs(np.diff(y)) <= 1e-4 * _height(y))
    (where,) = np.nonzero(jumps)
    line = np.where(np.isfinite(y), x, np.nan)
    return Curve(
        x=np.insert(line, where + 1, np.nan),
        y=np.insert(y, where + 1, np.nan),
        jumps=0.5 * (x[where] + x[where + 1]),
    )
