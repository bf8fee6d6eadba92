"""Where the images of a point do not depend on a parameter to first order.

A curve of periodic orbits, f^p(x) = x in the plane of x and a parameter q, crosses another one
only where f^p(x) - x is stationary in both. Where its derivative with respect to q vanishes is
an ordinary problem in x there, unlike f^p(x) = x itself, whose slope is zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.conditions.orbit_paths import Path
from stickslip.analysis.branches.along.borders import ConditionLost
from stickslip.analysis.maps.protocol import domain_width, sample

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats, MapFamily

EPS: Final = float(np.finfo(np.float64).eps)
STEP: Final = 1e-7  # of the domain: differences are taken so far apart
NEARBY: Final = 1e-3  # of the domain: no stationary point is looked for further away
SETTLED: Final = 1e-15  # of the domain: a shorter step is rounding
ROUNDINGS: Final = 4.0  # of each value and derivative
MAX_NEWTON: Final = 20


@dataclass(frozen=True)
class Stationary:
    """A point x where d f^p(x) / dq is zero."""

    path: Path  # of x
    curvature: float  # (f^p)'' there
    mixed: float  # derivative of (f^p)' with respect to the parameter
    noise: float  # rounding in (f^p)', and what the rounding of x makes of it


def stationary_in_parameter(f: MapFamily, p: int, x: float, name: str) -> Stationary:
    """Find x nearby whose p-th image is stationary in a parameter, or raise `ConditionLost`."""
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
        if abs(step) <= SETTLED * scale or abs(step) >= 0.5 * abs(last):
            shift = ROUNDINGS * EPS * size / abs(mixed) + float(np.spacing(abs(x)))
            noise = ROUNDINGS * EPS * p * abs(path.slope) + abs(curvature) * shift
            return Stationary(path, curvature, mixed, noise)
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
