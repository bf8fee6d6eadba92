"""Derivatives of a motion in time: of its states, events and slips, in parameters and the start."""

# A motion is followed once more with a tangent for each direction (docs/theory/sensitivity.md).

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, NamedTuple

import numpy as np

from stickslip import status as status_codes
from stickslip.checks import one_of, parameter_name, real_numbers, shown
from stickslip.mechanics.flow.blocks.system import TangentSteps, block_directions
from stickslip.mechanics.flow.blocks.transitions import excess_rate
from stickslip.mechanics.flow.engine import block_engine
from stickslip.mechanics.flow.recorder import BlocksRecorder, phase_starts, place
from stickslip.mechanics.flow.slip import SlipTracker
from stickslip.mechanics.flow.system import AT_UPPER_LIMIT, LANDING, STICK
from stickslip.mechanics.model.arguments import Model
from stickslip.mechanics.model.orders import orders
from stickslip.mechanics.model.plant import TINY
from stickslip.results.parts import part, register
from stickslip.results.result import Result
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.flow.blocks.system import BlockDirections, BlockMotion
    from stickslip.mechanics.flow.engine import BlockEngine
    from stickslip.mechanics.flow.recorder import Recorded
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.mechanics.model.plant import Reduced
    from stickslip.numerics.arrays import Floats, Ints

register(TangentSteps)

# Clearance, of the model's orders of magnitude, below which rounding may decide an event.
NO_CLEARANCE: Final = 1e-12
# Of the motion's order of time + t: events of two computations that are further apart are not one.
SAME_EVENT: Final = 1e-6


