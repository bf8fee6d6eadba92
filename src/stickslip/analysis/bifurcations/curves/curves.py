"""Bifurcations followed in the plane of two parameters.

The test function of a condition vanishes along a curve, which is followed by pseudo-arclength
in the plane of both parameters (for folds: in the space of orbit point and parameters, where
cusps are regular), both ways from its start, through its turning points, to the ends of the
range or to where the condition is lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import Bifurcation, bifurcation_of
from stickslip.analysis.bifurcations.conditions.conditions import Condition, Crossing, Fold
from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.bifurcations.crisis.comparison import KINDS
from stickslip.analysis.bifurcations.curves.curve_ends import doubt_about, end_event, last_crisis
from stickslip.analysis.bifurcations.curves.curve_events import Event, events_between
from stickslip.analysis.bifurcations.curves.plane_equations import (
    FoldEquations,
    Plane,
    PlaneEquations,
    closest_to_end,
)
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem, between
from stickslip.analysis.continuation.follower import MAX_POINTS, Follower, Half, Passed, contained
from stickslip.analysis.maps.arguments import checked_parameter
from stickslip.analysis.maps.protocol import Floats, MapFamily, domain_width
from stickslip.analysis.scales import FINE, ON_CURVE
from stickslip.checks import checked_interval
from stickslip.numerics.continuation import LeavesRegion, StepControl, StepTooLong
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from stickslip.analysis.bifurcations.curves.plane_equations import Equations
    from stickslip.analysis.work import Work
    from stickslip.numerics.continuation import CurvePoint, WalkEnd


CONTROL: Final = StepControl(first=0.01, smallest=1e-7, largest=1 / 32, patience=100)
SUDDEN: Final = 4.0  # times the last velocity of the orbit: a jump, or a step to be halved
KIND: Final = "bifurcation: "  # before the kind of a bifurcation in that of its curve


class PlaneProblem(Problem):
    """A bifurcation at each row, solved for in one of two parameters."""

    picture: ClassVar = "bifurcations.draw_curve"

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return the other parameter, on a straight line between two rows."""
        return np.atleast_1d(between(curve.parameters[other_parameter(curve, name)], row, share))


@part
@dataclass(frozen=True, eq=False)
class BifurcationProblem(PlaneProblem):
    """A bifurcation, known at each row by its condition."""

    system: MapFamily | None
    conditions: tuple[Condition, ...]

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Bifurcation:
        """Solve its condition for the other parameter, from the nearest row."""
        assert self.system is not None
        system, other = self.system, other_parameter(curve, name)
        (guess,) = self.guess(curve, row, share, name).tolist()
        widths = np.abs(np.diff(curve.parameters[other]))
        step = max(float(widths.max(initial=0.0)), ON_CURVE * abs(guess))
        try:
            found = solve_near(
                self.conditions[row + round(share)],
                lambda t: system.replace(**{name: value, other: t}),
                guess,
                step=step,
            )
        except ConditionLost as lost:
            raise ValueError(
                f"{name} = {value:.12g}: the bifurcation is not found there: {lost}."
            ) from lost
        kind: Any = curve.kind.removeprefix(KIND)
        new = system.replace(**{name: value, other: found.value})
        return bifurcation_of(kind, found, other, new)


def other_parameter(curve: Curve, name: str) -> str:
    """Name of the other parameter of a curve in a plane."""
    return next(each for each in curve.parameters if each != name)


def follow_bifurcation(
    item: Any,
    system: MapFamily,
    name: str,
    range: tuple[float, float],
    *,
    solve_for: str,
    work: Work | None = None,
) -> Curve:
    """Follow a bifurcation in the plane of two parameters; see `stickslip.follow`."""
    plane, q, s = checked_plane(item, system, name, range, solve_for)
    low, high = range
    try:
        start = solve_near(
            item.condition, lambda t: plane.map_at(t, s), q, step=ON_CURVE * max(abs(q), ON_CURVE)
        )
        kind = FoldEquations if isinstance(start.reading.condition, Fold) else PlaneEquations
        equations: Equations = kind.at(plane, start.reading, start.value, s, high - low)
        follower = _ConditionFollower(item, equations, low, high)
        first = follower.curve.point(equations.unknowns(start.reading, start.value, s))
    except (LeavesRegion, StepTooLong) as reason:
        raise ValueError(
            f"there is no such bifurcation near {name} = {s:.12g}, {solve_for} = {q:.12g}: "
            f"{reason}. Take the system in which it was found."
        ) from reason
    equations.accept(first.y, first.note)
    follower.column = 0
    if len(first.note.multipliers) > 1 and getattr(item.condition, "side", -1) > 0:
        follower.column = -1
    return follower.follow(first, work)


def checked_plane(
    item: Any, system: Any, along: str, range: tuple[float, float], solve_for: str
) -> tuple[Plane, float, float]:
    """Check the arguments; return the plane and where the curve starts."""
    for role, name in (("parameter", along), ("solve_for", solve_for)):
        checked_parameter(system, name, role)
    if along == solve_for:
        raise ValueError(f"parameter = solve_for = {along!r}: two different parameters are needed.")
    if isinstance(item.condition, Crossing):
        raise ValueError(
            f"a {item.kind} bifurcation is a point in the plane of two parameters, unless the "
            "system has a symmetry that keeps it: it is not followed. Take a fold or a flip "
            "beside it."
        )
    low, high = checked_interval("range", range)
    here = system.replace(**{item.parameter: item.value})
    s, q = here.parameters[along], here.parameters[solve_for]
    contained(low, high, along, s, "bifurcation")
    return Plane(here, along, solve_for), q, s


