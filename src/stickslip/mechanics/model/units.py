"""Physical scales: what one dimensionless unit is (definitions under eq. 6a)."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from stickslip.checks import finite_number, one_of, real_numbers
from stickslip.results.parts import part
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

Quantity = Literal[
    "displacement", "time", "frequency", "velocity", "acceleration", "force", "energy"
]


@part
@suggests
@dataclass(frozen=True)
class Units:
    """Scales that make the two-block system dimensionless.

    Any coherent set works (SI: kg, N/m, N). With X = k x / f_s1 and
    tau = sqrt(k / m) t every other scale follows, see `scale`.

    Parameters
    ----------
    m : float
        Mass of a block, > 0.
    k : float
        Stiffness of a support spring, > 0.
    fs1 : float
        Static limit of block 1, > 0.

    Notes
    -----
    Galvanetto (2001), definitions under eq. (6a). The printed
    "tau = sqrt(k/mt)" is a misprint: only sqrt(k/m) t is dimensionless, and only
    it gives d/dt = sqrt(k/m) d/dtau, printed in the same sentence.

    A law given in physical slip speeds becomes dimensionless through the velocity
    scale ``u = units.scale("velocity")``: a coefficient per speed is multiplied by
    u (gamma, viscous), one per speed squared by u**2 (eta), a speed divided by u.
    Shares of the static limit (mu, delta) stay.

    Examples
    --------
    >>> units = Units(m=2.0, k=8.0, fs1=4.0)
    >>> units.scale("displacement"), units.scale("time"), units.scale("velocity")
    (0.5, 0.5, 1.0)
    >>> float(units.to_physical("force", 0.25))
    1.0
    """

    m: float
    k: float
    fs1: float

    def __post_init__(self) -> None:
        """Check every number once and store it as a float."""
        reasons = {
            "m": "A block without mass has no equation of motion.",
            "k": "The support spring's stiffness sets the scales of length and time.",
            "fs1": "The static limit of block 1 sets the scale of force.",
        }
        for name, why in reasons.items():
            value = finite_number(name, getattr(self, name), above=0.0, why=why)
            object.__setattr__(self, name, value)

    def scale(self, quantity: Quantity) -> float:
        """Physical size of one dimensionless unit.

        Parameters
        ----------
        quantity : str
            ``"displacement"`` f_s1/k, ``"time"`` sqrt(m/k), ``"frequency"``
            sqrt(k/m), ``"velocity"`` f_s1/sqrt(k m), ``"acceleration"`` f_s1/m,
            ``"force"`` f_s1 or ``"energy"`` f_s1^2/k.

        Returns
        -------
        float
            In the units in which m, k and fs1 were given.

        Raises
        ------
        ValueError
            Unknown quantity.
        """
        one_of("quantity", quantity, get_args(Quantity))
        match quantity:
            case "displacement":
                return self.fs1 / self.k
            case "time":
                return sqrt(self.m / self.k)
            case "frequency":
                return sqrt(self.k / self.m)
            case "velocity":
                return self.fs1 / sqrt(self.k * self.m)
            case "acceleration":
                return self.fs1 / self.m
            case "force":
                return self.fs1
        return self.fs1**2 / self.k  # of energy

    def to_physical(self, quantity: Quantity, value: ArrayLike) -> NDArray[np.float64]:
        """Multiply dimensionless values by their scale.

        Parameters
        ----------
        quantity : str
            As in `scale`.
        value : array_like of float, any shape
            Dimensionless.

        Returns
        -------
        ndarray of float64, same shape
            Physical.
        """
        return np.multiply(real_numbers("value", value), self.scale(quantity), dtype=np.float64)

    def to_dimensionless(self, quantity: Quantity, value: ArrayLike) -> NDArray[np.float64]:
        """Divide physical values by their scale: the inverse of `to_physical`.

        Parameters
        ----------
        quantity : str
            As in `scale`.
        value : array_like of float, any shape
            Physical.

        Returns
        -------
        ndarray of float64, same shape
            Dimensionless.
        """
        return np.divide(real_numbers("value", value), self.scale(quantity), dtype=np.float64)
