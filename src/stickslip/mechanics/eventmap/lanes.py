"""Many motions at once: in lanes under constant kinetic friction, in pools under other laws."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from functools import cached_property, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.mechanics.eventmap.backend import NO_ITINERARY, ScalarBackend
from stickslip.mechanics.eventmap.records import Controls, Outputs, Pools, new_outputs
from stickslip.mechanics.flow._lane_kernels import constants_at
from stickslip.mechanics.flow.engine import Engine, start_direction
from stickslip.mechanics.flow.lanes.layout import ALIGNMENT, HANDED_OVER, KEPT, ORDER, PLACES
from stickslip.mechanics.flow.lanes.text import lane_kernels
from stickslip.mechanics.flow.system import new_motion
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.mechanics.friction.series import LawSeries
from stickslip.numerics.targets import config, instantiate, launch
from stickslip.numerics.vector import LANES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats


NO_SLOPE = np.empty(0)
# Scratch of each thread, most of a megabyte: whatever the model, one kernel uses it at a time.
_LOCAL = threading.local()


class LaneScratch(NamedTuple):
    """Arrays of one thread: streams and lists of the kernels, starts of a block."""

    streams: Floats
    lists: NDArray[np.uint64]
    column: Floats


def new_lane_scratch() -> LaneScratch:
    """Arrays for one thread."""
    from stickslip.mechanics.eventmap._lane_kernels import (
        BLOCK,
        CONSTANTS,
        N_LISTS,
        N_STREAMS,
        STRIDE,
    )

    streams = np.zeros((N_STREAMS + len(CONSTANTS)) * STRIDE)
    return LaneScratch(streams, np.zeros(N_LISTS * STRIDE, dtype=np.uint64), np.zeros(BLOCK))


def lanes_serve(engine: Engine, controls: Controls) -> bool:
    """Whether values may come from lanes: they keep no time, and need vector instructions."""
    return engine.name == "exact" and controls.max_time == math.inf and not config.DISABLE_JIT


class Lanes:
    """What `_lane_kernels` need to know of a model, and scratch for each thread."""

    def __init__(self, engine: Engine, controls: Controls) -> None:
        from stickslip.mechanics.eventmap import _lane_kernels

        mu_1, mu_2 = engine.laws[:, STATIC_COLUMN].tolist()
        self.row = np.array(constants_at(*engine.system, mu_1, mu_2))
        self.max_events = controls.max_events
        self._carry = _lane_kernels.carry_lanes

    def scratch(self) -> LaneScratch:
        """Arrays of the present thread."""
        held: LaneScratch | None = getattr(_LOCAL, "scratch", None)
        if held is None:
            held = _LOCAL.scratch = new_lane_scratch()
        return held

    def carry(self, points: Floats, slope: Floats, start: int, stop: int) -> None:
        """Put values in the place of starts: NaN to ask the exact engine, inf if none returns."""
        streams, index, _ = self.scratch()
        self._carry(self.row, streams, index, points, slope, start, stop, self.max_events)

    def value(self, d: float) -> float:
        """Value at one start inside the domain, or NaN, inf as above."""
        streams, index, column = self.scratch()
        column[0] = d
        self._carry(self.row, streams, index, column, NO_SLOPE, 0, 1, self.max_events)
        return column.item(0)


LANE_TILE = 8192


class LaneBackend(ScalarBackend):
    """Constant kinetic friction: values and slopes by lanes, all else by the exact engine."""

    # Which of them answers depends on d alone: not on how many are asked together, nor on threads.

    def __init__(self, model: TwoBlock, engine: Engine, controls: Controls, threads: int) -> None:
        super().__init__(model, engine, controls, threads)
        self.lanes = Lanes(engine, controls)

    def value(self, d: float) -> float:
        """Value at one d."""
        value = self.lanes.value(d)
        if value == value:
            return value if value < math.inf else math.nan
        return float(self._carried(np.array([d]), ()).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes; lanes keep nothing else."""
        slopes = np.empty(d.size) if slope else NO_SLOPE
        values, passed = self._by_lanes(d, slopes)
        if watch:
            outputs = super().carry(d, slope=slope, watch=True)
            served = ~np.isnan(values)
            outputs.value[served] = values[served]
            if slope:
                outputs.derivative[served, 0] = slopes[served]
            return outputs
        if passed.size > 0:
            exact = super().carry(d[passed], slope=slope)
            values[passed] = exact.value
            if slope:
                slopes[passed] = exact.derivative[:, 0]
        return new_outputs((0,), 0)._replace(value=values, derivative=slopes[:, None])

    def _by_lanes(self, d: Floats, slopes: Floats) -> tuple[Floats, NDArray[np.intp]]:
        """Values and, if there is room, slopes; indices that the lanes passed on."""
        values = np.empty(d.size)
        passed: list[NDArray[np.intp]] = []

        def task(start: int, stop: int) -> None:
            part = values[start:stop]
            part[:] = d[start:stop]
            self.lanes.carry(values, slopes, start, stop)
            rest = np.flatnonzero(~np.isfinite(part))
            unknown = np.isnan(part[rest])
            part[rest] = math.nan
            passed.append(start + rest[unknown])

        launch(task, d.size, self.threads, LANE_TILE)
        return values, np.concatenate(passed)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

        def task(start: int, stop: int) -> None:
            lanes, engine = self.lanes, self.engine
            streams, index, column = lanes.scratch()
            self._orbits.iterate_lanes(
                lanes.row,
                streams,
                index,
                column,
                NO_SLOPE,
                orbits,
                start,
                stop,
                engine.system,
                engine.laws,
                self.scratch(()),
                self.controls,
                NO_ITINERARY,
            )

        self.launch_orbits(task, orbits)

    @cached_property
    def _orbits(self) -> ModuleType:
        template = "stickslip.mechanics.eventmap._lane_follow_kernels"
        bindings = {name: getattr(self.kernels, name) for name in ("carry", "value_tangent")}
        return instantiate(template, self.engine.key, cached=self.engine.cached, **bindings)


