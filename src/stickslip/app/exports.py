"""Views as files: which formats each has, who makes and draws them, and ``POST /export``.

Pictures are the library's own drawings of the results that a view shows. What one client may ask at
a time has bounds of its own.
"""

from __future__ import annotations

import asyncio
import csv
import io
import math
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from starlette.requests import Request
from starlette.responses import Response

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basins import basins
from stickslip.analysis.bifurcations.bifurcations import bifurcations_of
from stickslip.analysis.diagrams.diagrams import diagram_of
from stickslip.analysis.maps.arguments import line_family
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.analysis.work import Work
from stickslip.app import requests
from stickslip.app.as_python import as_python
from stickslip.app.jobs import Job, TimeIsUpError, progress_between, undisturbed
from stickslip.app.requests import (
    BadRequestError,
    Export,
    Part,
    decoded,
    is_ours,
    model_of,
    plain,
    request_of,
)
from stickslip.app.session import Workers, client_of, told
from stickslip.app.views import VIEWS
from stickslip.app.views.diagram import surveyed
from stickslip.app.views.event_map import window_of
from stickslip.app.views.model import (
    found_cycle,
    map_of,
    naming,
    range_of,
    simulated,
    space_map_of,
    two_blocks,
)
from stickslip.app.views.section import grid_of, sides_of
from stickslip.plot.animation import can_write, film
from stickslip.plot.breaks import mechanism
from stickslip.plot.diagram import draw_diagram
from stickslip.plot.law import friction_characteristics
from stickslip.plot.locus import stick_locus, trajectory_in_plane
from stickslip.plot.maps import cobweb, event_map
from stickslip.plot.motion import phase_portrait
from stickslip.plot.orbits import draw_orbits
from stickslip.plot.style import pictured, save, style
from stickslip.vocabulary import did_you_mean

KNOWN: Final = {
    view: kind
    for view, kind in (requests.REQUESTS | requests.PICTURES).items()
    if kind is not requests.Returns
}
TYPES: Final = {
    "svg": "image/svg+xml",
    "png": "image/png",
    "csv": "text/csv",
    "json": "application/json",
    "gif": "image/gif",
    "mp4": "video/mp4",
    "python": "text/x-python",
}

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

LARGEST: Final = 64 * 1024  # bytes of a request
AT_ONCE: Final = 3  # files that one client may wait for
IN_ALL: Final = 12  # files that are made at a time


class NotHereError(Exception):
    """A format that this machine cannot write."""


class File(NamedTuple):
    """What is sent: content, media type and name."""

    content: bytes
    media_type: str
    name: str


def formats(view: str) -> list[str]:
    """Return the formats of a view that this machine can write."""
    return [kind for kind in _all_formats(KNOWN[view]) if kind != "mp4" or can_write("mp4")]


def _all_formats(kind: type[requests.Request]) -> list[str]:
    listed = ["svg", "png"] if kind in DRAWN else []
    listed += ["csv"] if kind in COLUMNS else []
    listed += ["json"] if kind in VIEWS else []
    listed += ["gif", "mp4"] if kind is requests.Mechanism else []
    return [*listed, "python"]


def export(view: str, request: requests.Request, kind: str) -> File:
    """Make a file of a view, of one of its `formats`."""
    known = _all_formats(type(request))
    if kind not in known:
        raise BadRequestError(f"format = {kind!r} of {view}. {did_you_mean(kind, known)}", "format")
    if kind == "mp4" and not can_write("mp4"):
        raise NotHereError("MP4 needs the program ffmpeg on the server's machine. Take GIF.")
    ending = "py" if kind == "python" else kind
    name = f"stickslip-{view.replace('_', '-')}.{ending}"
    return File(_content(request, kind), TYPES[kind], name)


def _content(request: requests.Request, kind: str) -> bytes:
    match kind:
        case "python":
            return as_python(request).encode()
        case "json":
            return as_json(request)
        case "csv":
            return as_csv(request).encode()
        case "gif" | "mp4":
            assert isinstance(request, requests.Mechanism)
            return film_of(request, kind)
    return picture_of(request, kind)


