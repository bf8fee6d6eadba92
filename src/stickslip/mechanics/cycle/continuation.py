"""Limit cycles along a parameter: shooting from a section, followed by pseudo-arclength."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from scipy.optimize import brentq

from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem
from stickslip.checks import checked_interval, whole_number
from stickslip.mechanics.cycle.cycle import Cycle, cycle_of
from stickslip.mechanics.cycle.mode_changes import Touch, on_section, partners, touches
from stickslip.mechanics.cycle.section import Shot
from stickslip.mechanics.cycle.shooting import Shooter
from stickslip.mechanics.cycle.sliding import modes
from stickslip.mechanics.model.arguments import checked_model, checked_parameter
from stickslip.numerics.continuation import (
    ArclengthCurve,
    CurvePoint,
    LeavesRegion,
    StepControl,
    StepTooLong,
    WalkEnd,
    turns_back,
)
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.sliding import Model

    Floats = NDArray[np.float64]

CONTROL: Final = StepControl(first=0.005, smallest=1e-13, largest=1 / 32, patience=64)
MAX_POINTS: Final = 2000  # to either side
MAX_CHANGES: Final = 24  # changes of the sequence of modes that one curve is followed through
TOLD: Final = {"persists": ", goes on with other modes", "fold": ", meets another cycle", None: ""}
ORDER: Final = ("landing", "grazing", "limit", "tie")
DECISIVE: Final = 1e-5  # room that a touch may have left where a walk could go no further
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
        for start, ahead in ((row, row + 1), (row + 1, row)):
            shooting, y = on_section(self.cycles[start], name)
            low, high = sorted((float(curve.values[start]), value))
            period = float(y[-2]) if shooting.section.block is not None else 1.0
            scale = shooting.scale(float(np.ptp(curve.values)), period)
            line = ArclengthCurve(shooting, scale, low, high, CONTROL)
            try:
                here = line.point(y)
                rises = curve.values[ahead] > curve.values[start]
                *_, last = line.walk(here if rises else here.reversed())
            except (StepTooLong, LeavesRegion, ValueError):
                continue
            if last.parameter == value:
                return cycle_of(last.note)
        raise ValueError(
            f"{name} = {value:.12g}: the cycle is not found there with the modes that it has "
            "beside it."
        )

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return the period, on a straight line between two rows."""
        periods = curve.data["period"]
        after = periods[row + 1] if share else periods[row]
        return np.array([periods[row] + share * (after - periods[row])])


def follow_cycle(
    cycle: Cycle, parameter: str, range: tuple[float, float], *, max_points: int | None = None
) -> Curve:
    """Follow a limit cycle along a parameter of its model; see `stickslip.follow`.

    Unknowns are a state where a block comes to rest in space (of a forced model: at the
    forcing's phase at time 0), the period and the parameter. A curve goes on through folds, and
    where the sequence of modes changes it goes on with the cycle that is found there with
    other modes. Derivation: docs/theory/cycles.md.
    """
    low, high = _checked(cycle, parameter, range)
    most = whole_number("max_points", MAX_POINTS if max_points is None else max_points)
    backward, forward = (_Walk(cycle, parameter, (low, high), sign, most).run() for sign in (-1, 1))
    # One curve in one order: the walk downward is turned round.
    cycles = [*reversed(backward.cycles), *forward.cycles[1:]]
    values = [*reversed(backward.values), *forward.values[1:]]
    offset = len(backward.cycles) - 1
    passed = [
        replace(item, row=max(offset - item.row - 1, 0)) for item in reversed(backward.passed)
    ]
    passed += [replace(item, row=offset + item.row) for item in forward.passed]
    multipliers = np.array([each.multipliers for each in cycles])
    return Curve(
        kind="cycle",
        parameters={parameter: np.array(values)},
        points=np.array([each.x for each in cycles]),
        multipliers=multipliers,
        stable=np.array([each.stable for each in cycles]),
        ends=(backward.end(), forward.end()),
        bifurcations=tuple(passed),
        data={
            "period": np.array([each.period for each in cycles]),
            "events": np.array([len(each.events) for each in cycles]),
        },
        problem=CycleProblem(cycle.model, tuple(cycles)),
    )