class PlaneFollower(Follower):
    """Follows a bifurcation in the plane of two parameters, the last unknowns of its equations."""

    marginal = FINE  # multipliers this close to the unit circle do not attract

    def __init__(
        self, kind: str, plane: Plane, low: float, high: float, control: StepControl
    ) -> None:
        super().__init__(plane.along, low, high, control, MAX_POINTS)
        self.which, self.kind, self.plane = kind, f"{KIND}{kind}", plane

    def parameters(self, point: CurvePoint) -> dict[str, float]:
        """Return the varied parameter, then the one that is solved for."""
        q, s = point.y[-2:].tolist()
        return {self.name: s, self.plane.solve_for: q}


class _ConditionFollower(PlaneFollower):
    """Follows a condition in the plane of two parameters."""

    def __init__(self, item: Any, equations: Equations, low: float, high: float) -> None:
        kind = getattr(item, "kind", type(item.condition).__name__.lower())
        super().__init__(kind, equations.plane, low, high, CONTROL)
        self.equations = equations
        self.curve = self.line(equations, equations.scale)
        self.velocity = math.inf  # of the orbit, in the last step
        below, above = getattr(item, "looks", (math.nan, math.nan))
        self.beside = 0.5 * (above - below)  # of a value: where its attractors are looked at
        self.column = 0  # of the multipliers: on the side that the orbit comes from

    def restart(self, start: CurvePoint) -> None:
        """Take the gradient at the start."""
        self.equations.restart(start.y)
        self.velocity = math.inf

    def half(self, start: CurvePoint, targets: Sequence[CurvePoint]) -> Half:
        """Follow the condition; of a crisis no further than attractors change there."""
        half = super().half(start, targets)
        if self.which in KINDS and math.isfinite(self.beside):
            with self.work.until_interrupted():
                if (found := last_crisis(half.rows, self._doubt, self._middle)) is not None:
                    lost, half.rows[:], why = found
                    half.events = [event for event in half.events if event.row < lost]
                    half.end = self.end(half.rows[-1], f"the crisis ceases ({why} beyond)")
                return half
            half.end = self.end(half.rows[-1], "interrupted")
        return half

    def _middle(self, a: CurvePoint, b: CurvePoint) -> CurvePoint:
        middle = 0.5 * (a.parameter + b.parameter)
        return self.curve.between(a, b, lambda point: point.parameter - middle)

    def _doubt(self, point: CurvePoint) -> str:
        q, s = point.y[-2:].tolist()
        at = partial(self.plane.map_at, s=s)
        return doubt_about(self.which, point.note.condition, at, q, self.beside)

    def points(self, point: CurvePoint) -> Floats:
        """Return the points of the orbit."""
        return np.array(point.note.points)

    def multipliers(self, point: CurvePoint) -> float:
        """Return the multiplier, of a border collision on the side that the orbit comes from."""
        return float(point.note.multipliers[self.column])

    def accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Let the orbit move as it may, and remember it."""
        step = float(np.linalg.norm((new.y - here.y) / self.equations.scale))
        moved = float(np.max(np.abs(np.subtract(new.note.points, here.note.points))))
        floor = ON_CURVE * domain_width(self.equations.plane.system)
        if moved > max(SUDDEN * self.velocity * step, floor):
            raise StepTooLong("the orbit jumps")
        self.velocity = max(moved, floor) / step
        self.equations.accept(new.y, new.note)

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """Solve for what changes the type of the bifurcation."""
        for event in events_between(self.curve, self.equations, here, new):
            end = self.end(event.node, event.what) if event.ends else None
            yield Passed(event.node, self._described(event), end)

    def _described(self, event: Event) -> CurveEvent:
        return self.event(event.kind, event.node, math.nan, what=event.what)

    def stopped(self, stop: WalkEnd, half: Half) -> CurveEnd:
        """Say why a walk has ended; keep of its last steps only the end."""
        last = closest_to_end(self.equations, half.rows[-1], 2 * CONTROL.smallest)
        event = end_event(self.equations, last)
        scale = self.equations.scale
        kept = [row for row in half.rows if np.linalg.norm((row.y - last.y) / scale) > ON_CURVE]
        half.rows = [*(kept or half.rows[:1]), event.node]
        half.events = [replace(item, row=min(item.row, len(half.rows) - 1)) for item in half.events]
        if event.kind:
            half.note(self._described(event))
        return self.end(half.rows[-1], event.what)

    def described(self, rows: list[CurvePoint]) -> tuple[dict[str, Any], Problem]:
        """Return the multipliers on both sides, and the conditions."""
        notes = [row.note for row in rows]
        one_sided = np.array([[r.multipliers[0], r.multipliers[-1]] for r in notes])
        data = {"multiplier_left": one_sided[:, 0], "multiplier_right": one_sided[:, 1]}
        return data, BifurcationProblem(self.plane.system, tuple(r.condition for r in notes))
