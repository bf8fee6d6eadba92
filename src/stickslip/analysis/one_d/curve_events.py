"""Points on a bifurcation curve where its type changes, and reasons for its ends.

Between two points of the curve a quantity changes its sign, or labels of the orbit change: the
place is solved for on the curve. A change of labels that the map does not notice is no event.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

from stickslip.analysis.one_d.borders import Border, ConditionLost
from stickslip.analysis.one_d.conditions import Collision, Connection, Flip, Fold
from stickslip.analysis.one_d.normal_forms import flip_coefficient
from stickslip.numerics.continuation import LeavesRegion, StepTooLong

if TYPE_CHECKING:
    from stickslip.analysis.one_d.borders import BorderReading
    from stickslip.analysis.one_d.conditions import Condition, Reading
    from stickslip.analysis.one_d.plane_equations import FoldEquations, PlaneEquations
    from stickslip.analysis.protocol import MapFamily
    from stickslip.numerics.continuation import Curve, CurvePoint

    Equations: TypeAlias = PlaneEquations | FoldEquations

__all__ = ["Event", "event_beyond", "events_between"]

REMAINDER: Final = 1e-3  # of the values around: a change of sign that leaves more is a pole
LOOK_AHEAD: Final = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5)  # scaled lengths, beyond the end of a curve
SIDES: Final = {-1: "left", 1: "right"}
MEANINGS: Final = {
    1: "the colliding orbit also folds",
    -1: "the colliding orbit also flips",
    0: "the colliding orbit is superstable",
}


@dataclass(frozen=True, eq=False)
class Event:
    """A special point of a curve.

    Attributes
    ----------
    kind, what : str
        As in `CodimensionTwo`.
    node : CurvePoint
        On the curve.
    ends : bool
        Whether the curve cannot go on.
    """

    kind: str
    what: str
    node: CurvePoint
    ends: bool = False


class _Quantity(NamedTuple):
    """Something that changes its sign where the type of a bifurcation changes."""

    kind: str
    what: str
    of: Callable[[CurvePoint], float]


def events_between(
    curve: Curve, equations: Equations, a: CurvePoint, b: CurvePoint
) -> Iterator[Event]:
    """Find the special points between two neighbours on a curve, in no particular order."""
    for quantity in _quantities(a.note.condition, equations):
        before, after = quantity.of(a), quantity.of(b)
        if not (math.isfinite(before) and math.isfinite(after) and before * after < 0):
            continue
        try:
            node = curve.between(a, b, quantity.of)
        except (StepTooLong, LeavesRegion):
            continue
        if abs(quantity.of(node)) <= REMAINDER * max(abs(before), abs(after)):
            yield Event(quantity.kind, quantity.what, node)
    for i in _changed_labels(a.note, b.note):
        event = _crossing(curve, equations, a, b, i)
        if event is not None:
            yield event


def _quantities(condition: Condition, equations: Equations) -> Iterator[_Quantity]:
    if isinstance(condition, Fold):
        what = "the curve has a cusp: two folds meet, three orbits are one"
        yield _Quantity("cusp", what, lambda node: node.note.curvature)
    elif isinstance(condition, Flip):
        what = "super- and subcritical flips meet, and a fold of the doubled orbit begins"
        yield _Quantity("generalised flip", what, lambda node: _coefficient(equations, node))
    elif isinstance(condition, Connection):
        for at in (1, -1):
            what = f"the multiplier of the orbit that is met passes {at}"
            yield _Quantity(f"multiplier {at}", what, _less(0, at))
    else:
        yield from _collision_quantities(condition)


def _collision_quantities(condition: Collision) -> Iterator[_Quantity]:
    if not isinstance(condition.border, Border):
        return
    continuous = condition.border.kind in ("corner", "smooth")
    for index, side in enumerate((-1, 1)):
        # Across a jump the orbit does not go on: only its own side matters.
        if continuous or side == condition.side:
            for at, meaning in MEANINGS.items():
                what = f"the multiplier on the {SIDES[side]} of the border passes {at}: {meaning}"
                yield _Quantity(f"multiplier {at}", what, _less(index, at))
    if continuous:
        what = "the slopes on both sides of the corner agree: the map is smooth there"
        yield _Quantity("kind of border", what, _bend)
    else:
        what = "the jump closes: the map is continuous there"
        yield _Quantity("kind of border", what, _jump)


def _less(index: int, at: int) -> Callable[[CurvePoint], float]:
    def of(node: CurvePoint) -> float:
        return float(node.note.multipliers[index]) - at

    return of


def _bend(node: CurvePoint) -> float:
    border: BorderReading = node.note.critical
    return border.right_slope - border.left_slope


def _jump(node: CurvePoint) -> float:
    border: BorderReading = node.note.critical
    return border.right - border.left


def _coefficient(equations: Equations, node: CurvePoint) -> float:
    found = flip_coefficient(_map_at(equations, node), node.note.points)
    return found.value if found.criticality is not None else 0.0


def _map_at(equations: Equations, node: CurvePoint) -> MapFamily:
    return equations.plane.map_at(*equations.parameters(node.y))


# ---------------------------------------------------------------- other breaks on the way


def _changed_labels(a: Reading, b: Reading) -> list[int]:
    pairs = zip(a.labels, b.labels, strict=False)
    return [i for i, (first, second) in enumerate(pairs) if first != second]


def _crossing(
    curve: Curve, equations: Equations, a: CurvePoint, b: CurvePoint, i: int
) -> Event | None:
    """Find where point i of an orbit crosses a break between two neighbours on a curve."""
    labels = (a.note.labels[i], b.note.labels[i])
    border = _break_beside(equations, a, i, labels)

    def distance(node: CurvePoint) -> float:
        if border is None:
            return -1.0 if node.note.labels[i] == labels[0] else 1.0
        return float(node.note.visited[i]) - border.at(_map_at(equations, node)).x

    try:
        node = curve.between(a, b, distance) if distance(a) * distance(b) < 0 else b
        met = None if border is None else border.at(_map_at(equations, node))
    except (StepTooLong, LeavesRegion, ConditionLost):
        node, met = b, None
    if met is not None and met.kind == "smooth":
        return None
    return _meeting(node, i, met)


def _break_beside(
    equations: Equations, node: CurvePoint, i: int, labels: tuple[int, int]
) -> Border | None:
    """Find the break between two labels close to point i of an orbit."""
    f, x = _map_at(equations, node), float(node.note.visited[i])
    for left, right in (labels, labels[::-1]):
        try:
            found = Border(left, right, x, "jump").at(f).critical
        except ConditionLost:
            continue
        if isinstance(found, Border) and {found.left_label, found.right_label} == set(labels):
            return found
    return None


def _meeting(node: CurvePoint, i: int, met: BorderReading | None) -> Event:
    reading: Reading = node.note
    x = reading.visited[i]
    what = f"the orbit meets another break, at {x:.12g}"
    if met is not None:
        what = f"the orbit meets another break, the {met.kind} at {x:.12g}"
    several = isinstance(reading.condition, Collision | Connection)
    ends = met is not None and met.kind in ("jump", "edge")
    return Event("second border" if several else "breakpoint", what, node, ends)


def event_beyond(equations: Equations, last: CurvePoint) -> tuple[Event | None, str]:
    """Find out what stops a curve at its last point.

    Returns
    -------
    event : Event or None
    reason : str
        In any case.
    """
    reason = "no further point was found"
    for length in LOOK_AHEAD:
        try:
            beyond: Reading = equations(last.y + length * equations.scale * last.tangent)[2]
        except LeavesRegion as left:
            reason = str(left.cause)
            break
        changed = _changed_labels(last.note, beyond)
        if changed:
            i = changed[0]
            labels = (last.note.labels[i], beyond.labels[i])
            border = _break_beside(equations, last, i, labels)
            met = None if border is None else border.at(_map_at(equations, last))
            event = _meeting(last, i, met)
            return Event(event.kind, event.what, last, True), event.what
    if reason.endswith("is gone"):
        return Event("end of border", reason, last, True), reason
    return None, reason
