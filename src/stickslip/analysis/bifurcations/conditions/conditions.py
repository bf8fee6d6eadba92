"""Bifurcations as zeros of scalar functions of a map, each with a regular problem inside.

| condition | problem inside, at given parameters | function |
|---|---|---|
| `Fold` | x with (f^p)'(x) = 1 | f^p(x) - x |
| `Flip` | the periodic orbit | multiplier + 1 |
| `SteepFlip` | x with (f^p)'(x) = -1 | f^p(x) - x |
| `Crossing` | x where d f^p(x) / dq = 0 | (f^p)'(x) - 1 |
| `Collision` | the border c | f^p(c-) - c or f^p(c+) - c; of several borders at once, the first |
| `Connection` | the critical point c, the unstable orbit u | f^k(c) - u |
| `Contact` | the critical point c, the break b or an end of the domain | f^k(c) - b |
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.orbit_paths import (
    SHARP,
    STEP,
    Path,
    follow_orbit,
    multiplier_noise,
    path_from,
    rounding,
    where_slope_is,
)
from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd, TrackedDiscontinuity
from stickslip.analysis.maps.protocol import Floats, Map1D, MapFamily, domain_width, sample
from stickslip.analysis.orbits.newton import MAX_NEWTON, ROUNDINGS
from stickslip.numerics.arrays import EPS
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.tracked import Critical, CriticalReading

NEARBY: Final = 1e-3  # of the domain: no stationary point is looked for further away


def stationary_in_parameter(
    f: MapFamily, p: int, x: float, name: str
) -> tuple[Path, float, float, float]:
    """Find x nearby with d f^p(x) / dq = 0: path, (f^p)'', d (f^p)' / dq, and noise of (f^p)'."""
    scale = domain_width(getattr(f, "whole", f))
    start, h, last = x, STEP * scale, math.inf
    lo, hi = f.domain
    for _ in range(MAX_NEWTON):
        x = min(max(x, lo), hi)
        # At an end of the domain differences are one-sided.
        points = np.array([max(x - h, lo), x, min(x + h, hi)])
        path, slopes, rates, size = _images(f, p, points, name)
        apart = float(points[2] - points[0])
        mixed, curvature = (float(v[2] - v[0]) / apart for v in (rates, slopes))
        step = -float(rates[1]) / mixed if mixed != 0 else math.inf
        if not abs(x + step - start) <= NEARBY * scale:
            break
        if abs(step) <= SHARP * scale or abs(step) >= 0.5 * abs(last):
            shift = ROUNDINGS * EPS * size / abs(mixed) + float(np.spacing(abs(x)))
            noise = ROUNDINGS * EPS * p * abs(path.slope) + abs(curvature) * shift
            return path, curvature, mixed, noise
        x, last = x + step, step
    raise ConditionLost(f"f^{p} is nowhere stationary in {name} near {start:.12g}")


def _images(f: MapFamily, p: int, points: Floats, name: str) -> tuple[Path, Floats, Floats, float]:
    """Path of the second of three points; slopes and rates of f^p; the size of a rate's terms."""
    x = float(points[1])
    slopes, rates, size = np.ones(3), np.zeros(3), 0.0
    centre, centre_slopes, labels = [x], [], []
    for _ in range(p):
        here = sample(f, points)
        if not (np.isfinite(here.value).all() and (here.label == here.label[1]).all()):
            raise ConditionLost(f"f^{p} is not smooth beside {x:.12g}")
        own = np.asarray(f.parameter_derivative(points, name), dtype=np.float64)
        size = abs(own[1]) + abs(here.derivative[1]) * (size + abs(rates[1]) + abs(points[1]))
        rates = own + here.derivative * rates
        slopes = slopes * here.derivative
        points = here.value
        centre.append(float(points[1]))
        centre_slopes.append(float(here.derivative[1]))
        labels.append(int(here.label[1]))
    return Path(tuple(centre), tuple(centre_slopes), tuple(labels), True), slopes, rates, size


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
    critical: CriticalReading | None = None
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
        return fold_reading(f, *where_slope_is(1.0, f, self.period, self.points[0]))


def fold_reading(f: Map1D, path: Path, curvature: float, value: float) -> Reading:
    """Describe an orbit where (f^p)' is 1, or nearly so, by its path and f^p(x) - x."""
    fold = Fold(len(path.slopes), path.points[:-1])
    return _along_orbit(fold, path, value, rounding(f, path), curvature=curvature)


