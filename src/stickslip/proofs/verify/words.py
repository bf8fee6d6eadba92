"""How a certificate is written: numbers, and the statement that its data make."""

from __future__ import annotations

from fractions import Fraction
from math import floor, log10
from typing import Any, Final

from flint import arb, fmpq

__all__ = ["KEYS", "SCHEMA", "Refused", "ball", "rounded", "statement"]

SCHEMA: Final = "stickslip-certificate-1"
KEYS: Final = {
    "orbit": {"period", "points", "itinerary", "multiplier", "stable", "alone"},
    "jump": {"d", "left", "right", "itinerary_left", "itinerary_right", "mechanism"},
    "border": {
        "parameter",
        "value",
        "period",
        "points",
        "itinerary",
        "itinerary_beyond",
        "exists",
        "mechanism",
    },
    "list": {"max_period", "orbits", "undecided"},
    "fold": {"parameter", "value", "period", "points", "itinerary", "curvature", "exists"},
    "flip": {
        "parameter",
        "value",
        "period",
        "points",
        "itinerary",
        "rate",
        "cubic",
        "stable",
        "doubled",
    },
}


class Refused(Exception):
    """The certificate does not hold; the message says what was found."""


def ball(text: str) -> arb:
    """Read ``decimal``, ``p/q`` or ``decimal +/- radius`` exactly."""
    try:
        middle, _, radius = text.partition(" +/- ")
        exact, width = Fraction(middle), Fraction(radius or 0)
    except (ValueError, AttributeError, ZeroDivisionError):
        raise Refused(f"{text!r} is not a number") from None
    if width < 0:
        raise Refused(f"{text!r} has a negative radius")
    ends = [arb(fmpq(x.numerator, x.denominator)) for x in (exact - width, exact + width)]
    return ends[0].union(ends[1]) if width else ends[0]


def rounded(x: arb, digits: int) -> str:
    """Write a ball as ``decimal +/- radius``, the radius half a unit of the last digit.

    The decimal has `digits` significant digits, or up to three more where the last could not be
    told: so a number has one form only.

    Raises
    ------
    ValueError
        The ball is wider than that.
    """
    mantissa, exponent = x.mid().man_exp()
    middle = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    mantissa, exponent = x.rad().man_exp()
    radius = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    size = floor(log10(abs(middle))) if middle else 0
    for places in range(max(digits - 1 - size, 1), digits + 4 - size):
        unit = Fraction(10) ** -places
        nearest = round(middle / unit)
        if abs(middle - nearest * unit) + radius <= unit * Fraction(45, 100):
            text = str(abs(nearest)).rjust(places + 1, "0")
            sign = "-" if nearest < 0 else ""
            return f"{sign}{text[:-places]}.{text[-places:]} +/- 5e-{places + 1}"
    raise ValueError(f"{x} has fewer than {digits} digits")


def statement(c: dict[str, Any]) -> str:
    """Say a certificate in words: made from its data, so that the two cannot differ."""
    system = ", ".join(f"{name} = {value}" for name, value in c["system"].items())
    law = "friction law (9)" if {"gamma_1", "delta_1"} & set(c["system"]) else "Coulomb friction"
    head = f"Two blocks with {law}, {system} (exact numbers). "
    return head + {
        "orbit": _orbit_words,
        "jump": _jump_words,
        "border": _border_words,
        "list": _list_words,
        "fold": _fold_words,
        "flip": _flip_words,
    }[c["claim"]](c)


def _orbit_words(c: dict[str, Any]) -> str:
    kind = "asymptotically stable" if c["stable"] else "unstable"
    basin = f", and all starts within {c['alone']} of this point tend to it" if c["stable"] else ""
    return (
        f"The event map has a periodic orbit of minimal period {c['period']} through "
        f"d = {c['points'][0]}. Within {c['alone']} of this point there is no other periodic point "
        f"of that period. Its multiplier is {c['multiplier']}: the orbit is {kind}{basin}."
    )


def _jump_words(c: dict[str, Any]) -> str:
    return (
        f"The event map jumps at d = {c['d']}: {c['mechanism']}. To the left the itinerary is "
        f"{c['itinerary_left']!r} and f tends to {c['left']}; to the right it is "
        f"{c['itinerary_right']!r} and f tends to {c['right']}."
    )


def _border_words(c: dict[str, Any]) -> str:
    return (
        f"As {c['parameter']} varies, the periodic orbit of period {c['period']} with the "
        f"itinerary {' | '.join(c['itinerary'])} reaches a jump of the event map at "
        f"{c['parameter']} = {c['value']}, with the point d = {c['points'][0]}: {c['mechanism']}. "
        f"It crosses the jump transversally: near that value the orbit exists "
        f"{c['exists']} it and not on the other side, where the itinerary of this point would be "
        f"{c['itinerary_beyond']!r}."
    )


def _list_words(c: dict[str, Any]) -> str:
    places = ", ".join(f"{o['points'][0]} (period {o['period']})" for o in c["orbits"])
    tail = f" Undecided: {c['undecided']}." if c["undecided"] else ""
    outside = ", outside the undecided intervals" if c["undecided"] else ""
    return (
        f"The event map has exactly {len(c['orbits'])} periodic orbits of period up to "
        f"{c['max_period']} on its whole domain{outside}: {places}.{tail}"
    )


def _critical_words(c: dict[str, Any], multiplier: int) -> str:
    return (
        f"As {c['parameter']} varies, the periodic orbit of minimal period {c['period']} with the "
        f"itinerary {' | '.join(c['itinerary'])} has the multiplier {multiplier} at "
        f"{c['parameter']} = {c['value']}, with the point d = {c['points'][0]}"
    )


def _fold_words(c: dict[str, Any]) -> str:
    return (
        f"{_critical_words(c, 1)}, where the second derivative of that power of the map is "
        f"{c['curvature']}. It is a fold: near that value two such orbits exist {c['exists']} it, "
        "which meet there, and none on the other side."
    )


def _flip_words(c: dict[str, Any]) -> str:
    kind = "stable" if c["stable"] != c["doubled"] else "unstable"
    side = {"stable": "super", "unstable": "sub"}[kind]
    return (
        f"{_critical_words(c, -1)}. It passes -1 with the derivative {c['rate']} in "
        f"{c['parameter']}, and the cubic coefficient of the normal form is {c['cubic']}: a "
        f"{side}critical flip. Near that value the orbit is asymptotically stable {c['stable']} it "
        f"and unstable on the other side, and an {kind} orbit of twice the period exists "
        f"{c['doubled']} it."
    ).replace("an stable", "a stable")
