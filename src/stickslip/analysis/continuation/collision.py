"""Where a periodic orbit meets a break of the map, or the end of its domain, along a parameter.

That is a condition of its own, solved to rounding: one point of the orbit is pinned to the
break, and the parameter takes its place among the unknowns. Only one-sided values at the break
enter, so that neither an orbit that ends there nor a root's infinite slope does any harm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.maps.protocol import sample
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from stickslip.analysis.continuation.borders import Border
    from stickslip.analysis.maps.protocol import Floats, MapFamily

MAX_STEPS: Final = 60
FIRST_CHANGE: Final = 1e-6  # of the parameter's range: for the first difference of the readings
ROUNDING: Final = 4 * float(np.finfo(np.float64).eps)  # of the parameter's size: a last step
SHRINKS: Final = 0.9  # at a tangency, too, each step is half or two thirds of the one before
STALLED: Final = 1e-9  # of the parameter's range: steps that do not shrink below it are noise


@dataclass(frozen=True, eq=False)
class Meeting:
    """An orbit with a point held on a border; periodic where the residual vanishes."""

    value: float  # of the parameter
    points: Floats
    f: MapFamily
    place: float  # of the border, ...
    image: float  # ... and its one-sided value
    slopes: Floats  # one-sided at the border
    labels: NDArray[np.uint64]  # at the border maybe that of the other side
    residual: Floats


def meet(
    at: Callable[[float], MapFamily],
    name: str,
    points: Floats,
    index: int,
    border: Border,
    value: float,
    low: float,
    high: float,
) -> Meeting:
    """Solve for the parameter at which point ``index`` of a periodic orbit lies on a border.

    Raises `ConditionLost` if the border is gone, the orbit leaves the domain, or nothing is nearby.
    """
    problem = _Problem(at, name, index, border)
    aside = FIRST_CHANGE * (high - low)
    before = problem.state(value + aside if value + aside <= high else value - aside, points)
    now = problem.state(value, points)
    last = np.inf
    for _ in range(MAX_STEPS):
        step = problem.newton_step(before, now)
        change = abs(step[index])
        noise = change <= STALLED * (high - low) and change >= SHRINKS * last
        if noise or change <= ROUNDING * max(abs(now.value), high - low):
            return now
        q = min(max(now.value + step[index], low), high)
        if not np.isfinite(step).all() or q == now.value:
            break
        before, now, last = now, problem.state(q, now.points + step), change
    raise ConditionLost("the orbit does not meet the break nearby")


@dataclass(frozen=True, eq=False)
class _Problem:
    at: Callable[[float], MapFamily]
    name: str
    index: int
    border: Border

    def state(self, q: float, guess: Floats) -> Meeting:
        """Evaluate the equations, the pinned point on the border."""
        f, k = self.at(q), self.index
        met, side = self.border.reading(f), self.border.side
        points = np.clip(guess, *f.domain)
        points[k] = met.x
        values = sample(f, points)
        rest = np.arange(len(points)) != k
        if (values.status[rest] != OK).any():
            raise ConditionLost("the orbit has no value on the way to the break")
        images, slopes = values.value.copy(), values.derivative.copy()
        images[k], slopes[k] = met.value(side), met.slope(side)
        residual = images - np.roll(points, -1)
        return Meeting(q, points, f, met.x, met.value(side), slopes, values.label, residual)

    def newton_step(self, before: Meeting, now: Meeting) -> Floats:
        """Solve for changes of the points, and the parameter's in place of the pinned one's."""
        k, p = self.index, len(now.points)
        ahead = (np.arange(p) + 1) % p
        difference = now.value - before.value
        rates = np.zeros(p)
        rest = np.arange(p) != k
        if rest.any():
            rates[rest] = now.f.parameter_derivative(now.points[rest], self.name)
        rates[k] = (now.image - before.image) / difference
        matrix = np.zeros((p, p))
        matrix[np.arange(p), np.arange(p)] = np.where(rest, now.slopes, 0.0)
        matrix[np.arange(p), ahead] -= np.where(ahead == k, 0.0, 1.0)
        matrix[:, k] = rates
        matrix[k - 1, k] -= (now.place - before.place) / difference
        try:
            return np.asarray(np.linalg.solve(matrix, -now.residual), dtype=np.float64)
        except np.linalg.LinAlgError as reason:
            raise ConditionLost("the orbit touches the break without crossing it") from reason
