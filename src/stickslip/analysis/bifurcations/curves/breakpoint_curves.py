"""A breakpoint followed along one parameter: the lines on which orbits collide."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.bifurcations.curves.plane_equations import replaced_sides
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.continuation.curve import Curve, CurveEnd, Problem
from stickslip.analysis.continuation.follower import MAX_POINTS, Follower, Half, contained
from stickslip.analysis.maps.arguments import checked_parameter
from stickslip.analysis.maps.protocol import Floats, MapFamily, domain_width
from stickslip.analysis.scales import NEARBY
from stickslip.checks import checked_interval
from stickslip.numerics.continuation import CurvePoint, StepControl, WalkEnd
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Generator

    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.work import Work

ONE_SIDED: Final = ("left", "right", "left_slope", "right_slope")  # of a border
CONTROL: Final = StepControl(first=1 / 64, smallest=1e-10, largest=1 / 16)  # of the range
BENT: Final = 2e-3  # of the breakpoint's whole way: larger misses of a prediction halve a step
STRAIGHT: Final = 2e-4  # ... and smaller ones double it
JUMPED: Final = 0.1  # of a step's own way, likewise: no break bends so much in so little


@part
@dataclass(frozen=True, eq=False)
class BreakpointProblem(Problem):
    """A breakpoint, known at each row by its labels."""

    system: MapFamily | None
    discontinuities: tuple[TrackedDiscontinuity, ...]
    picture: ClassVar = "bifurcations.draw_breakpoint_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Breakpoint:
        """Find the breakpoint from the nearest row."""
        assert self.system is not None
        f = self.system.replace(**{name: value})
        nearest = self.discontinuities[int(np.argmin(np.abs(curve.values - value)))]
        try:
            found = nearest.at(f)
        except ConditionLost as lost:
            raise ValueError(f"{name} = {value:.12g}: {lost}.") from lost
        same = (*ONE_SIDED, "kind", "interval", "scatter")
        facts: Any = {name: getattr(found, name) for name in same}
        left, right = found.labels
        return Breakpoint(found.x, **facts, left_label=left, right_label=right, system=f)


def follow_breakpoint(
    point: Breakpoint | TrackedDiscontinuity,
    system: MapFamily,
    name: str,
    range: tuple[float, float],
    *,
    work: Work | None = None,
) -> Curve:
    """Follow a breakpoint of a map along one parameter; see `stickslip.follow`."""
    checked_parameter(system, name)
    low, high = checked_interval("range", range)
    start = contained(low, high, name, float(system.parameters[name]), "breakpoint")
    border = point if isinstance(point, TrackedDiscontinuity) else TrackedDiscontinuity.of(point)
    try:
        here = border.at(system)
    except ConditionLost as lost:
        raise ValueError(f"{name} = {start:.12g}: {lost}. Take a breakpoint of this map.") from lost
    follower = _BreakFollower(system, name, low, high)
    return follower.follow(follower.point(start, here, 1.0), work)


class _BreakFollower(Follower):
    """Follows a border from value to value, in steps as long as its line is straight."""

    kind = "breakpoint"

    def __init__(self, system: MapFamily, name: str, low: float, high: float) -> None:
        super().__init__(name, low, high, CONTROL, MAX_POINTS)
        self.system, self.width = system, high - low

    def point(self, value: float, reading: CriticalReading, rate: float) -> CurvePoint:
        """Describe a border that is left with the parameter rising or falling."""
        y, tangent = np.array([reading.x, value]), np.array([0.0, rate])
        return CurvePoint(y, tangent, 0.0, 0, reading, CONTROL.first)

    def points(self, point: CurvePoint) -> Floats:
        """Return the place of the border."""
        return point.y[:1]

    def multipliers(self, point: CurvePoint) -> Floats:
        """Return none."""
        return np.empty(0)

    def images(self, point: CurvePoint) -> tuple[CurvePoint, ...]:
        """Return none: a line that does not turn back does not close."""
        return ()

    def walk(self, start: CurvePoint) -> Generator[CurvePoint, None, WalkEnd]:
        """Yield points up to an end of the range, or to where the border is lost."""
        rate = float(start.tangent[-1])
        end = self.high if rate > 0 else self.low
        rows = [(start.parameter, start.note)]
        step, smallest = CONTROL.first * self.width, CONTROL.smallest * self.width
        here = start
        while here.parameter != end:
            value = here.parameter
            to_end = abs(end - value)
            # A rest shorter than half a step would be a step of its own.
            new = end if to_end <= 1.5 * step else value + math.copysign(step, end - value)
            try:
                reading = self._read(here.note, new)
            except ConditionLost as lost:
                if step <= smallest:
                    return WalkEnd("region", here, str(lost).split(". ")[0])
                step = 0.5 * abs(new - value)
                continue
            miss, allowed = self._miss(rows, new, reading)
            if miss > allowed and abs(new - value) > smallest:
                step = 0.5 * abs(new - value)
                continue
            rows.append((new, reading))
            here = self.point(new, reading, rate)
            yield here
            if miss < STRAIGHT / BENT * allowed:
                step = min(2 * step, CONTROL.largest * self.width)
        return WalkEnd("end of range", here)

    def stopped(self, stop: WalkEnd, half: Half) -> CurveEnd:
        """Say why the border ends."""
        return self.end(stop.last, stop.cause or stop.reason)

    def assembled(self, rows: list[CurvePoint], **known: Any) -> Curve:
        """Make a curve of its readings."""
        readings: list[CriticalReading] = [row.note for row in rows]
        return Curve(
            kind=self.kind,
            parameters={self.name: np.array([row.parameter for row in rows])},
            points=np.array([self.points(row) for row in rows]),
            multipliers=np.empty((len(rows), 0)),
            stable=np.zeros(len(rows), dtype=bool),
            data={name: np.array([getattr(r, name) for r in readings]) for name in ONE_SIDED}
            | {"kind": tuple(r.kind for r in readings)},
            problem=BreakpointProblem(
                self.system,
                tuple(r.critical for r in readings if isinstance(r.critical, TrackedDiscontinuity)),
            ),
            **known,
        )

    def _read(self, last: CriticalReading, value: float) -> CriticalReading:
        try:
            f = self.system.replace(**{self.name: value})
        except ValueError as reason:
            raise ConditionLost(str(reason)) from reason
        found = last.critical.at(f)
        steps = np.abs([found.left - last.left, found.right - last.right])
        # Where a branch is continued by another one smoothly, only the label changes.
        if replaced_sides(last, found) and not np.nanmax(steps) <= NEARBY * domain_width(f):
            raise ConditionLost(f"the {last.kind} at {last.x:.12g} meets another break, or splits")
        return found

    def _miss(
        self, rows: list[tuple[float, CriticalReading]], new: float, reading: CriticalReading
    ) -> tuple[float, float]:
        """Return how far a breakpoint is from where a line foretold it, and how far it may be."""
        (value, last) = rows[-1]
        if len(rows) == 1:
            return 0.0, 1.0
        (before, old) = rows[-2]
        foretold = last.x + (last.x - old.x) * (new - value) / (value - before)
        way = max(abs(row.x - rows[0][1].x) for _, row in rows)
        moved = abs(foretold - last.x)
        return abs(reading.x - foretold), max(BENT * way, JUMPED * moved, CONTROL.smallest)
