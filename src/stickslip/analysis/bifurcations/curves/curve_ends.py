"""Where and why a bifurcation curve ends inside its range.

Once the end is closed in on, what stops the curve is looked for just beyond: a break that a
point of the orbit meets, or that meets the border itself. Its distance, a smooth function on
this side, is extrapolated to zero: closer than the resolution two breaks cannot be told apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.curves.curve_events import Event, break_beside, map_at, meeting
from stickslip.analysis.bifurcations.curves.plane_equations import (
    CLOSE,
    changed_labels,
    moved,
    replaced_sides,
)
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.numerics.continuation import LeavesRegion, lagrange_weights

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Reading
    from stickslip.analysis.bifurcations.curves.plane_equations import Equations
    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.numerics.continuation import CurvePoint

    Distance: TypeAlias = Callable[[CurvePoint], float]

LOOK_AHEAD: Final = tuple(CLOSE * 4.0**k for k in range(10))  # scaled lengths, beyond the end
LOOK_BACK: Final = (-4e-6, -8e-6, -12e-6)  # where distances are extrapolated from, before it
LOOK_ON: Final = (4e-6, 8e-6, 12e-6)  # ... and beyond
BELIEVED: Final = 1e-7  # scaled: how far that may move the end


def end_event(equations: Equations, last: CurvePoint) -> tuple[Event | None, str]:
    """Find out what stops a curve at its last point: the end, sharper than it; the reason."""
    reason = "no further point was found"
    for length in LOOK_AHEAD:
        try:
            beyond: Reading = equations(last.y + length * equations.scale * last.tangent)[2]
        except LeavesRegion as lost:
            # Of a long message, what is not allowed.
            reason = str(lost.cause).split(". ")[0]
            break
        replaced = replaced_sides(last.note, beyond)
        if replaced:
            return _other_break(equations, last, beyond, replaced[0])
        changed = changed_labels(last.note, beyond)
        if changed:
            return _other_branch(equations, last, beyond, changed[0])
    border = last.note.critical
    if border is not None and reason.startswith(f"the {border.kind}") and reason.endswith("gone"):
        return Event("end of border", reason, last, True), reason
    return None, reason


def _other_break(
    equations: Equations, last: CurvePoint, beyond: Reading, side: str
) -> tuple[Event, str]:
    """Tell of a break that meets the border, or splits off: the branch between them ends there."""
    border: CriticalReading = last.note.critical
    old, new = border.critical, beyond.critical.critical if beyond.critical else None
    assert isinstance(old, TrackedDiscontinuity)
    assert isinstance(new, TrackedDiscontinuity)
    where = f"the {border.kind} at {border.x:.12g}"
    labels = new.left_label, old.left_label
    if side == "right":
        labels = old.right_label, new.right_label
    met = TrackedDiscontinuity(*labels, border.x, "jump")
    split = TrackedDiscontinuity(*labels[::-1], border.x, "jump")
    node = _extrapolated(equations, last, lambda node: _gap(equations, met, node), LOOK_BACK)
    what = f"another break meets {where}: the branch on its {side} ends there"
    if node is None:
        node = _extrapolated(equations, last, lambda node: _gap(equations, split, node), LOOK_ON)
        if node is not None:
            what = f"{where} splits: a new branch comes up on its {side}"
    return Event("end of border", what, node or last, True), what


def _gap(equations: Equations, other: TrackedDiscontinuity, node: CurvePoint) -> float:
    """Measure from the border of a reading to another one, which has to have its own labels."""
    found = other.at(map_at(equations, node))
    critical = found.critical
    assert isinstance(critical, TrackedDiscontinuity)
    labels = (critical.left_label, critical.right_label)
    if labels != (other.left_label, other.right_label):
        raise ConditionLost("not the break that was meant")
    return found.x - float(node.note.critical.x)


def _other_branch(
    equations: Equations, last: CurvePoint, beyond: Reading, i: int
) -> tuple[Event, str]:
    """Point i of the orbit has reached a break."""
    border = break_beside(equations, last, i, (last.note.labels[i], beyond.labels[i]))
    if border is None:
        event = meeting(last, i, None)
        return replace(event, ends=True), event.what
    found = border

    def distance(node: CurvePoint) -> float:
        return float(node.note.visited[i]) - found.at(map_at(equations, node)).x

    node = _extrapolated(equations, last, distance, LOOK_BACK) or last
    event = meeting(node, i, found.at(map_at(equations, last)))
    return replace(event, ends=True), event.what


def _extrapolated(
    equations: Equations, last: CurvePoint, distance: Distance, lengths: tuple[float, ...]
) -> CurvePoint | None:
    """Move a point along the curve to where a distance that vanishes at its end does so."""
    try:
        before = [moved(equations, last, length) for length in LOOK_BACK]
        nodes = before
        if lengths is not LOOK_BACK:
            ways = [_lagrange(before, length) for length in lengths]
            nodes = [replace(last, y=y, note=equations(y)[2]) for y in ways]
        gaps = [distance(node) for node in nodes]
    except LeavesRegion:
        return None
    if len(set(gaps)) < len(gaps):
        return None
    # The way along the curve as a quadratic function of the distance, where that is zero.
    way = float(np.dot(lagrange_weights(gaps, 0.0), lengths))
    if abs(way) > BELIEVED:
        return None
    return replace(last, y=_lagrange(before, way))


def _lagrange(nodes: list[CurvePoint], length: float) -> Floats:
    """Continue the curve through points before its end."""
    return np.dot(lagrange_weights(LOOK_BACK, length), [node.y for node in nodes])
