"""From an event to a bifurcation: the orbits and attractors on both sides, and the outcome."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from stickslip.analysis.bifurcations.bifurcation import Bifurcation, bifurcation_of
from stickslip.analysis.bifurcations.border_collision.classification import (
    observed,
    predicted_at_corner,
    predicted_at_gap,
    predicted_at_jump,
)
from stickslip.analysis.bifurcations.conditions.conditions import Collision, Crossing
from stickslip.analysis.bifurcations.scan.events import Event, coefficients_at
from stickslip.analysis.branches.along.tracked import ConditionLost, CriticalReading
from stickslip.analysis.orbits.newton import orbit_through, solve_orbit, turned

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.crisis.comparison import ParameterPoint
    from stickslip.analysis.bifurcations.outcome import Outcome
    from stickslip.analysis.bifurcations.scan.adding_up import Concerned
    from stickslip.analysis.bifurcations.scan.nodes import Family
    from stickslip.analysis.bifurcations.scan.tracking import Span
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

# ------------------------------------------------------------------ a bifurcation


def explained(event: Event, span: Span, concerned: Concerned, family: Family) -> Bifurcation:
    """Tell what the lists and the map at an event say of it: all but the attractors."""
    found, reading = event.located, event.located.reading
    crosses = isinstance(reading.condition, Crossing)
    note = coefficients_at(found, family).text if crosses else ""
    predicted = None
    if isinstance(reading.condition, Collision):
        predicted = _predicted(event, reading.condition, family)
    before, after = span.left.select(concerned.before), span.right.select(concerned.after)
    if event.kind == "flip":
        before, after = (
            orbits or _parent_between(event, span, side, family)
            for side, orbits in ((-1, before), (1, after))
        )
    return bifurcation_of(
        event.kind,
        found,
        family.name,
        family.f,
        criticality=event.criticality,
        orbits_before=before,
        orbits_after=after,
        predicted_outcome=predicted,
        note=note,
    )


def _parent_between(
    flip: Event, span: Span, side: int, family: Family
) -> tuple[PeriodicOrbit, ...]:
    """Return the orbit that flips, on the side where it is in no list: from a fold too close."""
    folds = {
        way: other
        for other in span.events
        if other.kind == "fold"
        and other.period == flip.period
        and side * (way := other.value - flip.value) >= -other.located.error - flip.located.error
    }
    if not folds:
        return ()
    way = min(folds, key=abs)
    # Half way; points and multipliers leave a fold like the root of the parameter.
    start = turned(folds[way].points, flip.points)
    points = start + math.sqrt(0.5) * (flip.points - start)
    f = family.whole(flip.value + 0.5 * way)
    orbit = solve_orbit(f, points)
    solved = orbit.quality == "located" and abs(orbit.multiplier) < 1.0
    return (orbit if solved else orbit_through(f, points),)  # so close, a solution may be noise


def with_attractors(
    item: Bifurcation, below: ParameterPoint, above: ParameterPoint, width: float
) -> Bifurcation:
    """Add the attractors on both sides, and the outcome of a border collision that they show."""
    before, after = (look.attractors.attractors for look in (below, above))
    looks = below.value, above.value
    outcome = None
    if isinstance(item.condition, Collision):
        sides = item.orbits_before, item.orbits_after, before, after
        gap = item.kind == "enters_gap"
        outcome = observed(*sides, period=item.period, gap=gap, width=width)
    return replace(
        item, attractors_before=before, attractors_after=after, looks=looks, outcome=outcome
    )


def _predicted(event: Event, condition: Collision, family: Family) -> Outcome | None:
    """Foretell the outcome of a collision from what the map is at the border."""
    found = event.located
    border = found.reading.critical
    if not isinstance(border, CriticalReading) or found.slope == 0:
        return None
    direction = 1 if found.slope > 0 else -1
    left, right = found.reading.multipliers
    slope = left if condition.side < 0 else right
    if condition.others and border.kind != "jump":
        return None  # two corners at once are no skew tent, and no rule is known
    try:
        if border.kind == "corner":
            return predicted_at_corner(left, right, direction, period=event.period)
        if border.kind == "jump":
            f = family.whole(found.value)
            others = [(other.border.at(f), other.side) for other in condition.others]
            p, side = event.period, condition.side
            return predicted_at_jump(
                f, border, side, direction, period=p, multiplier=slope, others=others
            )
        if border.kind == "edge":
            return predicted_at_gap(slope, condition.side, direction, period=event.period)
    except (ConditionLost, ValueError):
        return None
    return None
