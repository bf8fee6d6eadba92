"""Arguments that several functions take, checked alike: parameters, their ranges, counts."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any

from stickslip.checks import checked_interval, finite_number, parameter_name

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.analysis.maps.protocol_nd import FamilyND


def checked_parameter(f: MapFamily | FamilyND, name: object, role: str = "name") -> None:
    """Refuse the name of a parameter that the map has not, with the closest known name."""
    parameter_name(role, name, f.parameters)


def checked_range(
    f: MapFamily | FamilyND, name: str, ends: Any, role: str = "range"
) -> tuple[float, float]:
    """Return the ends of a range; a map may say by ``searched`` how far searches go."""
    checked_parameter(f, name)
    low, high = checked_interval(role, ends)
    widest = getattr(f, "searched", {}).get(name, (-inf, inf))
    why = "Beyond that, motions hardly ever come back to global stick, or take very long."
    for end in (low, high):
        finite_number(name, end, at_least=widest[0], at_most=widest[1], of=f"{role}", why=why)
        f.replace(**{name: end})
    return low, high
