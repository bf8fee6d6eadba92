"""What carries motions of any number of blocks from one global stick phase to the next."""

from __future__ import annotations

import threading
from functools import cached_property, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.itinerary import SYMBOLS
from stickslip.mechanics.eventmap.records import BlockScratch, Controls, Outputs, new_outputs
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    block_directions,
    new_block_motion,
)
from stickslip.mechanics.flow.engine import BlockEngine
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.targets import instantiate, launch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.arguments import Model
    from stickslip.mechanics.model.structure import Structure
    from stickslip.numerics.arrays import Floats


SMALLEST_TILE = 64  # fewer motions are not worth a thread
MODES = np.array(list(SYMBOLS))


class BlocksBackend:
    """Any number of blocks, springs and dampers: one motion at a time."""

    name = "series"

    def __init__(self, model: Model, engine: BlockEngine, controls: Controls, threads: int) -> None:
        self.model = model.chain if isinstance(model, TwoBlock) else model
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
        name = name if name in self.model.parameters else "static_2"  # beta of two equal blocks
        return self._run(d, self._parameter_direction(name)).derivative[..., 0]

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1, ...) from their first entries on."""
        engine = self.engine
        points = orbits.reshape(*orbits.shape[:2], self._dimension)

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(self._no_directions)
            self._kernels.iterate_range(
                engine.system,
                engine.laws,
                points,
                start,
                stop,
                scratch,
                self.controls,
                self._no_itinerary,
            )

        steps = max(1, orbits.shape[1] - 1)
        launch(task, len(orbits), self.threads, max(1, SMALLEST_TILE // steps))

    def itinerary(self, d: float | list[float]) -> str:
        """Modes of each phase, as text."""
        length = 64
        while True:
            modes = np.zeros((length, self.model.n_blocks), dtype=np.int8)
            _, n_events, _, _, _ = self._kernels.carry(
                self.engine.system,
                self.engine.laws,
                np.array(d, ndmin=1),
                self._scratch(self._no_directions),
                self.controls,
                modes,
            )
            if n_events < length:
                return " ".join("".join(row) for row in MODES[modes[: n_events + 1] + 1])
            length = n_events + 1

    # --- kernels --------------------------------------------------------------------------

    @property
    def _dimension(self) -> int:
        return self.model.n_blocks - 1

    @cached_property
    def _kernels(self) -> ModuleType:
        return _bound(self.engine)

    @cached_property
    def _no_itinerary(self) -> NDArray[np.int8]:
        return np.zeros((0, self.model.n_blocks), dtype=np.int8)

    def _directions(
        self, changes: list[Structure | None], laws: Floats, start: Floats
    ) -> BlockDirections:
        return block_directions(self.engine.system, changes, laws, start)

    def _law_changes(self, count: int) -> Floats:
        return np.zeros((count, self.model.n_blocks, self.engine.code.N_PARAMETERS))

    @cached_property
    def _no_directions(self) -> BlockDirections:
        return self._directions([], self._law_changes(0), np.zeros((0, self._dimension)))

    @cached_property
    def _start_directions(self) -> BlockDirections:
        m = self._dimension
        return self._directions([None] * m, self._law_changes(m), np.eye(m))

    def _parameter_direction(self, name: str) -> BlockDirections:
        laws = self._law_changes(1)
        start = np.zeros((1, self._dimension))
        owners = self.model.law_parameters.get(name)
        if owners is None:
            return self._directions([self.model.structure_direction(name)], laws, start)
        for block, own_name in owners:
            law = self.model.laws[block]
            laws[0, block, self.engine.code.parameter_index(law, own_name)] = 1.0
        return self._directions([None], laws, start)

    def _scratch(self, directions: BlockDirections) -> BlockScratch:
        """Work arrays for this thread, with a tangent column for each direction."""
        n, count = self.model.n_blocks, len(directions.V)
        held: dict[int, BlockScratch] = self._local.__dict__.setdefault("scratch", {})
        if count not in held:
            none = self._directions(
                [None] * (count + 2 * n),
                self._law_changes(count + 2 * n),
                np.zeros((count + 2 * n, self._dimension)),
            )
            held[count] = BlockScratch(
                new_block_motion(n, count),
                directions,
                new_block_motion(n, count + 2 * n),
                none,
                new_block_motion(n, 0),
                self.engine.new_work(),
            )
        scratch = held[count]
        for wide, narrow in zip(scratch.long_directions, directions, strict=True):
            wide[:count] = narrow
        return scratch._replace(directions=directions)

    def _run(self, d: Floats, directions: BlockDirections, *, watch: bool = False) -> Outputs:
        """Evaluate all points on all threads."""
        count = len(directions.V)
        outputs = new_outputs(d.shape, count)
        rows = (len(d), self._dimension)
        points = d.reshape(rows)
        # The same numbers, with an axis for the differences that two blocks have one of.
        told = outputs._replace(
            value=outputs.value.reshape(rows), derivative=outputs.derivative.reshape(*rows, count)
        )
        engine = self.engine

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(directions)
            scratch.work.watch[0] = float(watch)
            self._kernels.carry_range(
                engine.system,
                engine.laws,
                points,
                start,
                stop,
                scratch,
                self.controls,
                self._no_itinerary,
                told,
            )

        launch(task, len(d), self.threads, SMALLEST_TILE)
        return outputs


@lru_cache(maxsize=64)
def _bound(engine: BlockEngine) -> ModuleType:
    return instantiate(
        "stickslip.mechanics.eventmap._blocks_kernels",
        engine.key,
        advance=engine.kernels.advance,
        landing_rate=engine.kernels.landing_rate,
        slides_for_ever=engine.kernels.slides_for_ever,
    )
