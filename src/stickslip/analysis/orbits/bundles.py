"""Many periodic orbits of one map, of any periods, moved to another parameter value at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.maps.protocol import sample
from stickslip.analysis.orbits.newton import polish_on

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

SAME: Final = 1e-9  # of the domain's size: points of an orbit that coincide


@dataclass(frozen=True, eq=False)
class OrbitBundle:
    """k periodic orbits of one map; arrays (k, P) are padded to the longest period P."""

    periods: NDArray[np.intp]
    points: Floats  # in the map's order; NaN beyond the period
    slopes: Floats
    labels: Labels  # 0 beyond the period

    @classmethod
    def of(cls, orbits: Sequence[PeriodicOrbit], f: Map1D) -> OrbitBundle:
        """Gather orbits of the map f; refuse infinitely unstable ones, which have no slope."""
        periods = np.array([orbit.period for orbit in orbits], dtype=np.intp)
        points = np.full((len(orbits), int(periods.max(initial=1))), np.nan)
        for row, orbit in zip(points, orbits, strict=True):
            if orbit.jump is not None:
                raise ValueError(
                    f"the orbit through the jump d = {orbit.jump.d:.12g} is infinitely unstable "
                    "and cannot be followed: follow the jump itself."
                )
            row[: orbit.period] = orbit.points
        values = sample(f, points)
        return cls(periods, points, values.derivative, values.label)

    def __len__(self) -> int:
        """Return the number of orbits."""
        return len(self.periods)

    def take(self, index: NDArray[np.intp] | NDArray[np.bool_] | slice) -> OrbitBundle:
        """Return some of the orbits."""
        return OrbitBundle(
            self.periods[index], self.points[index], self.slopes[index], self.labels[index]
        )

    def orbit_points(self, row: int) -> Floats:
        """Return the points of one orbit, shape (period,)."""
        return self.points[row, : self.periods[row]]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which places of the padded arrays are points, shape (k, P)."""
        used: NDArray[np.bool_] = np.arange(self.points.shape[1]) < self.periods[:, None]
        return used

    @property
    def multipliers(self) -> Floats:
        """Product of each orbit's slopes, shape (k,)."""
        product: Floats = np.where(self.used, self.slopes, 1.0).prod(axis=1)
        return product


@dataclass(frozen=True, eq=False)
class Moved:
    """Orbits after a change of the parameter; arrays of shape (k,)."""

    bundle: OrbitBundle  # meaningless where not `converged`
    converged: NDArray[np.bool_]  # down to rounding
    given_up: NDArray[np.bool_]  # Newton's method led too far away, or its steps grew
    collapsed: NDArray[np.bool_]  # converged, but onto an orbit of which the period is a multiple
    surprise: Floats  # largest distance of a point from its forecast


def polish_orbits(
    bundle: OrbitBundle, f: Map1D, start: Floats | None = None, **limits: float
) -> Moved:
    """Solve for orbits of f from ``start``, by default the bundle's points; limits of `polish`."""
    scale = max(abs(end) for end in f.domain)
    found = polish_on(f, bundle.points, periods=bundle.periods, start=start, **limits)
    slopes = np.where(bundle.used, found.slopes, np.nan)
    moved = OrbitBundle(bundle.periods, found.points, slopes, found.labels)
    collapsed = _collapsed(moved, SAME * scale) & found.converged
    off = np.where(bundle.used, np.abs(found.points - bundle.points), 0.0)
    surprise = off.max(axis=1, initial=0.0)
    return Moved(moved, found.converged, found.given_up, collapsed, surprise)


def _collapsed(bundle: OrbitBundle, same: float) -> NDArray[np.bool_]:
    """Tell which orbits repeat after a divisor of their period."""
    collapsed = np.zeros(len(bundle), dtype=bool)
    columns = np.arange(bundle.points.shape[1])
    for q in range(1, bundle.points.shape[1] // 2 + 1):
        rows = np.flatnonzero((bundle.periods % q == 0) & (bundle.periods > q))
        points, periods = bundle.points[rows], bundle.periods[rows]
        later = np.take_along_axis(points, (columns + q) % periods[:, None], axis=1)
        apart = np.where(bundle.used[rows], np.abs(later - points), 0.0)
        collapsed[rows] |= apart.max(axis=1, initial=0.0) <= same
    return collapsed