@part
class Origin(NamedTuple):
    """Where a motion was started, a state or a global stick phase, and its truncation error."""

    x: Floats | None
    v: Floats | None
    d: Floats | None
    rtol: float


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(Result):
    """Derivatives of a motion; ``Trajectory.derivative`` makes it.

    Each array has a last axis with an entry for each of `names`. The row of an event or slip is
    that of ``trajectory.events`` or ``trajectory.slips``.

    Attributes
    ----------
    trajectory : Trajectory
        The motion.
    names : tuple of str
        What is differentiated by: parameters, ``"x0_1"``, ``"v0_1"``, ``"d"``.
    t_end : float
        Time up to which there are derivatives; all that is later is NaN.
    margin : float
        Least clearance on the way, as of ``EventMapResult.margin``, in powers of ten of the plant's
        forces, velocities and times: how near an event is to appear, to vanish or to meet another
        one. Differences over a step that takes it up differ.
    margin_time : float
        When that was.
    status : int
        `stickslip.status`: OK; ONE_SIDED where the clearance is none; UNDECIDED where rounding has
        grown so much that the motion could not be repeated to its end.
    event_times : ndarray, shape (events, names)
    slip_starts, slip_durations, slip_moments : ndarray, shape (slips, names)
    d : ndarray, shape (k, names) for two blocks, else (k, N - 1, names)
        Of the differences in its global stick phases.
    """

    trajectory: Trajectory
    names: tuple[str, ...]
    t_end: float
    margin: float
    margin_time: float
    status: int
    d: Floats
    _steps: TangentSteps
    _plot: ClassVar = "motion.plot_sensitivity"

    @property
    def message(self) -> str:
        """What the status means."""
        if self.status == status_codes.OK:
            return f"least clearance {self.margin:.3g} at t = {self.margin_time:.6g}"
        if self.status == status_codes.ONE_SIDED:
            return f"{status_codes.MESSAGES[self.status]} (t = {self.margin_time:.6g})"
        return f"rounding has grown too much: no derivatives beyond t = {self.t_end:.6g}"

    def __repr__(self) -> str:
        """One line."""
        by = ", ".join(self.names)
        return f"Sensitivity by {by}: t = 0 .. {self.t_end:.6g}, {self.message}"

    def x(self, t: ArrayLike, *, side: Literal["right", "left"] = "right") -> Floats:
        """Differentiate the displacements at fixed times.

        Parameters
        ----------
        t : array_like of float, any shape
            Times within the trajectory, units of sqrt(m / k).
        side : {"right", "left"}
            At an event: just after it, or just before.

        Returns
        -------
        ndarray of float, shape (..., N, names)

        Raises
        ------
        ValueError
            A time is NaN or negative.
        """
        return self.states(t, side)[0]

    def v(self, t: ArrayLike, *, side: Literal["right", "left"] = "right") -> Floats:
        """Differentiate the velocities, shape (..., N, names); as `x`."""
        return self.states(t, side)[1]

    @cached_property
    def event_times(self) -> Floats:
        """Derivatives of the times of events, shape (events, names)."""
        steps = [(k, mode) for k, mode in zip(self._changes, self._modes, strict=True)]
        rows = [
            self._steps.clock[k]
            for (_, old), (k, new) in itertools.pairwise(steps)
            for _ in np.flatnonzero(old != new)
        ]
        return self._known([event.time for event in self.trajectory.events], rows)

    @cached_property
    def _slips(self) -> Floats:
        """Derivatives of starts, durations and moments, shape (slips, 3, names)."""
        steps, plant = self._steps, self.trajectory.model.plant
        index = np.array(self._changes)
        t, clock = steps.t[index], steps.clock[index]
        x, v = plant.states(steps.z[index], t)
        moved = self._at(index, t)[:, : plant.n_positions]
        travels = self._directions.travels(t, clock, x, v, moved)
        times = np.column_stack([t, clock])
        tracker = SlipTracker(plant, self.trajectory._record.w[0])
        found = [
            np.array(slip[:2] + slip[3:])[:, 1:]
            for time, travel, mode in zip(times, travels, self._modes, strict=True)
            for slip in tracker.see(time, travel, mode)
        ]
        ends = [slip.start + slip.duration for slip in self.trajectory.slips]
        return self._known(ends, found, 3)

    @property
    def slip_starts(self) -> Floats:
        """Derivatives of the slips' starts, shape (slips, names)."""
        return self._slips[:, 0]

    @property
    def slip_durations(self) -> Floats:
        """Derivatives of the slips' durations, shape (slips, names)."""
        return self._slips[:, 1]

    @property
    def slip_moments(self) -> Floats:
        """Derivatives of the slips' moments, shape (slips, names)."""
        return self._slips[:, 2]

    def _columns(self) -> dict[str, Any]:
        moved = {f"time_by_{name}": self.event_times[:, k] for k, name in enumerate(self.names)}
        return dict(self.trajectory.table()) | moved

    # --- inside -------------------------------------------------------------------------------

    @cached_property
    def _changes(self) -> list[int]:
        """Steps at which a phase begins, and the end."""
        return [*phase_starts(self._steps.mode).tolist(), len(self._steps.t) - 1]

    @property
    def _modes(self) -> Ints:
        return np.asarray(self._steps.mode[self._changes])

    def _known(self, times: list[float], rows: list[Floats], *shape: int) -> Floats:
        """Rows for the events at given times; NaN where there are no derivatives any more."""
        table = np.full((len(times), *shape, len(self.names)), np.nan)
        goes_on = self.t_end == self.trajectory.t[-1]
        known = len(times) if goes_on else int(np.searchsorted(times, self.t_end))
        known = min(known, len(rows))
        table[:known] = np.array(rows[:known]).reshape(known, *table.shape[1:])
        return table

    @cached_property
    def _engine(self) -> BlockEngine:
        return block_engine(self.trajectory.model)

    @cached_property
    def _directions(self) -> _Directions:
        return _Directions(self._engine, self.trajectory.model, self.names)

    def states(
        self, t: ArrayLike, side: Literal["right", "left"] = "right"
    ) -> tuple[Floats, Floats]:
        """Differentiate displacements and velocities at once; see `x`."""
        one_of("side", side, ("right", "left"))
        times = real_numbers("t", t)
        if not (times >= 0.0).all():
            bad = times[~(times >= 0.0)].flat[0]
            raise ValueError(f"t = {float(bad)!r} is outside the trajectory; allowed: t >= 0")
        # Events of a trajectory may be a rounding away from those of the motion that repeats it.
        own = self.trajectory.t[:-1]
        index = np.minimum(np.searchsorted(own, times), len(own) - 1)
        repeated = self._steps.t[self._changes[:-1]]
        event = (own[index] == times) & (index < len(repeated))
        flat = np.where(event, repeated[np.minimum(index, len(repeated) - 1)], times).ravel()
        order = np.argsort(flat, kind="stable")
        steps = self._steps
        known = flat[order] <= self.t_end
        asked = flat[order][known]
        step = np.searchsorted(steps.t, asked, side=side) - 1
        step = np.clip(step, 0, len(steps.t) - 1)
        plant = self.trajectory.model.plant
        n_states = len(plant.mass) + plant.n_positions
        moved = np.full((len(flat), n_states, len(self.names)), np.nan)
        moved[order[known]] = self._at(step, asked)
        first, second = np.split(moved, [plant.n_positions], axis=1)
        x, v = plant.split(first, second)
        return x.reshape(*times.shape, *x.shape[1:]), v.reshape(*times.shape, *v.shape[1:])

    def _at(self, step: Ints, t: Floats) -> Floats:
        """Differentiate positions, then velocities, at times in ascending steps."""
        engine, steps, plant = self._engine, self._steps, self.trajectory.model.plant
        n = steps.z.shape[1]
        z, out = np.zeros((len(t), n)), np.zeros((len(t), n, len(self.names)))
        engine.kernels.tangents_at_times(
            *(engine.system, engine.laws, engine.new_motion(self._directions.rows)),
            *(engine.new_work(), steps, step.astype(np.int64), t - steps.t[step], z, out),
        )
        moved = np.asarray(plant.jacobians[0] @ out)
        for column, change in enumerate(self._directions.changes):
            if change is not None:
                moved[..., column] += plant.states_change(z, t, change)
        return moved


