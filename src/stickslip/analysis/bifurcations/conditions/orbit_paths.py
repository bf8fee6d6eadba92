"""Images of a point with their slopes, and orbits followed into a changed map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np

from stickslip.analysis.branches.along.tracked import ConditionLost, CriticalReading
from stickslip.analysis.maps.protocol import Map1D, advance, domain_width, sample
from stickslip.analysis.orbits.newton import MAX_NEWTON, ROUNDINGS, SAME, polish_on
from stickslip.numerics.arrays import EPS

Others: TypeAlias = "Mapping[int, tuple[CriticalReading, int]]"

STEP: Final = 1e-7  # of the domain: derivatives are differences over it, Taylor's formula holds
FINEST: Final = 1e-11  # of the domain: ... or at least this far, where that is needed
SLOW: Final = 0.1  # reduction of the error by one step that tells of a good second derivative
SHARP: Final = 1e-15  # of the domain: a step so short, or what one adds to f^p(x) - x, is rounding
FARTHEST: Final = 0.02  # of the domain: longest step of Newton's method


@dataclass(frozen=True)
class Path:
    """A point and its images, as far as there are any."""

    points: tuple[float, ...]  # n + 1
    slopes: tuple[float, ...]  # of the map at all points but the last
    labels: tuple[int, ...]  # of the points that the map was evaluated at
    complete: bool  # all images exist
    error: float = 0.0  # bound of the points' errors, where these were solved for
    off: tuple[float, float] = (0.0, 0.0)  # of a critical point: its uncertainty, and its value's

    @property
    def slope(self) -> float:
        """Of the power of the map, NaN if an image is missing."""
        return math.prod(self.slopes) if self.complete else math.nan

    def all_from(self, border: CriticalReading) -> Path:
        """Return the path of a critical point, or raise `ConditionLost` where its images end."""
        if self.complete:
            return self
        n, where = len(self.points) - 1, f"the {border.kind} at {border.x:.12g}"
        if n == 0:
            raise ConditionLost(f"{where} has no value on that side")
        what = f"image {n} of {where}, {self.points[-1]:.12g}"
        raise ConditionLost(f"{what}, has left the domain or lies in a gap")


def path_from(
    f: Map1D, critical: CriticalReading, side: int, n: int, others: Others = MappingProxyType({})
) -> Path:
    """Apply a map ``n`` times to one side of a critical point."""
    # ``others``: breaks that the path meets, with the side that it stays on, by the image's number.
    value = critical.value(side)
    if not math.isfinite(value):
        return Path((critical.x,), (), (), False)
    rest = path_of(f, value, n - 1, {k - 1: other for k, other in others.items()})
    points, slopes = (critical.x, *rest.points), (critical.slope(side), *rest.slopes)
    off = critical.uncertainty, critical.scatter[side > 0]
    return Path(points, slopes, rest.labels, rest.complete, off=off)


def path_of(f: Map1D, x: float, n: int, others: Others = MappingProxyType({})) -> Path:
    """Apply a map ``n`` times to a point, as far as there are values."""
    points, slopes, labels = [x], list[float](), list[int]()
    while len(slopes) < n and math.isfinite(points[-1]):
        k = len(slopes)
        if k in others and others[k][0].is_beyond(others[k][1], points[-1]):
            border, side = others[k]
            points.append(border.continued(side, points[-1]))
            slopes.append(border.slope(side))
            labels.append(border.label(side))
            continue
        # On to where another break may be met, all at once.
        stop = min((other for other in others if other > k), default=n)
        way = advance(f, np.array(points[-1:]), min(stop, n) - k)[0]
        step = sample(f, np.array([points[-1], *way[1:-1]]))
        points += way[1:].tolist()
        slopes += step.derivative.tolist()
        labels += step.label.tolist()
    known = next((k for k, point in enumerate(points) if not math.isfinite(point)), len(points))
    last = known - 1
    return Path(tuple(points[:known]), tuple(slopes[:last]), tuple(labels[:last]), last >= n)


def rounding(f: Map1D, path: Path, aside: float = 0.0) -> float:
    """Estimate the rounding at the end of a path, where its start may be off by so much more."""
    whole = getattr(f, "whole", f)
    # Of one value, by the map's own word if it has one.
    accuracy = getattr(whole, "accuracy", None)
    accuracy = ROUNDINGS * EPS * domain_width(whole) if accuracy is None else float(accuracy)
    carried, error, (position, scatter) = 1.0, 0.0, path.off
    for k, slope in reversed([*enumerate(path.slopes)]):
        error += (accuracy if k else accuracy + scatter) * carried
        # An infinite slope carries nothing on: the value beside it is a limit.
        carried *= abs(slope) if math.isfinite(slope) else 1.0
    return error + (position + aside + float(np.spacing(abs(path.points[0])))) * (1.0 + carried)


# ---------------------------------------------------------------- periodic orbits


def multiplier_noise(f: Map1D, orbit: Path) -> float:
    """Estimate the rounding in a multiplier: in each slope, and by the points' errors."""
    scale, x = domain_width(getattr(f, "whole", f)), np.array(orbit.points[:-1])
    h, same = STEP * scale, np.zeros(len(x), dtype=np.bool_)
    while h >= FINEST * scale and not same.all():  # its branch is narrow
        beside = sample(f, x + h)
        same = beside.label == np.array(orbit.labels, dtype=np.uint64)
        with np.errstate(all="ignore"):
            bends = np.abs(beside.derivative / np.array(orbit.slopes) - 1.0) / h
        h *= 0.1
    # Across a break, or beside a slope of zero, this says nothing.
    known = np.where(same & np.isfinite(bends), bends, 0.0)
    relative = ROUNDINGS * EPS + np.maximum(orbit.error, np.spacing(np.abs(x))) * known
    return float(abs(orbit.slope) * relative.sum())


