"""A model's map, whose work can be called off, its laws, locus, motions and limit cycles."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.maps.arguments import checked_range
from stickslip.app.jobs import checkpoint
from stickslip.app.requests import BadRequestError, Part, is_ours, model_of, refuse_far
from stickslip.errors import NoCycleError
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap, GlobalStickMap
from stickslip.mechanics.eventmap.records import Outputs
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model import locus as geometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.app import requests
    from stickslip.app.requests import Diagram, Request
    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.eventmap.backend import Backend
    from stickslip.mechanics.eventmap.records import Controls
    from stickslip.mechanics.flow.trajectory import Event, Trajectory
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats


SLOW: Final = 0.05  # seconds between two checks: from then on fewer motions are followed at once
QUICK: Final = 0.01  # ... more of them
FIRST: Final = 16  # motions before the second check
MOST: Final = 4096  # between any two
MAX_EVENTS: Final = 20_000
CYCLE_SAMPLES: Final = 2000
CODES: Final = np.array([0, 1, 2], dtype=np.uint8)
"""How modes travel: stick, forward (1), backward (-1, the last)."""


class WatchedBackend:
    """A backend that passes a checkpoint before each piece of its work."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self.name = backend.name
        self._piece = FIRST

    def _pieces(self, d: Floats) -> Iterator[Floats]:
        """Cut points into pieces that take a moment each, with a checkpoint before each."""
        start = 0
        while start < len(d) or not start:
            checkpoint()
            stop, since = start + self._piece, time.monotonic()
            yield d[start:stop]
            start = stop
            self._adapt(time.monotonic() - since)

    def _adapt(self, seconds: float) -> None:
        if seconds > SLOW:
            self._piece = max(1, self._piece // 4)
        elif seconds < QUICK:
            self._piece = min(MOST, self._piece * 2)

    def value(self, d: float) -> float:
        """Value at one d."""
        checkpoint()
        return self._backend.value(d)

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        found = [self._backend.carry(some, slope=slope, watch=watch) for some in self._pieces(d)]
        return Outputs(*map(np.concatenate, zip(*found, strict=True)))

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        found = [self._backend.parameter_slope(some, name) for some in self._pieces(d)]
        return np.concatenate(found)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows from their first entries on, some steps at a time."""
        start = 0
        while start < orbits.shape[1] - 1:
            checkpoint()
            stop, since = start + max(1, self._piece // max(1, len(orbits))), time.monotonic()
            part = np.ascontiguousarray(orbits[:, start : stop + 1])
            self._backend.iterate(part)
            orbits[:, start : stop + 1] = part
            start = stop
            self._adapt(time.monotonic() - since)

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        checkpoint()
        return self._backend.itinerary(d)


class Watched(GlobalStickMap):
    """An event map whose evaluations end when the answer is no longer wanted."""

    def _backend_of(self, controls: Controls) -> Backend:
        return WatchedBackend(super()._backend_of(controls))


class WatchedMap(Watched, EventMap):
    """Of two blocks."""


class WatchedBlocksMap(Watched, BlocksEventMap):
    """Of more."""


def watched_map(model: Model, **settings: Any) -> WatchedMap:
    """Make the event map of a model; with one thread: other users need the others."""
    return WatchedMap(model, threads=1, **settings)


def two_blocks(request: Request) -> Model:
    """Make the model of a view that only two blocks have, which are not forced."""
    model = model_of(request)
    if model.n_blocks == 2 and model.forcing is None:
        return model
    raise BadRequestError(
        f"kind = {request.model['kind']!r}: this view is of two blocks without forcing, whose "
        "event map is one of the line.",
        "model.kind",
    )


def chain_map_of(request: Request) -> WatchedBlocksMap | None:
    """Make the event map of three blocks or more that are not forced; None of other models."""
    model = model_of(request)
    if model.n_blocks < 3 or model.forcing is not None:
        return None
    with naming("model"):
        return WatchedBlocksMap(model, threads=1)


def map_of(request: Request) -> WatchedMap:
    """Make the event map of the model."""
    with naming("model"):
        return watched_map(two_blocks(request))


def range_of(f: MapFamily, request: Diagram) -> tuple[float, float]:
    """Return the ends of a diagram's range, checked."""
    with naming("range" if request.parameter in f.parameters else "parameter"):
        for end in request.range:
            refuse_far({request.parameter: end})
        return checked_range(f, request.parameter, request.range)


@contextmanager
def naming(field: str) -> Iterator[None]:
    """Say of a ValueError which field of the request it is about."""
    try:
        yield
    except BadRequestError:
        raise
    except ValueError as error:
        if not is_ours(error):
            raise
        raise BadRequestError(str(error), field) from error


def law(request: requests.Law) -> Iterator[Part]:
    """Tabulate the friction law of each block."""
    model = model_of(request)
    s = np.linspace(0.0, request.range, request.points)
    arrays = {
        "s": s,
        "force": np.stack([law.force(s) for law in model.laws], axis=-1),
        "forward": np.stack([law.force(s, forward=True) for law in model.laws], axis=-1),
    }
    yield Part("law", arrays, {"names": [law.title for law in model.laws]})


def locus(request: requests.Locus) -> Iterator[Part]:
    """Give the corners of the locus and the edges on which global stick ends."""
    model = two_blocks(request)
    a, b, c, d = geometry.corners(model.plant)
    data = {
        "corners": [a, b, c, d],
        "domain": model.domain,
        "edges": [
            {"name": "block 1 slips", "from": a, "to": b},
            {"name": "block 2 slips", "from": b, "to": c},
        ],
        "AC": [a, c],
    }
    yield Part("locus", data=data)


def motion(request: requests.Motion) -> Iterator[Part]:
    """Follow a motion and sample it, every event included."""
    found = simulated(request)
    model = found.model
    arrays = sampled(found, request.samples) | {"d": found.d}
    data = {
        "events": events(found.events),
        "V": model.V,
        "limits": model.limits,
        "status": int(found.status),
        "message": found.message,
        "t_end": found.t[-1],
    }
    yield Part("motion", arrays, data)


def cycle(request: requests.Cycle) -> Iterator[Part]:
    """Follow a motion onto its limit cycle."""
    found = found_cycle(request)
    data = {
        "period": found.period,
        "multipliers": [complex(value) for value in found.multipliers],
        "stable": found.stable,
        "events": events(found.events),
        "d": found.d,
        "residual": found.residual,
        "V": found.model.V,
    }
    yield Part("cycle", sampled(found.trajectory, CYCLE_SAMPLES), data)


def simulated(request: requests.Motion) -> Trajectory:
    """Follow the motion of a request."""
    model = model_of(request)
    with naming(_start_field(request)):
        start = start_of(model, request)
        return simulate(model, **start, t_end=request.t_end, max_events=MAX_EVENTS)


def found_cycle(request: requests.Cycle) -> Cycle:
    """Find the limit cycle of a request."""
    model = model_of(request)
    with naming(_start_field(request)):
        x, v = _state_of(model, start_of(model, request))
        try:
            return find_cycle(model, x, v, max_events=request.max_events)
        except NoCycleError as none:  # the start is not to blame
            raise BadRequestError(str(none)) from none


def start_of(model: Model, request: requests.Start) -> dict[str, Any]:
    """Return the start, a global stick phase or a state, as `stickslip.simulate` takes it."""
    if (request.d is None) == (request.x is None) or (request.x is None) != (request.v is None):
        raise BadRequestError("give either d, a global stick phase, or both x and v, a state", "d")
    if request.d is None:
        return {"x": list(request.x or ()), "v": list(request.v or ())}
    if isinstance(request.d, float) == (model.n_blocks == 2):
        return {"d": request.d if isinstance(request.d, float) else list(request.d)}
    raise BadRequestError(
        "d is a number for two blocks, else a list of one per pair of blocks", "d"
    )


def _start_field(request: requests.Start) -> str:
    return "d" if request.x is None else "x"


def _state_of(model: Model, start: dict[str, Any]) -> tuple[Any, Any]:
    """Return displacements and velocities at the start."""
    if "x" in start:
        return start["x"], start["v"]
    state = simulate(model, **start, t_end=0.0).final_state
    return state.x, state.v


def sampled(found: Trajectory, samples: int) -> dict[str, NDArray[Any]]:
    """Sample a motion at even times and at every event."""
    t = np.union1d(np.linspace(0.0, found.t[-1], samples), found.t)
    phase = np.minimum(np.searchsorted(found.t, t, side="right") - 1, len(found.modes) - 1)
    x = found.x(t)
    return {
        "t": t,
        "x": x,
        "v": found.v(t),
        "mode": CODES[found.modes[phase]],
        "force": found.friction(t),
        "interval": _stick_intervals(found, t, x),
    }


def _stick_intervals(found: Trajectory, t: Floats, x: Floats) -> Floats:
    """Where each block could ride while the others stand where they are, shape (n, N, 2)."""
    model = found.model
    stiffness = np.diag(model.plant.stiffness)
    needed, limits = found.needed_force(t), np.asarray(model.limits)
    room = np.stack([-limits - needed, limits - needed], axis=-1)
    return np.asarray(x[..., None] + room / stiffness[:, None])


def events(found: tuple[Event, ...]) -> list[dict[str, Any]]:
    """Return events as plain values."""
    return [{"t": event.time, "block": event.block, "kind": event.kind} for event in found]
