"""Arguments that several functions take, checked alike: parameters, their ranges, counts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.analysis.maps.protocol import FamilyND, Floats, Map1D, MapFamily, MapND, Modelled
from stickslip.checks import checked_interval, finite_number, parameter_name, real_numbers, shown

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike


def map_of(f: object) -> Any:
    """Return the map of a model, and anything else as it is."""
    return f.as_map() if isinstance(f, Modelled) and not isinstance(f, type) else f


def line_map(f: object, role: str = "f") -> Map1D:
    """Return a map of the line, or a model's; refuse anything else."""
    found = map_of(f)
    if isinstance(found, MapND):
        raise ValueError(
            f"{role} = {shown(f)} is a map of {found.dimension} numbers, or has one: the question "
            "is one about maps of the line, such as the event map of two blocks."
        )
    if isinstance(found, Map1D):
        return found
    raise ValueError(
        f"{role} = {shown(f)} is neither a map of the line nor a model that has one. Take "
        "ss.event_map(model), ss.PiecewiseMap(...) or a model such as ss.TwoBlock(...)."
    )


def line_family(system: object) -> MapFamily:
    """Return a map of the line with parameters, or a model's; refuse anything else."""
    f = line_map(system, "system")
    if isinstance(f, MapFamily):
        return f
    raise ValueError(
        f"system = {shown(system)} has no parameters to vary. Take a model such as "
        "ss.TwoBlock(...), or ss.PiecewiseMap(..., parameters={...})."
    )


def space_map(f: object, role: str = "f") -> MapND:
    """Return a map of R^n, or a model's; refuse anything else."""
    found = map_of(f)
    if isinstance(found, MapND):
        return found
    more = " Of a map of the line take ss.lyapunov_exponent." if isinstance(found, Map1D) else ""
    raise ValueError(
        f"{role} = {shown(f)} is neither a map of R^n nor a model that has one. Take ss.Map(...), "
        f"ss.return_map(model) or a model such as ss.Chain(...).{more}"
    )


def space_family(system: object) -> FamilyND:
    """Return a map of R^n with parameters, or a model's; refuse anything else."""
    f = space_map(system, "system")
    if isinstance(f, FamilyND):
        return f
    raise ValueError(f"system = {shown(system)} has no parameters to vary.")


def not_for(kind: str, **given: bool) -> None:
    """Refuse what was given but is for maps of the other kind: nothing is ignored in silence."""
    for name in (name for name, is_given in given.items() if is_given):
        raise ValueError(f"{name} is for maps of {kind}, which this is not: leave it out.")


def space_points(f: MapND, name: str, x: ArrayLike) -> Floats:
    """Return points of a map's domain in R^n, shape (..., n), or say what was given instead."""
    points = real_numbers(name, x)
    if points.shape[-1:] != (f.dimension,) or not f.contains(points).all():
        raise ValueError(
            f"{name} = {shown(x)} is not allowed: its last axis must hold {f.dimension} numbers, "
            "a point inside the map's domain."
        )
    return points


def checked_parameter(f: MapFamily | FamilyND, name: object, role: str = "parameter") -> None:
    """Refuse the name of a parameter that the map has not, with the closest known name."""
    parameter_name(role, name, f.parameters)


def checked_range(
    f: MapFamily | FamilyND, name: str, ends: Any, role: str = "range"
) -> tuple[float, float]:
    """Return the ends of a range; a map may say by ``searched`` how far searches go."""
    low, high = checked_interval(role, ends)
    check_values(f, name, (low, high), role)
    return low, high


def check_values(f: MapFamily | FamilyND, name: str, values: Iterable[float], role: str) -> None:
    """Refuse values of a parameter that a map cannot have, or that searches do not go to."""
    checked_parameter(f, name)
    widest = getattr(f, "searched", {}).get(name, {})
    why = "Beyond that, motions hardly ever come back to global stick, or take very long."
    for value in values:
        f.replace(**{name: value})
        finite_number(name, value, **widest, of=f"the {role}", why=why)
