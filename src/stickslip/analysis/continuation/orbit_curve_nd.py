"""Curves of periodic orbits of maps of R^n: their orbits solved for anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from stickslip.analysis.continuation.curve import Problem
from stickslip.analysis.orbits.newton_nd import solve_orbits
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND, make_orbit
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.maps.protocol_nd import FamilyND


@part
@dataclass(frozen=True, eq=False)
class OrbitProblemND(Problem):
    """The equations of a periodic orbit in R^n."""

    system: FamilyND | None = None
    picture: ClassVar = "bifurcations.draw_orbit_curve_nd"

    def solve(
        self, curve: Curve, row: int, share: float, name: str, value: float
    ) -> PeriodicOrbitND | None:
        """Start from a straight line between two rows; None if no orbit is found."""
        points = curve.points[row]
        if share:
            points = points + share * (curve.points[row + 1] - points)
        return self._solved(curve, value, points)

    def row(self, curve: Curve, row: int) -> PeriodicOrbitND | None:
        """Solve from a row itself."""
        return self._solved(curve, float(curve.values[row]), curve.points[row])

    def _solved(self, curve: Curve, value: float, guess: Floats) -> PeriodicOrbitND | None:
        assert self.system is not None
        f = self.system.replace(**{curve.parameter: value})
        got = solve_orbits(f, guess[None])
        if not got.found[0]:
            return None
        return make_orbit(f, got.points[0], got.jacobians[0], got.labels[0], got.residual[0])

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return the first coordinates of the points."""
        points: Floats = curve.points[row, :, 0]
        return points + share * (curve.points[row + 1, :, 0] - points) if share else points

    def same(self, one: PeriodicOrbitND, other: PeriodicOrbitND) -> bool:
        """Tell whether the points are equal, to rounding."""
        apart = np.abs(one.points - other.points).max()
        return bool(apart <= 1e-12 * (1.0 + np.abs(one.points).max()))
