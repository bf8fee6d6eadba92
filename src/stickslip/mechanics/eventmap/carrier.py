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
from stickslip.numerics.targets import launch
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]

__all__ = ["Carrier", "carrier_for"]

# Fewer motions than this are not worth a thread.
SMALLEST_TILE = {"exact": 4000, "taylor": 64, "collocation": 16}
DEVICES = ("cpu", "cuda")
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
    return PlainCarrier(model, engine, controls, threads)


class PlainCarrier:
    """Two undamped blocks: the engines that know w and e."""

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        self.model, self.controls, self.threads = model, controls, threads
        self.engine: Engine = engine_for(model, engine)
        self.name = self.engine.name
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
            held[n_columns] = new_scratch(self.engine, n_columns)
        scratch = held[n_columns]
        for column, direction in enumerate(directions):
            scratch.motion.directions[column] = direction
            scratch.long_motion.directions[column] = direction
        return scratch


class DampedCarrier:
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
