"""The kinetic friction laws that are built in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from stickslip.mechanics.friction.law import Choice, FrictionLaw, NonNegative, Positive, Share
from stickslip.vocabulary import suggests


@suggests
@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """Constant kinetic friction, with viscous friction if wanted: ``F(s) = mu + viscous s``.

    Parameters
    ----------
    mu : float
        Kinetic friction over the static limit, ``0 <= mu <= 1``.
    viscous : float
        Growth of the force with the slip speed, ``viscous >= 0``. It counts among the
        `parameters` of a model only where it is not zero.

    Notes
    -----
    Galvanetto (2001), eq. (8). For ``mu < 1`` the force jumps where a stick ends.
    """

    name: ClassVar[str] = "coulomb"

    mu: Share
    viscous: NonNegative = 0.0

    @staticmethod
    def expression(s: Any, mu: Any, viscous: Any) -> Any:
        """Eq. (8) in s = |w|."""
        return mu + viscous * s

    @property
    def parameters(self) -> dict[str, float]:
        """``{"mu": ...}``, and ``"viscous"`` unless it is zero (then the law is eq. 8)."""
        values = self.arguments
        if self.viscous == 0.0:
            del values["viscous"]
        return values


@suggests
@dataclass(frozen=True)
class PoppStelter(FrictionLaw):
    """Continuous stick-slip transition: ``F(s) = (1-delta)/(1+gamma s) + delta + eta s^2``.

    Parameters
    ----------
    gamma : float
        How fast friction falls with the slip speed, ``gamma >= 0``.
    delta : float
        Friction that remains at large speeds, ``0 <= delta <= 1``.
    eta : float
        Growth at large speeds, ``eta >= 0``.

    Notes
    -----
    Galvanetto (2001), eq. (9), after Popp & Stelter (1990). The paper writes it in the
    relative velocity w; with ``s = |w|`` both of its lines become the one formula above.
    F(0) = 1, so that a block starts to slip with zero acceleration relative to the belt.
    """

    name: ClassVar[str] = "popp-stelter"

    gamma: NonNegative
    delta: Share = 0.0
    eta: NonNegative = 0.0

    @staticmethod
    def expression(s: Any, gamma: Any, delta: Any, eta: Any) -> Any:
        """Eq. (9) in s = |w|."""
        return (1.0 - delta) / (1.0 + gamma * s) + delta + eta * s**2


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
