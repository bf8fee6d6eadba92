"""Questions about one map, of a map or of a model; breakpoints of models with their mechanism."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any, Concatenate, Final, ParamSpec, TypeAlias, TypeVar, overload

from stickslip.analysis.attractors.attractors import attractors as _attractors
from stickslip.analysis.attractors.basins import basins as _basins
from stickslip.analysis.attractors.density import invariant_density as _invariant_density
from stickslip.analysis.attractors.lyapunov import lyapunov_exponent as _lyapunov_exponent
from stickslip.analysis.branches.branches import BreakpointList
from stickslip.analysis.branches.branches import branches as _branches
from stickslip.analysis.branches.branches import breakpoints as _breakpoints
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.branches.table import RESOLUTION, BranchTable
from stickslip.analysis.maps.protocol import Map1D, base_and_exponent, sample
from stickslip.analysis.maps.protocol_nd import MapND
from stickslip.analysis.orbits.orbit import OrbitList
from stickslip.analysis.orbits.orbits_nd import OrbitListND
from stickslip.analysis.orbits.periodic import periodic_orbits as _periodic_orbits
from stickslip.analysis.orbits.search_nd import periodic_orbits as _orbits_nd
from stickslip.checks import shown
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.study.event_map import event_map
from stickslip.study.mechanism import UNKNOWN, Mechanism, mechanism_between
from stickslip.vocabulary import did_you_mean

P = ParamSpec("P")
R = TypeVar("R")
MapOrModel: TypeAlias = Map1D | TwoBlock

LINE_OPTIONS: Final = ("infinitely_unstable", "resolution")
N_OPTIONS: Final = ("n_seeds",)


def as_map(f: object, name: str = "f") -> Map1D:
    """Return a map as it is, and of a model its event map.

    Raises
    ------
    ValueError
        Neither a map nor a model.
    """
    if isinstance(f, TwoBlock):
        return event_map(f)
    if isinstance(f, Map1D):
        return f
    raise ValueError(
        f"{name} = {shown(f)} is neither a map nor a model. Take ss.event_map(model), "
        "ss.PiecewiseMap(...) or a model such as ss.TwoBlock(...)."
    )


def _of_models_too(
    function: Callable[Concatenate[Map1D, P], R],
) -> Callable[Concatenate[MapOrModel, P], R]:
    """Let a function of a map take a model in its place."""

    @functools.wraps(function)
    def wrapper(f: MapOrModel, *args: P.args, **kwargs: P.kwargs) -> R:
        return function(as_map(f), *args, **kwargs)

    return wrapper  # type: ignore[return-value]  # typed by place, works by name, too


attractors = _of_models_too(_attractors)
basins = _of_models_too(_basins)
invariant_density = _of_models_too(_invariant_density)
lyapunov_exponent = _of_models_too(_lyapunov_exponent)


@overload
def periodic_orbits(
    f: MapOrModel,
    max_period: int = ...,
    *,
    period: int | None = ...,
    infinitely_unstable: bool = ...,
    resolution: float = ...,
) -> OrbitList: ...
@overload
def periodic_orbits(
    f: MapND | BeltModel,
    max_period: int = ...,
    *,
    period: int | None = ...,
    n_seeds: int = ...,
) -> OrbitListND: ...
def periodic_orbits(
    f: MapOrModel | MapND | BeltModel,
    max_period: int = 1,
    *,
    period: int | None = None,
    **options: Any,
) -> OrbitList | OrbitListND:
    """Find periodic orbits of a map or model, stable and unstable, each once.

    Parameters
    ----------
    f : map or model
    max_period : int
        Minimal periods 1 to this.
    period : int, optional
        Instead: minimal period exactly this.
    **options
        Of a `TwoBlock` and other maps of a line: ``infinitely_unstable``, whether to list orbits
        of the map with its jumps filled in, too: one point is a jump d, its image y any value
        between f(d-) and f(d+); ``resolution`` of the map's table of branches. Of more than two
        blocks: ``n_seeds``, starts of Newton's method for each period.

    Returns
    -------
    OrbitList or OrbitListND
        On a line: complete for every piece of f, ..., f^p whose laps of f are wider than the
        resolution; ``near_folds`` and ``unresolved`` say what could not be decided. Of N - 1
        differences of N > 2 blocks: those found from the seeds; ``unseen`` estimates how many
        were not.

    Raises
    ------
    ValueError
        A period or number of seeds that is not a whole number >= 1; an option of the other
        kind of map.

    Notes
    -----
    On a line: docs/theory/maps.md. In R^n: damped Newton steps for all points of an orbit, with
    exact Jacobians, from points spread over the domain and from points of iterated orbits.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.2})
    >>> [(orbit.period, orbit.stable) for orbit in ss.periodic_orbits(f, 4)]
    [(1, False), (1, False), (2, True)]
    """
    g = event_map(f) if isinstance(f, BeltModel) else f
    if isinstance(g, MapND):
        _check_options(options, N_OPTIONS)
        return _orbits_nd(g, max_period, period=period, **options)
    _check_options(options, LINE_OPTIONS)
    return _periodic_orbits(as_map(g), max_period, period=period, **options)


def _check_options(options: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for name in options:
        if name not in known:
            raise ValueError(
                f"{shown(name)} is no option of periodic_orbits for such a map. "
                f"{did_you_mean(name, known)}"
            )


def branches(f: MapOrModel, resolution: float = RESOLUTION) -> BranchTable:
    """Find the branches, breakpoints, gaps and laps of a map.

    Parameters
    ----------
    f : map or model
        An event map, a `PiecewiseMap`, a power of one (``f.power(p)``), or a model.
    resolution : float
        Everything wider is found; what stayed undecided is listed with its reason.

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
    table = _branches(as_map(f), resolution)
    explained = tuple(_explained(table.f, item) for item in table.breakpoints)
    return dataclasses.replace(table, breakpoints=explained)


def breakpoints(f: MapOrModel, resolution: float = RESOLUTION) -> BreakpointList:
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
    found = _breakpoints(as_map(f), resolution)
    explained = tuple(_explained(as_map(f), item) for item in found)
    return dataclasses.replace(found, items=explained)


def _explained(f: Map1D, breakpoint_: Breakpoint) -> Breakpoint:
    """Return a breakpoint with the mechanism that the motions on both sides tell."""
    found = _mechanism(f, *breakpoint_.interval)
    return dataclasses.replace(breakpoint_, mechanism=found.text, block=found.block)


def _mechanism(f: Map1D, left: float, right: float) -> Mechanism:
    """Follow both sides of a breakpoint through the iterates of a power to the one that splits.

    A window of a map, or of the map that a power is one of, hides no motion.
    """
    base, exponent = base_and_exponent(getattr(f, "whole", f))
    base = getattr(base, "whole", base)
    if not isinstance(base, EventMap):
        return Mechanism("", None)
    for k in range(exponent):
        values = sample(base, [left, right])
        if values.label[0] != values.label[1] or (values.status != 0).any():
            found = mechanism_between(base, left, right)
            text = found.text if exponent == 1 else f"{found.text} (iterate {k + 1})"
            return Mechanism(text, found.block)
        left, right = values.value.tolist()
    return UNKNOWN
