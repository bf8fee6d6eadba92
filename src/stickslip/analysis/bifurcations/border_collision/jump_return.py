"""Where a jump throws orbits, and how they come back to the orbit that met it.

Past the collision by mu, f^p beside the jump is u -> a u + mu, and the way back u -> -H + b u.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.attractors.attractors import MAX_STEPS
from stickslip.analysis.attractors.search import LAST_PERIODS
from stickslip.analysis.maps.protocol import SAME, advance, domain_width, values_and_slopes
from stickslip.analysis.scales import BLOCK, HALF_DIGITS

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.maps.protocol import Floats, Map1D

OneSided: TypeAlias = "Breakpoint | CriticalReading"
Fate = Literal["returns", "settles", "leaves", "wanders"]

# Contraction that is divided out at most: more of it leaves no number.
LEAST: Final = math.sqrt(sys.float_info.min)
AS_PREDICTED: Final = 0.02  # relative: the contraction beside the border against a
NONE: Final = (math.nan, math.nan)


@dataclass(frozen=True)
class FarImage:
    """What becomes of the far side's image of a jump, at a collision of an orbit with it."""

    # Displacements u from the jump are positive on the far side.

    period: int  # p, of the orbit that meets the jump
    multiplier: float  # a, of that orbit: slope of f^p on the near side
    local_slope: float  # of f^p on the far side: the b of the jump's normal form
    local_height: float  # displacement f^p(c far) - c: the l of the jump's normal form
    fate: Fate
    steps: int = 0  # r, if it returns: the offset of the periods, 1 <= r <= p; if it leaves: when
    height: float = math.nan  # H > 0, if it returns: near 0 the way back is u -> -H + b u
    slope: float = math.nan  # b of the way back
    cycle: int = 0  # period of the cycle on which it settles


def far_image(
    f: Map1D, border: OneSided, side: int, period: int, *, multiplier: float | None = None
) -> FarImage:
    """Follow the far side's image of a jump, at a collision with an orbit of period p.

    ``multiplier``: of that orbit, for one that meets other breaks too; else f tells.

    >>> f = ss.PiecewiseMap(
    ...     lambda x: np.where(x < 0, 0.5 * x, -0.4 * x - 1), (-3, 3), breakpoints=[0.0])
    >>> far = far_image(f, ss.breakpoints(f)[0], side=-1, period=1)
    >>> far.fate, far.steps, round(far.height, 6), round(far.slope, 6)
    ('returns', 1, 1.0, -0.4)
    """
    if multiplier is None:
        multiplier = near_multiplier(f, border, side, period)
    width, edge = domain_width(f), border.interval[0 if side < 0 else 1]
    n = max(BLOCK, 2 * period)
    x = _followed(f, _image(border, -side), n)
    local = _slope(f, border, -side, x[:period]), float(-side * (x[period - 1] - edge))
    image = partial(FarImage, period, multiplier, *(local if local[1] == local[1] else NONE))
    while True:
        u = -side * (x - edge)
        k = _first_beside(u, multiplier, period, HALF_DIGITS * width)
        if k is not None:
            # The contraction of whole turns beside the border is not the way back's.
            turns = min(k // period, int(math.log(LEAST) / math.log(multiplier)))
            slope = _slope(f, border, -side, x[: k + 1]) / multiplier**turns
            height = -float(u[k]) / multiplier**turns
            return image("returns", k + 1 - turns * period, height, slope)
        if np.isnan(x).any():
            return image("leaves", int(np.isnan(x).argmax()) + 1)
        if cycle := _recurrence(x, width):
            return image("settles", cycle=cycle)
        if n == MAX_STEPS:
            return image("wanders")
        n = min(2 * n, MAX_STEPS)
        x = _followed(f, x, n)


def near_multiplier(f: Map1D, border: OneSided, side: int, period: int) -> float:
    """Return the slope of f^p on one side of a border."""
    return _slope(f, border, side, _followed(f, _image(border, side), period))


def _image(border: OneSided, side: int) -> Floats:
    return np.array([border.left if side < 0 else border.right])


def _followed(f: Map1D, x: Floats, n: int) -> Floats:
    """Lengthen an orbit to n points, NaN once it has left."""
    return np.append(x, advance(f, x[-1:], n - len(x))[0, 1:])


def _slope(f: Map1D, border: OneSided, side: int, x: Floats) -> float:
    """Return the slope of a power of f on one side of a border, whose images up to it are x."""
    slope = border.left_slope if side < 0 else border.right_slope
    with np.errstate(over="ignore", invalid="ignore"):
        return float(slope * np.cumprod(np.append(1.0, values_and_slopes(f, x[:-1])[1]))[-1])


def _first_beside(u: Floats, a: float, period: int, close: float) -> int | None:
    """Find the first displacement, near and negative, that f^p contracts by a; None if none is."""
    if not 0 < a < 1:
        return None
    here, later = u[:-period], u[period:]
    with np.errstate(all="ignore"):
        beside = (-close < here) & (here < 0) & (np.abs(later / here - a) < AS_PREDICTED)
    return int(beside.argmax()) if beside.any() else None


def _recurrence(orbit: Floats, width: float) -> int:
    """Return the smallest period with which an orbit's last points recur, 0 if there is none."""
    last = orbit[-2 * LAST_PERIODS :]

    def off(m: int) -> float:
        return float(np.abs(last[m:] - last[:-m])[-m:].max())

    for m in range(1, len(last) // 2 + 1):
        if off(m) <= SAME * width:  # less than a slow approach moves when so close
            # On a slow approach from both sides, twice the period recurs more closely.
            return next(q for q in range(1, m + 1) if m % q == 0 and off(q) <= HALF_DIGITS * width)
    return 0
