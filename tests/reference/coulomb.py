"""Oracle for the two-block system with Coulomb friction (eqs. 5a-8, 10-12).

Between events every position is a constant, plus a multiple of time, plus sinusoids: written down
in closed form. All that is numerical is the time of the first event (`roots.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt

from flint import arb

from .motion import Modes, Motion, Pair, equal, motion
from .precision import TIE, ZERO, exact
from .roots import earliest, first_root


@dataclass(frozen=True)
class Wave:
    """constant + rate t + sum over (omega, a, b) of a cos(omega t) + b sin(omega t)."""

    constant: arb
    rate: arb
    terms: tuple[tuple[arb, arb, arb], ...]

    def __add__(self, other: Wave) -> Wave:
        return Wave(
            self.constant + other.constant,
            self.rate + other.rate,
            tuple(
                (omega, a1 + a2, b1 + b2)
                for (omega, a1, b1), (_, a2, b2) in zip(self.terms, other.terms, strict=True)
            ),
        )

    def __mul__(self, factor: object) -> Wave:
        k = exact(factor)
        return Wave(
            k * self.constant, k * self.rate, tuple((w, k * a, k * b) for w, a, b in self.terms)
        )

    def plus(self, constant: arb) -> Wave:
        """Shifted up by a constant."""
        return Wave(self.constant + constant, self.rate, self.terms)

    def derivative(self) -> Wave:
        """In time."""
        return Wave(self.rate, ZERO, tuple((w, w * b, -w * a) for w, a, b in self.terms))

    def jet(self, t: arb) -> tuple[arb, arb, arb]:
        """Value, first and second derivative at ``t``."""
        value, slope, curvature = self.constant + self.rate * t, self.rate, ZERO
        for omega, a, b in self.terms:
            sine, cosine = (omega * t).sin_cos()
            here = a * cosine + b * sine
            value += here
            slope += omega * (b * cosine - a * sine)
            curvature -= omega * omega * here
        return value, slope, curvature

    def start(self, order: int) -> arb:
        """Derivative of that order at 0."""
        wave = self
        for _ in range(order):
            wave = wave.derivative()
        return sum((a for _, a, _ in wave.terms), wave.constant)

    def bound(self, order: int) -> arb:
        """Largest absolute value of that derivative (order >= 2), at any time."""
        return sum((w**order * (a * a + b * b).sqrt() for w, a, b in self.terms), ZERO)


class CoulombPhase:
    """Motion with constant modes."""

    def __init__(self, system: Coulomb, x: Pair, v: Pair, modes: Modes) -> None:
        self.system, self.modes = system, modes
        self.x = (both_slip if modes[0] and modes[1] else one_slips)(system, x, v, modes)

    def state(self, t: arb) -> tuple[Pair, Pair]:
        """Positions and velocities."""
        (x1, v1, _), (x2, v2, _) = self.x[0].jet(t), self.x[1].jet(t)
        return (x1, x2), (v1, v2)

    def speed(self, block: int) -> Wave:
        """|X' - V| of a slipping block, continued past its zero."""
        return (self.x[block].derivative().plus(-self.system.V)) * self.modes[block]

    def need(self, block: int) -> Wave:
        """R of a riding block."""
        alpha = self.system.alpha
        return self.x[block] * (1 + alpha) + self.x[1 - block] * -alpha

    def signals(self) -> list[tuple[int, Wave]]:
        """What must stay positive for the modes to last, with the block it belongs to."""
        found = []
        for block in (0, 1):
            if self.modes[block]:
                found.append((block, self.speed(block)))
            else:
                limit, force = self.system.limits[block], self.need(block)
                found += [(block, (force * -1).plus(limit)), (block, force.plus(limit))]
        return found

    def first_event(self, longest: arb) -> tuple[arb, frozenset[int]] | None:
        """Earliest root of all signals, and every block with a signal at zero there."""
        signals = self.signals()
        first = earliest([signal for _, signal in signals], longest)
        if first is None:
            return None
        return first, frozenset(b for b, signal in signals if signal.jet(first)[0] < TIE)

    def never_ends(self) -> bool:
        """Both slip backward, and no combination of the two modes' phases reaches V.

        If the two frequencies have a rational ratio, the phases that do occur repeat after a
        common period, and it is enough that no event comes before it.
        """
        if 0 in self.modes:
            return False
        v = self.system.V
        speeds = [self.x[i].derivative() for i in (0, 1)]
        if all(s.bound(0) < v for s in speeds):
            return True
        if self.system.period is None:
            return False
        horizon = self.system.period * 1.001
        return all(first_root(self.speed(i), horizon) is None for i in (0, 1))