STEPS = ("step_one", "step_both", "tangent_one", "tangent_both")
DECISIONS = ("blocks_of_event", "event_margin", "mode_code", "value_tangent")


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


POOL_TILE = 512


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
            self._driver.advance_orbits(
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

        steps = max(1, orbits.shape[1] - 1)
        while True:
            launch(task, len(orbits), self.threads, max(1, POOL_TILE // steps))
            rows = np.flatnonzero(outputs.status == HANDED_OVER)
            if rows.size == 0:
                return outputs
            carried = self._carried(orbits[rows, filled[rows]], directions, watch)
            for kept, found in zip(outputs, carried, strict=True):
                kept[rows] = found
            filled[rows] += 1
            orbits[rows, filled[rows]] = carried.value

    @cached_property
    def _steps(self) -> ModuleType:
        return lane_kernels(self.series)

    @cached_property
    def _driver(self) -> ModuleType:
        """Kernels bound to the law's steps and to the decisions of the scalar engine."""
        return instantiate(
            "stickslip.mechanics.eventmap._pool_kernels",
            f"{self.engine.key}-{self.series.key}",
            force=self.engine.code.force,
            rate=self.engine.kernels.rate,
            **{name: getattr(self._steps, name) for name in STEPS},
            **{name: getattr(self.kernels, name) for name in DECISIONS},
        )

    @cached_property
    def _pools_here(self) -> threading.local:
        return _pools_of(self.series.key, self.model.laws)

    def _pools(self, directions: Sequence[Floats]) -> Pools:
        """Pools for this thread."""
        held: dict[int, Pools] = self._pools_here.__dict__.setdefault("pools", {})
        n_columns = len(directions)
        if n_columns not in held:
            laws = self.series.rows(self.model.laws)
            pools = new_pools(n_columns, self.engine.n_law_parameters, laws, self._steps.SIZE)
            for column, direction in enumerate(directions):
                pools.motion.directions[column] = direction
            held[n_columns] = pools
        return held[n_columns]


@lru_cache(maxsize=16)
def _pools_of(series: str, laws: tuple[FrictionLaw, FrictionLaw]) -> threading.local:
    """Pools of each thread, a quarter of a megabyte: models of the same laws use the same."""
    return threading.local()
