"""Curves of periodic orbits of maps of a line: their orbits solved for anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from stickslip.analysis.continuation.curve import Problem
from stickslip.analysis.orbits.newton import itinerary_of, solve_orbit
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.maps.protocol import Floats, MapFamily

APPROACHES: Final = 16  # steps towards an orbit that a straight line does not lead to
SAME: Final = 1e-13  # of the points: orbits that coincide


@part
@dataclass(frozen=True, eq=False)
class OrbitProblem(Problem):
    """The equations of a periodic orbit; `system` is restricted to the window if one was given."""

    system: MapFamily | None = None
    picture: ClassVar = "bifurcations.draw_orbit_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> PeriodicOrbit:
        """Start from a straight line between two rows; beside a fold, go there in steps."""
        if not share:
            return self.row(curve, row)
        ends = (row, row + 1)
        (q, r), (x, y) = curve.values[list(ends)], curve.points[list(ends)]
        orbit = self._solved(curve, value, x + (value - q) / (r - q) * (y - x))
        for start, goal in (ends[::-1], ends):
            if orbit.quality == "located":
                break
            orbit = self._approached(curve, start, goal, value)
        return orbit

    def _approached(self, curve: Curve, start: int, goal: int, number: float) -> PeriodicOrbit:
        q, r = curve.values[start], curve.values[goal]
        share = (abs(number - r) / abs(q - r)) ** (np.arange(1, APPROACHES + 1) / APPROACHES)
        now, x = q, curve.points[start]
        speed = np.zeros_like(x)
        for value in [*(r + share[:-1] * (q - r)).tolist(), number]:
            orbit = self._solved(curve, value, x + (value - now) * speed)
            if orbit.quality != "located":
                break
            shift = int(np.argmin(np.abs(orbit.points - x[0])))
            points = np.roll(orbit.points, -shift)
            speed, x, now = (points - x) / (value - now), points, value
        return orbit

    def _solved(self, curve: Curve, number: float, guess: Floats) -> PeriodicOrbit:
        assert self.system is not None
        return solve_orbit(self.system.replace(**{curve.parameter: number}), guess)

    def row(self, curve: Curve, row: int) -> PeriodicOrbit:
        """Return the orbit of a row as it was solved: at an end, a one-sided limit."""
        assert self.system is not None
        f = self.system.replace(**{curve.parameter: float(curve.values[row])})
        start = int(np.argmin(curve.points[row]))
        points = np.roll(curve.points[row], -start)
        labels = np.roll(curve.data["labels"][row], -start)
        multiplier, residual = float(curve.multipliers[row]), float(curve.data["residual"][row])
        return PeriodicOrbit(
            points=points,
            period=len(points),
            multiplier=multiplier,
            stable=abs(multiplier) < 1,
            itinerary=itinerary_of(f, points, labels),
            labels=labels,
            quality="located",
            interval=points[:, None] + residual * np.array([-1.0, 1.0]),
            residual=residual,
            system=f,
        )

    def same(self, one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
        """Tell whether two orbits coincide, to their errors."""
        errors = np.ptp(one.interval, axis=1) + np.ptp(other.interval, axis=1)
        apart = np.abs(one.points - other.points)
        return bool((apart <= errors + SAME * np.abs(one.points).max()).all())
