"""Jumps of the event map proven: the condition of the event that decides, and both sides."""

from __future__ import annotations

from typing import Any, Final

from flint import arb

from stickslip.proofs.events import Decision
from stickslip.proofs.jet import Jet, variables
from stickslip.proofs.newton import zero
from stickslip.proofs.power import Image, Setting, step
from stickslip.proofs.verify.words import rounded
from stickslip.proofs.wave import Undecided

RADII: Final = tuple(10.0**-k for k in range(5, 15))


def proven_jump(setting: Setting, near: arb, digits: int) -> dict[str, Any]:
    """Prove a jump near a point: the entries of its certificate, place and one-sided values."""

    def margin(box: list[Jet]) -> list[Jet]:
        pieces = parted(step(setting, box[0], forks=1, at_touch=True))
        return [pieces[0].margin]

    (place,), _ = zero(margin, [near], RADII, target=arb(10) ** (-digits - 12))
    (x,) = variables([place.mid()], [place.rad()])
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
        "mechanism": mechanism(decision),
    }


def parted(pieces: list[Image]) -> list[Image]:
    """Return the two pieces of a box that one question divides; `Undecided` if it is not one."""
    if len(pieces) == 1:
        raise Undecided(f"f has the one itinerary {pieces[0].itinerary!r} there: no breakpoint")
    if len(pieces) != 2 or any(len(piece.decisions) != 1 for piece in pieces):
        raise Undecided("more than one question stays open there")
    return pieces


def mechanism(decision: Decision) -> str:
    """Say in words what happens at the breakpoint."""
    who = " and ".join(map(str, decision.blocks))
    return {
        "graze": f"block {who} grazes the belt velocity",
        "tie": f"the events of blocks {who} coincide",
        "rest": f"block {who} comes to rest with its force exactly at the static limit",
        "onset": "both blocks reach their static limits together at the onset",
    }[decision.kind]
