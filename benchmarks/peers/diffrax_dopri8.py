"""diffrax: all motions in one ``jax.vmap``, phases in a ``while_loop``, continuous events.

Dopri8 with a `PIDController` at the common tolerances; `diffrax.Event` with a tuple of conditions,
their directions and optimistix's Newton iteration for the time; compiled once by ``jax.jit``.
"""

from __future__ import annotations

from functools import partial

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from benchmarks.peers.automaton import LONGEST_PHASE, MAX_PHASES, TOLERANCE, Blocks

import stickslip as ss

jax.config.update("jax_enable_x64", True)

MOST_STEPS = 4096


class Map:
    """Event map by Dopri8."""

    def __init__(self, model: ss.TwoBlock) -> None:
        self.blocks = Blocks.of(model)
        self._compiled = jax.jit(jax.vmap(self._value))

    def __call__(self, d: np.ndarray) -> np.ndarray:
        """Values at each of ``d``."""
        return np.asarray(self._compiled(jnp.asarray(d)))

    def _value(self, d):
        blocks = self.blocks
        first, second = 1.0 + blocks.alpha * d, blocks.beta - (1.0 + blocks.alpha) * d
        x = jnp.minimum(first, second)
        state = jnp.array([x, x + d, blocks.V, blocks.V])
        modes = jnp.array([-(first <= second).astype(float), -(second <= first).astype(float)])

        def slips(carry):
            _, modes, phases, found = carry
            return (modes != 0).any() & (phases < MAX_PHASES) & found

        def phase(carry):
            state, modes, phases, _ = carry
            state, modes, found = self._phase(state, modes)
            return state, modes, phases + 1, found

        state, modes, _, _ = jax.lax.while_loop(slips, phase, (state, modes, 0, True))
        return jnp.where((modes == 0).all(), state[1] - state[0], jnp.nan)

    def _phase(self, state, modes):
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(self._right_side),
            diffrax.Dopri8(),
            0.0,
            LONGEST_PHASE,
            None,
            state,
            args=modes,
            stepsize_controller=diffrax.PIDController(rtol=TOLERANCE, atol=TOLERANCE),
            event=diffrax.Event(
                (partial(self._room, 0), partial(self._room, 1)),
                optimistix.Newton(rtol=TOLERANCE, atol=TOLERANCE),
                direction=(False, False),
            ),
            max_steps=MOST_STEPS,
            throw=False,
        )
        state, found = solution.ys[-1], jnp.array(solution.event_mask)
        state = state.at[2:].set(jnp.where(found, self.blocks.V, state[2:]))
        limits = jnp.array([self.blocks.limit(0), self.blocks.limit(1)])
        needs = jnp.array([self.blocks.need(state, 0), self.blocks.need(state, 1)])
        rides = (modes != 0) & (jnp.abs(needs) < limits)
        changed = jnp.where(rides, 0.0, jnp.where(needs > 0, -1.0, 1.0))
        return state, jnp.where(found, changed, modes), found.any()

    def _right_side(self, t, y, modes):
        speeds = jnp.maximum(0.0, modes * (y[2:] - self.blocks.V))
        rates = [
            jnp.where(
                modes[i] != 0,
                -modes[i] * self.blocks.limit(i) * self.blocks.force(speeds[i], *self.blocks.law)
                - self.blocks.need(y, i),
                0.0,
            )
            for i in (0, 1)
        ]
        return jnp.array([y[2], y[3], *rates])

    def _room(self, block, t, y, args, **_):
        """Distance to the block's next event, >= 0."""
        modes = args
        room = self.blocks.limit(block) - jnp.abs(self.blocks.need(y, block))
        return jnp.where(modes[block] != 0, modes[block] * (y[2 + block] - self.blocks.V), room)
