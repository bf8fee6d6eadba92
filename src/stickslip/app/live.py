"""What the exported page computes by itself: maps and motions of two equal blocks.

The package's own kernels, as WebAssembly (`numerics.webassembly`), one module for each law.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import msgspec
import numpy as np

from stickslip.app.requests import reach
from stickslip.mechanics.eventmap.backend import ScalarBackend
from stickslip.mechanics.eventmap.records import Controls, new_outputs
from stickslip.mechanics.flow.engine import FLOW, engine_for
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.formula import TracedFormula
from stickslip.mechanics.friction.law import Range
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.friction.stribeck import Stribeck
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.expression import reachable
from stickslip.numerics.targets import instantiate
from stickslip.numerics.webassembly import web_module

if TYPE_CHECKING:
    from pathlib import Path

    from stickslip.mechanics.flow.engine import Engine
    from stickslip.mechanics.friction.law import FrictionLaw

LAWS: Final[dict[str, FrictionLaw]] = {
    "coulomb": Coulomb(mu=0.22),
    "popp-stelter": PoppStelter(gamma=3.0),
    "stribeck": Stribeck(mu=0.22, speed=0.1),
}
"""Laws that the page can move blocks with, as the page names them."""
POINTS: Final = 4  # of a map at a time: where blocks slip without end one may take a second
SAMPLES: Final = 20_000  # of a motion, events included
CONTROLS: Final = Controls(rtol=1e-15, max_events=1000, max_time=math.inf)
PHASES: Final = 64  # of an itinerary that is told


def write(folder: Path) -> None:
    """Write a module for each law, and what the page has to know of the laws."""
    folder.mkdir(parents=True, exist_ok=True)
    known = {}
    for name, law in LAWS.items():
        model = TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
        engine = engine_for(model)
        (folder / f"{name}.wasm").write_bytes(module(model, engine))
        known[name] = described(engine, law)
    (folder / "laws.json").write_bytes(msgspec.json.encode(known))


def module(model: TwoBlock, engine: Engine) -> bytes:
    """Compile the entries ``map``, over points, and ``motion``, from a global stick phase."""
    backend = ScalarBackend(model, engine, CONTROLS, threads=1)
    none, of_start = engine.directions(), engine.directions(np.eye(1))
    outputs = new_outputs((POINTS, 1), 1)
    for array in outputs:
        array[...] = 0  # what is not zero is kept in the file
    maps = {
        "system": engine.system,
        "laws": engine.laws,
        "points": np.zeros((POINTS, 1)),
        "start": 0,
        "stop": POINTS,
        "scratch": backend.scratch(of_start),
        "controls": CONTROLS,
        "itinerary": np.zeros((PHASES, 2), dtype=np.int8),
        "outputs": outputs._replace(value=outputs.value[:, None]),
    }
    key, advance = engine.key, engine.kernels.advance
    samples = instantiate(f"{FLOW}._samples_kernels", key, advance=advance)
    motion = {
        "system": engine.system,
        "laws": engine.laws,
        "d": 0.0,
        "t_end": 0.0,
        "every": 0.0,
        "motion": engine.new_motion(none),
        "work": engine.new_work(),
        "rtol": CONTROLS.rtol,
        "rows": np.zeros((SAMPLES, 5)),
        "modes": np.zeros((SAMPLES, 2), dtype=np.int8),
        "count": np.zeros(2, dtype=np.int64),
    }
    carry = backend.kernels.carry_range
    return web_module({"map": (carry, maps), "motion": (samples.sample, motion)})


def described(engine: Engine, law: FrictionLaw) -> dict[str, Any]:
    """Return a law's formula as a graph, and how rows of parameters are made of it."""
    (scalars,), (formula,) = engine.code.scalars, engine.code.formulas
    assert scalars is not None
    assert isinstance(formula, TracedFormula)
    force = formula.output(forward=False)
    nodes = scalars.graph.nodes
    ranges = {name: kind for name, kind in law.fields().items() if isinstance(kind, Range)}
    return {
        "parameters": formula.parameters,
        "constants": scalars.constants,  # nodes
        "force": force,
        "nodes": {k: nodes[k] for k in reachable(scalars.graph, [force, *scalars.constants])},
        "defaults": {name: getattr(law, name) for name in (*formula.parameters, *law.options)},
        "fixed": fixed(law),
        "ranges": ranges,
        "reach": {name: reach(name) for name in ("alpha", "beta", "V", *ranges)},
    }


def fixed(law: FrictionLaw) -> list[str]:
    """Parameters of a law that the page cannot change."""
    return [*law.options, *(["viscous"] if isinstance(law, Coulomb) else [])]


def moves(model: dict[str, Any]) -> bool:
    """Whether the page moves the blocks of a model, as ``engineOf`` of ``static/live.js`` says."""
    named: Any = model.get("friction")
    law = LAWS.get(named["law"]) if isinstance(named, dict) else None
    if law is None or model["kind"] != "two_block" or model.get("damping") or model.get("forcing"):
        return False
    values = {name: getattr(law, name) for name in fixed(law)}
    return all(named.get(name, value) == value for name, value in values.items())
