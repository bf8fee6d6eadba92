"""Functions of time within a phase: constant + rate t + sinusoids, and their first roots."""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from stickslip.proofs.germ import Germ, principal
from stickslip.proofs.jet import Jet, Number, centre, sin_cos, spread, tight


class Undecided(Exception):
    """The box is too wide, or the digits are too few, to tell what happens."""


class Basis(NamedTuple):
    """t and the sines and cosines at it, shared by all waves of a phase."""

    t: Number
    pairs: tuple[tuple[Number, Number], ...]


class Wave:
    """constant + rate t + sum of a cos(omega t) + b sin(omega t), one (a, b) for each omega."""

    __slots__ = ("constant", "omegas", "rate", "terms")

    def __init__(
        self,
        constant: Number,
        rate: Number,
        terms: tuple[tuple[Number, Number], ...],
        omegas: tuple[Number, ...],
    ) -> None:
        self.constant, self.rate, self.terms, self.omegas = constant, rate, terms, omegas

    def basis(self, t: Number) -> Basis:
        """Return what a wave of these frequencies needs at t."""
        return Basis(t, tuple(sin_cos(omega * t) for omega in self.omegas))

    def at(self, basis: Basis) -> Number:
        """Value."""
        value = self.constant + self.rate * basis.t
        for (a, b), (sine, cosine) in zip(self.terms, basis.pairs, strict=True):
            value = value + a * cosine + b * sine
        return tight(value)

    def __call__(self, t: Number) -> Number:
        """Value at t."""
        return self.at(self.basis(t))

    def derivative(self) -> Wave:
        """In time."""
        terms = tuple((w * b, -(w * a)) for w, (a, b) in zip(self.omegas, self.terms, strict=True))
        return Wave(self.rate, arb(0), terms, self.omegas)

    def centre(self) -> Wave:
        """Return the wave at the centre of the box."""
        terms = tuple((centre(a), centre(b)) for a, b in self.terms)
        return Wave(
            centre(self.constant), centre(self.rate), terms, tuple(map(centre, self.omegas))
        )

    def largest(self, order: int) -> arb:
        """Bound the derivative of that order (2 or more) at all times."""
        total = arb(0)
        for omega, (a, b) in zip(self.omegas, self.terms, strict=True):
            swing = (spread(a) ** 2 + spread(b) ** 2).sqrt()
            total += spread(omega) ** order * swing
        return total.upper()

    def __neg__(self) -> Wave:
        """Turn upside down."""
        return self * arb(-1)

    def __mul__(self, k: Number) -> Wave:
        """Multiply by a number."""
        terms = tuple((k * a, k * b) for a, b in self.terms)
        return Wave(k * self.constant, k * self.rate, terms, self.omegas)

    def __add__(self, other: Wave | Number) -> Wave:
        """Add a wave of the same frequencies, or a number."""
        if not isinstance(other, Wave):
            return Wave(self.constant + other, self.rate, self.terms, self.omegas)
        terms = tuple(
            (a + c, b + d) for (a, b), (c, d) in zip(self.terms, other.terms, strict=True)
        )
        return Wave(self.constant + other.constant, self.rate + other.rate, terms, self.omegas)

    def stretched(self, before: int, after: int, omegas: tuple[Number, ...]) -> Wave:
        """Return the wave among more frequencies: so many before its own, so many after."""
        none = (arb(0), arb(0))
        terms = (none,) * before + self.terms + (none,) * after
        return Wave(self.constant, self.rate, terms, omegas)


def root(wave: Wave, window: arb) -> Number:
    """Return the root of a wave in a window: times, for all parameters."""
    # There the wave is strictly monotone and has a root for each parameter; its gradient comes by
    # the implicit function theorem.
    slope = wave.derivative()
    range = _newton(wave, slope, window)
    kernel = wave.centre()
    middle = _newton(kernel, kernel.derivative(), range)
    at = wave(range)
    value = principal(at)
    if not isinstance(value, Jet):
        return middle
    rate = spread(slope(range))
    time = Jet(middle, range, tuple(-a / rate for a in value.gradient), value.box).tight()
    return _germ_of_root(wave, slope, time, at) if isinstance(at, Germ) else time


def _germ_of_root(wave: Wave, slope: Wave, time: Jet, at: Germ) -> Germ:
    """Return the root as a series in d: one more term with each round."""
    none = time * arb(0)
    terms = [time, *(none for _ in at.coefficients[1:])]
    rate = principal(slope(Germ(terms)))
    for k in range(1, len(terms)):
        terms[k] = -(wave(Germ(terms)).coefficients[k] / rate)
    return Germ(terms)


def _newton(wave: Wave, slope: Wave, window: arb) -> arb:
    """Contract a window by interval Newton steps until that stops helping."""
    while True:
        point = window.mid()
        rate = spread(slope(window))
        if not rate.is_finite() or rate.contains(0):
            raise Undecided("an event is not transversal")
        new = (point - spread(wave(point)) / rate).intersection(window)
        if not new.rad() < window.rad() * 0.7:
            return new
        window = new
