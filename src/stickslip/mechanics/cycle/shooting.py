"""A motion of any model from event to event, with the derivatives of its state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.flow.blocks.engine import BlockEngine, block_engine
from stickslip.mechanics.flow.blocks.forces import update_needed
from stickslip.mechanics.flow.blocks.mode import settle
from stickslip.mechanics.flow.blocks.system import block_directions, new_block_motion
from stickslip.mechanics.flow.system import LANDING
from stickslip.numerics.roots import EPSILON

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.equilibria import Model
    from stickslip.mechanics.flow.blocks.system import BlockMotion

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]

__all__ = ["Shooter", "State"]


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
    """A piece of a motion: where it led, how long it took, why it ended, and its derivative.

    ``tangent`` (2 N, 2 N): of the last state with respect to the first, at the event that ends
    the leg; ``events``: (time since the start, block, new mode).
    """

    state: State
    duration: float
    status: int
    tangent: Floats
    events: list[tuple[float, int, int]]


class Shooter:
    """Follows one motion of a model, event by event.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain or Oscillator
    rtol : float
    tangents : bool
        Whether to carry derivatives.
    """

    def __init__(self, model: Model, *, rtol: float = 1e-15, tangents: bool = True) -> None:
        self.model, self.rtol = model, rtol
        self.engine: BlockEngine = block_engine(model)
        n = model.n_blocks
        self.n = n
        columns = 2 * n if tangents else 0
        self.motion: BlockMotion = new_block_motion(n, columns)
        self.work = self.engine.new_work()
        laws = np.zeros((columns, n, self.engine.code.N_PARAMETERS))
        start = np.zeros((columns, max(n - 1, 0)))
        self.directions = block_directions(self.engine.system, [None] * columns, laws, start)

    def start(self, x: Floats, v: Floats) -> State:
        """State with these displacements and velocities, with the modes that it asks for."""
        motion, system = self.motion, self.engine.system
        motion.x[:] = x
        motion.w[:] = v - system.V
        motion.w[np.abs(motion.w) <= 2.0 * EPSILON * np.maximum(np.abs(v), system.V)] = 0.0
        motion.mode[:] = np.sign(motion.w)
        motion.event[:] = np.where(motion.w == 0.0, LANDING, 0)
        motion.phase[0] = self.model.structure.phase
        update_needed(system, motion)
        settle(system, motion, self.work.rates)
        return self._state()

    def leg(self, state: State, n_events: int, *, max_time: float = math.inf) -> Leg:
        """Follow a motion for some changes of mode, or for a time."""
        motion, engine = self.motion, self.engine
        motion.x[:], motion.w[:], motion.mode[:] = state.x, state.w, state.mode
        motion.phase[0] = state.phase
        motion.event[:] = 0
        update_needed(engine.system, motion)
        self._identity()
        t = 0.0
        events: list[tuple[float, int, int]] = []
        status = status_codes.OK
        while len(events) < n_events and t < max_time:
            if math.isinf(max_time) and self._slides_for_ever():
                status = status_codes.NEVER_SLIPPING
                break
            h, status = engine.kernels.advance(
                engine.system,
                engine.laws,
                self.directions,
                motion,
                self.work,
                self.rtol,
                max_time - t,
            )
            t += h
            if status != status_codes.OK:
                break
            if motion.event.any():
                before = motion.mode.copy()
                settle(engine.system, motion, self.work.rates)
                changed = np.flatnonzero(motion.mode != before)
                if changed.size:
                    events.append((t, int(changed[0]), int(motion.mode[changed[0]])))
        tangent = np.concatenate([motion.tangent_x, motion.tangent_w])
        return Leg(self._state(), t, int(status), tangent, events)

    def _identity(self) -> None:
        """Start the tangents: every displacement may vary, velocities of slipping blocks too."""
        motion, n = self.motion, self.n
        motion.tangent_x[:] = 0.0
        motion.tangent_w[:] = 0.0
        motion.tangent_phase[:] = 0.0
        if motion.tangent_x.shape[1]:
            index = np.arange(n)
            motion.tangent_x[index, index] = 1.0
            motion.tangent_w[index, n + index] = motion.mode != 0

    def _slides_for_ever(self) -> bool:
        engine = self.engine
        proved = engine.kernels.slides_for_ever(engine.system, engine.laws, self.motion, self.work)
        return bool(proved)

    def _state(self) -> State:
        motion = self.motion
        return State(motion.x.copy(), motion.w.copy(), motion.mode.copy(), float(motion.phase[0]))
