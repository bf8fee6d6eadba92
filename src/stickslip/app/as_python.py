"""Views as Python: the calls of the library that compute and draw what the page shows."""

from __future__ import annotations

from typing import Any, Final

from stickslip.app import requests
from stickslip.app.requests import model_of
from stickslip.app.views.event_map import window_of
from stickslip.app.views.model import (
    MAX_EVENTS,
    any_map,
    block_of,
    map_of,
    orbit_map_of,
    range_of,
    settings_of,
    space_map_of,
    start_of,
    two_blocks,
)
from stickslip.app.views.section import grid_of, sides_of
from stickslip.mechanics.cycle.return_map import SectionMap
from stickslip.mechanics.friction import LAWS, TabulatedFriction
from stickslip.mechanics.friction.values import FORWARD
from stickslip.mechanics.model.file import MODELS, model_values

CLASSES: Final = {name: cls.__name__ for name, cls in MODELS.items()} | {
    "state_space": "Structure.from_state_space"
}
CALLS: Final = {
    "contact": "ss.Contact",
    "forcing": "ss.Harmonic",
    "belt": "ss.Harmonic",
    "units": "ss.Units",
}
"""Tables of a model file, and what they are the arguments of."""
LAW_CLASSES: Final = {name: law.__name__ for name, law in LAWS.items()} | {
    TabulatedFriction.name: TabulatedFriction.__name__
}


def as_python(request: requests.Request, frame: requests.Frame = requests.WHOLE) -> str:
    """Write a program whose numbers and whose axes ``ax`` are those of a view."""
    # Only numbers of the request, and formulas in quotation marks, get into the program.
    body = TEXTS[type(request)](request)
    if settings := frame.settings(request):
        body.append(_call("ax.set", settings))
    head = ["import stickslip as ss", *sorted({line for line in body if line.startswith("from ")})]
    if any("np." in line for line in body):
        head.insert(0, "import numpy as np")
    calls = [line for line in body if not line.startswith("from ")]
    model = f"model = {model_text(request)}"
    return "\n".join([*head, "", model, *calls]) + "\n"


def model_text(request: requests.Request) -> str:
    """Write the call that makes the model."""
    values = model_values(model_of(request))
    return _call_of(f"ss.{CLASSES[values.pop('kind')]}", values)


def _call_of(name: str, values: dict[str, Any]) -> str:
    """Write the call that makes a model, or a part of one, from what a file says of it."""
    texts = {key: _text(key, value) for key, value in values.items()}
    if "contact" in texts:
        texts["contacts"] = texts.pop("contact")
    if "belt" in texts:  # a speed, and what oscillates about it
        texts["V"] = f"({texts['V']}, {texts.pop('belt')})"
    return f"{name}({', '.join(f'{key}={text}' for key, text in texts.items())})"


