"""Answers that come with the package: every preset's, shown before any kernel is compiled.

    python -m stickslip.app.shipped    computes all of them anew

The page shows them until the live ones replace them; exported, it shows nothing else. An export
that begins with a plant of one's own has its answers, too.
"""

from __future__ import annotations

import gzip
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec
import numpy as np

from stickslip.app import live
from stickslip.app.folder import LIMITS, PRESETS, SHIPPED, STATIC, page, presets
from stickslip.app.one_file import one_file
from stickslip.app.page import described_limits, made_presets
from stickslip.app.requests import Cycle, Part, message, request_of
from stickslip.app.views import VIEWS
from stickslip.files import plain, whole_file
from stickslip.mechanics.friction.stribeck import Stribeck
from stickslip.mechanics.model.file import model_of_values, model_values

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

INDEX: Final = "index.json"
PAGE: Final = "index.html"
FIRST: Final = {"samples", "followed", "dots", "coarse"}
"""Parts that later ones of the same answer replace."""
NO_SERVER: Final = (
    "<script>if (location.protocol === 'file:') document.querySelector('.connection').textContent ="
    " 'Browsers run the scripts of this folder only from a web server. "
    "stickslip explore --export page.html writes a page that opens from a file.';</script>"
)
UNREAD: Final = {"causes", "undecided", "left", "thin"}
"""What the page does not draw."""


