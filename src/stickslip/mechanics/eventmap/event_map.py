"""The event map (eqs. 11-12): from the d of one global stick phase to the d of the next."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any, ClassVar, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.analysis.maps.derived import LineMap
from stickslip.checks import (
    MOST_STEPS,
    Many,
    finite_number,
    instance,
    one_each,
    one_of,
    parameter_name,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.mechanics.eventmap.backend import Backend, ScalarBackend
from stickslip.mechanics.eventmap.lanes import (
    EqualLaneBackend,
    LaneBackend,
    PoolBackend,
    lanes_serve,
)
from stickslip.mechanics.eventmap.records import Controls
from stickslip.mechanics.eventmap.result import EventMapResult
from stickslip.mechanics.flow.engine import (
    EngineName,
    block_engine,
    engine_for,
    time_limit,
    tolerance,
)
from stickslip.mechanics.flow.lanes.pair import pair_numbers
from stickslip.mechanics.friction.series import law_series
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats, Ints
from stickslip.numerics.targets import available_threads
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Hashable, Sequence

    from stickslip.analysis.maps.protocol import Mechanism
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.mechanics.model.arguments import Model


class ModelMap:
    """A map of a model's motions; equal models and settings compare equal.

    A point is a number or, where the map has more dimensions, an array of them. Arrays of points
    have any shape before that.
    """

    model: Any
    _low: float = math.inf  # ends of the domain, if it is an interval
    _high: float = -math.inf
    _settings: ClassVar[tuple[str, ...]]
    _backend: Backend

    def __init__(
        self, model: Any, *, rtol: float, max_events: int, max_time: float, threads: int | None
    ) -> None:
        self.model = model
        self.rtol = tolerance(rtol)
        self.max_events = whole_number("max_events", max_events, what="events of one motion")
        self.max_time = time_limit(max_time)
        self.threads = (
            available_threads()
            if threads is None
            else whole_number("threads", threads, what="processor cores used")
        )
        self._backend = self._backend_of(Controls(self.rtol, self.max_events, self.max_time))

    def _backend_of(self, controls: Controls) -> Backend:
        raise NotImplementedError

    @property
    def _cell(self) -> tuple[int, ...]:
        """Shape of a point."""
        return () if self.dimension == 1 else (self.dimension,)

    def _admit(self, d: ArrayLike) -> Floats:
        """Return points of the domain; ValueError names the first outside."""
        points: Floats = self.model.admit(d)
        return points

    # --- what it is -----------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        """Numbers in a point."""
        raise NotImplementedError

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model by name."""
        return dict(self.model.parameters)

    @property
    def settings(self) -> dict[str, Any]:
        """Keyword arguments that make this map from its model."""
        return {name: getattr(self, name) for name in self._settings}

    def replace(self, **changes: Any) -> Self:
        """Make the map of a changed model, with the same settings."""
        return type(self)(self.model.replace(**changes), **self.settings)

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel to other processes as model and settings: compiled functions stay behind."""
        return functools.partial(type(self), self.model, **self.settings), ()

    def __eq__(self, other: object) -> bool:
        """Equal models and settings."""
        if not isinstance(other, ModelMap) or type(self) is not type(other):
            return NotImplemented
        return bool((self.model, self.settings) == (other.model, other.settings))

    def __hash__(self) -> int:
        """Hash of the model and the settings."""
        return hash((self.model, *self.settings.values()))

    def __repr__(self) -> str:
        """One line."""
        return f"{type(self).__name__}({self.model!r}, engine={self._backend.name!r})"

    # --- values ---------------------------------------------------------------------------

    def _admitted(self, d: ArrayLike) -> tuple[Floats, Floats]:
        """Return points of the domain as given, and as rows for the backend."""
        points = self._admit(d)
        return points, points.reshape(-1, *self._cell)

    @overload
    def __call__(self, d: float) -> float: ...
    @overload
    def __call__(self, d: Many) -> Floats: ...
    @overload
    def __call__(self, d: ArrayLike) -> float | Floats: ...
    def __call__(self, d: ArrayLike) -> float | Floats:
        """Value of the map.

        Parameters
        ----------
        d : array_like of float, any shape; of N > 2 blocks (..., N - 1)
            ``X_{i+1} - X_i`` of global stick phases, units of f_s1 / k, inside the domain.

        Returns
        -------
        float or ndarray shaped like ``d``
            NaN where the motion does not return to global stick.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or belongs to no global stick phase.
        """
        if isinstance(d, float) and self._low <= d <= self._high:
            return self._backend.value(d)
        points, rows = self._admitted(d)
        return _shaped(self._backend.carry(rows).value, points.shape)

    @overload
    def derivative(self, d: float) -> float: ...
    @overload
    def derivative(self, d: Many) -> Floats: ...
    @overload
    def derivative(self, d: ArrayLike) -> float | Floats: ...
    def derivative(self, d: ArrayLike) -> float | Floats:
        """Slope df/dd, exact (saltation at every event), one-sided at a breakpoint.

        Arguments and errors as for calling the map, and shape on the line. Of N > 2 blocks the
        Jacobian, shape (..., N - 1, N - 1): entry (i, j) is that of value i in d_j.
        """
        return self.value_and_derivative(d)[1]

    @overload
    def value_and_derivative(self, d: float) -> tuple[float, float]: ...
    @overload
    def value_and_derivative(self, d: Many) -> tuple[Floats, Floats]: ...
    @overload
    def value_and_derivative(self, d: ArrayLike) -> tuple[float | Floats, float | Floats]: ...
    def value_and_derivative(self, d: ArrayLike) -> tuple[float | Floats, float | Floats]:
        """Value and slope at once, without what `evaluate` tells besides, and sooner.

        Arguments, shapes and errors as for calling the map and its `derivative`.
        """
        points, rows = self._admitted(d)
        found = self._backend.carry(rows, slope=True)
        slopes = points.shape + self._cell
        return _shaped(found.value, points.shape), _shaped(found.derivative, slopes)

    @overload
    def parameter_derivative(self, d: float, name: str) -> float: ...
    @overload
    def parameter_derivative(self, d: Many, name: str) -> Floats: ...
    @overload
    def parameter_derivative(self, d: ArrayLike, name: str) -> float | Floats: ...
    def parameter_derivative(self, d: ArrayLike, name: str) -> float | Floats:
        """df/d(name) at fixed ``d``, exact; `name` as in ``model.parameters``.

        Arguments, shape and errors as for calling the map; ValueError for an unknown name.
        """
        points, rows = self._admitted(d)
        if type(name) is not str or name not in self.model.numbers:  # all are slow to gather
            parameter_name("name", name, self.parameters, of="the model")
        return _shaped(self._backend.parameter_slope(rows, name), points.shape)

    def evaluate(self, d: ArrayLike) -> EventMapResult:
        """Carry relative displacements to the next global stick phase, and tell how.

        Parameters
        ----------
        d : array_like of float, any shape; of N > 2 blocks (..., N - 1)
            ``X_{i+1} - X_i`` in units of f_s1 / k, inside the domain.

        Returns
        -------
        EventMapResult
            Fields with an entry for each point; ``value`` is shaped like ``d``.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or belongs to no global stick phase.

        Notes
        -----
        Galvanetto (2001), eqs. (11)-(12). Exact engine: error near rounding. Adaptive
        engine: error set by ``rtol``. How events are proved: docs/theory/flow.md.

        Examples
        --------
        >>> import stickslip as ss
        >>> f = ss.event_map(ss.examples.coulomb())
        >>> f.evaluate([-0.2, 0.1]).value.shape
        (2,)
        """
        points, rows = self._admitted(d)
        outputs = self._backend.carry(rows, slope=True, watch=True)
        cell = self._cell
        one_each = points.shape[: points.ndim - len(cell)]
        shapes = points.shape, points.shape + cell, *[one_each] * (len(outputs) - 2)
        told: list[Any] = [a.reshape(to)[()] for a, to in zip(outputs, shapes, strict=True)]
        told.append(points)
        return EventMapResult(*told)

    @overload
    def itinerary(self, d: float) -> str: ...
    @overload
    def itinerary(self, d: Many) -> NDArray[np.str_]: ...
    @overload
    def itinerary(self, d: ArrayLike) -> str | NDArray[np.str_]: ...
    def itinerary(self, d: ArrayLike) -> str | NDArray[np.str_]:
        """Modes of all blocks from the onset to the next global stick, as text.

        Returns
        -------
        str or ndarray of str, one for each point
            ``"-. -- .- .."``: one character per block and phase (``.`` stick, ``-`` backward,
            ``+`` forward). A motion without return ends with its last phase.
        """
        if isinstance(d, float) and self._low <= d <= self._high:
            return self._backend.itinerary(d)
        points, rows = self._admitted(d)
        texts = [self._backend.itinerary(row) for row in rows.tolist()]
        shape = points.shape[: points.ndim - len(self._cell)]
        return np.array(texts).reshape(shape) if shape else texts[0]

    def slip_from(self, d: Any, max_events: int) -> Trajectory:
        """Follow the motion from a point to the next one."""
        raise NotImplementedError

    def explain_border(self, d: ArrayLike, other: Self, beyond: ArrayLike) -> Mechanism:
        """Return why motions from a point and one close by differ, of a map with other numbers."""
        from stickslip.mechanics.eventmap.mechanism import MAX_EVENTS, difference_of  # seldom asked

        return difference_of(self.slip_from(d, MAX_EVENTS), other.slip_from(beyond, MAX_EVENTS))

    def iterate(self, d: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times, keeping every point.

        Parameters
        ----------
        d : array_like of float, any shape; of N > 2 blocks (..., N - 1)
            Starting points inside the domain.
        n : int
            Number of applications, >= 0.

        Returns
        -------
        ndarray of float, shape (..., n + 1); of N > 2 blocks (..., n + 1, N - 1)
            ``[..., 0]`` is ``d``; after a motion without return NaN stays NaN.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or outside the domain; ``n`` is negative.
        """
        n = whole_number("n", n, 0, at_most=MOST_STEPS, what="applications of the map")
        points, rows = self._admitted(d)
        cell = self._cell
        orbits = np.empty((len(rows), n + 1, *cell))
        orbits[:, 0] = rows
        self._backend.iterate(orbits)
        return orbits.reshape(*points.shape[: points.ndim - len(cell)], n + 1, *cell)


