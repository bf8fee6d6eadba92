"""Questions along a parameter, of models and of map families; border collisions explained."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias, overload

from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.analysis.bifurcations.curves.breakpoint_curves import (
    continue_breakpoint as _continue_breakpoint,
)
from stickslip.analysis.bifurcations.curves.curves import (
    continue_bifurcation as _continue_bifurcation,
)
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.continuation.continuation import continue_orbit as _continue_orbit
from stickslip.analysis.continuation.continuation_nd import continue_orbit as _continue_orbit_nd
from stickslip.analysis.continuation.orbit_branch import OrbitBranch
from stickslip.analysis.maps.arguments import line_family
from stickslip.analysis.maps.protocol import MapFamily
from stickslip.analysis.maps.protocol_nd import FamilyND
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
from stickslip.checks import instance, shown
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.curves.bifurcation_curve import (
        BifurcationCurve,
        BreakpointCurve,
    )
    from stickslip.analysis.continuation.orbit_branch_nd import OrbitBranchND

System: TypeAlias = MapFamily | TwoBlock


@overload
def continue_orbit(
    orbit: PeriodicOrbit | OrbitBranch,
    system: System,
    name: str,
    range: tuple[float, float],
    **options: Any,
) -> OrbitBranch: ...
@overload
def continue_orbit(
    orbit: PeriodicOrbitND,
    system: FamilyND | BeltModel,
    name: str,
    range: tuple[float, float],
    **options: Any,
) -> OrbitBranchND: ...
def continue_orbit(
    orbit: PeriodicOrbit | OrbitBranch | PeriodicOrbitND,
    system: System | FamilyND | BeltModel,
    name: str,
    range: tuple[float, float],
    **options: Any,
) -> OrbitBranch | OrbitBranchND:
    """Follow a periodic orbit along a parameter, both ways, through folds.

    Parameters
    ----------
    orbit : PeriodicOrbit, OrbitBranch or PeriodicOrbitND
        An orbit of the system with the parameters that it has; or a branch, which goes on from
        its ends that are ends of its range (of maps of a line).
    system : model or map with parameters
    name : str
        Parameter that is varied.
    range : pair of float
        Contains the system's own value.
    **options
        ``window``: part of the domain, which the orbit may not leave (of maps of a line).
        ``max_step``: longest step, as a share of the range and of the domain. ``max_points``:
        of either half.

    Returns
    -------
    OrbitBranch or OrbitBranchND
        ``ends`` tell why it ends, ``bifurcations`` the folds and flips on the way, and the
        Neimark-Sacker bifurcations of an orbit in R^n; ``branch.at(V=0.037)`` solves for the
        orbit anew.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; an infinitely unstable orbit, or none of the
        system; an unknown parameter; a range that does not contain the orbit.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.examples.coulomb()
    >>> s4 = ss.periodic_orbits(model, period=4)[0]
    >>> branch = ss.continue_orbit(s4, model, "V", (0.0366, 0.0372))
    >>> branch.end_reasons, round(float(branch.values[-1]), 12)
    (('end of range', 'breakpoint'), 0.03697592352)
    """
    f = event_map(system) if isinstance(system, BeltModel) else system
    if isinstance(orbit, PeriodicOrbitND):
        if not isinstance(f, FamilyND):
            raise ValueError(
                f"system = {shown(system)} is no map with parameters that has orbits of "
                f"points with {orbit.points.shape[1]} coordinates."
            )
        return _continue_orbit_nd(orbit, f, name, range, **options)
    known = "an orbit or a branch of one, such as ss.periodic_orbits(system)[0]"
    instance("orbit", orbit, (PeriodicOrbit, OrbitBranch), known)
    return _continue_orbit(orbit, line_family(f), name, range, **options)


def continue_bifurcation(
    b: Bifurcation, system: System, *, along: str, range: tuple[float, float], solve_for: str
) -> BifurcationCurve:
    """Follow a bifurcation in the plane of two parameters.

    Parameters
    ----------
    b : Bifurcation
        One of `bifurcations`, of any kind.
    system : model or map with parameters
        Values of all other parameters; they hold all along the curve.
    along : str
        Parameter that varies over ``range``.
    range : pair of float
        Contains the value of ``along`` at which the bifurcation was found.
    solve_for : str
        The other parameter.

    Returns
    -------
    BifurcationCurve
        ``bifurcations`` are the points where its type changes; ``curve.at(alpha=1.2)`` solves
        for the bifurcation anew.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; unknown or equal names; a range that is no
        interval or does not contain the start.
    """
    f = line_family(system)
    instance("b", b, Bifurcation, "a bifurcation, such as ss.bifurcations(system, ...)[0]")
    return _continue_bifurcation(b, f, along=along, range=range, solve_for=solve_for)


def continue_breakpoint(
    breakpoint_: Breakpoint | TrackedDiscontinuity,
    system: System,
    name: str,
    range: tuple[float, float],
) -> BreakpointCurve:
    """Follow a breakpoint along a parameter, both ways: the paper's discontinuity line D.

    Parameters
    ----------
    breakpoint_ : Breakpoint
        Of the system with the parameters that it has, from `breakpoints`.
    system : model or map with parameters
    name : str
        Parameter that is varied.
    range : pair of float
        Contains the system's own value.

    Returns
    -------
    BreakpointCurve
        ``end_reasons`` tell where a branch beside the breakpoint ends inside the range.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; an unknown parameter; a range without the
        system's own value; no breakpoint of this system.
    """
    known = "a breakpoint, such as ss.breakpoints(system)[0]"
    instance("breakpoint_", breakpoint_, (Breakpoint, TrackedDiscontinuity), known)
    return _continue_breakpoint(breakpoint_, line_family(system), name, range)
