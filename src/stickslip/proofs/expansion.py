"""Functions of time by their Taylor polynomial and a proven bound of all that follows it.

Sums of absolute values of coefficients are norms of an algebra, |u v| <= |u| |v|, so that products
and quotients have bounds of the same kind. Docs: proofs, Taylor steps.
"""

from __future__ import annotations

from typing import Any, cast

from flint import arb, arb_poly, arb_series, ctx

from stickslip.proofs.germ import Germ, combine
from stickslip.proofs.jet import Jet, Number, centre, spread, tight


class Unbounded(Exception):
    """The radius is too large for a bound."""


class Expansion:
    """A function of t / radius on the unit disc: its terms up to `degree`, enclosed."""

    # `tail` bounds the sum of absolute values of all other coefficients.

    __slots__ = ("degree", "head", "tail")

    def __init__(self, head: arb_poly, tail: arb, degree: int) -> None:
        self.head, self.tail, self.degree = head, tail, degree

    def _cut(self, full: arb_poly, tail: arb) -> Expansion:
        """Move the terms of a polynomial beyond the degree into the tail."""
        coefficients = full.coeffs()
        beyond = _size(coefficients[self.degree + 1 :])
        return Expansion(
            arb_poly(coefficients[: self.degree + 1]), (tail + beyond).upper(), self.degree
        )

    def size(self) -> arb:
        """Upper bound of the sum of absolute values of all coefficients."""
        return (_size(self.head.coeffs()) + self.tail).upper()

    def __add__(self, other: Any) -> Expansion:
        """Add."""
        if isinstance(other, Expansion):
            tail = (self.tail + other.tail).upper()
            return Expansion(self.head + other.head, tail, self.degree)
        return Expansion(self.head + other, self.tail, self.degree)

    __radd__ = __add__

    def __neg__(self) -> Expansion:
        """Negate."""
        return Expansion(-self.head, self.tail, self.degree)

    def __sub__(self, other: Any) -> Expansion:
        """Subtract."""
        return self + (-other)

    def __rsub__(self, other: Any) -> Expansion:
        """Subtract from a number."""
        return -self + other

    def __mul__(self, other: Any) -> Expansion:
        """Multiply."""
        if not isinstance(other, Expansion):
            tail = (self.tail * abs(arb(other))).upper()
            return Expansion(self.head * other, tail, self.degree)
        tail = self.tail * other.tail
        if self.tail > 0:
            tail += self.tail * _size(other.head.coeffs())
        if other.tail > 0:
            tail += other.tail * _size(self.head.coeffs())
        return self._cut(self.head * other.head, tail)

    __rmul__ = __mul__

    def __rtruediv__(self, other: Any) -> Expansion:
        """Divide a number: 1 / a = q + q r / (1 - r), r = 1 - a q, where |r| < 1."""
        if self.head[0].contains(0):
            raise Unbounded
        cap, ctx.cap = ctx.cap, self.degree + 1
        try:
            inverse = arb_poly((1 / arb_series(self.head)).coeffs())
        finally:
            ctx.cap = cap
        size = _size(inverse.coeffs())
        rest = _size((self.head * inverse).coeffs()[self.degree + 1 :]) + self.tail * size
        if not rest < 1:
            raise Unbounded
        return Expansion(inverse, (size * rest / (1 - rest)).upper(), self.degree) * other

    def integral(self, radius: arb) -> Expansion:
        """From 0, in time: t = radius times the variable."""
        tail = self.tail / (self.degree + 2)
        return self._cut(self.head.integral() * radius, tail * radius)


def _size(coefficients: list[arb]) -> arb:
    return sum((abs(c) for c in coefficients), arb(0)).upper()


class Arc:
    """A function of time that is known on a Taylor step, with its derivatives."""

    # `radius` is the time that the variable of the expansions stands for; |t| <= `reach` <
    # `radius`. Expansions were differentiated `order` times: their tails were not.

    __slots__ = ("order", "parts", "radius", "reach")

    def __init__(self, parts: Any, radius: arb, reach: arb, order: int = 0) -> None:
        self.parts, self.radius, self.reach, self.order = parts, radius, reach, order

    def basis(self, t: Number) -> Number:
        """Return what `at` takes."""
        return t

    def at(self, t: Number) -> Any:
        """Value."""
        return tight(self._value(self.parts, t))

    __call__ = at

    def _value(self, parts: Any, t: Any) -> Any:
        if isinstance(parts, Germ):
            return self._germ(parts, t)
        if isinstance(parts, Jet):
            parts = cast("Any", parts)  # its parts are expansions
            if not isinstance(t, Jet):
                return combine(lambda part: self._part(part, t), parts)
            rate = Arc(_slope(parts.range, self.radius), self.radius, self.reach, self.order + 1)
            speed = rate.at(t.range)
            slopes = zip(parts.gradient, t.gradient, strict=True)
            return Jet(
                self._part(parts.centre, t.centre),
                self._part(parts.range, t.range),
                tuple(self._part(part, t.range) + speed * u for part, u in slopes),
                parts.box,
            )
        return self._part(parts, t)

    def _germ(self, parts: Germ, t: Any) -> Germ:
        """Taylor's formula around the time's own value."""
        moves = isinstance(t, Germ)
        first = t.coefficients[0] if moves else t
        value = Germ([self._value(c, first) for c in parts.coefficients])
        if not moves:
            return value
        shift = t.shift()
        power, arc = shift, self
        for k in range(1, len(parts.coefficients)):
            arc = arc.derivative()
            rate = Germ([arc._value(c, first) for c in arc.parts.coefficients])
            value = value + power * rate
            power = power * shift / (k + 1)
        return value

    def _part(self, part: Expansion, t: arb) -> arb:
        if not abs(t) <= self.reach:
            return arb(0, float("inf"))
        return part.head(t / self.radius) + arb(0, self._tail(part, t))

    def _tail(self, part: Expansion, t: arb) -> arb:
        """Bound this derivative of the tail."""
        # The largest of k (k - 1) ... (k - order + 1) |t|^(k - order) over k > degree is the first,
        # as long as the ratio of the second to it is at most 1.
        first, order = part.degree + 1, self.order
        share = (abs(t) / self.radius).upper()
        if not share * (first + 1) <= first + 1 - order:
            return arb(float("inf"))
        worst = part.tail * share ** (first - order) / self.radius**order
        for k in range(first - order + 1, first + 1):
            worst *= k
        return worst.upper()

    def derivative(self) -> Arc:
        """In time."""
        parts = combine(lambda part: _slope(part, self.radius), self.parts)
        return Arc(parts, self.radius, self.reach, self.order + 1)

    def centre(self) -> Arc:
        """Return the function at the centre of the box."""
        parts = self.parts if isinstance(self.parts, Expansion) else centre(self.parts)
        return Arc(parts, self.radius, self.reach, self.order)

    def largest(self, order: int) -> arb:
        """Bound the derivative of that order on the step."""
        arc: Arc = self
        for _ in range(order):
            arc = arc.derivative()
        part: Any = arc.parts if isinstance(arc.parts, Expansion) else spread(arc.parts)
        share = self.reach / self.radius
        terms = (abs(c) * share**k for k, c in enumerate(part.head.coeffs()))
        return (sum(terms, arb(0)) + arc._tail(part, self.reach)).upper()


def _slope(part: Expansion, radius: arb) -> Expansion:
    return Expansion(part.head.derivative() * (1 / radius), part.tail, part.degree)
