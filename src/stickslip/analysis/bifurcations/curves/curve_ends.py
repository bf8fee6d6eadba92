"""Where and why a bifurcation curve ends inside its range.

Once the end is closed in on, what stops the curve is looked for just beyond: a break that a
point of the orbit meets, or that meets the border itself. Its distance, a smooth function on
this side, is extrapolated to zero: closer than the resolution two breaks cannot be told apart.
Where a crisis ceases to be one, only attractors tell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.crisis.comparison import KINDS, kind_of_change, parameter_point
from stickslip.analysis.bifurcations.crisis.crises import NUDGES, TOUCHING
from stickslip.analysis.bifurcations.curves.curve_events import Event, break_beside, map_at, meeting
from stickslip.analysis.bifurcations.curves.plane_equations import (
    changed_labels,
    moved,
    replaced_sides,
)
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.maps.protocol import Floats, domain_width
from stickslip.analysis.scales import FINE, HALF_DIGITS
from stickslip.numerics.continuation import CurvePoint, LeavesRegion, StepTooLong, lagrange_weights

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.bifurcations.conditions.conditions import Condition, Reading
    from stickslip.analysis.bifurcations.conditions.locate import MapAt
    from stickslip.analysis.bifurcations.crisis.comparison import ParameterPoint
    from stickslip.analysis.bifurcations.curves.plane_equations import Equations
    from stickslip.analysis.branches.along.tracked import CriticalReading

    Distance: TypeAlias = Callable[[CurvePoint], float]

LOOK_AHEAD: Final = tuple(FINE * 4.0**k for k in range(10))  # scaled lengths, beyond the end
LOOK_BACK: Final = (-4e-6, -8e-6, -12e-6)  # where distances are extrapolated from, before it
LOOK_ON: Final = tuple(-length for length in LOOK_BACK)  # ... and beyond
HIDDEN: Final = "hidden"
NOTHING: Final = "nothing"
LOOKS: Final = 4  # rows to either side of a start that are looked at where none is in doubt
HALVINGS: Final = 4  # of a step on which a crisis ceases to be one


def end_event(equations: Equations, last: CurvePoint) -> Event:
    """Find out what stops a curve at its last point: the end, sharper than it; of no kind, why."""
    reason = "no further point was found"
    for length in LOOK_AHEAD:
        try:
            beyond: Reading = equations(last.y + length * equations.scale * last.tangent)[2]
        except LeavesRegion as lost:
            # Of a long message, what is not allowed.
            reason = str(lost.cause).split(". ")[0]
            break
        replaced = replaced_sides(last.note.critical, beyond.critical)
        if replaced:
            return _other_break(equations, last, beyond, replaced[0])
        changed = changed_labels(last.note, beyond)
        if changed:
            return _other_branch(equations, last, beyond, changed[0])
    border = last.note.critical
    gone = border is not None and reason.startswith(f"the {border.kind}")
    return Event("end of border" if gone and reason.endswith("gone") else "", reason, last)


def _other_break(equations: Equations, last: CurvePoint, beyond: Reading, side: str) -> Event:
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
    return Event("end of border", what, node or last)


def _gap(equations: Equations, other: TrackedDiscontinuity, node: CurvePoint) -> float:
    """Measure from the border of a reading to another one, which has to have its own labels."""
    found = other.at(map_at(equations, node))
    critical = found.critical
    assert isinstance(critical, TrackedDiscontinuity)
    labels = (critical.left_label, critical.right_label)
    if labels != (other.left_label, other.right_label):
        raise ConditionLost("not the break that was meant")
    return found.x - float(node.note.critical.x)


def _other_branch(equations: Equations, last: CurvePoint, beyond: Reading, i: int) -> Event:
    """Point i of the orbit has reached a break."""
    border = break_beside(equations, last, i, (last.note.labels[i], beyond.labels[i]))
    if border is None:
        return meeting(last, i, None)
    found = border

    def distance(node: CurvePoint) -> float:
        return float(node.note.visited[i]) - found.at(map_at(equations, node)).x

    node = _extrapolated(equations, last, distance, LOOK_BACK) or last
    return meeting(node, i, found.at(map_at(equations, last)))


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
    if abs(way) > HALF_DIGITS:
        return None
    return replace(last, y=_lagrange(before, way))


def _lagrange(nodes: list[CurvePoint], length: float) -> Floats:
    """Continue the curve through points before its end."""
    return np.dot(lagrange_weights(LOOK_BACK, length), [node.y for node in nodes])


# ------------------------------------------------------------------ crises that are none any more

# What solves for the meeting of an edge with an orbit knows no attractors. Beyond a double crisis,
# where two orbits are met at once, the chaos ends at the other one, and this meeting changes
# nothing (Gallas, Grebogi and Yorke, Physical Review Letters 71, 1359, 1993).


def last_crisis(
    rows: list[CurvePoint],
    doubt: Callable[[CurvePoint], str],
    middle: Callable[[CurvePoint, CurvePoint], CurvePoint],
) -> tuple[int, list[CurvePoint], str] | None:
    """Find the first row in doubt, points up to the last one that is in none, and why it is."""
    looked_at = np.linspace(0, len(rows) - 1, LOOKS + 1).round().astype(int)
    steps = pairwise(np.unique(looked_at).tolist())
    first = next(((*step, why) for step in steps if (why := doubt(rows[step[1]]))), None)
    if first is None or doubt(rows[0]):  # looks that miss the crisis where it is known tell nothing
        return None
    low, high, why = first
    while high - low > 1:
        between = (low + high) // 2
        if found := doubt(rows[between]):
            high, why = between, found
        else:
            low = between
    kept, beyond = rows[low], rows[high]
    for _ in range(HALVINGS):
        try:
            node = middle(kept, beyond)
        except (LeavesRegion, StepTooLong):
            break
        if found := doubt(node):
            beyond, why = node, found
        else:
            kept = node
    return high, [*rows[:high], *([] if kept is rows[low] else [kept])], why


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
