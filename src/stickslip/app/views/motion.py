"""Motions in time, and the limit cycles that they settle on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.app.answers import Part
from stickslip.app.requests import BadRequestError, model_of
from stickslip.app.views.model import naming
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.flow.trajectory import simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.app import requests
    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.flow.trajectory import Event, Trajectory
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

MAX_EVENTS: Final = 20_000
CYCLE_SAMPLES: Final = 2000
CODES: Final = np.array([0, 1, 2], dtype=np.uint8)
"""How modes travel: stick, forward (1), backward (-1, the last)."""


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
        return find_cycle(model, x, v, max_events=request.max_events)


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
    stiffness = np.diag(model.structure.stiffness)
    needed, limits = found.needed_force(t), np.asarray(model.limits)
    room = np.stack([-limits - needed, limits - needed], axis=-1)
    return np.asarray(x[..., None] + room / stiffness[:, None])


def events(found: tuple[Event, ...]) -> list[dict[str, Any]]:
    """Return events as plain values."""
    return [{"t": event.time, "block": event.block, "kind": event.kind} for event in found]
