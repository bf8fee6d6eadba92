"""Zeros of a condition along one number: bracketed, or from a guess; of several at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision, Meeting
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.continuation.half_period import MAX_SECANT
from stickslip.numerics.zeros import MAX_ROUNDS

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Condition, Reading
    from stickslip.analysis.maps.protocol import Map1D

MapAt: TypeAlias = "Callable[[float], Map1D]"

STRIDES: Final = (1, 4, 16)  # steps to a far point: more of them if the condition is lost
BELOW_NOISE: Final = 0.25  # of the noise: a smaller value is as good as zero
ABOVE_NOISE: Final = 1e3  # times the noise: values fit for a slope
WIDEST: Final = 64.0  # times the step: how far from its guess a secant may go
SPAN: Final = 1e-4  # of a bracket, or of a step: where a slope is taken if no value is fit
WIDER: Final = (1.0, 10.0, 100.0, 1e3, 1e4)  # times that, where noise hides the slope
NEARBY: Final = 64.0  # ulp: values closer to a zero than that tell no slope, or may be it
ERRORS: Final = 8.0  # by which two values of one event may differ


@dataclass(frozen=True)
class Located:
    """A zero of a condition."""

    value: float
    error: float  # (abs(test function) + noise) / abs(slope), at least 2 ulp
    residual: float  # test function at `value`
    quality: str  # "failed" where the test function jumps over zero
    slope: float  # of the test function
    reading: Reading  # at `value`


@dataclass
class Readings:
    """A condition along one number; every reading starts from the nearest one so far."""

    condition: Condition
    at: MapAt
    known: dict[float, Reading] = field(default_factory=dict)

    def __call__(self, t: float) -> float:
        """Test function at t; `ConditionLost` also where a parameter is out of its range."""
        if t not in self.known:
            self.known[t] = self._read(t)
        return self.known[t].value

    def is_zero(self, t: float) -> bool:
        """Whether the test function at t is below rounding."""
        return abs(self(t)) <= BELOW_NOISE * self.known[t].noise

    def _read(self, t: float) -> Reading:
        if not self.known:
            return self._one(self.condition, t)
        start = min(self.known, key=lambda s: abs(s - t))
        for n in STRIDES:
            try:
                condition = self.known[start].condition
                for k in range(1, n):
                    condition = self._one(condition, start + (t - start) * k / n).condition
                return self._one(condition, t)
            except ConditionLost:
                if n == STRIDES[-1]:
                    raise
        raise AssertionError  # the last stride returns or raises

    def _one(self, condition: Condition, t: float) -> Reading:
        try:
            f = self.at(t)
        except ValueError as reason:
            raise ConditionLost(str(reason)) from reason
        return condition.at(f)

    def located(self, t: float, span: float) -> Located:
        """Judge a zero: its slope (over ``span`` if need be), its error, whether it is a jump."""
        reading = self.known[t]
        slope = self.slope(t, span)
        ulp = float(np.spacing(abs(t)))
        error = (abs(reading.value) + reading.noise) / abs(slope) if slope != 0 else math.inf
        error = max(error, 2.0 * ulp)
        return Located(
            value=t,
            error=error,
            residual=reading.value,
            quality="failed" if self._jumps_at(t) else "located",
            slope=slope,
            reading=reading,
        )

    def _jumps_at(self, t: float) -> bool:
        """Tell whether the sign changes by a jump: much steeper there than on the zero's side."""
        zero = self.known[t]
        across = [s for s in self.known if self.known[s].value * zero.value < 0]
        if not across:
            return False
        s = min(across, key=lambda s: abs(s - t))
        rise = abs(self.known[s].value - zero.value)
        if rise <= ABOVE_NOISE * zero.noise:
            return False
        beyond = (r for r in self.known if (r - t) * (t - s) > 0)
        own = [r for r in beyond if self.known[r].value * self.known[s].value < 0]
        if own and not self._too_steep(min(own, key=lambda r: abs(r - t)), t, s):
            return False
        r = t + NEARBY * (t - s)
        try:
            self(r)
        except ConditionLost:
            return False
        if own and self.known[r].value * self.known[s].value > 0:
            return True  # within rounding of a break the sign changes there and back
        # Another break that takes the place of this one there, or the next time, tells no slope.
        one, other = self.known[r].critical, zero.critical
        same = one is None or other is None or one.labels == other.labels
        return not same or self._too_steep(r, t, s)

    def _too_steep(self, r: float, t: float, s: float) -> bool:
        """Tell whether the slope from a zero t to r cannot explain the value at s beyond it."""
        zero, across = self.known[t], self.known[s]
        slope = abs(self(r) - zero.value) / abs(r - t)
        rise = abs(across.value - zero.value)
        return rise > ABOVE_NOISE * (zero.noise + slope * abs(s - t))

    def slope(self, t: float, span: float) -> float:
        """Slope of the test function beside a value; 0 if it cannot be told."""
        zero = self.known[t]
        enough, apart = ABOVE_NOISE * zero.noise, NEARBY * float(np.spacing(abs(t)))
        fit = [
            s
            for s in self.known
            if abs(s - t) >= apart and abs(self.known[s].value - zero.value) > enough
        ]
        if fit:
            s = min(fit, key=lambda s: abs(s - t))
            return (self.known[s].value - zero.value) / (s - t)
        span, rise, slope = max(span, apart), 0.0, 0.0  # or t + span may be t itself
        for way in [side * times * span for times in WIDER for side in (1, -1)]:
            try:
                risen = self(t + way) - zero.value
            except ConditionLost:
                continue
            if abs(risen) > rise:
                rise, slope = abs(risen), risen / way
            if rise > enough:
                break
        return slope


