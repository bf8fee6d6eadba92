"""Two blocks on a belt that hardly moves: during a slip it stands still, V -> 0 exactly."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.carrier import NO_ITINERARY, PlainCarrier
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.flow.system import BETA, START
from stickslip.mechanics.flow.two_block_recorder import TwoBlockRecorder
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Controls, Outputs
    from stickslip.mechanics.flow.engine import EngineName
    from stickslip.mechanics.flow.recorder import Recorder
    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]


class QuasistaticCarrier(PlainCarrier):
    """Carries motions with the belt at rest: the kernels of the moving belt, V = 0 in them.

    A block leaves its limit L with the acceleration -L (1 - F(0)), which must not be zero.
    """

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        super().__init__(model, engine_for(model, engine), controls, threads)
        system = self.engine.system._replace(V=0.0)
        self.engine = dataclasses.replace(self.engine, system=system)

    def last_forces(self, d: Floats) -> tuple[Floats, Floats]:
        """Needed forces (n, 2) as the slip from each d begins, and as it has ended (or NaN)."""
        first, last = np.full((d.size, 2), np.nan), np.full((d.size, 2), np.nan)
        scratch, engine = self.scratch(()), self.engine
        alpha, beta, _ = engine.system
        for k, start in enumerate(d.tolist()):
            lead = min(1.0 + (1.0 + 2.0 * alpha) * start, beta)
            first[k] = lead - (1.0 + 2.0 * alpha) * start, lead
            value, *_, status = self.kernels.carry(
                engine.system, engine.laws, start, scratch, self.controls, NO_ITINERARY
            )
            if status != OK:
                continue
            # A motion of very many events ends in the twin that watches for a loop.
            ends = [motion.e for motion in (scratch.motion, scratch.long_motion)]
            last[k] = min(ends, key=lambda e: abs((e[1] - e[0]) / (1.0 + 2.0 * alpha) - value))
        return first, last

    def recorder(self, d: float) -> Recorder:
        """Motion on the resting belt as the slip from `d` begins, to be followed step by step."""
        recorder = TwoBlockRecorder(self.engine, rtol=self.controls.rtol, dense=True)
        recorder.start_on_belt(np.array([d]))
        return recorder

    def _carried(self, d: Floats, directions: Sequence[Floats], watch: bool = False) -> Outputs:
        outputs = super()._carried(d, directions, watch)
        tied = np.isclose(self._lead(d), 0.0, atol=1e-14, rtol=0.0)
        for column, direction in enumerate(directions):
            outputs.derivative[tied, column] = self._slopes_of_tie(
                d[tied], outputs.value[tied], direction
            )
        return outputs

    def _lead(self, d: Floats) -> Floats:
        """How far block 2 is past its limit as block 1 leaves; 0 where both leave together."""
        alpha, beta, _ = self.engine.system
        return 1.0 + (1.0 + 2.0 * alpha) * d - beta

    def _slopes_of_tie(self, d: Floats, value: Floats, direction: Floats) -> Floats:
        """One-sided slopes where both leave together: infinite, from the side of smaller d.

        There block 1 frees block 2 after a time that grows as the square root of the distance.
        """
        alpha = self.engine.system.alpha
        if alpha == 0.0 or direction[BETA] != 0.0 or direction[START] == 0.0:
            return np.full(d.size, np.nan)
        step = 1e-6 / (1.0 + 2.0 * alpha)
        beside = super()._carried(d - step, ()).value
        return np.copysign(np.inf, value - beside)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d; the speed of the belt is no parameter of the limit."""
        if name == "V":
            raise ValueError("'V' is no parameter of the quasi-static map: it is the limit V -> 0")
        return super().parameter_slope(d, name)
