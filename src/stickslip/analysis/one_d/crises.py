"""Crises and mergings of bands: where chaotic attractors end, jump in size or join their bands.

The edges of a chaotic attractor are early images of breaks and turning points. A crisis is the
parameter value where such an image meets an unstable orbit outside the attractor: at the
boundary of its basin the attractor is lost, elsewhere it suddenly grows, and where the orbit lies
between two of its bands they merge (Grebogi, Ott and Yorke, Physica D 7, 181, 1983).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from stickslip.analysis.attractors import Attractor, AttractorList
    from stickslip.analysis.one_d.conditions import Connection
    from stickslip.analysis.one_d.locate import Located
    from stickslip.analysis.one_d.table import BranchTable
    from stickslip.analysis.orbits import OrbitList, PeriodicOrbit
    from stickslip.analysis.protocol import Map1D

__all__ = [
    "CrisisEvent",
    "CrisisKind",
    "ParameterPoint",
    "attractors_beside",
    "crises",
    "parameter_point",
]

CrisisKind: TypeAlias = Literal["boundary_crisis", "interior_crisis", "band_merging"]
MapAt: TypeAlias = "Callable[[float], Map1D]"


@dataclass(frozen=True, eq=False)
class ParameterPoint:
    """A map at one parameter value, with everything known of it.

    Attributes
    ----------
    value : float
    f : Map1D
    table : BranchTable
    orbits : OrbitList
        Complete up to a period.
    attractors : AttractorList
    """

    value: float
    f: Map1D
    table: BranchTable
    orbits: OrbitList
    attractors: AttractorList


@dataclass(frozen=True, eq=False)
class CrisisEvent:
    """A chaotic attractor that is lost, or changes suddenly, at a parameter value.

    Attributes
    ----------
    kind : {"boundary_crisis", "interior_crisis", "band_merging"}
    value, error : float
    condition : Connection
        The image of a break or turning point on the unstable orbit, started from here.
    located : Located
        How it was solved.
    points : tuple of float
        The unstable orbit there, in the map's order, the point that is met first.
    period : int
        Of the unstable orbit.
    attractors_before, attractors_after : tuple of Attractor
        All attractors just below and just above `value`.
    orbits_before, orbits_after : tuple of PeriodicOrbit
        The unstable orbit just below and just above, as far as it exists there.
    """

    kind: CrisisKind
    value: float
    error: float
    condition: Connection
    located: Located
    points: tuple[float, ...]
    period: int
    attractors_before: tuple[Attractor, ...]
    attractors_after: tuple[Attractor, ...]
    orbits_before: tuple[PeriodicOrbit, ...] = ()
    orbits_after: tuple[PeriodicOrbit, ...] = ()


def parameter_point(at: MapAt, value: float, max_period: int = 4) -> ParameterPoint:
    """Make the table, the list of orbits and the attractors of a map at one value."""
    raise NotImplementedError


def attractors_beside(
    at: MapAt, value: float, delta: float, *, max_period: int = 4
) -> tuple[AttractorList, AttractorList]:
    """Attractors at ``value - delta`` and ``value + delta``."""
    raise NotImplementedError


def crises(at: MapAt, grid: Sequence[ParameterPoint], *, max_period: int = 4) -> list[CrisisEvent]:
    """Find the crises and band mergings between the values of a grid, ascending.

    Parameters
    ----------
    at : callable
        The map at a parameter value.
    grid : sequence of ParameterPoint
        In ascending order of their values.
    max_period : int
        Longest period of the unstable orbits that an attractor may meet.
    """
    raise NotImplementedError