def solve(condition: Condition, at: MapAt, low: float, high: float) -> Located:
    """Find the zero between two numbers of a condition that starts from close to one of them.

    "failed" where the test function only jumps over zero; `ConditionLost` where it does not exist
    all over the bracket; a ValueError where its signs agree.

    >>> from stickslip.analysis.bifurcations.conditions.conditions import Flip
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.2})
    >>> solve(Flip(1, (0.6875,)), lambda r: f.replace(r=r), 2.5, 3.5).value
    3.0
    """
    g = Readings(condition, at)
    try:
        g(low)
        g(high)
    except ConditionLost:
        if g.known:
            raise
        g(high)
        g(low)
    for end in (low, high):
        if g.is_zero(end):
            return g.located(end, SPAN * (high - low))
    if g(low) * g(high) > 0:
        raise ValueError(
            f"the test function has the values {g(low):.6g} at {low:.12g} and {g(high):.6g} at "
            f"{high:.12g}: a zero between them is not certain. Take ends with different signs."
        )
    return g.located(_between(g, low, high), SPAN * (high - low))


def solve_near(
    condition: Condition,
    at: MapAt,
    guess: float,
    *,
    step: float,
    slope: float = math.nan,
    within: tuple[float, float] = (-math.inf, math.inf),
) -> Located:
    """Find the zero of a condition close to a guess, or raise `ConditionLost`; never outside."""
    # ``step``: how far off the guess may be, and the first step where no slope can be told.
    g = Readings(condition, at)
    lo, hi = max(within[0], guess - WIDEST * step), min(within[1], guess + WIDEST * step)
    old = min(max(guess, lo), hi)
    if g.is_zero(old):
        return g.located(old, SPAN * step)
    if not math.isfinite(slope):  # a whole step away the condition may be lost, or another one
        slope = g.slope(old, SPAN * step)
    move = -g(old) / slope if slope != 0 else step
    if abs(move) > WIDEST * step:
        move = math.copysign(step, move)
    new = old + move if lo <= old + move <= hi else old - move
    new = min(max(new, lo), hi)
    if new == old:  # at one end, the other closer than a step
        new = lo + hi - old
    for _ in range(MAX_SECANT):
        if g.is_zero(new):
            return g.located(new, SPAN * step)
        if g(new) * g(old) < 0:
            return g.located(_between(g, min(old, new), max(old, new)), SPAN * step)
        rise = g(new) - g(old)
        following = new - g(new) * (new - old) / rise if rise != 0 else math.inf
        if new in (lo, hi) and not lo <= following <= hi:
            break
        if abs(new - old) <= 2 * np.spacing(abs(new)):
            return g.located(new, SPAN * step)
        old, new = new, min(max(following, lo), hi)
    raise ConditionLost(f"the test function has no zero near {guess:.12g}")


