"""Carries motions under nonlinear friction: in pools, and the scalar engine for the rest."""

from __future__ import annotations

import threading
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.carrier import PlainCarrier
from stickslip.mechanics.eventmap.pools import MovingPools
from stickslip.mechanics.eventmap.records import new_outputs
from stickslip.mechanics.flow.engine import start_direction
from stickslip.mechanics.flow.lanes.layout import HANDED_OVER
from stickslip.numerics.targets import launch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Controls, Outputs
    from stickslip.mechanics.flow.engine import Engine
    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.friction.series import LawSeries
    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]

SMALLEST_TILE = 512


class PoolCarrier(PlainCarrier):
    """Two undamped blocks with one formula for both: many motions at once, in pools.

    The scalar engine carries what pools hand over. Which of them does depends on the motion alone.
    """

    def __init__(
        self,
        model: TwoBlock,
        engine: Engine,
        controls: Controls,
        threads: int,
        series: LawSeries,
    ) -> None:
        super().__init__(model, engine, controls, threads)
        self.series = series

    def values(self, d: Floats) -> Floats:
        """Value at each d."""
        return self._evaluated(d).value

    def slopes(self, d: Floats) -> Floats:
        """Slope at each d."""
        return self._evaluated(d, slope=True).derivative[:, 0]

    def evidence(self, d: Floats) -> Outputs:
        """Everything of each d, the slope in column 0 of its derivatives."""
        return self._evaluated(d, slope=True, watch=True)

    def _evaluated(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        orbits = np.full((d.size, 2), np.nan)
        orbits[:, 0] = d
        outputs = self._advanced(orbits, slope=slope, watch=watch)
        return outputs._replace(value=orbits[:, 1])

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""
        self._advanced(orbits)

    def _advanced(self, orbits: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Fill the rows of `orbits`; return what is known of their last motions."""
        directions = (start_direction(self.engine),) if slope else ()
        outputs = new_outputs((len(orbits),), len(directions))
        filled = np.zeros(len(orbits), dtype=np.int64)

        def task(start: int, stop: int) -> None:
            self._moved.advance(orbits, filled, start, stop, directions, watch, outputs)

        steps = max(1, orbits.shape[1] - 1)
        while True:
            launch(task, len(orbits), self.threads, max(1, SMALLEST_TILE // steps))
            rows = np.flatnonzero(outputs.status == HANDED_OVER)
            if rows.size == 0:
                return outputs
            carried = self._carried(orbits[rows, filled[rows]], directions, watch)
            for field, found in zip(outputs, carried, strict=True):
                field[rows] = found
            filled[rows] += 1
            orbits[rows, filled[rows]] = carried.value

    @cached_property
    def _moved(self) -> MovingPools:
        pools = _pools_of(self.series.key, self.model.laws)
        return MovingPools(self.engine, self.kernels, self.series, self.model, self.controls, pools)


@lru_cache(maxsize=16)
def _pools_of(series: str, laws: tuple[FrictionLaw, FrictionLaw]) -> threading.local:
    """Pools of each thread, a quarter of a megabyte: models of the same laws use the same."""
    return threading.local()
