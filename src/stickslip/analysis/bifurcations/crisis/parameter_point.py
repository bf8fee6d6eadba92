"""A map at one value of a parameter, with its attractors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from stickslip.analysis.attractors.attractors import attractors_of
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.interpolation.interpolated import interpolated_map

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor, AttractorList
    from stickslip.analysis.bifurcations.conditions.locate import MapAt
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.interpolation.interpolated import InterpolatedMap
    from stickslip.analysis.maps.protocol import Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit


MAX_STEPS: Final = 5376  # of orbits at a quick look: three growing blocks
MAX_PERIOD: Final = 64  # of stable cycles there


@dataclass(frozen=True, eq=False)
class ParameterPoint:
    """A map at one parameter value, with what is known of it."""

    value: float
    f: Map1D
    table: BranchTable
    attractors: AttractorList
    fast: InterpolatedMap  # of the table

    @property
    def chaotic(self) -> list[Attractor]:
        """The chaotic attractors."""
        return [a for a in self.attractors if a.kind == "chaotic"]


def parameter_point(
    at: MapAt,
    value: float,
    orbits: Iterable[PeriodicOrbit] = (),
    fast: InterpolatedMap | None = None,
    *,
    quick: bool = False,
) -> ParameterPoint:
    """Find the attractors of a map at a value; stable known orbits are attractors in any case.

    ``quick`` gives up sooner on orbits that do not settle, and on long periods.
    """
    fast = interpolated_map(branch_table(at(value))) if fast is None else fast
    f, table = fast.f, fast.table
    limits = {"max_steps": MAX_STEPS, "max_period": MAX_PERIOD} if quick else {}
    found = attractors_of(f, table, orbits, fast=fast, **limits)
    return ParameterPoint(float(value), f, table, found, fast)
