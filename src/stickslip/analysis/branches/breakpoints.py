"""Breakpoints: where the branches of a map end, and how; one-sided values and slopes there.

Limits are taken inside the branch: at the last float a square root has lost half of its digits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.branches.discontinuities import BEND, STEP, rounding_of_points
from stickslip.analysis.branches.mesh import Mesh, Nodes, finest
from stickslip.numerics.arrays import Columns
from stickslip.results.result import ResultRow

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.tracked import NearDiscontinuity
    from stickslip.analysis.maps.protocol import Bools, Floats, Map1D

    # What limits are taken from: a map that can be evaluated, and its scales.
    Prober: TypeAlias = Mesh | NearDiscontinuity

CLOSEST: Final = 1 / 64  # of h: the point that the value is taken from
ROOM: Final = 1 / 64  # h is at most this share of the branch
STEEPENS: Final = 1.5  # growth of the slope from 4 h to h beyond which it diverges
ROUNDING: Final = 1e-14  # of the range of values: the value at the break itself is as good
SINGULAR_ROUNDING: Final = 1e-11  # likewise at an infinite slope, where limits are less sharp
SLOW: Final = 0.1  # power of the distance to a break: a smaller one is as slow as a logarithm
Kind: TypeAlias = Literal["jump", "corner", "smooth", "edge"]


@dataclass(frozen=True)
class Limits(Columns):
    """One-sided limits, shapes (n,); NaN beside a gap. Infinite slopes carry their sign."""

    value: Floats
    slope: Floats
    scatter: Floats  # by which the value of a logarithm changes from float to float; else 0

    def moved(self, shift: Floats) -> Limits:
        """Return the limits at points a few ulp further on; infinite slopes stay put."""
        with np.errstate(invalid="ignore"):
            step = np.where(np.isfinite(self.slope), self.slope * shift, 0.0)
        return Limits(self.value + step, self.slope, self.scatter)


def limits_inside(mesh: Prober, ends: Nodes, inward: Floats, room: Floats) -> Limits:
    """Extrapolate value and slope to ends of branches, ``inward`` +1 for a branch right of it."""
    if not (ok := ends.ok).all():  # in gaps nothing is evaluated
        limits = Limits(*np.full((3, len(ends)), np.nan))
        known = limits_inside(mesh, ends.take(ok), inward[ok], room[ok])
        limits.put(ok, known)
        return limits
    # Where less is resolved limits are no less sharp.
    h = np.minimum(min(mesh.resolution, finest(mesh.f)), ROOM * room)
    smallest = 64 * np.spacing(np.abs(ends.x))
    h = np.maximum(h, smallest)
    limits, off = _limits_from(mesh, ends, inward, h)
    # Branches that bend on a scale of less than h are asked closer by, while that helps.
    (at,) = np.nonzero((off > BEND) & (h > smallest))
    while at.size:
        h[at] = np.maximum(CLOSEST * h[at], smallest[at])
        closer, still_off = _limits_from(mesh, ends.take(at), inward[at], h[at])
        better = still_off < off[at]
        at, closer, still_off = at[better], closer.take(better), still_off[better]
        limits.put(at, closer)
        off[at] = still_off
        at = at[(still_off > BEND) & (h[at] > smallest[at])]
    return limits


def _limits_from(mesh: Prober, ends: Nodes, inward: Floats, h: Floats) -> tuple[Limits, Floats]:
    """Extrapolate from points h inside; return how far off the slope there is, of the slopes."""
    n = len(ends)
    x = np.concatenate([ends.x + inward * k * h for k in (CLOSEST, 1.0, 4.0, 16.0)])
    lo, hi = mesh.f.domain
    x = np.clip(x, lo, hi)
    # Close, near, far and farther points of each end.
    values, slopes = (inside.reshape(4, n) for inside in mesh.slopes(x))
    with np.errstate(all="ignore"):
        diverges = _diverges(mesh, slopes)
        # s0 + a sqrt(h) + b h suits both sides of a graze; its mean up to the close point is known,
        # and what it foretells of the slope there tells whether it holds.
        regular = (8 * slopes[1] - 6 * slopes[2] + slopes[3]) / 3
        plain = values[0] + (2 * slopes[0] + regular) / 3 * (ends.x - x[:n])
        root = _root_value(values, slopes, inward * h)
        scatter = np.where(diverges & np.isnan(root), np.abs(slopes[1] * h), 0.0)
        value = np.where(diverges, root, plain)
        slope = np.where(diverges, np.inf * np.sign(slopes[1]), regular)
        allowed = np.where(diverges, SINGULAR_ROUNDING, ROUNDING) * mesh.value_scale
        exact = np.abs(ends.value - value) <= allowed
        typical = mesh.slope_scale + np.abs(slope)
        as_good = np.isfinite(slope) & (np.abs(ends.slope - slope) <= BEND * typical)
        at_close = (310 * slopes[1] - 217 * slopes[2] + 35 * slopes[3]) / 128
        off = np.where(diverges, 0.0, np.abs(slopes[0] - at_close) / typical)
    # NaN shows a gap too narrow for points inside.
    value = np.where(exact | np.isnan(value), ends.value, value)
    slope = np.where(as_good | np.isnan(slope), ends.slope, slope)
    return Limits(value, slope, scatter), off


def _diverges(mesh: Prober, slopes: Floats) -> Bools:
    """Tell where the slope grows without bound, like the derivative of a root."""
    close, near, far, _ = np.abs(slopes)
    steepens = (near > STEEPENS * far) & (close > STEEPENS**3 * near)
    # A power grows by the cube of that over 64 = 4^3 times the distance; exponentials do not.
    steepens &= 2 * close > near * (near / far) ** 3
    # A slope that rises from (almost) 0 steepens too, but not to anything.
    return np.asarray(steepens & (close > mesh.slope_scale))


def _root_value(values: Floats, slopes: Floats, h: Floats) -> Floats:
    """Extrapolate c0 + c1 |h|^q + c2 h from h and 4 h; q from the slopes, 1/2 if close to it.

    NaN for a pole, or a logarithm: what is known is how far values get before the end.
    """
    exponent = 1 - np.log(slopes[1] / slopes[2]) / np.log(4.0)
    exponent = np.where(np.abs(exponent - 0.5) < 0.02, 0.5, exponent)
    first = values[1] - slopes[1] * h / exponent
    second = values[2] - slopes[2] * 4 * h / exponent
    return np.where(exponent > SLOW, (4 * first - second) / 3, np.nan)


@dataclass(frozen=True, eq=False, repr=False)
class Breakpoint(ResultRow):
    """End of a branch.

    Attributes
    ----------
    d : float
        Where; the label changes between adjacent floats, of which this is one.
    left, right : float
        One-sided values of the map, NaN beside a gap.
    left_slope, right_slope : float
        One-sided slopes; an infinite one shows a square root, or a logarithm (`scatter`).
    kind : str
        ``jump``; ``corner`` (continuous, slopes differ); ``smooth`` (value and slope agree:
        the label changes and the map does not care); ``edge`` (no value on one side).
    mechanism : str
        What happens there, for who knows what the map stands for; empty here.
    block : int or None
        Block that the mechanism concerns.
    left_label, right_label : int
        Labels of the two branches; 0 beside a gap.
    interval : tuple of float
        Points on either side, adjacent floats unless several changes fell within the
        resolution.
    quality : str
        ``located``, or ``bracketed`` where the interval is wider than rounding.
    scatter : tuple of float
        By how much one-sided values change from float to float, where they have no limit that
        floats come near: beside logarithms; else 0.
    system : map or None
        The map that it is a breakpoint of; None if it was loaded without.
    """

    d: float
    left: float
    right: float
    left_slope: float
    right_slope: float
    kind: Kind
    mechanism: str = ""
    block: int | None = None
    left_label: int = field(default=0, repr=False)
    right_label: int = field(default=0, repr=False)
    interval: tuple[float, float] = field(default=(math.nan, math.nan), repr=False)
    quality: str = field(default="located", repr=False)
    scatter: tuple[float, float] = field(default=(0.0, 0.0), repr=False)
    system: Map1D | None = field(default=None, repr=False, compare=False)
    _column_names: ClassVar = (
        *("d", "left", "right", "left_slope", "right_slope", "kind", "mechanism", "block"),
        *("quality", "residual"),
    )
    _drawn: ClassVar = ("d", "left", "right")
    _has_picture: ClassVar = False

    @property
    def residual(self) -> float:
        """Width of `interval`."""
        return self.interval[1] - self.interval[0]

    @property
    def jump(self) -> float:
        """Step of the value from left to right."""
        return self.right - self.left


def kind_of(mesh: Prober, left: Limits, right: Limits, width: Floats) -> list[Kind]:
    """Classify breaks by their limits from both sides, which are ``width`` apart."""
    with np.errstate(all="ignore"):
        steepness = np.abs(left.slope) + np.abs(right.slope)
        apart = np.maximum(width, rounding_of_points(mesh.f))
        slack = np.where(np.isfinite(steepness), steepness * apart, 0.0)
        edge = np.isnan(left.value) | np.isnan(right.value)
        jump = np.abs(left.value - right.value) > STEP * mesh.value_scale + slack
        bend = np.abs(left.slope - right.slope) > BEND * (mesh.slope_scale + steepness)
    bend |= ~(np.isfinite(left.slope) & np.isfinite(right.slope))
    return [
        "edge" if is_edge else "jump" if is_jump else "corner" if is_bend else "smooth"
        for is_edge, is_jump, is_bend in zip(edge, jump, bend, strict=True)
    ]
