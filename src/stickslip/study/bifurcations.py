"""Questions along a parameter, of models and of map families; border collisions explained."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias, overload

from stickslip.analysis.bifurcations.bifurcation import Bifurcation, attempted
from stickslip.analysis.bifurcations.bifurcations import bifurcations as _bifurcations
from stickslip.analysis.bifurcations.conditions.conditions import Collision, Connection
from stickslip.analysis.bifurcations.curves.breakpoint_curves import (
    continue_breakpoint as _continue_breakpoint,
)
from stickslip.analysis.bifurcations.curves.curves import (
    continue_bifurcation as _continue_bifurcation,
)
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.continuation.continuation import continue_orbit as _continue_orbit
from stickslip.analysis.continuation.continuation_nd import continue_orbit as _continue_orbit_nd
from stickslip.analysis.continuation.orbit_branch import OrbitBranch
from stickslip.analysis.maps.protocol import MapFamily
from stickslip.analysis.maps.protocol_nd import FamilyND
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
from stickslip.checks import instance, shown
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.study.event_map import event_map
from stickslip.study.maps import as_map
from stickslip.study.mechanism import mechanism_between

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.analysis.bifurcations.bifurcation import BifurcationList
    from stickslip.analysis.bifurcations.curves.bifurcation_curve import (
        BifurcationCurve,
        BreakpointCurve,
    )
    from stickslip.analysis.continuation.orbit_branch_nd import OrbitBranchND

System: TypeAlias = MapFamily | TwoBlock


def as_family(system: object) -> MapFamily:
    """Return a map with parameters as it is, and of a model its event map.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters.
    """
    f = as_map(system, "system")
    if isinstance(f, MapFamily):
        return f
    raise ValueError(
        f"system = {shown(system)} has no parameters to vary. Take a model such as "
        "ss.TwoBlock(...), or ss.PiecewiseMap(..., parameters={...})."
    )


def bifurcations(
    system: System,
    name: str,
    range: tuple[float, float],
    *,
    max_period: int = 4,
    window: tuple[float, float] | None = None,
    n_values: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> BifurcationList:
    """Find, locate and explain every bifurcation of a system along one of its parameters.

    Parameters
    ----------
    system : model or map with parameters
        A `TwoBlock`, an event map or a `PiecewiseMap`.
    name : str
        Parameter that is varied, as in ``system.parameters``.
    range : pair of float
        ``lo < hi``, both allowed for the system.
    max_period : int
        Longest period of the orbits that are searched for; cascades are followed beyond.
    window : pair of float, optional
        Part of the domain that is searched: orbits that leave it have left.
    n_values : int, optional
        Values of the parameter with complete lists of orbits to begin with (24 by default);
        more are added where something happens.
    progress : callable, optional
        Called now and then with the share of the work that is done, 0 to 1.

    Returns
    -------
    BifurcationList
        A sequence of `Bifurcation`, ascending, with the branches of orbits between them, the
        cascades, and what stayed ``unresolved``. For a model the border collisions carry
        their mechanism and block.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; an unknown parameter; a range that is no
        interval or not allowed; a period or number of values that is not a whole number.

    Notes
    -----
    Complete lists of orbits at a grid of values, every orbit joined to its like at the next
    value or followed to where it ends; what ends it is solved for to rounding, and lists just
    below and above each bifurcation show what it concerns (docs/theory/bifurcations.md).

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.0})
    >>> found = ss.bifurcations(f, "r", (2.9, 3.5), max_period=2)
    >>> [(b.kind, b.criticality, round(b.value, 9)) for b in found]
    [('flip', 'super', 3.0), ('flip', 'super', 3.449489743)]
    """
    f = as_family(system)
    found = _bifurcations(
        f,
        name,
        range,
        max_period=max_period,
        window=window,
        n_values=n_values,
        progress=progress,
    )
    if not isinstance(f, EventMap):
        return found
    return _with_mechanisms(found, f)


def _with_mechanisms(found: BifurcationList, f: EventMap) -> BifurcationList:
    """Explain all border collisions and crises by the motions at their borders."""
    unresolved = list(found.unresolved)
    new = {
        id(item): attempted(
            partial(explain_border, item, f), "a mechanism", item.value, item.value, unresolved
        )
        or item
        for item in found
    }
    cascades = tuple(
        dataclasses.replace(cascade, flips=tuple(new.get(id(item), item) for item in cascade.flips))
        for cascade in found.cascades
    )
    items = tuple(new[id(item)] for item in found)
    return dataclasses.replace(
        found, bifurcations=items, cascades=cascades, unresolved=tuple(unresolved)
    )


def explain_border(item: Bifurcation, f: EventMap) -> Bifurcation:
    """Add to a bifurcation what the motions on both sides of its border tell.

    Parameters
    ----------
    item : Bifurcation
        Unchanged if no break of the map takes part in it.
    f : EventMap
        Of the system, whatever the value of the bifurcation's parameter.
    """
    condition = item.condition
    if isinstance(condition, Collision):
        border = condition.border
    elif isinstance(condition, Connection):
        border = condition.critical
    else:
        return item
    if not isinstance(border, TrackedDiscontinuity):
        return item
    at_value = f.replace(**{item.parameter: item.value})
    assert isinstance(at_value, EventMap)
    try:
        reading = border.at(at_value)
    except ConditionLost:
        return item
    found = mechanism_between(at_value, *reading.interval)
    text = found.text
    if isinstance(condition, Connection):
        text = f"image {condition.k} of the break where {text} meets the unstable orbit"
    return dataclasses.replace(item, mechanism=text, block=found.block)


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
    return _continue_orbit(orbit, as_family(f), name, range, **options)


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
    f = as_family(system)
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
    return _continue_breakpoint(breakpoint_, as_family(system), name, range)
