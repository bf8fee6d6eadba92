"""Many motions with constant kinetic friction at once, and one at small cost."""

from __future__ import annotations

import math
import threading
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.mechanics.eventmap.backend import NO_ITINERARY, ScalarBackend
from stickslip.mechanics.eventmap.records import new_outputs
from stickslip.mechanics.flow._lane_kernels import constants_at
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.numerics.targets import config, instantiate, launch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Controls, Outputs
    from stickslip.mechanics.flow.engine import Engine
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


SMALLEST_TILE = 8192


class LaneBackend(ScalarBackend):
    """Constant kinetic friction: values and slopes by lanes, all else by the exact engine.

    Which of them answers depends on d alone: not on how many are asked together, nor on threads.
    """

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

        launch(task, d.size, self.threads, SMALLEST_TILE)
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
        return instantiate(template, self.engine.key, carry=self.kernels.carry)
