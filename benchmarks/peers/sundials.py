"""CVODE of SUNDIALS through scikit-sundae: Adams' method, which it suggests for nonstiff problems.

``eventsfn`` fills an array, with ``terminal`` and ``direction``; one solver for each pair of modes
is made once.
"""

from __future__ import annotations

import numpy as np
from benchmarks.peers.automaton import LONGEST_PHASE, TOLERANCE, Blocks, Modes, PhaseByPhase
from sksundae.cvode import CVODE

import stickslip as ss

MOST_STEPS = 100_000


class Map(PhaseByPhase):
    """Event map by CVODE."""

    def __init__(self, model: ss.TwoBlock) -> None:
        super().__init__(model)
        modes = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
        self.solvers = {pair: _solver(self.blocks, pair) for pair in modes}

    def phase(self, state: list[float], modes: Modes) -> tuple[list[float], list[bool]] | None:
        """Integrate to the first event."""
        phase = self.solvers[modes].solve([0.0, LONGEST_PHASE], np.array(state))
        if phase.i_events is None or not len(phase.i_events):
            return None
        return phase.y_events[-1].tolist(), [bool(flag) for flag in phase.i_events[-1]]


def _solver(blocks: Blocks, modes: Modes) -> CVODE:
    def right_side(t, y, yp):
        state = y.tolist()
        speeds = (max(0.0, modes[i] * (state[2 + i] - blocks.V)) for i in (0, 1))
        yp[0], yp[1] = state[2], state[3]
        for i, speed in enumerate(speeds):
            yp[2 + i] = blocks.acceleration(state, i, modes[i], speed)

    def events(t, y, found):
        state = y.tolist()
        for i in (0, 1):
            room = blocks.limit(i) - abs(blocks.need(state, i))
            found[i] = state[2 + i] - blocks.V if modes[i] else room

    events.terminal = [True, True]
    events.direction = [-mode if mode else -1 for mode in modes]
    return CVODE(
        right_side,
        method="Adams",
        rtol=TOLERANCE,
        atol=TOLERANCE,
        eventsfn=events,
        num_events=2,
        max_num_steps=MOST_STEPS,
    )