def _shaped(values: Floats, shape: tuple[int, ...]) -> float | Floats:
    return values.item() if shape == () else values.reshape(shape)


class GlobalStickMap(ModelMap):
    """From one global stick phase to the next: a point d holds the differences of neighbours."""

    _settings: ClassVar = ("rtol", "max_events", "max_time", "engine", "device", "threads")

    def __init__(
        self,
        model: Any,
        *,
        rtol: float = 1e-15,
        max_events: int = 10_000,
        max_time: float = math.inf,
        engine: EngineName = "auto",
        device: str = "cpu",
        threads: int | None = None,
    ) -> None:
        if model.plant.n_waves:
            raise ValueError(
                "a forced model has no event map: what a global stick phase leads to depends on "
                "its time as well. Take stickslip.stroboscopic_map(model) or "
                "stickslip.return_map(model)."
            )
        if not model.plant.rubs_as_one:
            raise ValueError(
                f"model = {shown(model)} has no event map: not every mass rubs on one moving belt, "
                "so that global stick phases leave more than differences open. Take "
                "stickslip.return_map(model), or follow it in time."
            )
        if model.n_blocks < 2:
            raise ValueError(
                f"the event map of {model.n_blocks} block has no differences d to map: two blocks "
                "or more are needed. stickslip.simulate follows the block in time."
            )
        self.engine: EngineName = engine
        self.device = device
        super().__init__(
            model, rtol=rtol, max_events=max_events, max_time=max_time, threads=threads
        )
        if model.n_blocks == 2:
            self._low, self._high = model.domain

    def _backend_of(self, controls: Controls) -> Backend:
        return backend_for(self.model, self.engine, controls, self.device, self.threads)

    @property
    def dimension(self) -> int:
        """Numbers in a point d: one less than blocks."""
        n: int = self.model.n_blocks
        return n - 1

    @property
    def n_impulses(self) -> int:
        """Velocities that may jump: one of each block."""
        return self.dimension + 1

    def after_impulse(self, d: ArrayLike, block: int, by: float) -> float | Floats:
        """Return where the blocks next stick after a jump of one's velocity as global stick ends.

        Parameters
        ----------
        d : float, or array_like of float, shape (n_blocks - 1,)
            The global stick phase at whose end the velocity jumps.
        block : int
            From 1.
        by : float
            Change of the block's velocity, units of f_s1 / sqrt(k m); 0 gives f(d).

        Returns
        -------
        float or ndarray
            A point as `d`; NaN if the blocks do not all stick again.

        Raises
        ------
        ValueError
            `d` lies outside the domain, there is no such block, or `by` is not finite.
        """
        from stickslip.mechanics.flow.trajectory import simulate  # not for the first value

        number = whole_number("block", block, at_most=self.n_impulses)
        limits: Any = {"max_events": self.max_events, "engine": self.engine, "rtol": self.rtol}
        given = real_numbers("d", d)
        if given.shape != self._cell:
            raise ValueError(f"d = {shown(d)} is not one point: its shape must be {self._cell}.")
        point = given.tolist()
        start = simulate(self.model, d=point, t_end=0.0, **limits).final_state
        v = start.v.copy()
        v[number - 1] += finite_number("by", by)
        state = {"d": point} if by == 0.0 else {"x": start.x, "v": v}
        moved = simulate(self.model, **state, until="stick", record="events", **limits)
        stuck = moved.status == OK and moved.t[-1] <= self.max_time
        landed = moved.d[-1] if stuck else np.full(np.shape(point), np.nan)
        return _shaped(np.asarray(landed), given.shape)

    def slip_from(self, d: Any, max_events: int) -> Trajectory:
        """Follow the motion, with the map's displacements, modes and forces, to the next stick."""
        from stickslip.mechanics.flow.trajectory import simulate  # not for the first value

        return simulate(self.model, d=d, until="stick", max_events=max_events, engine=self.engine)


