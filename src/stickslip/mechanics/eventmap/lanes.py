"""Many motions at once: in lanes under constant kinetic friction, in pools under other laws."""

from __future__ import annotations

import math
import threading
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.mechanics.eventmap.backend import NO_ITINERARY, ScalarBackend, held_for
from stickslip.mechanics.eventmap.records import (
    START,
    STATE,
    Asked,
    Controls,
    Models,
    Outputs,
    Pools,
    new_outputs,
)
from stickslip.mechanics.flow._lane_kernels import Change, CoulombConstants, Pair, constants_at
from stickslip.mechanics.flow.engine import Engine
from stickslip.mechanics.flow.lanes.layout import (
    ALIGNMENT,
    DAMP,
    DRIFT,
    HANDED_OVER,
    KEPT,
    LASTING,
    NUMBERS,
    ORDER,
    PLACES,
)
from stickslip.mechanics.flow.lanes.pair import coulomb_pair, pair_changes
from stickslip.mechanics.flow.lanes.steps import lane_kernels
from stickslip.mechanics.flow.system import ALPHA, BETA, LAWS, VELOCITY, new_motion
from stickslip.mechanics.friction.coulomb import is_constant
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.mechanics.friction.series import LawSeries, law_series
from stickslip.numerics.targets import config, instantiate, launch
from stickslip.numerics.vector import LANES
from stickslip.status import NEVER_CYCLE, OK

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    from numpy.typing import NDArray

    from stickslip.numerics.arrays import Floats, Ints


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
    from stickslip.mechanics.eventmap._lane_kernels import (
        BLOCK,
        CONSTANTS,
        N_LISTS,
        N_STREAMS,
        STRIDE,
    )

    streams = aligned((N_STREAMS + len(CONSTANTS)) * STRIDE)  # `evaluate` takes a fifth less
    # Once 16 MB were freed the C library keeps what is freed later, up to twice as much. Else the
    # system takes arrays of results back and clears new ones at each call: a tenth of slopes.
    np.empty(1 << 21)
    return LaneScratch(streams, np.zeros(N_LISTS * STRIDE, dtype=np.uint64), np.zeros(BLOCK))


def lanes_of(engine: Engine, max_events: int) -> Lanes:
    """Lanes for two equal blocks."""
    mu_1, mu_2 = engine.laws[:, STATIC_COLUMN].tolist()
    return Lanes(constants_at(*engine.system, mu_1, mu_2), None, max_events)


def change_along(engine: Engine, direction: Floats) -> Change:
    """Return the derivatives of what two blocks are made of, in a direction of the engine."""
    d_alpha, d_beta, d_V = direction[[ALPHA, BETA, VELOCITY]].tolist()
    d_mu_1, d_mu_2 = direction[LAWS :: engine.n_law_parameters].tolist()
    d_friction_2 = d_mu_2 * engine.system.beta + float(engine.laws[1, STATIC_COLUMN]) * d_beta
    return Change(d_alpha, d_V, d_mu_1, d_friction_2, d_beta)


def lanes_serve(controls: Controls) -> bool:
    """Whether values may come from lanes: they keep no time, and need vector instructions."""
    return controls.max_time == math.inf and not config.DISABLE_JIT


class Lanes:
    """What `_lane_kernels` need to know of a model, and scratch for each thread."""

    def __init__(self, constants: CoulombConstants, pair: Pair | None, max_events: int) -> None:
        from stickslip.mechanics.eventmap import _lane_list_kernels

        self.row, self.pair, self.max_events = np.array(constants), pair, max_events
        self._carry = _lane_list_kernels.carry_lanes

    def scratch(self) -> LaneScratch:
        """Arrays of the present thread."""
        held: LaneScratch | None = getattr(_LOCAL, "scratch", None)
        if held is None:
            held = _LOCAL.scratch = new_lane_scratch()
        return held

    def carry(
        self,
        points: Floats,
        slope: Floats,
        start: int,
        stop: int,
        along: Change | None = None,
        told: Outputs | None = None,
    ) -> None:
        """Put values in the place of starts: NaN to ask the exact engine, inf if none returns."""
        streams, index, _ = self.scratch()
        limit = self.max_events
        self._carry(
            self.row, self.pair, streams, index, points, slope, start, stop, limit, along, told
        )

    def value(self, d: float) -> float:
        """Value at one start inside the domain, or NaN, inf as above."""
        column = self.scratch().column
        column[0] = d
        self.carry(column, NO_SLOPE, 0, 1)
        return column.item(0)