def follow_orbit(f: Map1D, points: tuple[float, ...]) -> Path:
    """Find the orbit close to where it was in another map, or raise `ConditionLost`."""
    scale = domain_width(getattr(f, "whole", f))
    found = polish_on(f, np.array([points]), scale)
    if not found.converged[0]:
        raise ConditionLost(f"the orbit of period {len(points)} at {points[0]:.12g} is gone")
    x = found.points[0]
    if len(x) > 1 and np.min(np.abs(x[1:] - x[0])) <= SAME * scale:
        raise ConditionLost(f"the orbit of period {len(points)} has become one of a shorter period")
    slopes, labels = tuple(found.slopes[0].tolist()), tuple(found.labels[0].tolist())
    return Path((*x.tolist(), float(x[0])), slopes, labels, True, float(found.error.max()))


def where_slope_is(wanted: float, f: Map1D, p: int, x: float) -> tuple[Path, float, float]:
    """Find where f^p has a slope near x: path, (f^p)'' and the sharp f^p(x) - x there."""
    scale = domain_width(getattr(f, "whole", f))
    h, last, start = STEP * scale, math.inf, x
    for _ in range(MAX_NEWTON):
        try:
            path, slope, curvature = bend(f, p, x, h)
        except ConditionLost:
            if h <= FINEST * scale:
                raise
            h = max(0.1 * h, FINEST * scale)  # its branch is narrow
            continue
        off = wanted - slope
        step = off / curvature if curvature != 0 else math.inf
        # Where f^p bends sharply even a small step matters to the value.
        if abs(step) <= STEP * scale and abs(off * step) <= SHARP * scale:
            rise = wanted - 1.0 - 0.5 * off  # of f^p(x) - x, along the step
            value = path.points[-1] - path.points[0] + rise * step
            # The start of the path moves a little, and its images with it.
            shifts = step * np.cumprod([1.0, *path.slopes])
            points = tuple((np.array(path.points) + shifts).tolist())
            return replace(path, points=points), curvature, value
        if abs(off) > SLOW * last:
            h = max(0.1 * h, FINEST * scale)  # f^p bends on a smaller scale than that
        if abs(off) > last:
            x = start  # ... and this was too far
            continue
        if not abs(step) < FARTHEST * scale:
            break
        last, start = abs(off), x
        x += step
    raise ConditionLost(f"the slope of f^{p} is not {wanted:g} near {x:.12g}")


def bend(f: Map1D, p: int, x: float, h: float) -> tuple[Path, float, float]:
    """Path of x, slope and second derivative of f^p there: a difference of slopes ``h`` apart."""
    # One-sided beside a break; `ConditionLost` with breaks on both sides, or without an image.
    points = np.array([x - h, x, x + h])
    slopes, labels, centre = np.ones(3), [], [float(x)]
    centre_slopes: list[float] = []
    usable = np.ones(3, dtype=bool)
    for _ in range(p):
        step = sample(f, points)
        usable &= np.isfinite(step.value) & (step.label == step.label[1])
        points, slopes = step.value, slopes * step.derivative
        labels.append(int(step.label[1]))
        centre.append(float(points[1]))
        centre_slopes.append(float(step.derivative[1]))
    if not usable[1] or not usable[[0, 2]].any():
        raise ConditionLost(f"f^{p} is not smooth beside {x:.12g}")
    first, last = (0 if usable[0] else 1), (2 if usable[2] else 1)
    curvature = float(slopes[last] - slopes[first]) / ((last - first) * h)
    path = Path(tuple(centre), tuple(centre_slopes), tuple(labels), True)
    return path, float(slopes[1]), curvature
