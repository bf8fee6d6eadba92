"""``POST /export``: a view as a file, with its own bounds on what one client may ask at a time."""

from __future__ import annotations

import asyncio
from collections import Counter
from typing import TYPE_CHECKING, Final

import msgspec
from starlette.responses import Response

from stickslip.app.exports import KNOWN, File, NotHereError, export
from stickslip.app.jobs import Job, TimeIsUpError
from stickslip.app.requests import BadRequestError, Export, export_of, is_ours, request_of
from stickslip.app.session import client_of, told

if TYPE_CHECKING:
    from starlette.requests import Request

    from stickslip.app import requests
    from stickslip.app.session import Workers

LARGEST: Final = 64 * 1024  # bytes of a request
AT_ONCE: Final = 3  # files that one client may wait for
IN_ALL: Final = 12  # files that are made at a time

BAD, TOO_LARGE, BUSY, BROKEN, NOT_HERE, TOO_LONG = 422, 413, 429, 500, 501, 504


class Downloads:
    """Files made by the same workers as the page's answers."""

    def __init__(self, workers: Workers) -> None:
        self._workers = workers
        self._busy: Counter[str] = Counter()

    async def answer(self, received: Request) -> Response:
        """Make the file that is asked for, or tell why not."""
        content = await _content(received)
        if content is None:
            return _refused(TOO_LARGE, f"a request has {LARGEST} bytes at most")
        try:
            asked = export_of(content)
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
            self._workers.compiler.prepare([request])
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
        except Exception as error:
            return _refused(_code_of(error), **told(error, request))
        headers = {"content-disposition": f'attachment; filename="{file.name}"'}
        return Response(file.content, media_type=file.media_type, headers=headers)


def _code_of(error: Exception) -> int:
    match error:
        case ValueError() if is_ours(error):
            return BAD
        case TimeIsUpError():
            return TOO_LONG
    return BROKEN


async def _content(received: Request) -> bytes | None:
    """Read a request, None if it is too large."""
    content = b""
    async for piece in received.stream():
        content += piece
        if len(content) > LARGEST:
            return None
    return content


def _refused(code: int, message: str, field: str = "") -> Response:
    content = msgspec.json.encode({"error": {"message": message, "field": field}})
    return Response(content, status_code=code, media_type="application/json")
