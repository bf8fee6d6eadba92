"""The web server: the page, what its controls are built from, and its WebSocket."""

from __future__ import annotations

import logging
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final

import msgspec
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from stickslip.app.downloads import Downloads
from stickslip.app.headers import SafeHeaders, hosts_of
from stickslip.app.limits import described_limits
from stickslip.app.presets import presets
from stickslip.app.session import Limits, Session, Workers
from stickslip.app.warmth import Warmth
from stickslip.numerics.targets import available_threads

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

__all__ = ["application"]

LOG: Final = logging.getLogger(__name__)

LIMITS: Final = Limits()
TRY_AGAIN: Final = 1013


@cache
def _json(what: str) -> bytes:
    content: Any = {"presets": presets, "limits": described_limits}[what]()
    return msgspec.json.encode(content)


def application(
    *,
    host: str = "127.0.0.1",
    limits: Limits = LIMITS,
    framed_by: tuple[str, ...] = (),
    warm: bool = True,
) -> Starlette:
    """Build the explorer.

    Parameters
    ----------
    host : str
        Address that it is served at; requests that name another host are refused, unless it is
        served at all addresses.
    limits : Limits
        What users may take.
    framed_by : tuple of str
        Origins, besides its own, whose pages may show it in a frame.
    warm : bool
        Whether to compile the kernels in the background at once.

    Returns
    -------
    Starlette
    """
    workers = Workers(available_threads(), limits)
    warmth = Warmth()
    open_pages: set[Session] = set()
    static = files("stickslip.app") / "static"

    async def page(_: Request) -> Response:
        return FileResponse(str(static / "index.html"))

    async def health(_: Request) -> Response:
        state = {"status": "ok", "warm": warmth.is_warm, "pages": len(open_pages)}
        return Response(msgspec.json.encode(state), media_type="application/json")

    async def listed(request: Request) -> Response:
        what = request.url.path.removeprefix("/").removesuffix(".json")
        return Response(_json(what), media_type="application/json")

    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        if len(open_pages) >= limits.connections:
            await socket.close(TRY_AGAIN, "too many pages are open")
            return
        session = Session(socket, workers)
        open_pages.add(session)
        try:
            warmth.greet(session)
            await session.run()
        finally:
            open_pages.discard(session)

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        if warm:
            threading.Thread(target=warmth.warm_up, daemon=True).start()
        yield
        workers.pool.shutdown(wait=False, cancel_futures=True)

    routes = [
        Route("/", page),
        Route("/healthz", health),
        Route("/presets.json", listed),
        Route("/limits.json", listed),
        Route("/export", Downloads(workers).answer, methods=["POST"]),
        WebSocketRoute("/ws", talk),
        Mount("/static", StaticFiles(directory=str(static))),
    ]
    middleware = [Middleware(SafeHeaders, hosts=hosts_of(host), framed_by=framed_by)]
    return Starlette(routes=routes, middleware=middleware, lifespan=lifespan)
