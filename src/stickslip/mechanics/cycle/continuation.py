"""Limit cycles along a parameter: shooting from a section, followed by pseudo-arclength."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from scipy.optimize import brentq

from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem, between
from stickslip.analysis.continuation.follower import (
    MAX_POINTS,
    Follower,
    Passed,
    contained,
    first_point,
)
from stickslip.analysis.continuation.half_period import flip_of_half
from stickslip.checks import checked_interval, whole_number
from stickslip.mechanics.cycle.cycle import Cycle, cycle_of, same_cycle
from stickslip.mechanics.cycle.mode_changes import (
    NOT_SOLVED,
    Touch,
    converged,
    on_section,
    partners,
    touches,
)
from stickslip.mechanics.cycle.section import EVENTS
from stickslip.mechanics.cycle.shooting import Shooter
from stickslip.mechanics.cycle.sliding import modes_about, steady_states
from stickslip.mechanics.model.arguments import checked_model, checked_parameter
from stickslip.numerics.continuation import (
    CurvePoint,
    LeavesRegion,
    StepControl,
    StepTooLong,
    WalkEnd,
    turns_back,
)
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.continuation.follower import Half
    from stickslip.analysis.work import Work
    from stickslip.mechanics.cycle.section import Shooting
    from stickslip.mechanics.cycle.sliding import Model

    Floats = NDArray[np.float64]

CONTROL: Final = StepControl(first=0.005, smallest=1e-13, largest=1 / 32, patience=64)
TOLD: Final = {"persists": ", goes on with other modes", "fold": ", meets another cycle", None: ""}
ORDER: Final = ("landing", "grazing", "limit", "tie")
DECISIVE: Final = 1e-5  # room that a touch may have left where a walk could go no further
SLANT: Final = 0.5  # of the cosine between cycle and section's normal: less asks for another one
LOST: Final = 1e-7  # of a value: beside it multipliers double only where a release is lost
AWAY: Final = 1e-6  # least half-width of the interval in which a Hopf point is solved for


@part
@dataclass(frozen=True, eq=False)
class CycleProblem(Problem):
    """A limit cycle, known at each row."""

    system: Model
    cycles: tuple[Cycle, ...]
    picture: ClassVar = "cycles.draw_cycle_curve"

    def row(self, curve: Curve, row: int) -> Cycle:
        """Return the cycle of a row."""
        return self.cycles[row]

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Cycle:
        """Walk from a row to the value, with its sequence of modes."""
        if not share:
            return self.cycles[row]
        for start in (row, row + 1):
            own = self.cycles[start].model.parameters[name]  # a row's may differ in the last digit
            low, high = sorted((own, value))
            follower = _CycleFollower(self.cycles[start], name, low, high, MAX_POINTS)
            with contextlib.suppress(ValueError):
                last = follower.reached(follower.start(), value)
                if last is not None:
                    return _cycle(last)
        raise ValueError(
            f"{name} = {value:.12g}: the cycle is not found there with the modes that it has "
            "beside it."
        )

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return the period, on a straight line between two rows."""
        return np.atleast_1d(between(curve.data["period"], row, share))


def follow_cycle(
    cycle: Cycle,
    parameter: str,
    range: tuple[float, float],
    *,
    max_points: int | None = None,
    work: Work | None = None,
) -> Curve:
    """Follow a limit cycle along a parameter of its model; see `stickslip.follow`.

    Unknowns are a state where a coordinate is extreme (of a forced model: at a phase of the
    forcing), the period and the parameter. A curve goes on through folds, and
    where the sequence of modes changes it goes on with the cycle that is found there with
    other modes. Derivation: docs/theory/cycles.md.
    """
    low, high = _checked(cycle, parameter, range)
    most = whole_number("max_points", MAX_POINTS if max_points is None else max_points)
    follower = _CycleFollower(cycle, parameter, low, high, most)
    return follower.follow(follower.start(), work)


