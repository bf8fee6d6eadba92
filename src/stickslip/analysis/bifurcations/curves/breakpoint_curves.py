"""A breakpoint followed along one parameter: the lines on which orbits collide."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.continuation.curve import Curve, CurveEnd, Problem
from stickslip.analysis.maps.arguments import checked_parameter
from stickslip.analysis.maps.protocol import domain_width
from stickslip.checks import checked_interval
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.maps.protocol import MapFamily

FIRST: Final = 1 / 64  # of the range: the first step
LARGEST: Final = 1 / 16
SMALLEST: Final = 1e-10  # ... and how far an end is closed in on
BENT: Final = 2e-3  # of the breakpoint's whole way: larger misses of a prediction halve a step
STRAIGHT: Final = 2e-4  # ... and smaller ones double it
SUDDEN: Final = 1e-3  # of the domain: a value that changes with a label by more has jumped
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
        assert isinstance(found.critical, TrackedDiscontinuity)
        return Breakpoint(
            d=found.x,
            left=found.left,
            right=found.right,
            left_slope=found.left_slope,
            right_slope=found.right_slope,
            kind=found.kind,  # type: ignore[arg-type]
            left_label=found.critical.left_label or 0,
            right_label=found.critical.right_label or 0,
            interval=found.interval,
            system=f,
        )

    def row(self, curve: Curve, row: int) -> Breakpoint:
        """Find it again at the parameter of the row."""
        return self.solve(curve, row, 0.0, curve.parameter, float(curve.values[row]))


def follow_breakpoint(
    point: Breakpoint | TrackedDiscontinuity,
    system: MapFamily,
    name: str,
    range: tuple[float, float],
) -> Curve:
    """Follow a breakpoint of a map along one parameter; see `stickslip.follow`."""
    low, high, start = _checked(system, name, range)
    border = point if isinstance(point, TrackedDiscontinuity) else TrackedDiscontinuity.of(point)
    try:
        here = border.at(system)
    except ConditionLost as lost:
        raise ValueError(f"{name} = {start:.12g}: {lost}. Take a breakpoint of this map.") from lost
    walk = _Walk(system, name, high - low)
    down, first_reason = walk.go(start, here, low)
    up, last_reason = walk.go(start, here, high)
    rows = [*reversed(down), (start, here), *up]
    readings = [reading for _, reading in rows]
    values, d = np.array([value for value, _ in rows]), np.array([r.x for r in readings])
    return Curve(
        kind="breakpoint",
        parameters={name: values},
        points=d[:, None],
        multipliers=np.empty((len(rows), 0)),
        stable=np.zeros(len(rows), dtype=bool),
        ends=(
            CurveEnd(first_reason, {name: float(values[0])}, d[:1]),
            CurveEnd(last_reason, {name: float(values[-1])}, d[-1:]),
        ),
        bifurcations=(),
        data={
            "left": np.array([r.left for r in readings]),
            "right": np.array([r.right for r in readings]),
            "left_slope": np.array([r.left_slope for r in readings]),
            "right_slope": np.array([r.right_slope for r in readings]),
            "kind": tuple(r.kind for r in readings),
        },
        problem=BreakpointProblem(
            system,
            tuple(r.critical for r in readings if isinstance(r.critical, TrackedDiscontinuity)),
        ),
    )


def _checked(
    system: MapFamily, name: str, range: tuple[float, float]
) -> tuple[float, float, float]:
    checked_parameter(system, name)
    low, high = checked_interval("range", range)
    start = float(system.parameters[name])
    if not low <= start <= high:
        raise ValueError(
            f"range = ({low:.12g}, {high:.12g}) does not contain {name} = {start:.12g}, the "
            "value of the system that the breakpoint was found in."
        )
    return low, high, start


class _Walk:
    """Follow a border from value to value, in steps as long as its line is straight."""

    def __init__(self, system: MapFamily, name: str, width: float) -> None:
        self.system, self.name, self.width = system, name, width

    def go(
        self, start: float, here: CriticalReading, end: float
    ) -> tuple[list[tuple[float, CriticalReading]], str]:
        """Return values and readings up to an end, without the start, and why they stop."""
        rows = [(start, here)]
        step = FIRST * self.width
        while rows[-1][0] != end:
            value = rows[-1][0]
            to_end = abs(end - value)
            # A rest shorter than half a step would be a step of its own.
            new = end if to_end <= 1.5 * step else value + math.copysign(step, end - value)
            try:
                reading = self._read(rows[-1][1], new)
            except ConditionLost as lost:
                if step <= SMALLEST * self.width:
                    return rows[1:], str(lost).split(". ")[0]
                step = 0.5 * abs(new - value)
                continue
            miss, allowed = self._miss(rows, new, reading)
            if miss > allowed and abs(new - value) > SMALLEST * self.width:
                step = 0.5 * abs(new - value)
                continue
            rows.append((new, reading))
            if miss < STRAIGHT / BENT * allowed:
                step = min(2 * step, LARGEST * self.width)
        return rows[1:], "end of range"

    def _read(self, last: CriticalReading, value: float) -> CriticalReading:
        try:
            f = self.system.replace(**{self.name: value})
        except ValueError as reason:
            raise ConditionLost(str(reason)) from reason
        found = last.critical.at(f)
        old, new = last.critical, found.critical
        assert isinstance(old, TrackedDiscontinuity)
        assert isinstance(new, TrackedDiscontinuity)
        relabelled = (old.left_label, old.right_label) != (new.left_label, new.right_label)
        steps = np.abs([found.left - last.left, found.right - last.right])
        # Where a branch is continued by another one smoothly, only the label changes.
        if relabelled and not np.nanmax(steps) <= SUDDEN * domain_width(f):
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
        return abs(reading.x - foretold), max(BENT * way, JUMPED * moved, SMALLEST)
