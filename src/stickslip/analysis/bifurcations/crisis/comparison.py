"""A map at one value of a parameter with its attractors, and two of them compared."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, get_args

import numpy as np

from stickslip.analysis.attractors.attractors import MAX_PERIOD, attractors_of
from stickslip.analysis.attractors.bands import common
from stickslip.analysis.bifurcations.accounting import Look, of_cascade
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.interpolation.interpolated import InterpolatedMap, interpolated_map

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor, AttractorList
    from stickslip.analysis.bifurcations.conditions.locate import MapAt
    from stickslip.analysis.maps.protocol import Floats, Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

CrisisKind: TypeAlias = Literal["boundary_crisis", "interior_crisis", "band_merging"]

KINDS: Final[tuple[CrisisKind, ...]] = get_args(CrisisKind)
JUMP: Final = 1.2  # growth of the bands' total length at an interior crisis, at least
SUSPECT: Final = 1.5  # growth from one value to the next that asks for a closer look
MAX_STEPS: Final = 5376  # of orbits at a quick look: three growing blocks


@dataclass(frozen=True)
class Change:
    """A chaotic attractor that is not the same at the other end of an interval."""

    attractor: Attractor
    start: ParameterPoint
    stop: ParameterPoint
    certain: bool

    @cached_property
    def partner(self) -> Attractor | None:
        """What is in its place there."""
        return partner_of(self.attractor, self.stop.attractors)

    @property
    def period_there(self) -> int:
        """Period of what is in its place; 0 for nothing, and for what has none."""
        return 0 if self.partner is None else self.partner.period

    @property
    def ratio(self) -> Fraction:
        """Of the longer period to the shorter, here and there; 0 if what is there has none."""
        there = self.period_there
        return ratio_of(there, self.attractor.period) if there else Fraction(0)

    @property
    def is_of_doublings(self) -> bool:
        """Whether the longer one follows from the shorter by doublings, as in a cascade."""
        if self.partner is None or not is_of_doublings(self.ratio):
            return False
        orbit = self.partner.orbit
        return orbit is None or _is_paired(orbit.points, self.attractor.period)


def _is_paired(points: Floats, turns: int) -> bool:
    """Tell whether points of a cycle lie two by two, and so do the pairs, down to some turns.

    Points that a flip parts are neighbours for ever: a branch never meets itself. Those of a window
    in chaos may be as many, but are not.
    """
    while (n := len(points)) > turns:
        ranks, half = np.argsort(np.argsort(points)), n // 2
        pairs = [(ranks + shift) % n // 2 for shift in (0, 1)]  # also across the cut of a circle
        if not any((pair[:half] == pair[half:]).all() for pair in pairs):
            return False
        points = points[:half]
    return True


def is_of_doublings(ratio: Fraction) -> bool:
    """Tell whether periods of a ratio, at least one, follow from each other by doublings."""
    return ratio.denominator == 1 and of_cascade(ratio.numerator, 1)


def ratio_of(one: int, two: int) -> Fraction:
    """Ratio of the longer of two periods to the shorter."""
    return Fraction(max(one, two), min(one, two))


def changes(left: ParameterPoint, right: ParameterPoint) -> list[Change]:
    """Chaotic attractors of either side that the other side does not have, few bands last."""
    found = []
    for start, stop in ((left, right), (right, left)):
        for attractor in start.chaotic:
            partner = partner_of(attractor, stop.attractors)
            back = None if partner is None else partner_of(partner, start.attractors)
            if partner is None or partner.kind != "chaotic" or back is not attractor:
                found.append(Change(attractor, start, stop, certain=True))
            elif partner.period < attractor.period or len(partner.bands) < len(attractor.bands):
                found.append(Change(attractor, start, stop, certain=True))
            elif _length(partner) > SUSPECT * _length(attractor):
                found.append(Change(attractor, start, stop, certain=False))
    return sorted(found, key=lambda change: -len(change.attractor.bands))


def _length(attractor: Attractor) -> float:
    return float(np.sum(attractor.bands[:, 1] - attractor.bands[:, 0]))


def partner_of(attractor: Attractor, others: Iterable[Attractor]) -> Attractor | None:
    """Return the attractor that shares most of its place with another one."""
    best, most = None, 0.0
    for other in others:
        shared = _shared(attractor, other)
        if shared > most:
            best, most = other, shared
    return best


def _shared(one: Attractor, other: Attractor) -> float:
    """Return the common length of two attractors' bands, as a share of the shorter one's."""
    for a, b in ((one, other), (other, one)):
        if a.orbit is not None:
            points = a.bands[:, 0]
            if b.orbit is not None:
                return 0.0
            return float(np.mean(b.contains(points)))
    low, high = common(one.bands, *other.bands.T)
    shared = float(np.sum(np.maximum(high - low, 0.0)))
    return shared / max(min(_length(one), _length(other)), 1e-300)


def kind_of_change(
    attractor: Attractor, near: ParameterPoint, far: ParameterPoint
) -> CrisisKind | Literal["hidden", "transient", "window", "several"] | None:
    """Name what happens to an attractor between two close values; None for another event."""
    # ``hidden``: by a stable cycle; ``window``: as a cycle of a window in it, it is lost;
    # ``several``: bands merge more than once; ``transient``: a long-lived remnant.
    here = partner_of(attractor, near.attractors)
    if here is None:
        return None
    if here.kind != "chaotic":
        gone = partner_of(attractor, far.attractors) is partner_of(here, far.attractors) is None
        return "window" if gone and here.period % attractor.period == 0 else "hidden"
    if here.period != attractor.period:
        return None
    there = partner_of(here, far.attractors)
    if there is None:
        return "boundary_crisis"
    if there.kind == "undecided":
        return "transient"
    if there.kind == "periodic":
        return "hidden"
    if _length(there) > JUMP * _length(here):
        return "interior_crisis"
    if 2 * there.period < here.period:
        return "several"
    if there.period < here.period or len(there.bands) < len(here.bands):
        return "band_merging"
    return None


@dataclass(frozen=True, eq=False)
class ParameterPoint(Look):
    """A map at one parameter value, with what is known of it."""

    attractors: AttractorList
    f: Map1D
    table: BranchTable
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
    """Find a map's attractors, stable known orbits included; ``quick`` gives up sooner."""
    fast = interpolated_map(branch_table(at(value))) if fast is None else fast
    f, table = fast.f, fast.table
    limits = {"max_steps": MAX_STEPS, "max_period": MAX_PERIOD} if quick else {}
    found = attractors_of(f, table, orbits, fast=fast, **limits)
    return ParameterPoint(float(value), found, f, table, fast, quick=quick)
