"""The paper's two systems, ready to use (Galvanetto 2001, section 4).

>>> import stickslip as ss
>>> ss.examples.coulomb(V=0.05).V, ss.examples.law9().friction.gamma
(0.05, 3.0)
"""

from __future__ import annotations

from typing import Any

from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.two_block import TwoBlock

__all__ = ["coulomb", "law9"]


def coulomb(**changes: Any) -> TwoBlock:
    """Coulomb system of the paper's figures 4 to 10.

    Parameters
    ----------
    **changes
        Parameters to change, by the names of `TwoBlock.parameters`.

    Returns
    -------
    TwoBlock
        alpha = 1.2, beta = 1.3, mu = 0.22; V = 0.0366, the left end of the
        paper's range 0.0366 < V < 0.0372, unless changed.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.examples.coulomb(V=0.037).parameters["V"]
    0.037
    """
    model = TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=Coulomb(mu=0.22))
    return model.replace(**changes)


def law9(**changes: Any) -> TwoBlock:
    """System with the falling friction law (9) of the paper's figures 11 to 17.

    Parameters
    ----------
    **changes
        Parameters to change, by the names of `TwoBlock.parameters`.

    Returns
    -------
    TwoBlock
        beta = 1.301, V = 0.295, gamma = 3, delta = eta = 0; alpha = 1.208, the
        left end of the paper's range 1.208 < alpha < 1.21865, unless changed.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.examples.law9(alpha=1.211).alpha
    1.211
    """
    friction = PoppStelter(gamma=3.0, delta=0.0, eta=0.0)
    return TwoBlock(alpha=1.208, beta=1.301, V=0.295, friction=friction).replace(**changes)
