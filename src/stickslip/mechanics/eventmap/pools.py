"""Motions under nonlinear friction that step together in pools; a scalar engine has the rest."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.backend import ScalarBackend
from stickslip.mechanics.eventmap.records import Controls, Outputs, Pools, new_outputs
from stickslip.mechanics.flow.engine import Engine, start_direction
from stickslip.mechanics.flow.lanes.layout import ALIGNMENT, HANDED_OVER, KEPT, ORDER, PLACES
from stickslip.mechanics.flow.lanes.text import lane_kernels
from stickslip.mechanics.flow.system import new_motion
from stickslip.mechanics.friction.series import LawSeries
from stickslip.numerics.targets import instantiate, launch
from stickslip.numerics.vector import LANES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats


STEPS = ("step_one", "step_both", "tangent_one", "tangent_both")
DECISIONS = ("blocks_of_event", "event_margin", "mode_code", "value_tangent")


@dataclass(frozen=True, eq=False)
class MovingPools:
    """Carries motions of one model in pools."""

    engine: Engine  # the scalar engine, whose decisions at events are taken
    scalar: ModuleType  # its kernels of the event map
    series: LawSeries
    model: TwoBlock
    controls: Controls
    _local: threading.local = field(default_factory=threading.local)

    def advance(
        self,
        orbits: Floats,
        filled: NDArray[np.int64],
        start: int,
        stop: int,
        directions: Sequence[Floats],
        watch: bool,
        outputs: Outputs,
    ) -> None:
        """Fill rows of `orbits` as far as the pools can: kernel `advance_orbits`."""
        self._kernels.advance_orbits(
            self.engine.system,
            self.engine.laws,
            orbits,
            filled,
            start,
            stop,
            self._pools(directions),
            self.controls,
            watch,
            outputs,
        )

    @cached_property
    def _steps(self) -> ModuleType:
        return lane_kernels(self.series)

    @cached_property
    def _kernels(self) -> ModuleType:
        """The driver, bound to the law's steps and to the decisions of the scalar engine."""
        return instantiate(
            "stickslip.mechanics.eventmap._pool_kernels",
            f"{self.engine.key}-{self.series.key}",
            force=self.engine.code.force,
            rate=self.engine.kernels.rate,
            **{name: getattr(self._steps, name) for name in STEPS},
            **{name: getattr(self.scalar, name) for name in DECISIONS},
        )

    def _pools(self, directions: Sequence[Floats]) -> Pools:
        """Pools for this thread."""
        held: dict[int, Pools] = self._local.__dict__.setdefault("pools", {})
        n_columns = len(directions)
        if n_columns not in held:
            laws = self.series.rows(self.model.laws)
            pools = new_pools(n_columns, self.engine.n_law_parameters, laws, self._steps.SIZE)
            for column, direction in enumerate(directions):
                pools.motion.directions[column] = direction
            held[n_columns] = pools
        return held[n_columns]


def new_pools(n_columns: int, n_law_parameters: int, laws: Floats, size: int) -> Pools:
    """Arrays of empty pools."""
    return Pools(
        laws=laws,
        x=aligned(3 * KEPT).reshape(3, KEPT),
        taken=aligned(size),
        tags=np.zeros((3, PLACES, 4), dtype=np.int64),
        labels=np.zeros((3, PLACES), dtype=np.uint64),
        counts=np.zeros(3, dtype=np.int64),
        flagged=np.zeros(LANES + 1, dtype=np.int64),
        rows=np.zeros(LANES, dtype=np.int64),
        motion=new_motion(n_columns, n_law_parameters),
        w=np.zeros((2, ORDER + 1)),
        e=np.zeros((2, ORDER + 1)),
        signal=np.zeros(ORDER + 1),
        reciprocals=1.0 / np.maximum(np.arange(ORDER + 2), 1),
    )


def aligned(size: int) -> Floats:
    """Zeros that begin where a vector of any machine may."""
    store = np.zeros(size + ALIGNMENT // 8)
    start = -store.ctypes.data % ALIGNMENT // 8
    return store[start : start + size]


SMALLEST_TILE = 512


class PoolBackend(ScalarBackend):
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

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
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
            for kept, found in zip(outputs, carried, strict=True):
                kept[rows] = found
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
