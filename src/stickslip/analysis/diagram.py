"""Bifurcation diagrams: periodic orbits, attractors and breakpoints over a parameter."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.protocol import Floats, MapFamily

__all__ = [
    "AttractorTable",
    "BreakLine",
    "CurveEnd",
    "Diagram",
    "OrbitCurve",
    "bifurcation_diagram",
]

AttractorKind: TypeAlias = Literal["periodic", "chaotic", "undecided"]


@dataclass(frozen=True, eq=False)
class CurveEnd:
    """Where a curve of orbits ends.

    Attributes
    ----------
    value : float
        Of the parameter, located.
    points : ndarray of float, shape (p,)
        The orbit there.
    reason : str
        "end of range", or what happens: "fold", "flip", "breakpoint", "gap", ...
    """

    value: float
    points: Floats
    reason: str


@dataclass(frozen=True, eq=False)
class OrbitCurve:
    """One periodic orbit over the values at which it exists.

    Attributes
    ----------
    period : int
        Minimal.
    points : ndarray of float, shape (n, p)
        In the map's order; NaN at values without the orbit.
    multipliers : ndarray of float, shape (n,)
        NaN at values without the orbit.
    ends : tuple of CurveEnd
        The lower and the upper one.
    """

    period: int
    points: Floats
    multipliers: Floats
    ends: tuple[CurveEnd, CurveEnd]


@dataclass(frozen=True, eq=False)
class AttractorTable:
    """Attractors, one row for each at each value; arrays of shape (m,) unless said otherwise.

    Attributes
    ----------
    where : ndarray of int
        Place of the parameter in the diagram's ``values``; ascending.
    kind : ndarray of str
        "periodic", "chaotic" or "undecided".
    period : ndarray of int
        Of a periodic attractor, else 0.
    lyapunov : ndarray of float
        Mean of log |f'| per step.
    points : ndarray of float, shape (m, k)
        The cycle, or successive iterates; NaN fills the rest of a row.
    """

    where: NDArray[Any]
    kind: NDArray[Any]
    period: NDArray[Any]
    lyapunov: Floats
    points: Floats


@dataclass(frozen=True, eq=False)
class BreakLine:
    """A breakpoint of the map over the values at which it exists.

    Attributes
    ----------
    kind : str
        "jump", "corner" or "edge".
    d : ndarray of float, shape (n,)
        NaN at values without it.
    """

    kind: str
    d: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Diagram:
    """What a map does over a range of one parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray of float, shape (n,)
        Ascending.
    max_period : int
        All orbits up to this period are in `orbits`.
    window : tuple of float or None
        Part of the domain that was looked at.
    orbits : tuple of OrbitCurve
        By period, then by lowest value.
    attractors : AttractorTable
    breakpoints : tuple of BreakLine
    """

    parameter: str
    values: Floats
    max_period: int
    window: tuple[float, float] | None
    orbits: tuple[OrbitCurve, ...]
    attractors: AttractorTable
    breakpoints: tuple[BreakLine, ...]

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the diagram; see `stickslip.plot.diagram.draw_diagram`."""
        module = importlib.import_module("stickslip.plot.diagram")
        axes: Axes = module.draw_diagram(self, ax, **style)
        return axes

    def table(self) -> str:
        """Say which orbits exist where, and how they begin and end, as text."""
        raise NotImplementedError

    def to_xarray(self) -> Any:
        """Return the diagram as an ``xarray.Dataset`` (needs the extra ``sweep``)."""
        raise NotImplementedError

    def save(self, path: str | Path) -> Path:
        """Write the diagram to a file that `stickslip.load` reads."""
        raise NotImplementedError


def bifurcation_diagram(
    family: MapFamily,
    name: str,
    values: ArrayLike,
    *,
    max_period: int = 4,
    window: tuple[float, float] | None = None,
    iterates: int = 64,
    attractors: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Diagram:
    """Follow all periodic orbits, attractors and breakpoints of a map over a parameter.

    Parameters
    ----------
    family : map with parameters
    name : str
        Parameter that varies.
    values : array_like of float, shape (n,)
        Its values, ascending.
    max_period : int
        All orbits up to this period are followed.
    window : tuple of float, optional
        Part of the domain to look at; orbits that leave it have left.
    iterates : int
        Points kept of an attractor that is no short cycle.
    attractors : bool
        Whether to look for attractors other than the stable ones among the orbits.
    progress : callable, optional
        Told the share of the work that is done.

    Returns
    -------
    Diagram
    """
    raise NotImplementedError
