"""Orbits, jumps and cusps of the paper's two systems by the names that it gives them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from stickslip import examples
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats

WINDOW: Final = (0.379, 0.390)
"""Range of d in which section 4 studies law (9)."""


def named(model: TwoBlock, *varied: str) -> str:
    """Write the numbers of a model for a caption, without those that vary in the figure."""
    kept = (item for item in model.parameters.items() if item[0] not in varied)
    return ", ".join(f"{name} = {value:g}" for name, value in kept)


@lru_cache(maxsize=64)  # conditions and claims ask for the same tables
def in_window(alpha: float) -> WindowMap:
    """Make the map of law (9) on the range of d that section 4 studies."""
    return WindowMap(event_map(examples.law9(alpha=alpha)), WINDOW)


@lru_cache(maxsize=8)  # figures 5, 8 and 10 and the table of values ask for the same
def coulomb_orbits(f: EventMap) -> dict[str, PeriodicOrbit]:
    """Orbits of a map up to period 4 by the names of figure 5: S1, U1, U2, S4."""
    found = periodic_orbits(f, 4)
    orbits = (*found.of_period(1), *found.of_period(4))
    return dict(zip(("S1", "U1", "U2", "S4"), orbits, strict=True))


def attracting_orbits(f: EventMap) -> tuple[PeriodicOrbit, ...]:
    """Orbits of the attractors of a map, all periodic, the one of the largest basin first."""
    return tuple(item.orbit for item in attractors(f) if item.orbit is not None)


def jump_of_s4(f: EventMap) -> Breakpoint:
    """Find the jump that S4 meets: there block 2 grazes its stick interval."""
    (jump,) = (item for item in breakpoints(f).of_kind("jump") if item.block == 2)
    return jump


def u4(f: EventMap) -> PeriodicOrbit:
    """Find the infinitely unstable orbit of period 4 through the jump that S4 meets."""
    jump = jump_of_s4(f)
    found = periodic_orbits(f, period=4, infinitely_unstable=True)
    (orbit,) = (item for item in found if item.jump is not None and item.jump.d == jump.d)
    return orbit


def from_point_1(orbit: PeriodicOrbit, jump: float) -> Floats:
    """Points of S4 or U4 as the paper numbers them: point 1 is the nearest to the jump."""
    first = int(np.argmin(np.abs(orbit.points - jump)))
    return np.asarray(np.roll(orbit.points, -first))


def cusp_of(f: WindowMap) -> Breakpoint:
    """Find the first maximum of a map of law (9) at a corner, between adjacent floats."""
    corners = breakpoints(f).of_kind("corner")
    return next(item for item in corners if item.left_slope > 0.0 > item.right_slope)


def fixed_points(f: WindowMap) -> tuple[PeriodicOrbit, ...]:
    """All fixed points in a part of a map, ascending."""
    return periodic_orbits(f).orbits


@dataclass(frozen=True)
class Moment:
    """The map of the window at one alpha."""

    alpha: float
    cusp: float
    images: Floats  # f(c) .. f^4(c), c the cusp
    p1: PeriodicOrbit
    twice: tuple[PeriodicOrbit, ...]  # orbits of period 2
    a: PeriodicOrbit | None  # born at the cusp, as b, or None
    b: PeriodicOrbit | None  # of negative multiplier

    @property
    def bands(self) -> Floats:
        """Widths of the two bands between images of the cusp, and the gap between them."""
        first, second, third, fourth = self.images
        return np.array([fourth - second, first - third, third - fourth])


def moment(alpha: float) -> Moment:
    """List the orbits of the window up to period 2 and follow the cusp; alpha below the crisis."""
    f = in_window(alpha)
    cusp = cusp_of(f).d
    found = periodic_orbits(f, 2)
    (p1,) = (o for o in found.of_period(1) if o.points[0] > cusp)
    twice = found.of_period(2)
    # A and B have a point on either side of P1, all four between the cusp's first two images.
    images = f.iterate(cusp, 4)[1:]
    born = [o for o in twice if o.points[0] > images[1] and o.points[1] < images[0]]
    a, b = (next((o for o in born if (o.multiplier > 0) is up), None) for up in (True, False))
    return Moment(alpha, cusp, images, p1, twice, a, b)
