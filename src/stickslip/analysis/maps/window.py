"""A map restricted to a part of its domain: orbits that leave the part have left the map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analysis.maps.power import EvaluatedMap
from stickslip.analysis.maps.protocol import checked_points, clip_to_domain, iterate
from stickslip.checks import checked_interval
from stickslip.results.files import register_part

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Floats, Map1D, MapValues


@dataclass(frozen=True)
class WindowMap(EvaluatedMap):
    """A map on a part of its domain, for whoever studies only that.

    Parameters
    ----------
    f : Map1D
        An event map, a `PiecewiseMap`, a power of one, or a window of one.
    window : pair of float
        Ends ``lo < hi`` of the part; clipped to the domain of ``f``, which may move with
        the parameters.

    Raises
    ------
    ValueError
        The window is not an interval, or does not meet the domain.

    Notes
    -----
    Values are those of ``f``, also where they lie outside the window: there the orbit
    leaves. What ``f`` offers besides the protocol of `Map1D` (parameters, texts of
    itineraries) the restricted map offers too.

    Examples
    --------
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
        """Return value, derivative, label and status at points of the window.

        Raises
        ------
        ValueError
            An element is NaN or outside the window.
        """
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
        """Apply the map ``n`` times; shape ``x.shape + (n + 1,)``.

        After the first point outside the window NaN stays.
        """
        points = checked_points(self.domain, x)
        inner = getattr(self.f, "iterate", None)
        if inner is None or n < 0:
            return iterate(self, points, n)
        orbit: Floats = inner(points, n)
        _, inside = clip_to_domain(self.domain, orbit[..., :-1])
        orbit[..., 1:][~np.logical_and.accumulate(inside, axis=-1)] = np.nan
        return orbit

    # ------------------------------------------------------------------ parameters

    @property
    def parameters(self) -> Mapping[str, float]:
        """Names and values, those of the whole map."""
        parameters: Mapping[str, float] = self.f.parameters  # type: ignore[attr-defined]
        return parameters

    def replace(self, **changes: Any) -> WindowMap:
        """Return the same window of the map with other parameter values.

        Raises
        ------
        ValueError
            As for the whole map; or its domain has moved out of the window.
        """
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


register_part("window", WindowMap, lambda f: {"of": f.f, "window": list(f.window)}, _window_map)
