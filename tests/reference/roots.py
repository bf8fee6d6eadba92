"""First root of a signal that is positive now, by conservative advancement.

From ``t`` the signal is known to stay positive as long as its Taylor polynomial minus a bound on
the remainder does; stepping exactly that far can never jump over a root, however close together
two roots are. Near a simple root the step is Newton's, so nothing is lost at the end. Signs are
never compared across a step.
"""

from __future__ import annotations

from typing import Protocol

from flint import arb

from .precision import POLISHED, ROOT, TIE, ZERO


class Signal(Protocol):
    """A function of time with derivatives at a point and bounds on them for all later times."""

    def jet(self, t: arb) -> tuple[arb, arb, arb]:
        """Value, first and second derivative at ``t``."""

    def start(self, order: int) -> arb:
        """Derivative of that order at ``t = 0``."""

    def bound(self, order: int) -> arb:
        """Upper bound of that derivative's absolute value (order 2 and up) up to the horizon."""


class NotPositive(ArithmeticError):
    """The signal is not positive just after the start: the modes are not consistent with it."""


HIGHEST_ZERO = 4  # a signal of this kind of motion leaves zero with one of its first derivatives


class Search:
    """The first root of one signal, looked for piece by piece.

    A zero at t = 0 itself, of whatever order, is not a root if the phase ``begins`` there.
    A touch (double root) is a root.
    """

    def __init__(self, signal: Signal, *, begins: bool = True) -> None:
        self.signal = signal
        self.bounds = signal.bound(2), signal.bound(3)
        self.t = leave_zero(signal) if begins else ZERO

    def until(self, horizon: arb) -> arb | None:
        """The root if it comes before ``horizon``, else None; may be asked again further on."""
        while self.t < horizon:
            value, slope, curvature = self.signal.jet(self.t)
            if value < ROOT:
                self.t = polish(self.signal, self.t)
                return self.t
            self.t = (self.t + safe_step(value, slope, curvature, *self.bounds)).mid()
        return None


def first_root(signal: Signal, horizon: arb) -> arb | None:
    """Smallest t > 0 with signal(t) = 0, or None if there is none up to ``horizon``."""
    return Search(signal).until(horizon)


def earliest(signals: list[Signal], longest: arb) -> arb | None:
    """The first root of any of the signals, or None if there is none up to ``longest``.

    The horizon grows for all together: one signal may have no root for a very long time.
    """
    searches = [Search(signal) for signal in signals]
    horizon = arb(1)
    while horizon < longest:
        horizon = min(2 * horizon, longest)
        first: arb | None = None
        for search in searches:
            root = search.until(horizon if first is None else first)
            first = root if root is not None else first
        if first is not None:
            return first
    return None


def leave_zero(signal: Signal) -> arb:
    """A time before which a signal that starts at zero has no other root; 0 if it does not."""
    if signal.start(0) > TIE:
        return ZERO
    for order in range(1 if abs(signal.start(0)) <= TIE else 0, HIGHEST_ZERO + 1):
        lowest = signal.start(order)
        if lowest < -TIE:
            raise NotPositive(f"derivative of order {order} is {float(lowest)}")
        if lowest > TIE:
            # g(t) >= lowest t^order / order! - bound t^(order+1) / (order+1)!
            bound = signal.bound(order + 1) if order else ZERO
            return (lowest * (order + 1) / (2 * (bound + lowest))).mid()
    raise NotPositive(f"all derivatives up to order {HIGHEST_ZERO} are zero")


def safe_step(value: arb, slope: arb, curvature: arb, bound2: arb, bound3: arb) -> arb:
    """A step over which the signal is positive; near a simple root, Newton's step from outside."""
    step = positive_until(value, slope, bound2)
    if step is None:  # no curvature at all, and not falling
        return arb(1)
    for stretch in (4, 16):
        cap = stretch * step
        # For s <= cap: g''s^2/2 - bound3 s^3/6 >= -(bound3 cap/3 - g'') s^2/2
        reach = positive_until(value, slope, bound3 * cap / 3 - curvature)
        better = cap if reach is None or reach > cap else reach
        if better > step:
            step = better
    return step.mid()


def positive_until(value: arb, slope: arb, downward: arb) -> arb | None:
    """Smallest s > 0 with value + slope s - downward s^2 / 2 = 0, for value > 0; None if never."""
    disc = slope * slope + 2 * downward * value
    if disc < 0 or (slope >= 0 and downward <= 0):
        return None
    root = disc.sqrt() if disc > 0 else ZERO
    # Each form adds numbers of one sign: no cancellation.
    return 2 * value / (root - slope) if slope < 0 else (slope + root) / downward


def polish(signal: Signal, t: arb) -> arb:
    """Newton from a point where the signal is almost zero: on its root, or on the touch."""
    for _ in range(6):
        value, slope, curvature = signal.jet(t)
        touching = slope * slope < 4 * abs(curvature) * ROOT
        step = slope / curvature if touching else value / slope
        t = (t - step).mid()
        if abs(step) < POLISHED:
            break
    return t
