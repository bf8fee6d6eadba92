"""Short steps on a bifurcation curve that never leave the orbit and the border they started with.

The walk along a curve may stop before its end, or step over a place where the border becomes
another one. From a point before, such a place is closed in on by halving.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.maps.protocol import domain_width

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Reading
    from stickslip.analysis.bifurcations.curves.plane_equations import FoldEquations, PlaneEquations
    from stickslip.numerics.continuation import CurvePoint

    Equations: TypeAlias = PlaneEquations | FoldEquations

CLOSE: Final = 1e-9  # scaled: how far an end is closed in on
ASIDE: Final = 1e-2  # of such a step: how far the curve may be from its tangent
NEAR: Final = 1e-3  # of the domain: the orbit moves less than that on the way


def closest_to_end(equations: Equations, last: CurvePoint, step: float) -> CurvePoint:
    """Go on from the last point of a walk as far as there are points, halving a too long step."""
    while step > CLOSE:
        step *= 0.5
        try:
            last = moved(equations, last, step)
        except (ConditionLost, ValueError):
            continue
    return last


def moved(equations: Equations, last: CurvePoint, length: float) -> CurvePoint:
    """Solve for a point of the curve a short way along its tangent, of the same orbit."""
    plane, (scale_q, scale_s) = equations.plane, equations.scale[-2:]
    along_q, along_s = last.tangent[-2:]
    q, s = equations.parameters(last.y + length * equations.scale * last.tangent)
    # Orthogonal to the curve in the scaled plane.
    normal = np.array([along_s * scale_q, -along_q * scale_s]) / math.hypot(along_q, along_s)
    near = NEAR * domain_width(plane.system)
    first = last.note.condition.at(plane.map_at(q, s))
    if not _same(last.note, first, near):
        raise ConditionLost("another orbit")
    found = solve_near(
        first.condition,
        lambda t: plane.map_at(q + t * normal[0], s + t * normal[1]),
        0.0,
        step=ASIDE * abs(length),
    )
    if found.quality != "located" or not _same(last.note, found.reading, near):
        raise ConditionLost("another orbit")
    where = (q + found.value * normal[0], s + found.value * normal[1])
    return replace(last, y=equations.unknowns(found.reading, *where), note=found.reading)


def _same(a: Reading, b: Reading, near: float) -> bool:
    """Tell whether a reading is another one, a little moved."""
    away = float(np.max(np.abs(np.subtract(a.points, b.points))))
    kinds = [None if reading.critical is None else reading.critical.kind for reading in (a, b)]
    return (
        away <= near
        and kinds[0] == kinds[1]
        and not changed_labels(a, b)
        and not replaced_sides(a, b)
    )


def changed_labels(a: Reading, b: Reading) -> list[int]:
    """Return which of the points that a test function depends on have changed their branch."""
    pairs = zip(a.labels, b.labels, strict=False)
    return [i for i, (first, second) in enumerate(pairs) if first != second]


def replaced_sides(a: Reading, b: Reading) -> list[str]:
    """Sides of a border on which there is another branch than before."""
    if a.critical is None or b.critical is None:
        return []
    old, new = a.critical.critical, b.critical.critical
    if not (isinstance(old, TrackedDiscontinuity) and isinstance(new, TrackedDiscontinuity)):
        return []
    same = {
        "left": old.left_label == new.left_label,
        "right": old.right_label == new.right_label,
    }
    return [side for side in same if not same[side]]
