"""What carries motions from one global stick phase to the next: kernels, threads, scratch."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Protocol

import numpy as np

from stickslip.mechanics.eventmap.itinerary import itinerary_text
from stickslip.mechanics.eventmap.loop import new_loop
from stickslip.mechanics.eventmap.records import Controls, Outputs, Scratch, new_outputs
from stickslip.mechanics.flow.engine import (
    Engine,
    bind_engine,
    parameter_direction,
    start_direction,
)
from stickslip.mechanics.flow.system import new_motion
from stickslip.numerics.targets import launch

if TYPE_CHECKING:
    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats


# Fewer motions than this are not worth a thread.
SMALLEST_TILE = {"exact": 4000, "taylor": 64, "collocation": 16}
NO_ITINERARY = np.zeros(0, dtype=np.int8)


class Backend(Protocol):
    """Carries motions of two blocks from start to value; points are arrays of shape (n,)."""

    name: str

    def value(self, d: float) -> float:
        """Value at one d."""

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, slopes in column 0 of the derivatives; all the rest only if `watch`."""

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""


class ScalarBackend:
    """Two undamped blocks: the engines that know w and e, one motion at a time."""

    def __init__(self, model: TwoBlock, engine: Engine, controls: Controls, threads: int) -> None:
        self.model, self.engine, self.controls, self.threads = model, engine, controls, threads
        self.name = self.engine.name
        self._local = threading.local()

    def value(self, d: float) -> float:
        """Value at one d."""
        return float(self.carry(np.array([d])).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        return self._carried(d, (start_direction(self.engine),) if slope else (), watch)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        direction = parameter_direction(self.engine, self.model, name)
        return self._carried(d, (direction,)).derivative[:, 0]

    def _carried(self, d: Floats, directions: Sequence[Floats], watch: bool = False) -> Outputs:
        outputs = new_outputs(d.shape, len(directions))

        def task(start: int, stop: int) -> None:
            scratch = self.scratch(directions)
            scratch.work.watch[0] = float(watch)
            self._run(self.kernels.carry_range, d, start, stop, scratch, outputs)

        launch(task, d.size, self.threads, SMALLEST_TILE[self.name])
        return outputs

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

        def task(start: int, stop: int) -> None:
            self._run(self.kernels.iterate_range, orbits, start, stop, self.scratch(()))

        self.launch_orbits(task, orbits)

    def launch_orbits(self, task: Callable[[int, int], None], orbits: Floats) -> None:
        """Run a task over rows of `orbits` in threads."""
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
        """Modes of each phase, as text."""
        codes = np.zeros(64, dtype=np.int8)
        while True:
            _, _, n_events, _, _, _ = self.kernels.carry(
                self.engine.system, self.engine.laws, d, self.scratch(()), self.controls, codes
            )
            if n_events < codes.size:
                return itinerary_text(codes[: n_events + 1])
            codes = np.zeros(n_events + 1, dtype=np.int8)

    @cached_property
    def kernels(self) -> ModuleType:
        """The kernels with this engine bound into them."""
        return bind_engine("stickslip.mechanics.eventmap._kernels", self.engine)

    def scratch(self, directions: Sequence[Floats]) -> Scratch:
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


def new_scratch(engine: Engine, n_columns: int) -> Scratch:
    """Work arrays of one motion with that many tangents."""
    n_law = engine.n_law_parameters
    return Scratch(
        new_motion(n_columns, n_law),
        new_motion(n_columns + 4, n_law),
        new_motion(0, n_law),
        new_loop(4),
        engine.new_work(),
    )
