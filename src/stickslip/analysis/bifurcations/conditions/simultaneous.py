"""Collisions of several points of an orbit with breaks of their own, at one parameter value.

A symmetry makes them one condition (docs/theory/reversing_symmetry.md): that of the first border is
solved, the other branches continued a little, and each of the others must give the same value.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from stickslip.analysis.bifurcations.conditions.conditions import Collision, Meeting
from stickslip.analysis.bifurcations.conditions.locate import found_near, solve_near

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Condition
    from stickslip.analysis.bifurcations.conditions.locate import Located, MapAt

ERRORS: Final = 8.0  # by which two values of one event may differ


def solve_together(
    condition: Condition, at: MapAt, guess: float, *, step: float, within: tuple[float, float]
) -> Located:
    """Solve near a guess; a collision with all those of its ``others`` that happen there, too."""
    found = solve_near(condition, at, guess, step=step, within=within)
    joint = found.reading.condition
    if not isinstance(joint, Collision):
        return found
    kept = tuple(
        other for k, other in enumerate(joint.others) if _agrees(turned(joint, k), at, found, step)
    )
    if len(kept) == len(joint.others):
        return found
    return solve_together(replace(joint, others=kept), at, found.value, step=step, within=within)


def turned(condition: Collision, number: int) -> Collision:
    """Return the same collision, counted from another border on."""
    first, p = condition.others[number], condition.period
    own = Meeting(0, condition.border, condition.side)
    rest = (own, *condition.others[:number], *condition.others[number + 1 :])
    others = tuple(replace(one, place=(one.place - first.place) % p) for one in rest)
    return Collision(p, first.border, first.side, others)


def _agrees(condition: Collision, at: MapAt, found: Located, step: float) -> bool:
    """Tell whether a condition vanishes where another one does, within both errors."""
    other = found_near(condition, at, found.value, step=step)
    if other is None:
        return False
    return abs(other.value - found.value) <= ERRORS * (found.error + other.error)
