"""Branches of periodic orbits along a parameter: what `continue_orbit` returns."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

if TYPE_CHECKING:
    import os

    from matplotlib.axes import Axes

    from stickslip.analysis.one_d.borders import Border
    from stickslip.analysis.orbits import PeriodicOrbit
    from stickslip.analysis.protocol import Floats, Labels, MapFamily

__all__ = ["BranchEnd", "EndReason", "OrbitBranch", "PassedBifurcation"]

EndReason: TypeAlias = Literal[
    "end of range",
    "breakpoint",
    "gap",
    "end of domain",
    "period halves",
    "closed",
    "point limit",
    "step limit",
]


@dataclass(frozen=True, eq=False)
class BranchEnd:
    """Why a branch of orbits ends, and where.

    Attributes
    ----------
    reason : str
        ``end of range``; ``breakpoint``: a point of the orbit meets a jump or a corner of
        the map; ``gap``: it meets the edge of one; ``end of domain``: it meets the end of the
        map's domain or window; ``period halves``: the orbit merges with one of half its
        period, which flips there; ``closed``: the branch is a closed curve and has come back
        to its start; ``point limit`` and ``step limit``: given up after too many steps, or
        where the step became too small.
    value : float
        The parameter there.
    points : ndarray of float, shape (period,)
        The orbit there, a one-sided limit at a breakpoint.
    multiplier : float
        Likewise one-sided.
    border : Border or None
        The break that was met; None at the end of the domain.
    index : int or None
        Which of `points` lies on the break or the end of the domain.
    side : int
        -1 if the orbit comes from the left of the break, 1 from the right; 0 if there is none.
    """

    reason: EndReason
    value: float
    points: Floats
    multiplier: float
    border: Border | None = None
    index: int | None = None
    side: int = 0


@dataclass(frozen=True, eq=False)
class PassedBifurcation:
    """A fold or a flip on the way along a branch.

    Attributes
    ----------
    kind : {"fold", "flip"}
    value : float
        Of the parameter.
    points : ndarray of float, shape (period,)
        The orbit there, ordered as along the branch.
    multiplier : float
        1 or -1 to rounding.
    error : float
        Bound of the error of `value`.
    row : int
        The branch's row that is this point.
    """

    kind: Literal["fold", "flip"]
    value: float
    points: Floats
    multiplier: float
    error: float
    row: int


@dataclass(frozen=True, eq=False, repr=False)
class OrbitBranch:
    """A periodic orbit of a map followed along a parameter, through folds.

    Attributes
    ----------
    parameters : dict of str to ndarray of float, shape (n,)
        The varied parameter by its name, along the branch. It turns back at folds.
    points : ndarray of float, shape (n, period)
        In the map's order; the first column is one point of the orbit all along.
    multipliers : ndarray of float, shape (n,)
    period : int
    labels : ndarray of uint64, shape (n, period)
        Branches of the points.
    residual : ndarray of float, shape (n,)
        Largest abs(f(x_i) - x_(i+1)) of each row.
    ends : tuple of BranchEnd
        First and last.
    bifurcations : tuple of PassedBifurcation
        Folds and flips on the way, each of which is a row of the branch.
    f : MapFamily or None
        The map, restricted to the window if one was given, at the parameters it had when
        the continuation began; None for a branch loaded without its system.
    """

    parameters: dict[str, Floats]
    points: Floats
    multipliers: Floats
    period: int
    labels: Labels = field(repr=False)
    residual: Floats = field(repr=False)
    ends: tuple[BranchEnd, BranchEnd]
    bifurcations: tuple[PassedBifurcation, ...] = ()
    f: MapFamily | None = None

    @property
    def parameter(self) -> str:
        """Name of the varied parameter."""
        (name,) = self.parameters
        return name

    @property
    def values(self) -> Floats:
        """Values of the varied parameter, shape (n,)."""
        return self.parameters[self.parameter]

    @property
    def stable(self) -> Any:
        """Where the multiplier is inside (-1, 1), ndarray of bool, shape (n,)."""
        return np.abs(self.multipliers) < 1

    @property
    def end_reasons(self) -> tuple[EndReason, EndReason]:
        """Why the branch ends where it begins, and where it ends (see `BranchEnd`)."""
        return self.ends[0].reason, self.ends[1].reason

    def __len__(self) -> int:
        """Return the number of points computed along the branch."""
        return len(self.points)

    def at(self, **value: float) -> PeriodicOrbit:
        """Solve for the orbit at a parameter value, given by its name.

        Raises
        ------
        ValueError
            The value is outside the branch; or the branch passes it several times
            (`all_at` returns all of them); or the parameter has another name.

        Examples
        --------
        >>> branch.at(r=3.2)  # doctest: +SKIP
        """
        raise NotImplementedError

    def all_at(self, **value: float) -> tuple[PeriodicOrbit, ...]:
        """Solve for all orbits of the branch at a parameter value, in their order along it."""
        raise NotImplementedError

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the branch over its parameter; see `stickslip.plot.bifurcations`."""
        module = importlib.import_module("stickslip.plot.bifurcations")
        axes: Axes = module.draw_branch(self, ax, **style)
        return axes

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file that `stickslip.load` reads."""
        importlib.import_module("stickslip.analysis.storage").save(self, path)
