"""Views as files: which formats each has, who makes and draws them, and ``POST /export``.

Pictures are the library's own drawings of the results that a view shows. What one client may ask at
a time has bounds of its own.
"""

from __future__ import annotations

import asyncio
import csv
import io
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from operator import itemgetter
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray
from starlette.requests import Request
from starlette.responses import Response

from stickslip.app import requests
from stickslip.app.as_python import as_python
from stickslip.app.jobs import Job, TimeIsUpError
from stickslip.app.requests import (
    BadRequestError,
    Export,
    Part,
    decoded,
    is_ours,
    request_of,
)
from stickslip.app.session import Workers, client_of, told
from stickslip.app.views import VIEWS
from stickslip.files import plain
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
    requests.Mechanism: "motion",
    requests.Cycle: "cycle",
    requests.Law: "law",
    requests.Basins: "basins",
    requests.Diagram: "branches",
}
"""Views that have curves, and the part of the answer that holds them."""

OF_BIFURCATION: Final = ("kind", "error", "points", "mechanism")
"""Columns of a diagram's bifurcations, which stand between the values beside them."""

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
    """Return the formats of a view; MP4 needs a program, too."""
    kind = KNOWN[view]
    listed = ["svg", "png"] + ["csv"] * (kind in COLUMNS)
    listed += ["json"] if kind in (*VIEWS, requests.Mechanism) else []
    listed += ["gif", "mp4"] if kind is requests.Mechanism else []
    return [*listed, "python"]


def export(
    view: str, request: requests.Request, kind: str, frame: requests.Frame = requests.WHOLE
) -> File:
    """Make a file of a view, of one of its `formats`; pictures in the `frame` of the page's."""
    known = formats(view)
    if kind not in known:
        raise BadRequestError(f"format = {kind!r} of {view}. {did_you_mean(kind, known)}", "format")
    ending = "py" if kind == "python" else kind
    name = f"stickslip-{view.replace('_', '-')}.{ending}"
    return File(_content(request, kind, frame), TYPES[kind], name)


def _content(request: requests.Request, kind: str, frame: requests.Frame) -> bytes:
    match kind:
        case "python":
            return as_python(request, frame).encode()
        case "json":
            return as_json(request)
        case "csv":
            return as_csv(request).encode()
    from stickslip.app.pictures import film_of, picture_of  # loads matplotlib
    from stickslip.plot.animation import can_write

    if kind in ("gif", "mp4"):
        assert isinstance(request, requests.Mechanism)
        if not can_write(kind):
            raise NotHereError("MP4 needs the program ffmpeg on the server's machine. Take GIF.")
        return film_of(request, kind)
    return picture_of(request, kind, frame)


def as_json(request: requests.Request) -> bytes:
    """Compute a view and return request and answer as a JSON document."""
    parts = [{"name": part.name, **part.arrays, **part.data} for part in _answered(request)]
    return msgspec.json.encode(plain({"request": msgspec.to_builtins(request), "parts": parts}))


def as_csv(request: requests.Request) -> str:
    """Compute a view and return its curves, a row for each point; a diagram's bifurcations, too."""
    parts = _answered(request)
    part = next(part for part in parts if part.name == COLUMNS[type(request)])
    columns = dict(_columns(_point_rows(part)))
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    names = list(columns)
    if isinstance(request, requests.Diagram):
        found = next(part for part in parts if part.name == "bifurcations").data["bifurcations"]
        rows += [{name: item[name] for name in ("value", *OF_BIFURCATION)} for item in found]
        rows.sort(key=itemgetter("value"))
        names += OF_BIFURCATION
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _answered(request: requests.Request) -> Iterator[Part]:
    """Answer a request; what the mechanism shows is a motion."""
    kind = requests.Motion if isinstance(request, requests.Mechanism) else type(request)
    return VIEWS[kind](request)


def _point_rows(part: Part) -> Mapping[str, NDArray[Any]]:
    """Return the arrays that have a row for each point."""
    if not part.arrays:
        raise BadRequestError(part.data["why"])
    if "index" in part.arrays:  # points of a grid
        x, y = np.meshgrid(part.arrays["x"], part.arrays["y"], indexing="ij")
        points = zip(part.data["coordinates"], (x.ravel(), y.ravel()), strict=True)
        return {**dict(points), "attractor": part.arrays["index"].ravel()}
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
                return export(asked.view, request, asked.format, asked.frame)

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
