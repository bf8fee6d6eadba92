"""Points on a bifurcation curve where its type changes, and reasons for its ends.

Between two points of the curve a quantity changes its sign, or labels of the orbit change: the
place is solved for on the curve. A change of labels that the map does not notice is no event.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision, Connection, Flip, Fold
from stickslip.analysis.bifurcations.curves.plane_equations import changed_labels, closest_to_end
from stickslip.analysis.bifurcations.normal_forms import flip_coefficient
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity, break_between
from stickslip.analysis.maps.differences import LIKE
from stickslip.numerics.continuation import ArclengthCurve, CurvePoint, LeavesRegion, StepTooLong

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Condition, Reading
    from stickslip.analysis.bifurcations.curves.plane_equations import Equations
    from stickslip.analysis.branches.along.tracked import Critical, CriticalReading
    from stickslip.analysis.maps.protocol import MapFamily


# Kind and meaning of an event, and what vanishes there.
Quantity: TypeAlias = tuple[str, str, Callable[[CurvePoint], float]]

SIDES: Final = {-1: "left", 1: "right"}
MEANINGS: Final = {
    1: "the colliding orbit also folds",
    -1: "the colliding orbit also flips",
    0: "the colliding orbit is superstable",
}


@dataclass(frozen=True, eq=False)
class Event:
    """A special point of a curve; kind and what as in `CurveEvent`."""

    kind: str
    what: str
    node: CurvePoint  # on the curve
    ends: bool = False  # the curve cannot go on


def events_between(
    curve: ArclengthCurve, equations: Equations, a: CurvePoint, b: CurvePoint
) -> Iterator[Event]:
    """Find the special points between two neighbours, in no particular order."""
    for kind, what, quantity in _quantities(a.note.condition, equations):
        first, second = quantity(a), quantity(b)
        if not (math.isfinite(first) and math.isfinite(second) and first * second < 0):
            continue
        try:
            node = curve.between(a, b, quantity)
        except (StepTooLong, LeavesRegion):
            continue
        # A change of sign that leaves more is a pole.
        if abs(quantity(node)) <= LIKE * max(abs(first), abs(second)):
            yield Event(kind, what, node)
    if _kind(a.note) != _kind(b.note):
        yield _changed_kind(equations, a, b)
    for i in changed_labels(a.note, b.note):
        event = _crossing(curve, equations, a, b, i)
        if event is not None:
            yield event


def _quantities(condition: Condition, equations: Equations) -> Iterator[Quantity]:
    """Yield what changes its sign where the type of a bifurcation changes."""
    if isinstance(condition, Fold):
        what = "the curve has a cusp: two folds meet, three orbits are one"
        yield "cusp", what, lambda node: node.note.curvature
    elif isinstance(condition, Flip):
        what = "super- and subcritical flips meet, and a fold of the doubled orbit begins"

        def cubic(node: CurvePoint) -> float:
            found = flip_coefficient(map_at(equations, node), node.note.points)
            return found.value if found.criticality is not None else 0.0

        yield "generalised flip", what, cubic
    elif isinstance(condition, Connection):
        for at in (1, -1):
            what = f"the multiplier of the orbit that is met passes {at}"
            yield f"multiplier {at}", what, partial(_less, 0, at)
    elif isinstance(condition, Collision):
        yield from _collision_quantities(condition)


def _collision_quantities(condition: Collision) -> Iterator[Quantity]:
    if not isinstance(condition.border, TrackedDiscontinuity):
        return
    continuous = condition.border.kind in ("corner", "smooth")
    for index, side in enumerate((-1, 1)):
        # Across a jump the orbit does not go on: only its own side matters.
        if continuous or side == condition.side:
            for at, meaning in MEANINGS.items():
                what = f"the multiplier on the {SIDES[side]} of the border passes {at}: {meaning}"
                yield f"multiplier {at}", what, partial(_less, index, at)
    # Of a smooth break both are rounding.
    if condition.border.kind == "corner":
        what = "the slopes on both sides of the corner agree: the map is smooth there"
        yield "kind of border", what, lambda node: _step(node, "slope")
    if condition.border.kind == "jump":
        what = "the jump closes: the map is continuous there"
        yield "kind of border", what, lambda node: _step(node, "value")


def _less(index: int, at: int, node: CurvePoint) -> float:
    return float(node.note.multipliers[index]) - at


def _step(node: CurvePoint, what: Literal["value", "slope"]) -> float:
    """Return how much the value or the slope changes across a border."""
    one_sided = getattr(node.note.critical, what)
    return float(one_sided(1) - one_sided(-1))


def _kind(reading: Reading) -> str:
    return "" if reading.critical is None else reading.critical.kind


def _changed_kind(equations: Equations, a: CurvePoint, b: CurvePoint) -> Event:
    """Find where the break that an orbit collides with becomes one of another kind."""
    old, new = _kind(a.note), _kind(b.note)
    what = f"the {old} becomes a {new}"
    if new == "smooth":
        what = f"the {old} between these two branches becomes smooth: nothing happens there beyond"
    step = float(np.linalg.norm((b.y - a.y) / equations.scale))
    return Event("kind of border", what, closest_to_end(equations, a, step), new == "smooth")


def map_at(equations: Equations, node: CurvePoint) -> MapFamily:
    """Return the map at a point of a curve."""
    return equations.plane.map_at(*node.y[-2:].tolist())


# ---------------------------------------------------------------- other breaks on the way


def _crossing(
    curve: ArclengthCurve, equations: Equations, a: CurvePoint, b: CurvePoint, i: int
) -> Event | None:
    """Find where point i of an orbit crosses a break between two neighbours on a curve."""
    labels = (a.note.labels[i], b.note.labels[i])
    border = break_beside(equations, a, i, labels)

    def distance(node: CurvePoint) -> float:
        if border is None:
            return -1.0 if node.note.labels[i] == labels[0] else 1.0
        return float(node.note.visited[i]) - border.at(map_at(equations, node)).x

    try:
        node = curve.between(a, b, distance) if distance(a) * distance(b) < 0 else b
        met = None if border is None else border.at(map_at(equations, node))
    except (StepTooLong, LeavesRegion):
        node, met = b, None
    if met is not None and met.kind == "smooth":
        return None
    return meeting(node, i, met)


def break_beside(
    equations: Equations, node: CurvePoint, i: int, labels: tuple[int, int]
) -> Critical | None:
    """Find the break between two labels close to point i of an orbit, None if there is none."""
    f, x = map_at(equations, node), float(node.note.visited[i])
    found = break_between(f, x, labels)
    return None if found is None else found.critical


def meeting(node: CurvePoint, i: int, met: CriticalReading | None) -> Event:
    """Describe how point i of an orbit meets a break."""
    reading: Reading = node.note
    x = reading.visited[i]
    kind = "" if met is None else f"the {met.kind} "
    what = f"the orbit meets another break, {kind}at {x:.12g}"
    several = isinstance(reading.condition, Collision | Connection)
    ends = met is not None and met.kind in ("jump", "edge")
    return Event("second border" if several else "breakpoint", what, node, ends)
