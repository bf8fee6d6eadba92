"""The bifurcation diagram, as it grows: dots at once, then orbits, then bifurcations."""

from __future__ import annotations

from collections.abc import Iterator
from contextvars import copy_context
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from stickslip.analysis.bifurcations.bifurcations import N_LISTS, bifurcations_of
from stickslip.analysis.bifurcations.scan.nodes import Family
from stickslip.analysis.bifurcations.scan.survey import Survey
from stickslip.analysis.diagrams.diagram import Diagram
from stickslip.analysis.diagrams.diagrams import diagram_of
from stickslip.analysis.maps.arguments import line_family
from stickslip.analysis.maps.derived import windowed
from stickslip.analysis.maps.protocol import MapFamily, advance_each, domain_width
from stickslip.analysis.orbits.periodic import jump_orbits
from stickslip.analysis.work import Work
from stickslip.app import requests
from stickslip.app.jobs import checkpoint, progress_between
from stickslip.app.requests import Part
from stickslip.app.views.model import map_of, naming, range_of
from stickslip.numerics.arrays import Floats
from stickslip.numerics.processes import PROCESSES
from stickslip.numerics.threads import pool

SEEDS: Final = 8  # orbits that the first dots are taken from
SETTLING: Final = 60  # steps of each before dots are kept
KEPT: Final = 16  # dots of each
COARSE: Final = 120  # values with first dots, at most
BLOCKS: Final = 12  # parts that they come in
GIVES_WAY: Final = 5  # niceness of a diagram's processes: somebody waits for other answers

SHORT: Final = {
    "fold": "LP",
    "flip": "PD",
    "transcritical": "TC",
    "pitchfork": "PF",
    "border_collision": "BC",
    "boundary_crisis": "CR",
    "interior_crisis": "IC",
    "band_merging": "BM",
    "enters_gap": "EG",
}
"""Labels of bifurcations beside their points, the usual ones where there are such."""


def diagram(request: requests.Diagram) -> Iterator[Part]:
    """Iterate for first dots; then follow all orbits; then find and explain their bifurcations."""
    f = line_family(map_of(request))
    low, high = range_of(f, request)
    PROCESSES.begin(GIVES_WAY)
    # Lists and attractors come from processes: this one has time for the rest meanwhile.
    with pool(1, "diagram") as thread:
        begun = thread.submit(copy_context().run, surveyed, f, request, low, high)
        yield from _dots(f, request, low, high)
        survey, work = begun.result(), Work(progress_between(0.4, 0.8))
        listing = thread.submit(copy_context().run, bifurcations_of, survey, work)
        values = np.linspace(low, high, request.values)
        yield _branches(diagram_of(survey, values, Work(progress_between(0.4, 0.5))))
        through_jumps = _infinitely_unstable(survey)
        items = listing.result()
    data = {
        "bifurcations": [{"short": SHORT[item.kind], **item.row()} for item in items],
        "unresolved": [str(item) for item in items.unresolved],
    }
    yield Part("bifurcations", data=data, progress=0.8)
    yield through_jumps


def surveyed(f: MapFamily, request: requests.Diagram, low: float, high: float) -> Survey:
    """List all orbits along the range: what a diagram and bifurcations are made of."""
    family = Family(f, request.parameter, request.window)
    with naming("window"):
        survey = Survey(family, low, high, request.max_period, Work(progress_between(0.2, 0.4)))
        survey.run(N_LISTS)
    return survey


# --- first dots -------------------------------------------------------------------------------


def _dots(f: MapFamily, request: requests.Diagram, low: float, high: float) -> Iterator[Part]:
    """Iterate a few orbits at each value, coarse to fine: in interleaved blocks of values."""
    values = np.linspace(low, high, min(request.values, COARSE))
    for k in range(BLOCKS):
        some = values[k::BLOCKS]
        if some.size == 0:
            return
        checkpoint()
        maps = [f.replace(**{request.parameter: value}) for value in some]
        dots = _settled([windowed(g, request.window) for g in maps])
        arrays = {
            "value": np.repeat(some, [len(points) for points in dots]),
            "d": np.concatenate(dots),
        }
        yield Part("dots", arrays, progress=0.2 * (k + 1) / BLOCKS)


def _settled(maps: list[Any]) -> list[Floats]:
    """Points that a few orbits of each map visit after a while, those that leave aside."""
    share = (np.arange(SEEDS) + 0.5) / SEEDS
    starts = [f.domain[0] + domain_width(f) * share for f in maps]
    orbits = advance_each(maps, starts, SETTLING + KEPT)
    return [np.unique(o[:, SETTLING:][np.isfinite(o[:, SETTLING:])].round(12)) for o in orbits]


# --- what is exact ----------------------------------------------------------------------------


def _branches(found: Diagram) -> Part:
    """Orbits from where they begin to where they end, breakpoints, and the attractors' dots."""
    arrays: dict[str, NDArray[Any]] = {"value": found.values}
    for k, orbit in enumerate(found.orbits):
        arrays |= {f"points_{k}": orbit.points, f"multiplier_{k}": orbit.multipliers}
    for k, line in enumerate(found.breakpoints):
        arrays[f"break_{k}"] = line.d
    table = found.attractors
    known = np.isfinite(table.points)
    where = np.broadcast_to(found.values[table.where][:, None], known.shape)
    arrays |= {"dot_value": where[known], "dot_d": table.points[known]}
    data = {
        "parameter": found.parameter,
        "orbits": [
            {"period": orbit.period, "ends": [_end(end) for end in orbit.ends]}
            for orbit in found.orbits
        ],
        "breakpoints": [{"kind": line.kind} for line in found.breakpoints],
        "unresolved": list(found.unresolved),
    }
    return Part("branches", arrays, data, progress=0.5)


def _end(end: Any) -> dict[str, Any]:
    return {"value": end.value, "reason": end.reason, "points": end.points}


def _infinitely_unstable(survey: Survey) -> Part:
    """List the orbits that pass through a jump, at the values whose branches are known."""
    rows: list[tuple[float, float, int]] = []
    report = progress_between(0.5, 0.6)
    for k, node in enumerate(survey.grid_nodes):
        report(k / len(survey.grid_nodes))
        for orbit in jump_orbits(node.table, survey.max_period):
            rows += [(node.q, float(d), orbit.period) for d in orbit.points]
    table = np.array(rows, dtype=np.float64).reshape(-1, 3)
    arrays: dict[str, NDArray[Any]] = {
        "value": table[:, 0],
        "d": table[:, 1],
        "period": table[:, 2].astype(np.int32),
    }
    return Part("infinitely_unstable", arrays)
