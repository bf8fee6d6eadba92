"""Friction that falls exponentially with the slip speed from the static limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from stickslip.mechanics.friction.law import Choice, FrictionLaw, NonNegative, Positive, Share
from stickslip.vocabulary import suggests


@suggests
@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    """Stribeck curve: ``F(s) = mu + (1 - mu) exp(-(s / speed)^exponent) + viscous s``.

    Parameters
    ----------
    mu : float
        Friction that remains at large speeds, ``0 <= mu <= 1``.
    speed : float
        Slip speed over which friction falls, ``speed > 0``.
    viscous : float
        Growth of the force with the slip speed, ``viscous >= 0``.
    exponent : {1, 2}
        1 falls at once, 2 (a Gaussian) starts with zero slope.

    Notes
    -----
    Armstrong-Hélouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083-1138, for
    the two exponents with which it is smooth at s = 0.
    """

    name: ClassVar[str] = "stribeck"

    mu: Share
    speed: Positive
    viscous: NonNegative = 0.0
    exponent: Annotated[int, Choice((1, 2))] = 1

    @staticmethod
    def expression(s: Any, mu: Any, speed: Any, viscous: Any, exponent: int) -> Any:
        """Return F(s)."""
        return mu + (1.0 - mu) * np.exp(-((s / speed) ** exponent)) + viscous * s
