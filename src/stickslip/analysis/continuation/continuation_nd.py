"""Periodic orbits of maps of R^n followed along a parameter, through folds, to where they end."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np

from stickslip.analysis.continuation.curve import Curve, CurveEnd, Problem, between
from stickslip.analysis.continuation.follower import checked_steps, contained
from stickslip.analysis.continuation.orbit_follower import OrbitFollower
from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.protocol_nd import apart
from stickslip.analysis.orbits.newton_nd import monodromy, solve_orbits
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND, make_orbit, multipliers_of
from stickslip.numerics.continuation import LeavesRegion, StepTooLong
from stickslip.results.parts import part
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.analysis.continuation.follower import Half
    from stickslip.analysis.continuation.orbit_equations import Departure, Linearized
    from stickslip.analysis.maps.protocol import Floats, PointValues
    from stickslip.analysis.maps.protocol_nd import FamilyND
    from stickslip.numerics.continuation import CurvePoint, WalkEnd

# A border is approached by halving steps that cross it, down to little more than the error of a
# point; then a little further on the way the cause is seen.
SMALLEST: Final = 2e-12
PROBES: Final = (2e-11, 2e-10, 2e-9, 2e-8)
BEYOND: Final = (1e-5, 1e-7)  # scaled ways past a border at which the two sides are compared
SMOOTH: Final = 1e-9  # a larger difference of values is a jump ...
JUMPS: Final = 0.5  # ... if it does not shrink with the way as that of a root-like corner does
SAME_SLOPE: Final = 1e-3  # of Jacobians, beside 1 + their size: a larger difference is a corner


@part
@dataclass(frozen=True, eq=False)
class OrbitProblemND(Problem):
    """The equations of a periodic orbit in R^n."""

    system: FamilyND | None = None
    picture: ClassVar = "bifurcations.draw_orbit_curve"

    def solve(
        self, curve: Curve, row: int, share: float, name: str, value: float
    ) -> PeriodicOrbitND | None:
        """Start from a straight line between two rows; None if no orbit is found."""
        points = between(curve.points, row, share)
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
        return between(curve.points[:, :, 0], row, share)

    def same(self, one: PeriodicOrbitND, other: PeriodicOrbitND) -> bool:
        """Tell whether the points are equal, to rounding."""
        off = np.abs(one.points - other.points).max()
        return bool(off <= 1e-12 * (1.0 + np.abs(one.points).max()))


def follow_orbit_nd(
    orbit: PeriodicOrbitND,
    f: FamilyND,
    name: str,
    range: tuple[float, float],
    *,
    max_step: float | None = None,
    max_points: int | None = None,
) -> Curve:
    """Follow a periodic orbit of a map of R^n along a parameter; see `stickslip.follow`.

    Pseudo-arclength with all points of the orbit as unknowns and exact derivatives. Where a
    point of the orbit gets to another piece of the map the two sides are compared: a map that is
    smooth there is followed on, else the curve ends in a border collision, located by halving
    to its `error`.
    """
    low, high = checked_range(f, name, range)
    steps = checked_steps(max_step, max_points)
    value = contained(low, high, name, float(f.parameters[name]), "orbit")
    follower = _SpaceOrbitFollower(f, name, low, high, *steps, smallest=SMALLEST, patience=steps[1])
    return follower.follow(follower.start(orbit.points, value))


class _SpaceOrbitFollower(OrbitFollower):
    """Follows an orbit of a map of R^n to borders, which are approached by halving steps."""

    def problem(self) -> Problem:
        """Orbits of this map."""
        return OrbitProblemND(self.f)

    def size(self) -> Floats:
        """Width of the domain in each direction."""
        return np.ptp(self.f.spread(256), axis=0)

    def solved(self, value: float, guess: Floats) -> tuple[Floats, float]:
        """Solve for an orbit, points in the order of the guess."""
        got = solve_orbits(self.equations.at(value), guess[None])
        if not got.found[0]:
            return guess, np.nan
        return got.points[0], float(np.prod(multipliers_of(got.jacobians[0]) + 1.0).real)

    def stopped(self, stop: WalkEnd, half: Half) -> CurvePoint | CurveEnd:
        """Find out what ended a walk; pass the ends of pieces where the map is smooth."""
        last = stop.last
        if stop.reason == "end of range":
            return self.end(last, "end of range")
        departure = self._departure(last)
        if departure is None:
            return self.end(last, "step limit")
        cause, way = departure
        index = int(cause.indices[0])
        error = abs(way * float(self.curve.scale[-1] * last.tangent[-1]))
        where: dict[str, Any] = {
            "index": index,
            "error": error + 2 * float(np.spacing(abs(last.parameter))),
        }
        beyond = self._beyond(last, cause)
        if beyond is None:
            inside = self.f.contains(cause.points)[index]
            return self.end(last, "gap" if inside else "end of domain", **where)
        kind, label = beyond
        if kind == "corner" and (passed := self._past(last, half)) is not None:
            return passed
        if kind == "smooth":
            self.equations.pieces[index].add(label)
            return replace(last, step=self.control.first)
        explain = getattr(self.equations.at(last.parameter), "explain_border", None)
        if explain is not None:
            beside = self.equations.at(cause.value), cause.points[index]
            where["border"] = tuple(explain(self.points(last)[index], *beside))
        return self.end(last, "breakpoint", kind=kind, **where)

    def _past(self, last: CurvePoint, half: Half) -> CurvePoint | None:
        """Go on beyond a border that leaves all multipliers as they are; None at any other.

        So does an event of a motion in time that crosses the time at which a map looks at it.
        """
        y = last.y + BEYOND[1] * self.curve.scale * last.tangent
        f = self.equations.at(y[-1])
        # The map itself knows the directions that it forgets: its images are where points belong.
        points = np.roll(self.equations.sample(f, self.equations.points(y)).value, 1, axis=0)
        got = self.equations.sample(f, points)
        if (got.status != OK).any():
            return None
        old, new = (np.poly(monodromy(each)) for each in (last.note.slopes, got.derivative))
        if (np.abs(new - old) > SAME_SLOPE * (1 + np.abs(old).max())).any():
            return None
        pieces, labels = self.equations.pieces, got.label.tolist()
        self.equations.pieces = [{label} for label in labels]
        try:
            start = self.curve.point(np.append(points.ravel(), y[-1]))
        except (StepTooLong, LeavesRegion):
            self.equations.pieces = pieces
            return None
        rising = last.tangent[-1] > 0
        half.rows.append(start if rising else start.reversed())
        return half.rows[-1]

    def _departure(self, last: CurvePoint) -> tuple[Departure, float] | None:
        """Which points leave their pieces just past the end of a walk, and how far past."""
        for way in PROBES:
            try:
                self.equations(last.y + way * self.curve.scale * last.tangent)
            except LeavesRegion as left:
                cause: Departure = left.cause
                return cause, way
            except StepTooLong:
                continue
        return None

    def _beyond(
        self, last: CurvePoint, cause: Departure
    ) -> tuple[Literal["jump", "corner", "smooth"], int] | None:
        """Compare the two sides of the border that a point meets; None without a value there."""
        index = cause.indices[0]
        far, near = (self._other_side(last, index, way) for way in BEYOND)
        if far is None or near is None:
            return None
        note: Linearized = last.note
        slope = note.slopes[index]
        offs = (apart(self.f, side.value, note.values[index]) for side in (far, near))
        gaps = [float(np.abs(off).max()) for off in offs]
        label = int(near.label)
        if gaps[1] > max(SMOOTH, JUMPS * gaps[0]):
            return "jump", label
        if (np.abs(near.derivative - slope) > SAME_SLOPE * (1 + np.abs(slope))).any():
            return "corner", label
        return "smooth", label

    def _other_side(self, last: CurvePoint, index: int, way: float) -> PointValues | None:
        """Value past a border, led back to it by the slopes there; and these slopes."""
        y = last.y + way * self.curve.scale * last.tangent
        f, x = self.equations.at(y[-1]), self.equations.points(y)[index]
        values = self.equations.sample(f, x)
        if values.status != OK:
            return None
        dx = x - self.points(last)[index]
        rate = np.asarray(f.parameter_derivative(x, self.name))
        back = values.value - values.derivative @ dx - rate * (y[-1] - last.y[-1])
        return replace(values, value=back)
