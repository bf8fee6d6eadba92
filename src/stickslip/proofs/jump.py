"""Jumps of the event map proven, both sides, and the values at which orbits reach them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from flint import arb

from stickslip.proofs.flow import Piece
from stickslip.proofs.jet import Jet, box_of
from stickslip.proofs.newton import NoZero, zero
from stickslip.proofs.power import Setting, follow, step
from stickslip.proofs.verify.words import rounded
from stickslip.proofs.wave import Undecided

RADII: Final = tuple(10.0**-k for k in range(5, 15))
COLLISION_RADII: Final = tuple(10.0**-k for k in range(4, 15))


def proven_jump(setting: Setting, near: arb, digits: int) -> dict[str, Any]:
    """Prove a jump near a point: the entries of its certificate, place and one-sided values."""

    def margin(box: list[Jet]) -> list[Jet]:
        pieces = parted(step(setting, box[0], forks=1, at_touch=True))
        return [pieces[0].margin]

    (place,), _ = zero(margin, [near], RADII, target=arb(10) ** (-digits - 12))
    (x,) = box_of(place)
    pieces = parted(step(setting, x, forks=1, at_touch=True))
    decision = pieces[0].decisions[-1]
    (rate,) = pieces[0].margin.gradient
    left, right = sorted(pieces, key=lambda p: p.decisions[-1].sign * (1 if rate > 0 else -1))
    values = [piece.value.range for piece in (left, right)]
    if values[0].overlaps(values[1]):
        raise Undecided(
            f"the itinerary changes at d = {rounded(place, digits)}, but the values on both sides "
            f"agree to within {float((values[0] - values[1]).abs_upper()):.1g}: no jump"
        )
    return {
        "d": rounded(place, digits),
        "left": rounded(values[0], digits),
        "right": rounded(values[1], digits),
        "itinerary_left": left.itinerary,
        "itinerary_right": right.itinerary,
        "mechanism": decision.mechanism,
    }


def parted(pieces: list[Piece]) -> list[Piece]:
    """Return the two pieces of a box that one question divides; `Undecided` if it is not one."""
    if len(pieces) == 1:
        raise Undecided(f"f has the one itinerary {pieces[0].itinerary!r} there: no breakpoint")
    if len(pieces) != 2 or any(len(piece.decisions) != 1 for piece in pieces):
        raise Undecided("more than one question stays open there")
    return pieces


@dataclass(frozen=True)
class _Round:
    """The orbit's round from the jump back to it, on one side."""

    points: list[Jet]
    words: list[str]
    here: Piece
    beyond: Piece
    end: Jet


def proven_border(
    setting: Setting, near: arb, value: arb, period: int, digits: int
) -> dict[str, Any]:
    """Prove that an orbit reaches a jump, transversally, at one value of the varied parameter."""
    # `near` and `value` are the orbit's point on the jump and the parameter there, nearly.
    reasons: list[str] = []
    for sign in (1, -1):
        try:
            return _on_side(setting, near, value, period, digits, sign)
        except (NoZero, Undecided) as error:
            reasons.append(str(error))
    raise Undecided(" and ".join(dict.fromkeys(reasons)))


def _on_side(
    setting: Setting, near: arb, value: arb, period: int, digits: int, sign: int
) -> dict[str, Any]:
    def equations(box: list[Jet]) -> list[Jet]:
        around = _round(setting, box, period, sign)
        return [around.end - box[0], around.here.margin]

    found, _ = zero(equations, [near, value], COLLISION_RADII, target=arb(10) ** (-digits - 12))
    box = box_of(*found)
    closes, grazes = equations(box)
    rate = -closes.gradient[1] / closes.gradient[0]  # of the point along the orbit's branch
    speed = grazes.gradient[1] + grazes.gradient[0] * rate
    if not speed.is_finite() or speed.contains(0):
        raise Undecided("the orbit is not shown to cross the jump transversally")
    around = _round(setting, box, period, sign)
    near_by = arb(0, arb(10) ** (-digits - 4))  # the second program looks beside the value
    return {
        "parameter": setting.varied[0],
        "value": rounded(found[1], digits),
        "period": period,
        "points": [rounded(x.range + near_by, digits) for x in around.points],
        "itinerary": around.words,
        "itinerary_beyond": around.beyond.itinerary,
        "exists": "below" if bool(speed * sign < 0) else "above",
        "mechanism": around.here.decisions[-1].mechanism,
    }


def _round(setting: Setting, box: list[Jet], period: int, sign: int) -> _Round:
    """Follow the orbit once from a box that holds the jump."""
    x, *parameters = box
    pieces = parted(step(setting, x, parameters, forks=1, at_touch=True))
    here, beyond = sorted(pieces, key=lambda piece: -sign * piece.decisions[-1].sign)
    points, words, end = follow(setting, here.value, parameters, period - 1)
    return _Round([x, *points], [here.itinerary, *words], here, beyond, end)
