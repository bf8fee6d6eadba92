"""A model's map, its laws, locus, motions and limit cycles."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from msgspec import to_builtins

from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.derived import LineMap
from stickslip.app.requests import BadRequestError, Part, fastest, is_ours, model_of, refuse_busy
from stickslip.app.words import of_page
from stickslip.errors import NoCycleError
from stickslip.mechanics.cycle.return_map import SectionMap, return_map
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.eventmap.of_model import map_of as map_of_model
from stickslip.mechanics.flow.at_contacts import at_contacts
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model import locus as geometry

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.app import requests
    from stickslip.app.requests import Diagram, OfMap, Request, Section
    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.flow.trajectory import Event, Trajectory
    from stickslip.mechanics.model.arguments import Model
    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Floats


MAX_EVENTS: Final = 20_000
CYCLE_SAMPLES: Final = 2000
NO_CYCLE: Final = "no cycle was found"
CODES: Final = np.array([0, 1, 2], dtype=np.uint8)
"""How modes travel: stick, forward (1), backward (-1, the last)."""


PATIENCE: Final = 1e4  # times the inverse of the fastest rate: how long a return is waited for


def any_map(request: OfMap) -> Any:
    """Make the map of a model, whatever its dimension; with one thread: other users need them."""
    model, section = model_of(request), request.section
    with naming("model" if section is None else "section"):
        if section is None:
            f = map_of_model(model, threads=1)
        else:
            f = return_map(model, threads=1, **settings_of(section))
        if isinstance(f, SectionMap):
            f = type(f)(model, **{**f.settings, "max_time": PATIENCE / fastest(model)})
        return f


def settings_of(section: Section) -> dict[str, Any]:
    """Keyword arguments of a return map."""
    return {name: value for name, value in to_builtins(section).items() if value is not None}


def is_of_line(f: Any) -> bool:
    """Whether a map is one of the line."""
    return isinstance(f, LineMap)


def map_of(request: OfMap) -> Any:
    """Make the map of the line that a model has."""
    if is_of_line(f := any_map(request)):
        return f
    raise BadRequestError(
        f"kind = {request.model['kind']!r}: this view is of a map of the line; that of this model "
        f"has {f.dimension} numbers.",
        "model.kind",
    )


def space_map_of(request: OfMap) -> Any:
    """Make the map of the plane or of more dimensions that a model has; None of other models."""
    return None if is_of_line(f := any_map(request)) else f


def orbit_map_of(request: requests.Cobweb) -> Any:
    """Make the map of the line that an orbit starts in."""
    f = map_of(request)
    with naming("d"):
        f.evaluate(request.d)
    return f


def block_of(request: requests.Portrait) -> int:
    """Return the number of the block that a portrait is of."""
    if request.block > (n := model_of(request).n_blocks):
        raise BadRequestError(f"block = {request.block} of {n}", "block")
    return request.block


def two_blocks(request: Request) -> Model:
    """Make the model of a view that only two blocks have, which are not forced."""
    model = model_of(request)
    if model.plant.rubs_as_one and model.n_blocks == 2 and not model.plant.n_waves:
        return model
    raise BadRequestError(
        f"kind = {request.model['kind']!r}: this view is of two blocks without forcing, whose "
        "event map is one of the line.",
        "model.kind",
    )


def returns(request: requests.Returns) -> Iterator[Part]:
    """Tell which map a model has, what its points are, and why there is none."""
    yield Part("returns", data=told_map(request))


def told_map(request: OfMap) -> dict[str, Any]:
    """Kind of the map, its coordinates, its domain where it is known, and a sentence if none."""
    try:
        f = any_map(request)
    except BadRequestError as error:
        if error.field.startswith("model."):
            raise
        return {"kind": "none", "why": str(error), "coordinates": [], "domain": None}
    of_contact = isinstance(f, SectionMap)
    names = list(f.coordinates) if of_contact else ["d"] * f.dimension
    told = {"kind": "space", "why": "", "coordinates": names, "domain": None}
    if is_of_line(f):
        try:
            return told | {"kind": "line", "domain": f.domain}
        except ValueError as error:
            return told | {"kind": "none", "why": of_page(str(error))}
    if of_contact and f.domain is None:
        why = (
            f"The map has {f.dimension} numbers: its basins are shown with a range for each, in "
            'the address section={"domain": [[low, high], ...]}.'
        )
        return told | {"kind": "none", "why": why}
    return told


def range_of(f: Any, request: Diagram) -> tuple[float, float]:
    """Return the ends of a diagram's range, checked."""
    is_known = request.parameter in f.parameters
    for k, end in enumerate(request.range):
        with naming(f"range[{k}]" if is_known else "parameter"):
            refuse_busy(f.model.replace(**{request.parameter: end}))
    with naming("range"):
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
        **assembly(model),
        "status": int(found.status),
        "message": of_page(found.message),
        "t_end": found.t[-1],
    }
    yield Part("motion", arrays, data)


def cycle(request: requests.Cycle) -> Iterator[Part]:
    """Follow a motion onto its limit cycle, or tell why there is none."""
    try:
        found = found_cycle(request)
    except BadRequestError as error:
        if not str(error).startswith(NO_CYCLE):
            raise
        yield Part("cycle", data={"why": str(error)})
        return
    data = {
        "period": found.period,
        "multipliers": [complex(value) for value in found.multipliers],
        "stable": found.stable,
        "events": events(found.events),
        "d": found.d,
        "residual": found.residual,
    }
    yield Part("cycle", sampled(found.trajectory, CYCLE_SAMPLES), data)


