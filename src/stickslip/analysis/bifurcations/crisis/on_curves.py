"""Where the curve of a crisis is none any more: the edge and the orbit meet, and no chaos is there.

What solves for the meeting knows no attractors. Beyond a double crisis, where two orbits are met at
once, the chaos ends at the other one, and this meeting changes nothing (Gallas, Grebogi and Yorke,
Physical Review Letters 71, 1359, 1993).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.crisis.comparison import (
    KINDS,
    kind_of_change,
    parameter_point,
)
from stickslip.analysis.bifurcations.crisis.crises import NUDGES, TOUCHING
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.maps.protocol import domain_width

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeVar

    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.bifurcations.conditions.conditions import Condition
    from stickslip.analysis.bifurcations.conditions.locate import MapAt
    from stickslip.analysis.bifurcations.crisis.comparison import ParameterPoint

    T = TypeVar("T")

HIDDEN: Final = "hidden"
NOTHING: Final = "nothing"
LOOKS: Final = 4  # rows to either side of a start that are looked at where none is in doubt


def doubt_about(kind: str, condition: Condition, at: MapAt, value: float, beside: float) -> str:
    """Say why a crisis is none of its kind; empty if it is, or if windows hide what is there."""
    seen = set()
    for nudge in NUDGES:  # what is told must be seen at each of these distances
        looks = (value - nudge * beside, value + nudge * beside)
        try:
            below, above = (parameter_point(at, look, quick=True) for look in looks)
        except ConditionLost:
            return ""  # the family ends there
        seen.add(_change(condition, below, above))
        if len(seen) > 1 or not seen.isdisjoint({kind, HIDDEN}):
            return ""
    (change,) = seen
    if change == NOTHING:
        return "no chaotic attractor with this edge changes"
    return f"it is of the kind {change.replace('_', ' ')}"


def _change(condition: Condition, below: ParameterPoint, above: ParameterPoint) -> str:
    """Tell what becomes of a chaotic attractor with this edge from one side to the other."""
    for near, far in ((below, above), (above, below)):
        attractor = _with_edge(near, condition)
        change = None if attractor is None else kind_of_change(attractor, near, far)
        if change is not None:
            return change if change in KINDS else HIDDEN
    one, two = (sorted((a.kind, a.period) for a in p.attractors) for p in (below, above))
    return NOTHING if one == two and "undecided" not in dict(one) else HIDDEN


def _with_edge(point: ParameterPoint, condition: Condition) -> Attractor | None:
    """Return the chaotic attractor that ends at the image of a critical point."""
    try:
        (*_, edge) = condition.at(point.f).path
    except ConditionLost:
        return None
    close = TOUCHING * domain_width(point.f)
    return next((a for a in point.chaotic if np.abs(a.bands - edge).min() <= close), None)


def first_lost(rows: Sequence[T], doubt: Callable[[T], str]) -> tuple[int, str] | None:
    """Find the first row in doubt, and why it is: some are looked at, then those between."""
    looked_at = np.linspace(0, len(rows) - 1, LOOKS + 1).round().astype(int).tolist()
    low = 0
    for high in looked_at[1:]:
        if high > low and (why := doubt(rows[high])):
            while high - low > 1:
                middle = (low + high) // 2
                if found := doubt(rows[middle]):
                    high, why = middle, found
                else:
                    low = middle
            return high, why
        low = high
    return None
