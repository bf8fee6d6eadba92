"""The one follower of solutions along a parameter: both ways, through folds, to where they end.

A kind of solution says what is solved, what may be passed and what stops it; all else is here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, TypeAlias

import numpy as np

from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem
from stickslip.analysis.orbits.newton import MANY
from stickslip.analysis.scales import CLOSE, NEARBY
from stickslip.analysis.work import Work
from stickslip.checks import finite_number, whole_number
from stickslip.numerics.arrays import EPS
from stickslip.numerics.continuation import ArclengthCurve, LeavesRegion, StepTooLong

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from stickslip.numerics.continuation import CurvePoint, Equations, Floats, StepControl, WalkEnd

    Test: TypeAlias = Callable[[CurvePoint], float]

MAX_STEP: Final = 1 / 32  # of the range
MAX_POINTS: Final = 2000  # to either side
CLOSES: Final = 0.1  # of a step: this close to the curve the start is met again
AHEAD: Final = 0.5  # cosine: what a curve meets in the direction of travel
JUMP: Final = 0.1  # of a test function, at what seems its zero: there it jumps instead


class Passed(NamedTuple):
    """A special place between two neighbours on a curve."""

    point: CurvePoint | None  # None: at the first of both
    event: CurveEvent | None = None
    end: CurveEnd | None = None  # if the curve ends there


@dataclass(eq=False)
class Half:
    """A curve to one side of its start, which is the first row."""

    rows: list[CurvePoint]
    events: list[CurveEvent] = field(default_factory=list)
    end: CurveEnd | None = None

    def note(self, event: CurveEvent) -> None:
        """Have an event happen at the last row."""
        self.events.append(replace(event, row=len(self.rows) - 1))


class Follower:
    """Follows one solution along a parameter; a class for each kind of solution."""

    kind: str
    marginal: ClassVar[float] = 0.0  # multipliers this close to the unit circle do not attract
    most_borders: ClassVar[int] = 200  # that are passed, false alarms included
    curve: ArclengthCurve

    def __init__(
        self, name: str, low: float, high: float, control: StepControl, max_points: int
    ) -> None:
        self.name, self.low, self.high = name, low, high
        self.control, self.max_points = control, max_points
        self.work = Work()
        # In the last step, by the share of it at which each is met.
        self.pending: list[tuple[float, Passed]] = []

    # ------------------------------------------------------------------ said by a kind

    def points(self, point: CurvePoint) -> Floats:
        """Return a row of `Curve.points`."""
        raise NotImplementedError

    def multipliers(self, point: CurvePoint) -> Any:
        """Return a row of `Curve.multipliers`."""
        return point.note.multipliers

    def parameters(self, point: CurvePoint) -> dict[str, float]:
        """Return the values of all parameters of the curve, by name."""
        return {self.name: point.parameter}

    def stopped(self, stop: WalkEnd, half: Half) -> CurvePoint | CurveEnd:
        """Find out what ended a walk inside the range: the end, or where to go on from."""
        raise NotImplementedError

    def described(self, rows: list[CurvePoint]) -> tuple[dict[str, Any], Problem]:
        """Return further columns of a curve, and its problem."""
        raise NotImplementedError

    def assembled(self, rows: list[CurvePoint], **known: Any) -> Curve:
        """Make a curve of its rows; ends and bifurcations are known."""
        where = [self.parameters(row) for row in rows]
        points = np.array([self.points(row) for row in rows])
        multipliers = np.array([self.multipliers(row) for row in rows])
        data, problem = self.described(rows)
        return Curve(
            kind=self.kind,
            period=points.shape[1],
            parameters={name: np.array([each[name] for each in where]) for name in where[0]},
            points=points,
            multipliers=multipliers,
            stable=np.abs(multipliers.reshape(len(rows), -1)).max(axis=1) < 1 - self.marginal,
            data=data,
            problem=problem,
            **known,
        )

    def accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Refuse a step by `StepTooLong`."""

    def restart(self, start: CurvePoint) -> None:
        """Get ready to leave the start once more, to its other side."""

    def images(self, point: CurvePoint) -> Iterable[CurvePoint]:
        """Return all points that stand for one solution that the curve may come back to."""
        return (point,)

    def near(self, point: CurvePoint, here: CurvePoint) -> CurvePoint:
        """Return a point where it is closest to another, of all places that are the same."""
        return point

    def tests(self, here: CurvePoint, new: CurvePoint) -> Iterator[tuple[str, Test]]:
        """Functions along the curve that vanish at bifurcations."""
        yield "fold", _rate
        yield "flip", self.off_flip
        yield "neimark_sacker", self.off_circle

    # ------------------------------------------------------------------ both ways

    def follow(self, start: CurvePoint, work: Work | None = None) -> Curve:
        """Follow a solution to both sides; the parameter rises at the start."""
        whole = Work() if work is None else work
        self.work = whole.part(0.0, 0.5)
        ahead = self.half(start, [start])
        behind = Half([start], end=ahead.end)
        if self.work.interrupted:
            behind.end = self.end(start, "interrupted")
        elif ahead.end is None or ahead.end.reason != "closed":
            self.work = whole.part(0.5, 1.0)
            self.restart(start)
            behind = self.half(start.reversed(), [])
        return self.joined(behind, ahead)

    def joined(self, behind: Half, ahead: Half) -> Curve:
        """Put two halves from one start together."""
        before = len(behind.rows) - 1
        events = [replace(event, row=before - event.row) for event in behind.events]
        events += [replace(event, row=before + event.row) for event in ahead.events]
        return self.assembled(
            [*reversed(behind.rows[1:]), *ahead.rows],
            ends=(behind.end, ahead.end),
            bifurcations=tuple(sorted(events, key=lambda event: event.row)),
        )

    def half(self, start: CurvePoint, targets: Sequence[CurvePoint]) -> Half:
        """Follow a solution along its tangent, to a target passed in the direction of its own."""
        half, onward = Half([start]), start
        goals = [image for target in targets for image in self.images(target)]
        with self.work.until_interrupted():
            for _ in range(self.most_borders):
                outcome = self._walk(onward, half, goals)
                if isinstance(outcome, CurveEnd):
                    half.end = outcome
                    return half
                onward = outcome
            half.end = self.end(onward, "step limit")
            return half
        half.end = self.end(half.rows[-1], "interrupted")
        return half

    def _walk(
        self, here: CurvePoint, half: Half, goals: Sequence[CurvePoint]
    ) -> CurveEnd | CurvePoint:
        """Walk as far as it goes; return the end, or where to go on from."""
        walk, first = self.walk(here), half.rows[0]
        room = abs((self.high if _rate(first) > 0 else self.low) - first.parameter)
        while True:
            way = abs(here.parameter - first.parameter)
            self.work.tell(min(way / room, 1.0) if room else 1.0)
            try:
                new = next(walk)
            except StopIteration as stop:
                ended: WalkEnd = stop.value
                if ended.reason == "end of range":
                    return self.end(ended.last, ended.reason)
                return self.stopped(ended, half)
            closing = self._closing(here, new, goals)
            for share, passed in self.pending:
                if closing is not None and share > closing[0]:
                    break
                half.rows += [] if passed.point is None else [passed.point]
                if passed.event is not None:
                    half.note(passed.event)
                if passed.end is not None:
                    return passed.end
            half.rows.append(new if closing is None else closing[1])
            if closing is not None:
                return self.end(half.rows[-1], "closed")
            if len(half.rows) > self.max_points:
                return self.end(new, "point limit")
            here = new

    def reached(self, start: CurvePoint, value: float) -> CurvePoint | None:
        """Walk to an end of the range, whatever is passed; None if the walk stops before."""
        ahead = np.zeros(len(start.y))
        ahead[-1] = value - start.parameter
        *_, last = start, *replace(self.curve, accept=self.accept).walk(start.along(ahead))
        return last if last.parameter == value else None

    def end(self, point: CurvePoint, reason: str, **more: Any) -> CurveEnd:
        """End the curve at a point."""
        where = self.points(point), self.multipliers(point)
        return CurveEnd(reason, self.parameters(point), *where, **more)

    # ------------------------------------------------------------------ on the way

    def walk(self, start: CurvePoint) -> Generator[CurvePoint, None, WalkEnd]:
        """Yield points in the direction of the start's tangent."""
        return self.curve.walk(start)

    def line(self, equations: Equations, scale: Floats) -> ArclengthCurve:
        """Make the curve of some equations; its steps are looked at on the way."""
        return ArclengthCurve(
            equations, scale, self.low, self.high, self.control, self._look_between
        )

    def _look_between(self, here: CurvePoint, new: CurvePoint) -> None:
        """Look at a step: refuse it, or note what it passes, in order."""
        self.accept(here, new)
        found = [
            (0.0 if item.point is None else self._share(here, new, item.point), item)
            for item in self.passed(here, new)
        ]
        self.pending = sorted(found, key=lambda pair: pair[0])

    def _share(self, here: CurvePoint, new: CurvePoint, point: CurvePoint) -> float:
        """Return the share of a step after which a point is met."""
        chord = (new.y - here.y) / self.curve.scale
        return float((point.y - here.y) / self.curve.scale @ chord) / float(chord @ chord)

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """Solve for what lies between two neighbours."""
        for kind, test in self.tests(here, new):
            if test(here) * test(new) < 0:
                if kind == "branch_point" and (found := self._crossed(here, new, test)):
                    yield found
                    continue
                point = self.curve.between(here, new, test)
                if abs(test(point)) > JUMP * max(abs(test(here)), abs(test(new))):
                    continue  # multipliers jump there, as beside a change of modes
                if kind == "neimark_sacker":
                    m: NDArray[np.complex128] = self.multipliers(point)
                    on = np.abs(np.abs(m) - 1.0) < CLOSE
                    if not (on & (np.abs(m.imag) > CLOSE)).any():
                        continue  # two real multipliers whose product is 1: nothing happens
                error = self.solution_error(point)
                if kind != "fold":
                    noise = abs(test(point)) + MANY * EPS * len(point.y)
                    error += noise * abs(
                        (new.parameter - here.parameter) / (test(new) - test(here))
                    )
                yield Passed(point, self.event(kind, point, error))

    def _crossed(self, here: CurvePoint, new: CurvePoint, test: Test) -> Passed | None:
        """Bracket a point where the equations are singular by a short step; None if it is long."""
        way = new.y - here.y
        if float(np.linalg.norm(way / self.curve.scale)) > NEARBY:
            return None
        share = test(here) / (test(here) - test(new))
        there = replace(here, y=here.y + share * way)
        event = self.event("branch_point", there, abs(float(way[-1])))
        return Passed(None, event)

    def event(self, kind: str, point: CurvePoint, error: float, **more: Any) -> CurveEvent:
        """Describe a bifurcation at a point."""
        where = self.parameters(point), self.points(point), self.multipliers(point)
        return CurveEvent(kind, *where, error, -1, **more)

    def off_flip(self, point: CurvePoint) -> float:
        """det(M + 1), zero where a multiplier is -1."""
        return off_multiplier(self.multipliers(point), -1.0)

    def off_fold(self, point: CurvePoint) -> float:
        """det(M - 1), zero where a multiplier is 1."""
        return off_multiplier(self.multipliers(point), 1.0)

    def off_circle(self, point: CurvePoint) -> float:
        """Product of m_i m_j - 1 over pairs: zero where two multipliers have the product 1."""
        m = np.atleast_1d(self.multipliers(point))
        first, second = np.triu_indices(len(m), 1)
        return float(np.prod(m[first] * m[second] - 1.0).real)

    def solution_error(self, point: CurvePoint, *, fixed: bool = False) -> float:
        """Bound how far residual and rounding may have moved the parameter of a point.

        Where that is fixed: the coordinate before it, another parameter.
        """
        _, jacobian, _ = self.curve.equations(point.y)
        scale, k = self.curve.scale, -2 if fixed else -1
        aside = np.eye(len(scale))[-1] if fixed else point.tangent
        influence = np.abs(np.linalg.inv(np.vstack([jacobian * scale, aside]))[k, :-1])
        off = point.residual + 4 * EPS * float(np.abs(scale[:k]).max())
        return float(scale[k] * influence.sum() * off) + 2 * float(np.spacing(abs(point.y[k])))

    def _closing(
        self, here: CurvePoint, new: CurvePoint, goals: Sequence[CurvePoint]
    ) -> tuple[float, CurvePoint] | None:
        """Find a goal that a step passes: the share of the step, and the goal."""
        for goal in goals:
            if len(goal.y) != len(new.y):
                continue
            image = self.near(goal, here)
            step, share = new.y - here.y, self._share(here, new, image)
            aside, length = (
                float(np.linalg.norm(way / self.curve.scale))
                for way in (image.y - here.y - share * step, step)
            )
            same_way = float(image.tangent @ new.tangent) > AHEAD
            if 0 < share <= 1 and aside <= CLOSES * length and same_way:
                return share, image
        return None