def _checked(cycle: Cycle, parameter: str, ends: tuple[float, float]) -> tuple[float, float]:
    model = cycle.model
    checked_parameter("parameter", checked_model(model), parameter)
    low, high = checked_interval("range", ends)
    own = model.parameters[parameter]
    if not low <= own <= high:
        raise ValueError(
            f"range = ({low:.12g}, {high:.12g}) does not contain the model's own {parameter} = "
            f"{own!r}, where the cycle is."
        )
    for end in (low, high):
        model.replace(**{parameter: end})
    if not cycle.events and not (np.abs(np.abs(cycle.multipliers) - 1.0) > 1e-9).any():
        raise ValueError(
            "this motion belongs to a neutral family, which fills a region: it is no limit cycle "
            "that could be followed. See stickslip.equilibria(model)[0].neutral_family."
        )
    return low, high


class _Walk:
    """From a cycle in one direction of the parameter, through changes of modes."""

    def __init__(
        self,
        cycle: Cycle,
        name: str,
        ends: tuple[float, float],
        sign: int,
        max_points: int,
    ) -> None:
        self.model, self.name, self.ends, self.max_points = cycle.model, name, ends, max_points
        self.shooting, y = on_section(cycle, name)
        self.curve = self._curve(y)
        try:
            here = self.curve.point(y)
        except (StepTooLong, LeavesRegion) as reason:
            raise ValueError(
                "the cycle cannot be solved for with its own sequence of modes: it stands at a "
                "bifurcation, or touches a change of modes. Start from one beside it."
            ) from reason
        self.here = here if sign > 0 else here.reversed()
        self.cycles: list[Cycle] = [self._cycle(here)]
        self.values = [here.parameter]
        self.passed: list[CurveEvent] = []
        self.reason = "step limit"
        self.touch: Touch | None = None
        self.fresh = 0  # cycles when the section was last chosen

    def _curve(self, y: np.ndarray) -> ArclengthCurve:
        low, high = self.ends
        period = float(y[-2]) if self.shooting.section.block is not None else 1.0
        return ArclengthCurve(
            self.shooting, self.shooting.scale(high - low, period), low, high, CONTROL
        )

    def _cycle(self, point: CurvePoint) -> Cycle:
        shot: Shot = point.note
        return cycle_of(shot)

    # --- along the curve --------------------------------------------------------------------

    def run(self) -> _Walk:
        """Walk to the end."""
        for _ in range(MAX_CHANGES):
            reason = self._smooth_piece() or self._change_modes()
            if reason is not None:
                self.reason = reason
                return self
        self.reason = "point limit"
        return self

    def end(self) -> CurveEnd:
        """Why the walk ended, at its last cycle."""
        last = self.cycles[-1]
        return CurveEnd(self.reason, {self.name: self.here.parameter}, last.x, last.multipliers)

    def _event(self, kind: str, value: float, error: float, cycle: Cycle, **more: Any) -> None:
        """Note a bifurcation at the last row, or just after."""
        self.passed.append(
            CurveEvent(
                kind,
                {self.name: value},
                cycle.x,
                cycle.multipliers,
                error,
                len(self.cycles) - 1,
                solution=cycle,
                **more,
            )
        )

    def _smooth_piece(self) -> str | None:
        """Walk while the sequence of modes stays; None where it changes."""
        steps = self.curve.walk(self.here)
        while True:
            try:
                new = next(steps)
            except StopIteration as stop:
                return self._stopped(stop.value)
            if self._passes_rest(self.here, new):
                return self._vanish(self.here, new)
            self._look_between(self.here, new)
            self.here = new
            self.cycles.append(self._cycle(new))
            self.values.append(new.parameter)
            if len(self.cycles) >= self.max_points:
                return "point limit"

    def _stopped(self, end: WalkEnd) -> str | None:
        self.here = end.last
        if end.reason == "end of range":
            return "end of range"
        self.touch = self._touch()
        return None if self.touch is not None else self._elsewhere()

    def _elsewhere(self) -> str | None:
        """Go on from another section, where an event of another block has come to this one."""
        if len(self.cycles) < self.fresh + 2:
            return "step limit"
        rising = self.here.tangent[-1] > 0.0
        self.shooting, y = on_section(self.cycles[-1], self.name)
        self.curve = self._curve(y)
        try:
            start = self.curve.point(y)
        except (StepTooLong, LeavesRegion):
            return "step limit"
        self.here = start if (start.tangent[-1] > 0.0) == rising else start.reversed()
        self.fresh = len(self.cycles)
        return self._smooth_piece()

    def _passes_rest(self, a: CurvePoint, b: CurvePoint) -> bool:
        """Whether a slip cycle has shrunk to steady sliding and grown again, mirrored in time."""
        block = self.shooting.section.block
        if block is None or self.shooting.word:
            return False
        row = self.model.n_blocks + block
        return bool(a.note.velocity[row] * b.note.velocity[row] < 0.0)

    def _vanish(self, a: CurvePoint, b: CurvePoint) -> str:
        """End at the Hopf point, which is solved for on the modes of steady sliding."""
        frequency = 2.0 * np.pi / self.cycles[-1].period

        def growth(value: float) -> float:
            model = self.model.replace(**{self.name: value})
            values = modes(model, model.V).values
            return float(values[np.argmin(np.abs(values - 1j * frequency))].real)

        # On both sides the parameter has left its extreme, which is at the Hopf point.
        reach = 4 * abs(a.parameter - b.parameter) + AWAY
        low, high = b.parameter - reach, b.parameter + reach
        if growth(low) * growth(high) < 0.0:
            value = float(brentq(growth, low, high, xtol=1e-300, rtol=1e-15))
            self._event("hopf", value, 1e-15 * abs(value), self.cycles[-1])
            self.here = replace(a, y=np.append(a.y[:-1], value))
        return "vanishes"

    def _look_between(self, a: CurvePoint, b: CurvePoint) -> None:
        """Note what happens between two points: signs of test functions of the multipliers."""
        if turns_back(a, b):
            self._note("fold", a, b, lambda point: float(point.tangent[-1]))
        tests: list[tuple[str, Callable[[CurvePoint], float]]] = [
            ("flip", lambda point: _product(point.note.multipliers + 1.0)),
            ("neimark_sacker", _torus),
        ]
        if not turns_back(a, b):
            tests.append(("branch_point", lambda point: _product(point.note.multipliers - 1.0)))
        for kind, test in tests:
            if test(a) * test(b) < 0:
                self._note(kind, a, b, test)

    def _note(
        self, kind: str, a: CurvePoint, b: CurvePoint, test: Callable[[CurvePoint], float]
    ) -> None:
        try:
            point = self.curve.between(a, b, test)
        except (StepTooLong, LeavesRegion):
            return
        if kind == "neimark_sacker" and not _on_circle(point):
            return  # two real multipliers whose product is 1: nothing happens
        error = max(1e-15 * abs(point.parameter), abs(point.residual))
        self._event(kind, point.parameter, error, self._cycle(point))

    # --- where modes change -------------------------------------------------------------------

    def _touch(self) -> Touch | None:
        """Whatever is about to change the modes at the present point."""
        model, state, period = self.shooting.start(self.here.y)
        shooter = Shooter(model, rtol=self.shooting.rtol, tangents=False)
        found = [t for t in touches(shooter, state, period) if abs(t.room) < DECISIVE]
        # A law with F(0) = 1 lets a landing at the limit also graze: it is named a landing.
        return min(found, key=lambda touch: ORDER.index(touch.kind), default=None)

    def _change_modes(self) -> str | None:
        """Go on with a cycle of other modes beside the present point; else tell why not."""
        touch = self.touch
        assert touch is not None
        beside = partners(self.shooting, self.here, self.ends)
        before = self.here.parameter
        outcome = None if beside is None else beside.outcome
        # The walk has halved its steps down to rounding: what is left is its last one.
        error = max(abs(touch.room) ** 2, 4e-16 * abs(before), 2.0 * self.here.step)
        what = f"block {touch.block + 1}{TOLD[outcome]}"
        self._event(
            touch.kind,
            before,
            error,
            self.cycles[-1],
            what=what,
            block=touch.block + 1,
            outcome=outcome,
        )
        if beside is None:
            return touch.kind
        self.shooting = beside.shooting
        self.curve = self._curve(beside.y)
        start = self.curve.point(beside.y)
        self.here = start if beside.rising else start.reversed()
        self.cycles.append(self._cycle(start))
        self.values.append(start.parameter)
        return None


def _product(values: np.ndarray) -> float:
    """Real product of numbers that come in conjugate pairs, kept in bounds."""
    return float(np.prod(values / np.maximum(np.abs(values), 1.0)).real)


def _torus(point: CurvePoint) -> float:
    """Product of mu_i mu_j - 1 over pairs: zero where a complex pair is on the unit circle."""
    values = point.note.multipliers
    pairs = [a * b - 1.0 for a, b in itertools.combinations(values, 2)]
    return _product(np.array(pairs)) if pairs else 1.0


def _on_circle(point: CurvePoint) -> bool:
    values = point.note.multipliers
    return bool(((np.abs(np.abs(values) - 1.0) < 1e-6) & (np.abs(values.imag) > 1e-9)).any())