def simulated(request: requests.Motion) -> Trajectory:
    """Follow the motion of a request."""
    with naming(_start_field(request)):
        model, start = start_of(request)
        return simulate(model, **start, t_end=request.t_end, max_events=MAX_EVENTS)


def found_cycle(request: requests.Cycle) -> Cycle:
    """Find the limit cycle of a request."""
    with naming(_start_field(request)):
        model, start = start_of(request)
        x, v = _state_of(model, start)
        try:
            return find_cycle(model, x, v, max_events=request.max_events)
        except NoCycleError as none:  # the start is not to blame
            raise BadRequestError(str(none)) from none


def start_of(request: requests.Start) -> tuple[Model, dict[str, Any]]:
    """Model and start, a global stick phase or a state, as `stickslip.simulate` takes them.

    From a point of a return map the phases of forces are those at that point.
    """
    if (request.d is None) == (request.x is None) or (request.x is None) != (request.v is None):
        raise BadRequestError("give either d, a point of the map, or both x and v, a state", "d")
    model = model_of(request)
    if request.d is None:
        return model, {"x": list(request.x or ()), "v": list(request.v or ())}
    if isinstance(f := any_map(request), SectionMap):
        model, x, v = f.begun(request.d)
        return model, {"x": x.tolist(), "v": v.tolist()}
    if isinstance(request.d, float) == (model.n_blocks == 2):
        return model, {"d": request.d if isinstance(request.d, float) else list(request.d)}
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
    x, v = found.x(t), found.v(t)
    sticks = found.modes[phase] == 0
    u, w = at_contacts(found.model, t, x, v, sticks)
    limit = found.model.plant.limits(x, v)
    own = {} if found.model.plant.rubs_as_one else {"u": u, "w": w, "limit": limit}
    return {
        "t": t,
        "x": x,
        "v": v,
        **own,
        "mode": CODES[found.modes[phase]],
        "force": found.friction(t),
        "interval": _stick_intervals(found, t, u),
    }


def _stick_intervals(found: Trajectory, t: Floats, u: Floats) -> Floats:
    """Where each contact could stick if it alone were moved, shape (n, m, 2); NaN: anywhere."""
    plant = found.model.plant
    r, n_q = plant.reduced, plant.n_positions
    rows = r.matrix[r.n_free : r.n_free + plant.n_contacts, r.n_waves : r.n_waves + n_q]
    lead = plant.lead(plant)[:n_q]
    stiffness = np.einsum("mq,qm->m", rows, lead) if n_q else np.zeros(plant.n_contacts)
    stiffness[(stiffness <= 0.0) | plant.is_coupled] = np.nan
    needed, limits = found.needed_force(t), plant.limits(found.x(t), found.v(t))
    room = np.stack([-limits - needed, limits - needed], axis=-1)
    return np.asarray(u[..., None] + room / stiffness[:, None])


def assembly(model: Model) -> dict[str, Any]:
    """List what a model is made of, as it is drawn: bodies, springs between them, contacts.

    A spring has the numbers of its bodies from 0, the second -1 of one to the ground. A contact
    has those that it joins; there are no bodies where one acts on something else.
    """
    plant = model.plant
    n = plant.n_bodies
    contacts = [
        {"bodies": _joined(plant.out[k], k in plant.elastic, plant), "V": plant.V[k]}
        | {"limit": plant.static[k], "elastic": k in plant.elastic}
        for k in range(plant.n_contacts)
    ]
    if not plant.n_positions or not all(contact["bodies"] for contact in contacts):
        alone = [contact | {"bodies": []} for contact in contacts]
        return {"bodies": 0, "springs": [], "contacts": alone}
    stiffness = 0.5 * (plant.stiffness + plant.stiffness.T)[:n]
    dust = 1e-12 * np.abs(stiffness).max(initial=0.0)
    rows = [(i, j, -stiffness[i, j]) for i in range(n) for j in range(i + 1, n)]
    rows += [(i, -1, row.sum()) for i, row in enumerate(stiffness)]
    springs = [[i, j, k] for i, j, k in rows if abs(k) > dust]
    return {"bodies": n, "springs": springs, "contacts": contacts}


def _joined(row: Floats, is_elastic: bool, plant: Plant) -> list[int]:
    """Numbers of the bodies that a contact joins; one: it rubs on a belt; none: on other things."""
    if is_elastic:  # its foot stretches a spring to where it acts
        row = -plant.stiffness[int(np.flatnonzero(row)[0])] * (np.arange(len(row)) < plant.n_bodies)
        row = row / np.abs(row).max()
    at = np.flatnonzero(row)
    match sorted(row[at].tolist()):
        case [1.0]:
            return at.tolist()
        case [-1.0, 1.0]:
            return [int(np.argmax(row)), int(np.argmin(row))]
    return []


def events(found: tuple[Event, ...]) -> list[dict[str, Any]]:
    """Return events as plain values."""
    return [{"t": event.time, "block": event.block, "kind": event.kind} for event in found]