LANE_TILE = 8192


class BatchBackend:
    """Many motions at once; the scalar backend carries what that declines, and tells the rest."""

    scalar: ScalarBackend | PoolBackend

    def __init__(self, scalar: ScalarBackend | PoolBackend) -> None:
        self.scalar = scalar
        self.name: str = scalar.name
        self.threads: int = scalar.threads

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        return self.scalar.parameter_slope(d, name)

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        return self.scalar.itinerary(d)


class LaneBackend(BatchBackend):
    """Constant kinetic friction: lanes, and another backend for what these decline."""

    # Which of them answers depends on d alone: not on how many are asked together, nor on threads.
    # Of unequal blocks lanes tell values and slopes alone.

    def __init__(self, scalar: ScalarBackend | PoolBackend, lanes: Lanes) -> None:
        super().__init__(scalar)
        self.lanes = lanes

    def value(self, d: float) -> float:
        """Value at one d."""
        value = self.lanes.value(d)
        if value == value:
            return value if value < math.inf else math.nan
        return self.scalar.value(d)

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        slopes = np.empty(d.size) if slope else NO_SLOPE
        outputs = new_outputs((0,), 0)
        if watch:  # room for what lanes tell, or who carries what they passed on
            rooms: Any = (np.zeros(d.size, each.dtype) for each in outputs[2:])
            outputs = Outputs(*outputs[:2], *rooms)
        told = outputs if watch and self.lanes.pair is None else None
        values, passed = self._by_lanes(d, slopes, told=told)
        if watch:  # also why motions do not return
            passed = np.flatnonzero(np.isnan(values) | (told is None or told.margin < 0.0))
        outputs = outputs._replace(value=values, derivative=slopes[:, None])
        if passed.size > 0:
            served = ~np.isnan(values[passed])
            missed = slope and not served.all()
            exact = self.scalar.carry(d[passed], slope=missed, watch=watch)
            exact.value[served] = values[passed[served]]
            if missed:
                exact.derivative[served, 0] = slopes[passed[served]]
            for kept, found in zip(outputs, exact, strict=True):
                if kept.size > 0 and found.size > 0:
                    kept[passed] = found
        return outputs

    def _by_lanes(
        self,
        d: Floats,
        slopes: Floats,
        along: Change | None = None,
        told: Outputs | None = None,
    ) -> tuple[Floats, NDArray[np.intp]]:
        """Values and, if there is room, slopes; indices that the lanes passed on."""
        values = np.empty(d.size)
        passed: list[NDArray[np.intp]] = []

        def task(start: int, stop: int) -> None:
            part = values[start:stop]
            part[:] = d[start:stop]
            self.lanes.carry(values, slopes, start, stop, along, told)
            rest = np.flatnonzero(~np.isfinite(part))
            unknown = np.isnan(part[rest])
            part[rest] = math.nan
            passed.append(start + rest[unknown])

        launch(task, d.size, self.threads, LANE_TILE)
        return values, np.concatenate(passed)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""
        for k in range(orbits.shape[1] - 1):
            alive = ~np.isnan(orbits[:, k])
            orbits[:, k + 1] = math.nan
            orbits[alive, k + 1] = self.carry(orbits[alive, k]).value


class EqualLaneBackend(LaneBackend):
    """Two equal blocks: the exact engine carries what lanes decline, on the way of an orbit too."""

    scalar: ScalarBackend

    def __init__(self, scalar: ScalarBackend) -> None:
        super().__init__(scalar, lanes_of(scalar.engine, scalar.controls.max_events))

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        engine, slopes = self.scalar.engine, np.empty(d.size)
        along = change_along(engine, engine.along(self.scalar.model, name)[0])
        _, passed = self._by_lanes(d, slopes, along)
        if passed.size > 0:
            slopes[passed] = self.scalar.parameter_slope(d[passed], name)
        return slopes

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""

        def task(start: int, stop: int) -> None:
            lanes, scalar = self.lanes, self.scalar
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
                scalar.engine.system,
                scalar.engine.laws,
                scalar.scratch(scalar.no_directions),
                scalar.controls,
                NO_ITINERARY,
            )

        self.scalar.launch_orbits(task, orbits)

    @cached_property
    def _orbits(self) -> ModuleType:
        template = "stickslip.mechanics.eventmap._lane_follow_kernels"
        kernels, engine = self.scalar.kernels, self.scalar.engine
        bindings = {name: getattr(kernels, name) for name in ("carry_number", "value_tangent")}
        return instantiate(template, engine.key, **bindings)


