"""Basins of attraction: who is attracted where."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basins import basins as divided
from stickslip.app.answers import Part
from stickslip.app.views.common import map_of

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.app import requests


def basins(request: requests.Basins) -> Iterator[Part]:
    """Find the attractors, then the exact edges of their basins."""
    f = map_of(request)
    known = attractors(f)
    yield Part("attractors", data={"attractors": [_attractor(a) for a in known]}, progress=0.3)
    found = divided(f, known, resolution=request.resolution)
    data = {
        "causes": [str(cause) for cause in found.causes],
        "undecided": found.undecided,
        "left": found.left,
        "thin": found.thin,
        "reason": found.reason,
    }
    yield Part("basins", {"edges": found.edges, "label": found.index}, data)


def _attractor(found: Attractor) -> dict[str, Any]:
    return {
        "kind": found.kind,
        "period": found.period,
        "points": None if found.orbit is None else found.orbit.points,
        "bands": found.bands,
        "lyapunov": found.lyapunov.value,
        "reason": found.reason,
    }
