"""What a map of R^n must offer, and how it is asked at points that may lie outside."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, Self, runtime_checkable

import numpy as np

from stickslip.analysis.maps.protocol import OUTSIDE, PointValues

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats, MapValues


@runtime_checkable
class MapND(Protocol):
    """A piecewise-smooth map of a part of R^n into R^n, immutable.

    ``evaluate`` takes points of shape (..., n): ``value`` is shaped like them, ``derivative`` is
    the Jacobian (..., n, n), ``label`` and ``status`` are (...). It may raise ValueError outside
    the domain. A map may also offer ``itinerary(x)``, a text per point that says more than the
    label's number.
    """

    @property
    def dimension(self) -> int:
        """The n."""

    def contains(self, x: ArrayLike, /) -> NDArray[np.bool_]:
        """Tell which points are in the domain, shape (...); False for NaN."""

    def spread(self, count: int, /) -> Floats:
        """Return points spread evenly over the domain, shape (count, n), always the same."""

    def evaluate(self, x: ArrayLike, /) -> MapValues:
        """Return value, Jacobian, label and status."""


@runtime_checkable
class FamilyND(MapND, Protocol):
    """A map with named parameters and exact derivatives with respect to each."""

    @property
    def parameters(self) -> Mapping[str, float]:
        """Names and values."""

    def replace(self, **changes: Any) -> Self:
        """Return the map with other parameter values."""

    def parameter_derivative(self, x: ArrayLike, name: str, /) -> Any:
        """Return df/d(name) at fixed ``x``, shaped like it."""


def sample(f: MapND, x: Floats) -> PointValues:
    """Evaluate a map at any points; outside: NaN, label 0 and status `OUTSIDE`."""
    inside = f.contains(x)
    shape = inside.shape
    value, derivative = np.full(x.shape, np.nan), np.full((*x.shape, f.dimension), np.nan)
    label = np.zeros(shape, dtype=np.uint64)
    status = np.full(shape, OUTSIDE, dtype=np.int64)
    if inside.any():
        got = f.evaluate(x[inside])
        value[inside], derivative[inside] = got.value, got.derivative
        label[inside], status[inside] = got.label, got.status
    return PointValues(value, derivative, label, status, np.full(shape, np.nan))
