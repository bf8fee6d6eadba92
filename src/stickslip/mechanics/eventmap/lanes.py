"""Values of many motions with constant kinetic friction at once, and of one at small cost."""

from __future__ import annotations

import math
import threading
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.mechanics.flow._lane_kernels import plant_at
from stickslip.mechanics.friction.columns import STATIC_COLUMN
from stickslip.numerics.targets import config

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Controls
    from stickslip.mechanics.flow.engine import Engine

    Floats = NDArray[np.float64]

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
    from stickslip.mechanics.eventmap._lane_kernels import N_LISTS
    from stickslip.mechanics.eventmap._lane_passes_kernels import BLOCK, N_STREAMS, PLANT, STRIDE

    streams = np.zeros((N_STREAMS + len(PLANT)) * STRIDE)
    return LaneScratch(streams, np.zeros(N_LISTS * STRIDE, dtype=np.uint64), np.zeros(BLOCK))


def lanes_serve(engine: Engine, controls: Controls) -> bool:
    """Whether values may come from lanes: they keep no time, and need vector instructions."""
    return engine.name == "exact" and controls.max_time == math.inf and not config.DISABLE_JIT


class Lanes:
    """What `_lane_kernels` need to know of a model, and scratch for each thread."""

    def __init__(self, engine: Engine, controls: Controls) -> None:
        from stickslip.mechanics.eventmap import _lane_kernels

        mu_1, mu_2 = engine.laws[:, STATIC_COLUMN].tolist()
        self.row = np.array(plant_at(*engine.system, mu_1, mu_2))
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
