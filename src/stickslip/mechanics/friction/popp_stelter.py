"""Friction that falls with the slip speed from the static limit: eq. (9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from stickslip.mechanics.friction.law import FrictionLaw, NonNegative, Share
from stickslip.vocabulary import suggests


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

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.PoppStelter(gamma=3.0, delta=0.2)
    >>> law.force([0.0, 0.1, 1e6]).round(6)  # the static limit is 1; delta remains at high speed
    array([1.      , 0.815385, 0.2     ])
    """

    name: ClassVar[str] = "popp-stelter"

    gamma: NonNegative
    delta: Share = 0.0
    eta: NonNegative = 0.0

    @staticmethod
    def expression(s: Any, gamma: Any, delta: Any, eta: Any) -> Any:
        """Eq. (9) in s = |w|."""
        return (1.0 - delta) / (1.0 + gamma * s) + delta + eta * s**2
