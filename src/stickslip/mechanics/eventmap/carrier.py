"""What carries motions from one global stick phase to the next: kernels, threads, scratch.

The event map of two blocks asks a carrier and does not know which engine it has.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Protocol

import numpy as np

from stickslip.mechanics.eventmap.blocks_map import BlocksEventMap
from stickslip.mechanics.eventmap.itinerary import itinerary_text
from stickslip.mechanics.eventmap.records import Controls, Lanes, Outputs, Scratch
from stickslip.mechanics.flow.engine import (
    Engine,
    EngineName,
    bind_engine,
    engine_for,
    parameter_direction,
    start_direction,
)
from stickslip.mechanics.flow.lanes.kernels import lane_kernels
from stickslip.mechanics.flow.lanes.layout import ALIGNMENT, HANDED_OVER, LANES, ORDER, PLACES
from stickslip.mechanics.flow.system import new_motion
from stickslip.mechanics.friction.series import LawSeries, law_series
from stickslip.numerics.targets import instantiate, launch
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]

__all__ = ["Carrier", "carrier_for"]

# Fewer motions than this are not worth a thread.
SMALLEST_TILE = {"exact": 4000, "taylor": 64, "collocation": 16, "lanes": 512}
STEPS = ("step_one", "step_both", "tangent_one", "tangent_both")
NO_ITINERARY = np.zeros(0, dtype=np.int8)


class Carrier(Protocol):
    """Carries many motions of two blocks; points are arrays of shape (n,)."""

    name: str

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Carry each d; with its derivative in column 0 if `slope`, margins if `watch`."""

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""


def carrier_for(model: TwoBlock, engine: EngineName, controls: Controls, threads: int) -> Carrier:
    """Choose what carries the motions of a model; errors as in `engine_for`."""
    if model.damping > 0.0:
        return _DampedCarrier(model, engine, controls, threads)
    prepared = engine_for(model, engine)
    series = law_series(model.laws) if prepared.name == "taylor" else None
    if series is not None:
        return _LanesCarrier(model, prepared, controls, threads, series)
    return _PlainCarrier(model, prepared, controls, threads)


class _PlainCarrier:
    """Two undamped blocks: the engines that know w and e."""

    def __init__(self, model: TwoBlock, engine: Engine, controls: Controls, threads: int) -> None:
        self.model, self.controls, self.threads = model, controls, threads
        self.engine = engine
        self.name = engine.name
        self._local = threading.local()

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        directions = (start_direction(self.engine),) if slope else ()
        return self._carried(d, directions, watch)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        direction = parameter_direction(self.engine, self.model, name)
        return self._carried(d, (direction,), watch=False).derivative[:, 0]

    def _carried(self, d: Floats, directions: Sequence[Floats], watch: bool) -> Outputs:
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
            n_law = self.engine.n_law_parameters
            held[n_columns] = Scratch(
                new_motion(n_columns, n_law),
                new_motion(n_columns + 4, n_law),
                new_motion(0, n_law),
                self.engine.new_work(),
            )
        scratch = held[n_columns]
        for column, direction in enumerate(directions):
            scratch.motion.directions[column] = direction
            scratch.long_motion.directions[column] = direction
        return scratch


class _LanesCarrier(_PlainCarrier):
    """Two undamped blocks with one formula for both: many motions at once.

    What the lanes hand over, and derivatives by parameters, the scalar engine carries. Which of
    the two carries a motion depends on that motion alone, and so do the bits of its value.
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
        orbits = np.full((d.size, 2), np.nan)
        orbits[:, 0] = d
        return self._advanced(orbits, slope or watch, watch)._replace(value=orbits[:, 1])

    def iterate(self, orbits: Floats) -> None:
        self._advanced(orbits, tangent=False, watch=False)

    def _advanced(self, orbits: Floats, tangent: bool, watch: bool) -> Outputs:
        """Fill the rows of `orbits`; what is known of their last motions."""
        directions = (start_direction(self.engine),) if tangent else ()
        outputs = new_outputs(len(orbits), len(directions))
        filled = np.zeros(len(orbits), dtype=np.int64)

        def task(start: int, stop: int) -> None:
            self._lanes_kernels.advance_orbits(
                self.engine.system,
                self.engine.laws,
                orbits,
                filled,
                start,
                stop,
                self._lanes(directions),
                self.controls,
                watch,
                outputs,
            )

        steps = max(1, orbits.shape[1] - 1)
        while True:
            launch(task, len(orbits), self.threads, max(1, SMALLEST_TILE["lanes"] // steps))
            rows = np.flatnonzero(outputs.status == HANDED_OVER)
            if rows.size == 0:
                return outputs
            carried = self._carried(orbits[rows, filled[rows]], directions, watch=watch)
            for field, found in zip(outputs, carried, strict=True):
                field[rows] = found
            filled[rows] += 1
            orbits[rows, filled[rows]] = carried.value

    @cached_property
    def _lanes_kernels(self) -> ModuleType:
        """The driver, bound to the law's steps and to the decisions of the scalar engine."""
        engine, steps, scalar = self.engine, lane_kernels(self.series), self._kernels
        shared = ("blocks_of_event", "event_margin", "hashed", "mode_code", "value_tangent")
        return instantiate(
            "stickslip.mechanics.eventmap._lanes_kernels",
            f"{engine.key}-{self.series.key}",
            force=engine.code.force,
            rate=engine.kernels.rate,
            **{name: getattr(steps, name) for name in STEPS},
            **{name: getattr(scalar, name) for name in shared},
        )

    def _lanes(self, directions: Sequence[Floats]) -> Lanes:
        """Pools for this thread."""
        held: dict[int, Lanes] = self._local.__dict__.setdefault("lanes", {})
        n_columns = len(directions)
        if n_columns not in held:
            size = lane_kernels(self.series).SIZE
            laws = self.series.rows(self.model.laws)
            held[n_columns] = new_lanes(n_columns, self.engine, laws, size)
            for column, direction in enumerate(directions):
                held[n_columns].motion.directions[column] = direction
        return held[n_columns]


def new_lanes(n_columns: int, engine: Engine, laws: Floats, size: int) -> Lanes:
    """Arrays of empty pools; the pools begin where vectors of any machine may."""
    bytes_ = np.zeros(8 * 3 * size + ALIGNMENT, dtype=np.uint8)
    start = -bytes_.ctypes.data % ALIGNMENT
    return Lanes(
        laws=laws,
        x=bytes_[start : start + 8 * 3 * size].view(np.float64).reshape(3, size),
        tags=np.zeros((3, PLACES, 4), dtype=np.int64),
        labels=np.zeros((3, PLACES), dtype=np.uint64),
        counts=np.zeros(3, dtype=np.int64),
        flagged=np.zeros(LANES + 1, dtype=np.int64),
        rows=np.zeros(LANES, dtype=np.int64),
        motion=new_motion(n_columns, engine.n_law_parameters),
        w=np.zeros((2, ORDER + 1)),
        e=np.zeros((2, ORDER + 1)),
        signal=np.zeros(ORDER + 1),
        reciprocals=1.0 / np.maximum(np.arange(ORDER + 2), 1),
    )


class _DampedCarrier:
    """Two damped blocks: the flow of the family."""

    name = "series"

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        engine_for(model.replace(damping=0.0), engine)  # the same errors
        self.parameters = model.parameters
        self.inner = BlocksEventMap(model.chain, **controls._asdict(), threads=threads)

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        found = self.inner.carry(d[:, None], slope=slope, watch=watch)
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
