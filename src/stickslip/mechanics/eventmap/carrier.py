"""What carries motions from one global stick phase to the next: kernels, threads, scratch.

The event map of two blocks asks a carrier and does not know which engine it has.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Protocol

import numpy as np

from stickslip.mechanics.eventmap.blocks_map import BlocksEventMap
from stickslip.mechanics.eventmap.itinerary import itinerary_text
from stickslip.mechanics.eventmap.lanes import NO_SLOPE, Lanes, lanes_serve
from stickslip.mechanics.eventmap.records import Controls, Outputs, Scratch
from stickslip.mechanics.flow.engine import (
    Engine,
    EngineName,
    bind_engine,
    engine_for,
    parameter_direction,
    start_direction,
)
from stickslip.mechanics.flow.system import new_motion
from stickslip.numerics.targets import instantiate, launch
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]

__all__ = ["Carrier", "carrier_for"]

# Fewer motions than this are not worth a thread.
SMALLEST_TILE = {"lanes": 16_384, "exact": 4000, "taylor": 64, "collocation": 16}
DEVICES = ("cpu", "cuda")
NO_ITINERARY = np.zeros(0, dtype=np.int8)


class Carrier(Protocol):
    """Carries motions of two blocks from start to value; points are arrays of shape (n,)."""

    name: str

    def value(self, d: float) -> float:
        """Value at one d."""

    def values(self, d: Floats) -> Floats:
        """Value at each d."""

    def slopes(self, d: Floats) -> Floats:
        """Slope at each d."""

    def evidence(self, d: Floats) -> Outputs:
        """Everything of each d, the slope in column 0 of its derivatives."""

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""


def carrier_for(
    model: TwoBlock, engine: EngineName, controls: Controls, device: str, threads: int
) -> Carrier:
    """Choose what carries the motions of a model.

    Raises
    ------
    ValueError
        As in `engine_for`; an unknown device; 'cuda' without a GPU, or for a model that only
        the CPU carries.
    """
    if device not in DEVICES:
        raise ValueError(f"device = {device!r} is unknown. {did_you_mean(str(device), DEVICES)}")
    if device == "cuda":
        from stickslip.mechanics.eventmap.cuda_carrier import CudaCarrier  # needs numba-cuda

        return CudaCarrier(model, engine, controls)
    if model.damping > 0.0:
        return DampedCarrier(model, engine, controls, threads)
    chosen = LaneCarrier if lanes_serve(model, engine, controls) else PlainCarrier
    return chosen(model, engine, controls, threads)


class PlainCarrier:
    """Two undamped blocks: the engines that know w and e, one motion at a time."""

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        self.model, self.controls, self.threads = model, controls, threads
        self.engine: Engine = engine_for(model, engine)
        self.name = self.engine.name
        self._local = threading.local()

    def value(self, d: float) -> float:
        return float(self.values(np.array([d]))[0])

    def values(self, d: Floats) -> Floats:
        return self._carried(d, ()).value

    def slopes(self, d: Floats) -> Floats:
        return self._carried(d, (start_direction(self.engine),)).derivative[:, 0]

    def evidence(self, d: Floats) -> Outputs:
        return self._carried(d, (start_direction(self.engine),), watch=True)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        direction = parameter_direction(self.engine, self.model, name)
        return self._carried(d, (direction,)).derivative[:, 0]

    def _carried(self, d: Floats, directions: Sequence[Floats], watch: bool = False) -> Outputs:
        outputs = new_outputs(d.size, len(directions))

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(directions)
            scratch.work.watch[0] = float(watch)
            self._run(self._kernels.carry_range, d, start, stop, scratch, outputs)

        launch(task, d.size, self.threads, SMALLEST_TILE[self.name])
        return outputs

    def iterate(self, orbits: Floats) -> None:
        def task(start: int, stop: int) -> None:
            self._run(self._kernels.iterate_range, orbits, start, stop, self._scratch(()))

        self._launch_orbits(task, orbits)

    def _launch_orbits(self, task: Callable[[int, int], None], orbits: Floats) -> None:
        steps = max(1, orbits.shape[1] - 1)
        launch(task, len(orbits), self.threads, max(1, SMALLEST_TILE[self.name] // steps))

    def _run(
        self,
        kernel: Callable[..., None],
        points: Floats,
        start: int,
        stop: int,
        scratch: Scratch,
        *more: Outputs,
    ) -> None:
        engine = self.engine
        kernel(
            engine.system,
            engine.laws,
            points,
            start,
            stop,
            scratch,
            self.controls,
            NO_ITINERARY,
            *more,
        )

    def itinerary(self, d: float) -> str:
        codes = np.zeros(64, dtype=np.int8)
        while True:
            _, _, n_events, _, _, _ = self._kernels.carry(
                self.engine.system, self.engine.laws, d, self._scratch(()), self.controls, codes
            )
            if n_events < codes.size:
                return itinerary_text(codes[: n_events + 1])
            codes = np.zeros(n_events + 1, dtype=np.int8)

    @cached_property
    def _kernels(self) -> ModuleType:
        return bind_engine("stickslip.mechanics.eventmap._kernels", self.engine)

    def _scratch(self, directions: Sequence[Floats]) -> Scratch:
        """Work arrays for this thread, with a tangent column for each direction."""
        n_columns = len(directions)
        held: dict[int, Scratch] = self._local.__dict__.setdefault("scratch", {})
        if n_columns not in held:
            held[n_columns] = new_scratch(self.engine, n_columns)
        scratch = held[n_columns]
        for column, direction in enumerate(directions):
            scratch.motion.directions[column] = direction
            scratch.long_motion.directions[column] = direction
        return scratch


class LaneCarrier(PlainCarrier):
    """Constant kinetic friction: values and slopes by lanes, all else by the exact engine.

    Where lanes pass (a decision too close, a motion too long) the exact engine gives the
    value too. Which of them answers depends on d alone, so values do not depend on how many
    are asked together, on what else is asked of them, or on threads.
    """

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        super().__init__(model, engine, controls, threads)
        self.lanes = Lanes(self.engine, controls)

    def value(self, d: float) -> float:
        value = self.lanes.value(d)
        if value == value:
            return value if value < math.inf else math.nan
        return super().value(d)

    def values(self, d: Floats) -> Floats:
        values, passed = self._by_lanes(d, NO_SLOPE)
        if passed.size > 0:
            values[passed] = super().values(d[passed])
        return values

    def slopes(self, d: Floats) -> Floats:
        slopes = np.empty(d.size)
        _, passed = self._by_lanes(d, slopes)
        if passed.size > 0:
            slopes[passed] = super().slopes(d[passed])
        return slopes

    def evidence(self, d: Floats) -> Outputs:
        outputs = super().evidence(d)
        slopes = np.empty(d.size)
        values, _ = self._by_lanes(d, slopes)
        served = ~np.isnan(values)
        outputs.value[served] = values[served]
        outputs.derivative[served, 0] = slopes[served]
        return outputs

    def _by_lanes(self, d: Floats, slopes: Floats) -> tuple[Floats, NDArray[np.intp]]:
        """Values and, if there is room for them, slopes; indices that the lanes passed on."""
        values = d.copy()

        def task(start: int, stop: int) -> None:
            self.lanes.carry(values, slopes, start, stop)

        launch(task, d.size, self.threads, SMALLEST_TILE["lanes"])
        passed = np.flatnonzero(np.isnan(values))
        values[np.isinf(values)] = math.nan
        return values, passed

    def iterate(self, orbits: Floats) -> None:
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
                self._scratch(()),
                self.controls,
                NO_ITINERARY,
            )

        self._launch_orbits(task, orbits)

    @cached_property
    def _orbits(self) -> ModuleType:
        template = "stickslip.mechanics.eventmap._lane_orbits_kernels"
        return instantiate(template, self.engine.key, carry=self._kernels.carry)


class DampedCarrier:
    """Two damped blocks: the flow of the family."""

    name = "series"

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        engine_for(model.replace(damping=0.0), engine)  # the same errors
        self.parameters = model.parameters
        self.inner = BlocksEventMap(model.chain, **controls._asdict(), threads=threads)

    def value(self, d: float) -> float:
        return float(self.values(np.array([d]))[0])

    def values(self, d: Floats) -> Floats:
        return self.inner.carry(d[:, None]).value[:, 0]

    def slopes(self, d: Floats) -> Floats:
        return self.inner.carry(d[:, None], slope=True).derivative[:, 0, 0]

    def evidence(self, d: Floats) -> Outputs:
        found = self.inner.carry(d[:, None], slope=True, watch=True)
        return Outputs(found.value[:, 0], found.derivative[:, 0], *found[2:])

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        if name not in self.parameters:
            known = did_you_mean(name, list(self.parameters))
            raise ValueError(f"the model has no parameter {name!r}. {known}")
        name = {"beta": "static_2"}.get(name, name)
        return self.inner.parameter_derivative(d[:, None], name)[:, 0]

    def iterate(self, orbits: Floats) -> None:
        orbits[:] = self.inner.iterate(orbits[:, :1], orbits.shape[1] - 1)[..., 0]

    def itinerary(self, d: float) -> str:
        return str(self.inner.itinerary([d]))


def new_scratch(engine: Engine, n_columns: int) -> Scratch:
    """Work arrays of one motion with that many tangents."""
    n_law = engine.n_law_parameters
    return Scratch(
        new_motion(n_columns, n_law),
        new_motion(n_columns + 4, n_law),
        new_motion(0, n_law),
        engine.new_work(),
    )


def new_outputs(n: int, n_columns: int) -> Outputs:
    """Arrays for what n motions leave."""
    return Outputs(
        value=np.full(n, np.nan),
        derivative=np.full((n, n_columns), np.nan),
        duration=np.zeros(n),
        n_events=np.zeros(n, dtype=np.int64),
        label=np.zeros(n, dtype=np.uint64),
        margin=np.full(n, np.inf),
        status=np.zeros(n, dtype=np.int64),
    )