def _text(key: str, value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return f"[{', '.join(_text(key, part) for part in value)}]"
    if key == "friction":
        return _law(value)
    if key in CALLS:
        return _call_of(CALLS[key], value)
    return repr(tuple(value) if key == "at" and isinstance(value, list) else value)


def _law(values: dict[str, Any]) -> str:
    rest = {name: value for name, value in values.items() if name != "law"}
    if values["law"] not in LAW_CLASSES:  # a formula, which the grammar has read
        forward = {FORWARD: rest.pop(FORWARD)} if FORWARD in rest else {}
        return _call("ss.friction_law", {"force": values["law"], "parameters": rest, **forward})
    return _call(f"ss.{LAW_CLASSES[values['law']]}", rest)


def _call(name: str, arguments: dict[str, Any]) -> str:
    return f"{name}({', '.join(f'{key}={value!r}' for key, value in arguments.items())})"


# --- the views --------------------------------------------------------------------------------


def _map(request: requests.OfMap) -> str:
    """Write the call that makes the map."""
    section = {} if request.section is None else settings_of(request.section)
    f = any_map(request)
    if not isinstance(f, SectionMap):
        return "f = ss.event_map(model)"
    named = "".join(f", {name}={value!r}" for name, value in section.items())
    return f"f = ss.return_map(model{named}, max_time={f.max_time!r})"


def _event_map(request: requests.EventMap) -> list[str]:
    window = window_of(map_of(request), request)
    power = f".power({request.power})" if request.power > 1 else ""
    lines = [
        "from stickslip.plot.maps import event_map",
        "from stickslip.plot.orbits import draw_orbits",
        _map(request),
        f"g = f{power}",
        f"x = np.linspace({window[0]!r}, {window[1]!r}, {request.points})",
        "values = g(x)",
        "branches = ss.branches(g)",
        f"ax = event_map(g, window={window!r}, points={request.points}, power={request.power})",
    ]
    if request.max_period > 0:
        found = f"ss.periodic_orbits(f, {request.max_period}, infinitely_unstable=True)"
        if request.power > 1:
            found = f"[orbit for orbit in {found} if {request.power} % orbit.period == 0]"
        lines += [
            f"orbits = {found}",
            f"draw_orbits(orbits, ax, power={request.power}, clip_on=True)",
        ]
    return lines


def _cobweb(request: requests.Cobweb) -> list[str]:
    orbit_map_of(request)
    return [
        "from stickslip.plot.maps import cobweb",
        _map(request),
        f"orbit = f.iterate({request.d!r}, {request.n})",
        f"ax = cobweb(f, {request.d!r}, steps={request.n})",
    ]


def _started(request: requests.Start) -> tuple[str, dict[str, Any]]:
    """Write the model that the motion of a request is of, and give its start."""
    model, start = start_of(request)
    given = model_of(request).parameters
    moved = {name: value for name, value in model.parameters.items() if value != given[name]}
    return (f"model.replace(**{moved!r})" if moved else "model"), start


def _simulated(request: requests.Motion) -> str:
    model, start = _started(request)
    arguments = {**start, "t_end": request.t_end, "max_events": MAX_EVENTS}
    named = ", ".join(f"{name}={value!r}" for name, value in arguments.items())
    return f"motion = ss.simulate({model}, {named})"


def _mechanism(request: requests.Mechanism) -> list[str]:
    if not model_of(request).plant.rubs_as_one:  # its bodies have no places to be drawn at
        return [_simulated(request), "ax = motion.plot()"]
    return [
        "from stickslip.plot.breaks import mechanism",
        _simulated(request),
        "ax = mechanism(model, x=motion.x(0.0))",
    ]


def _plane(request: requests.Plane) -> list[str]:
    two_blocks(request)
    return [
        "from stickslip.plot.locus import trajectory_in_plane",
        _simulated(request),
        "ax = trajectory_in_plane(motion)",
    ]


def _locus(request: requests.Locus) -> list[str]:
    two_blocks(request)
    return ["from stickslip.plot.locus import stick_locus", "ax = stick_locus(model)"]


def _cycle(request: requests.Cycle) -> list[str]:
    model, start = _started(request)
    lines = (
        [f"x, v = {start['x']!r}, {start['v']!r}"]
        if "x" in start
        else [f"_, x, v = ss.simulate(model, d={start['d']!r}, t_end=0.0).final_state"]
    )
    return [
        *lines,
        f"cycle = ss.find_cycle({model}, x, v, max_events={request.max_events})",
        "ax = cycle.plot()",
    ]


def _diagram(request: requests.Diagram) -> list[str]:
    low, high = range_of(map_of(request), request)  # the name is that of a parameter, too
    asked = f"max_period={request.max_period}, window={request.window!r}"
    name = request.parameter
    return [
        _map(request),
        f"values = np.linspace({low!r}, {high!r}, {request.values})",
        f"diagram = ss.bifurcation_diagram(f, {name!r}, values, {asked})",
        f"found = ss.bifurcations(f, {name!r}, ({low!r}, {high!r}), {asked})",
        "ax = diagram.plot(bifurcations=found)",
    ]


def _basins(request: requests.Basins) -> list[str]:
    f = space_map_of(request)
    how = f"resolution={request.resolution!r}"
    if f is not None:
        how = f"grid={grid_of(f, sides_of(request)[-1])!r}"
    return [
        _map(request),
        f"basins = ss.basins(f, ss.attractors(f), {how})",
        "ax = basins.plot()",
    ]


TEXTS: Final[dict[type[requests.Request], Any]] = {
    requests.EventMap: _event_map,
    requests.Cobweb: _cobweb,
    requests.Motion: lambda r: [
        _simulated(r),
        f"t = np.union1d(np.linspace(0.0, motion.t[-1], {r.samples}), motion.t)",
        "x, v = motion.x(t), motion.v(t)",
        "ax = motion.plot()",
    ],
    requests.Portrait: lambda r: [
        "from stickslip.plot.motion import phase_portrait",
        _simulated(r),
        f"ax = phase_portrait(motion, {block_of(r)})",
    ],
    requests.Plane: _plane,
    requests.Mechanism: _mechanism,
    requests.Cycle: _cycle,
    requests.Locus: _locus,
    requests.Law: lambda r: [
        "from stickslip.plot.law import friction_characteristics",
        f"s = np.linspace(0.0, {r.range!r}, {r.points})",
        "force = np.stack([law.force(s) for law in model.laws], axis=-1)",
        f"ax = friction_characteristics(model, limit={r.range!r})",
    ],
    requests.Basins: _basins,
    requests.Diagram: _diagram,
}