class _Directions:
    """What a motion is differentiated by, in the form that kernels take; an entry per name."""

    def __init__(self, engine: BlockEngine, model: Model, names: tuple[str, ...]) -> None:
        plant, m = model.plant, len(engine.system.mass)
        n, n_positions = len(plant.mass), plant.n_positions
        self.model, self.names = model, names
        self.changes: list[Reduced | None] = []
        laws = np.zeros((len(names), m, engine.code.N_PARAMETERS))
        phases = np.zeros((len(names), m - 1))
        self.starts = np.zeros((n_positions + n, len(names)))  # of a starting state
        first = {"x0": 0, "v0": n_positions} if n_positions else {"x0": 0}
        for column, name in enumerate(names):
            change: Reduced | None = None
            if name in model.parameters:
                change, laws[column] = engine.change(model, name)
            else:
                kind, _, number = name.partition("_")
                index = int(number or 1) - 1
                if kind == "d":
                    phases[column, index] = 1.0
                else:
                    self.starts[first[kind] + index, column] = 1.0
            self.changes.append(change)
        self.rows: BlockDirections = block_directions(engine.system, self.changes, laws, phases)

    def begin(self, motion: BlockMotion) -> None:
        """Start the tangents of a motion that has been placed at a state."""
        plant = self.model.plant
        n_waves, z = plant.n_waves, motion.z[plant.n_waves :]
        into = plant.jacobians[1]
        motion.tangent_z[n_waves:] = into @ self.starts
        cosine, sine = np.split(motion.z[:n_waves], 2)
        for column, change in enumerate(self.changes):
            if change is not None:
                motion.tangent_z[n_waves:, column] -= into @ plant.states_change(z, 0.0, change)
                turned = np.concatenate([-sine * change.phase, cosine * change.phase])
                motion.tangent_z[:n_waves, column] = turned
        motion.tangent_w[motion.mode == STICK] = 0.0

    def travels(self, t: Floats, clock: Floats, x: Floats, v: Floats, dx: Floats) -> Floats:
        """``Plant.travel`` and its derivatives at the times of events, (k, m, 1 + names)."""
        # `clock` (k, names) moves the times; `dx` (k, n, names) is at fixed times.
        plant, model = self.model.plant, self.model
        at_event = dx + v[:, :, None] * clock[:, None, :]
        found = np.empty((len(t), plant.n_contacts, 1 + len(self.names)))
        plants = [
            plant if change is None else model.moved_plant(name)
            for name, change in zip(self.names, self.changes, strict=True)
        ]
        for k, time in enumerate(t):
            found[k, :, 0] = plant.travel(x[k], time)
            for column, moved in enumerate(plants):
                place, later = at_event[k, :, column], clock[k, column]
                shifted = moved.travel(x[k] + 1j * TINY * place, time + 1j * TINY * later)
                found[k, :, 1 + column] = np.imag(shifted) / TINY
        return found


