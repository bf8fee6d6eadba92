"""Coulomb's law: eq. (8)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from stickslip.mechanics.friction.law import FrictionLaw, NonNegative, Share
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

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))
    >>> model.replace(mu=0.3).friction
    Coulomb(mu=0.3, viscous=0.0)
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


def is_constant(law: FrictionLaw) -> bool:
    """Whether the kinetic friction of a law does not depend on speed."""
    return isinstance(law, Coulomb) and law.viscous == 0.0
