"""Many periodic orbits of one map, of any periods, as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analysis.maps.protocol import sample
from stickslip.numerics.arrays import Columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit


def padded(rows: Sequence[Floats]) -> tuple[Floats, NDArray[np.intp]]:
    """Return rows of any lengths as one array, NaN beyond the end of each, and the lengths."""
    lengths = np.array([len(row) for row in rows], dtype=np.intp)
    wide = np.full((len(rows), int(lengths.max(initial=1))), np.nan)
    for line, row in zip(wide, rows, strict=True):
        line[: len(row)] = row
    return wide, lengths


@dataclass(frozen=True, eq=False)
class OrbitBundle(Columns):
    """k periodic orbits of one map; arrays (k, P) are padded to the longest period P."""

    periods: NDArray[np.intp]
    points: Floats  # in the map's order; NaN beyond the period
    slopes: Floats
    labels: Labels  # 0 beyond the period

    @classmethod
    def of(cls, orbits: Sequence[PeriodicOrbit], f: Map1D) -> OrbitBundle:
        """Gather orbits of the map f, none infinitely unstable: such a one has no slope."""
        points, periods = padded([orbit.points for orbit in orbits])
        values = sample(f, points)
        return cls(periods, points, values.derivative, values.label)

    def orbit_points(self, row: int) -> Floats:
        """Return the points of one orbit, shape (period,)."""
        return self.points[row, : self.periods[row]]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which places of the padded arrays are points, shape (k, P)."""
        return np.arange(self.points.shape[1]) < self.periods[:, None]

    @property
    def multipliers(self) -> Floats:
        """Product of each orbit's slopes, shape (k,); infinite beyond the range of floats."""
        with np.errstate(over="ignore"):
            product: Floats = np.where(self.used, self.slopes, 1.0).prod(axis=1)
        return product

    def repeats(self, slack: ArrayLike) -> NDArray[np.bool_]:
        """Tell which orbits repeat, up to a slack, after a divisor of their period; shape (k,)."""
        found = np.zeros(len(self), dtype=bool)
        columns, slack = np.arange(self.points.shape[1]), np.broadcast_to(slack, self.points.shape)
        for q in range(1, self.points.shape[1] // 2 + 1):
            rows = np.flatnonzero((self.periods % q == 0) & (self.periods > q))
            if rows.size:
                points, periods = self.points[rows], self.periods[rows, None]
                later = np.take_along_axis(points, (columns + q) % periods, axis=1)
                with np.errstate(invalid="ignore"):
                    same = (np.abs(later - points) <= slack[rows]) | (columns >= periods)
                found[rows] |= same.all(axis=1)
        return found