def as_json(request: requests.Request) -> bytes:
    """Compute a view and return request and answer as a JSON document."""
    parts = [
        {"name": part.name, **part.arrays, **part.data} for part in VIEWS[type(request)](request)
    ]
    return msgspec.json.encode(plain({"request": msgspec.to_builtins(request), "parts": parts}))


def as_csv(request: requests.Request) -> str:
    """Compute a view and return its curves, a row for each point."""
    part = next(p for p in VIEWS[type(request)](request) if p.name == COLUMNS[type(request)])
    columns = dict(_columns(_point_rows(part)))
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue()


def _point_rows(part: Part) -> Mapping[str, NDArray[Any]]:
    """Return the arrays that have a row for each point."""
    if not part.arrays:
        raise BadRequestError(part.data["why"])
    if "index" in part.arrays:  # points of a grid
        x, y = np.meshgrid(part.arrays["x"], part.arrays["y"], indexing="ij")
        return {"d_1": x.ravel(), "d_2": y.ravel(), "attractor": part.arrays["index"].ravel()}
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


BAD, TOO_LARGE, BUSY, BROKEN, NOT_HERE, TOO_LONG = 422, 413, 429, 500, 501, 504


class Downloads:
    """Files made by the same workers as the page's answers."""

    def __init__(self, workers: Workers) -> None:
        self._workers = workers
        self._busy: Counter[str] = Counter()

    async def answer(self, received: Request) -> Response:
        """Make the file that is asked for, or tell why not."""
        content = await read_body(received)
        if content is None:
            return _refused(TOO_LARGE, f"a request has {LARGEST} bytes at most")
        try:
            asked = decoded(content, Export)
            request = request_of(asked.view, asked.request, KNOWN)
        except BadRequestError as error:
            return _refused(BAD, str(error), error.field)
        client = client_of(received)
        if self._busy[client] >= AT_ONCE or self._busy.total() >= IN_ALL:
            return _refused(BUSY, "other files are being made; try again in a moment")
        self._busy[client] += 1
        try:
            return await self._made(asked, request, client)
        finally:
            self._busy[client] -= 1

    async def _made(self, asked: Export, request: requests.Request, client: str) -> Response:
        seconds = self._workers.limits.slow_seconds
        job = Job(self._workers.gate, self, seconds, client=client, patient=True)

        def work() -> File:
            self._workers.compiler.prepare([request], check=job.check_wanted)
            with job.running():
                return export(asked.view, request, asked.format)

        try:
            loop = asyncio.get_running_loop()
            file = await loop.run_in_executor(self._workers.pool, work)
        except asyncio.CancelledError:
            job.call_off()
            raise
        except NotHereError as error:
            return _refused(NOT_HERE, str(error), "format")
        except (Exception, TimeIsUpError) as error:
            return _refused(_code_of(error), **told(error, request))
        headers = {"content-disposition": f'attachment; filename="{file.name}"'}
        return Response(file.content, media_type=file.media_type, headers=headers)


def _code_of(error: BaseException) -> int:
    match error:
        case ValueError() if is_ours(error):
            return BAD
        case TimeIsUpError():
            return TOO_LONG
    return BROKEN


async def read_body(received: Request) -> bytes | None:
    """Return the body of a request, None if it is too large."""
    content = b""
    async for piece in received.stream():
        content += piece
        if len(content) > LARGEST:
            return None
    return content


def _refused(code: int, message: str, field: str = "") -> Response:
    content = msgspec.json.encode({"error": {"message": message, "field": field}})
    return Response(content, status_code=code, media_type="application/json")


HEIGHT: Final = 4.0  # inches, over the width of two columns

Draw = Callable[[Any], Any]

_drawing = threading.Lock()  # matplotlib's settings belong to the whole process


