"""Steady sliding: where it is, and the belt speed at which it loses stability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from scipy.optimize import brentq

from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Equilibrium", "equilibria"]

Model: TypeAlias = TwoBlock | BeltModel

N_SPEEDS: Final = 400
SPEEDS: Final = (1e-4, 1e2)
"""Range of belt speeds in which changes of stability are looked for."""

NEUTRAL: Final = 1e-12
"""Of the largest frequency: growth rates this small are rounding."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Steady sliding: all blocks rest in space while the belt moves on beneath them.

    Attributes
    ----------
    x : ndarray of float, shape (N,)
        Displacements.
    V : float
        Speed of the belt, and of the slip.
    eigenvalues : ndarray of complex, shape (2 N,)
        Of small motions about it, by descending growth rate.
    stable : bool
        All growth rates are negative; an undamped mode makes it neutral, which is not stable.
    neutral : bool
        The largest growth rate is zero: small motions neither grow nor decay.
    critical_speeds : ndarray of float
        Belt speeds from 1e-4 to 100 at which it changes its stability, ascending.
    """

    x: Floats
    V: float
    eigenvalues: NDArray[np.complex128]
    stable: bool
    neutral: bool
    critical_speeds: Floats

    def __repr__(self) -> str:
        """Stability, then the modes."""
        word = "neutral" if self.neutral else "stable" if self.stable else "unstable"
        speeds = ", ".join(f"{v:.10g}" for v in self.critical_speeds) or "none"
        lines = [f"Equilibrium: steady sliding at V = {self.V:.10g}, {word}"]
        lines.append(f"  x = {', '.join(f'{x:.10g}' for x in self.x)}")
        lines.append(f"  changes its stability at V = {speeds}")
        lines += [
            f"  growth rate {value.real:14.8g}   frequency {value.imag:.10g}"
            for value in self.eigenvalues
            if value.imag >= 0
        ]
        return "\n".join(lines)


def equilibria(model: Model) -> tuple[Equilibrium, ...]:
    """Find the steady sliding of a model, its stability, and where that changes with V.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain or Oscillator
        Unforced, with V > 0.

    Returns
    -------
    tuple of Equilibrium
        One: at a given belt speed the friction forces, and with them the displacements, are
        given.

    Raises
    ------
    ValueError
        The model is forced.

    Notes
    -----
    ``K X = limit F(V)``; small motions obey ``M y'' + (C + diag(limit F'(V))) y' + K y = 0``: a
    law that falls with speed feeds energy (negative damping), which is how brakes squeal.
    """
    structure = model.structure
    if structure.is_forced:
        raise ValueError(
            "a forced model has no equilibrium. Take the model without its forcing, "
            "model.replace(forcing=None)."
        )
    friction = structure.static * [float(law.force(model.V)) for law in model.laws]
    values = _eigenvalues(model, model.V)
    largest = float(values[0].real)
    neutral = abs(largest) <= NEUTRAL * np.abs(values).max()
    return (
        Equilibrium(
            x=np.asarray(np.linalg.solve(structure.stiffness, friction), dtype=np.float64),
            V=model.V,
            eigenvalues=values,
            stable=largest < 0.0 and not neutral,
            neutral=neutral,
            critical_speeds=_critical_speeds(model),
        ),
    )


def _eigenvalues(model: Model, V: float) -> NDArray[np.complex128]:
    """Eigenvalues of small motions about steady sliding at a belt speed."""
    s = model.structure
    n = s.n_blocks
    feeding = s.damping + np.diag(s.static * [float(law.slope(V)) for law in model.laws])
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -s.stiffness / s.mass[:, None]
    matrix[n:, n:] = -feeding / s.mass[:, None]
    values = np.linalg.eigvals(matrix).astype(np.complex128)
    return np.asarray(values[np.lexsort((-values.imag, -values.real))])


def _critical_speeds(model: Model) -> Floats:
    """Speeds at which the largest growth rate changes its sign."""

    def growth(V: float) -> float:
        values = _eigenvalues(model, V)
        rate = float(values[0].real)
        return 0.0 if abs(rate) <= NEUTRAL * np.abs(values).max() else rate

    speeds = np.geomspace(*SPEEDS, N_SPEEDS)
    rates = np.array([growth(float(V)) for V in speeds])
    found = [
        float(brentq(growth, speeds[k], speeds[k + 1], xtol=1e-300, rtol=1e-14))
        for k in np.flatnonzero(rates[:-1] * rates[1:] < 0)
    ]
    return np.array(found)