class TangentRecorder(BlocksRecorder):
    """A motion that is followed with tangents, and with its clearances."""

    def __init__(self, engine: BlockEngine, model: Model, names: tuple[str, ...], rtol: float):
        super().__init__(engine, model, rtol=rtol, dense=False)
        self.directions = _Directions(engine, model, names)
        self.motion = engine.new_motion(self.directions.rows)
        self.orders = orders(model.plant)
        self.work.watch[:] = 1.0, self.orders.velocity, *self.orders.force
        self.tangents: list[tuple[Floats, Floats]] = []
        self.margins: list[float] = []  # of each step and the event that ends it
        self.touches: list[float] = []  # times
        self.phases: list[Floats] = []  # derivatives of the differences in global stick phases
        self.d_times: list[float] = []  # when these begin
        self._last: tuple[float, int] = (-math.inf, -1)  # event: time, and contact if there is one

    def start_on_belt(self, d: Floats) -> None:
        """Start as a global stick phase ends."""
        super().start_on_belt(d)
        self.phases.append(self.directions.rows.start.T.copy())
        self.d_times.append(0.0)
        leaving = np.count_nonzero(self.mode)
        self.margins.append(self._room(self.mode == STICK) if leaving == 1 else 0.0)

    def start(self, x: Floats, v: Floats) -> None:
        """Start from a state."""
        place(self.engine, self.motion, self.plant.coordinates(x, v), self.work)
        self.directions.begin(self.motion)
        self._note_global_stick()
        self.margins.append(self._room(self.motion.w == 0.0))

    def keep(self) -> None:
        """Add the present state and its tangents to the record."""
        super().keep()
        motion = self.motion
        self.tangents.append((motion.tangent_z.copy(), motion.tangent_clock.copy()))

    def _room(self, of: NDArray[np.bool_] | NDArray[np.intp]) -> float:
        """Least distance of some contacts' needed forces from their limits."""
        room = np.abs(self.motion.limit - np.abs(self.motion.e)) / self.orders.force
        return float(np.min(room[of], initial=math.inf))

    def _advance(self, cap: float) -> tuple[float, int]:
        self.work.margin[0] = math.inf
        self.motion.shift[:] = 0.0
        t, status = super()._advance(cap)
        self.margins.append(float(self.work.margin[0]))
        return t, status

    def _settle(self) -> bool:
        motion, time, unit = self.motion, float(self.motion.clock[0]), self.orders
        here = np.flatnonzero(motion.event)
        rests = (motion.mode == STICK) & (motion.event == 0)
        margin = min(self._room(rests), float(self.work.margin[0]))
        for each in here:
            if motion.event[each] == LANDING:
                pull = abs(self.work.rates[each]) / unit.velocity * unit.time
                margin = min(margin, self._room(np.array([each])), pull)
            elif motion.joint is None:
                side = 1.0 if motion.event[each] == AT_UPPER_LIMIT else -1.0
                rate = excess_rate(self.engine.system, motion, self.work.rates, int(each), side)
                margin = min(margin, abs(rate) / unit.force[each] * unit.time)
        before, contact = self._last
        if len(here) > 1 and motion.joint is None:
            margin = 0.0
        elif here[0] != contact:
            margin = min(margin, (time - before) / unit.time)
        self._last = time, int(here[0])
        if np.isnan(motion.shift).any():
            margin = 0.0
            self.touches.append(time)
        self.work.margin[0] = margin
        return super()._settle()

    def _note_global_stick(self) -> None:
        before = len(self.d)
        super()._note_global_stick()
        if len(self.d) > before:
            places = self.motion.tangent_y[self.plant.n_waves :]
            self.phases.append(np.diff(places, axis=0))
            self.d_times.append(float(self.motion.clock[0]))


def sensitivity(trajectory: Trajectory, names: tuple[str, ...]) -> Sensitivity:
    """Differentiate a motion; see ``Trajectory.derivative``."""
    model, origin = trajectory.model, trajectory._origin
    if origin is None:
        raise ValueError("a motion of the quasistatic limit has no derivatives in time")
    names = _columns_of(model, names, origin)
    engine = block_engine(model)
    recorder = TangentRecorder(engine, model, names, origin.rtol)
    if origin.d is not None:
        recorder.start_on_belt(origin.d)
    else:
        recorder.start(np.asarray(origin.x), np.asarray(origin.v))
    return _result(trajectory, recorder, _repeated(recorder, trajectory))


