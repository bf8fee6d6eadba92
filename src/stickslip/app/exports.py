"""Views as files: which formats each has, and who makes them."""

from __future__ import annotations

from typing import Final, NamedTuple

from stickslip.app import requests
from stickslip.app.as_python import as_python
from stickslip.app.pictures import DRAWN, film_of, picture_of
from stickslip.app.requests import BadRequestError
from stickslip.app.tables import COLUMNS, as_csv, as_json
from stickslip.app.views import VIEWS
from stickslip.plot.animation import can_write
from stickslip.vocabulary import did_you_mean

KNOWN: Final = requests.REQUESTS | requests.PICTURES
TYPES: Final = {
    "svg": "image/svg+xml",
    "png": "image/png",
    "csv": "text/csv",
    "json": "application/json",
    "gif": "image/gif",
    "mp4": "video/mp4",
    "python": "text/x-python",
}


class NotHereError(Exception):
    """A format that this machine cannot write."""


class File(NamedTuple):
    """What is sent: content, media type and name."""

    content: bytes
    media_type: str
    name: str


def formats(view: str) -> list[str]:
    """Return the formats of a view, those aside that this machine cannot write."""
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
