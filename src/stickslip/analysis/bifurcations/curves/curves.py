"""Bifurcations followed in the plane of two parameters.

The test function of a condition vanishes along a curve, which is followed by pseudo-arclength
in the plane of both parameters (for folds: in the space of orbit point and parameters, where
cusps are regular), both ways from its start, through its turning points, to the ends of the
range or to where the condition is lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.analysis.bifurcations.conditions.conditions import Crossing, Fold
from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.bifurcations.curves.curve_ends import end_event
from stickslip.analysis.bifurcations.curves.curve_events import Watch
from stickslip.analysis.bifurcations.curves.curve_steps import closest_to_end
from stickslip.analysis.bifurcations.curves.plane_equations import (
    FoldEquations,
    Plane,
    PlaneEquations,
)
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem
from stickslip.analysis.maps.arguments import checked_parameter
from stickslip.analysis.maps.protocol import domain_width
from stickslip.checks import checked_interval
from stickslip.numerics.continuation import ArclengthCurve, LeavesRegion, StepControl, StepTooLong
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Condition, Reading
    from stickslip.analysis.bifurcations.curves.curve_events import Event
    from stickslip.analysis.maps.protocol import Floats, MapFamily
    from stickslip.numerics.continuation import CurvePoint

    Equations: TypeAlias = PlaneEquations | FoldEquations

CONTROL: Final = StepControl(first=0.01, smallest=1e-7, largest=1 / 32, patience=100)
MAX_NODES: Final = 2000  # a curve that winds on is cut here
START: Final = 1e-4  # of a parameter: how far off the start of a curve may be
SUDDEN: Final = 4.0  # times the last velocity of the orbit: a jump, or a step to be halved
FLOOR: Final = 1e-4  # of the domain: smaller moves of the orbit are no jumps
THIN: Final = 1e-4  # scaled: the approach to an end is not kept, only the end
RETURNED: Final = 0.5  # of a step: a curve that comes back so close to its start is closed
END_OF_RANGE: Final = "end of range"
KIND: Final = "bifurcation: "  # before the kind of a bifurcation in that of its curve
AT_STEP: Final = 1e-4  # of a parameter: least error of an interpolated guess
MARGINAL: Final = 1e-9  # multipliers this close to the unit circle do not attract


@part
@dataclass(frozen=True, eq=False)
class BifurcationProblem(Problem):
    """A bifurcation, known at each row by its condition."""

    system: MapFamily | None
    conditions: tuple[Condition, ...]
    picture: ClassVar = "bifurcations.draw_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Bifurcation:
        """Solve its condition for the other parameter, from the nearest row."""
        assert self.system is not None
        system, other = self.system, _other(curve, name)
        (guess,) = self.guess(curve, row, share, name).tolist()
        widths = np.abs(np.diff(curve.parameters[other]))
        step = max(float(widths.max(initial=0.0)), AT_STEP * abs(guess))
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
        return Bifurcation(
            kind=curve.kind.removeprefix(KIND),  # type: ignore[arg-type]
            parameter=other,
            value=found.value,
            error=found.error,
            period=found.reading.condition.period,
            points=np.array(found.reading.points),
            quality=found.quality,
            interval=found.interval,
            residual=found.residual,
            condition=found.reading.condition,
            multipliers=found.reading.multipliers,
            system=system.replace(**{name: value, other: found.value}),
        )

    def row(self, curve: Curve, row: int) -> Bifurcation:
        """Solve for it again at the row's value of the varied parameter."""
        return self.solve(curve, row, 0.0, curve.parameter, float(curve.values[row]))

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return the other parameter, on a straight line between two rows."""
        values = curve.parameters[_other(curve, name)]
        after = values[row + 1] if share else values[row]
        return np.array([values[row] + share * (after - values[row])])


def _other(curve: Curve, name: str) -> str:
    return next(each for each in curve.parameters if each != name)


def follow_bifurcation(
    item: Any, system: MapFamily, name: str, range: tuple[float, float], *, solve_for: str
) -> Curve:
    """Follow a bifurcation in the plane of two parameters; see `stickslip.follow`."""
    plane, q, s = _start(item, system, name, range, solve_for)
    low, high = range
    try:
        start = solve_near(
            item.condition, lambda t: plane.map_at(t, s), q, step=START * max(abs(q), START)
        )
        equations = _equations(plane, start.reading, start.value, s, high - low)
        curve = ArclengthCurve(
            equations, equations.scale, low, high, CONTROL, _Continuity(equations)
        )
        first = curve.point(equations.unknowns(start.reading, start.value, s))
    except (ConditionLost, LeavesRegion, StepTooLong) as reason:
        raise ValueError(
            f"there is no such bifurcation near {name} = {s:.12g}, {solve_for} = {q:.12g}: "
            f"{reason}. Take the system in which it was found."
        ) from reason
    equations.accept(first.y, first.note)
    back = _Walk(curve, equations).go(first.reversed())
    on = _Walk(curve, equations, [first], reason=back.reason)
    if not back.closed:
        equations.restart(first.y)
        on = _Walk(curve, equations).go(first)
    return _assembled(item, plane, equations, first, back, on)


def _start(
    item: Any, system: MapFamily, along: str, range: tuple[float, float], solve_for: str
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
    if not low <= s <= high:
        raise ValueError(
            f"range = ({low:.12g}, {high:.12g}) does not contain {along} = {s:.12g}, where the "
            "bifurcation was found."
        )
    return Plane(here, along, solve_for), q, s


def _equations(plane: Plane, start: Reading, q: float, s: float, width: float) -> Equations:
    kind = FoldEquations if isinstance(start.condition, Fold) else PlaneEquations
    return kind.at(plane, start, q, s, width)


@dataclass
class _Continuity:
    """Lets a point of the curve pass if the orbit has moved as it may; remembers it then."""

    equations: Equations
    velocity: float = math.inf

    def __call__(self, previous: CurvePoint, new: CurvePoint) -> None:
        scale = self.equations.scale
        step = float(np.linalg.norm((new.y - previous.y) / scale))
        moved = float(np.max(np.abs(np.subtract(new.note.points, previous.note.points))))
        floor = FLOOR * domain_width(self.equations.plane.system)
        if moved > max(SUDDEN * self.velocity * step, floor):
            raise StepTooLong("the orbit jumps")
        self.velocity = max(moved, floor) / step
        self.equations.accept(new.y, new.note)


@dataclass
class _Walk:
    """One way along a curve."""

    curve: ArclengthCurve
    equations: Equations
    nodes: list[CurvePoint] = field(default_factory=list)
    events: list[tuple[int, Event]] = field(default_factory=list)
    reason: str = END_OF_RANGE
    closed: bool = False

    def go(self, start: CurvePoint) -> _Walk:
        """Walk to the end."""
        self.nodes.append(start)
        steps, watch = self.curve.walk(start), Watch(self.curve, self.equations)
        while True:
            try:
                node = next(steps)
            except StopIteration as end:
                self._finish(end.value.reason)
                return self
            here = len(self.nodes) - 1
            self.nodes.append(node)
            for event in watch.between(self.nodes[here], node):
                if event.ends:
                    self.nodes[-1], self.reason = event.node, event.what
                self.events.append((here, event))
            if self.reason != END_OF_RANGE:
                return self
            if len(self.nodes) > MAX_NODES:
                self.reason = f"more than {MAX_NODES} points"
                return self
            if self._is_closed(start, node):
                self.nodes.append(start)
                self.reason, self.closed = "the curve is closed", True
                return self

    def _finish(self, how: str) -> None:
        """Say why a walk has ended; keep of its last steps only the end."""
        if how == END_OF_RANGE:
            return
        last = closest_to_end(self.equations, self.nodes[-1], 2 * CONTROL.smallest)
        event, self.reason = end_event(self.equations, last)
        scale = self.equations.scale
        kept = [n for n in self.nodes[:-1] if np.linalg.norm((n.y - last.y) / scale) > THIN]
        self.nodes = [*(kept or self.nodes[:1]), last]
        self.events = [(min(i, len(self.nodes) - 2), e) for i, e in self.events]
        if event is not None:
            self.events.append((len(self.nodes) - 2, event))

    def _is_closed(self, start: CurvePoint, node: CurvePoint) -> bool:
        if len(self.nodes) < 8:
            return False
        away = float(np.linalg.norm((node.y - start.y) / self.equations.scale))
        return away < RETURNED * node.step and float(node.tangent @ start.tangent) > 0


def _assembled(
    item: Any, plane: Plane, equations: Equations, first: CurvePoint, back: _Walk, on: _Walk
) -> Curve:
    """Join both ways into one curve, in which the parameter rises at the start."""
    nodes = [*reversed(back.nodes[1:]), first, *on.nodes[1:]]
    zero = len(back.nodes) - 1
    side = -1
    if len(first.note.multipliers) > 1:
        side = getattr(item.condition, "side", -1)
    column = 0 if side < 0 else -1
    marks = [_mark(plane, equations, nodes, zero - 1 - i, e, column) for i, e in back.events]
    marks += [_mark(plane, equations, nodes, zero + i, e, column) for i, e in on.events]
    where = np.array([equations.parameters(node.y) for node in nodes])
    readings: list[Reading] = [node.note for node in nodes]
    one_sided = np.array([[r.multipliers[0], r.multipliers[-1]] for r in readings])
    multipliers = one_sided[:, column]
    parameters = {plane.along: where[:, 1], plane.solve_for: where[:, 0]}
    points = np.array([r.points for r in readings])
    kind = getattr(item, "kind", type(item.condition).__name__.lower())
    ends = [
        CurveEnd(
            reason,
            {name: float(values[k]) for name, values in parameters.items()},
            points[k],
            float(multipliers[k]),
        )
        for k, reason in ((0, back.reason), (-1, on.reason))
    ]
    return Curve(
        kind=f"{KIND}{kind}",
        period=item.condition.period,
        parameters=parameters,
        points=points,
        multipliers=multipliers,
        stable=np.abs(multipliers) < 1 - MARGINAL,
        ends=(ends[0], ends[1]),
        bifurcations=tuple(sorted(marks, key=lambda mark: mark.position)),
        data={"multiplier_left": one_sided[:, 0], "multiplier_right": one_sided[:, 1]},
        problem=BifurcationProblem(plane.system, tuple(r.condition for r in readings)),
    )


def _mark(
    plane: Plane,
    equations: Equations,
    nodes: list[CurvePoint],
    index: int,
    event: Event,
    column: int,
) -> CurveEvent:
    """Describe an event between nodes ``index`` and ``index + 1``."""
    q, s = equations.parameters(event.node.y)
    before, after = nodes[index], nodes[index + 1]
    way = [np.linalg.norm((end.y - event.node.y) / equations.scale) for end in (before, after)]
    share = float(way[0] / sum(way)) if sum(way) > 0 else 0.0
    return CurveEvent(
        kind=event.kind,
        parameters={plane.along: s, plane.solve_for: q},
        points=np.array(event.node.note.points),
        multipliers=float(event.node.note.multipliers[column]),
        error=math.nan,
        row=index,
        share=share,
        what=event.what,
    )