def _columns_of(model: Model, asked: tuple[Any, ...], origin: Origin) -> tuple[str, ...]:
    """Names of single numbers; ValueError for one that is unknown, or has no meaning here."""
    starts: dict[str, list[str]]
    if origin.d is not None:
        starts = {"d": ["d"] if model.d_shape == () else _numbered("d", len(origin.d))}
    else:
        both = {"x0": np.asarray(origin.x), "v0": np.asarray(origin.v)}
        starts = {name: _numbered(name, state.size) for name, state in both.items() if state.size}
    single = {name for names in starts.values() for name in names}
    known = list(dict.fromkeys([*model.parameters, *starts, *sorted(single)]))
    names: list[str] = []
    for name in asked:
        if isinstance(name, str) and name in starts and name not in model.parameters:
            if taken := [each for each in starts[name] if each in model.parameters]:
                raise ValueError(
                    f"names = {shown(asked)}: {', '.join(taken)} of the start are parameters of "
                    "the model, too. Give those of the friction laws another name."
                )
            names += starts[name]
        else:
            names.append(parameter_name("names", name, known, of="this motion"))
    if not names or len(set(names)) < len(names):
        raise ValueError(
            f"names = {shown(asked)} is not allowed: give what to differentiate by, each once. "
            f"{did_you_mean('', known)}"
        )
    return tuple(names)


def _numbered(name: str, n: int) -> list[str]:
    return [f"{name}_{k}" for k in range(1, n + 1)]


def _repeated(recorder: TangentRecorder, trajectory: Trajectory) -> Recorded:
    """Follow a motion once more, as far as the trajectory goes."""
    t, mode = trajectory._record.t, trajectory._record.mode
    end = float(t[-1])
    # The event that ended a motion may come a rounding later in another engine.
    at_event = len(t) > 1 and bool((mode[-1] != mode[-2]).any())
    spare = SAME_EVENT * (recorder.orders.time + end) if at_event else 0.0
    for _ in recorder.follow(end + spare, sys.maxsize, until_stick=False):
        if at_event and recorder.t >= end - spare and (recorder.mode == mode[-1]).all():
            break
    return recorder.finish()


def _result(trajectory: Trajectory, recorder: TangentRecorder, record: Recorded) -> Sensitivity:
    """Put together what a recorder has found, as far as it went as the trajectory did."""
    end = float(trajectory.t[-1])
    tangent, clock = (np.array(each) for each in zip(*recorder.tangents, strict=True))
    z = np.array([step.state for step in recorder.record])[:, : -recorder.plant.n_contacts]
    t_end = min([_agreement(trajectory, record, recorder.orders.time), *recorder.touches])
    margins = np.array(recorder.margins)
    margins[record.t > t_end] = math.inf
    least = int(np.argmin(margins))
    status = status_codes.OK
    if margins[least] <= NO_CLEARANCE:
        status = status_codes.ONE_SIDED
    elif t_end < end:
        status = status_codes.UNDECIDED
    shape = (len(trajectory.d), *trajectory.d.shape[1:], len(recorder.directions.names))
    d = np.full(shape, np.nan)
    phases = np.array(recorder.phases).reshape(len(recorder.phases), *shape[1:])
    known = len(d) if t_end == end else int(np.searchsorted(recorder.d_times, t_end))
    kept = min(known, len(phases), len(d))
    d[:kept] = phases[:kept]
    return Sensitivity(
        trajectory=trajectory,
        names=recorder.directions.names,
        t_end=t_end,
        margin=float(margins[least]),
        margin_time=float(record.t[least]),
        status=status,
        d=d,
        _steps=TangentSteps(record.t, z, record.mode, tangent, clock),
    )


def _agreement(trajectory: Trajectory, record: Recorded, unit: float) -> float:
    """Time up to which a motion has the phases of a trajectory."""
    starts = phase_starts(record.mode)
    times, modes = record.t[starts], record.mode[starts]
    for k, (time, mode) in enumerate(zip(trajectory.t, trajectory.modes, strict=False)):
        if k == len(times) or (modes[k] != mode).any():
            return float(min(time, times[min(k, len(times) - 1)]))
        if abs(times[k] - time) > SAME_EVENT * (unit + time):
            return float(min(time, times[k]))
    return float(trajectory.t[-1])
