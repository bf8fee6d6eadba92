"""What carries motions of any number of blocks from one global stick phase to the next."""

from __future__ import annotations

import threading
from functools import cached_property, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.itinerary import SYMBOLS
from stickslip.mechanics.eventmap.loop import new_loop
from stickslip.mechanics.eventmap.records import (
    BlockScratch,
    Controls,
    Outputs,
    Section,
    SectionChanges,
    new_outputs,
)
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    Rows,
    new_block_motion,
    sparse_changes,
    widened,
)
from stickslip.mechanics.flow.engine import BlockEngine
from stickslip.numerics.targets import instantiate, launch

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats


SMALLEST_TILE = 64  # fewer motions are not worth a thread
MODES = np.array(list(SYMBOLS))


class BlocksBackend:
    """Any number of blocks, springs and dampers: one motion at a time."""

    name = "series"

    def __init__(self, model: Model, engine: BlockEngine, controls: Controls, threads: int) -> None:
        self.model = model
        self.engine, self.controls, self.threads = engine, controls, threads
        self._local = threading.local()

    def value(self, d: float) -> float:
        """Value at one d of two blocks."""
        return float(self.carry(np.array([d])).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        return self._run(d, self._start_directions if slope else self._no_directions, watch=watch)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        directions = self.engine.directions(changes=[self.engine.change(self.model, name)])
        return self._run(d, directions, self._section_along(name)).derivative[..., 0]

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1, ...) from their first entries on."""
        points = orbits.reshape(*orbits.shape[:2], self._dimension)
        tile = max(1, SMALLEST_TILE // max(1, orbits.shape[1] - 1))
        self._launch(self._kernels.iterate_range, points, self._no_directions, tile=tile)

    def itinerary(self, d: float | list[float]) -> str:
        """Modes of each phase, as text."""
        length = 64
        while True:
            modes = np.zeros((length, self.model.n_blocks), dtype=np.int8)
            _, n_events, _, _, _ = self._kernels.carry(
                self.engine.system,
                self.engine.laws,
                self._section,
                np.array(d, ndmin=1),
                self._scratch(self._no_directions),
                self.controls,
                modes,
            )
            if n_events < length:
                return " ".join("".join(row) for row in MODES[modes[: n_events + 1] + 1])
            length = n_events + 1

    # --- where motions start and end ---------------------------------------------------------

    @property
    def _dimension(self) -> int:
        return self.model.n_blocks - 1

    @cached_property
    def _section(self) -> Section:
        """Global stick, and differences as the point; changes in their own directions."""
        n, into = self._dimension, np.zeros((0, 0))
        pairs = np.arange(n)[:, None] + np.array([0, 1])
        out = Rows(2 * np.arange(n + 1), pairs.ravel(), np.tile([-1.0, 1.0], n), np.zeros(n))
        return Section(-1, 0, False, 0.0, into, out, still(max(n, 1), n, into, 0))

    def _section_along(self, _name: str) -> Section:
        """Return the section with its change with a parameter: differences have none."""
        return self._section

    # --- kernels --------------------------------------------------------------------------

    @cached_property
    def _kernels(self) -> ModuleType:
        return _bound(self.engine)

    @cached_property
    def _no_itinerary(self) -> NDArray[np.int8]:
        return np.zeros((0, self.model.n_blocks), dtype=np.int8)

    @cached_property
    def _no_directions(self) -> BlockDirections:
        return self.engine.directions()

    @cached_property
    def _start_directions(self) -> BlockDirections:
        return self.engine.directions(np.eye(self._dimension))

    def _scratch(self, directions: BlockDirections) -> BlockScratch:
        """Work arrays for this thread, with a tangent column for each direction."""
        count, system = len(directions.varies), self.engine.system
        n = len(system.constant) - len(system.mass)  # numbers of a state
        held: dict[int, BlockScratch] = self._local.__dict__.setdefault("scratch", {})
        if count not in held:
            held[count] = BlockScratch(
                new_block_motion(system, count),
                directions,
                new_block_motion(system, count + n),
                widened(directions, n),
                new_block_motion(system, 0),
                new_loop(n),
                self.engine.new_work(),
            )
        scratch = held[count]
        if scratch.directions is not directions:
            wide = widened(directions, n)
            scratch = held[count] = scratch._replace(directions=directions, long_directions=wide)
        return scratch

    def _run(
        self,
        d: Floats,
        directions: BlockDirections,
        section: Section | None = None,
        *,
        watch: bool = False,
    ) -> Outputs:
        """Evaluate all points on all threads."""
        count = len(directions.varies)
        outputs = new_outputs(d.shape, count)
        rows = (len(d), self._dimension)
        points = d.reshape(rows)
        # The same numbers, with an axis for the differences that two blocks have one of.
        told = outputs._replace(
            value=outputs.value.reshape(rows), derivative=outputs.derivative.reshape(*rows, count)
        )
        self._launch(
            self._kernels.carry_range, points, directions, told, section=section, watch=watch
        )
        return outputs

    def _launch(
        self,
        kernel: Callable[..., None],
        points: Floats,
        directions: BlockDirections,
        *more: Outputs,
        section: Section | None = None,
        watch: bool = False,
        tile: int = SMALLEST_TILE,
    ) -> None:
        """Run a kernel over rows of points on all threads."""
        engine, section = self.engine, section or self._section

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(directions)
            scratch.work.watch[0] = float(watch)
            kernel(
                engine.system,
                engine.laws,
                section,
                points,
                start,
                stop,
                scratch,
                self.controls,
                self._no_itinerary,
                *more,
            )

        launch(task, len(points), self.threads, tile)


def still(count: int, n_point: int, into: Floats, n_harmonics: int) -> SectionChanges:
    """Return changes of a section that does not change itself, only with its point."""
    none = np.zeros((count, n_harmonics))
    return SectionChanges(
        point=np.eye(count, n_point),
        into=np.zeros((count, *into.shape)),
        out=sparse_changes([None] * count, n_point, [False] * count),
        period=np.zeros(count),
        frequency=none,
        phase=none,
    )


@lru_cache(maxsize=64)
def _bound(engine: BlockEngine) -> ModuleType:
    return instantiate(
        "stickslip.mechanics.eventmap._blocks_kernels",
        engine.key,
        advance=engine.kernels.advance,
        landing_rate=engine.kernels.landing_rate,
        rate=engine.kernels.rate,
        slides_for_ever=engine.kernels.slides_for_ever,
    )
