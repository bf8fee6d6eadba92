"""The event map of n blocks: from the differences of one global stick phase to the next."""

from __future__ import annotations

import math
import threading
from functools import cached_property, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import MOST_STEPS, parameter_name, whole_number
from stickslip.mechanics.eventmap.base import EventMapResult, ModelMap
from stickslip.mechanics.eventmap.records import BlockScratch, Outputs, new_outputs
from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    block_directions,
    new_block_motion,
)
from stickslip.mechanics.flow.engine import BlockEngine, block_engine
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.numerics.targets import instantiate, launch

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.model.structure import Structure
    from stickslip.numerics.arrays import Floats


SMALLEST_TILE = 64  # fewer motions are not worth a thread
MODES = np.array(["-", ".", "+"])


class BlocksEventMap(ModelMap):
    """The event map of a model with any number of blocks; `stickslip.event_map` makes it.

    Calling it carries differences ``d_i = X_{i+1} - X_i`` from one global stick phase to the
    next: ``f(d)`` for arrays of shape (..., n_blocks - 1). Immutable; equal settings compare
    equal.
    """

    model: BeltModel

    def __init__(
        self,
        model: BeltModel,
        *,
        rtol: float = 1e-15,
        max_events: int = 10_000,
        max_time: float = math.inf,
        threads: int | None = None,
    ) -> None:
        if model.forcing is not None:
            raise ValueError(
                "a forced model has no event map: what a global stick phase leads to depends on "
                "its time as well. Take stickslip.stroboscopic_map(model)."
            )
        if model.n_blocks < 2:
            raise ValueError(
                f"the event map of {model.n_blocks} block has no differences d to map: two blocks "
                "or more are needed. stickslip.simulate follows the block in time."
            )
        self.model = model
        self._set(rtol, max_events, max_time, threads)
        self._engine: BlockEngine = block_engine(model)
        self._local = threading.local()

    # --- what it is -----------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        """Entries of d: one less than blocks."""
        return self.model.n_blocks - 1

    def contains(self, d: ArrayLike) -> NDArray[np.bool_]:
        """Whether ``d`` (..., n_blocks - 1) belongs to a global stick phase; False for NaN."""
        return self.model.contains(d)

    def spread(self, n: int) -> Floats:
        """Return n points spread evenly over the domain, always the same."""
        return self.model.spread_domain(n)

    def __repr__(self) -> str:
        """One line."""
        return f"BlocksEventMap({self.model!r})"

    # --- values ---------------------------------------------------------------------------

    def __call__(self, d: ArrayLike) -> Floats:
        """Value of the map.

        Parameters
        ----------
        d : array_like of float, shape (..., n_blocks - 1)
            ``X_{i+1} - X_i`` of global stick phases.

        Returns
        -------
        ndarray of float, shaped like ``d``
            NaN where the motion does not return to global stick.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or belongs to no global stick phase.
        """
        points = self.model.admit(d)
        return self.carry(points).value.reshape(points.shape)

    def derivative(self, d: ArrayLike) -> Floats:
        """Jacobian of the map, exact, one-sided at a breakpoint.

        Parameters
        ----------
        d : array_like of float, shape (..., n_blocks - 1)

        Returns
        -------
        ndarray of float, shape (..., n_blocks - 1, n_blocks - 1)
            Entry (i, j): derivative of value i with respect to d_j. Errors as for calling.
        """
        points = self.model.admit(d)
        outputs = self.carry(points, slope=True)
        return outputs.derivative.reshape(*points.shape, self.dimension)

    def parameter_derivative(self, d: ArrayLike, name: str) -> Floats:
        """df/d(name) at fixed ``d``, exact, shaped like ``d``; ValueError for an unknown name."""
        name = parameter_name("name", name, self.parameters, of="the model")
        directions = self._parameter_direction(name)
        points = self.model.admit(d)
        return self._run(points, directions).derivative.reshape(points.shape)

    def evaluate(self, d: ArrayLike) -> EventMapResult:
        """Carry differences to the next global stick phase, and tell how.

        Parameters
        ----------
        d : array_like of float, shape (..., n_blocks - 1)

        Returns
        -------
        EventMapResult
            ``value`` shaped like ``d``, ``derivative`` the Jacobian, the other fields of shape
            ``d.shape[:-1]``.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or belongs to no global stick phase.
        """
        points = self.model.admit(d)
        outputs = self.carry(points, slope=True, watch=True)
        slopes = (*points.shape, self.dimension)
        return self._result(points, outputs, points.shape[:-1], slopes)

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Carry rows of differences, which are not checked; with the Jacobian if `slope`."""
        directions = self._start_directions if slope else self._no_directions
        return self._run(d, directions, watch=watch)

    def itinerary(self, d: ArrayLike) -> str | NDArray[np.str_]:
        """Modes of all blocks from the onset to the next global stick, as text.

        Returns
        -------
        str or ndarray of str, shape ``d.shape[:-1]``
            Such as ``"-.. --. -.. ..."``: one character per block and phase.
        """
        points = self.model.admit(d)
        rows = points.reshape(-1, self.dimension)
        texts = [self._itinerary(row) for row in rows]
        return texts[0] if points.ndim == 1 else np.array(texts).reshape(points.shape[:-1])

    def iterate(self, d: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times, keeping every point, shape (..., n + 1, n_blocks - 1).

        Raises
        ------
        ValueError
            Some ``d`` is outside the domain; ``n`` is negative.
        """
        n = whole_number("n", n, 0, at_most=MOST_STEPS, what="applications of the map")
        points = self.model.admit(d)
        rows = points.reshape(-1, self.dimension)
        orbits = np.empty((len(rows), n + 1, self.dimension))
        orbits[:, 0] = rows
        self._fill(orbits)
        return orbits.reshape(*points.shape[:-1], n + 1, self.dimension)

    def _fill(self, orbits: Floats) -> None:
        """Fill orbits (m, steps + 1, n_blocks - 1) from their first points on, not checked."""
        engine = self._engine

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(self._no_directions)
            self._kernels.iterate_range(
                engine.system,
                engine.laws,
                orbits,
                start,
                stop,
                scratch,
                self._controls,
                self._no_itinerary,
            )

        steps = max(1, orbits.shape[1] - 1)
        launch(task, len(orbits), self.threads, max(1, SMALLEST_TILE // steps))

    # --- kernels --------------------------------------------------------------------------

    @cached_property
    def _kernels(self) -> ModuleType:
        return _bound(self._engine)

    @cached_property
    def _no_itinerary(self) -> NDArray[np.int8]:
        return np.zeros((0, self.model.n_blocks), dtype=np.int8)

    def _directions(
        self, changes: list[Structure | None], laws: Floats, start: Floats
    ) -> BlockDirections:
        return block_directions(self._engine.system, changes, laws, start)

    def _law_changes(self, count: int) -> Floats:
        return np.zeros((count, self.model.n_blocks, self._engine.code.N_PARAMETERS))

    @cached_property
    def _no_directions(self) -> BlockDirections:
        return self._directions([], self._law_changes(0), np.zeros((0, self.dimension)))

    @cached_property
    def _start_directions(self) -> BlockDirections:
        m = self.dimension
        return self._directions([None] * m, self._law_changes(m), np.eye(m))

    def _parameter_direction(self, name: str) -> BlockDirections:
        laws = self._law_changes(1)
        start = np.zeros((1, self.dimension))
        owners = self.model.law_parameters.get(name)
        if owners is None:
            return self._directions([self.model.structure_direction(name)], laws, start)
        for block, own_name in owners:
            law = self.model.laws[block]
            laws[0, block, self._engine.code.parameter_index(law, own_name)] = 1.0
        return self._directions([None], laws, start)

    def _scratch(self, directions: BlockDirections) -> BlockScratch:
        """Work arrays for this thread, with a tangent column for each direction."""
        n, count = self.model.n_blocks, len(directions.V)
        held: dict[int, BlockScratch] = self._local.__dict__.setdefault("scratch", {})
        if count not in held:
            none = self._directions(
                [None] * (count + 2 * n),
                self._law_changes(count + 2 * n),
                np.zeros((count + 2 * n, self.dimension)),
            )
            held[count] = BlockScratch(
                new_block_motion(n, count),
                directions,
                new_block_motion(n, count + 2 * n),
                none,
                new_block_motion(n, 0),
                self._engine.new_work(),
            )
        scratch = held[count]
        for wide, narrow in zip(scratch.long_directions, directions, strict=True):
            wide[:count] = narrow
        return scratch._replace(directions=directions)

    def _run(self, points: Floats, directions: BlockDirections, *, watch: bool = False) -> Outputs:
        """Evaluate all points on all threads."""
        rows = points.reshape(-1, self.dimension)
        n = len(rows)
        outputs = new_outputs(rows.shape, len(directions.V))
        engine = self._engine

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(directions)
            scratch.work.watch[0] = float(watch)
            self._kernels.carry_range(
                engine.system,
                engine.laws,
                rows,
                start,
                stop,
                scratch,
                self._controls,
                self._no_itinerary,
                outputs,
            )

        launch(task, n, self.threads, SMALLEST_TILE)
        return outputs

    def _itinerary(self, d: Floats) -> str:
        length = 64
        while True:
            modes = np.zeros((length, self.model.n_blocks), dtype=np.int8)
            _, n_events, _, _, _ = self._kernels.carry(
                self._engine.system,
                self._engine.laws,
                d,
                self._scratch(self._no_directions),
                self._controls,
                modes,
            )
            if n_events < length:
                return " ".join("".join(row) for row in MODES[modes[: n_events + 1] + 1])
            length = n_events + 1


@lru_cache(maxsize=64)
def _bound(engine: BlockEngine) -> ModuleType:
    return instantiate(
        "stickslip.mechanics.eventmap._blocks_kernels",
        engine.key,
        advance=engine.kernels.advance,
        landing_rate=engine.kernels.landing_rate,
        slides_for_ever=engine.kernels.slides_for_ever,
    )
