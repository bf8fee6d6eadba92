"""The event map (eqs. 11-12): from the d of one global stick phase to the d of the next."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import status as status_codes
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
from stickslip.mechanics.flow.settings import positive_integer, time_limit, tolerance
from stickslip.mechanics.flow.system import new_motion
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.targets import available_threads, launch

Floats = NDArray[np.float64]

# Fewer motions than this are not worth a thread.
SMALLEST_TILE = {"exact": 4000, "taylor": 64, "collocation": 16}


@dataclass(frozen=True)
class EventMapResult:
    """What `EventMap.evaluate` knows of each motion; every field is shaped like ``d``.

    Attributes
    ----------
    value : ndarray of float
        d of the next global stick phase, units of f_s1 / k; NaN where there is none.
    derivative : ndarray of float
        Slope of the map, one-sided at a breakpoint.
    duration : ndarray of float
        Time between the two phases, units of sqrt(m / k).
    n_events : ndarray of int
        Changes of mode after the onset, the return to global stick included.
    label : ndarray of uint64
        Hash of the itinerary: equal on a branch.
    margin : ndarray of float
        Smallest clearance of the motion from another itinerary, >= 0: of lobes of w that
        turned back, of riders' forces at their extremes, of landings from the static limit
        and from a touch (w'), and between consecutive events of different blocks.
    status : ndarray of int
        `stickslip.status`; anything but OK goes with a NaN value.
    """

    value: Floats
    derivative: Floats
    duration: Floats
    n_events: NDArray[np.int64]
    label: NDArray[np.uint64]
    margin: Floats
    status: NDArray[np.int64]

    @property
    def message(self) -> NDArray[np.str_]:
        """What each status means and what to do about it."""
        return np.asarray(status_codes.MESSAGES)[self.status]

    def __repr__(self) -> str:
        """Count the statuses, then show the first motions as a table."""
        statuses = np.atleast_1d(self.status).ravel()
        names, counts = np.unique(statuses, return_counts=True)
        lines = [
            "EventMapResult: "
            + ", ".join(f"{c} {status_codes.NAMES[n]}" for n, c in zip(names, counts, strict=True))
        ]
        lines.append("       value  derivative    duration  events    margin")
        columns = (self.value, self.derivative, self.duration, self.n_events, self.margin)
        rows = zip(*(np.atleast_1d(column).ravel()[:8] for column in columns), strict=True)
        lines += [f"{v:12.8g}{s:12.5g}{t:12.6g}{n:8d}{m:10.2g}" for v, s, t, n, m in rows]
        if statuses.size > 8:
            lines.append(f"... {statuses.size - 8} more")
        return "\n".join(lines)


class EventMap:
    """The event map of a model; `stickslip.event_map` makes it.

    Calling it carries relative displacements from one global stick phase to the next:
    ``f(d)`` for a float or an array of any shape. Immutable; equal settings compare equal.
    """

    def __init__(
        self,
        model: TwoBlock,
        *,
        rtol: float = 1e-15,
        max_events: int = 10_000,
        max_time: float = math.inf,
        engine: EngineName = "auto",
        device: str = "cpu",
        threads: int | None = None,
    ) -> None:
        if not isinstance(model, TwoBlock):
            raise ValueError(f"model = {model!r} is not a model. Take ss.TwoBlock(...).")
        if device != "cpu":
            raise ValueError(f"device = {device!r} is not available; allowed: 'cpu'.")
        self.model = model
        self.rtol = tolerance(rtol)
        self.max_events = positive_integer("max_events", max_events, "events of one motion")
        self.max_time = time_limit(max_time)
        self.engine: EngineName = engine
        self.device = device
        self.threads = (
            available_threads()
            if threads is None
            else positive_integer("threads", threads, "processor cores used")
        )
        self._engine: Engine = engine_for(model, engine)
        self._local = threading.local()

    # --- what it is -----------------------------------------------------------------------

    @property
    def domain(self) -> tuple[float, float]:
        """Ends of the interval of definition, ``|d| <= (1 + beta) / (1 + 2 alpha)``."""
        return self.model.domain

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model by name."""
        return self.model.parameters

    @property
    def settings(self) -> dict[str, Any]:
        """Keyword arguments that make this map from its model."""
        names = ("rtol", "max_events", "max_time", "engine", "device", "threads")
        return {name: getattr(self, name) for name in names}

    def replace(self, **changes: Any) -> EventMap:
        """Make the map of a changed model, with the same settings."""
        return type(self)(self.model.replace(**changes), **self.settings)

    def __eq__(self, other: object) -> bool:
        """Equal models and settings."""
        if not isinstance(other, EventMap):
            return NotImplemented
        return (self.model, self.settings) == (other.model, other.settings)

    def __hash__(self) -> int:
        """Hash of the model and the settings."""
        return hash((self.model, *self.settings.values()))

    def __repr__(self) -> str:
        """One line."""
        return f"EventMap({self.model!r}, engine={self._engine.name!r})"

    # --- values ---------------------------------------------------------------------------

    def __call__(self, d: ArrayLike) -> Any:
        """Value of the map.

        Parameters
        ----------
        d : array_like of float, any shape
            ``X_2 - X_1`` of global stick phases, units of f_s1 / k, inside `domain`.

        Returns
        -------
        float or ndarray shaped like ``d``
            NaN where the motion does not return to global stick.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or outside the locus of eq. (6a).
        """
        points = self.model.admit(d)
        return _shaped(self._run(points.ravel(), ()).value, points.shape)

    def derivative(self, d: ArrayLike) -> Any:
        """Slope df/dd, exact (saltation at every event), one-sided at a breakpoint.

        Arguments, shape and errors as for calling the map.
        """
        points = self.model.admit(d)
        outputs = self._run(points.ravel(), (start_direction(self._engine),))
        return _shaped(outputs.derivative[:, 0], points.shape)

    def parameter_derivative(self, d: ArrayLike, name: str) -> Any:
        """df/d(name) at fixed ``d``, exact; `name` as in ``model.parameters``.

        Arguments, shape and errors as for calling the map; ValueError for an unknown name.
        """
        direction = parameter_direction(self._engine, self.model, name)
        points = self.model.admit(d)
        outputs = self._run(points.ravel(), (direction,))
        return _shaped(outputs.derivative[:, 0], points.shape)

    def evaluate(self, d: ArrayLike) -> EventMapResult:
        """Carry relative displacements to the next global stick phase, and tell how.

        Parameters
        ----------
        d : array_like of float, any shape
            ``X_2 - X_1`` in units of f_s1 / k, inside `domain`.

        Returns
        -------
        EventMapResult
            Fields shaped like ``d``.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or outside the locus of eq. (6a).

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
        points = self.model.admit(d)
        outputs = self._run(points.ravel(), (start_direction(self._engine),), watch=True)
        shape = points.shape
        return EventMapResult(
            value=_shaped_array(outputs.value, shape),
            derivative=_shaped_array(outputs.derivative[:, 0], shape),
            duration=_shaped_array(outputs.duration, shape),
            n_events=_shaped_array(outputs.n_events, shape),
            label=_shaped_array(outputs.label, shape),
            margin=_shaped_array(outputs.margin, shape),
            status=_shaped_array(outputs.status, shape),
        )

    def itinerary(self, d: ArrayLike) -> Any:
        """Modes of both blocks from the onset to the next global stick, as text.

        Returns
        -------
        str or ndarray of str shaped like ``d``
            ``"-. -- .- .."``: one character per block and phase (``.`` stick, ``-`` backward,
            ``+`` forward). A motion without return ends with its last phase.
        """
        points = self.model.admit(d)
        texts = [self._itinerary(value) for value in points.ravel().tolist()]
        if points.ndim == 0:
            return texts[0]
        return np.array(texts).reshape(points.shape)

    def iterate(self, d: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times, keeping every point.

        Parameters
        ----------
        d : array_like of float, any shape
            Starting points inside `domain`.
        n : int
            Number of applications, >= 0.

        Returns
        -------
        ndarray of float, shape (..., n + 1)
            ``[..., 0]`` is ``d``; after a motion without return NaN stays NaN.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or outside the domain; ``n`` is negative.
        """
        if isinstance(n, bool) or int(n) != n or n < 0:
            raise ValueError(f"n = {n!r} is not allowed: n is a number of steps, 0 or more.")
        points = self.model.admit(d)
        orbits = np.empty((points.size, int(n) + 1))
        orbits[:, 0] = points.ravel()

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(())
            self._kernels.iterate_range(
                self._engine.system,
                self._engine.laws,
                orbits,
                start,
                stop,
                scratch,
                self._controls,
                _NO_ITINERARY,
            )

        smallest = max(1, SMALLEST_TILE[self._engine.name] // max(1, int(n)))
        launch(task, points.size, self.threads, smallest)
        return orbits.reshape(*points.shape, int(n) + 1)

    # --- kernels --------------------------------------------------------------------------

    @cached_property
    def _kernels(self) -> ModuleType:
        return bind_engine("stickslip.mechanics.eventmap._kernels", self._engine)

    @cached_property
    def _controls(self) -> Controls:
        return Controls(self.rtol, self.max_events, self.max_time)

    def _scratch(self, directions: Sequence[Floats]) -> Scratch:
        """Work arrays for this thread, with a tangent column for each direction."""
        n_columns = len(directions)
        held: dict[int, Scratch] = self._local.__dict__.setdefault("scratch", {})
        if n_columns not in held:
            n_law = self._engine.n_law_parameters
            held[n_columns] = Scratch(
                new_motion(n_columns, n_law),
                new_motion(n_columns + 4, n_law),
                new_motion(0, n_law),
                self._engine.new_work(),
            )
        scratch = held[n_columns]
        for column, direction in enumerate(directions):
            scratch.motion.directions[column] = direction
            scratch.long_motion.directions[column] = direction
        return scratch

    def _run(self, points: Floats, directions: Sequence[Floats], *, watch: bool = False) -> Outputs:
        """Evaluate all points on all threads."""
        n = points.size
        outputs = Outputs(
            value=np.full(n, np.nan),
            derivative=np.full((n, len(directions)), np.nan),
            duration=np.zeros(n),
            n_events=np.zeros(n, dtype=np.int64),
            label=np.zeros(n, dtype=np.uint64),
            margin=np.full(n, np.inf),
            status=np.zeros(n, dtype=np.int64),
        )

        def task(start: int, stop: int) -> None:
            scratch = self._scratch(directions)
            scratch.work.watch[0] = float(watch)
            self._kernels.carry_range(
                self._engine.system,
                self._engine.laws,
                points,
                start,
                stop,
                scratch,
                self._controls,
                _NO_ITINERARY,
                outputs,
            )

        launch(task, n, self.threads, SMALLEST_TILE[self._engine.name])
        return outputs

    def _itinerary(self, d: float) -> str:
        codes = np.zeros(64, dtype=np.int8)
        while True:
            _, _, n_events, _, _, _ = self._kernels.carry(
                self._engine.system,
                self._engine.laws,
                d,
                self._scratch(()),
                self._controls,
                codes,
            )
            if n_events < codes.size:
                return itinerary_text(codes[: n_events + 1])
            codes = np.zeros(n_events + 1, dtype=np.int8)


_NO_ITINERARY = np.zeros(0, dtype=np.int8)


def _shaped(values: Floats, shape: tuple[int, ...]) -> Any:
    return float(values[0]) if shape == () else values.reshape(shape)


def _shaped_array(values: NDArray[Any], shape: tuple[int, ...]) -> Any:
    return values.reshape(shape)[()] if shape == () else values.reshape(shape)