def off_multiplier(multipliers: Any, at: float) -> float:
    """det(M - at), zero where a multiplier is that."""
    return float(np.prod(np.atleast_1d(multipliers) - at).real)


def _rate(point: CurvePoint) -> float:
    return float(point.tangent[-1])


def first_point(
    curve: ArclengthCurve,
    y: Floats,
    wrong: str,
    apart: float = math.inf,
    shown: Callable[[Floats], Floats] = lambda y: y[:-1],
) -> CurvePoint:
    """Solve for the start of a curve; a ValueError if it is not near the numbers given."""
    try:
        found = curve.point(y)
    except (StepTooLong, LeavesRegion) as reason:
        raise ValueError(f"{wrong}Newton's method does not converge.") from reason
    if np.abs((found.y - y) / curve.scale).max() > apart:
        raise ValueError(f"{wrong}the nearest one is at {shown(found.y)}.")
    return found


def contained(low: float, high: float, name: str, value: float, what: str) -> float:
    """Return the value of a parameter at the start of a curve, refused outside the range."""
    if not low <= value <= high:
        raise ValueError(
            f"range = ({low:.12g}, {high:.12g}) does not contain {name} = {value:.12g}, at "
            f"which the {what} is given."
        )
    return value


def checked_steps(max_step: float | None, max_points: int | None) -> tuple[float, int]:
    """Return the longest step, as a share of the range, and the number of points to either side."""
    share = MAX_STEP if max_step is None else max_step
    why = "It is a share of the range."
    step = finite_number("max_step", share, above=0.0, at_most=1.0, why=why)
    return step, whole_number("max_points", MAX_POINTS if max_points is None else max_points, 1)
