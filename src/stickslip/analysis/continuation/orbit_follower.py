"""Periodic orbits on their way along a parameter: in R^n, and on a line with all its borders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd
from stickslip.analysis.continuation.borders import encounters, unlabelled_encounters
from stickslip.analysis.continuation.collision import meet
from stickslip.analysis.continuation.curve import Curve, CurveEnd, Problem, between
from stickslip.analysis.continuation.follower import (
    MAX_POINTS,
    MAX_STEP,
    Follower,
    Passed,
    first_point,
)
from stickslip.analysis.continuation.half_period import flip_of_half, shrinks_to_half
from stickslip.analysis.continuation.orbit_equations import Linearized, OrbitEquations
from stickslip.analysis.maps.protocol import domain_width
from stickslip.analysis.orbits.newton import solve_orbit
from stickslip.analysis.orbits.orbit import PeriodicOrbit, orbit_of
from stickslip.numerics.continuation import CurvePoint, StepControl, StepTooLong
from stickslip.results.parts import part
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.continuation.borders import Encounter
    from stickslip.analysis.continuation.collision import Meeting
    from stickslip.analysis.continuation.follower import Half
    from stickslip.analysis.maps.protocol import Floats, MapFamily
    from stickslip.numerics.continuation import WalkEnd

BENDS: Final = 0.5  # a slope changes at most so much per step, beside 1 + abs(slope) ...
BENDS_UNLABELLED: Final = 0.05  # ... and where no label would tell of a corner
AHEAD: Final = 0.5  # cosine: the end of a curve lies in the direction of travel
REACHES: Final = 32.0  # times the last step that failed
TOUCHING: Final = 1e-6  # scaled: an end so close has no direction
ON_BORDER: Final = 1e-10  # of the domain
NEARBY: Final = 1e-3  # scaled: where the end at a break without a label may be
ORBIT_OF_MAP: Final = 1e-6  # of the domain: the orbit given must be so close to one of the map
SAME: Final = 1e-13  # of the points: orbits that coincide
REASONS: Final[dict[str, Any]] = {
    "jump": "breakpoint",
    "corner": "breakpoint",
    "edge": "gap",
}


class OrbitFollower(Follower):
    """Follows one orbit of a map; ``max_step`` is a share of range and domain."""

    kind: ClassVar = "orbit"
    bends = BENDS

    def __init__(
        self,
        f: Any,
        name: str,
        low: float,
        high: float,
        max_step: float,
        max_points: int,
        **control: Any,
    ) -> None:
        steps = StepControl(first=min(0.01, max_step), largest=max_step, **control)
        super().__init__(name, low, high, steps, max_points)
        self.f = f

    def problem(self) -> Problem:
        """Say how the curve's orbits are solved for anew."""
        raise NotImplementedError

    def size(self) -> Any:
        """Width of the domain, in each direction."""
        raise NotImplementedError

    def solved(self, value: float, guess: Floats) -> tuple[Floats, float]:
        """Solve for an orbit, in the order of a guess; and det(M + 1), NaN if there is none."""
        raise NotImplementedError

    def start(self, points: Floats, value: float) -> CurvePoint:
        """Set out from an orbit, the parameter rising; a ValueError if the map has none there."""
        equations = OrbitEquations(self.f, self.name, [])
        values = equations.sample(equations.at(value), points)
        equations.pieces = [{label} for label in values.label.tolist()]
        self.equations = equations
        scale = np.append(np.tile(self.size(), len(points)), self.high - self.low)
        self.curve = self.line(equations, scale)
        wrong = f"the map has no such orbit at {self.name} = {value:.15g}: "
        if (values.status != OK).any():
            raise ValueError(f"{wrong}no value at one of its points.")
        return first_point(self.curve, np.append(points.ravel(), value), wrong, ORBIT_OF_MAP)

    def points(self, point: CurvePoint) -> Floats:
        """Return the points of the orbit."""
        return self.equations.points(point.y)

    def images(self, point: CurvePoint) -> Iterator[CurvePoint]:
        """Start an orbit at each of its points; the parameter stays last."""
        points, tangent = self.points(point), self.equations.points(point.tangent)
        for turn in range(len(points)):
            ahead = np.roll(tangent, turn, axis=0).ravel()
            yield replace(
                point,
                y=np.append(np.roll(points, turn, axis=0).ravel(), point.parameter),
                tangent=np.append(ahead, point.tangent[-1]),
                note=point.note.turned(turn),
            )

    def accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Let no slope change by much."""
        before, after = here.note.slopes, new.note.slopes
        if (np.abs(after - before) > self.bends * (1 + np.minimum(abs(before), abs(after)))).any():
            raise StepTooLong("a slope changes")

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """Solve for bifurcations, and for the orbit of half the period that ends the curve."""
        if shrinks_to_half(self.points(here), self.points(new)):
            yield self._merged(here)
        else:
            yield from super().passed(here, new)

    def _merged(self, last: CurvePoint) -> Passed:
        """Solve for the flip at which the orbit merges with one of half its period."""
        start = self.points(last), last.parameter
        found = flip_of_half(self.solved, *start, self.low, self.high)
        if found is None:
            raise StepTooLong("no flip of half the orbit")
        value, half = found
        points = np.concatenate([half, half])
        values = self.equations.sample(self.equations.at(value), points)
        point = self.at(last, points, value, *self.equations.described(points, values))
        return Passed(point, end=self.end(point, "period halves"))

    def at(
        self, last: CurvePoint, points: Floats, value: float, residual: Floats, note: Linearized
    ) -> CurvePoint:
        """Describe an orbit where the curve ends, beyond the last point of a walk."""
        y, size = np.append(points.ravel(), value), float(np.abs(residual).max())
        return replace(last, y=y, residual=size, note=note)

    def assembled(self, rows: list[CurvePoint], **known: Any) -> Curve:
        """Make a curve of its rows."""
        points = np.array([self.points(row) for row in rows])
        multipliers = np.array([row.note.multipliers for row in rows])
        return Curve(
            kind=self.kind,
            period=points.shape[1],
            parameters={self.name: np.array([row.parameter for row in rows])},
            points=points,
            multipliers=multipliers,
            stable=np.abs(multipliers.reshape(len(rows), -1)).max(axis=1) < 1,
            data={
                "labels": np.array([row.note.labels for row in rows]),
                "residual": np.array([row.residual for row in rows]),
            },
            problem=self.problem(),
            **known,
        )


class LineOrbitFollower(OrbitFollower):
    """Follows an orbit of a map of a line to borders, which are solved for as conditions."""

    def problem(self) -> Problem:
        """Orbits of this map."""
        return OrbitProblem(self.f)

    def size(self) -> float:
        """Width of the domain."""
        return domain_width(self.f)

    def start(self, points: Floats, value: float) -> CurvePoint:
        """Set out from an orbit; without labels more carefully."""
        found = super().start(points, value)
        self.bends = BENDS if any(map(any, self.equations.pieces)) else BENDS_UNLABELLED
        return found

    def tests(self, here: CurvePoint, new: CurvePoint) -> Iterator[Any]:
        """One multiplier may fold or flip."""
        yield from list(super().tests(here, new))[:2]

    def solved(self, value: float, guess: Floats) -> tuple[Floats, float]:
        """Solve for an orbit, points in the order of the guess."""
        orbit = solve_orbit(self.equations.at(value), guess)
        if orbit.quality != "located":
            return guess, np.nan
        shift = int(np.argmin(np.abs(orbit.points - guess[0])))
        return np.roll(orbit.points, -shift), orbit.multiplier + 1.0

    def stopped(self, stop: WalkEnd, half: Half) -> CurvePoint | CurveEnd:
        """Find out what ended a walk."""
        last = stop.last
        points, value = self.points(last), last.parameter
        if stop.reason == "end of range":
            return self.end(last, "end of range")
        if stop.reason == "step limit":
            for met in unlabelled_encounters(self.equations.at(value), points):
                if (end := self._end_at(last, met, NEARBY, half)) is not None:
                    return end
            return self.end(last, "step limit")
        for met in encounters(self.equations, points, value, stop.cause):
            if met.harmless is not None:
                self.equations.pieces[met.index].add(met.harmless)
                return replace(last, step=self.control.first)
            if (end := self._end_at(last, met, REACHES * last.step, half)) is not None:
                return end
        return last  # a false alarm: Newton's method went astray

    def _end_at(
        self, last: CurvePoint, encounter: Encounter, reach: float, half: Half
    ) -> CurveEnd | None:
        """Solve for the orbit on a border; None if that is not where the curve leads."""
        eq, index, border = self.equations, encounter.index, encounter.border
        start = self.points(last), index, border, last.parameter
        try:
            met = meet(eq.at, self.name, *start, self.low, self.high)
        except ConditionLost:
            return None
        # Points on the border itself, of which there may be several, are seen from their pieces.
        on_border = np.abs(met.points - met.points[index]) <= ON_BORDER * self.curve.scale[:-1]
        labels = np.where(on_border, last.note.labels, met.labels)
        if not eq.stays(labels, np.ones(len(labels), dtype=bool)).all():
            return None
        if not self._lies_ahead(last, met, reach):
            return None
        note = Linearized(met.slopes, met.points, labels)
        point = self.at(last, met.points, met.value, met.residual, note)
        half.rows.append(point)
        found = border.critical
        if isinstance(found, DomainEnd):
            return self.end(point, "end of domain", index=index, side=border.side)
        return self.end(point, REASONS[found.kind], index=index, side=border.side, border=found)

    def _lies_ahead(self, last: CurvePoint, met: Meeting, reach: float) -> bool:
        way = (np.append(met.points, met.value) - last.y) / self.curve.scale
        length = float(np.linalg.norm(way))
        ahead = float(way @ last.tangent) >= AHEAD * length
        return length <= reach and (ahead or length <= TOUCHING)


@part
@dataclass(frozen=True, eq=False)
class OrbitProblem(Problem):
    """The equations of a periodic orbit; `system` is restricted to the window if one was given."""

    system: MapFamily | None = None
    picture: ClassVar = "bifurcations.draw_orbit_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> PeriodicOrbit:
        """Start from a straight line between two rows; beside a fold, walk there."""
        if not share:
            return self.row(curve, row)
        orbit = self._solved(curve, value, between(curve.points, row, share))
        for start in (row + 1, row):
            if orbit.quality == "located":
                break
            own = float(curve.values[start])
            low, high = sorted((own, value))
            follower = LineOrbitFollower(self.system, name, low, high, MAX_STEP, MAX_POINTS)
            last = follower.reached(follower.start(curve.points[start], own), value)
            if last is not None:
                orbit = self._solved(curve, value, last.y[:-1])
        return orbit

    def _solved(self, curve: Curve, number: float, guess: Floats) -> PeriodicOrbit:
        assert self.system is not None
        return solve_orbit(self.system.replace(**{curve.parameter: number}), guess)

    def row(self, curve: Curve, row: int) -> PeriodicOrbit:
        """Return the orbit of a row as it was solved: at an end, a one-sided limit."""
        assert self.system is not None
        f = self.system.replace(**{curve.parameter: float(curve.values[row])})
        residual = float(curve.data["residual"][row])
        return orbit_of(
            f,
            curve.points[row],
            curve.data["labels"][row],
            multiplier=float(curve.multipliers[row]),
            error=residual,
            residual=residual,
        )

    def same(self, one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
        """Tell whether two orbits coincide, to their errors."""
        errors = np.ptp(one.interval, axis=1) + np.ptp(other.interval, axis=1)
        apart = np.abs(one.points - other.points)
        return bool((apart <= errors + SAME * np.abs(one.points).max()).all())
