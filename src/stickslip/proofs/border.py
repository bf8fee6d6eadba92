"""The parameter value at which a periodic orbit reaches a jump: orbit and event in one system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from flint import arb

from stickslip.proofs.jet import Jet, variables
from stickslip.proofs.jump import mechanism, parted
from stickslip.proofs.newton import NoZero, zero
from stickslip.proofs.power import Image, Setting, step
from stickslip.proofs.verify.words import rounded
from stickslip.proofs.wave import Undecided

RADII: Final = tuple(10.0**-k for k in range(4, 15))


@dataclass(frozen=True)
class _Round:
    """The orbit's round from the jump back to it, on one side."""

    points: list[Jet]
    words: list[str]
    here: Image
    beyond: Image
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

    found, _ = zero(equations, [near, value], RADII, target=arb(10) ** (-digits - 12))
    box = variables([x.mid() for x in found], [x.rad() for x in found])
    closes, grazes = equations(box)
    rate = -closes.gradient[1] / closes.gradient[0]  # of the point along the orbit's branch
    speed = grazes.gradient[1] + grazes.gradient[0] * rate
    if not speed.is_finite() or speed.contains(0):
        raise Undecided("the orbit is not shown to cross the jump transversally")
    around = _round(setting, box, period, sign)
    return {
        "parameter": setting.varied[0],
        "value": rounded(found[1], digits),
        "period": period,
        "points": [rounded(x.range, digits) for x in around.points],
        "itinerary": around.words,
        "itinerary_beyond": around.beyond.itinerary,
        "exists": "below" if bool(speed * sign < 0) else "above",
        "mechanism": mechanism(around.here.decisions[-1]),
    }


def _round(setting: Setting, box: list[Jet], period: int, sign: int) -> _Round:
    """Follow the orbit once from a box that holds the jump."""
    x, *parameters = box
    pieces = parted(step(setting, x, parameters, forks=1, at_touch=True))
    here, beyond = sorted(pieces, key=lambda piece: -sign * piece.decisions[-1].sign)
    points, words = [x], [here.itinerary]
    y = here.value
    for _ in range(period - 1):
        points.append(y)
        (piece,) = step(setting, y, parameters)
        words.append(piece.itinerary)
        y = piece.value
    return _Round(points, words, here, beyond, y)
