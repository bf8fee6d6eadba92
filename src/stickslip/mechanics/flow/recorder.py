"""Following one motion step by step in Python, keeping what each step was."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.flow.blocks import transitions as blocks
from stickslip.mechanics.flow.blocks.system import BlockMotion, BlockWork
from stickslip.mechanics.flow.dense import FORCE_ROUNDING
from stickslip.mechanics.flow.engine import BlockEngine
from stickslip.mechanics.flow.system import (
    BACKWARD,
    LANDING,
    MAX_INSTANT,
    Phases,
    System,
    limit,
    new_motion,
)
from stickslip.mechanics.flow.transitions import onset, round_landings
from stickslip.mechanics.model.arguments import Model
from stickslip.numerics.arrays import Floats, Ints
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import launch
from stickslip.results.parts import part, register

register(System)

# Longer steps of closed forms are cut: quadrature over a step must be accurate.
LONGEST_STEP = 1.5
# Steps, for each event allowed, after which a motion without an end time is given up.
STEPS_PER_EVENT = 10
# Steps of which the inside is kept: a few kilobytes each.
MOST_KEPT = 5_000_000

Instant: TypeAlias = tuple[Floats, Floats, Floats, Floats]
"""Displacements, velocities, relative velocities at contacts, needed forces."""
StatesInside: TypeAlias = Callable[[Ints, Floats], Instant]


@part
@dataclass(frozen=True, eq=False)
class Recorded:
    """A motion as it was followed: n steps of N blocks; entries of all but `inside`: n + 1."""

    t: Floats
    x: Floats
    v: Floats
    w: Floats
    e: Floats
    mode: Ints  # of each step; in the end those that the motion ends with
    inside: StatesInside | None  # (step, t since its start) -> Instant; None: events only


def phase_starts(mode: Ints) -> Ints:
    """Find the steps at which phases begin: the first, and each whose modes have changed."""
    changed = (mode[1:-1] != mode[:-2]).any(axis=1)
    return np.concatenate(([0], 1 + np.flatnonzero(changed)))


class Step(NamedTuple):
    """State at the start of a step of a motion, as its kernels hold it, and its modes."""

    t: float
    state: Floats
    mode: Ints


class Recorder(ABC):
    """A motion that moves step by step; `run` ends it and returns why."""

    # Keeps the `last` steps and global stick phases, or all; `dense`: what is inside steps too.

    def __init__(self, engine: Any, *, rtol: float, dense: bool, last: int | None = None) -> None:
        self.engine = engine  # Engine or BlockEngine
        self.motion = engine.new_motion(engine.directions())
        self.work = engine.new_work()
        self.rtol = rtol
        self.longest = LONGEST_STEP
        self.dense = dense
        self.polynomials: deque[Any] = deque()  # of each step, if closed forms are none
        self.record: deque[Step] = deque(maxlen=last)
        self.t = 0.0
        self.n_events = 0
        self.status = status_codes.OK  # why it ended
        self.is_closed = False  # no step led on from the state kept last
        self.d: deque[float | Floats] = deque(maxlen=last)

    # --- what a kind of motion must do -------------------------------------------------------

    @property
    def mode(self) -> Ints:
        """Present modes of the blocks."""
        return self.motion.mode

    @abstractmethod
    def start_on_belt(self, d: Floats) -> None:
        """Start at the end of a global stick phase: there the first slip begins."""

    @abstractmethod
    def start(self, x: Floats, v: Floats) -> None:
        """Start from any state; a block at belt velocity rides if its force is in the limits."""

    @abstractmethod
    def _state(self) -> Floats:
        """Present state, a copy."""

    @abstractmethod
    def shown(self, t: Floats, state: Floats) -> Instant:
        """Interpret states that were kept."""

    @property
    def last(self) -> Instant:
        """State kept last."""
        return self.shown(np.array(self.record[-1].t), self.record[-1].state)

    def keep(self) -> None:
        """Add the present state to the record."""
        self.record.append(Step(self.t, self._state(), self.mode.copy()))

    @abstractmethod
    def _series(self) -> Any:
        """Polynomials of the step just taken, copies."""

    @abstractmethod
    def _note_global_stick(self) -> None:
        """Keep the differences of a global stick phase, if one begins."""

    @abstractmethod
    def _inside(self) -> StatesInside:
        """How to evaluate the recorded steps."""

    # --- following ---------------------------------------------------------------------------

    @property
    def _keeps_polynomials(self) -> bool:
        return self.dense and self.engine.name != "exact"

    @property
    def _rides(self) -> bool:
        """Whether all that moves rides at one speed: then one step reaches the next event."""
        return not self.mode.any()

    def _slides_for_ever(self) -> bool:
        """Whether it can be shown that no block sticks again."""
        engine, motion = self.engine, self.motion
        if not (motion.mode == BACKWARD).all():
            return False
        return bool(engine.kernels.slides_for_ever(engine.system, engine.laws, motion, self.work))

    def _advance(self, cap: float) -> tuple[float, int]:
        """Take one step of at most `cap`, with the change of modes that ends it."""
        engine, motion = self.engine, self.motion
        t, status = engine.kernels.advance(
            engine.system, engine.laws, motion, self.work, self.rtol, cap
        )
        if status not in (status_codes.OK, status_codes.CONTACT_LOST):
            return 0.0, int(status)
        if self._keeps_polynomials:
            self.polynomials.append(self._series())
        if status == status_codes.OK and motion.event.any():
            self.n_events += self._settle()
            self._note_global_stick()
        return t, int(status)

    def _settle(self) -> bool:
        """Change the modes at an event; tell whether any changed."""
        return bool(self.engine.settle(self.motion, self.work))

    def run(self, t_end: float, max_events: int, *, until_stick: bool) -> int:
        """Move until `t_end` or a limit, or the next global stick phase; return a status."""
        for _ in self.follow(t_end, max_events, until_stick=until_stick):
            pass
        return self.status

    def follow(self, t_end: float, max_events: int, *, until_stick: bool) -> Iterator[None]:
        """Move as `run` does and pause after each step, the start of which was kept last."""
        endless = math.isinf(t_end)
        for n, status in enumerate(self._steps(t_end)):
            self.status = status
            if status not in (status_codes.OK, status_codes.CONTACT_LOST):
                self.is_closed = True
                return
            if status != status_codes.OK:
                pass  # the last step
            elif endless and self._slides_for_ever():
                self.status = status_codes.NEVER_SLIPPING
            elif endless and n >= STEPS_PER_EVENT * max_events:
                self.status = status_codes.TIME_LIMIT
            elif self._keeps_polynomials and n >= MOST_KEPT and self.t < t_end:
                self.status = status_codes.TIME_LIMIT
            elif self.n_events >= max_events:
                self.status = status_codes.EVENT_LIMIT
            yield
            if self.status != status_codes.OK:
                return
            if until_stick and self.n_events > 0 and not self.mode.any():
                return

    def _steps(self, t_end: float) -> Iterator[int]:
        instant, left, reached = 0, t_end, (0.0, status_codes.OK)

        def advance(_start: int, _stop: int) -> None:
            nonlocal reached
            reached = self._advance(left if self._rides else min(self.longest, left))

        while self.t < t_end:
            self.keep()
            left = t_end - self.t
            launch(advance, 1, threads=1, smallest=1)  # which may be called off
            t, status = reached
            if not np.isfinite(self._state()).all():
                status = status_codes.STEP_FAILED
            self.t = t_end if t == left else self.t + t
            instant = instant + 1 if t == 0.0 else 0
            stuck = instant > MAX_INSTANT * self.mode.size
            yield status_codes.UNDECIDED if stuck and status == status_codes.OK else status

    def close(self) -> None:
        """Keep the last state, where the motion ends."""
        if not self.is_closed:
            self.keep()

    def finish(self) -> Recorded:
        """Return the record, closed by the last state."""
        self.close()
        dense = self.dense and len(self.record) > 1
        t, state, mode = (np.array(values) for values in zip(*self.record, strict=True))
        return Recorded(t, *self.shown(t, state), mode, self._inside() if dense else None)


@part
@dataclass(frozen=True, eq=False)
class ClosedForms:
    """Motion within recorded steps of the exact engine."""

    system: System
    laws: Floats
    n_law_parameters: int
    w: Floats
    e: Floats
    mode: Ints

    def __call__(self, step: Ints, t: Floats) -> Instant:
        """As `StatesInside` says."""
        from stickslip.mechanics.flow import _exact_kernels as kernels

        w, e = np.empty((t.size, 2)), np.empty((t.size, 2))
        kernels.states(
            self.system,
            self.laws,
            new_motion(0, self.n_law_parameters),
            kernels.new_work(),
            Phases(self.w, self.e, self.mode),
            step.astype(np.int64),
            t,
            w,
            e,
        )
        return displacements(self.system.alpha, e), w + self.system.V, w, e


@part
@dataclass(frozen=True, eq=False)
class Sums:
    """Motion within recorded steps of the adaptive engine: polynomials of w and e."""

    alpha: float
    V: float
    w: Floats
    e: Floats

    def __call__(self, step: Ints, t: Floats) -> Instant:
        """As `ClosedForms`."""
        w, e = horner(self.w, step, t), horner(self.e, step, t)
        return displacements(self.alpha, e), w + self.V, w, e


class TwoBlockRecorder(Recorder):
    """A motion of a `TwoBlock`."""

    def start_on_belt(self, d: Floats) -> None:
        """Start at the end of the global stick phase `d`: there the first slip begins."""
        self.d.append(float(d[0]))
        self._leave_belt()

    def start(self, x: Floats, v: Floats) -> None:
        """Start from any state; a block at belt velocity rides if its force is in the limits."""
        alpha, _, V = self.engine.system
        motion = self.motion
        motion.e[:] = x + alpha * (x - x[::-1])
        motion.w[:] = v - V
        motion.w_low[:] = motion.e_low[:] = 0.0
        motion.w[np.abs(motion.w) <= 2.0 * EPSILON * np.maximum(np.abs(v), V)] = 0.0
        motion.mode[:] = np.sign(motion.w)
        motion.event[:] = np.where(motion.w == 0.0, LANDING, 0)
        round_landings(self.engine.system, motion, FORCE_ROUNDING)
        self.engine.settle(motion, self.work)
        self._note_global_stick()

    def _state(self) -> Floats:
        return np.stack([self.motion.w, self.motion.e])

    def shown(self, t: Floats, state: Floats) -> Instant:
        """Interpret states (w, e)."""
        w, e = state[..., 0, :], state[..., 1, :]
        return displacements(self.engine.system.alpha, e), w + self.engine.system.V, w, e

    def _advance(self, cap: float) -> tuple[float, int]:
        if self.motion.mode.any():
            return super()._advance(cap)
        return self._ride(cap), status_codes.OK

    def _series(self) -> tuple[Floats, Floats]:
        return self.work.w.copy(), self.work.e.copy()

    def _ride(self, cap: float) -> float:
        """Global stick: the needed forces grow with the belt until one reaches its limit."""
        V = self.engine.system.V
        room = min(limit(self.engine.system, block) - self.motion.e[block] for block in range(2))
        t = max(room, 0.0) / V
        if self._keeps_polynomials:
            self.polynomials.append(self._riding_polynomials())
        if t > cap:
            self.motion.e[:] += V * cap
            return cap
        self._leave_belt()
        return t

    def _riding_polynomials(self) -> tuple[Floats, Floats]:
        w = np.zeros_like(self.work.w)
        e = np.zeros_like(self.work.e)
        e[:, 0] = self.motion.e
        e[:, 1] = self.engine.system.V
        return w, e

    def _leave_belt(self) -> None:
        """End the present global stick phase."""
        onset(self.engine.system, self.motion, float(self.d[-1]))
        self.n_events += 1

    def _note_global_stick(self) -> None:
        if not self.motion.mode.any():
            spread = self.motion.e[1] - self.motion.e[0]
            self.d.append(float(spread / (1.0 + 2.0 * self.engine.system.alpha)))

    # --- afterwards --------------------------------------------------------------------------

    def _inside(self) -> StatesInside:
        system = self.engine.system
        if self.engine.name == "exact":
            _, state, mode = (np.array(values) for values in zip(*self.record, strict=True))
            laws, n = self.engine.laws, self.engine.n_law_parameters
            w, e = np.ascontiguousarray(np.moveaxis(state, 1, 0))
            return ClosedForms(system, laws, n, w, e, mode)
        w_rows, e_rows = (np.array(rows) for rows in zip(*self.polynomials, strict=True))
        return Sums(system.alpha, system.V, w_rows, e_rows)


def displacements(alpha: float, e: Floats) -> Floats:
    """Displacements from needed forces, both (..., 2)."""
    total = e[..., 0] + e[..., 1]
    d = (e[..., 1] - e[..., 0]) / (1.0 + 2.0 * alpha)
    return np.stack((0.5 * (total - d), 0.5 * (total + d)), axis=-1)


def horner(rows: Floats, step: Ints, t: Floats) -> Floats:
    """Values (m, N) of polynomials ``rows`` (steps, N, degree + 1) of given steps at times t."""
    total = np.zeros((t.size, rows.shape[1]))
    for k in range(rows.shape[-1] - 1, -1, -1):
        total = total * t[:, None] + rows[step, :, k]
    return total


@part
@dataclass(frozen=True, eq=False)
class BlockSums:
    """Motion within recorded steps: polynomials of z, times of the steps' starts."""

    model: Model
    start: Floats
    mode: Ints
    z: Floats

    def __call__(self, step: Ints, t: Floats) -> Instant:
        """As `StatesInside` says."""
        plant, z, time = self.model.plant, horner(self.z, step, t), self.start[step] + t
        e = plant.needed(z, time, self.mode[step], self.model.laws)
        return *plant.states(z, time), z[:, -plant.n_contacts :], e


