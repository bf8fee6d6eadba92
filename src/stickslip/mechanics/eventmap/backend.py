"""What carries motions from one point to the next: kernels, threads, scratch."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from functools import cached_property, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from stickslip.mechanics.eventmap.itinerary import itinerary_text
from stickslip.mechanics.eventmap.loop import new_loop
from stickslip.mechanics.eventmap.records import (
    LONG,
    START,
    Controls,
    Outputs,
    Scratch,
    global_stick,
    new_outputs,
)
from stickslip.mechanics.flow.engine import BlockEngine, Engine
from stickslip.numerics.targets import instantiate, launch
from stickslip.status import EVENT_LIMIT, TIME_LIMIT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Section
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats


# Fewer motions than this are not worth a thread.
SMALLEST_TILE = {"exact": 4000, "taylor": 64, "series": 64, "collocation": 16}
NO_ITINERARY = np.zeros((0, 2), dtype=np.int8)
NO_TRAPS = np.zeros((0, 0))


class Backend(Protocol):
    """Carries motions of a model from start to value; points are (n,), or (n, numbers) in R^n."""

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
    """One motion at a time; points (n,) or, of more than one number, (n, numbers)."""

    has_traps: ClassVar = True  # two blocks: motions are those of the model

    def __init__(
        self, model: Model, engine: Engine | BlockEngine, controls: Controls, threads: int
    ) -> None:
        self.model, self.controls, self.threads = model, controls, threads
        self.engine: Any = engine
        self.name: str = engine.name
        self._local = held_for(engine.key) if engine.is_pair else threading.local()
        self._no_itinerary = np.zeros((0, model.n_blocks), dtype=np.int8)

    def value(self, d: float) -> float:
        """Value at one d of two blocks."""
        return float(self.carry(np.array([d])).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        return self._carried(d, self._start_directions if slope else self.no_directions, watch)

    def carry_along(self, d: Floats, along: str | None, watch: bool = False) -> Outputs:
        """Values and derivatives in a parameter, or in the `START`; None: values alone."""
        if not along:
            return self.carry(d, slope=along == START, watch=watch)
        directions = self.engine.along(self.model, along)
        return self._carried(d, directions, watch, self._section_along(along))

    def go_on(self, states: Floats, watch: bool) -> Outputs:
        """Follow motions of two blocks from states (n, STATE) until it is told if they return."""
        outputs = self.room(len(states))
        self.run(states, outputs, watch=watch, first=LONG // 4, most=LONG)
        return outputs

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        return self.carry_along(d, name).derivative[..., 0]

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1, ...) from their first entries on."""
        points = orbits.reshape(*orbits.shape[:2], self._dimension)
        outputs = self.room(len(points), points.shape[1] - 1)
        self.run(points[:, 0].copy(), outputs)
        points[:, 1:] = outputs.value

    def launch_orbits(self, task: Callable[[int, int], None], orbits: Floats) -> None:
        """Run a task over rows of `orbits` in threads."""
        self._launch(task, len(orbits), orbits.shape[1] - 1)

    def _launch(self, task: Callable[[int, int], None], n: int, steps: int) -> None:
        launch(task, n, self.threads, max(1, SMALLEST_TILE[self.name] // max(1, steps)))

    def itinerary(self, d: float | list[float]) -> str:
        """Modes of each phase, as text."""
        length, held = 64, self._local.__dict__
        outputs: Outputs | None = held.get("told")
        if outputs is None:
            outputs = held["told"] = self.room(1)
        while True:
            modes = np.zeros((length, self.model.n_blocks), dtype=np.int8)
            self.run(np.array(d, ndmin=2), outputs, itinerary=modes)
            n_events = int(outputs.n_events[0])
            if n_events < length:
                return itinerary_text(modes[: n_events + 1])
            length = n_events + 1

    # --- where motions start and end ---------------------------------------------------------

    @property
    def _dimension(self) -> int:
        """Numbers of a point."""
        return self.model.n_blocks - 1

    @cached_property
    def _section(self) -> Any:
        return NO_TRAPS if self.engine.is_pair else global_stick(self._dimension)

    def _section_along(self, _name: str) -> Any:
        """Return the section with its change with a parameter: differences have none."""
        return self._section

    # --- kernels --------------------------------------------------------------------------

    @cached_property
    def kernels(self) -> ModuleType:
        """The kernels with this engine bound into them."""
        return driver(self.engine)

    @cached_property
    def no_directions(self) -> Any:
        """For motions without tangents."""
        return self.engine.directions()

    @cached_property
    def _start_directions(self) -> Any:
        return self.engine.directions(np.eye(self._dimension))

    def scratch(self, directions: Any, section: Any = None) -> Scratch:
        """Work arrays for this thread, with a tangent column for each direction."""
        section = self._section if section is None else section
        held: dict[int, Scratch] = self._local.__dict__.setdefault("scratch", {})
        count = len(self.engine.columns(directions))
        scratch = held.get(count)
        if scratch is None or scratch.motion.directions is not directions:
            scratch = held[count] = new_scratch(self.engine, directions, section, scratch)
        elif scratch.section is not section:
            scratch = held[count] = scratch._replace(section=section)
        return scratch

    def _carried(
        self, d: Floats, directions: Any, watch: bool = False, section: Section | None = None
    ) -> Outputs:
        """Evaluate all points on all threads."""
        count = len(self.engine.columns(directions))
        outputs = new_outputs(d.shape, count)
        rows = (len(d), self._dimension)
        # The same numbers, with axes for steps and for the differences that two blocks have one of.
        told = outputs._replace(
            value=outputs.value.reshape(len(d), 1, self._dimension),
            derivative=outputs.derivative.reshape(*rows, count),
        )
        self.run(d.reshape(rows), told, directions, watch, section)
        return outputs

    def room(self, n: int, steps: int = 1) -> Outputs:
        """Room for what n motions of some steps leave, without tangents."""
        value = np.full((n, steps, self._dimension), np.nan)
        return new_outputs((n, self._dimension), 0)._replace(value=value)

    def run(
        self,
        points: Floats,
        outputs: Outputs,
        directions: Any = None,
        watch: bool = False,
        section: Section | None = None,
        itinerary: NDArray[np.int8] | None = None,
        first: int = LONG,
        most: int | None = None,
    ) -> None:
        """Carry all points; after `first` events they are asked if they have come into a trap."""
        most, most_time = most or self.controls.max_events, self.controls.max_time
        first = min(most, first) if self.has_traps and self.engine.is_pair else most
        task = self.task(points, outputs, first, directions, watch, section, itinerary)
        self._launch(task, len(points), outputs.value.shape[1])
        if first == most or not np.count_nonzero(outputs.status):
            return
        # Steps without an event are counted, too: EVENT_LIMIT, or TIME_LIMIT before the time.
        late = (outputs.status == EVENT_LIMIT) & (outputs.n_events < most)
        late |= (outputs.status == TIME_LIMIT) & (outputs.duration <= most_time)
        (rows,) = late.nonzero()
        if rows.size == 0:
            return
        from stickslip.mechanics.eventmap.traps import traps_of  # seldom asked

        traps = traps_of(self.model, self.name, self.controls.rtol)
        task = self.task(points, outputs, most, directions, watch, traps, itinerary)

        def again(start: int, stop: int) -> None:
            for row in rows[start:stop].tolist():
                task(row, row + 1)

        self._launch(again, rows.size, 1)

    def task(
        self,
        points: Floats,
        outputs: Outputs,
        max_events: int,
        directions: Any = None,
        watch: bool = False,
        section: Any = None,
        itinerary: NDArray[np.int8] | None = None,
    ) -> Callable[[int, int], None]:
        """Return what carries ``points[start:stop]``, in any thread."""
        engine, modes = self.engine, self._no_itinerary if itinerary is None else itinerary
        ways = self.no_directions if directions is None else directions
        controls = self.controls._replace(max_events=max_events)

        def carry(start: int, stop: int) -> None:
            scratch = self.scratch(ways, section)
            scratch.work.watch[0] = float(watch)
            self.kernels.carry_range(
                *(engine.system, engine.laws, points, start, stop, scratch, controls),
                *(modes, outputs),
            )

        return carry


@lru_cache(maxsize=32)
def held_for(*_users: Hashable) -> threading.local:
    """Work arrays of each thread, up to a quarter of a megabyte: maps beside each other share."""
    return threading.local()


def new_scratch(
    engine: Any,
    directions: Any,
    section: Section | None = None,
    like: Scratch | None = None,
) -> Scratch:
    """Work arrays of one motion with a tangent for each direction; those of `like` serve again."""
    n = engine.n_states
    longer, none = engine.widened(directions, n), engine.directions()
    if like is not None:
        return like._replace(
            motion=like.motion._replace(directions=directions),
            long_motion=like.long_motion._replace(directions=longer),
            section=section,
        )
    return Scratch(
        engine.new_motion(directions),
        engine.new_motion(longer),
        engine.new_motion(none),
        engine.new_motion(engine.widened(none, n)),
        engine.new_motion(none),
        new_loop(n),
        engine.new_work(),
        section,
        np.zeros(1),
    )


def scratch_of(engine: Engine, n_columns: int) -> Scratch:
    """Work arrays of a motion of two blocks, with the tangent in its start or with none."""
    return new_scratch(engine, engine.directions(np.eye(n_columns, 1)))


STEPPER = ("advance", "landing_rate", "slides_for_ever")
ENDS = (
    *("begin", "change_modes", "copy_rest", "event_margin", "has_arrived", "is_state"),
    *("is_trapped", "read_point", "read_tangent", "start_loop_tangent"),
)


def driver(engine: Any) -> ModuleType:
    """Kernels that carry motions by an engine: how they start and end, what they go through."""
    rooms, sections = "stickslip.mechanics.eventmap", not engine.is_pair
    stepper = {name: getattr(engine.kernels, name) for name in STEPPER}
    own = {"rate": engine.kernels.rate} if sections else {}
    ends = instantiate(
        f"{rooms}.{'_section_kernels' if sections else '_pair_kernels'}",
        engine.key,
        landing_rate=stepper.pop("landing_rate"),
        **own,
    )
    more = "slides_steadily" if sections else "value_tangent"
    bound = {name: getattr(ends, name) for name in (*ENDS, more)}
    return instantiate(
        f"{rooms}._kernels",
        engine.key,
        SECTIONS=sections,
        **stepper,
        **bound,
    )
