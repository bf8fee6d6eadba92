"""Pools of motions that step together: their kernels, and their arrays for each thread."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.records import Controls, Outputs, Pools
from stickslip.mechanics.flow.engine import Engine
from stickslip.mechanics.flow.lanes.kernels import lane_kernels
from stickslip.mechanics.flow.lanes.layout import ALIGNMENT, KEPT, ORDER, PLACES
from stickslip.mechanics.flow.system import new_motion
from stickslip.mechanics.friction.series import LawSeries
from stickslip.numerics.targets import instantiate
from stickslip.numerics.vector import LANES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]

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
