"""Where a jump throws orbits, and how they come back to the orbit that met it.

Past the collision by mu, f^p beside the jump is u -> a u + mu, and the way back u -> -H + b u.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import (
    clip_to_domain,
    domain_width,
    iterate,
    values_and_slopes,
)

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.maps.protocol import Floats, Map1D

OneSided: TypeAlias = "Breakpoint | CriticalReading"
Fate = Literal["returns", "settles", "leaves", "wanders"]

MAX_STEPS: Final = 20_000
CLOSE: Final = 1e-7  # of the domain's width: u is linear there, and above rounding
LEAST: Final = 1e-150  # contraction that is divided out at most: more of it leaves no number
AS_PREDICTED: Final = 0.02  # relative: the contraction beside the border against a
LONGEST_CYCLE: Final = 1024  # recognised where the far image settles
RECURS: Final = 1e-12  # of the domain's width: less than a slow approach moves when CLOSE
FIRST_LOOK: Final = 256  # steps after which to look whether the far image has settled
SHOWN: Final = 64  # images kept
MOST_AHEAD: Final = 1024  # images made at once
N_WINDOWS: Final = 10_000  # numbers n tried


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
    path: tuple[float, ...] = ()  # the first images of the jump's far side

    def window(self, n: int) -> tuple[float, float]:
        """Return the mu = f^p(c near) - c > 0 with a cycle of n p + r steps that crosses once."""
        # A_(n-1) + b <= H / mu < A_n to first order; empty: the lower end is above the upper.
        low = self.height / _growth(self.multiplier, n)
        bottom = _growth(self.multiplier, n - 1) + self.slope
        return low, self.height / bottom if bottom > 0 else math.inf

    def periods(self, mu: float) -> tuple[int, ...]:
        """Return the periods n p + r of cycles that cross once, mu past the collision."""
        found = []
        for n in range(1, N_WINDOWS):
            low, high = self.window(n)
            if low < mu <= high and abs(self.multiplier**n * self.slope) < 1:
                found.append(n * self.period + self.steps)
            if high < mu:
                break
        return tuple(found)


def _growth(a: float, n: int) -> float:
    """Return (a^-n - 1) / (1 - a), the sum of a^-k from 1 to n."""
    return float((a**-n - 1) / (1 - a))


def far_image(
    f: Map1D,
    border: OneSided,
    side: int,
    period: int,
    *,
    multiplier: float | None = None,
    max_steps: int = MAX_STEPS,
) -> FarImage:
    """Follow the far side's image of a jump, at a collision with an orbit of period p.

    ``multiplier``: of that orbit, for one that meets other breaks too; else f tells.

    >>> f = ss.PiecewiseMap(
    ...     lambda x: np.where(x < 0, 0.5 * x, -0.4 * x - 1), (-3, 3), breakpoints=[0.0])
    >>> far = far_image(f, ss.breakpoints(f)[0], side=-1, period=1)
    >>> far.fate, far.steps, round(far.height, 6), round(far.slope, 6)
    ('returns', 1, 1.0, -0.4)
    >>> far.periods(0.01)  # distance past the collision
    (7,)
    """
    if side not in (-1, 1):
        raise ValueError(f"side = {side!r} of a border: -1 (left) or 1 (right) is needed.")
    if period < 1:
        raise ValueError(f"period = {period!r} of an orbit: at least 1 is needed.")
    if multiplier is None:
        multiplier = _Walk(f, border, side, side).slope(period)
    far = _Walk(f, border, side, -side)
    look, cycle, k = FIRST_LOOK, 0, 1
    while k < max_steps and not math.isnan(far.x(k)) and not cycle:
        if far.converges(k, multiplier, period):
            return _returned(far, k, multiplier, period)
        if k >= look:
            cycle = _recurrence(far.path(k), domain_width(f))
            look *= 2
        k += 1
    local = far.local(k, period)
    path = tuple(far.path(k)[:SHOWN].tolist())
    if math.isnan(far.x(k)):
        return FarImage(period, multiplier, *local, fate="leaves", steps=k, path=path)
    fate: Fate = "settles" if cycle else "wanders"
    return FarImage(period, multiplier, *local, fate=fate, cycle=cycle, path=path)


class _Walk:
    """Images 1, 2, ... of one side of a border and their derivatives, made some at a time."""

    def __init__(self, f: Map1D, border: OneSided, near: int, start: int) -> None:
        self._f, self._near, self._width = f, near, domain_width(f)
        self._iterate = getattr(f, "iterate", partial(iterate, f))
        self._c = border.interval[0] if near < 0 else border.interval[1]
        self._x = np.array([border.left if start < 0 else border.right])
        self._slope = np.array([border.left_slope if start < 0 else border.right_slope])

    def _make(self, k: int) -> None:
        """Make the images up to k, each time as many as there are."""
        while len(self._x) < k:
            last, n = self._x[-1:], min(len(self._x), MOST_AHEAD)
            _, inside = clip_to_domain(self._f.domain, last)
            orbit = self._iterate(last, n)[0] if inside.all() else np.full(n + 1, np.nan)
            with np.errstate(over="ignore", invalid="ignore"):
                slopes = self._slope[-1] * np.cumprod(values_and_slopes(self._f, orbit[:-1])[1])
            self._x = np.concatenate([self._x, orbit[1:]])
            self._slope = np.concatenate([self._slope, slopes])

    def x(self, k: int) -> float:
        """Image k; NaN stays once the orbit has left."""
        self._make(k)
        return float(self._x[k - 1])

    def slope(self, k: int) -> float:
        """Return the derivative of f^k."""
        self._make(k)
        return float(self._slope[k - 1])

    def u(self, k: int) -> float:
        """Displacement of image k from the border, positive on the far side."""
        return -self._near * (self.x(k) - self._c)

    def path(self, k: int) -> Floats:
        """Return the first k images."""
        self._make(k)
        return self._x[:k]

    def local(self, k: int, period: int) -> tuple[float, float]:
        """Slope and height of f^p on the far side, if the first k images tell."""
        return (self.slope(period), self.u(period)) if k > period else (math.nan, math.nan)

    def converges(self, k: int, a: float, period: int) -> bool:
        """Whether image k is beside the border on the near side, and f^p contracts it by a."""
        if not (0 < a < 1 and -CLOSE * self._width < self.u(k) < 0):
            return False
        return abs(self.u(k + period) / self.u(k) - a) < AS_PREDICTED


def _returned(far: _Walk, k: int, a: float, period: int) -> FarImage:
    """Divide the contraction of whole turns beside the border out of the way back."""
    turns = min((k - 1) // period, int(math.log(LEAST) / math.log(a)))
    return FarImage(
        period,
        a,
        *far.local(k + 1, period),
        fate="returns",
        steps=k - turns * period,
        height=-far.u(k) / a**turns,
        slope=far.slope(k) / a**turns,
        path=tuple(far.path(k)[:SHOWN].tolist()),
    )


def _recurrence(orbit: Floats, width: float) -> int:
    """Return the smallest period with which an orbit's last points recur, 0 if there is none."""
    last = orbit[-2 * LONGEST_CYCLE :]

    def off(m: int) -> float:
        return float(np.abs(last[m:] - last[:-m])[-m:].max())

    for m in range(1, len(last) // 2 + 1):
        if off(m) <= RECURS * width:
            # On a slow approach from both sides, twice the period recurs more closely.
            return next(q for q in range(1, m + 1) if m % q == 0 and off(q) <= CLOSE * width)
    return 0
