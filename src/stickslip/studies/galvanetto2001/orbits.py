"""The orbits and points that the paper names, picked from complete lists."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import examples
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.window import WindowMap
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.mechanics.eventmap.event_map import EventMap

WINDOW: Final = (0.379, 0.390)
"""Range of d in which section 4 studies law (9)."""


@lru_cache(maxsize=64)  # conditions and claims ask for the same tables
def in_window(alpha: float) -> WindowMap:
    """Make the map of law (9) on the range of d that section 4 studies.

    Parameters
    ----------
    alpha : float
        Coupling ratio; the other parameters are the paper's.

    Returns
    -------
    WindowMap
    """
    return WindowMap(event_map(examples.law9(alpha=alpha)), WINDOW)


@lru_cache(maxsize=8)  # figures 5, 8 and 10 and the table of values ask for the same
def coulomb_orbits(f: EventMap) -> dict[str, PeriodicOrbit]:
    """Orbits up to period 4 by the names of figure 5: S1, U1, U2, S4.

    Parameters
    ----------
    f : EventMap
        Of the Coulomb system at V = 0.0366, or so close that the same orbits exist.

    Returns
    -------
    dict of str to PeriodicOrbit
        S1, U1, U2 in ascending order, then S4.
    """
    found = periodic_orbits(f, 4)
    orbits = (*found.of_period(1), *found.of_period(4))
    return dict(zip(("S1", "U1", "U2", "S4"), orbits, strict=True))


def attracting_orbits(f: EventMap) -> tuple[PeriodicOrbit, ...]:
    """Orbits of the attractors of a map, all of which are periodic.

    Parameters
    ----------
    f : EventMap
        Of the Coulomb system.

    Returns
    -------
    tuple of PeriodicOrbit
        The one with the largest basin first.
    """
    return tuple(item.orbit for item in attractors(f) if item.orbit is not None)


def jump_of_s4(f: EventMap) -> Breakpoint:
    """Find the jump that S4 meets: there block 2 grazes its stick interval.

    Parameters
    ----------
    f : EventMap
        Of the Coulomb system.

    Returns
    -------
    Breakpoint
        The jump.
    """
    (jump,) = (item for item in breakpoints(f).of_kind("jump") if item.block == 2)
    return jump


def u4(f: EventMap) -> PeriodicOrbit:
    """Find the infinitely unstable orbit of period 4 through the jump that S4 meets.

    Parameters
    ----------
    f : EventMap
        Of the Coulomb system.

    Returns
    -------
    PeriodicOrbit
        U4 of section 4.
    """
    jump = jump_of_s4(f)
    found = periodic_orbits(f, period=4, infinitely_unstable=True)
    (orbit,) = (item for item in found if item.jump is not None and item.jump.d == jump.d)
    return orbit


def from_point_1(orbit: PeriodicOrbit, jump: float) -> NDArray[np.float64]:
    """Points of S4 or U4 as the paper numbers them.

    Parameters
    ----------
    orbit : PeriodicOrbit
        S4 or U4.
    jump : float
        The jump of the map, to which point 1 is the nearest.

    Returns
    -------
    ndarray of float64, shape (4,)
        In the order of visits.
    """
    first = int(np.argmin(np.abs(orbit.points - jump)))
    return np.asarray(np.roll(orbit.points, -first))


def cusp_of(f: WindowMap) -> Breakpoint:
    """Find the first maximum of a map at a corner.

    Parameters
    ----------
    f : WindowMap
        Part of a map of law (9).

    Returns
    -------
    Breakpoint
        Its ``interval`` are the adjacent floats between which the slope changes its sign.
    """
    corners = breakpoints(f).of_kind("corner")
    return next(item for item in corners if item.left_slope > 0.0 > item.right_slope)


def fixed_points(f: WindowMap) -> tuple[PeriodicOrbit, ...]:
    """All fixed points in a part of a map.

    Parameters
    ----------
    f : WindowMap
        Part of a map of law (9).

    Returns
    -------
    tuple of PeriodicOrbit
        Ascending.
    """
    return periodic_orbits(f).orbits