def new_pools(n_columns: int, n_parameters: int, size: int) -> Pools:
    """Arrays of empty pools."""
    laws = aligned(6 * n_parameters * PLACES)
    return Pools(
        x=aligned(3 * KEPT).reshape(3, KEPT),
        numbers=aligned(3 * NUMBERS * PLACES).reshape(3, -1),
        laws=laws.reshape(3, 2, -1),
        models=np.full((3, PLACES), -1),
        taken=aligned(size),
        tags=np.zeros((3, PLACES, 4), dtype=np.int64),
        labels=np.zeros((3, PLACES), dtype=np.uint64),
        counts=np.zeros(3, dtype=np.int64),
        flagged=np.zeros(LANES + 1, dtype=np.int64),
        rows=np.zeros(LANES, dtype=np.int64),
        motion=new_motion(n_columns, 0),
        signal=np.zeros(ORDER + 1),
        reciprocals=1.0 / np.maximum(np.arange(ORDER + 2), 1),
    )


def aligned(size: int) -> Floats:
    """Zeros that begin where a vector of any machine may."""
    store = np.zeros(size + ALIGNMENT // 8)
    start = -store.ctypes.data % ALIGNMENT // 8
    return store[start : start + size]


POOL_TILE = 512
# Kernels of steps: what values and margins take, and what tangents do.
VALUES = ("step_one", "step_both", "turns_one", "turns_both")
TANGENTS = ("tangent_one", "tangent_both")


class PoolBackend(BatchBackend):
    """Two contacts with one formula for both: many motions at once, in pools.

    The scalar backend carries what pools hand over. Which of them does depends on the motion alone.
    """

    scalar: ScalarBackend

    def __init__(self, scalar: ScalarBackend, numbers: Floats, series: LawSeries) -> None:
        super().__init__(scalar)
        self.series, self.numbers = series, numbers
        self._models: dict[str | None, tuple[Floats, Floats, Floats]] = {}
        self.damped = bool(numbers[0, DAMP:DRIFT].any())

    def value(self, d: float) -> float:
        """Value at one d."""
        return float(self.carry(np.array([d])).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        return self._carried(d, START if slope else None, watch)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        absent = any(own in self.series.absent for _, own in self._owners(name))
        served = self._whole if absent else self
        return served._carried(d, name).derivative[:, 0]

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""
        self._advanced(orbits)

    @property
    def kin(self) -> Hashable:
        """What models have in common that may share pools."""
        code = self.scalar.engine.code
        return code.key, self.series.key, self.damped, self.scalar.controls

    def iterate_beside(self, others: Sequence[PoolBackend], orbits: Floats, of: Ints) -> Ints:
        """Fill rows that belong to models of one kin, each to ``others[of]``; say why they end."""
        return self._advanced(orbits, others=others, of=of).status

    def _carried(self, d: Floats, along: str | None, watch: bool = False) -> Outputs:
        orbits = np.empty((d.size, 2))
        orbits[:, 0], orbits[:, 1] = d, math.nan
        outputs = self._advanced(orbits, along, watch)
        return outputs._replace(value=orbits[:, 1])

    def _advanced(
        self,
        orbits: Floats,
        along: str | None = None,
        watch: bool = False,
        others: Sequence[PoolBackend] = (),
        of: Ints | None = None,
    ) -> Outputs:
        """Fill the rows of `orbits`; return what is known of their last motions."""
        scalar, outputs = self.scalar, new_outputs((len(orbits),), int(along is not None))
        filled = np.zeros(len(orbits), dtype=np.int64)
        asked = Asked(np.empty(len(orbits), dtype=np.int64), np.empty((len(orbits), STATE)))
        asked.step.fill(-1)
        driver = self._changing_driver if along else self._driver
        owners = others or (self,)
        if of is None:
            of = np.zeros(len(orbits), dtype=np.int64)
        laws, rows, numbers = self._model(along)
        if others:
            parts = zip(*(each._model(along) for each in others), strict=True)
            laws, rows, numbers = map(np.concatenate, parts)
        models = Models(laws, rows, numbers, of)

        def task(start: int, stop: int) -> None:
            driver.advance_orbits(
                models,
                orbits,
                filled,
                start,
                stop,
                self.pools(along),
                scalar.controls,
                watch,
                outputs,
                asked,
            )

        steps = max(1, orbits.shape[1] - 1)
        while True:
            launch(task, len(orbits), self.threads, max(LANES, POOL_TILE // steps))
            if not np.count_nonzero(outputs.status < OK):  # nearly always
                return outputs
            lasting, handed = ((outputs.status == s).nonzero()[0] for s in (LASTING, HANDED_OVER))
            for number in set(of[handed].tolist()):
                own = handed[of[handed] == number]
                starts = orbits[own, filled[own]]
                carried = owners[number].scalar.carry_along(starts, along, watch)
                for kept, found in zip(outputs, carried, strict=True):
                    kept[own] = found
            for number in set(of[lasting].tolist()):
                own = lasting[of[lasting] == number]
                never = owners[number]._never_return(own, asked, outputs, watch)
                handed = np.append(handed, never)
            filled[handed] += 1
            orbits[handed, filled[handed]] = outputs.value[handed]

    def _never_return(self, rows: Ints, asked: Asked, outputs: Outputs, watch: bool) -> Ints:
        """Return which motions that seem to last do so; the others begin again."""
        told = self.scalar.go_on(asked.state[rows], watch)
        never = told.status == NEVER_CYCLE
        rows = rows[never]
        outputs.status[rows] = NEVER_CYCLE
        outputs.value[rows], outputs.derivative[rows] = math.nan, math.nan
        outputs.duration[rows] += told.duration[never]
        outputs.n_events[rows] += told.n_events[never]
        outputs.margin[rows] = np.minimum(outputs.margin[rows], told.margin[never])
        return rows

    @property
    def lanes(self) -> Lanes | None:
        """Closed forms of these motions, if the friction is constant and no block is unloaded."""
        laws, plant = self.scalar.model.laws, self.scalar.model.plant
        if not all(map(is_constant, laws)):
            return None
        mu = self.scalar.engine.laws[:, STATIC_COLUMN].tolist()
        found = coulomb_pair(plant, self.numbers[0], mu)
        return found and Lanes(*found, self.scalar.controls.max_events)

    @cached_property
    def _whole(self) -> PoolBackend:
        """The same with all parameters of the law, those that are zero too."""
        series = law_series(self.scalar.model.laws, whole=True)
        assert series is not None
        return PoolBackend(self.scalar, self.numbers, series)

    @cached_property
    def _steps(self) -> ModuleType:
        return lane_kernels(self.series, damped=self.damped)

    @cached_property
    def _driver(self) -> ModuleType:
        """Kernels bound to the law and its steps, for slopes."""
        return self._driver_with(self._steps, changing=False)

    @cached_property
    def _changing_driver(self) -> ModuleType:
        """The same for derivatives in parameters."""
        return self._driver_with(
            lane_kernels(self.series, damped=True, changing=True), changing=True
        )

    def _driver_with(self, tangents: ModuleType, *, changing: bool) -> ModuleType:
        code = self.scalar.engine.code
        return instantiate(
            "stickslip.mechanics.eventmap._pool_kernels",
            f"{code.key}-{self.series.key}-{LANES}-{self.damped}" + "-changing" * changing,
            force=code.force,
            CHANGING=changing,
            TELLS=self.series.tells,
            **{name: getattr(self._steps, name) for name in VALUES},
            **{name: getattr(tangents, name) for name in TANGENTS},
        )

    def _model(self, along: str | None) -> tuple[Floats, Floats, Floats]:
        """Numbers of this model (`Models`); `along`: what tangents go with."""
        known = self._models
        if along not in known:
            model = self.scalar.model
            changing: list[str | None] = [None, None]
            for block, own_name in self._owners(along):
                changing[block] = own_name
            numbers = self.numbers
            if along in model.numbers:
                numbers = numbers + pair_changes(model.moved_plant(along))
            rows = self.series.rows(model.laws, changing)
            known[along] = self.scalar.engine.laws[None], rows[None], numbers[None]
        return known[along]

    def _owners(self, along: str | None) -> tuple[tuple[int, str], ...]:
        """Blocks, and names in their laws, that what tangents go with belongs to."""
        model = self.scalar.model
        if not along or along in model.numbers:
            return ()
        return model.law_parameters[along]

    def pools(self, along: str | None) -> Pools:
        """Pools for this thread."""
        held: dict[tuple[int, int], Pools] = self._local.__dict__.setdefault("pools", {})
        key = int(along is not None), self._model(along)[1].shape[2]
        if key not in held:
            held[key] = new_pools(*key, self._steps.SIZE)
        return held[key]

    @cached_property
    def _local(self) -> threading.local:
        return held_for(self.series.key)
