"""Bifurcations as zeros of scalar functions of a map, each with a regular problem inside.

| condition | problem inside, at given parameters | function |
|---|---|---|
| `Fold` | x with (f^p)'(x) = 1 | f^p(x) - x |
| `Flip` | the periodic orbit | multiplier + 1 |
| `Crossing` | x where d f^p(x) / dq = 0 | (f^p)'(x) - 1 |
| `Collision` | the border c | f^p(c-) - c or f^p(c+) - c |
| `Connection` | the critical point c, the unstable orbit u | f^k(c) - u |

A condition is plain data. Evaluated in a map, it says where it stands and hands over the same
condition started from there: the next map may then be a little different.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from stickslip.analysis.bifurcations.conditions.orbit_paths import (
    follow_orbit,
    multiplier_noise,
    path_from,
    rounding,
    slope_one,
)
from stickslip.analysis.bifurcations.conditions.rates import stationary_in_parameter
from stickslip.analysis.branches.along.borders import ConditionLost
from stickslip.analysis.maps.protocol import MapFamily
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.borders import BorderReading, Critical
    from stickslip.analysis.maps.protocol import Map1D


@part
@dataclass(frozen=True)
class Reading:
    """What a condition finds in one map."""

    value: float  # the test function; the bifurcation is where it vanishes
    noise: float  # rounding in it, estimated
    # the orbit, in the map's order; away from the bifurcation it does not quite close
    points: tuple[float, ...]
    # one; of a `Collision` two, from the border's left and right, NaN beside a gap
    multipliers: tuple[float, ...]
    condition: Condition  # the same one, started from here
    labels: tuple[int, ...] = ()  # branches that the test function depends on, the border's aside
    visited: tuple[float, ...] = ()  # the points that have these labels
    critical: BorderReading | None = None
    # of a `Connection`: the images of the critical point, itself first
    path: tuple[float, ...] = ()
    # (f^p)'' at a `Fold` or `Crossing`; 0 at a cusp, and at a pitchfork
    curvature: float = math.nan
    mixed: float = math.nan  # of a `Crossing`: derivative of (f^p)' with respect to the parameter


@part
@dataclass(frozen=True)
class Fold:
    """An orbit with multiplier 1: f^p(x) - x where (f^p)'(x) = 1."""

    period: int
    points: tuple[float, ...]  # where the orbit was last

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` where (f^p)' is not 1 anywhere nearby."""
        path, curvature, value = slope_one(f, self.period, self.points[0])
        return Reading(
            value=value,
            noise=rounding(f, path),
            points=path.points[:-1],
            multipliers=(path.slope,),
            condition=Fold(self.period, path.points[:-1]),
            labels=path.labels,
            visited=path.points[:-1],
            curvature=curvature,
        )


@part
@dataclass(frozen=True)
class Flip:
    """An orbit with multiplier -1: multiplier + 1 along the orbit."""

    period: int
    points: tuple[float, ...]  # where the orbit was last

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` where the orbit is gone."""
        orbit = follow_orbit(f, self.points)
        return Reading(
            value=orbit.slope + 1.0,
            noise=multiplier_noise(f, orbit),
            points=orbit.points,
            multipliers=(orbit.slope,),
            condition=Flip(self.period, orbit.points),
            labels=orbit.labels,
            visited=orbit.points,
        )


@part
@dataclass(frozen=True)
class Crossing:
    """Two curves of orbits that cross: transcritical, or a pitchfork.

    There g = f^p(x) - x is zero, and stationary in x and in the parameter. The two derivatives are
    solved for, which is a regular problem; who has solved it looks whether g is zero.
    """

    period: int
    points: tuple[float, ...]  # where the orbit was last
    parameter: str  # that varies

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` where f^p is nowhere stationary in it."""
        if not isinstance(f, MapFamily):
            raise ConditionLost("a map without parameters: no two curves of orbits can cross")
        found = stationary_in_parameter(f, self.period, self.points[0], self.parameter)
        points = found.path.points[:-1]
        return Reading(
            value=found.path.slope - 1.0,
            noise=found.noise,
            points=points,
            multipliers=(found.path.slope,),
            condition=Crossing(self.period, points, self.parameter),
            labels=found.path.labels,
            visited=points,
            path=found.path.points,
            curvature=found.curvature,
            mixed=found.mixed,
        )


@part
@dataclass(frozen=True)
class Collision:
    """An orbit with a point on a border, f^p(c±) - c; superstable at a turning point."""

    period: int
    border: Critical
    side: int  # -1: c is approached from the left, 1: from the right

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` without the border, or its images."""
        border = self.border.at(f)
        paths = {side: path_from(f, border, side, self.period) for side in (-1, 1)}
        path = paths[self.side]
        if not path.complete:
            raise ConditionLost(path.end_reason(border))
        return Reading(
            value=path.points[-1] - border.x,
            noise=rounding(f, path, border.uncertainty),
            points=path.points[:-1],
            multipliers=(paths[-1].slope, paths[1].slope),
            condition=Collision(self.period, border.critical, self.side),
            labels=path.labels,
            visited=path.points[1:-1],
            critical=border,
        )


@part
@dataclass(frozen=True)
class Connection:
    """An image of a critical point on an unstable orbit u (homoclinic): f^k(c±) - u.

    Crises and band mergings are of this kind.
    """

    critical: Critical
    side: int  # of the border, -1 or 1; of no account at a turning point
    k: int  # applications of the map
    # the unstable orbit in the map's order; its first point is the one that is met
    points: tuple[float, ...]

    @property
    def period(self) -> int:
        """Period of the unstable orbit."""
        return len(self.points)

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` without c, u, or an image of c."""
        critical = self.critical.at(f)
        path = path_from(f, critical, self.side, self.k)
        if not path.complete:
            raise ConditionLost(path.end_reason(critical))
        orbit = follow_orbit(f, self.points)
        return Reading(
            value=path.points[-1] - orbit.points[0],
            noise=rounding(f, path, critical.uncertainty) + orbit.error,
            points=orbit.points,
            multipliers=(orbit.slope,),
            condition=Connection(critical.critical, self.side, self.k, orbit.points),
            labels=path.labels + orbit.labels,
            visited=path.points[1:-1] + orbit.points,
            critical=critical,
            path=path.points,
        )


Condition: TypeAlias = Fold | Flip | Crossing | Collision | Connection
