"""A motion of any model from event to event, with the derivatives of its state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.flow.blocks.system import block_directions, new_block_motion
from stickslip.mechanics.flow.blocks.transitions import settle, update_needed
from stickslip.mechanics.flow.engine import BlockEngine, block_engine
from stickslip.mechanics.flow.system import LANDING, MAX_INSTANT
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.roots import EPSILON

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.mechanics.flow.blocks.system import BlockMotion
    from stickslip.mechanics.model.structure import Structure
    from stickslip.numerics.arrays import Floats, Ints


ALIASES = {"beta": "static_2"}
"""Parameters of `TwoBlock` that a chain calls otherwise."""


class State(NamedTuple):
    """State just after an event: displacements, relative velocities, modes, forcing phase."""

    x: Floats
    w: Floats
    mode: Ints
    phase: float

    @property
    def vector(self) -> Floats:
        """Displacements, then relative velocities, shape (2 N,)."""
        return np.concatenate([self.x, self.w])


@dataclass(frozen=True)
class Leg:
    """A piece of a motion: where it led, how long it took, why it ended, and its derivative."""

    state: State
    duration: float
    status: int
    tangent: Floats  # (2 N, 2 N), at the event that ends the leg or at its fixed duration
    parameter: Floats  # (2 N,), likewise
    events: list[tuple[float, int, int]]  # time since the start, block, new mode


class Shooter:
    """Follows one motion of a model, event by event, with derivatives by state and a parameter."""

    def __init__(
        self,
        model: Model,
        *,
        rtol: float = 1e-15,
        tangents: bool = True,
        parameter: str | None = None,
    ) -> None:
        self.model, self.rtol = model, rtol
        self.engine: BlockEngine = block_engine(model)
        # Without forcing the phase is a clock: its tangents are shifts of time.
        frequency = model.structure.frequency if model.structure.is_forced else 1.0
        self.system = self.engine.system._replace(frequency=frequency)
        n = model.n_blocks
        self.n = n
        states = 2 * n if tangents else 0
        columns = states + (parameter is not None)
        self.motion: BlockMotion = new_block_motion(n, columns)
        self.work = self.engine.new_work()
        laws = np.zeros((columns, n, self.engine.code.N_PARAMETERS))
        changes: list[Structure | None] = [None] * columns
        if parameter is not None:
            changes[-1], laws[-1] = _direction(model, self.engine, parameter)
        start = np.zeros((columns, max(n - 1, 0)))
        self.directions = block_directions(self.system, changes, laws, start)

    def start(self, x: Floats, v: Floats) -> State:
        """State with these displacements and velocities, with the modes that it asks for."""
        motion, system = self.motion, self.system
        motion.x[:] = x
        motion.w[:] = v - system.V
        motion.w[np.abs(motion.w) <= 2.0 * EPSILON * np.maximum(np.abs(v), system.V)] = 0.0
        motion.mode[:] = np.sign(motion.w)
        motion.event[:] = np.where(motion.w == 0.0, LANDING, 0)
        motion.phase[0] = self.model.structure.phase
        update_needed(system, motion)
        self.work.rates[:] = 0.0
        settle(system, motion, self.work.rates)
        return self._state()

    def leg(self, state: State, n_events: int, *, max_time: float = math.inf) -> Leg:
        """Follow a motion for some events that change modes, or for a time."""
        motion = self.motion
        self.place(state)
        self._start_tangents()
        t = 0.0
        events: list[tuple[float, int, int]] = []
        count = instant = 0
        status = status_codes.OK
        while count < n_events and t < max_time:
            if math.isinf(max_time) and self.slides_for_ever():
                status = status_codes.NEVER_SLIPPING
                break
            h, status = self.advance(max_time - t)
            t += h
            instant = instant + 1 if h == 0.0 else 0
            if status == status_codes.OK and instant > MAX_INSTANT * self.n:
                status = status_codes.UNDECIDED
            if status != status_codes.OK:
                break
            if motion.event.any():
                before = motion.mode.copy()
                settle(self.system, motion, self.work.rates)
                changed = np.flatnonzero(motion.mode != before)
                events += [(t, int(block), int(motion.mode[block])) for block in changed]
                count += changed.size > 0
        tangent = self._tangent(t if t >= max_time else None)
        states = tangent.shape[1] - (tangent.shape[1] % 2)
        parameter = tangent[:, states] if tangent.shape[1] > states else np.zeros(2 * self.n)
        return Leg(self._state(), t, int(status), tangent[:, :states], parameter, events)

    def advance(self, cap: float) -> tuple[float, int]:
        """Take one step, at most `cap` long, up to an event if one comes; length and status."""
        engine = self.engine
        h, status = engine.kernels.advance(
            self.system, engine.laws, self.directions, self.motion, self.work, self.rtol, cap
        )
        return float(h), int(status)

    def velocity(self, state: State) -> Floats:
        """Rate of change of a state, (x', w'), shape (2 N,)."""
        self.place(state)
        engine, motion = self.engine, self.motion
        rates = [
            engine.kernels.rate(self.system, engine.laws, motion, block) for block in range(self.n)
        ]
        return np.concatenate([motion.w + self.system.V, rates])

    def place(self, state: State) -> None:
        """Take a state as the present one."""
        motion = self.motion
        motion.x[:], motion.w[:], motion.mode[:] = state.x, state.w, state.mode
        motion.phase[0] = state.phase
        motion.event[:] = 0
        update_needed(self.system, motion)

    def _tangent(self, time: float | None) -> Floats:
        """Differentiate the present state: at its event, or at a fixed time since the start."""
        # Events move the clock of a tangent; the phase holds the sum of these shifts.
        motion, directions = self.motion, self.directions
        tangent = np.concatenate([motion.tangent_x, motion.tangent_w])
        if time is None or not tangent.shape[1]:
            return tangent
        own = directions.phase + directions.frequency * time
        shift = (motion.tangent_phase - own) / self.system.frequency
        return np.asarray(tangent - np.outer(self.velocity(self._state()), shift))

    def _start_tangents(self) -> None:
        """Begin: every displacement may vary, velocities of slipping blocks too."""
        motion, n = self.motion, self.n
        motion.tangent_x[:] = 0.0
        motion.tangent_w[:] = 0.0
        motion.tangent_phase[:] = self.directions.phase
        if motion.tangent_x.shape[1] >= 2 * n:
            index = np.arange(n)
            motion.tangent_x[index, index] = 1.0
            motion.tangent_w[index, n + index] = motion.mode != 0

    def slides_for_ever(self) -> bool:
        """Whether the present motion can be shown never to reach the belt again."""
        engine = self.engine
        proved = engine.kernels.slides_for_ever(self.system, engine.laws, self.motion, self.work)
        return bool(proved)

    def _state(self) -> State:
        motion = self.motion
        return State(motion.x.copy(), motion.w.copy(), motion.mode.copy(), float(motion.phase[0]))


def _direction(model: Model, engine: BlockEngine, name: str) -> tuple[Structure | None, Floats]:
    """Change of a model with one of its parameters: of its structure, or of its laws."""
    family, known = (
        (model.chain, ALIASES.get(name, name)) if isinstance(model, TwoBlock) else (model, name)
    )
    laws = np.zeros((model.n_blocks, engine.code.N_PARAMETERS))
    owners = family.law_parameters.get(known)
    if owners is None:
        return family.structure_direction(known), laws
    for block, own_name in owners:
        laws[block, engine.code.parameter_index(model.laws[block], own_name)] = 1.0
    return None, laws
