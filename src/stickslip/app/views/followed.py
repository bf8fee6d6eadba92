"""Orbits of a map solved for from those of a map nearby: quick while a slider moves.

They are orbits of the map, to rounding; only the search after them tells that there are no others.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.analysis.orbits.newton import polish

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

NEAR: Final = 0.05  # largest change of a parameter, of its size
MOVED: Final = 0.05  # of the domain's width: an orbit further off is another one
SAME: Final = 1e-9  # of the domain's width: points that coincide
MODELS: Final = 64  # that are remembered


class Known:
    """Orbits of the latest models, of all users."""

    def __init__(self) -> None:
        self._lists: deque[tuple[Model, tuple[Floats, ...]]] = deque(maxlen=MODELS)

    def add(self, model: Model, orbits: Iterable[PeriodicOrbit]) -> None:
        """Remember the orbits of a model, those through a jump aside."""
        self._lists.append((model, tuple(o.points for o in orbits if o.jump is None)))

    def followed(self, f: Map1D, model: Model, max_period: int) -> Iterator[dict[str, Any]]:
        """Solve for the orbits of the nearest model that is known, if one is near."""
        latest_first = tuple(self._lists)[::-1]
        nearest = min(latest_first, key=lambda item: _distance(item[0], model), default=None)
        if nearest is None or _distance(nearest[0], model) > NEAR:
            return
        by_period: dict[int, list[Floats]] = defaultdict(list)
        for points in nearest[1]:
            by_period[len(points)].append(points)
        for period in sorted(period for period in by_period if period <= max_period):
            yield from _solved(f, np.array(by_period[period]))


def _distance(one: Model, other: Model) -> float:
    """Largest change of a parameter, relative to its size; infinite between other laws."""
    if [type(law) for law in one.laws] != [type(law) for law in other.laws]:
        return np.inf
    first, second = one.parameters, other.parameters
    if first.keys() != second.keys():
        return np.inf
    sizes = [max(abs(first[name]), abs(second[name]), NEAR) for name in first]
    steps = [abs(first[name] - second[name]) for name in first]
    return max(step / size for step, size in zip(steps, sizes, strict=True))


def _solved(f: Map1D, guesses: Floats) -> Iterator[dict[str, Any]]:
    """Solve for orbits of one period, shape (n, p), all together."""
    low, high = f.domain
    guesses = guesses[((guesses >= low) & (guesses <= high)).all(axis=1)]

    def evaluate(_: NDArray[np.intp], x: Floats) -> tuple[Floats, Floats]:
        values = sample(f, x)
        return values.value, values.derivative

    bounds = np.full_like(guesses, low), np.full_like(guesses, high)
    found = polish(evaluate, guesses, *bounds, max(abs(low), abs(high)))
    width = domain_width(f)
    kept: list[Floats] = []
    for k in np.flatnonzero(found.converged):
        points = np.roll(found.points[k], -int(np.argmin(found.points[k])))
        is_near = np.abs(found.points[k] - guesses[k]).max() <= MOVED * width
        is_shorter = len(points) > 1 and np.diff(np.sort(points)).min() <= SAME * width
        is_known = any(np.abs(points - other).max() <= SAME * width for other in kept)
        if is_near and not is_shorter and not is_known:
            kept.append(points)
            yield _described(points, float(found.slopes[k].prod()))


def _described(points: Floats, multiplier: float) -> dict[str, Any]:
    stable = abs(multiplier) < 1.0
    return {
        "period": len(points),
        "points": points,
        "multiplier": multiplier,
        "kind": "stable" if stable else "unstable",
        "stable": stable,
    }
