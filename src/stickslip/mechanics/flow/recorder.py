"""Following one motion step by step in Python, keeping what each step was."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip import status as status_codes
from stickslip.mechanics.flow.engine import Engine
from stickslip.mechanics.flow.mode import settle
from stickslip.mechanics.flow.onset import onset
from stickslip.mechanics.flow.system import (
    BACKWARD,
    LANDING,
    Motion,
    Phases,
    limit,
    new_motion,
)
from stickslip.numerics.roots import EPSILON

# Longer steps of the exact engine are cut: quadrature over a step must be accurate.
LONGEST_STEP = 1.5
# Steps, for each event allowed, after which a motion without an end time is given up.
STEPS_PER_EVENT = 10


@dataclass
class Record:
    """Steps of a motion: start times, states and modes; polynomials of the adaptive engine."""

    t: list[float] = field(default_factory=list)
    w: list[NDArray[np.float64]] = field(default_factory=list)
    e: list[NDArray[np.float64]] = field(default_factory=list)
    mode: list[NDArray[np.int64]] = field(default_factory=list)
    polynomials: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = field(default_factory=list)

    def add(self, t: float, motion: Motion) -> None:
        """Keep the state at the start of a step."""
        self.t.append(t)
        self.w.append(motion.w.copy())
        self.e.append(motion.e.copy())
        self.mode.append(motion.mode.copy())

    def drop(self) -> None:
        """Forget the last step: it could not be taken."""
        for values in (self.t, self.w, self.e, self.mode):
            values.pop()

    def phases(self) -> Phases:
        """All of it as arrays."""
        return Phases(np.array(self.w), np.array(self.e), np.array(self.mode))


class Recorder:
    """A motion that moves step by step; `run` ends it and returns why."""

    def __init__(self, engine: Engine, *, rtol: float, dense: bool) -> None:
        self.engine = engine
        self.rtol = rtol
        self.dense = dense
        self.motion = new_motion(0, engine.n_law_parameters)
        self.work = engine.new_work()
        self.record = Record()
        self.t = 0.0
        self.n_events = 0
        self.d: list[float] = []

    def start_on_belt(self, d: float) -> None:
        """Start at the end of the global stick phase `d`: there the first slip begins."""
        self.d.append(d)
        self._leave_belt()

    def start(self, x: NDArray[np.float64], v: NDArray[np.float64]) -> None:
        """Start from any state; a block at belt velocity rides if its force is in the limits."""
        alpha, _, V = self.engine.system
        motion = self.motion
        motion.e[:] = x + alpha * (x - x[::-1])
        motion.w[:] = v - V
        motion.w[np.abs(motion.w) <= 2.0 * EPSILON * np.maximum(np.abs(v), V)] = 0.0
        motion.mode[:] = np.sign(motion.w)
        motion.event[:] = np.where(motion.w == 0.0, LANDING, 0)
        settle(self.engine.system, motion)
        self._note_global_stick()

    def run(self, t_end: float, max_events: int, *, until_stick: bool) -> int:
        """Move until `t_end` or a limit, or the next global stick phase; return a status."""
        endless = math.isinf(t_end)
        for n, status in enumerate(self._steps(t_end)):
            if status != status_codes.OK:
                self.record.drop()
                return status
            if endless and self._slides_for_ever():
                return status_codes.NEVER_SLIPPING
            if endless and n >= STEPS_PER_EVENT * max_events:
                return status_codes.TIME_LIMIT
            if self.n_events >= max_events:
                return status_codes.EVENT_LIMIT
            if until_stick and self.n_events > 0 and not self.motion.mode.any():
                break
        return status_codes.OK

    def _slides_for_ever(self) -> bool:
        """Whether both blocks slip backward and never reach the belt again."""
        engine, motion = self.engine, self.motion
        if not (motion.mode == BACKWARD).all():
            return False
        return bool(engine.kernels.slides_for_ever(engine.system, engine.laws, motion, self.work))

    def finish(self) -> Record:
        """Return the record, closed by the last state."""
        self.record.add(self.t, self.motion)
        return self.record

    def _steps(self, t_end: float) -> Iterator[int]:
        while self.t < t_end:
            cap = min(LONGEST_STEP, t_end - self.t)
            self.record.add(self.t, self.motion)
            yield self._ride(cap) if not self.motion.mode.any() else self._slip(cap)

    def _slip(self, cap: float) -> int:
        """Take one step of the engine; blocks change modes at its end if there is an event."""
        engine, motion = self.engine, self.motion
        t, status = engine.kernels.advance(
            engine.system, engine.laws, motion, self.work, self.rtol, cap
        )
        if status != status_codes.OK:
            return int(status)
        self.t += t
        if self.dense and engine.name != "exact":
            self.record.polynomials.append((self.work.w.copy(), self.work.e.copy()))
        if motion.event.any():
            before = motion.mode.copy()
            settle(engine.system, motion)
            self.n_events += bool((motion.mode != before).any())
            self._note_global_stick()
        return int(status)

    def _ride(self, cap: float) -> int:
        """Global stick: the needed forces grow with the belt until one reaches its limit."""
        V = self.engine.system.V
        room = min(limit(self.engine.system, block) - self.motion.e[block] for block in range(2))
        t = max(room, 0.0) / V
        if self.dense and self.engine.name != "exact":
            self.record.polynomials.append(self._riding_polynomials())
        if t > cap:
            self.t += cap
            self.motion.e[:] += V * cap
            return status_codes.OK
        self.t += t
        self._leave_belt()
        return status_codes.OK

    def _riding_polynomials(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        w = np.zeros_like(self.work.w)
        e = np.zeros_like(self.work.e)
        e[:, 0] = self.motion.e
        e[:, 1] = self.engine.system.V
        return w, e

    def _leave_belt(self) -> None:
        """End the present global stick phase."""
        onset(self.engine.system, self.motion, self.d[-1])
        self.n_events += 1

    def _note_global_stick(self) -> None:
        if not self.motion.mode.any():
            spread = self.motion.e[1] - self.motion.e[0]
            self.d.append(float(spread / (1.0 + 2.0 * self.engine.system.alpha)))


def scratch(engine: Engine) -> tuple[Motion, Any]:
    """Work arrays for evaluating a recorded motion."""
    return new_motion(0, engine.n_law_parameters), engine.new_work()
