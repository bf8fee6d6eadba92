"""One periodic orbit on its way along a parameter: steps, bifurcations passed, the end."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.continuation.collision import meet
from stickslip.analysis.continuation.curve import CurveEnd, CurveEvent
from stickslip.analysis.continuation.half_period import flip_of_half, shrinks_to_half
from stickslip.analysis.continuation.obstacles import obstacles, unlabelled_obstacles
from stickslip.analysis.continuation.orbit_equations import OrbitEquations
from stickslip.analysis.continuation.walls import BorderWall
from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.analysis.orbits.newton import EPS
from stickslip.numerics.continuation import (
    ArclengthCurve,
    CurvePoint,
    LeavesRegion,
    StepControl,
    StepTooLong,
    turns_back,
)
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Literal

    from stickslip.analysis.continuation.collision import Meeting
    from stickslip.analysis.continuation.obstacles import Obstacle
    from stickslip.analysis.maps.protocol import Floats, Labels, MapFamily
    from stickslip.numerics.continuation import WalkEnd

MAX_OBSTACLES: Final = 200  # smooth breaks crossed, and false alarms
BENDS: Final = 0.5  # a slope changes at most so much per step, beside 1 + abs(slope) ...
BENDS_UNLABELLED: Final = 0.05  # ... and where no label would tell of a corner
AHEAD: Final = 0.5  # cosine: the end of a curve lies in the direction of travel
REACHES: Final = 32.0  # times the last step that failed
TOUCHING: Final = 1e-6  # scaled: an end so close has no direction
ON_WALL: Final = 1e-10  # of the domain
NEARBY: Final = 1e-3  # scaled: where the end at a break without a label may be
ORBIT_OF_MAP: Final = 1e-6  # of the domain: the orbit given must be so close to one of the map
CLOSES: Final = 0.1  # of a step: this close to the curve the start is met again
CLOSED_AFTER: Final = 3  # rows: the start is not met again before
SAME_WAY: Final = 0.7  # cosine
ROUNDINGS: Final = 64.0  # in a multiplier
REASONS: Final[dict[str, Any]] = {
    "jump": "breakpoint",
    "corner": "breakpoint",
    "edge": "gap",
    "end": "end of domain",
}


@dataclass(frozen=True, eq=False)
class Row:
    """A point of a curve of orbits, and the bifurcation that it is, if it is one."""

    value: float
    points: Floats
    multiplier: float
    labels: Labels
    residual: float
    passed: CurveEvent | None = None

    @classmethod
    def of(cls, point: CurvePoint, passed: CurveEvent | None = None) -> Row:
        """Take over a point of the curve."""
        note = point.note
        return cls(
            point.parameter, point.y[:-1], note.multiplier, note.labels, point.residual, passed
        )

    def ends(self, name: str, reason: str) -> CurveEnd:
        """Make this the end of a curve along a parameter."""
        return CurveEnd(reason, {name: self.value}, self.points, self.multiplier)


@dataclass(eq=False)
class Half:
    """A curve to one side of its start, which is not part of it."""

    rows: list[Row] = field(default_factory=list)
    end: CurveEnd | None = None


class OrbitFollower:
    """Follows one orbit of a map along a parameter; ``max_step`` is a share of range and domain."""

    def __init__(
        self, f: MapFamily, name: str, low: float, high: float, max_step: float, max_points: int
    ) -> None:
        self.f, self.name, self.low, self.high = f, name, low, high
        self.control = StepControl(first=min(0.01, max_step), largest=max_step)
        self.max_points = max_points
        self.pending: list[Row] = []
        self.halved = False

    def start(self, points: Floats, value: float) -> CurvePoint:
        """Set out from an orbit, the parameter rising; a ValueError if the map has none there."""
        f = self.f.replace(**{self.name: value})
        values = sample(f, points)
        pieces = [{label} for label in values.label.tolist()]
        self.equations = OrbitEquations(f, self.name, pieces)
        scale = np.append(np.full(len(points), domain_width(f)), self.high - self.low)
        self.curve = ArclengthCurve(
            self.equations, scale, self.low, self.high, self.control, self._accept
        )
        self.unlabelled = not values.label.any()
        wrong = f"the map has no such orbit at {self.name} = {value:.15g}: "
        if (values.status != OK).any():
            raise ValueError(f"{wrong}no value at one of its points.")
        try:
            found = self.curve.point(np.append(points, value))
        except (StepTooLong, LeavesRegion) as reason:
            raise ValueError(f"{wrong}Newton's method does not converge.") from reason
        if np.abs((found.y - np.append(points, value)) / scale).max() > ORBIT_OF_MAP:
            raise ValueError(f"{wrong}the nearest one is at {found.y[:-1]}.")
        return found

    def go(self, start: CurvePoint, targets: Sequence[CurvePoint]) -> Half:
        """Follow the orbit along its tangent, to a target passed in the direction of its own."""
        half, here = Half(), start
        for _ in range(MAX_OBSTACLES):
            outcome = self._walk(here, half, targets)
            if isinstance(outcome, CurveEnd):
                half.end = outcome
                return half
            here = outcome
        half.end = Row.of(here).ends(self.name, "step limit")
        return half

    def _walk(
        self, here: CurvePoint, half: Half, targets: Sequence[CurvePoint]
    ) -> CurveEnd | CurvePoint:
        """Walk as far as it goes; return the end, or where to go on from."""
        walk = self.curve.walk(here)
        while True:
            try:
                new = next(walk)
            except StopIteration as stop:
                return self._stopped(stop.value, half)
            if self.halved:
                return self._merged(here, half)
            half.rows += [*self.pending, Row.of(new)]
            if len(half.rows) > CLOSED_AFTER and self._closes(here, new, targets):
                return half.rows[-1].ends(self.name, "closed")
            if len(half.rows) >= self.max_points:
                return half.rows[-1].ends(self.name, "point limit")
            here = new

    # ------------------------------------------------------------------ on the way

    def _accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Look at a step: no slope may change by much; note what it passes."""
        before, after = here.note.slopes, new.note.slopes
        allowed = BENDS_UNLABELLED if self.unlabelled else BENDS
        if (np.abs(after - before) > allowed * (1 + np.minimum(abs(before), abs(after)))).any():
            raise StepTooLong("a slope changes")
        self.halved = shrinks_to_half(here.y[:-1], new.y[:-1])
        self.pending = [] if self.halved else self._passed(here, new)

    def _passed(self, here: CurvePoint, new: CurvePoint) -> list[Row]:
        """Solve for the folds and flips between two neighbours, in their order."""
        chord = (new.y - here.y) / self.curve.scale
        found: list[tuple[float, Row]] = []

        def add(kind: Literal["fold", "flip"], point: CurvePoint) -> None:
            place = float((point.y - here.y) / self.curve.scale @ chord)
            found.append((place, self._bifurcation(kind, point, here, new)))

        if turns_back(here, new):
            add("fold", self.curve.turning_point(here, new))
        if _off_flip(here) * _off_flip(new) < 0:
            add("flip", self.curve.between(here, new, _off_flip))
        return [row for _, row in sorted(found, key=lambda pair: pair[0])]

    def _bifurcation(
        self, kind: Literal["fold", "flip"], point: CurvePoint, here: CurvePoint, new: CurvePoint
    ) -> Row:
        multiplier = point.note.multiplier
        error = self._solution_error(point)
        if kind == "flip":
            rise = abs(new.note.multiplier - here.note.multiplier)
            noise = abs(multiplier + 1) + ROUNDINGS * EPS * len(point.y)
            error += noise * abs(new.parameter - here.parameter) / rise
        passed = CurveEvent(
            kind, {self.name: point.parameter}, point.y[:-1], multiplier, error, row=-1
        )
        return Row.of(point, passed)

    def _solution_error(self, point: CurvePoint) -> float:
        """Bound how far residual and rounding may have moved the parameter of a point."""
        _, jacobian, _ = self.equations(point.y)
        scale = self.curve.scale
        matrix = np.vstack([jacobian * scale, point.tangent])
        influence = np.abs(np.linalg.inv(matrix)[-1, :-1])
        size = max(abs(end) for end in self.equations.f.domain)
        off = point.residual + 4 * EPS * size
        return float(scale[-1] * influence.sum() * off) + 2 * float(np.spacing(abs(point.y[-1])))

    def _closes(self, here: CurvePoint, new: CurvePoint, targets: Sequence[CurvePoint]) -> bool:
        """Tell whether a step passes a target, or one that starts at another of its points."""
        scale = self.curve.scale
        chord = (new.y - here.y) / scale
        for target in targets:
            for turn in range(len(target.y) - 1):
                offset = (_turned(target.y, turn) - here.y) / scale
                share = float(offset @ chord / (chord @ chord))
                aside = float(np.linalg.norm(offset - share * chord))
                along = float(_turned(target.tangent, turn) @ new.tangent)
                if 0 < share <= 1 and aside <= CLOSES * np.linalg.norm(chord) and along > SAME_WAY:
                    return True
        return False

    # ------------------------------------------------------------------ ends

    def _stopped(self, stop: WalkEnd, half: Half) -> CurveEnd | CurvePoint:
        """Find out what ended a walk."""
        last = stop.last
        points, value = last.y[:-1], last.parameter
        if stop.reason == "end of range":
            return Row.of(last).ends(self.name, "end of range")
        if stop.reason == "step limit":
            f = self.equations.at(value)
            for obstacle in unlabelled_obstacles(f, points):
                if (end := self._end_at(last, obstacle, NEARBY, half)) is not None:
                    return end
            return Row.of(last).ends(self.name, "step limit")
        for obstacle in obstacles(self.equations, points, value, stop.cause):
            if obstacle.kind == "smooth" and obstacle.beyond is not None:
                self.equations.pieces[obstacle.index].add(obstacle.beyond)
                return replace(last, step=self.control.first)
            if (end := self._end_at(last, obstacle, REACHES * last.step, half)) is not None:
                return end
        return last  # a false alarm: Newton's method went astray

    def _end_at(
        self, last: CurvePoint, obstacle: Obstacle, reach: float, half: Half
    ) -> CurveEnd | None:
        """Solve for the orbit on an obstacle; None if that is not where the curve leads."""
        eq, index = self.equations, obstacle.index
        try:
            met = meet(
                eq.at, self.name, last.y[:-1], index, obstacle.wall, last.parameter,
                self.low, self.high,
            )  # fmt: skip
        except ConditionLost:
            return None
        # Points on the wall itself, of which there may be several, are seen from their pieces.
        on_wall = np.abs(met.points - met.points[index]) <= ON_WALL * self.curve.scale[:-1]
        labels = np.where(on_wall, last.note.labels, met.labels)
        if not eq.stays(labels, np.ones(len(labels), dtype=bool)).all():
            return None
        if not self._lies_ahead(last, met, reach):
            return None
        row = Row(met.value, met.points, float(met.slopes.prod()), labels, met.residual)
        half.rows.append(row)
        wall = obstacle.wall
        border: TrackedDiscontinuity | None = wall.border if isinstance(wall, BorderWall) else None
        return replace(
            row.ends(self.name, REASONS[obstacle.kind]), border=border, index=index, side=wall.side
        )

    def _lies_ahead(self, last: CurvePoint, met: Meeting, reach: float) -> bool:
        way = (np.append(met.points, met.value) - last.y) / self.curve.scale
        length = float(np.linalg.norm(way))
        ahead = float(way @ last.tangent) >= AHEAD * length
        return length <= reach and (ahead or length <= TOUCHING)

    def _merged(self, last: CurvePoint, half: Half) -> CurveEnd:
        """Solve for the flip at which the orbit merges with one of half its period."""
        found = flip_of_half(self.equations.at, last.y[:-1], last.parameter, self.low, self.high)
        if found is None:
            return Row.of(last).ends(self.name, "step limit")
        value, points = found
        twice = np.tile(points, 2)
        values = sample(self.equations.at(value), twice)
        residual = float(np.abs(values.value - np.roll(twice, -1)).max())
        multiplier = float(values.derivative.prod())
        half.rows.append(Row(value, twice, multiplier, values.label, residual))
        return half.rows[-1].ends(self.name, "period halves")


def _off_flip(point: CurvePoint) -> float:
    multiplier: float = point.note.multiplier
    return multiplier + 1.0


def _turned(y: Floats, turn: int) -> Floats:
    """Start an orbit at another of its points; the parameter stays last."""
    return np.append(np.roll(y[:-1], turn), y[-1])
