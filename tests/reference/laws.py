"""Friction laws as recurrences of Taylor coefficients: of s(t) = |X' - V| in, of F(s(t)) out.

A law's ``series()`` starts one expansion; each call with the coefficients s_0 .. s_k returns F_k.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import arb

from .precision import exact

Recurrence = Callable[[list[arb]], arb]


def product(a: Sequence[arb], b: Sequence[arb], k: int) -> arb:
    """Coefficient k of the product of two series."""
    return sum((a[j] * b[k - j] for j in range(1, k + 1)), a[0] * b[k])


class PoppStelter:
    """Eq. (9): (1 - delta) / (1 + gamma s) + delta + eta s^2."""

    def __init__(self, gamma: object, delta: object = 0, eta: object = 0) -> None:
        self.gamma, self.delta, self.eta = exact(gamma), exact(delta), exact(eta)

    def force(self, s: arb) -> arb:
        """F(s)."""
        return (1 - self.delta) / (1 + self.gamma * s) + self.delta + self.eta * s * s

    def series(self) -> Recurrence:
        """With q = 1 + gamma s: p = 1 / q obeys p q = 1."""
        p: list[arb] = []

        def coefficient(s: list[arb]) -> arb:
            k = len(s) - 1
            if k == 0:
                p.append(1 / (1 + self.gamma * s[0]))
                return self.force(s[0])
            known = sum((s[j] * p[k - j] for j in range(1, k + 1)), arb(0))
            p.append(-self.gamma * known * p[0])
            square = product(s, s, k) if self.eta != 0 else arb(0)
            return (1 - self.delta) * p[k] + self.eta * square

        return coefficient


class Viscous:
    """Coulomb friction with a viscous part: mu + viscous s."""

    def __init__(self, mu: object, viscous: object = 0) -> None:
        self.mu, self.viscous = exact(mu), exact(viscous)

    def force(self, s: arb) -> arb:
        """F(s)."""
        return self.mu + self.viscous * s

    def series(self) -> Recurrence:
        """Linear in s."""
        return lambda s: self.force(s[0]) if len(s) == 1 else self.viscous * s[-1]


class Stribeck:
    """mu + (1 - mu) exp(-(s / speed)^exponent) + viscous s; exponent 1 or 2."""

    def __init__(self, mu: object, speed: object, viscous: object = 0, exponent: int = 1) -> None:
        self.mu, self.speed, self.viscous = exact(mu), exact(speed), exact(viscous)
        self.exponent = int(exponent)

    def force(self, s: arb) -> arb:
        """F(s)."""
        falling = (-((s / self.speed) ** self.exponent)).exp()
        return self.mu + (1 - self.mu) * falling + self.viscous * s

    def series(self) -> Recurrence:
        """With e = exp(u): e' = u' e."""
        u: list[arb] = []
        e: list[arb] = []

        def coefficient(s: list[arb]) -> arb:
            k = len(s) - 1
            if self.exponent == 1:
                u.append(-s[k] / self.speed)
            else:
                u.append(-product(s, s, k) / (self.speed * self.speed))
            if k == 0:
                e.append(u[0].exp())
                return self.force(s[0])
            e.append(sum((j * u[j] * e[k - j] for j in range(1, k + 1)), arb(0)) / k)
            return (1 - self.mu) * e[k] + self.viscous * s[k]

        return coefficient
