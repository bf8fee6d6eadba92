"""Branches and breakpoints of a map, as a user asks for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

from stickslip.analysis.branches.breakpoints import BREAKPOINT_COLUMNS, Breakpoint
from stickslip.analysis.branches.table import RESOLUTION, branch_table
from stickslip.results.result import ResultList

if TYPE_CHECKING:
    from stickslip.analysis.branches.breakpoints import Kind
    from stickslip.analysis.branches.discontinuities import Unresolved
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Map1D

SHOWN: Final = 40  # rows of a list in its repr


@dataclass(frozen=True, eq=False, repr=False)
class BreakpointList(ResultList[Breakpoint]):
    """Breakpoints of a map from left to right: a sequence with what stayed open.

    Attributes
    ----------
    items : tuple of Breakpoint
    resolution : float
        Changes closer to each other than this are one breakpoint.
    unresolved : tuple of Unresolved
    """

    items: tuple[Breakpoint, ...]
    resolution: float
    unresolved: tuple[Unresolved, ...]
    _column_names: ClassVar = BREAKPOINT_COLUMNS
    _drawn: ClassVar = ("d", "left", "right")

    @property
    def _items(self) -> tuple[Breakpoint, ...]:
        return self.items

    def of_kind(self, *kinds: Kind) -> tuple[Breakpoint, ...]:
        """Return those that are a ``jump``, ``corner``, ``edge`` or ``smooth``."""
        return tuple(item for item in self.items if item.kind in kinds)

    def __repr__(self) -> str:
        """Table of positions, one-sided values and slopes; the harmless ones last."""
        serious = self.of_kind("jump", "corner", "edge")
        smooth = self.of_kind("smooth")
        lines = [
            f"BreakpointList: {len(serious)} breakpoints, {len(smooth)} harmless changes of "
            f"label, complete above {self.resolution:.2g}",
            "                   d          f(d-)          f(d+)      f'(d-)      f'(d+)  kind",
        ]
        lines += [_row(item) for item in serious[:SHOWN]]
        if len(serious) > SHOWN:
            lines.append(f"  ... {len(serious) - SHOWN} more")
        if smooth:
            places = ", ".join(f"{item.d:.12g}" for item in smooth[:SHOWN])
            more = f", ... {len(smooth) - SHOWN} more" if len(smooth) > SHOWN else ""
            lines.append(f"  smooth at {places}{more}")
        lines += [f"  unresolved: {item}" for item in self.unresolved[:SHOWN]]
        return "\n".join(lines)


def _row(item: Breakpoint) -> str:
    values = f"{item.d:20.15g}{item.left:15.10g}{item.right:15.10g}"
    slopes = f"{item.left_slope:12.6g}{item.right_slope:12.6g}"
    return f"{values}{slopes}  {item.kind:6s}  {item.mechanism}".rstrip()


def branches(f: Map1D, resolution: float = RESOLUTION) -> BranchTable:
    """Find the branches of a map, and with them its breakpoints, gaps and laps.

    Parameters
    ----------
    f : Map1D
        An event map, a `PiecewiseMap` or a power of one (``f.power(p)``).
    resolution : float
        Branches, gaps and laps wider than this are found. Narrower ones between two of the
        same label may be missed; narrower ones between two different ones are part of one
        breakpoint.

    Returns
    -------
    BranchTable
        A sequence of `Branch`; ``unresolved`` says where branches accumulate or the map
        is too rough.

    Raises
    ------
    ValueError
        The resolution is not positive or not small beside the domain.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x: 3 * x % 1, (0, 1), breakpoints=[1 / 3, 2 / 3])
    >>> [(round(b.left, 6), round(b.right, 6)) for b in ss.branches(f)]
    [(0.0, 0.333333), (0.333333, 0.666667), (0.666667, 1.0)]
    """
    return branch_table(f, resolution)


def breakpoints(f: Map1D, resolution: float = RESOLUTION) -> BreakpointList:
    """Find where the branches of a map end, to adjacent floats.

    Parameters
    ----------
    f : Map1D
        An event map, a `PiecewiseMap` or a power of one.
    resolution : float
        As in `branches`.

    Returns
    -------
    BreakpointList
        A sequence of `Breakpoint`; ``of_kind("jump", "corner", "edge")`` leaves out the
        harmless ones.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x: abs(x - 0.25), (0, 1))
    >>> [(b.d, b.kind, b.left_slope, b.right_slope) for b in ss.breakpoints(f)]
    [(0.25, 'corner', -1.0, 1.0)]
    """
    table = branch_table(f, resolution)
    return BreakpointList(table.breakpoints, table.resolution, table.unresolved)