def questions(state: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Slot, view and request of all that the page asks in a preset's state, at its own fineness."""
    model = model_of_values(state["model"])
    of_map = {"section": state["section"]} if "section" in state else {}
    told = state["map"]["kind"] if "map" in state else None
    of_line = told == "line" or state["model"]["kind"] == "two_block"
    yield "law", "law", {"range": law_range(model), "points": 101}
    start = {"d": state["d"]} if of_line else start_state(model, state)
    if of_line:
        yield from _of_line(state, of_map | start)
    else:
        yield "cycle", "cycle", {**of_map, **start}
        if told == "space" or (model.n_blocks > 2 and told is None):
            yield "basins", "basins", {**of_map, "resolution": 1e-3}
    if model.plant.rubs_as_one and of_line and not model.plant.n_waves:
        yield "locus", "locus", {}
    until = state.get("t_end", 120)
    yield "motion", "motion", {**of_map, **start, "t_end": until, "samples": 500}


def _of_line(
    state: dict[str, Any], asked: dict[str, Any]
) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """List what is asked of a map of the line."""
    of_map = {name: value for name, value in asked.items() if name == "section"}
    along, window = state["diagram"], state.get("window")
    shown = {name: box[:2] for name, box in state.get("windows", {}).items()}
    for name, power, max_period in (
        ("map", 1, state.get("max_period", 4)),
        ("power", state.get("power", 2), 0),
    ):
        drawn = {"window": shown.get(name, window), "points": 500}
        yield name, "event_map", {**of_map, **drawn, "power": power, "max_period": max_period}
    yield "cobweb", "cobweb", {**asked, "n": 160}
    yield "basins", "basins", {**of_map, "resolution": 1e-3}
    moved = model_of_values(state["model"]).replace(**{along["parameter"]: along["range"][0]})
    yield "diagram", "diagram", {**of_map, **along, "model": model_values(moved), "values": 120}


def law_range(model: Model) -> float:
    """Slip speeds that show the laws' shapes: some times the belts', and the speeds in the laws."""
    speeds = [*np.abs(model.plant.V).tolist()]
    speeds += [law.parameters["speed"] for law in model.laws if isinstance(law, Stribeck)]
    return float(max(0.5, *(4 * speed for speed in speeds)))


def start_state(model: Model, state: dict[str, Any]) -> dict[str, list[float]]:
    """Displacements and velocities that a motion starts with, as long as the model's."""
    n = model.plant.n_bodies
    x, v = (
        (state.get(name, default) + [0.0] * n)[:n] for name, default in (("x", [0.1]), ("v", []))
    )
    return {"x": x, "v": v if model.plant.n_positions else []}


def listed(views: Sequence[dict[str, Any]] | None = None) -> dict[str, tuple[str, dict[str, Any]]]:
    """View and request of each answer, by the name of its file; equal ones are listed once."""
    found: dict[str, tuple[str, dict[str, Any]]] = {}
    for preset in presets() if views is None else views:
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
    if isinstance(asked, Cycle):  # its samples are for files
        kept = [replace(part, arrays={}) for part in kept]
    return b"".join(message(plain(_header(view, part)), _single(part)) for part in kept)


def _header(view: str, part: Part) -> dict[str, Any]:
    data = {name: value for name, value in part.data.items() if name not in UNREAD}
    return {"view": view, "progress": 1.0, "data": {"part_name": part.name, **data}}


def _single(part: Part) -> dict[str, Any]:
    return {
        name: _rounded(array) if array.dtype.kind == "f" else array
        for name, array in part.arrays.items()
    }


def _rounded(array: Floats) -> NDArray[np.float32]:
    """Round to single precision; what has grown beyond it is not there, so that the rest shows."""
    beyond = np.isfinite(array) & (np.abs(array) > np.finfo(np.float32).max)
    return np.where(beyond, np.nan, array).astype(np.float32)


def make(folder: Path) -> None:
    """Write all answers, and the list of them."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / PRESETS).write_bytes(msgspec.json.encode(made_presets()) + b"\n")
    (folder / LIMITS).write_bytes(msgspec.json.encode(described_limits()) + b"\n")
    entries = []
    for name, asked in listed().items():
        entries.append(_made(folder, name, *asked))
        print(name, (folder / name).stat().st_size, flush=True)
    (folder / INDEX).write_bytes(msgspec.json.encode(entries) + b"\n")


def _made(folder: Path, name: str, view: str, request: dict[str, Any]) -> dict[str, Any]:
    """Write an answer and return its entry in the list."""
    (folder / name).write_bytes(gzip.compress(answer(view, request), mtime=0))
    return {"file": name, "view": view, "request": request}


def _begun(plant: dict[str, Any]) -> dict[str, Any]:
    """Tell where motions of a plant that was opened start, and along what its diagram goes."""
    known = model_of_values(plant["state"]["model"]).parameters
    along = next((name for name in ("V", "V_1") if name in known), next(iter(known)))
    about = sorted(round(share * known[along], 12) for share in (0.98, 1.02))  # as the page has it
    diagram = {"parameter": along, "range": about, "window": None, "max_period": 4}
    return plant | {"state": {"d": 0.1, "diagram": diagram, **plant["state"]}}


def _add(folder: Path, plant: dict[str, Any]) -> None:
    """Add the answers of a plant that was opened: all that it has, such as basins of a map."""
    entries = msgspec.json.decode((folder / INDEX).read_bytes())
    for name, asked in listed([plant]).items():
        with suppress(ValueError):
            entries.append(_made(folder, name, *asked))
    (folder / INDEX).write_bytes(msgspec.json.encode(entries) + b"\n")


def read(name: str, folder: Path = SHIPPED) -> bytes:
    """Messages of an answer that is shipped."""
    return gzip.decompress((folder / name).read_bytes())


def export(place: Path, first: dict[str, Any] | None = None) -> Path:
    """Write the page: into a folder for a web server, or one ``.html`` file that loads nothing.

    It begins with `first`, a preset of the page or of a plant that was opened.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if place.suffix == ".html":
            with whole_file(place) as temporary:
                _export(folder, first)
                temporary.write_text(one_file(folder), encoding="utf-8")
            return place
        place.mkdir(parents=True, exist_ok=True)
        _export(folder, first)
        # The page comes last: where there is no room for all of them, there is none.
        for path in sorted(filter(Path.is_file, folder.rglob("*")), key=lambda p: p.name == PAGE):
            copy = place / path.relative_to(folder)
            copy.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(copy) as temporary:
                temporary.write_bytes(path.read_bytes())
    return place / PAGE


def _export(folder: Path, first: dict[str, Any] | None) -> None:
    static = folder / "static"
    shutil.copytree(STATIC, static)
    live.write(static / "live")
    if first is not None and first not in presets():
        first = _begun(first)
        _add(static / SHIPPED.name, first)
    views = presets() if first is None else [first, *(v for v in presets() if v != first)]
    (static / SHIPPED.name / PRESETS).write_bytes(msgspec.json.encode(views))
    alone = page().replace('<html lang="en"', '<html lang="en" data-alone', 1)
    alone = alone.replace("</body>", f"  {NO_SERVER}\n  </body>")
    (folder / PAGE).write_text(alone, encoding="utf-8")


if __name__ == "__main__":
    make(SHIPPED)