def picture_of(request: requests.Request, kind: str) -> bytes:
    """Compute and draw a view, as "svg" or "png"."""
    draw = DRAWN[type(request)](request)
    with _one_at_a_time(), TemporaryDirectory() as folder:
        (path,) = save(pictured(draw, HEIGHT), Path(folder) / "view", (kind,))
        return path.read_bytes()


def film_of(request: requests.Mechanism, kind: str) -> bytes:
    """Compute a motion and draw it as a film, "gif" or "mp4"."""
    motion = simulated(request)
    with _one_at_a_time(), TemporaryDirectory() as folder:
        path = Path(folder) / f"view.{kind}"
        film(motion, path)
        return path.read_bytes()


@contextmanager
def _one_at_a_time() -> Iterator[None]:
    """Draw in the house style; nobody's turn comes meanwhile, or two could wait for each other."""
    with undisturbed(), _drawing, style():
        yield


# --- the views: first what takes long, then a function that draws it ---------------------------


def _event_map(request: requests.EventMap) -> Draw:
    f = map_of(request)
    window = window_of(f, request)
    found = (
        periodic_orbits(f, request.max_period, infinitely_unstable=True)
        if request.max_period
        else ()
    )

    def draw(ax: Axes) -> Axes:
        g = f if request.power == 1 else f.power(request.power)
        event_map(g, ax, window=window, points=request.points, power=request.power)
        return draw_orbits(found, ax, power=request.power, clip_on=True)

    return draw


def _cobweb(request: requests.Cobweb) -> Draw:
    f = map_of(request)
    with naming("d"):
        f.evaluate(request.d)
    return lambda ax: cobweb(f, request.d, ax, steps=request.n)


def _portrait(request: requests.Portrait) -> Draw:
    motion = simulated(request)
    if request.block > motion.model.n_blocks:
        raise BadRequestError(f"block = {request.block} of {motion.model.n_blocks}", "block")
    return lambda ax: phase_portrait(motion, request.block, ax)


def _plane(request: requests.Plane) -> Draw:
    two_blocks(request)
    motion = simulated(request)
    return lambda ax: trajectory_in_plane(motion, ax)


def _mechanism(request: requests.Mechanism) -> Draw:
    motion = simulated(request)
    return lambda ax: mechanism(motion.model, ax, x=motion.x(0.0))


def _locus(request: requests.Locus) -> Draw:
    model = two_blocks(request)
    return lambda ax: stick_locus(model, ax)


def _law(request: requests.Law) -> Draw:
    model = model_of(request)
    return lambda ax: friction_characteristics(model, ax, limit=request.range)


def _basins(request: requests.Basins) -> Draw:
    if (blocks := space_map_of(request)) is not None:
        grid = grid_of(blocks, sides_of(request)[-1])
        return basins(blocks, attractors(blocks), grid=grid).plot
    f = map_of(request)
    return basins(f, attractors(f), resolution=request.resolution).plot


def _diagram(request: requests.Diagram) -> Draw:
    f = line_family(map_of(request))
    low, high = range_of(f, request)
    survey = surveyed(f, request, low, high)
    watched = Work(progress_between(0.4, 0.5))
    diagram = diagram_of(survey, np.linspace(low, high, request.values), watched)
    found = bifurcations_of(survey, progress_between(0.0, 1.0))
    return lambda ax: draw_diagram(diagram, ax, bifurcations=found)


DRAWN: Final[dict[type[requests.Request], Callable[[Any], Draw]]] = {
    requests.EventMap: _event_map,
    requests.Cobweb: _cobweb,
    requests.Motion: lambda r: simulated(r).plot,
    requests.Portrait: _portrait,
    requests.Plane: _plane,
    requests.Mechanism: _mechanism,
    requests.Cycle: lambda r: found_cycle(r).plot,
    requests.Locus: _locus,
    requests.Law: _law,
    requests.Basins: _basins,
    requests.Diagram: _diagram,
}
