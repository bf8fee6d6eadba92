"""heyoka.py: Taylor's method compiled for the equations, with terminal events.

One integrator for each pair of modes is compiled once, at heyoka's default tolerance (rounding),
and restarted for each phase. A slip starts on a root of its own event, with F(0) = 1 a double one;
heyoka's cooldown covers the event that fired, not that of another integrator. Without help half of
the answers for law (9) are wrong, so a slip from rest starts with a step of an integrator without
events. It must be short: with 1e-9 events are lost next to breakpoints.
"""

from __future__ import annotations

from typing import Any

import heyoka as hy
from benchmarks.peers.automaton import LONGEST_PHASE, Blocks, Modes, PhaseByPhase

import stickslip as ss

PUSH = 1e-12


class Map(PhaseByPhase):
    """Event map by Taylor's method."""

    def __init__(self, model: ss.TwoBlock) -> None:
        super().__init__(model)
        modes = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
        self.integrators = {pair: _integrators(self.blocks, pair) for pair in modes}

    def phase(self, state: list[float], modes: Modes) -> tuple[list[float], list[bool]] | None:
        """Integrate to the first event."""
        push, integrator = self.integrators[modes]
        integrator.time, integrator.state[:] = 0.0, state
        if any(mode != 0 and state[2 + i] == self.blocks.V for i, mode in enumerate(modes)):
            push.time, push.state[:] = 0.0, state
            push.propagate_until(PUSH)
            integrator.time, integrator.state[:] = PUSH, push.state
        integrator.reset_cooldowns()
        outcome = int(integrator.propagate_until(LONGEST_PHASE)[0])
        if outcome not in (-1, -2):  # a terminal event k stops with -k - 1
            return None
        return integrator.state.tolist(), [outcome == -1, outcome == -2]


def _integrators(blocks: Blocks, modes: Modes) -> tuple[Any, Any]:
    """Without and with events."""
    y = hy.make_vars("x_1", "x_2", "v_1", "v_2")
    equations = [(y[0], y[2]), (y[1], y[3])]
    events = []
    for i in (0, 1):
        speed = modes[i] * (y[2 + i] - blocks.V)
        equations.append(
            (y[2 + i], hy.expression(0.0) + blocks.acceleration(y, i, modes[i], speed))
        )
        need = blocks.need(y, i)
        room = speed if modes[i] else blocks.limit(i) ** 2 - need * need
        events.append(hy.t_event(room, direction=hy.event_direction.negative))
    start = [0.0, 0.0, blocks.V, blocks.V]
    return (
        hy.taylor_adaptive(equations, start),
        hy.taylor_adaptive(equations, start, t_events=events),
    )
