"""Power series in the start d, cut off: numbers that know higher derivatives of the event map.

Coefficients u'(d), u''(d) / 2, ... are known on a box, with gradients of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import mul
from typing import Any

from flint import arb

from stickslip.proofs.jet import Arithmetic, Jet, centre, sin_cos, spread, tight


class Germ(Arithmetic):
    """c_0 + c_1 x + ... + c_n x^n + O(x^{n+1}), x the distance from d."""

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Sequence[Any]) -> None:
        self.coefficients = tuple(coefficients)

    @property
    def centre(self) -> arb:
        """Of the value."""
        return centre(self.coefficients[0])

    @property
    def range(self) -> arb:
        """Of the value."""
        return spread(self.coefficients[0])

    def tight(self) -> Germ:
        """Tighten each coefficient."""
        return Germ([tight(c) for c in self.coefficients])

    def vague(self, among: arb) -> Germ:
        """Return a quantity of which nothing but its range is known."""
        first = self.coefficients[0]
        unknown = first.vague(arb(0, float("inf")))
        return Germ([first.vague(among), *(unknown for _ in self.coefficients[1:])])

    def __add__(self, other: Any) -> Germ:
        """Add."""
        if isinstance(other, Germ):
            pairs = zip(self.coefficients, other.coefficients, strict=True)
            return Germ([a + b for a, b in pairs])
        return Germ([self.coefficients[0] + other, *self.coefficients[1:]])

    def __neg__(self) -> Germ:
        """Negate."""
        return Germ([-c for c in self.coefficients])

    def __mul__(self, other: Any) -> Germ:
        """Multiply."""
        if not isinstance(other, Germ):
            return Germ([c * other for c in self.coefficients])
        u, v = self.coefficients, other.coefficients
        return Germ([_dot(u[: k + 1], v[k::-1]) for k in range(len(u))])

    def __truediv__(self, other: Any) -> Germ:
        """Divide."""
        if isinstance(other, Germ):
            return self * other.reciprocal()
        return Germ([c / other for c in self.coefficients])

    def reciprocal(self) -> Germ:
        """1 / u."""
        u = self.coefficients
        found = [1 / u[0]]
        for k in range(1, len(u)):
            found.append(-found[0] * _dot(u[1 : k + 1], found[k - 1 :: -1]))
        return Germ(found)

    def sqrt(self) -> Germ:
        """Root of a positive quantity."""
        u = self.coefficients
        found = [u[0].sqrt()]
        for k in range(1, len(u)):
            known = u[k] if k == 1 else u[k] - _dot(found[1:], found[:0:-1])
            found.append(known / (found[0] * 2))
        return Germ(found)

    def sin_cos(self) -> tuple[Germ, Germ]:
        """Sine and cosine."""
        first, *rest = self.coefficients
        sine, cosine = ([x] for x in sin_cos(first))
        rates = [c * k for k, c in enumerate(rest, 1)]
        for k in range(1, len(rest) + 1):
            s, c = _dot(rates[:k], sine[::-1]), _dot(rates[:k], cosine[::-1])
            sine.append(c / k)
            cosine.append(-s / k)
        return Germ(sine), Germ(cosine)

    def shift(self) -> Germ:
        """Less its value."""
        first, *rest = self.coefficients
        return Germ([first * arb(0), *rest])

    def into(self, coefficients: Sequence[Any]) -> Germ:
        """Return c_0 + c_1 y + c_2 y^2 ..., y being the shift of this germ."""
        shift = self.shift()
        value = shift * arb(0) + coefficients[-1]
        for c in reversed(coefficients[:-1]):
            value = value * shift + c
        return value


def germ(d: Any, order: int) -> Germ:
    """Return the start itself."""
    none = d * arb(0)
    return Germ([d, none + 1, *(none for _ in range(order - 1))])


def principal(x: Any) -> Any:
    """Return the value of a germ, other numbers as they are."""
    return x.coefficients[0] if isinstance(x, Germ) else x


def _dot(us: Sequence[Any], vs: Sequence[Any]) -> Any:
    return total([u * v for u, v in zip(us, vs, strict=True)])


def combine(f: Callable[..., Any], *numbers: Any) -> Any:
    """Apply a function to corresponding parts of numbers of one kind, part by part."""
    first = numbers[0]
    if isinstance(first, Germ):
        rows = zip(*(x.coefficients for x in numbers), strict=True)
        return Germ([combine(f, *row) for row in rows])
    if isinstance(first, Jet):
        slopes = zip(*(x.gradient for x in numbers), strict=True)
        return Jet(
            f(*(x.centre for x in numbers)),
            f(*(x.range for x in numbers)),
            tuple(f(*row) for row in slopes),
            first.box,
        )
    return f(*numbers)


def like(kind: Any, x: Any) -> Any:
    """Write a number in the form of another one."""
    return x if type(x) is type(kind) else combine(lambda _: arb(0), kind) + x


def dot(xs: Sequence[Any], ys: Sequence[Any]) -> Any:
    """Return the sum of products of numbers of one kind; faster than one by one."""
    first = xs[0]
    if isinstance(first, Germ):
        u = [[x.coefficients[k] for x in xs] for k in range(len(first.coefficients))]
        v = [[y.coefficients[k] for y in ys] for k in range(len(first.coefficients))]
        return Germ([total([dot(u[j], v[k - j]) for j in range(k + 1)]) for k in range(len(u))])
    if not isinstance(first, Jet):
        return sum(map(mul, xs, ys), arb(0))
    u, v = [x.range for x in xs], [y.range for y in ys]
    slopes = []
    for i in range(len(first.box)):
        du, dv = [x.gradient[i] for x in xs], [y.gradient[i] for y in ys]
        slopes.append(sum(map(mul, du, v), sum(map(mul, u, dv), arb(0))))
    middle = sum(map(mul, [x.centre for x in xs], [y.centre for y in ys]), arb(0))
    return Jet(middle, sum(map(mul, u, v), arb(0)), tuple(slopes), first.box)


def total(terms: Sequence[Any]) -> Any:
    """Return the sum of one or more numbers."""
    first, *rest = terms
    return sum(rest, first)
