"""A motion of any model from event to event, with the derivatives of its state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.flow.engine import BlockEngine, block_engine
from stickslip.mechanics.flow.recorder import place
from stickslip.mechanics.flow.system import MAX_INSTANT
from stickslip.mechanics.model.orders import orders
from stickslip.mechanics.model.plant import ROUNDING
from stickslip.numerics.targets import launch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.mechanics.flow.blocks.system import BlockMotion
    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Floats, Ints


MANY: Final = 2**62  # events: no limit
AT_ONCE: Final = 2**16  # steps, some tenths of a second: Ctrl-C is heeded between


class State(NamedTuple):
    """State just after an event: coordinates z = (y, w) of the plant, modes, time."""

    z: Floats
    mode: Ints
    t: float = 0.0

    @property
    def w(self) -> Floats:
        """Relative velocities at the contacts, a part of z."""
        return self.z[len(self.z) - len(self.mode) :]

    @property
    def free(self) -> NDArray[np.bool_]:
        """Coordinates that may vary: all but the relative velocities of sticking contacts."""
        return np.concatenate([np.ones(len(self.z) - len(self.mode), dtype=bool), self.mode != 0])


@dataclass(frozen=True)
class Leg:
    """A piece of a motion: where it led from where, how long, why it ended, and its derivative."""

    start: State
    state: State
    duration: float
    status: int
    tangent: Floats  # (n, n), at the event that ends the leg or at its fixed duration
    parameter: Floats  # (n,), likewise
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
        self.system = self.engine.system
        self.n_contacts = model.plant.n_contacts
        self.n_waves = model.plant.n_waves
        self.n = len(self.system.constant) - self.n_contacts - self.n_waves
        columns = (self.n if tangents else 0) + (parameter is not None)
        self.work = self.engine.new_work()
        changes = [] if parameter is None else [self.engine.change(model, parameter)]
        directions = self.engine.directions(columns - len(changes), changes)
        self.motion: BlockMotion = self.engine.new_motion(directions)
        self.change = changes[0][0] if changes else None

    @property
    def period_change(self) -> float:
        """Change of the forcing's period; ValueError where there would be none any more."""
        return self.model.plant.period_change(self.change)

    def start(self, x: Floats, v: Floats) -> State:
        """State with these displacements and velocities, with the modes that it asks for."""
        plant = self.model.plant
        z = plant.coordinates(x, v)
        # Of a point that Newton's method has solved for, w is 0 to rounding only: a creep of 1e-18
        # would feel kinetic friction where rest feels up to the static limit.
        w = z[len(z) - self.n_contacts :]
        w[np.abs(w) <= ROUNDING * sizes_of(plant)[-w.size :]] = 0.0
        place(self.engine, self.motion, z, self.work)
        return self._state()

    def leg(self, state: State, n_events: int = MANY, *, max_time: float = math.inf) -> Leg:
        """Follow a motion for some events that change modes, or for a time."""
        motion = self.motion
        self.place(state)
        self._start_tangents()
        t = 0.0
        events: list[tuple[float, int, int]] = []
        count = instant = 0
        status = status_codes.OK
        while count < n_events and t < max_time:
            begun = t
            t, status = self.follow(t, max_time)
            instant = instant + 1 if t == begun else 0
            if status == status_codes.OK and instant > MAX_INSTANT * self.n_contacts:
                status = status_codes.UNDECIDED
            if status != status_codes.OK:
                break
            if motion.event.any():
                before = motion.mode.copy()
                self.engine.settle(motion, self.work)
                changed = np.flatnonzero(motion.mode != before)
                events += [(t, int(block), int(motion.mode[block])) for block in changed]
                count += changed.size > 0
        tangent = self._tangent(t if t >= max_time else None)
        states = self.n if tangent.shape[1] >= self.n else 0
        parameter = tangent[:, states] if tangent.shape[1] > states else np.zeros(self.n)
        return Leg(state, self._state(), t, int(status), tangent[:, :states], parameter, events)

    def follow(self, t: float, end: float, steps: int = AT_ONCE) -> tuple[float, int]:
        """Follow the motion from t to its next event, to an end, or for some steps.

        Return the time there, and a status.
        """
        engine, reached = self.engine, (t, status_codes.OK)

        def task(_start: int, _stop: int) -> None:
            nonlocal reached
            reached = engine.kernels.to_event(
                self.system, engine.laws, self.motion, self.work, self.rtol, t, end, steps
            )

        launch(task, 1, threads=1, smallest=1)  # which may be called off: searches take many
        return float(reached[0]), int(reached[1])

    def velocity(self, state: State) -> Floats:
        """Rate of change of a state, (y', w'), shape (n,)."""
        self.place(state)
        engine, motion = self.engine, self.motion
        engine.kernels.find_rates(self.system, engine.laws, motion, self.work.rates)
        flow, _, _ = self.model.plant.rows(motion.z[self.n_waves :], state.t)
        return np.concatenate([flow, self.work.rates])

    def place(self, state: State) -> None:
        """Take a state as the present one."""
        motion = self.motion
        motion.z[self.n_waves :], motion.mode[:], motion.clock[0] = state.z, state.mode, state.t
        motion.event[:] = 0
        self.engine.refresh(motion)

    def _tangent(self, time: float | None) -> Floats:
        """Differentiate the present state: at its event, or at a fixed time since the start."""
        # Events move the clock of a tangent, which holds the sum of these shifts.
        tangent = self.motion.tangent_z[self.n_waves :].copy()
        if time is None or not tangent.shape[1]:
            return tangent
        velocity = self.velocity(self._state())
        return np.asarray(tangent - np.outer(velocity, self.motion.tangent_clock))

    def _start_tangents(self) -> None:
        """Begin: y may vary, relative velocities of slipping contacts too."""
        motion = self.motion
        motion.tangent_z[:] = 0.0
        motion.tangent_clock[:] = 0.0
        if motion.tangent_z.shape[1] >= self.n:
            index = np.arange(self.n)
            motion.tangent_z[self.n_waves + index, index] = self._state().free
        if self.change is not None:
            cosine, sine = np.split(motion.z[: self.n_waves], 2)
            turned = self.change.phase + motion.clock[0] * self.change.frequency
            motion.tangent_z[: self.n_waves, -1] = *(-sine * turned), *(cosine * turned)

    def slides_for_ever(self) -> bool:
        """Whether the present motion can be shown never to reach the belt again."""
        engine = self.engine
        proved = engine.kernels.slides_for_ever(self.system, engine.laws, self.motion, self.work)
        return bool(proved)

    def _state(self) -> State:
        motion = self.motion
        z = motion.z[self.n_waves :].copy()
        return State(z, motion.mode.copy(), float(motion.clock[0]))


def sizes_of(plant: Plant) -> Floats:
    """Sizes of the states (y, w) of a plant's motions, shape (n,): friction's, and belts' too."""
    order, belt = orders(plant), float(np.abs(plant.V).max())
    carried = np.where(np.arange(order.state.size) < plant.n_positions, order.time, 1.0)
    return np.asarray(order.state + belt * carried)
