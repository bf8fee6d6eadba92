"""Bifurcations as zeros of scalar functions of a map, each with a regular problem inside."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from stickslip.analysis.one_d.borders import BorderReading, Critical
    from stickslip.analysis.protocol import Map1D

__all__ = ["Collision", "Condition", "Connection", "Flip", "Fold", "Reading"]


@dataclass(frozen=True)
class Reading:
    """What a condition finds in one map.

    Attributes
    ----------
    value : float
        The test function; the bifurcation is where it vanishes.
    noise : float
        Rounding in it, estimated.
    points : tuple of float
        The periodic orbit concerned, in the map's order; away from the bifurcation a
        sequence that does not quite close.
    multipliers : tuple of float
        Of the orbit: one number; for a `Collision` the two one-sided ones, products of
        slopes along the images of the border's left and right side, NaN beside a gap.
    condition : Fold, Flip, Collision or Connection
        The same condition, started from here.
    critical : BorderReading or None
        The border or turning point, where there is one.
    path : tuple of float
        Of a `Connection`: the images of the critical point, itself first.
    """

    value: float
    noise: float
    points: tuple[float, ...]
    multipliers: tuple[float, ...]
    condition: Condition
    critical: BorderReading | None = None
    path: tuple[float, ...] = ()


@dataclass(frozen=True)
class Fold:
    """An orbit with multiplier 1: f^p(x) - x where (f^p)'(x) = 1.

    Attributes
    ----------
    period : int
    points : tuple of float, length period
        Where the orbit was last.
    labels : tuple of int
        Branches of the points there; empty if unknown.
    """

    period: int
    points: tuple[float, ...]
    labels: tuple[int, ...] = field(default=(), repr=False)

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` if there is no slope 1 nearby."""
        raise NotImplementedError


@dataclass(frozen=True)
class Flip:
    """An orbit with multiplier -1: multiplier + 1 along the orbit.

    Attributes are those of `Fold`.
    """

    period: int
    points: tuple[float, ...]
    labels: tuple[int, ...] = field(default=(), repr=False)

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` if the orbit is gone."""
        raise NotImplementedError


@dataclass(frozen=True)
class Collision:
    """An orbit with a point on a border: f^p(c-) - c or f^p(c+) - c.

    Attributes
    ----------
    period : int
    border : Border or TurningPoint
        The orbit of a turning point is superstable.
    side : int
        -1: c is approached from the left, 1: from the right.
    """

    period: int
    border: Critical
    side: int

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` if the border is gone."""
        raise NotImplementedError


@dataclass(frozen=True)
class Connection:
    """An image of a critical point on an unstable orbit u: f^k(c-) - u or f^k(c+) - u.

    Crises and band mergings are of this kind.

    Attributes
    ----------
    critical : Border or TurningPoint
    side : int
        Side of the border, -1 or 1; of no account at a turning point.
    k : int
        Applications of the map.
    points : tuple of float
        The unstable orbit in the map's order; its first point is the one that is met.
    """

    critical: Critical
    side: int
    k: int
    points: tuple[float, ...]
    labels: tuple[int, ...] = field(default=(), repr=False)

    @property
    def period(self) -> int:
        """Period of the unstable orbit."""
        return len(self.points)

    def at(self, f: Map1D) -> Reading:
        """Evaluate the test function; `ConditionLost` if c or u is gone."""
        raise NotImplementedError


Condition: TypeAlias = Fold | Flip | Collision | Connection
