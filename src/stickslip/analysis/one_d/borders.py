"""Breaks and turning points of a map, followed as its parameters change."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Self, TypeAlias

if TYPE_CHECKING:
    from stickslip.analysis.one_d.breakpoints import Breakpoint, Kind
    from stickslip.analysis.protocol import Map1D

__all__ = [
    "Border",
    "BorderReading",
    "ConditionLost",
    "Critical",
    "CriticalKind",
    "Side",
    "TurningPoint",
]

Side: TypeAlias = Literal[-1, 1]
CriticalKind: TypeAlias = Literal["jump", "corner", "smooth", "edge", "turning point"]


class ConditionLost(Exception):
    """What a condition asks for does not exist at these parameter values.

    Attributes
    ----------
    reason : str
        A sentence.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


@dataclass(frozen=True)
class BorderReading:
    """A critical point of one map: where it is and what the map does on either side.

    Attributes
    ----------
    x : float
    left, right : float
        One-sided values of the map, NaN beside a gap; equal at a turning point.
    left_slope, right_slope : float
        One-sided slopes; an infinite one shows a square root; 0 at a turning point.
    kind : str
        ``jump``, ``corner``, ``smooth``, ``edge`` or ``turning point``.
    interval : tuple of float
        Points on either side, adjacent floats at a break.
    critical : Border or TurningPoint
        The same one, started from here.
    """

    x: float
    left: float
    right: float
    left_slope: float
    right_slope: float
    kind: CriticalKind
    interval: tuple[float, float]
    critical: Critical

    def value(self, side: int) -> float:
        """One-sided value: -1 left, 1 right."""
        return self.left if side < 0 else self.right

    def slope(self, side: int) -> float:
        """One-sided slope: -1 left, 1 right."""
        return self.left_slope if side < 0 else self.right_slope


@dataclass(frozen=True)
class Border:
    """A break of a map between two labels, plain data: finds itself in a changed map.

    Attributes
    ----------
    left_label, right_label : int
        Labels of the branches on either side; 0 in a gap.
    x : float
        Where it was last.
    kind : str
        ``jump``, ``corner``, ``smooth`` or ``edge``.
    reach : float
        How far it moved when it was followed last; 0 if never.
    """

    left_label: int
    right_label: int
    x: float
    kind: Kind
    reach: float = field(default=0.0, compare=False)

    @classmethod
    def of(cls, breakpoint_: Breakpoint) -> Self:
        """Make a border of a breakpoint of a map's table."""
        b = breakpoint_
        return cls(b.left_label, b.right_label, b.d, b.kind)

    def at(self, f: Map1D) -> BorderReading:
        """Find the break in a map with other parameter values.

        Raises
        ------
        ConditionLost
            It is not there.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class TurningPoint:
    """A smooth extremum of a map: f'(x) = 0 inside a branch.

    Attributes
    ----------
    x : float
        Where it was last.
    reach : float
        How far it moved when it was followed last; 0 if never.
    """

    x: float
    reach: float = field(default=0.0, compare=False)

    @property
    def kind(self) -> CriticalKind:
        """``turning point``."""
        return "turning point"

    def at(self, f: Map1D) -> BorderReading:
        """Find the turning point in a map with other parameter values.

        Raises
        ------
        ConditionLost
            It is not there.
        """
        raise NotImplementedError


Critical: TypeAlias = Border | TurningPoint