def _along_orbit(
    condition: Fold | Flip | Crossing, orbit: Path, value: float, noise: float, **more: Any
) -> Reading:
    """Describe an orbit and a condition on it alone, which starts from there."""
    points = orbit.points[:-1]
    return Reading(
        value=value,
        noise=noise,
        points=points,
        multipliers=(orbit.slope,),
        condition=replace(condition, points=points),
        labels=orbit.labels,
        visited=points,
        **more,
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
        return _along_orbit(self, orbit, orbit.slope + 1.0, multiplier_noise(f, orbit))


@part
@dataclass(frozen=True)
class SteepFlip(Flip):
    """A flip so close to a fold that the multiplier is noise: f^p(x) - x where (f^p)'(x) = -1."""

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` where (f^p)' is not -1 anywhere nearby."""
        path, curvature, value = where_slope_is(-1.0, f, self.period, self.points[0])
        return _along_orbit(self, path, value, rounding(f, path), curvature=curvature)


@part
@dataclass(frozen=True)
class Crossing:
    """Two curves of orbits that cross: transcritical, or a pitchfork."""

    # The caller looks whether f^p(x) - x, stationary in x and in the parameter, is zero.

    period: int
    points: tuple[float, ...]  # where the orbit was last
    parameter: str  # that varies

    def at(self, f: Any) -> Reading:
        """Evaluate the test function; `ConditionLost` where f^p is nowhere stationary in it."""
        where = self.period, self.points[0], self.parameter
        path, curvature, mixed, noise = stationary_in_parameter(f, *where)
        more = {"path": path.points, "curvature": curvature, "mixed": mixed}
        return _along_orbit(self, path, path.slope - 1.0, noise, **more)


@part
@dataclass(frozen=True)
class Meeting:
    """A break that another point of a colliding orbit meets at the same value of the parameter."""

    place: int  # of that point: images of the first border
    border: Critical
    side: int  # from which the break is met


@part
@dataclass(frozen=True)
class Collision:
    """An orbit with a point on a border, f^p(c±) - c, beyond which the orbit is virtual."""

    period: int
    border: Critical  # at a turning point the orbit is superstable
    side: int  # -1: c is approached from the left, 1: from the right
    # where a symmetry makes several collisions one condition: the rest (`solve_together`)
    others: tuple[Meeting, ...] = ()

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` without a border, or its images."""
        border = self.border.at(f)
        met = {other.place: (other.border.at(f), other.side) for other in self.others}
        # Where breaks are corners, the path on the far side comes past all of them.
        crossed = {
            k: (b, -side) for k, (b, side) in met.items() if b.kind == border.kind == "corner"
        }
        paths = {
            side: path_from(f, border, side, self.period, met if side == self.side else crossed)
            for side in (-1, 1)
        }
        path = paths[self.side].all_from(border)
        others = tuple(replace(other, border=met[other.place][0].critical) for other in self.others)
        return Reading(
            value=path.points[-1] - border.x,
            noise=rounding(f, path),
            points=path.points[:-1],
            multipliers=(paths[-1].slope, paths[1].slope),
            condition=Collision(self.period, border.critical, self.side, others),
            labels=path.labels,
            visited=path.points[1:-1],
            critical=border,
        )


@part
@dataclass(frozen=True)
class Connection:
    """An image of a critical point on an unstable orbit u, f^k(c±) - u: crises, band mergings."""

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
        path = path_from(f, critical, self.side, self.k).all_from(critical)
        orbit = follow_orbit(f, self.points)
        points = orbit.points[:-1]
        return Reading(
            value=path.points[-1] - points[0],
            noise=rounding(f, path) + orbit.error,
            points=points,
            multipliers=(orbit.slope,),
            condition=Connection(critical.critical, self.side, self.k, points),
            labels=path.labels + orbit.labels,
            visited=path.points[1:-1] + points,
            critical=critical,
            path=path.points,
        )


@part
@dataclass(frozen=True)
class Contact:
    """An image of a critical point on a break b or an end of the domain, f^k(c±) - b: crises."""

    critical: Critical
    side: int  # of the critical point, -1 or 1; of no account at a turning point
    k: int  # applications of the map
    border: TrackedDiscontinuity | DomainEnd
    period: ClassVar = 0  # no orbit is concerned

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` without c, b, or an image of c."""
        critical, border = self.critical.at(f), self.border.at(f)
        path = path_from(f, critical, self.side, self.k).all_from(critical)
        met = border.critical
        assert isinstance(met, TrackedDiscontinuity | DomainEnd)
        return Reading(
            value=path.points[-1] - border.x,
            noise=rounding(f, path, border.uncertainty),
            points=(border.x,),
            multipliers=(math.nan,),
            condition=Contact(critical.critical, self.side, self.k, met),
            labels=path.labels,
            visited=path.points[1:-1],
            critical=critical,
            path=path.points,
        )


Condition: TypeAlias = Fold | Flip | Crossing | Collision | Connection | Contact
