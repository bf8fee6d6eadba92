"""Bifurcations followed in the plane of two parameters, breakpoints along one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stickslip.analysis.bifurcation_curve import BifurcationCurve, BreakpointCurve
    from stickslip.analysis.one_d.borders import Border
    from stickslip.analysis.one_d.breakpoints import Breakpoint
    from stickslip.analysis.protocol import MapFamily

__all__ = ["continue_bifurcation", "continue_breakpoint"]


def continue_bifurcation(
    b: Any, system: MapFamily, *, along: str, range: tuple[float, float], solve_for: str
) -> BifurcationCurve:
    """Follow a bifurcation in the plane of two parameters.

    Parameters
    ----------
    b : Bifurcation
        With ``condition``, ``parameter`` and ``value``.
    system : MapFamily
        Has the two parameters; its other ones hold all along the curve.
    along : str
        Parameter that varies over ``range``.
    range : tuple of float
    solve_for : str
        The other parameter.

    Raises
    ------
    ValueError
        A name is not a parameter, the names agree, or the range is no interval.
    """
    raise NotImplementedError


def continue_breakpoint(
    breakpoint_: Breakpoint | Border, system: MapFamily, name: str, range: tuple[float, float]
) -> BreakpointCurve:
    """Follow a breakpoint of a map along one parameter, both ways from where it is known.

    Raises
    ------
    ValueError
        ``name`` is not a parameter, or the range is no interval.
    """
    raise NotImplementedError