class EventMap(GlobalStickMap, LineMap):
    """The event map of two blocks, a map of the line; `stickslip.event_map` makes it.

    Calling it carries relative displacements from one global stick phase to the next:
    ``f(d)`` for a float or an array of any shape. Immutable; equal settings compare equal.
    """

    @property
    def domain(self) -> tuple[float, float]:
        """Ends of the interval of definition: the global stick locus, projected on d."""
        return self._low, self._high

    @property
    def searched(self) -> dict[str, dict[str, float]]:
        """Ranges of parameters in which bifurcations are searched for, as for `finite_number`."""
        # In units of block 1 and the slowest mode.
        s = self.model.plant
        slowest = math.sqrt(np.linalg.eigvals(s.stiffness / s.mass[:, None]).real.min())
        impedance = float(slowest * s.mass[0])
        speed, damper = (float(f"{x:.6g}") for x in (10 * s.static[0] / impedance, 50 * impedance))
        dampers = [name for name in self.parameters if name.startswith("damping_")]
        return {
            "alpha": {"at_least": 0.0, "at_most": 1e6},
            "V": {"above": 0.0, "at_most": speed},
            "damping": {"at_least": 0.0, "at_most": damper},
            **{name: {"at_least": -damper, "at_most": damper} for name in dampers},
        }

    def explain_break(self, left: float, right: float) -> Mechanism:
        """Return why the map breaks between two starting points, adjacent floats."""
        from stickslip.mechanics.eventmap.mechanism import mechanism_between  # seldom asked

        return mechanism_between(self, left, right)

    @property
    def kin(self) -> Hashable | None:
        """What maps have in common that `iterate_each` takes side by side; None for others."""
        return getattr(self._backend, "kin", None)

    @staticmethod
    def iterate_each(maps: Sequence[EventMap], starts: Sequence[ArrayLike], n: int) -> list[Floats]:
        """Iterate points of several maps, side by side where models differ in numbers only.

        Parameters
        ----------
        maps : sequence of event maps
            As many as there are ``starts``.
        starts : sequence of array_like of float
            For each map points as ``iterate`` takes them.
        n : int
            Number of applications, >= 0.

        Returns
        -------
        list of ndarray of float
            For each map what its ``iterate`` returns, to the last bit.

        Raises
        ------
        ValueError
            As ``iterate``; there is no map, or not as many ``starts`` as ``maps``.
        """
        return [orbits for orbits, _ in EventMap.follow_each(maps, starts, n)]

    @staticmethod
    def follow_each(
        maps: Sequence[EventMap], starts: Sequence[ArrayLike], n: int
    ) -> list[tuple[Floats, Ints | None]]:
        """Return the orbits of `iterate_each`, and why they ended, or None where nobody knows."""
        n = whole_number("n", n, 0, at_most=MOST_STEPS, what="applications of the maps")
        what = "a list or tuple of event maps of two blocks"
        if not instance("maps", maps, (list, tuple), what):
            raise ValueError("maps is empty: give one event map or more.")
        for k, f in enumerate(maps):
            instance(f"maps[{k}]", f, EventMap, "an event map of two blocks")
        points = []
        for k, d in enumerate(one_each("starts", starts, len(maps), "map")):
            try:
                points.append(maps[k]._admit(d))
            except ValueError as error:
                raise ValueError(f"starts[{k}]: {error}") from None
        families: dict[Hashable, list[int]] = {}
        for k, f in enumerate(maps):
            families.setdefault(k if f.kin is None else f.kin, []).append(k)
        found: dict[int, tuple[Floats, Ints | None]] = {}
        for members in families.values():
            if maps[members[0]].kin is None:
                found |= {k: (maps[k].iterate(points[k], n), None) for k in members}
                continue
            sizes = [points[k].size for k in members]
            orbits = np.empty((sum(sizes), n + 1))
            orbits[:, 0] = np.concatenate([points[k].ravel() for k in members])
            pools: list[Any] = [maps[k]._backend for k in members]
            of = np.repeat(np.arange(len(pools)), sizes)
            status = pools[0].iterate_beside(pools, orbits, of)
            parts = (np.split(each, np.cumsum(sizes)[:-1]) for each in (orbits, status))
            for k, own, why in zip(members, *parts, strict=True):
                shape = points[k].shape
                found[k] = own.reshape(*shape, n + 1), why.reshape(shape)
        return [found[k] for k in range(len(maps))]


