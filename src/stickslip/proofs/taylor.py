"""Taylor steps with proven remainders: motion under the falling law (9) with constant modes.

A function of time is its polynomial and a bound of the rest; norms |u v| <= |u| |v| bound products
and quotients alike. Docs: proofs, Taylor steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple, cast

from flint import arb, arb_poly, arb_series, ctx

from stickslip.proofs.germ import Germ, combine, dot, like
from stickslip.proofs.jet import Arithmetic, Jet, Number, centre, spread, tight
from stickslip.proofs.wave import Undecided

if TYPE_CHECKING:
    from stickslip.proofs.system import Modes, Pair, System

TRIED_RADII: Final = 12  # tried for one step
FIRST_SHARE: Final = 0.85  # of the radius of convergence, as the coefficients show it
NEXT_SHARE: Final = 0.85
LARGEST_RADIUS: Final = 8.0
KINDS: Final = (arb, Jet, Germ)  # what a number may be, the richest last
LONGEST_SHARE: Final = 0.7  # of the radius, that a step may use


class Unbounded(Exception):
    """The radius is too large for a bound."""


class Expansion(Arithmetic):
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

    def __neg__(self) -> Expansion:
        """Negate."""
        return Expansion(-self.head, self.tail, self.degree)

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

    def reciprocal(self) -> Expansion:
        """1 / a = q + q r / (1 - r), r = 1 - a q, where |r| < 1."""
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
        return Expansion(inverse, (size * rest / (1 - rest)).upper(), self.degree)

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


class Falling(NamedTuple):
    """Law (9): F(s) = (1 - delta) / (1 + gamma s) + delta + eta s^2."""

    gamma: Number
    delta: Number
    eta: Number

    def force(self, s: Any) -> Any:
        """F along a motion with expansions as parts."""
        force = (1 - self.delta) * (1 / (1 + self.gamma * s)) + self.delta
        return force if _vanishes(self.eta) else force + self.eta * (s * s)


def _vanishes(x: Number) -> bool:
    return isinstance(x, arb) and x.is_zero()


class TaylorStep:
    """Motion from a state (w, e) for a short time, with what `system.Phase` offers."""

    # The `released` block has just left the belt by its force: its acceleration is exactly 0.

    def __init__(
        self, system: System, modes: Modes, w: Pair, e: Pair, released: int | None
    ) -> None:
        self.system, self.modes = system, modes
        self.laws: tuple[Any, ...] = system.laws
        self.degree = ctx.prec // 3 + 8
        kind = max(
            (*w, *e, system.alpha, system.beta, system.V), key=lambda x: KINDS.index(type(x))
        )
        self.w0 = [like(kind, x) for x in w]
        self.e0 = [like(kind, x) for x in e]
        series = self._coefficients(released)
        self.radius, self.reach, w_parts, e_parts = self._enclosed(series)
        found = signals(modes, system.limits, w_parts, e_parts)
        self.signals = [(i, end, self._arc(x)) for i, end, x in found]
        self.w = tuple(self._arc(x) for x in w_parts)
        self.e = tuple(self._arc(x) for x in e_parts)

    def _arc(self, parts: Any) -> Arc:
        return Arc(parts, self.radius, self.reach)

    def _coefficients(self, released: int | None) -> list[list[Any]]:
        """Return the Taylor coefficients of both relative velocities in time."""
        system, modes = self.system, self.modes
        alpha, V = system.alpha, system.V
        w, e = [[x] for x in self.w0], [[x] for x in self.e0]
        slips = [i for i in (0, 1) if modes[i]]
        s: list[list[Any]] = [[], []]
        r: list[list[Any]] = [[], []]
        none = self.w0[0] * arb(0)
        for k in range(self.degree):
            for i in (0, 1):
                if i not in slips:
                    w[i].append(none)
                    continue
                gamma, delta, eta = self.laws[i]
                s[i].append(w[i][k] * arb(modes[i]))
                if k == 0:
                    r[i].append(1 / (1 + gamma * s[i][0]))
                else:
                    r[i].append(-(r[i][0] * gamma) * dot(s[i][1:], r[i][::-1]))
                force = (1 - delta) * r[i][k]
                if k == 0:
                    force = force + delta
                if not _vanishes(eta):
                    force = force + eta * dot(s[i], s[i][::-1])
                rate = force * (system.limits[i] * arb(-modes[i])) - e[i][k]
                w[i].append(none if k == 0 and i == released else rate / (k + 1))
            for i in (0, 1):
                rate = (alpha + 1) * w[i][k] - alpha * w[1 - i][k]
                e[i].append((rate + V if k == 0 else rate) / (k + 1))
        return w

    def _enclosed(self, w: list[list[Any]]) -> tuple[arb, arb, tuple[Any, Any], tuple[Any, Any]]:
        """Find a radius on which the tails can be bounded, and the time they allow."""
        radius = FIRST_SHARE * self._convergence(w)
        for _ in range(TRIED_RADII):
            size = arb(radius)
            try:
                found = self._contracted(w, size)
            except Unbounded:
                found = None
            if found is not None:
                worst = max(float(part.tail) for x in found[0] + found[1] for part in parts(x))
                return size, arb(radius * self._share(worst)), *found
            radius *= NEXT_SHARE
        raise Undecided("the box is too wide for a Taylor step")

    def _share(self, tail: float) -> float:
        """Share of the radius after which a tail has shrunk below the precision."""
        if tail == 0:
            return LONGEST_SHARE
        share = (2.0 ** (-0.75 * ctx.prec) / tail) ** (1 / (self.degree + 1))
        return float(min(LONGEST_SHARE, share))

    def _convergence(self, w: list[list[Any]]) -> float:
        """Estimate the radius of convergence by the last coefficients."""
        found = LARGEST_RADIUS
        for x in w:
            for k in range(self.degree - 3, self.degree + 1):
                size = float(abs(spread(x[k]).mid()))
                if size > 0:
                    found = min(found, size ** (-1 / k))
        return found

    def _contracted(self, w: list[list[Any]], radius: arb) -> Any:
        """Bound the tails: Picard's operator maps the tails within the bounds into themselves."""
        powers = [arb(1)]
        for _ in range(self.degree):
            powers.append(powers[-1] * radius)

        def series(*column: arb) -> Expansion:
            head = arb_poly([c * p for c, p in zip(column, powers, strict=True)])
            return Expansion(head, arb(0), self.degree)

        start = [combine(series, *x) for x in w]
        image, e = self._picard(start, radius)
        for _ in range(4):
            trial = [combine(_tailed, x, 2 * y) for x, y in zip(start, image, strict=True)]
            image, e = self._picard(trial, radius)
            pairs = [
                (a, b)
                for x, y in zip(image, trial, strict=True)
                for a, b in zip(parts(x), parts(y), strict=True)
            ]
            if all(a.tail <= b.tail for a, b in pairs):
                found = [combine(_tailed, x, y) for x, y in zip(start, image, strict=True)]
                return tuple(found), tuple(e)
        return None

    def _picard(self, w: list[Any], radius: arb) -> tuple[list[Any], list[Any]]:
        """Return start + the integral of the right hand side, and the needed forces."""
        system, modes = self.system, self.modes
        alpha, V = system.alpha, system.V
        one = Expansion(arb_poly([1]), arb(0), self.degree)
        time = one.integral(radius)
        y = [combine(lambda part: part.integral(radius), x) for x in w]
        e = [y[i] * (alpha + 1) - y[1 - i] * alpha + V * time + self.e0[i] for i in (0, 1)]
        image = []
        for i, mode in enumerate(modes):
            if not mode:
                image.append(w[i])
                continue
            force = self.laws[i].force(w[i] * arb(mode)) * (system.limits[i] * arb(-mode))
            rate = force - e[i]
            image.append(combine(lambda part: part.integral(radius), rate) + self.w0[i])
        return image, e


def signals(modes: Modes, limits: Pair, w: Any, e: Any) -> list[tuple[int, int, Any]]:
    """Return what stays positive while the modes last: (block, end, function of time)."""
    # The end is 0 for a landing, 1 or -1 for a rider's upper or lower limit. A rider whose
    # neighbour slips backward is loaded: e' = V - alpha w >= V > 0, so only its upper limit.
    found = []
    for i in (0, 1):
        mode, other = modes[i], modes[1 - i]
        if mode:
            found.append((i, 0, w[i] * arb(mode)))
            continue
        found.append((i, 1, -e[i] + limits[i]))
        if other > 0:
            found.append((i, -1, e[i] + limits[i]))
    return found


def _tailed(start: Expansion, image: Expansion) -> Expansion:
    return Expansion(start.head, image.tail, start.degree)


def parts(x: Any) -> list[Expansion]:
    """List the parts of a number."""
    found: list[Expansion] = []
    combine(found.append, x)
    return found