def found_near(condition: Condition, at: MapAt, guess: float, **how: Any) -> Located | None:
    """Find what `solve_near` does; None where that is nothing, or a jump over zero."""
    try:
        found = solve_near(condition, at, guess, **how)
    except (ConditionLost, ValueError):
        return None
    return None if found.quality == "failed" else found


def _between(g: Readings, low: float, high: float) -> float:
    """Zero between two numbers where the signs differ: Brent's method, readings from near by."""
    a, b = (low, high) if abs(g(low)) > abs(g(high)) else (high, low)
    # b is the best so far, a on the other side, c the one before b.
    c, wide = a, True
    for _ in range(MAX_ROUNDS):
        if g.is_zero(b) or abs(b - a) <= 2 * np.spacing(abs(b)):
            break
        t = _proposal(g, a, b, c)
        if not (min(b, 0.75 * a + 0.25 * b) < t < max(b, 0.75 * a + 0.25 * b)) or not wide:
            t = 0.5 * (a + b)
        before = abs(b - a)
        # A step to where rounding begins would only be repeated.
        t = b + math.copysign(max(abs(t - b), float(np.spacing(abs(b)))), a - b)
        c = b
        if g(t) * g(b) < 0:
            a = b
        b = t
        if abs(g(a)) < abs(g(b)):
            a, b = b, a
        wide = abs(b - a) <= 0.5 * before or abs(g(b)) <= 0.5 * abs(g(c))
    return b


def _proposal(g: Readings, a: float, b: float, c: float) -> float:
    """Inverse quadratic interpolation through three values, or the secant through two."""
    ga, gb, gc = g(a), g(b), g(c)
    if ga != gc and gb != gc:
        return (
            a * gb * gc / ((ga - gb) * (ga - gc))
            + b * ga * gc / ((gb - ga) * (gb - gc))
            + c * ga * gb / ((gc - ga) * (gc - gb))
        )
    return b - gb * (b - a) / (gb - ga)


# ------------------------------------------------------------------ several collisions at once

# Several points of an orbit may collide with breaks of their own at one parameter value: a symmetry
# makes that one condition (docs/theory/reversing_symmetry.md). That of the first border is solved,
# the other branches continued a little, and each of the others must give the same value.


def solve_together(
    condition: Condition, at: MapAt, guess: float, *, step: float, within: tuple[float, float]
) -> Located:
    """Solve near a guess; a collision with all those of its ``others`` that happen there, too."""
    found = solve_near(condition, at, guess, step=step, within=within)
    joint = found.reading.condition
    if not isinstance(joint, Collision):
        return found
    kept = tuple(
        other for k, other in enumerate(joint.others) if _agrees(turned(joint, k), at, found, step)
    )
    if len(kept) == len(joint.others):
        return found
    return solve_together(replace(joint, others=kept), at, found.value, step=step, within=within)


def turned(condition: Collision, number: int) -> Collision:
    """Return the same collision, counted from another border on."""
    first, p = condition.others[number], condition.period
    own = Meeting(0, condition.border, condition.side)
    rest = (own, *condition.others[:number], *condition.others[number + 1 :])
    others = tuple(replace(one, place=(one.place - first.place) % p) for one in rest)
    return Collision(p, first.border, first.side, others)


def _agrees(condition: Collision, at: MapAt, found: Located, step: float) -> bool:
    """Tell whether a condition vanishes where another one does, within both errors."""
    other = found_near(condition, at, found.value, step=step)
    if other is None:
        return False
    return abs(other.value - found.value) <= ERRORS * (found.error + other.error)
