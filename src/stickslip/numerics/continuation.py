"""Curves F(y) = 0, one unknown more than equations, followed by pseudo-arclength.

The last unknown is the parameter. Lengths and angles are those of ``y / scale``, so that the
caller decides what is far. Knows neither maps nor blocks.

Keller (1977); Allgower and Georg, Introduction to Numerical Continuation Methods (2003),
chapters 2 and 6; Seydel, Practical Bifurcation and Stability Analysis (2010), chapter 4.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.zeros import zero_between

Floats: TypeAlias = NDArray[np.float64]
Equations: TypeAlias = Callable[[Floats], tuple[Floats, Floats, Any]]

STALLED: Final = 1e-8  # scaled Newton steps this small that do not shrink are rounding
NOISE: Final = 1e-11  # scaled Newton steps this small that shrink less than foreseen are, too
UNFORESEEN: Final = 16.0  # times the step that quadratic convergence foretells
CONTRACTS: Final = 0.5  # each Newton step at most this share of the one before
FIRST_SHARE: Final = 0.5  # of the step along the curve: a longer correction mistrusts the guess
CALM: Final = 4  # steps in a row after which one that left the region is forgotten


class StepTooLong(Exception):
    """A step that has to be tried again at half its length: no convergence, or a sharp bend."""


class LeavesRegion(Exception):
    """Raised by equations where F is no longer the smooth function that is followed."""

    def __init__(self, cause: Any = None) -> None:
        super().__init__(cause)
        self.cause = cause


class _BeyondRangeError(StepTooLong):
    """A point outside the range of the parameter, where F is never evaluated."""


@dataclass(frozen=True, eq=False)
class CurvePoint:
    """A point of the curve."""

    y: Floats  # the parameter last
    tangent: Floats  # of y / scale, length 1, in the direction of travel
    residual: float  # largest abs(F) before the last Newton step, itself no longer than rounding
    corrections: int
    note: Any  # the equations' third result
    step: float  # scaled length to be tried from here

    @property
    def parameter(self) -> float:
        """The last component of y."""
        return float(self.y[-1])

    def reversed(self) -> CurvePoint:
        """Return the same point, about to be left in the other direction."""
        return replace(self, tangent=-self.tangent)

    def along(self, direction: Floats) -> CurvePoint:
        """Return the same point, about to be left to the side of a vector."""
        return self if self.tangent @ direction >= 0 else self.reversed()


@dataclass(frozen=True)
class StepControl:
    """Lengths are scaled ones."""

    first: float = 0.01
    smallest: float = 1e-9
    largest: float = 1 / 32
    angle: float = 0.25  # by which the tangent turns in one step at most, radians
    corrections: int = 7  # Newton steps per point; with fewer than half of them the step grows
    patience: int = (
        2  # steps out of the region that are halved before `ArclengthCurve.walk` ends there
    )
    enough: float = 1e-13  # Newton step: the next would be its square
    foretell: bool = False  # a point ahead by a cubic, and Newton's next step by its square


@dataclass(frozen=True, eq=False)
class WalkEnd:
    """How a walk along a curve ended."""

    # region: every step met `LeavesRegion`; step limit: the smallest was still too long
    reason: Literal["end of range", "region", "step limit"]
    last: CurvePoint
    cause: Any = None  # of the last `LeavesRegion`


def _accept_all(previous: CurvePoint, new: CurvePoint) -> None:
    """Have nothing against any step."""


@dataclass(frozen=True, eq=False)
class ArclengthCurve:
    """The curve F(y) = 0 and how to walk on it."""

    # `equations(y)` gives F, shape (n,), its Jacobian, shape (n, n + 1), and a note for the point.
    # They may raise `LeavesRegion`, or `StepTooLong` to ask for a point nearby; so may
    # `accept(previous, new)`.

    equations: Equations
    scale: Floats
    low: float = -math.inf  # range of the parameter: nothing is evaluated outside
    high: float = math.inf
    control: StepControl = field(default_factory=StepControl)
    accept: Callable[[CurvePoint, CurvePoint], None] = _accept_all

    # ------------------------------------------------------------------ points

    def point(self, guess: Floats) -> CurvePoint:
        """Return the point of the curve with the parameter of a guess, parameter rising.

        Where the curve turns back just there, the nearest point of the curve.
        """
        rising = np.zeros(len(guess))
        rising[-1] = 1.0
        try:
            return self._corrected(guess, rising, rising, math.inf)
        except StepTooLong:
            normal = self._tangent(self.equations(guess)[1], rising)
            return self._corrected(guess, normal, rising, math.inf)

    def _corrected(
        self, guess: Floats, normal: Floats, ahead: Floats, longest: float
    ) -> CurvePoint:
        """Newton's method in the plane through a guess; bounded, and it has to contract."""
        y, before, foreseen = guess.copy(), longest / CONTRACTS, math.inf
        for count in range(self.control.corrections + 1):
            if not self.low <= y[-1] <= self.high:
                raise _BeyondRangeError
            residual, jacobian, note = self.equations(y)
            step = self._newton_step(residual, jacobian, normal)
            length = float(np.linalg.norm(step))
            rounding = length > CONTRACTS * before and length <= STALLED
            rounding |= UNFORESEEN * foreseen < length <= NOISE
            if length <= self.control.enough or rounding:
                # The last step is not worth another evaluation, but is taken if it is one.
                new = y if rounding else y + self.scale * step
                new[-1] = min(max(new[-1], self.low), self.high)
                tangent = self._tangent(jacobian, ahead)
                largest = float(np.abs(residual).max())
                return CurvePoint(new, tangent, largest, count, note, self.control.first)
            if not length <= CONTRACTS * before:
                break
            if count and self.control.foretell:
                foreseen = length * (length / before) ** 2
            y, before = y + self.scale * step, length
        raise StepTooLong("Newton's method does not converge")

    def _newton_step(self, residual: Floats, jacobian: Floats, normal: Floats) -> Floats:
        """Scaled step to F = 0 orthogonal to a vector."""
        matrix, right = np.empty((len(normal), len(normal))), np.zeros(len(normal))
        matrix[:-1], matrix[-1], right[:-1] = jacobian * self.scale, normal, -residual
        try:
            return np.asarray(np.linalg.solve(matrix, right))
        except np.linalg.LinAlgError as reason:
            raise StepTooLong("singular equations") from reason

    def _tangent(self, jacobian: Floats, ahead: Floats) -> Floats:
        """Null vector of the scaled Jacobian, on the side of another vector."""
        q, _ = np.linalg.qr((jacobian * self.scale).T, mode="complete")
        tangent: Floats = q[:, -1]
        return tangent if tangent @ ahead >= 0 else -tangent

    # ------------------------------------------------------------------ steps

    def walk(self, start: CurvePoint) -> Generator[CurvePoint, None, WalkEnd]:
        """Yield points from a start in the direction of its tangent; ends of the range exactly."""
        here, step, retreats, calm = start, start.step, 0, 0
        last: CurvePoint | None = None
        while not self._at_end(here):
            try:
                new, landed = self._step(last, here, step)
            except StepTooLong:
                step *= 0.5
            except LeavesRegion as left:
                step *= 0.5
                retreats, calm = retreats + 1, 0
                if retreats > self.control.patience:
                    return WalkEnd("region", replace(here, step=step), left.cause)
            else:
                calm += 1
                retreats = 0 if calm > CALM else retreats
                # Before a border steps that grow again would only approach it.
                grown = self._next_step(here, new, step) if not retreats else step
                step = min(grown, self.control.largest)
                last, here = here, replace(new, step=step)
                yield here
                if landed:
                    break
            if step < self.control.smallest:
                return WalkEnd("step limit", here)
        return WalkEnd("end of range", here)

    def _at_end(self, point: CurvePoint) -> bool:
        """Tell whether the way on leads out of the range at once."""
        rate = point.tangent[-1]
        return (point.y[-1] >= self.high and rate > 0) or (point.y[-1] <= self.low and rate < 0)

    def _step(
        self, last: CurvePoint | None, here: CurvePoint, step: float
    ) -> tuple[CurvePoint, bool]:
        """Make one step ahead, or onto the end of the range if that is closer."""
        rate = float(here.tangent[-1])
        end = self.high if rate > 0 else self.low
        to_end = (end - here.y[-1]) / self.scale[-1] / rate if rate else math.inf
        if to_end <= step:
            return self._landed(last, here, to_end, end), True
        try:
            guess = self._foretold(last, here, step)
            new = self._corrected(guess, here.tangent, here.tangent, FIRST_SHARE * step)
        except _BeyondRangeError:
            if to_end > 2 * step:
                raise
            return self._landed(last, here, to_end, end), True
        self._check(here, new)
        return new, False

    def _foretold(self, last: CurvePoint | None, here: CurvePoint, step: float) -> Floats:
        """Guess a point ahead: on the cubic through the last two, or along the first tangent."""
        length = 0.0 if last is None else float(np.linalg.norm((here.y - last.y) / self.scale))
        if last is None or not (length and self.control.foretell):  # steps may round to nothing
            return here.y + step * self.scale * here.tangent
        way = _hermite(last, here, 1.0 + step / length, length, self.scale)
        guess: Floats = last.y + self.scale * way
        return guess

    def _landed(
        self, last: CurvePoint | None, here: CurvePoint, length: float, end: float
    ) -> CurvePoint:
        """Solve for the point with the parameter at the end of its range."""
        guess = self._foretold(last, here, length)
        guess[-1] = end
        normal = np.zeros(len(guess))
        normal[-1] = 1.0
        new = self._corrected(
            guess, normal, here.tangent, FIRST_SHARE * max(length, self.control.enough)
        )
        self._check(here, new)
        new.y[-1] = end
        return new

    def _check(self, here: CurvePoint, new: CurvePoint) -> None:
        if _angle(here.tangent, new.tangent) > self.control.angle:
            raise StepTooLong("the curve bends")
        self.accept(here, new)

    def _next_step(self, here: CurvePoint, new: CurvePoint, step: float) -> float:
        """Choose the length of the next step from how hard this one was."""
        turned = _angle(here.tangent, new.tangent) / self.control.angle
        if turned > 0.7 or new.corrections > 0.7 * self.control.corrections:
            return 0.6 * step
        if turned < 0.4 and new.corrections < 0.5 * self.control.corrections:
            return 1.6 * step
        return step

    # ------------------------------------------------------------------ between points

    def between(
        self, a: CurvePoint, b: CurvePoint, test: Callable[[CurvePoint], float]
    ) -> CurvePoint:
        """Find the point between two neighbours where a function along the curve vanishes."""
        chord = (b.y - a.y) / self.scale
        length = float(np.linalg.norm(chord))
        chord = chord / length
        best: list[CurvePoint] = []
        known: dict[bytes, CurvePoint] = {}  # shares may differ by less than points do

        def value(share: float) -> float:
            guess = a.y + self.scale * _hermite(a, b, share, length, self.scale)
            if (key := guess.tobytes()) not in known:
                known[key] = self._corrected(guess, chord, a.tangent, length)
            best[:] = [known[key]]
            return test(best[0])

        share = zero_between(value, 0.0, 1.0, test(a), test(b))
        if not best or share in (0.0, 1.0):
            return a if share == 0.0 else b
        value(share)
        return replace(best[0], step=a.step)

    def turning_point(self, a: CurvePoint, b: CurvePoint) -> CurvePoint:
        """Find the point between two neighbours where the parameter turns back."""
        return self.between(a, b, lambda point: float(point.tangent[-1]))


def turns_back(a: CurvePoint, b: CurvePoint) -> bool:
    """Tell whether the parameter turns back between two neighbours."""
    return bool(a.tangent[-1] * b.tangent[-1] < 0)


def _angle(a: Floats, b: Floats) -> float:
    """Angle between unit vectors, exact also where it is small."""
    return 2 * math.asin(min(1.0, 0.5 * float(np.linalg.norm(a - b))))


def _hermite(a: CurvePoint, b: CurvePoint, t: float, length: float, scale: Floats) -> Floats:
    """Scaled way from a along the cubic through both points and tangents."""
    rise = (b.y - a.y) / scale
    start, end = length * a.tangent - rise, rise - length * b.tangent
    way: Floats = t * rise + t * (1 - t) * (start * (1 - t) + end * t)
    return way


def lagrange_weights(known: Sequence[float], wanted: float) -> list[float]:
    """Weights of values at known places in the polynomial through them, at another place."""
    return [math.prod((wanted - b) / (a - b) for b in known if b != a) for a in known]