class BlocksEventMap(GlobalStickMap):
    """The event map of more than two blocks, a map of R^n; `stickslip.event_map` makes it.

    Calling it carries differences ``d_i = X_{i+1} - X_i`` from one global stick phase to the
    next: ``f(d)`` for arrays of shape (..., n_blocks - 1). Immutable; equal settings compare
    equal.
    """

    def contains(self, d: ArrayLike) -> NDArray[np.bool_]:
        """Whether ``d`` (..., n_blocks - 1) belongs to a global stick phase; False for NaN."""
        inside: NDArray[np.bool_] = self.model.contains(d)
        return inside

    def spread(self, n: int) -> Floats:
        """Return n points spread evenly over the domain, always the same."""
        points: Floats = self.model.spread_domain(n)
        return points


DEVICES = ("cpu", "cuda")


def backend_for(
    model: Model, engine: EngineName, controls: Controls, device: str, threads: int
) -> Backend:
    """Choose what carries the motions of a model; ValueError if the device cannot."""
    if one_of("device", device, DEVICES) == "cuda":
        from stickslip.mechanics.eventmap.cuda import CudaBackend  # needs numba-cuda

        return CudaBackend(model, engine, controls)
    if isinstance(model, TwoBlock) and model.damping == 0.0:
        scalar = ScalarBackend(model, engine_for(model, engine), controls, threads)
        if scalar.engine.name == "exact" and lanes_serve(controls):
            return EqualLaneBackend(scalar)
    else:
        scalar = ScalarBackend(model, block_engine(model, engine), controls, threads)
    if scalar.name in ("taylor", "series"):
        numbers, series = pair_numbers(model.plant), law_series(model.laws)
        if numbers is not None and series is not None:
            pools = PoolBackend(scalar, numbers, series)
            lanes = pools.lanes if engine == "auto" and lanes_serve(controls) else None
            return LaneBackend(pools, lanes) if lanes else pools
    return scalar
