"""CyRK's `pysolve_ivp` with events: its C++ solver around numba functions.

As in its documentation (Events.md): functions are compiled by ``numba.njit``, the derivative is
written into an argument, numbers go through ``args``; DOP853, terminal events with a direction.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from benchmarks.peers.automaton import LONGEST_PHASE, TOLERANCE, Modes, PhaseByPhase
from CyRK import pysolve_ivp

import stickslip as ss

njit = numba.njit  # noqa: TID251  what CyRK asks for


class Map(PhaseByPhase):
    """Event map by DOP853."""

    def __init__(self, model: ss.TwoBlock) -> None:
        super().__init__(model)
        self.right_side = _right_side(njit(self.blocks.force), self.blocks.law)
        self.events = {
            (i, mode): _landing(i, mode) if mode else _release(i)
            for i in (0, 1)
            for mode in (-1, 0, 1)
        }

    def phase(self, state: list[float], modes: Modes) -> tuple[list[float], list[bool]] | None:
        """Integrate to the first event."""
        blocks = self.blocks
        phase = pysolve_ivp(
            self.right_side,
            (0.0, LONGEST_PHASE),
            np.array(state),
            method="DOP853",
            events=(self.events[0, modes[0]], self.events[1, modes[1]]),
            args=(blocks.alpha, blocks.beta, blocks.V, float(modes[0]), float(modes[1])),
            rtol=TOLERANCE,
            atol=TOLERANCE,
            pass_dy_as_arg=True,
        )
        if not phase.event_terminated:
            return None
        return phase.y[:, -1].tolist(), [len(times) > 0 for times in phase.t_events]


def _right_side(force: Any, law: tuple[float, ...]) -> Any:
    @njit
    def right_side(dy, t, y, alpha, beta, V, mode_1, mode_2):
        dy[0], dy[1] = y[2], y[3]
        dy[2] = dy[3] = 0.0
        if mode_1 != 0.0:
            speed = max(0.0, mode_1 * (y[2] - V))
            dy[2] = -mode_1 * force(speed, *law) - y[0] - alpha * (y[0] - y[1])
        if mode_2 != 0.0:
            speed = max(0.0, mode_2 * (y[3] - V))
            dy[3] = -mode_2 * beta * force(speed, *law) - y[1] - alpha * (y[1] - y[0])

    return right_side


def _landing(block: int, mode: int) -> Any:
    @njit
    def speed(t, y, alpha, beta, V, mode_1, mode_2):
        return y[2 + block] - V

    speed.terminal, speed.direction = True, -mode
    return speed


def _release(block: int) -> Any:
    @njit
    def room(t, y, alpha, beta, V, mode_1, mode_2):
        limit = beta if block else 1.0
        return limit - abs(y[block] + alpha * (y[block] - y[1 - block]))

    room.terminal, room.direction = True, -1
    return room
