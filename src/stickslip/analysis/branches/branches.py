"""Branches and breakpoints of a map, as a user asks for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, get_args

from stickslip.analysis.branches.breakpoints import Breakpoint, Kind
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.maps.arguments import line_map
from stickslip.analysis.maps.protocol import Map1D, Modelled, explanation
from stickslip.checks import one_of
from stickslip.numerics.waiting import waits
from stickslip.results.result import ResultList
from stickslip.results.table import SHOWN, aligned, more
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from stickslip.analysis.branches.discontinuities import Unresolved


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
    _column_names: ClassVar = Breakpoint._column_names
    _drawn: ClassVar = ("d", "left", "right")

    def of_kind(self, *kinds: Kind) -> tuple[Breakpoint, ...]:
        """Return those that are a ``jump``, ``corner``, ``edge`` or ``smooth``."""
        for kind in kinds:
            one_of("kind", kind, get_args(Kind))
        return tuple(item for item in self.items if item.kind in kinds)

    def __repr__(self) -> str:
        """Table of positions, one-sided values and slopes; the harmless ones last."""
        serious = self.of_kind("jump", "corner", "edge")
        smooth = self.of_kind("smooth")
        lines = [
            f"BreakpointList: {len(serious)} breakpoints, {len(smooth)} harmless changes of "
            f"label, complete above {self.resolution:.2g}",
        ]
        head = ("d", "f(d-)", "f(d+)", "f'(d-)", "f'(d+)", "kind", "")
        lines += aligned([head, *map(_row, serious[:SHOWN])], ">>>>><<")
        lines += more(len(serious))
        if smooth:
            places = ", ".join(f"{item.d:.12g}" for item in smooth[:SHOWN])
            others = f", ... {len(smooth) - SHOWN} more" if len(smooth) > SHOWN else ""
            lines.append(f"  smooth at {places}{others}")
        lines += [f"  unresolved: {item}" for item in self.unresolved[:SHOWN]]
        return "\n".join(lines)


def _row(item: Breakpoint) -> tuple[str, ...]:
    values = (f"{item.d:.15g}", f"{item.left:.10g}", f"{item.right:.10g}")
    slopes = (f"{item.left_slope:.6g}", f"{item.right_slope:.6g}")
    return (*values, *slopes, item.kind, item.mechanism)


@waits
@suggests
def branches(f: Map1D | Modelled[Map1D], resolution: float | None = None) -> BranchTable:
    """Find the branches, breakpoints, gaps and laps of a map.

    Parameters
    ----------
    f : map or model
        An event map, a `PiecewiseMap`, a power of one (``f.power(p)``), or a model.
    resolution : float, optional
        Everything wider is found; what stayed undecided is listed with its reason. By default
        1e-9 of the domain's width, taken to the nearest power of 1024; more where more than 64
        branches narrower than a thousandth of the domain crowd.

    Returns
    -------
    BranchTable
        A sequence of branches; ``breakpoints`` of an event map carry their mechanism.

    Raises
    ------
    ValueError
        Neither a map nor a model; a resolution that is not small beside the domain.

    Examples
    --------
    >>> import stickslip as ss
    >>> len(ss.branches(ss.examples.coulomb()))
    9
    """
    table = branch_table(line_map(f), resolution)
    return replace(table, breakpoints=_explained(table))


@waits
@suggests
def breakpoints(f: Map1D | Modelled[Map1D], resolution: float | None = None) -> BreakpointList:
    """Find where the branches of a map end, to adjacent floats, and why.

    Parameters and errors as in `branches`.

    Returns
    -------
    BreakpointList
        A sequence of `Breakpoint` in ascending order. ``kind`` "smooth" marks changes of the
        itinerary that the map's value and slope do not notice; ``of_kind("jump", "corner",
        "edge")`` leaves them out. ``mechanism`` and ``block`` are known for event maps.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.breakpoints(ss.examples.coulomb()).of_kind("jump")[3].mechanism
    'block 2 grazes its stick interval near X_2 = 0.0258, inside'
    """
    table = branch_table(line_map(f), resolution)
    return BreakpointList(_explained(table), table.resolution, table.unresolved)


def _explained(table: BranchTable) -> tuple[Breakpoint, ...]:
    """Return the breakpoints with their map, and the mechanisms that it tells, if it tells any."""
    if not hasattr(table.f, "explain_break"):
        return tuple(replace(item, system=table.f) for item in table.breakpoints)
    found = []
    for item in table.breakpoints:
        text, block = explanation(table.f, *item.interval)
        found.append(replace(item, mechanism=text, block=block, system=table.f))
    return tuple(found)
