"""Kinetic friction laws. `LAWS` lists those that are built in; everything else reads it."""

from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.friction.stribeck import Stribeck
from stickslip.mechanics.friction.tabulated import TabulatedFriction
from stickslip.mechanics.friction.user_law import UserLaw, friction_law

LAWS: dict[str, type[FrictionLaw]] = {law.name: law for law in (Coulomb, PoppStelter, Stribeck)}

__all__ = [
    "LAWS",
    "Coulomb",
    "FrictionLaw",
    "PoppStelter",
    "Stribeck",
    "TabulatedFriction",
    "UserLaw",
    "friction_law",
]
