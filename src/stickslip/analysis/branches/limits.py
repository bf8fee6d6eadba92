"""One-sided values and slopes of a map at its breaks and at the ends of its domain.

At the last float before a break the derivative may belong to the other branch, and a square
root has lost half of its digits; so limits are taken from points inside the branch, at
distances h / 64, h, 4 h and 16 h with h the resolution (less in a narrow branch).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.branches.mesh import Nodes, Prober
    from stickslip.analysis.maps.protocol import Floats

CLOSEST: Final = 1 / 64  # of h: the point that the value is taken from
ROOM: Final = 1 / 64  # h is at most this share of the branch
STEEPENS: Final = 1.5  # growth of the slope from 4 h to h beyond which it diverges
ROUNDING: Final = 1e-14  # of the range of values: the value at the break itself is as good
SAME_SLOPE: Final = 1e-6  # of the slopes: the slope at the break is the branch's own, and exact
SINGULAR_ROUNDING: Final = 1e-11  # likewise at an infinite slope, where limits are less sharp


@dataclass(frozen=True)
class Limits:
    """One-sided limits, shapes (n,); NaN beside a gap. Infinite slopes carry their sign."""

    value: Floats
    slope: Floats

    def moved(self, shift: Floats) -> Limits:
        """Return the limits at points a few ulp further on; infinite slopes stay put."""
        with np.errstate(invalid="ignore"):
            step = np.where(np.isfinite(self.slope), self.slope * shift, 0.0)
        return Limits(self.value + step, self.slope)

    def take(self, index: slice) -> Limits:
        """Return some of the limits."""
        return Limits(self.value[index], self.slope[index])


def limits_inside(mesh: Prober, ends: Nodes, inward: Floats, room: Floats) -> Limits:
    """Extrapolate value and slope to the last points of branches of width ``room``."""
    if not ends.ok.all():
        return _beside_gaps(mesh, ends, inward, room)
    n = len(ends)
    h = np.minimum(mesh.resolution, ROOM * room)
    h = np.maximum(h, 64 * np.spacing(np.abs(ends.x)))
    x = np.concatenate([ends.x + inward * k * h for k in (CLOSEST, 1.0, 4.0, 16.0)])
    lo, hi = mesh.f.domain
    inside = mesh.probe(np.clip(x, lo, hi))
    close, near, far, farther = (inside.take(slice(i * n, (i + 1) * n)) for i in range(4))
    with np.errstate(all="ignore"):
        diverges = _diverges(mesh, close, near, far, h)
        value = np.where(diverges, _root_value(near, far, inward * h), _value(close, near, ends))
        regular = _slope(near, far, farther)
        slope = np.where(diverges, np.inf * np.sign(near.slope), regular)
        allowed = np.where(diverges, SINGULAR_ROUNDING, ROUNDING) * mesh.value_scale
        exact = np.abs(ends.value - value) <= allowed
        typical = mesh.slope_scale + np.abs(slope)
        as_good = np.isfinite(slope) & (np.abs(ends.slope - slope) <= SAME_SLOPE * typical)
    # NaN shows a gap too narrow for points inside.
    value = np.where(exact | np.isnan(value), ends.value, value)
    slope = np.where(as_good | np.isnan(slope), ends.slope, slope)
    return Limits(value, slope)


def _beside_gaps(mesh: Prober, ends: Nodes, inward: Floats, room: Floats) -> Limits:
    """Take limits where there are any; in gaps nothing is evaluated."""
    ok = ends.ok
    known = limits_inside(mesh, ends.take(ok), inward[ok], room[ok])
    value, slope = np.full(len(ends), np.nan), np.full(len(ends), np.nan)
    value[ok], slope[ok] = known.value, known.slope
    return Limits(value, slope)


def _value(close: Nodes, near: Nodes, ends: Nodes) -> Floats:
    """Extrapolate linearly over h / 64 with the slope at h."""
    value: Floats = close.value + near.slope * (ends.x - close.x)
    return value


def _slope(near: Nodes, far: Nodes, farther: Nodes) -> Floats:
    """Extrapolate s0 + a sqrt(h) + b h, which suits both sides of a graze, from h, 4 h, 16 h."""
    slope: Floats = (8 * near.slope - 6 * far.slope + farther.slope) / 3
    return slope


def _diverges(mesh: Prober, close: Nodes, near: Nodes, far: Nodes, h: Floats) -> NDArray[np.bool_]:
    """Tell where the slope grows without bound, like the derivative of a root."""
    steepens = (np.abs(near.slope) > STEEPENS * np.abs(far.slope)) & (
        np.abs(close.slope) > STEEPENS**3 * np.abs(near.slope)
    )
    # A slope that rises from (almost) 0 steepens too, but not to anything.
    return steepens & (np.abs(close.slope) > mesh.slope_scale)


def _root_value(near: Nodes, far: Nodes, h: Floats) -> Floats:
    """Extrapolate c0 + c1 |h|^q + c2 h from h and 4 h; q from the slopes, 1/2 if close to it."""
    exponent = 1 - np.log(near.slope / far.slope) / np.log(4.0)
    exponent = np.where(np.abs(exponent - 0.5) < 0.02, 0.5, exponent)
    first = near.value - near.slope * h / exponent
    second = far.value - far.slope * 4 * h / exponent
    return (4 * first - second) / 3
