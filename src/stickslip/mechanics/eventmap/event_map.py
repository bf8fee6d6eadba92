"""The event map (eqs. 11-12): from the d of one global stick phase to the d of the next."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.analysis.maps.derived import LineMap
from stickslip.checks import MOST_STEPS, Many, one_of, parameter_name, shown, whole_number
from stickslip.mechanics.eventmap.backend import Backend, ScalarBackend
from stickslip.mechanics.eventmap.base import EventMapResult, ModelMap
from stickslip.mechanics.eventmap.blocks_map import BlocksEventMap
from stickslip.mechanics.eventmap.lanes import LaneBackend, PoolBackend, lanes_serve
from stickslip.mechanics.eventmap.records import Controls, Outputs
from stickslip.mechanics.flow.engine import EngineName, engine_for
from stickslip.mechanics.friction.series import law_series
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Mechanism
    from stickslip.mechanics.flow.trajectory import Trajectory


class EventMap(ModelMap, LineMap):
    """The event map of a model; `stickslip.event_map` makes it.

    Calling it carries relative displacements from one global stick phase to the next:
    ``f(d)`` for a float or an array of any shape. Immutable; equal settings compare equal.

    Attributes
    ----------
    searched : dict of str to pair of float
        Ranges of parameters within which bifurcations and diagrams are searched for.
    """

    model: TwoBlock
    _settings = ("rtol", "max_events", "max_time", "engine", "device", "threads")
    searched: ClassVar = {"alpha": (0.0, 1e6), "V": (0.0, 10.0), "damping": (0.0, 50.0)}

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
            raise ValueError(f"model = {shown(model)} is not a model. Take ss.TwoBlock(...).")
        self.model = model
        self._set(rtol, max_events, max_time, threads)
        self.engine: EngineName = engine
        self.device = device
        self._backend = self._backend_of(self._controls)
        self._end = model.domain[1]

    def _backend_of(self, controls: Controls) -> Backend:
        return backend_for(self.model, self.engine, controls, self.device, self.threads)

    # --- what it is -----------------------------------------------------------------------

    @property
    def domain(self) -> tuple[float, float]:
        """Ends of the interval of definition, ``|d| <= (1 + beta) / (1 + 2 alpha)``."""
        return self.model.domain

    def __repr__(self) -> str:
        """One line."""
        return f"EventMap({self.model!r}, engine={self._backend.name!r})"

    def slip_from(self, d: float, max_events: int) -> Trajectory:
        """Follow the motion, with the map's displacements, modes and forces, to the next stick."""
        from stickslip.mechanics.flow.trajectory import simulate  # not for the first value

        return simulate(self.model, d=d, until="stick", max_events=max_events, engine=self.engine)

    def explain_break(self, left: float, right: float) -> Mechanism:
        """Return why the map breaks between two starting points, adjacent floats."""
        from stickslip.mechanics.eventmap.mechanism import mechanism_between  # seldom asked

        return mechanism_between(self, left, right)

    # --- values ---------------------------------------------------------------------------

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
        if isinstance(d, float) and -self._end <= d <= self._end:
            return self._backend.value(d)
        points = self.model.admit(d)
        return _shaped(self._backend.carry(points.ravel()).value, points.shape)

    @overload
    def derivative(self, d: float) -> float: ...
    @overload
    def derivative(self, d: Many) -> Floats: ...
    @overload
    def derivative(self, d: ArrayLike) -> float | Floats: ...
    def derivative(self, d: ArrayLike) -> float | Floats:
        """Slope df/dd, exact (saltation at every event), one-sided at a breakpoint.

        Arguments, shape and errors as for calling the map.
        """
        points = self.model.admit(d)
        slopes = self._backend.carry(points.ravel(), slope=True).derivative[:, 0]
        return _shaped(slopes, points.shape)

    @overload
    def value_and_derivative(self, d: float) -> tuple[float, float]: ...
    @overload
    def value_and_derivative(self, d: Many) -> tuple[Floats, Floats]: ...
    @overload
    def value_and_derivative(self, d: ArrayLike) -> tuple[float | Floats, float | Floats]: ...
    def value_and_derivative(self, d: ArrayLike) -> tuple[float | Floats, float | Floats]:
        """Value and slope at once, without what `evaluate` tells besides, and sooner.

        Arguments, shape and errors as for calling the map.
        """
        points = self.model.admit(d)
        found = self._backend.carry(points.ravel(), slope=True)
        slopes = found.derivative[:, 0]
        return _shaped(found.value, points.shape), _shaped(slopes, points.shape)

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
        points = self.model.admit(d)
        parameter_name("name", name, self.parameters, of="the model")
        return _shaped(self._backend.parameter_slope(points.ravel(), name), points.shape)

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
        outputs = self._backend.carry(points.ravel(), slope=True, watch=True)
        return self._result(points, outputs, points.shape, points.shape)

    @overload
    def itinerary(self, d: float) -> str: ...
    @overload
    def itinerary(self, d: Many) -> NDArray[np.str_]: ...
    @overload
    def itinerary(self, d: ArrayLike) -> str | NDArray[np.str_]: ...
    def itinerary(self, d: ArrayLike) -> str | NDArray[np.str_]:
        """Modes of both blocks from the onset to the next global stick, as text.

        Returns
        -------
        str or ndarray of str shaped like ``d``
            ``"-. -- .- .."``: one character per block and phase (``.`` stick, ``-`` backward,
            ``+`` forward). A motion without return ends with its last phase.
        """
        points = self.model.admit(d)
        texts = [self._backend.itinerary(value) for value in points.ravel().tolist()]
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
        n = whole_number("n", n, 0, at_most=MOST_STEPS, what="applications of the map")
        points = self.model.admit(d)
        orbits = np.empty((points.size, n + 1))
        orbits[:, 0] = points.ravel()
        self._backend.iterate(orbits)
        return orbits.reshape(*points.shape, n + 1)


def _shaped(values: Floats, shape: tuple[int, ...]) -> float | Floats:
    return float(values[0]) if shape == () else values.reshape(shape)


DEVICES = ("cpu", "cuda")


def backend_for(
    model: TwoBlock, engine: EngineName, controls: Controls, device: str, threads: int
) -> Backend:
    """Choose what carries the motions of a model; ValueError if the device cannot."""
    if one_of("device", device, DEVICES) == "cuda":
        from stickslip.mechanics.eventmap.cuda import CudaBackend  # needs numba-cuda

        return CudaBackend(model, engine, controls)
    if model.damping > 0.0:
        return DampedBackend(model, engine, controls, threads)
    moved = engine_for(model, engine)
    if lanes_serve(moved, controls):
        return LaneBackend(model, moved, controls, threads)
    series = law_series(model.laws) if moved.name == "taylor" else None
    if series is not None:
        return PoolBackend(model, moved, controls, threads, series)
    return ScalarBackend(model, moved, controls, threads)


class DampedBackend:
    """Two damped blocks: the flow of the family."""

    name = "series"

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        engine_for(model.replace(damping=0.0), engine)  # the same errors
        self.inner = BlocksEventMap(model.chain, **controls._asdict(), threads=threads)

    def value(self, d: float) -> float:
        """Value at one d."""
        return float(self.carry(np.array([d])).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        found = self.inner.carry(d[:, None], slope=slope, watch=watch)
        return Outputs(found.value[:, 0], found.derivative[:, 0], *found[2:])

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        name = {"beta": "static_2"}.get(name, name)
        return self.inner.parameter_derivative(d[:, None], name)[:, 0]

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""
        self.inner._fill(orbits[..., None])

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        return str(self.inner.itinerary([d]))
