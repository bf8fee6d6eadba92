"""Basins of maps of more than one dimension: the plane of the first two numbers, on finer grids."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basins import basins
from stickslip.app.requests import Part

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.attractors.attractor import AttractorND
    from stickslip.app import requests

COARSE, FINE = 16, 64  # points along a side, one picture after the other
SPREAD: Final = 2048  # points of the domain whose extremes bound the picture
POINTS: Final = 400  # of an attractor


def section(f: Any, request: requests.Basins) -> Iterator[Part]:
    """Find the attractors, then who is attracted where: evidence, with its numbers."""
    known = attractors(f)
    plane = f.dimension == 2
    names = getattr(f, "coordinates", ("d_1", "d_2"))[:2]
    told = [_attractor(each, plane=plane) for each in known]
    yield Part("attractors", data={"attractors": told}, progress=0.1)
    sides = sides_of(request)
    for side in sides:
        found = basins(f, known, grid=grid_of(f, side))
        inside = found.index.size * (1.0 - found.left)
        arrays: dict[str, NDArray[Any]] = {
            "x": found.axes[0],
            "y": found.axes[1],
            "index": found.index,
        }
        data = {
            "coordinates": names,
            "shares": [
                float((found.index == k).sum() / max(inside, 1.0)) for k in range(len(told))
            ],
            "held": f.dimension - 2,
            "mistaken": found.mistaken,
            "checked": found.checked,
        }
        last = side == sides[-1]
        if last and found.undecided:
            data["unresolved"] = [f"where {found.undecided:.3g} of the starts end is not known"]
        yield Part("basins" if last else "coarse", arrays, data, 1.0 if last else 0.4)


def sides_of(request: requests.Basins) -> list[int]:
    """Return numbers of points along a side, as fine as the request asks for."""
    most = min(math.ceil(1.0 / request.resolution), FINE)
    return [side for side in (COARSE,) if side < most] + [most]


def grid_of(f: Any, side: int) -> list[Any]:
    """Return the plane of the first two differences; the others are 0."""
    x = f.spread(SPREAD)[:, :2]
    ends = zip(x.min(axis=0).tolist(), x.max(axis=0).tolist(), strict=True)
    return [*((low, high, side) for low, high in ends), *[0.0] * (f.dimension - 2)]


def _attractor(found: AttractorND, *, plane: bool) -> dict[str, Any]:
    points = found.points[-POINTS:, :2] if plane else np.empty((0, 2))  # others lie off the section
    facts = {"kind": found.kind, "period": found.period, "reason": found.reason}
    return {**facts, "points": points, "lyapunov": found.lyapunov.value}
