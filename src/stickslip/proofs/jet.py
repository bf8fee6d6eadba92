"""Numbers that depend on d and parameters inside a box: a value, its range and its gradient.

With the gradient a motion through many events stays narrow, where balls alone would grow; the mean
value theorem joins the three, and `Jet.tight` intersects the range with what the theorem gives.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import inf, nextafter
from typing import Any, Final, TypeAlias

from flint import arb, ctx

HALF: Final = arb(1) / 2


class Arithmetic:
    """What sums, changes of sign, products and the reciprocal make of a number."""

    __slots__ = ()
    __add__: Any
    __neg__: Any
    __mul__: Any
    reciprocal: Any

    def __radd__(self, other: Any) -> Any:
        """Add to a number."""
        return self + other

    def __sub__(self, other: Any) -> Any:
        """Subtract."""
        return self + (-other)

    def __rsub__(self, other: Any) -> Any:
        """Subtract from a number."""
        return -self + other

    def __rmul__(self, other: Any) -> Any:
        """Multiply a number."""
        return self * other

    def __rtruediv__(self, other: Any) -> Any:
        """Divide a number."""
        return self.reciprocal() * other


class Jet(Arithmetic):
    """A function on a box: enclosures of its value at the centre, its range and its gradient."""

    # `box` holds the variables less their centres: balls around 0.

    __slots__ = ("box", "centre", "gradient", "range")

    def __init__(
        self, centre: arb, range: arb, gradient: tuple[arb, ...], box: tuple[arb, ...]
    ) -> None:
        self.centre, self.range, self.gradient, self.box = centre, range, gradient, box

    def tight(self) -> Jet:
        """Intersect the range with the mean value form."""
        form = self.centre
        for slope, step in zip(self.gradient, self.box, strict=True):
            form = form + slope * step
        if not form.is_finite():
            return self
        return Jet(self.centre, self.range.intersection(form), self.gradient, self.box)

    def __add__(self, other: Number | int) -> Jet:
        """Add."""
        if isinstance(other, Jet):
            slopes = tuple(a + b for a, b in zip(self.gradient, other.gradient, strict=True))
            return Jet(self.centre + other.centre, self.range + other.range, slopes, self.box)
        return Jet(self.centre + other, self.range + other, self.gradient, self.box)

    def __neg__(self) -> Jet:
        """Negate."""
        return Jet(-self.centre, -self.range, tuple(-a for a in self.gradient), self.box)

    def __mul__(self, other: Number | int) -> Jet:
        """Multiply; the product rule."""
        if isinstance(other, Jet):
            u, v = self.range, other.range
            slopes = tuple(
                a * v + b * u for a, b in zip(self.gradient, other.gradient, strict=True)
            )
            return Jet(self.centre * other.centre, u * v, slopes, self.box)
        return Jet(
            self.centre * other,
            self.range * other,
            tuple(a * other for a in self.gradient),
            self.box,
        )

    def __truediv__(self, other: Number | int) -> Jet:
        """Divide."""
        if isinstance(other, Jet):
            return self * other.reciprocal()
        return self * (1 / arb(other))

    def reciprocal(self) -> Jet:
        """1 / u; not finite where the range contains 0."""
        inverse = 1 / self.range
        return self.chain(1 / self.centre, inverse, -inverse * inverse)

    def sqrt(self) -> Jet:
        """Root of a positive quantity."""
        root = self.range.sqrt()
        return self.chain(self.centre.sqrt(), root, HALF / root)

    def sin_cos(self) -> tuple[Jet, Jet]:
        """Sine and cosine."""
        (s, c), (sine, cosine) = self.centre.sin_cos(), self.range.sin_cos()
        return self.chain(s, sine, cosine), self.chain(c, cosine, -sine)

    def __pow__(self, exponent: arb) -> Jet:
        """Raise to a constant power."""
        slope = exponent * power(self.range, exponent - 1)
        return self.chain(power(self.centre, exponent), power(self.range, exponent), slope)

    def chain(self, centre: arb, range: arb, slope: arb) -> Jet:
        """Apply a function: its values at the centre and on the range, its slopes there."""
        return Jet(centre, range, tuple(slope * a for a in self.gradient), self.box)

    def vague(self, among: arb) -> Jet:
        """Return a quantity of which nothing but its range is known."""
        nothing = arb(0, float("inf"))
        return Jet(among, among, tuple(nothing for _ in self.box), self.box)


Number: TypeAlias = Any  # arb, Jet, or a germ of either


def power(x: arb, exponent: arb) -> arb:
    """x^exponent; of a ball that holds 0, its part where there is a real power."""
    whole = exponent.unique_fmpz() if exponent.is_exact() else None
    if whole is not None:
        n = abs(int(whole))
        result, square = arb(1), x
        while n:
            result = result * square if n % 2 else result
            square, n = (square * square).nonnegative_part(), n // 2
        return result if exponent >= 0 else 1 / result
    if x > 0:
        return x**exponent
    if exponent.contains_integer():  # a ball around 3, as 0.1*30 is: which is not known
        return arb.nan()
    if exponent > 0 and x.upper() >= 0:
        return arb(0).union(x.upper() ** exponent)
    return x**exponent


def variables(centres: Sequence[arb], radii: Sequence[arb]) -> list[Jet]:
    """Return the coordinates of a box; centres are exact, half widths are rounded upward."""
    box = tuple(arb(0, radius.upper()) for radius in radii)
    units = [tuple(arb(i == j) for i in range(len(box))) for j in range(len(box))]
    return [
        Jet(centre, centre + step, unit, box)
        for centre, step, unit in zip(centres, box, units, strict=True)
    ]


def box_of(*balls: arb) -> list[Jet]:
    """Return the coordinates of the box of some balls."""
    return variables([x.mid() for x in balls], [x.rad() for x in balls])


def centre(x: Number) -> arb:
    """Value at the centre of the box."""
    found: arb = x if isinstance(x, arb) else x.centre
    return found


def spread(x: Number) -> arb:
    """Range over the box."""
    found: arb = x if isinstance(x, arb) else x.range
    return found


def tight(x: Number) -> Number:
    """`Jet.tight`, constants as they are."""
    return x if isinstance(x, arb) else x.tight()


def sin_cos(x: Number) -> tuple[Number, Number]:
    """Sine and cosine of either sort of number."""
    sine, cosine = x.sin_cos()
    return sine, cosine


def outward(x: arb) -> tuple[float, float]:
    """Return the ends of a ball as floats, rounded outward."""
    return nextafter(float(x.lower()), -inf), nextafter(float(x.upper()), inf)


def hull(low: arb, high: arb) -> arb:
    """Return the ball from the one number to the other."""
    return low.union(high)


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Compute with so many bits; flint's precision is global, so proofs do not run in threads."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before