def _checked(cycle: Cycle, parameter: str, ends: tuple[float, float]) -> tuple[float, float]:
    model = cycle.model
    checked_parameter("parameter", checked_model(model), parameter)
    low, high = checked_interval("range", ends)
    contained(low, high, parameter, model.parameters[parameter], "cycle")
    for end in (low, high):
        model.replace(**{parameter: end})
    sizes = np.abs(cycle.multipliers)
    held = sizes <= 1e-9
    if not cycle.events and (held | (np.abs(sizes - 1.0) <= 1e-9)).all():
        why = (
            "friction holds its contacts wherever they are."
            if held.any()
            else "see stickslip.equilibria(model)[0].neutral_family."
        )
        raise ValueError(
            "this motion belongs to a neutral family, which fills a region: it is no limit cycle "
            f"that could be followed; {why}"
        )
    return low, high


class _CycleFollower(Follower):
    """Follows a limit cycle through changes of modes."""

    kind = "cycle"
    most_borders: ClassVar = 24  # changes of the sequence of modes

    def __init__(self, cycle: Cycle, name: str, low: float, high: float, max_points: int) -> None:
        super().__init__(name, low, high, CONTROL, max_points)
        self.model, self.cycle = cycle.model, cycle
        self.fresh = 0  # rows when the section was last chosen

    def start(self) -> CurvePoint:
        """Set out from the cycle, the parameter rising."""
        y = self._on_section(self.cycle)
        self.first = self.shooting
        return first_point(self.curve, y, f"{NOT_SOLVED}. Start from one beside it: ")

    def walk(self, start: CurvePoint) -> Generator[CurvePoint, None, WalkEnd]:
        """Yield points, as long as the section lies across the cycle."""
        # Where it touched the cycle two crossings would meet, which looks like a fold.
        walk, least = super().walk(start), SLANT * abs(start.note.crossing)
        while True:
            try:
                point = next(walk)
            except StopIteration as stop:
                end: WalkEnd = stop.value
                return end
            yield point
            if abs(point.note.crossing) < least and self.low < point.parameter < self.high:
                return WalkEnd("region", point)

    def restart(self, start: CurvePoint) -> None:
        """Return to the start's section and modes."""
        self.fresh = 0
        self._take(self.first, start.y)

    def _on_section(self, cycle: Cycle) -> Floats:
        """Choose the section, and return the unknowns there."""
        shooting, y = on_section(cycle, self.name)
        self._take(shooting, y)
        return y

    def _take(self, shooting: Shooting, y: Floats) -> None:
        self.shooting = shooting
        self.curve = self.line(shooting, shooting.scale(self.high - self.low, y))

    # --- along the curve --------------------------------------------------------------------

    def points(self, point: CurvePoint) -> Floats:
        """Return the displacements where the period begins."""
        return _cycle(point).x

    def event(self, kind: str, point: CurvePoint, error: float, **more: Any) -> CurveEvent:
        """Describe a bifurcation, with the cycle there."""
        return super().event(kind, point, error, solution=_cycle(point), **more)

    def tests(self, here: CurvePoint, new: CurvePoint) -> Iterator[Any]:
        """A multiplier 1 may also tell of a branch point."""
        yield from super().tests(here, new)
        if not turns_back(here, new):
            yield "branch_point", _off_one

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """Solve for bifurcations, and for the Hopf point in which the curve ends."""
        if self._passes_rest(here, new):
            yield self._vanished(here, new)
        elif (merged := self._merged(here, new)) is not None:
            yield merged
        else:
            yield from super().passed(here, new)

    def _merged(self, here: CurvePoint, new: CurvePoint) -> Passed | None:
        """End at the flip of a cycle of half the period, if the halves have changed places."""
        # From there the curve would lead back the way it came, half a period later.
        if not turns_back(here, new):
            return None
        whole, apart, after = self.shooting, self._halves(here), self._halves(new)
        if apart is None or after is None or apart @ after >= 0.0:
            return None
        assert whole.word is not None
        word, rounds = whole.word[: len(whole.word) // 2], max(whole.rounds // 2, 1)
        half = replace(whole, word=word, rounds=rounds)

        def solve(value: float, y: Floats) -> tuple[Floats, float]:
            found = converged(half, np.append(y[:-1], value), self.high - self.low)
            if found is None:
                return y, np.nan
            return found, float(np.prod(half.shot(found).multipliers + 1.0).real)

        period = 0.5 * here.y[-2 : -2 + whole.free]
        middle = np.concatenate([here.y[: len(apart)] + 0.5 * apart, period, here.y[-1:]])
        found = flip_of_half(solve, middle, here.parameter, self.low, self.high)
        scale = self.curve.scale
        reach = scale[-1] * float(np.linalg.norm((new.y - here.y) / scale))
        if found is None or abs(found[0] - here.parameter) > reach:
            return None
        y = found[1].copy()
        y[len(apart) : -1] *= 2.0
        with contextlib.suppress(LeavesRegion):
            residual, _, shot = whole(y)
            point = replace(here, y=y, residual=float(np.abs(residual).max()), note=shot)
            return Passed(point, end=self.end(point, "period halves"))
        return None

    def _halves(self, point: CurvePoint) -> Floats | None:
        """How far a cycle is from its start after half a period; None: with other modes."""
        word, rounds, free = self.shooting.word or (), self.shooting.rounds, self.shooting.free
        if word != 2 * word[: len(word) // 2] or not (free or rounds % 2 == 0):
            return None
        shooter = Shooter(point.note.model, rtol=self.shooting.rtol, tangents=False)
        start = point.note.state
        end = shooter.leg(start, EVENTS, max_time=0.5 * point.note.leg.duration).state
        same = (end.mode == start.mode).all()
        return np.asarray((end.z - start.z) @ self.shooting.section.ways) if same else None

    def _closing(
        self, here: CurvePoint, new: CurvePoint, goals: Sequence[CurvePoint]
    ) -> tuple[float, CurvePoint] | None:
        """Find the cycle from which the walk set out, from whatever section it is met again."""
        for goal in goals:
            start, rises = goal.parameter, goal.tangent[-1] * new.tangent[-1] > 0.0
            if rises and (here.parameter - start) * (new.parameter - start) < 0.0:
                there = self.curve.between(here, new, partial(_off, start))
                if same_cycle(_cycle(there), _cycle(goal)):
                    return self._share(here, new, there), there
        return None

    def _passes_rest(self, a: CurvePoint, b: CurvePoint) -> bool:
        """Whether a slip cycle has shrunk to steady sliding and grown again, mirrored in time."""
        slips = not self.shooting.word and self.shooting.free
        return bool(slips and a.note.bend * b.note.bend < 0.0)

    def _vanished(self, a: CurvePoint, b: CurvePoint) -> Passed:
        """End at the Hopf point, which is solved for on the modes of steady sliding."""
        frequency = 2.0 * np.pi / a.note.leg.duration

        def growth(value: float) -> float:
            model = self.model.replace(**{self.name: value})
            (steady, *_) = steady_states(model, near=a.note.state.w)
            values = modes_about(model.plant, model.laws, steady).values
            return float(values[np.argmin(np.abs(values - 1j * frequency))].real)

        # On both sides the parameter has left its extreme, which is at the Hopf point.
        reach = 4 * abs(a.parameter - b.parameter) + AWAY
        low, high = b.parameter - reach, b.parameter + reach
        if growth(low) * growth(high) >= 0.0:
            return Passed(None, end=self.end(a, "vanishes"))
        value = float(brentq(growth, low, high, xtol=1e-300, rtol=1e-15))
        there = replace(a, y=np.append(a.y[:-1], value))
        event = self.event("hopf", there, 1e-15 * abs(value))
        return Passed(None, event, self.end(there, "vanishes"))

    def assembled(self, rows: list[CurvePoint], **known: Any) -> Curve:
        """Make a curve of its cycles."""
        cycles = [_cycle(row) for row in rows]
        return Curve(
            kind=self.kind,
            parameters={self.name: np.array([row.parameter for row in rows])},
            points=np.array([each.x for each in cycles]),
            multipliers=np.array([each.multipliers for each in cycles]),
            stable=np.array([each.stable for each in cycles]),
            data={
                "period": np.array([each.period for each in cycles]),
                "events": np.array([len(each.events) for each in cycles]),
            },
            problem=CycleProblem(self.model, tuple(cycles)),
            **known,
        )

    # --- where modes change -------------------------------------------------------------------

    def stopped(self, stop: WalkEnd, half: Half) -> CurvePoint | CurveEnd:
        """Go on with other modes, or from another section; else tell why not."""
        last, touch = stop.last, self._touch(stop.last)
        return self._elsewhere(last, half) if touch is None else self._beyond(last, touch, half)

    def _touch(self, last: CurvePoint) -> Touch | None:
        """Whatever is about to change the modes at a point."""
        model, state, period = self.shooting.start(last.y)
        shooter = Shooter(model, rtol=self.shooting.rtol, tangents=False)
        every = touches(shooter, state, period)
        found = [t for t in every if abs(t.room) < DECISIVE]
        # A law with F(0) = 1 lets a landing at the limit also graze: it is named a landing, also
        # where rounding has taken the last of it.
        touch = min(found, key=lambda touch: ORDER.index(touch.kind), default=None)
        if touch is None or touch.kind != "grazing":
            return touch
        told = (touch.block, 0) in (self.shooting.word or ())
        lands = any(t.kind == "landing" and t.block == touch.block for t in every)
        return touch._replace(kind="landing") if told and not lands else touch

    def _elsewhere(self, last: CurvePoint, half: Half) -> CurvePoint | CurveEnd:
        """Go on from another section, where an event of another block has come to this one."""
        end = self.end(last, "step limit")
        if len(half.rows) < self.fresh + 2:
            return end
        y = self._on_section(_cycle(last))
        self.fresh = len(half.rows)
        try:
            start = self.curve.point(y)
        except (StepTooLong, LeavesRegion):
            return end
        return start if (start.tangent[-1] > 0.0) == (last.tangent[-1] > 0.0) else start.reversed()

    def _beyond(self, last: CurvePoint, touch: Touch, half: Half) -> CurvePoint | CurveEnd:
        """Go on with a cycle of other modes beside a change of modes."""
        beside = partners(self.shooting, last, (self.low, self.high))
        outcome = None if beside is None else beside.outcome
        # The walk has halved its steps down to rounding: what is left is its last one.
        step = 2.0 * last.step * float(self.curve.scale[-1])
        if touch.kind == "limit" and (way := _since_half(half.rows, last)) < LOST * abs(
            last.parameter
        ):
            step = max(step, way)
        error = max(max(touch.room**2, 4e-16) * abs(last.parameter), step)
        block = touch.block + 1
        what = f"block {block}{TOLD[outcome]}{'' if beside is None else beside.symmetry}"
        half.note(self.event(touch.kind, last, error, what=what, block=block, outcome=outcome))
        if beside is None:
            return self.end(last, touch.kind)
        self._take(beside.shooting, beside.y)
        start = self.curve.point(beside.y)
        half.rows.append(start if beside.rising else start.reversed())
        return half.rows[-1]


def _cycle(point: CurvePoint) -> Cycle:
    return cycle_of(point.note)


def _since_half(rows: list[CurvePoint], last: CurvePoint) -> float:
    """Way in which the multiplier has doubled, as far as the end where it grows like 1 / way."""
    # A release that is lost, to friction that falls at once, comes at the square root of what the
    # force has beyond its limit: in the end rounding of the state leaves no step, and scatters it.
    sizes = [np.abs(row.note.multipliers).max() for row in (*rows, last)]
    first = next(k for k, size in enumerate(sizes) if size >= 0.5 * sizes[-1])
    return abs(rows[max(first - 1, 0)].parameter - last.parameter)


def _off(value: float, point: CurvePoint) -> float:
    return point.parameter - value


def _off_one(point: CurvePoint) -> float:
    """det(M - 1), zero where a multiplier is 1."""
    return float(np.prod(point.note.multipliers - 1.0).real)
