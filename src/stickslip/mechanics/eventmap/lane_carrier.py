"""Carries motions under constant kinetic friction: in lanes, and the exact engine for the rest."""

from __future__ import annotations

import math
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.carrier import NO_ITINERARY, PlainCarrier
from stickslip.mechanics.eventmap.lanes import NO_SLOPE, Lanes
from stickslip.numerics.targets import instantiate, launch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Controls, Outputs
    from stickslip.mechanics.flow.engine import Engine
    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]

SMALLEST_TILE = 8192


class LaneCarrier:
    """Constant kinetic friction: values and slopes by lanes, all else by the exact engine.

    Which of them answers depends on d alone: not on how many are asked together, nor on threads.
    """

    def __init__(self, model: TwoBlock, engine: Engine, controls: Controls, threads: int) -> None:
        self.exact = PlainCarrier(model, engine, controls, threads)
        self.lanes = Lanes(engine, controls)
        self.name = self.exact.name

    def value(self, d: float) -> float:
        """Value at one d."""
        value = self.lanes.value(d)
        if value == value:
            return value if value < math.inf else math.nan
        return self.exact.value(d)

    def values(self, d: Floats) -> Floats:
        """Value at each d."""
        values, passed = self._by_lanes(d, NO_SLOPE)
        if passed.size > 0:
            values[passed] = self.exact.values(d[passed])
        return values

    def slopes(self, d: Floats) -> Floats:
        """Slope at each d."""
        return self.values_and_slopes(d)[1]

    def values_and_slopes(self, d: Floats) -> tuple[Floats, Floats]:
        """Value and slope at each d."""
        slopes = np.empty(d.size)
        values, passed = self._by_lanes(d, slopes)
        if passed.size > 0:
            values[passed], slopes[passed] = self.exact.values_and_slopes(d[passed])
        return values, slopes

    def evidence(self, d: Floats) -> Outputs:
        """Everything of each d, the slope in column 0 of its derivatives."""
        outputs = self.exact.evidence(d)
        slopes = np.empty(d.size)
        values, _ = self._by_lanes(d, slopes)
        served = ~np.isnan(values)
        outputs.value[served] = values[served]
        outputs.derivative[served, 0] = slopes[served]
        return outputs

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        return self.exact.parameter_slope(d, name)

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        return self.exact.itinerary(d)

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

        launch(task, d.size, self.exact.threads, SMALLEST_TILE)
        return values, np.concatenate(passed)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

        def task(start: int, stop: int) -> None:
            lanes, engine = self.lanes, self.exact.engine
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
                self.exact.scratch(()),
                self.exact.controls,
                NO_ITINERARY,
            )

        self.exact.launch_orbits(task, orbits)

    @cached_property
    def _orbits(self) -> ModuleType:
        template = "stickslip.mechanics.eventmap._lane_orbits_kernels"
        return instantiate(template, self.exact.engine.key, carry=self.exact.kernels.carry)
