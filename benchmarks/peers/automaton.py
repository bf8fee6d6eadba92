"""The event map as a hybrid automaton around any solver of differential equations.

The state is (x_1, x_2, v_1, v_2); the modes -1, 0, +1 (backward, stick, forward) are held outside,
since the equations change with them: a solver takes one phase, from the state at which the last
one ended to the first event of either block.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import stickslip as ss

TOLERANCE = 1e-10
LONGEST_PHASE = 1e3
MAX_PHASES = 400

State = Sequence[float]
Modes = tuple[int, int]


def coulomb_force(s: Any, mu: float) -> Any:
    """Eq. (8), relative to the static limit."""
    return mu


def popp_stelter_force(s: Any, gamma: float, delta: float, eta: float) -> Any:
    """Eq. (9), relative to the static limit."""
    return (1.0 - delta) / (1.0 + gamma * s) + delta + eta * s * s


FORCES: dict[type, Callable[..., Any]] = {
    ss.Coulomb: coulomb_force,
    ss.PoppStelter: popp_stelter_force,
}


@dataclass(frozen=True)
class Blocks:
    """Equations (5a) and (7a) with the numbers of one system."""

    alpha: float
    beta: float
    V: float
    force: Callable[..., Any]
    law: tuple[float, ...]

    @classmethod
    def of(cls, model: ss.TwoBlock) -> Blocks:
        """Take the numbers of a model."""
        law = model.friction
        numbers = tuple(law.parameters.values())
        return cls(model.alpha, model.beta, model.V, FORCES[type(law)], numbers)

    def limit(self, block: int) -> float:
        """Tell the static limit."""
        return self.beta if block else 1.0

    def need(self, y: State, block: int) -> Any:
        """Friction force that the block needs in order to stay with the belt, eq. (6a)."""
        return y[block] + self.alpha * (y[block] - y[1 - block])

    def acceleration(self, y: State, block: int, mode: int, speed: Any) -> Any:
        """X'' of eqs. (5a) and (7a); `speed`: of slip, >= 0."""
        if mode == 0:
            return 0.0
        friction = -mode * self.limit(block) * self.force(speed, *self.law)
        return friction - self.need(y, block)

    def onset(self, d: float) -> tuple[list[float], Modes]:
        """State and modes where the global stick phase ends."""
        first, second = 1.0 + self.alpha * d, self.beta - (1.0 + self.alpha) * d
        x = min(first, second)
        return [x, x + d, self.V, self.V], (-(first <= second), -(second <= first))

    def after(self, state: list[float], modes: Modes, found: Sequence[bool]) -> Modes:
        """Modes after an event; a block that lands gets the belt's velocity exactly."""
        changed = list(modes)
        for block in (0, 1):
            if not found[block]:
                continue
            state[2 + block] = self.V
            need = self.need(state, block)
            rides = modes[block] != 0 and abs(need) < self.limit(block)
            changed[block] = 0 if rides else (-1 if need > 0 else 1)
        return changed[0], changed[1]


class PhaseByPhase(ABC):
    """``d -> f(d)``, one call of a solver for each phase; NaN if global stick does not return."""

    def __init__(self, model: ss.TwoBlock) -> None:
        self.blocks = Blocks.of(model)

    def __call__(self, d: np.ndarray) -> np.ndarray:
        """Values at each of ``d``."""
        return np.array([self.value(start) for start in d.tolist()])

    def value(self, d: float) -> float:
        """Value at one d."""
        state, modes = self.blocks.onset(d)
        for _ in range(MAX_PHASES):
            if modes == (0, 0):
                return state[1] - state[0]
            phase = self.phase(state, modes)
            if phase is None:
                return math.nan
            state, found = phase
            modes = self.blocks.after(state, modes, found)
        return math.nan

    @abstractmethod
    def phase(self, state: list[float], modes: Modes) -> tuple[list[float], list[bool]] | None:
        """State at the first event and which blocks have one; None if there is none."""
