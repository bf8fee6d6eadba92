"""The event map with scipy's solver and its events, as its documentation recommends.

`scipy.integrate.solve_ivp`: one event function for each thing that may happen, with
``terminal`` and ``direction``; a new call for each phase of the motion, from the state at which
the event function was zero; DOP853, which is recommended for tight tolerances. Parameters go
through ``args``. The right-hand side and the events are plain Python on floats, faster here than
arrays of two. No push off the surface and no ``max_step``: neither is asked for there.

The state is (x_1, x_2, v_1, v_2); the modes -1, 0, +1 (backward, stick, forward) are held
outside, since the equations change with them: a hybrid automaton around an ODE solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

import stickslip as ss

TOLERANCE = 1e-10
LONGEST_PHASE = 1e3
MAX_PHASES = 400

State = Sequence[float]
Modes = tuple[int, int]


def coulomb_force(s: float, mu: float) -> float:
    """Eq. (8), relative to the static limit."""
    return mu


def popp_stelter_force(s: float, gamma: float, delta: float, eta: float) -> float:
    """Eq. (9), relative to the static limit."""
    return (1.0 - delta) / (1.0 + gamma * s) + delta + eta * s * s


FORCES: dict[type, Callable[..., float]] = {
    ss.Coulomb: coulomb_force,
    ss.PoppStelter: popp_stelter_force,
}


@dataclass(frozen=True)
class Blocks:
    """Equations (5a) and (7a) with the numbers of one system."""

    alpha: float
    beta: float
    V: float
    force: Callable[..., float]
    law: tuple[float, ...]

    def limit(self, block: int) -> float:
        """Tell the static limit."""
        return self.beta if block else 1.0

    def need(self, y: State, block: int) -> float:
        """Friction force that the block needs in order to stay with the belt, eq. (6a)."""
        return y[block] + self.alpha * (y[block] - y[1 - block])

    def acceleration(self, y: State, block: int, mode: int) -> float:
        """X'' of eqs. (5a) and (7a)."""
        if mode == 0:
            return 0.0
        # A trial step may pass the zero of the speed: the law is not asked there.
        speed = max(0.0, mode * (y[2 + block] - self.V))
        friction = -mode * self.limit(block) * self.force(speed, *self.law)
        return friction - self.need(y, block)


def right_side(t: float, y: np.ndarray, blocks: Blocks, modes: Modes) -> list[float]:
    """Differentiate the state."""
    state = y.tolist()
    first, second = (blocks.acceleration(state, i, modes[i]) for i in (0, 1))
    return [state[2], state[3], first, second]


def landing(block: int, mode: int) -> Callable[..., float]:
    """Event function: the block reaches the belt's velocity."""

    def speed(t: float, y: np.ndarray, blocks: Blocks, modes: Modes) -> float:
        return y.item(2 + block) - blocks.V

    speed.terminal, speed.direction = True, -mode
    return speed


def release(block: int) -> Callable[..., float]:
    """Event function: what the riding block needs reaches its static limit, at either end."""

    def room(t: float, y: np.ndarray, blocks: Blocks, modes: Modes) -> float:
        return blocks.limit(block) - abs(blocks.need(y.tolist(), block))

    room.terminal, room.direction = True, -1
    return room


EVENTS = {
    (block, mode): landing(block, mode) if mode else release(block)
    for block in (0, 1)
    for mode in (-1, 0, 1)
}


class ScipyMap:
    """``d -> f(d)``, one ``solve_ivp`` for each phase; NaN if global stick does not come back."""

    def __init__(self, model: ss.TwoBlock, method: str = "DOP853") -> None:
        law = model.friction
        self.blocks = Blocks(
            model.alpha, model.beta, model.V, FORCES[type(law)], tuple(law.parameters.values())
        )
        self.method = method

    def __call__(self, d: np.ndarray) -> np.ndarray:
        """Values at each of ``d``."""
        return np.array([self.value(start) for start in d.tolist()])

    def onset(self, d: float) -> tuple[list[float], Modes]:
        """State and modes where the global stick phase ends."""
        blocks = self.blocks
        first, second = 1.0 + blocks.alpha * d, blocks.beta - (1.0 + blocks.alpha) * d
        x = min(first, second)
        return [x, x + d, blocks.V, blocks.V], (-(first <= second), -(second <= first))

    def value(self, d: float) -> float:
        """Value at one d."""
        state, modes = self.onset(d)
        for _ in range(MAX_PHASES):
            if modes == (0, 0):
                return state[1] - state[0]
            phase = solve_ivp(
                right_side,
                (0.0, LONGEST_PHASE),
                np.array(state),
                method=self.method,
                events=[EVENTS[0, modes[0]], EVENTS[1, modes[1]]],
                args=(self.blocks, modes),
                rtol=TOLERANCE,
                atol=TOLERANCE,
            )
            if phase.status != 1:
                return math.nan
            state = phase.y[:, -1].tolist()
            modes = self.after(state, modes, [len(times) > 0 for times in phase.t_events])
        return math.nan

    def after(self, state: list[float], modes: Modes, found: list[bool]) -> Modes:
        """Modes after an event; a block that lands gets the belt's velocity exactly."""
        changed = list(modes)
        for block in (0, 1):
            if not found[block]:
                continue
            state[2 + block] = self.blocks.V
            need = self.blocks.need(state, block)
            rides = modes[block] != 0 and abs(need) < self.blocks.limit(block)
            changed[block] = 0 if rides else (-1 if need > 0 else 1)
        return changed[0], changed[1]
