"""The map f^p: a map like any other, which remembers what it is a power of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast, overload

import numpy as np

from stickslip.analysis.maps.protocol import (
    Map1D,
    Mechanism,
    PointValues,
    checked_points,
    explanation,
    iterate,
    mix_labels,
    sample,
    values_and_slopes,
)
from stickslip.checks import MOST_KEPT, whole_number
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Floats
    from stickslip.checks import Many


class LineMap:
    """What every map of the line offers besides its values: for classes that fit `Map1D`."""

    __slots__ = ()

    def power(self, p: int) -> PowerMap:
        """Return the map f^p, which has no value where an orbit leaves the domain."""
        return PowerMap(cast("Map1D", self), whole_number("p", p, at_most=MOST_KEPT))

    def preimages(self, x: float) -> Floats:
        """Return all points that the map carries to x, ascending; complete as `branches` is."""
        from stickslip.analysis.branches.preimages import preimages  # not for the first value

        return preimages(cast("Map1D", self), x)

    @property
    def gaps(self) -> Floats:
        """Open intervals without a value, shape (k, 2): last point before, first point after."""
        from stickslip.analysis.branches.table import branch_table  # not for the first value

        return branch_table(cast("Map1D", self)).gaps


class EvaluatedMap(LineMap):
    """What a map is called for, from what it is evaluated to."""

    @overload
    def __call__(self, x: float) -> float: ...
    @overload
    def __call__(self, x: Many) -> Floats: ...
    @overload
    def __call__(self, x: ArrayLike) -> float | Floats: ...
    def __call__(self, x: ArrayLike) -> float | Floats:
        """Return f(x): a float for a scalar, else an array of the same shape."""
        return plain(self._value(x))

    @overload
    def derivative(self, x: float) -> float: ...
    @overload
    def derivative(self, x: Many) -> Floats: ...
    @overload
    def derivative(self, x: ArrayLike) -> float | Floats: ...
    def derivative(self, x: ArrayLike) -> float | Floats:
        """Return f'(x): a float for a scalar, else an array of the same shape."""
        return plain(cast("Map1D", self).evaluate(x).derivative)

    def _value(self, x: ArrayLike) -> Floats:
        return cast("Map1D", self).evaluate(x).value


def plain(values: Floats) -> float | Floats:
    """Return a float for an array without axes, other arrays as they are."""
    return float(values) if np.ndim(values) == 0 else values


@dataclass(frozen=True)
class PowerMap(EvaluatedMap):
    """A map applied ``exponent`` times.

    Parameters
    ----------
    base : Map1D
        The map that is applied.
    exponent : int
        How often, >= 1.

    Raises
    ------
    ValueError
        The exponent is not a whole number >= 1.

    Notes
    -----
    Derivatives are products along the orbit, labels combine those of its points in order,
    the status is the first that is not OK. Orbits that leave the domain have no value.
    """

    base: Map1D
    exponent: int

    def __post_init__(self) -> None:
        """Check the exponent."""
        n = whole_number("exponent", self.exponent, at_most=MOST_KEPT)
        object.__setattr__(self, "exponent", n)

    @property
    def domain(self) -> tuple[float, float]:
        """Domain of the base map: points whose orbit leaves it have no value."""
        return self.base.domain

    def evaluate(self, x: ArrayLike, /) -> PointValues:
        """Return value, derivative, label and status of f^p at points of the domain."""
        point = checked_points(self.domain, x)
        derivative = np.ones(point.shape)
        label = np.zeros(point.shape, dtype=np.uint64)
        status = np.full(point.shape, OK, dtype=np.int64)
        margin = np.full(point.shape, np.inf)
        for _ in range(self.exponent):
            step = sample(self.base, point)
            point, derivative = step.value, derivative * step.derivative
            label = mix_labels(label, step.label)
            margin = np.where(status == OK, np.minimum(margin, step.margin), margin)
            status = np.where(status == OK, step.status, status)
        slope = np.where(status == OK, derivative, np.nan)
        return PointValues(point, slope, label, status, margin)

    def value_and_derivative(self, x: ArrayLike) -> tuple[Floats, Floats]:
        """Return f^p(x) and (f^p)'(x), arrays of the same shape, and no more."""
        point = checked_points(self.domain, x)
        derivative = np.ones(point.shape)
        for _ in range(self.exponent):
            point, slope = values_and_slopes(self.base, point)
            derivative = derivative * slope
        return point, np.where(np.isnan(point), np.nan, derivative)

    def itinerary(self, x: float) -> str:
        """Return what the base map says of each point on the way, joined by ``|``."""
        texts, point = [], float(checked_points(self.domain, x))
        describe = getattr(self.base, "itinerary", None)
        for _ in range(self.exponent):
            step = sample(self.base, point)
            texts.append(str(step.label) if describe is None else str(describe(point)))
            if step.status != OK:
                break
            point = float(step.value)
        return " | ".join(texts)

    def explain_break(self, left: float, right: float) -> Mechanism:
        """Return why f^p breaks between two points, and at which iterate."""
        for k in range(self.exponent):
            values = sample(self.base, [left, right])
            if values.label[0] != values.label[1] or (values.status != OK).any():
                text, block = explanation(self.base, left, right)
                place = f" (iterate {k + 1})" if text and self.exponent > 1 else ""
                return Mechanism(text + place, block)
            left, right = values.value.tolist()
        return explanation(self.base, left, right)

    def iterate(self, x: ArrayLike, n: int) -> Floats:
        """Apply f^p ``n`` times; shape ``x.shape + (n + 1,)``."""
        return iterate(self, x, n)

    def power(self, p: int) -> PowerMap:
        """Return the map (f^p)^q as a power of the base map itself."""
        return PowerMap(self.base, self.exponent * whole_number("p", p, at_most=MOST_KEPT))
