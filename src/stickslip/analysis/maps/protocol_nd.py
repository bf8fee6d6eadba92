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
    label's number, and ``periods`` of its coordinates, infinite for those that are no angles.
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


def apart(f: MapND, x: Floats, y: Floats) -> Floats:
    """Differences of points, angles the short way round."""
    difference: Floats = x - y
    if (periods := getattr(f, "periods", None)) is not None:
        angle = np.isfinite(periods)
        turns = np.round(difference[..., angle] / periods[angle])
        difference[..., angle] -= turns * periods[angle]
    return difference


def turns(f: MapND) -> Floats:
    """Return the period of each coordinate from its low end on, (n, 2); infinite for no angle."""
    period = np.asarray(getattr(f, "periods", np.full(f.dimension, np.inf)))
    domain = getattr(f, "domain", None)
    low = np.zeros(f.dimension) if domain is None else np.asarray(domain, dtype=np.float64)[:, 0]
    low = np.where(np.isfinite(low), low, 0.0)
    return np.stack([low, low + period], axis=1)


def reduced(f: MapND, x: Floats) -> Floats:
    """Return points with each angle in the period that begins at the domain's low end."""
    if not np.isfinite(getattr(f, "periods", np.inf)).any():
        return x
    box = turns(f)
    angle = np.isfinite(box[:, 1])
    low, period = box[angle, 0], np.ptp(box[angle], axis=1)
    led = np.array(x, dtype=np.float64)
    within = np.mod(led[..., angle] - low, period)
    led[..., angle] = low + np.where(within < period, within, 0.0)  # rounded up
    return led


def box_points(box: Floats, count: int) -> Floats:
    """Return the first points of a Sobol sequence in a box (n, 2), always the same."""
    from scipy.stats.qmc import Sobol  # not for the first value

    low, high = box.T
    shares = Sobol(len(box), rng=0).random_base2(max(count - 1, 1).bit_length())[:count]
    return np.asarray(low + shares * (high - low))


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


def orbits(f: Any, x: Floats, n: int) -> Floats:
    """Return orbits (m, n + 1, d) of any points (m, d); NaN once they have left the domain."""
    made = np.full((len(x), n + 1, x.shape[1]), np.nan)
    made[:, 0] = x
    inside = f.contains(x)
    if hasattr(f, "iterate"):
        if n and inside.any():
            made[inside] = f.iterate(x[inside], n)
        return made
    for k in range(n):
        made[:, k + 1] = sample(f, made[:, k]).value
    return made
