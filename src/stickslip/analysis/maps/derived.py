"""Maps made of others: powers f^p, and windows of the domain, outside of which orbits end."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast, overload

import numpy as np

from stickslip.analysis.maps.protocol import (
    Map1D,
    Mechanism,
    PointValues,
    checked_points,
    clip_to_domain,
    explanation,
    iterate,
    mix_labels,
    sample,
    values_and_slopes,
)
from stickslip.checks import MOST_KEPT, Many, checked_interval, whole_number
from stickslip.results.files import register_part
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Floats, MapValues


class LineMap:
    """What every map of the line offers besides its values: for classes that fit `Map1D`."""

    __slots__ = ()

    def power(self, p: int) -> PowerMap:
        """Return the map f^p, which has no value where an orbit leaves the domain."""
        return PowerMap(cast("Map1D", self), whole_number("p", p, at_most=MOST_KEPT))

    def preimages(self, x: float) -> Floats:
        """Return all points that the map carries to x, ascending; complete as `branches` is."""
        from stickslip.analysis.branches.table import preimages  # not for the first value

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

    def iterate(self, x: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times; shape ``x.shape + (n + 1,)``, NaN once it has left."""
        return iterate(cast("Map1D", self), x, n)

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
        n_events = np.zeros(point.shape, dtype=np.int64)
        for _ in range(self.exponent):
            step = sample(self.base, point)
            n_events += step.n_events
            point, derivative = step.value, derivative * step.derivative
            label = mix_labels(label, step.label)
            margin = np.where(status == OK, np.minimum(margin, step.margin), margin)
            status = np.where(status == OK, step.status, status)
        slope = np.where(status == OK, derivative, np.nan)
        return PointValues(point, slope, label, status, margin, n_events)

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

    def power(self, p: int) -> PowerMap:
        """Return the map (f^p)^q as a power of the base map itself."""
        return PowerMap(self.base, self.exponent * whole_number("p", p, at_most=MOST_KEPT))


@dataclass(frozen=True)
class WindowMap(EvaluatedMap):
    """A map on a part of its domain, clipped to that of ``f``; values outside end the orbit.

    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.5})
    >>> upper = WindowMap(f, (0.5, 1.0))
    >>> upper.replace(r=3.2).domain
    (0.5, 1.0)
    >>> len(ss.periodic_orbits(f)), len(ss.periodic_orbits(upper))
    (2, 1)
    """

    f: Map1D
    window: tuple[float, float]

    def __post_init__(self) -> None:
        """Check the window, and that it meets the domain."""
        object.__setattr__(self, "window", checked_interval("window", self.window))
        lo, hi = self.domain
        if not lo < hi:
            (first, last), (start, end) = self.window, self.f.domain
            raise ValueError(
                f"window = ({first:.12g}, {last:.12g}) does not meet the domain "
                f"[{start:.12g}, {end:.12g}] of the map. Take a part of it."
            )

    @cached_property
    def domain(self) -> tuple[float, float]:
        """The part of the window that lies in the domain of the whole map."""
        lo, hi = self.f.domain
        return max(lo, self.window[0]), min(hi, self.window[1])

    @property
    def whole(self) -> Map1D:
        """The map without any window."""
        return self.f.whole if isinstance(self.f, WindowMap) else self.f

    def __repr__(self) -> str:
        """Name the map and the window."""
        return f"WindowMap({self.f!r}, ({self.window[0]:.12g}, {self.window[1]:.12g}))"

    # ------------------------------------------------------------------ values

    def evaluate(self, x: ArrayLike, /) -> MapValues:
        """Return value, derivative, label and status at points of the window."""
        return self.f.evaluate(checked_points(self.domain, x))

    @property
    def value_and_derivative(self) -> Any:
        """Value and slope at once; an AttributeError if the whole map does not offer it."""
        return self.f.value_and_derivative  # type: ignore[attr-defined]

    @property
    def itinerary(self) -> Any:
        """What the whole map says of a point's branch; an AttributeError if it says nothing."""
        return self.f.itinerary  # type: ignore[attr-defined]

    @property
    def explain_break(self) -> Any:
        """Why the whole map breaks; an AttributeError if the whole map does not say."""
        return self.f.explain_break  # type: ignore[attr-defined]

    def iterate(self, x: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times; shape ``x.shape + (n + 1,)``, NaN once outside the window."""
        points = checked_points(self.domain, x)
        inner = getattr(self.f, "iterate", None)
        if inner is None or n < 0:
            return iterate(self, points, n)
        return self._ended(inner(points, n))

    @property
    def iterate_each(self) -> Any:
        """Orbits of several windowed maps; an AttributeError if the whole maps do not offer it."""
        inner = self.f.iterate_each  # type: ignore[attr-defined]

        def iterate_each(
            maps: Sequence[WindowMap], starts: Sequence[ArrayLike], n: int
        ) -> list[Floats]:
            points = [checked_points(g.domain, x) for g, x in zip(maps, starts, strict=True)]
            orbits = inner([g.f for g in maps], points, n)
            return [g._ended(orbit) for g, orbit in zip(maps, orbits, strict=True)]

        return iterate_each

    def _ended(self, orbit: Floats) -> Floats:
        """Let an orbit end where it leaves the window."""
        _, inside = clip_to_domain(self.domain, orbit[..., :-1])
        orbit[..., 1:][~np.logical_and.accumulate(inside, axis=-1)] = np.nan
        return orbit

    # ------------------------------------------------------------------ parameters

    @property
    def parameters(self) -> Mapping[str, float]:
        """Names and values, those of the whole map."""
        return self.f.parameters  # type: ignore[attr-defined]

    def replace(self, **changes: Any) -> WindowMap:
        """Return the same window of the map with other parameter values."""
        return WindowMap(self.f.replace(**changes), self.window)  # type: ignore[attr-defined]

    def parameter_derivative(self, x: ArrayLike, name: str, /) -> Any:
        """Return df/d(name) at fixed points x of the window."""
        points = checked_points(self.domain, x)
        return self.f.parameter_derivative(points, name)  # type: ignore[attr-defined]


def windowed(f: Any, window: tuple[float, float] | None) -> Any:
    """Return a map restricted to a window, or as it is for None."""
    return f if window is None else WindowMap(f, window)


def _window_map(values: dict[str, Any]) -> WindowMap | None:
    f, window = values["of"], values["window"]
    return None if f is None else WindowMap(f, tuple(window))


def _power_map(values: dict[str, Any]) -> PowerMap | None:
    f = values["of"]
    return None if f is None else PowerMap(f, values["exponent"])


register_part("power", PowerMap, lambda f: {"of": f.base, "exponent": f.exponent}, _power_map)
register_part("window", WindowMap, lambda f: {"of": f.f, "window": list(f.window)}, _window_map)
