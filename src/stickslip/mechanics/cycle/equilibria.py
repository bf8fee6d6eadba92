"""Steady sliding: where it is, its modes, and the belt speeds at which it loses stability."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.checks import checked_interval, shown
from stickslip.mechanics.cycle.hopf import HopfPoint, hopf_points
from stickslip.mechanics.cycle.neutral import NeutralFamily, neutral_family
from stickslip.mechanics.cycle.sliding import Model, Steady, modes_about, steady_states
from stickslip.mechanics.model.arguments import checked_model
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.numerics.arrays import Floats

SPEEDS: Final = (1e-4, 1e2)


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Result):
    """Steady sliding: all blocks rest in space while the belt moves on beneath them.

    Attributes
    ----------
    x : ndarray of float, shape (N,)
        Displacements; of what turns freely, from its middle place.
    w : ndarray of float, shape (m,)
        Velocities of slip at the contacts: -V of blocks on a belt.
    V : float
        Speed of the belt; NaN where contacts have several.
    eigenvalues : ndarray of complex
        Of small motions about it, by descending growth rate: 2 N of N blocks. The zeros of free
        turning are left out.
    stable : bool
        All growth rates are negative; an undamped mode makes it neutral, which is not stable.
    neutral : bool
        The largest growth rate is zero: small motions neither grow nor decay.
    speeds : tuple of float
        Range of belt speeds in which `hopf_points` are looked for.
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    """

    x: Floats
    w: Floats
    V: float
    eigenvalues: NDArray[np.complex128]
    stable: bool
    neutral: bool
    speeds: tuple[float, float]
    model: Model = field(repr=False)
    _drawn: ClassVar = ("growth_rate", "frequency")

    @cached_property
    def neutral_family(self) -> NeutralFamily | None:
        """The motions about it, none of which is a cycle, and where they graze the belt.

        None unless undamped and under constant friction.
        """
        return neutral_family(self.model)

    @cached_property
    def hopf_points(self) -> tuple[HopfPoint, ...]:
        """Where a pair of modes begins or ceases to grow in the range of belt speeds.

        Raises
        ------
        ValueError
            Contacts have speeds of their own, `Structure`: follow the equilibrium along one.
        """
        if not self._on_one_belt:
            names = [name for name in self.model.parameters if name.startswith("V_")]
            raise ValueError(
                "hopf_points and critical_speeds are speeds of a model's one belt V; contacts of "
                f"a Structure have {', '.join(names)}. Take the bifurcations of "
                f"stickslip.follow(equilibrium, {names[0]!r}, (low, high))."
            )
        return hopf_points(self.model, self.speeds)

    @property
    def _on_one_belt(self) -> bool:
        return "V" in self.model.parameters

    @property
    def critical_speeds(self) -> Floats:
        """Belt speeds at which it changes its stability, ascending."""
        return np.unique([point.V for point in self.hopf_points if point.changes_stability])

    def __repr__(self) -> str:
        """Stability, then the modes."""
        word = "neutral" if self.neutral else "stable" if self.stable else "unstable"
        w, x = (", ".join(f"{value:.10g}" for value in values) for values in (self.w, self.x))
        where = f"V = {self.V:.10g}" if self._on_one_belt else f"w = {w}"
        lines = [f"Equilibrium: steady sliding at {where}, {word}", f"  x = {x}"]
        if self._on_one_belt:
            lines += [f"  {point!r}" for point in self.hopf_points]
            if not self.critical_speeds.size:
                lines.append("  keeps its stability at all belt speeds searched")
        lines += [
            f"  growth rate {value.real:14.8g}   frequency {value.imag:.10g}"
            for value in self.eigenvalues
            if value.imag >= 0
        ]
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        return {"growth_rate": self.eigenvalues.real, "frequency": self.eigenvalues.imag}


@suggests
def equilibria(model: Model, *, speeds: tuple[float, float] = SPEEDS) -> tuple[Equilibrium, ...]:
    """Find the steady sliding of a model, its stability, and where that changes with V.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
        Unforced, with V > 0.
    speeds : tuple of float
        Range of belt speeds in which changes of stability are looked for, above 0.

    Returns
    -------
    tuple of Equilibrium
        One where springs hold all bodies: belts' speeds give the friction forces, and these the
        displacements. None where a contact rests or opens. What turns freely may have several.

    Raises
    ------
    ValueError
        The model is forced, or the range is none.

    Notes
    -----
    ``K X = limit F(V)``; small motions obey ``M y'' + (C + diag(limit F'(V))) y' + K y = 0``: a
    law that falls with speed feeds energy (negative damping), which is how brakes squeal.
    Derivation: docs/theory/cycles.md.

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.4, friction=ss.PoppStelter(gamma=3), damping=1.171875)
    >>> (sliding,) = ss.equilibria(block)
    >>> sliding.hopf_points[0]
    HopfPoint: V = 0.2, frequency 1, subcritical, calms as V grows
    """
    plant = checked_model(model).plant
    if plant.is_forced:
        raise ValueError(
            f"model = {shown(model)} is forced: it has no equilibrium. Take the model "
            "without its forcing, model.replace(forcing=None)."
        )
    low, high = checked_interval("speeds", speeds)
    if low <= 0.0:
        raise ValueError(f"speeds = {shown(speeds)} is not allowed: belt speeds above 0")
    return tuple(equilibrium_at(model, steady, (low, high)) for steady in steady_states(model))


def equilibrium_at(
    model: Model, steady: Steady, speeds: tuple[float, float] = SPEEDS
) -> Equilibrium:
    """Describe steady sliding and its stability."""
    values = modes_about(model.plant, model.laws, steady).values
    largest = float(values[0].real)
    return Equilibrium(
        x=steady.x,
        w=steady.w,
        V=model.V,
        eigenvalues=values,
        stable=largest < 0.0,
        neutral=largest == 0.0,
        speeds=speeds,
        model=model,
    )