class BlocksRecorder(Recorder):
    """A motion of any plant."""

    def __init__(
        self,
        engine: BlockEngine,
        model: Model,
        *,
        rtol: float,
        dense: bool,
        last: int | None = None,
    ) -> None:
        super().__init__(engine, rtol=rtol, dense=dense, last=last)
        self.model, self.plant = model, model.plant
        self.longest *= engine.system.longest

    def start_on_belt(self, d: Floats) -> None:
        """Start at the end of the global stick phase `d`: there the first slip begins."""
        self.d.append(np.array(d))
        blocks.onset(self.engine.system, self.motion, d)
        self.n_events += 1

    def start(self, x: Floats, v: Floats) -> None:
        """Start from any state; a contact at rest sticks if its force is in the limits."""
        place(self.engine, self.motion, self.plant.coordinates(x, v), self.work)
        self._note_global_stick()

    def _state(self) -> Floats:
        return np.concatenate([self.motion.z[self.plant.n_waves :], self.motion.e])

    def shown(self, t: Floats, state: Floats) -> Instant:
        """Interpret states (z, e)."""
        z, e = np.split(state, [-self.plant.n_contacts], axis=-1)
        return *self.plant.states(z, t), z[..., -self.plant.n_contacts :], e

    @property
    def _rides(self) -> bool:
        plant = self.plant
        return super()._rides and plant.rubs_as_one and not plant.is_forced

    def _series(self) -> Floats:
        return np.asarray(self.work.z[self.plant.n_waves :].copy())

    def _note_global_stick(self) -> None:
        if self.plant.rubs_as_one and not self.motion.mode.any():
            self.d.append(np.diff(self.motion.y[self.plant.n_waves :]))

    def _inside(self) -> StatesInside:
        t, _, mode = (np.array(values) for values in zip(*self.record, strict=True))
        return BlockSums(self.model, t, mode, np.array(self.polynomials))


def place(engine: BlockEngine, motion: BlockMotion, z: Floats, work: BlockWork) -> None:
    """Start a motion at coordinates z, with the modes that they ask for."""
    motion.z[-z.size :] = z
    motion.clock[0] = 0.0
    motion.mode[:] = np.sign(motion.w)
    motion.event[:] = np.where(motion.w == 0.0, LANDING, 0)
    work.rates[:] = 0.0
    engine.refresh(motion)
    turned = motion.mode * motion.w < 0.0
    if turned.any():  # feet that cannot slip the way they are said to: they begin at rest
        resting = z.copy()
        resting[-turned.size :][turned] = 0.0
        place(engine, motion, resting, work)
        return
    engine.settle(motion, work)
