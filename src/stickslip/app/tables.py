"""Views as data: what the page gets, as JSON, and the curves in it as columns of a CSV file."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

import msgspec

from stickslip.app import requests
from stickslip.app.answers import plain
from stickslip.app.views import VIEWS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.app.answers import Part

COLUMNS: Final[dict[type[requests.Request], str]] = {
    requests.EventMap: "branches",
    requests.Cobweb: "orbit",
    requests.Motion: "motion",
    requests.Cycle: "cycle",
    requests.Law: "law",
    requests.Basins: "basins",
    requests.Diagram: "branches",
}
"""Views that have curves, and the part of the answer that holds them."""


def as_json(request: requests.Request) -> bytes:
    """Compute a view and return request and answer as a JSON document."""
    parts = [
        {"name": part.name, **part.arrays, **part.data} for part in VIEWS[type(request)](request)
    ]
    return msgspec.json.encode(plain({"request": msgspec.to_builtins(request), "parts": parts}))


def as_csv(request: requests.Request) -> str:
    """Compute a view and return its curves, a row for each point."""
    part = next(p for p in VIEWS[type(request)](request) if p.name == COLUMNS[type(request)])
    columns = dict(_columns(_rows(part)))
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue()


def _rows(part: Part) -> Mapping[str, NDArray[Any]]:
    """Return the arrays that have a row for each point."""
    if part.name == "basins":  # edges enclose intervals
        edges = part.arrays["edges"]
        return {"left": edges[:-1], "right": edges[1:], "attractor": part.arrays["label"]}
    first = next(iter(part.arrays.values()))
    return {name: array for name, array in part.arrays.items() if len(array) == len(first)}


def _columns(arrays: Mapping[str, NDArray[Any]]) -> Iterator[tuple[str, list[Any]]]:
    """Name a column for each block, or for each end of an interval of each block."""
    for name, array in arrays.items():
        flat = array.reshape(len(array), math.prod(array.shape[1:]))
        for k, column in enumerate(flat.T, start=1):
            yield name if array.ndim == 1 else f"{name}_{k}", column.tolist()