def one_slips(system: Coulomb, x: Pair, v: Pair, modes: Modes) -> tuple[Wave, Wave]:
    """X_i'' + (1 + alpha) X_i = F_i + alpha (X_j(0) + V t), X_j = X_j(0) + V t (5a, 7a)."""
    i = 0 if modes[0] else 1
    j = 1 - i
    alpha, omega = system.alpha, (1 + system.alpha).sqrt()
    rider = Wave(x[j], system.V, ((omega, ZERO, ZERO),))
    centre = (system.friction(i, modes[i]) + alpha * x[j]) / (1 + alpha)
    drift = alpha * system.V / (1 + alpha)
    slipper = Wave(centre, drift, ((omega, x[i] - centre, (v[i] - drift) / omega),))
    return (slipper, rider) if i == 0 else (rider, slipper)


def both_slip(system: Coulomb, x: Pair, v: Pair, modes: Modes) -> tuple[Wave, Wave]:
    """Sum s'' + s = F_1 + F_2 and difference r'' + (1 + 2 alpha) r = F_2 - F_1 of eqs. (7a)."""
    slow, fast = arb(1), (1 + 2 * system.alpha).sqrt()
    f1, f2 = (system.friction(i, modes[i]) for i in (0, 1))
    sum_centre, difference_centre = f1 + f2, (f2 - f1) / (1 + 2 * system.alpha)
    sum_wave = (slow, x[0] + x[1] - sum_centre, v[0] + v[1])
    difference_wave = (fast, x[1] - x[0] - difference_centre, (v[1] - v[0]) / fast)
    total = Wave(sum_centre, ZERO, (sum_wave, (fast, ZERO, ZERO)))
    difference = Wave(difference_centre, ZERO, ((slow, ZERO, ZERO), difference_wave))
    return (total + difference * -1) * 0.5, (total + difference) * 0.5


class Coulomb:
    """Two blocks with Coulomb friction; parameters are doubles, taken exactly.

    ``mu`` is one number or a pair, each relative to the block's own static limit (1, beta).
    """

    def __init__(
        self, alpha: object, beta: object, V: object, mu: object | tuple[object, object]
    ) -> None:
        self.alpha, self.beta, self.V = exact(alpha), exact(beta), exact(V)
        self.limits = (arb(1), self.beta)
        self.plant = equal(self.alpha, self.beta, self.V)
        self.mu = tuple(exact(m) for m in (mu if isinstance(mu, tuple) else (mu, mu)))
        self.period = common_period(self.alpha)

    def friction(self, block: int, mode: int) -> arb:
        """Eqs. (8) and (10): against the relative motion."""
        return -mode * self.limits[block] * self.mu[block]

    def acceleration(self, block: int, x: Pair, v: Pair, mode: int) -> arb:
        """X'' of a slipping block (7a)."""
        pull = x[block] + self.alpha * (x[block] - x[1 - block])
        return self.friction(block, mode) - pull

    def phase(self, x: Pair, v: Pair, modes: Modes) -> CoulombPhase:
        """The motion from this state as long as the modes last."""
        return CoulombPhase(self, x, v, modes)

    def motion(self, d: object, **limits: float) -> Motion:
        """One step of the event map."""
        return motion(self, d, **limits)


def common_period(alpha: arb) -> arb | None:
    """Period of cos t and cos(sqrt(1 + 2 alpha) t) together, if their ratio is a simple one."""
    ratio = 1 + 2 * Fraction(float(alpha))
    p, q = isqrt(ratio.numerator), isqrt(ratio.denominator)
    if arb(float(alpha)) != alpha or p * p != ratio.numerator or q * q != ratio.denominator:
        return None
    return 2 * arb.pi() * q if q <= 1000 else None
