"""The web server: the page, what its controls are built from, and its WebSocket."""

from __future__ import annotations

from collections import Counter
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
from stickslip.app.session import TRY_AGAIN, Limits, Session, Workers
from stickslip.app.warmth import Warmth
from stickslip.numerics.targets import available_threads

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

STATIC: Final = files("stickslip.app") / "static"
LIMITS: Final = Limits()
FULL: Final = "too many pages are open"


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
    """Build the explorer, `warm` if it compiles kernels in the background at once."""
    # Requests that name another host than `host` are refused, unless it is served at all addresses.
    # Pages of its own origin and of `framed_by` may show it in a frame.
    explorer = _Explorer(limits, warm)
    routes = [
        Route("/", explorer.page),
        Route("/healthz", explorer.health),
        Route("/presets.json", explorer.listed),
        Route("/limits.json", explorer.listed),
        Route("/export", explorer.downloads.answer, methods=["POST"]),
        WebSocketRoute("/ws", explorer.talk),
        Mount("/static", StaticFiles(directory=str(STATIC))),
    ]
    middleware = [Middleware(SafeHeaders, hosts=hosts_of(host), framed_by=framed_by)]
    return Starlette(routes=routes, middleware=middleware, lifespan=explorer.lifespan)


class _Explorer:
    """What the routes lead to, and what they share."""

    def __init__(self, limits: Limits, warm: bool) -> None:
        self._limits = limits
        self._warm = warm
        self._workers = Workers(available_threads(), limits)
        self._warmth = Warmth(self._workers.gate, self._workers.compiler)
        self._open: set[Session] = set()
        self.downloads = Downloads(self._workers)

    @asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        if self._warm:
            self._warmth.start()
        yield
        self._workers.compiler.stop()
        self._workers.pool.shutdown(wait=False, cancel_futures=True)

    async def page(self, _: Request) -> Response:
        return FileResponse(str(STATIC / "index.html"))

    async def health(self, _: Request) -> Response:
        state = {"status": "ok", "warm": self._warmth.is_warm, "pages": len(self._open)}
        return Response(msgspec.json.encode(state), media_type="application/json")

    async def listed(self, request: Request) -> Response:
        what = request.url.path.removeprefix("/").removesuffix(".json")
        return Response(_json(what), media_type="application/json")

    async def talk(self, socket: WebSocket) -> None:
        await socket.accept()
        session = Session(socket, self._workers)
        if not self._has_room(session.client):
            await socket.close(TRY_AGAIN, FULL)
            return
        self._open.add(session)
        try:
            self._warmth.greet(session)
            await session.run()
        finally:
            self._open.discard(session)
            self._warmth.forget(session)

    def _has_room(self, client: str) -> bool:
        """Tell whether one more page fits, if need be in place of a greedier client's."""
        if len(self._open) < self._limits.connections:
            return True
        pages = Counter(session.client for session in self._open)
        ((greedy, most),) = pages.most_common(1)
        if pages[client] + 1 >= most:
            return False
        theirs = [session for session in self._open if session.client == greedy]
        idlest = min(theirs, key=lambda session: session.heard)
        self._open.discard(idlest)
        idlest.dismiss(FULL)
        return True
