"""Answers that come with the package: every preset's, shown before any kernel is compiled.

    python -m stickslip.app.shipped    computes all of them anew

The page shows them until the live ones replace them; exported, it shows nothing else.
"""

from __future__ import annotations

import gzip
import shutil
from collections.abc import Iterator
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec
import numpy as np

from stickslip.app import live
from stickslip.app.page import described_limits, presets
from stickslip.app.requests import Part, message, plain, request_of
from stickslip.app.views import VIEWS

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

STATIC: Final = files("stickslip.app") / "static"
SHIPPED: Final = STATIC / "shipped"
INDEX: Final = "index.json"
FIRST: Final = {"samples", "followed", "dots", "coarse"}
"""Parts that later ones of the same answer replace."""
UNREAD: Final = {"causes", "undecided", "left", "thin", "unresolved"}
"""What the page does not draw."""


def questions(state: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Slot, view and request of all that the page asks in a preset's state, at its own fineness."""
    model, period = state["model"], state.get("max_period", 4)
    yield "law", "law", {"range": max(0.5, 4 * model["V"]), "points": 101}
    if model["kind"] != "two_block":
        rest = [0.0] * len(model.get("static", [0.0]))
        start: dict[str, Any] = {"x": [*state.get("x", [0.1]), *rest[1:]], "v": rest}
        yield "cycle", "cycle", start
        if len(rest) > 2:
            yield "basins", "basins", {"resolution": 1e-3}
    else:
        start, window, along = {"d": state["d"]}, state.get("window"), state["diagram"]
        of_map = {"window": window, "points": 500}
        yield "map", "event_map", {**of_map, "power": 1, "max_period": period}
        power = state.get("power", 2)
        yield "power", "event_map", {**of_map, "power": power, "max_period": 0}
        yield "cobweb", "cobweb", {**start, "n": 160}
        yield "basins", "basins", {"resolution": 1e-3}
        yield "locus", "locus", {}
        first = {**model, along["parameter"]: along["range"][0]}
        yield "diagram", "diagram", {**along, "model": first, "values": 120}
    yield "motion", "motion", {**start, "t_end": 120, "samples": 500}


def listed() -> dict[str, tuple[str, dict[str, Any]]]:
    """View and request of each answer, by the name of its file; equal ones are listed once."""
    found: dict[str, tuple[str, dict[str, Any]]] = {}
    for preset in presets():
        for slot, view, request in questions(preset["state"]):
            asked = view, plain({"model": preset["state"]["model"], **request})
            if asked not in found.values():
                found[f"{preset['name']}-{slot}.bin"] = asked
    return found


def answer(view: str, request: dict[str, Any]) -> bytes:
    """Compute an answer: the messages that the server sends, with numbers of single precision."""
    asked = request_of(view, msgspec.Raw(msgspec.json.encode(request)))
    parts = {part.name: part for part in VIEWS[type(asked)](asked)}
    if "explained" in parts:
        del parts["branches"]
    kept = [part for name, part in parts.items() if name not in FIRST]
    return b"".join(message(plain(_header(view, part)), _single(part)) for part in kept)


def _header(view: str, part: Part) -> dict[str, Any]:
    data = {name: value for name, value in part.data.items() if name not in UNREAD}
    return {"view": view, "progress": 1.0, "data": {"part_name": part.name, **data}}


def _single(part: Part) -> dict[str, Any]:
    return {
        name: array.astype(np.float32) if array.dtype.kind == "f" else array
        for name, array in part.arrays.items()
    }


def make(folder: Path) -> None:
    """Write all answers, and the list of them."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    entries = []
    for name, (view, request) in listed().items():
        (folder / name).write_bytes(gzip.compress(answer(view, request), mtime=0))
        entries.append({"file": name, "view": view, "request": request})
        print(name, (folder / name).stat().st_size, flush=True)
    (folder / INDEX).write_bytes(msgspec.json.encode(entries) + b"\n")


def read(name: str, folder: Traversable = SHIPPED) -> bytes:
    """Messages of an answer that is shipped."""
    return gzip.decompress((folder / name).read_bytes())


def export(folder: Path) -> None:
    """Write the page with all that it loads: files that any web server can show."""
    folder.mkdir(parents=True, exist_ok=True)
    with as_file(STATIC) as static:
        shutil.copytree(static, folder / "static", dirs_exist_ok=True)
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    live.write(folder / "static" / "live")
    alone = page.replace('<html lang="en"', '<html lang="en" data-alone', 1)
    (folder / "index.html").write_text(alone, encoding="utf-8")
    for name, content in (("limits", described_limits() | {"exports": {}}), ("presets", presets())):
        (folder / f"{name}.json").write_bytes(msgspec.json.encode(content))


if __name__ == "__main__":
    with as_file(SHIPPED) as place:
        make(place)
