"""Curves of a bifurcation in the plane of two parameters, and of a breakpoint along one."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    import os

    from matplotlib.axes import Axes

    from stickslip.analysis.one_d.borders import Border, BorderReading
    from stickslip.analysis.one_d.conditions import Condition, Reading
    from stickslip.analysis.protocol import Floats

__all__ = ["BifurcationCurve", "BreakpointCurve", "CodimensionTwo", "CurvePoint"]

SHOWN: Final = 24  # points of a curve in its repr


@dataclass(frozen=True)
class CodimensionTwo:
    """A point of a bifurcation curve where the type of the bifurcation changes.

    Attributes
    ----------
    kind : str
        ``cusp``, ``breakpoint``, ``generalised flip``, ``multiplier 1``, ``multiplier -1``,
        ``multiplier 0``, ``kind of border``, ``second border`` or ``end of border``.
    what : str
        A sentence.
    parameters : dict
        Both parameter values by name.
    points : tuple of float
        The orbit there.
    position : float
        Place on the curve: number of the point before, plus the share of the way to the next.
    """

    kind: str
    what: str
    parameters: dict[str, float]
    points: tuple[float, ...]
    position: float

    def __str__(self) -> str:
        """One line."""
        where = ", ".join(f"{name} = {value:.13g}" for name, value in self.parameters.items())
        return f"{self.kind} at {where}: {self.what}"


@dataclass(frozen=True)
class CurvePoint:
    """A point of a bifurcation curve, solved for anew.

    Attributes
    ----------
    parameters : dict
        Both parameter values by name.
    value, error : float
        Of the parameter that was solved for.
    residual : float
        Test function there.
    points : tuple of float
        The orbit.
    multipliers : tuple of float
        Of the orbit; of a border collision the one-sided ones.
    reading : Reading
    """

    parameters: dict[str, float]
    value: float
    error: float
    residual: float
    points: tuple[float, ...]
    multipliers: tuple[float, ...]
    reading: Reading = field(repr=False)


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationCurve:
    """A bifurcation followed in the plane of two parameters; `continue_bifurcation` makes it.

    Attributes
    ----------
    kind : str
        Of the bifurcation: ``fold``, ``border_collision``, ...
    period : int
    along, solve_for : str
        Names of the two parameters.
    parameters : dict
        Both by name, shapes (n,), in the curve's order; ends of the range exactly.
    points : ndarray of float, shape (n, period)
        The orbit at each.
    multipliers : ndarray of float, shape (n,)
        Of the orbit; of a border collision that on the side it comes from.
    one_sided : ndarray of float, shape (n, 2)
        Left and right multiplier at the border; both `multipliers` for other kinds.
    end_reasons : tuple of str
        Why the curve ends at its first and at its last point.
    bifurcations : tuple of CodimensionTwo
        In the curve's order.
    conditions : tuple
        The condition at each point, to solve again from there.
    system : map family
        With values of all parameters; None after loading, if it cannot be stored.
    """

    kind: str
    period: int
    along: str
    solve_for: str
    parameters: dict[str, Floats]
    points: Floats
    multipliers: Floats
    one_sided: Floats
    end_reasons: tuple[str, str]
    bifurcations: tuple[CodimensionTwo, ...]
    conditions: tuple[Condition, ...]
    system: Any = None

    def at(self, *, near: float | None = None, **where: float) -> CurvePoint:
        """Solve for the bifurcation at one value of either parameter: ``curve.at(alpha=1.2)``.

        Parameters
        ----------
        near : float, optional
            Of the other parameter: which solution is meant where the curve has several.
        **where
            One parameter by name.

        Raises
        ------
        ValueError
            Not one of the two parameters; a value that the curve does not reach, or
            reaches several times and ``near`` is not given.
        """
        raise NotImplementedError

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the curve and mark its special points; see `stickslip.plot.bifurcations`."""
        module = importlib.import_module("stickslip.plot.bifurcations")
        axes: Axes = module.draw_curve(self, ax, **style)
        return axes

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file that `stickslip.load` reads."""
        importlib.import_module("stickslip.analysis.storage").save(self, path)


@dataclass(frozen=True, eq=False, repr=False)
class BreakpointCurve:
    """A breakpoint followed along one parameter; `continue_breakpoint` makes it.

    Attributes
    ----------
    parameter : str
    values : ndarray of float, shape (n,)
        Ascending values of the parameter.
    d : ndarray of float, shape (n,)
        Where the breakpoint is.
    left, right, left_slope, right_slope : ndarray of float, shape (n,)
        One-sided values and slopes of the map.
    kinds : tuple of str, length n
        ``jump``, ``corner``, ``smooth`` or ``edge``.
    end_reasons : tuple of str
        Why the curve ends at its lowest and highest value.
    borders : tuple of Border, length n
    system : map family
    """

    parameter: str
    values: Floats
    d: Floats
    left: Floats
    right: Floats
    left_slope: Floats
    right_slope: Floats
    kinds: tuple[str, ...]
    end_reasons: tuple[str, str]
    borders: tuple[Border, ...]
    system: Any = None

    def at(self, **where: float) -> BorderReading:
        """Find the breakpoint at one value of the parameter: ``curve.at(V=0.037)``.

        Raises
        ------
        ValueError
            Not the curve's parameter, or a value outside the curve.
        """
        raise NotImplementedError

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw position against parameter; see `stickslip.plot.bifurcations`."""
        module = importlib.import_module("stickslip.plot.bifurcations")
        axes: Axes = module.draw_breakpoint_curve(self, ax, **style)
        return axes

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a file that `stickslip.load` reads."""
        importlib.import_module("stickslip.analysis.storage").save(self, path)
