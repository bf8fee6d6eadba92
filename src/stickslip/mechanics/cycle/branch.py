"""Branches of limit cycles along a parameter: what `continue_cycle` returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np

from stickslip.numerics.branch import AlongParameter
from stickslip.results.parts import part
from stickslip.results.result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats


CycleKind: TypeAlias = Literal[
    "fold",
    "flip",
    "neimark_sacker",
    "branch_point",
    "hopf",
    "grazing",
    "limit",
    "landing",
    "tie",
]
CycleEndReason: TypeAlias = Literal[
    "end of range",
    "grazing",
    "limit",
    "landing",
    "tie",
    "vanishes",
    "step limit",
    "point limit",
]


@part
@dataclass(frozen=True, eq=False)
class CycleBifurcation:
    """A change on the way along a branch.

    Attributes
    ----------
    kind : str
        ``fold``, ``flip``, ``neimark_sacker``, ``branch_point`` (a multiplier 1 without a fold:
        a symmetry is lost), ``hopf`` (it shrinks onto steady sliding), all smooth; or what
        changes the sequence of modes: ``grazing`` (a slip touches the belt), ``limit`` (the
        needed force of a rider touches its static limit), ``landing`` (a block lands exactly at
        its limit: a stick of zero length), ``tie`` (events of two blocks at once).
    value : float
        Of the parameter.
    error : float
        Estimate of the error of `value`.
    cycle : Cycle
        At `value`; where modes change, the last one with the modes before.
    block : int or None
        That touches or lands, from 1.
    outcome : {"persists", "fold", None}
        Where modes change: whether the cycle goes on with other modes on the far side, or meets
        another one that exists on the same side (a discontinuous fold: both end there).
    row : int
        The branch's row at or just before it.
    """

    kind: CycleKind
    value: float
    error: float
    cycle: Cycle
    block: int | None = None
    outcome: Literal["persists", "fold"] | None = None
    row: int = 0

    def __repr__(self) -> str:
        """One line."""
        block = f", block {self.block}" if self.block is not None else ""
        told = {"persists": ", goes on with other modes", "fold": ", meets another cycle", None: ""}
        return (
            f"{self.kind} at {self.value:.13g} (error {self.error:.1g}){block}{told[self.outcome]}"
        )


@part
@dataclass(frozen=True, eq=False)
class CycleEnd:
    """Why a branch of cycles ends, and where.

    Attributes
    ----------
    reason : str
        ``end of range``; ``grazing``, ``limit``, ``landing`` or ``tie``: modes change there and
        no cycle with other modes was found beside it; ``vanishes``: it shrinks onto steady
        sliding; ``point limit``, ``step limit``: given up after too many points, or where steps
        became too small.
    value : float
        The parameter there.
    """

    reason: CycleEndReason
    value: float


@dataclass(frozen=True, eq=False, repr=False)
class CycleBranch(AlongParameter, Result):
    """A limit cycle followed along a parameter, through folds and changes of modes.

    Attributes
    ----------
    parameters : dict of str to ndarray of float, shape (n,)
        The varied parameter by its name, in order along the branch; it turns back at folds.
    periods : ndarray of float, shape (n,)
    multipliers : ndarray of complex, shape (n, 2 N - 1), or (n, 2 N) of a forced model
    stable : ndarray of bool, shape (n,)
    reach : ndarray of float, shape (n, N)
        Displacement of each block at the section where the period begins.
    cycles : tuple of Cycle
        The cycle of each row.
    bifurcations : tuple of CycleBifurcation
    ends : tuple of CycleEnd
        First and last.
    """

    parameters: dict[str, Floats]
    cycles: tuple[Cycle, ...]
    bifurcations: tuple[CycleBifurcation, ...]
    ends: tuple[CycleEnd, CycleEnd]
    model: Model = field(repr=False)
    _plot: ClassVar = "cycles.plot_cycle_branch"

    @property
    def periods(self) -> Floats:
        """Periods, shape (n,)."""
        return np.array([cycle.period for cycle in self.cycles])

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers, a row each."""
        return np.array([cycle.multipliers for cycle in self.cycles])

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where the cycle attracts, shape (n,)."""
        return np.array([cycle.stable for cycle in self.cycles])

    @property
    def reach(self) -> Floats:
        """Displacements at the start of the period, shape (n, N)."""
        return np.array([cycle.x for cycle in self.cycles])

    @property
    def end_reasons(self) -> tuple[CycleEndReason, CycleEndReason]:
        """Why the branch ends where it begins, and where it ends."""
        return self.ends[0].reason, self.ends[1].reason

    def _columns(self) -> dict[str, Any]:
        return {
            self.parameter: self.values,
            "period": self.periods,
            "multiplier": np.abs(self.multipliers).max(axis=1, initial=0.0),
            "stable": self.stable,
            "events": np.array([len(cycle.events) for cycle in self.cycles]),
        }

    def __repr__(self) -> str:
        """Return a short table: ends and what happens on the way."""
        low, high = float(self.values.min()), float(self.values.max())
        lines = [
            f"CycleBranch: {len(self)} cycles, {self.parameter} = {low:.10g} .. {high:.10g}",
            f"  begins: {self.ends[0].reason} at {self.ends[0].value:.13g}",
            *(f"  {item!r}" for item in self.bifurcations),
            f"  ends: {self.ends[1].reason} at {self.ends[1].value:.13g}",
        ]
        return "\n".join(lines)
