"""Motions of n blocks, step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.flow.blocks.system import block_directions, new_block_motion
from stickslip.mechanics.flow.blocks.transitions import onset, settle, update_needed
from stickslip.mechanics.flow.engine import BlockEngine
from stickslip.mechanics.flow.recorder import Recorder, StatesInside, horner
from stickslip.mechanics.flow.system import LANDING
from stickslip.mechanics.model.structure import Structure
from stickslip.numerics.arrays import Floats, Ints
from stickslip.numerics.roots import EPSILON
from stickslip.results.parts import part


@part
@dataclass(frozen=True, eq=False)
class BlockSums:
    """Motion within recorded steps: polynomials of x and w, times of the steps' starts."""

    structure: Structure
    start: Floats
    x: Floats
    w: Floats

    def __call__(self, step: Ints, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Displacements, relative velocities and needed forces, as `StatesInside` says."""
        structure = self.structure
        x, w = horner(self.x, step, t), horner(self.w, step, t)
        time = (self.start[step] + t)[:, None]
        forcing = structure.amplitude * np.cos(structure.frequency * time + structure.phase)
        e = x @ structure.stiffness + (w + structure.V) @ structure.damping - forcing
        return x, w, e


class BlocksRecorder(Recorder):
    """A motion of any model of the family."""

    def __init__(
        self,
        engine: BlockEngine,
        structure: Structure,
        *,
        rtol: float,
        dense: bool,
        last: int | None = None,
    ) -> None:
        super().__init__(rtol=rtol, dense=dense, last=last)
        n = structure.n_blocks
        self.engine, self.structure = engine, structure
        self.motion = new_block_motion(n, 0)
        self.motion.phase[0] = structure.phase
        self.work = engine.new_work()
        laws = np.zeros((0, n, engine.code.N_PARAMETERS))
        self.directions = block_directions(engine.system, [], laws, np.zeros((0, n - 1)))
        self.polynomials: list[tuple[Floats, Floats]] = []

    @property
    def mode(self) -> Ints:
        """Present modes of the blocks."""
        return self.motion.mode

    def start_on_belt(self, d: Floats) -> None:
        """Start at the end of the global stick phase `d`: there the first slip begins."""
        self.d.append(np.array(d))
        onset(self.engine.system, self.directions, self.motion, d)
        self.n_events += 1

    def start(self, x: Floats, v: Floats) -> None:
        """Start from any state; a block at belt velocity rides if its force is in the limits."""
        motion, V = self.motion, self.engine.system.V
        motion.x[:] = x
        motion.w[:] = v - V
        motion.w[np.abs(motion.w) <= 2.0 * EPSILON * np.maximum(np.abs(v), V)] = 0.0
        motion.mode[:] = np.sign(motion.w)
        motion.event[:] = np.where(motion.w == 0.0, LANDING, 0)
        update_needed(self.engine.system, motion)
        settle(self.engine.system, motion, self.work.rates)
        self._note_global_stick()

    def _state(self) -> tuple[Floats, Floats, Floats]:
        return self.motion.x, self.motion.w, self.motion.e

    def _slides_for_ever(self) -> bool:
        engine = self.engine
        proved = engine.kernels.slides_for_ever(engine.system, engine.laws, self.motion, self.work)
        return bool(proved)

    def _advance(self, cap: float) -> tuple[float, int]:
        engine, motion = self.engine, self.motion
        t, status = engine.kernels.advance(
            engine.system, engine.laws, self.directions, motion, self.work, self.rtol, cap
        )
        if status != status_codes.OK:
            return 0.0, int(status)
        if self.dense:
            self.polynomials.append((self.work.x.copy(), self.work.w.copy()))
        if motion.event.any():
            self.n_events += bool(settle(engine.system, motion, self.work.rates))
            self._note_global_stick()
        return t, status_codes.OK

    def _note_global_stick(self) -> None:
        if not self.motion.mode.any():
            self.d.append(np.diff(self.motion.x))

    def _inside(self) -> StatesInside:
        x, w = (np.array(rows) for rows in zip(*self.polynomials, strict=True))
        return BlockSums(self.structure, np.array([step.t for step in self.record]), x, w)
