"""Kinetic friction laws. `LAWS` lists those that are built in; everything else reads it."""

from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.mechanics.friction.parse import law_from_text
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.friction.stribeck import Stribeck
from stickslip.mechanics.friction.tabulated import TabulatedFriction
from stickslip.mechanics.friction.user_law import UserLaw, friction_law

LAWS: dict[str, type[FrictionLaw]] = {law.name: law for law in (Coulomb, PoppStelter, Stribeck)}


def parse_law(text: str) -> FrictionLaw:
    """Read a built-in law written as ``"coulomb:mu=0.22"``; see `law_from_text`."""
    return law_from_text(text, LAWS)


__all__ = [
    "LAWS",
    "Coulomb",
    "FrictionLaw",
    "PoppStelter",
    "Stribeck",
    "TabulatedFriction",
    "UserLaw",
    "friction_law",
    "parse_law",
]
