"""scipy's `solve_ivp` with events, as its documentation recommends.

One event function for each thing that may happen, with ``terminal`` and ``direction``; a new call
for each phase; DOP853, recommended for tight tolerances. Parameters go through ``args``. Right-hand
side and events are plain Python on floats, faster here than arrays of two. No push off the surface
and no ``max_step``: neither is asked for there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from benchmarks.peers.automaton import LONGEST_PHASE, TOLERANCE, Blocks, Modes, PhaseByPhase
from scipy.integrate import solve_ivp


def right_side(t: float, y: np.ndarray, blocks: Blocks, modes: Modes) -> list[float]:
    """Differentiate the state; a trial step may pass the zero of a speed."""
    state = y.tolist()
    speeds = (max(0.0, modes[i] * (state[2 + i] - blocks.V)) for i in (0, 1))
    first, second = (blocks.acceleration(state, i, modes[i], s) for i, s in enumerate(speeds))
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


class Map(PhaseByPhase):
    """Event map by DOP853."""

    def phase(self, state: list[float], modes: Modes) -> tuple[list[float], list[bool]] | None:
        """Integrate to the first event."""
        phase = solve_ivp(
            right_side,
            (0.0, LONGEST_PHASE),
            np.array(state),
            method="DOP853",
            events=[EVENTS[0, modes[0]], EVENTS[1, modes[1]]],
            args=(self.blocks, modes),
            rtol=TOLERANCE,
            atol=TOLERANCE,
        )
        if phase.status != 1:
            return None
        return phase.y[:, -1].tolist(), [len(times) > 0 for times in phase.t_events]
