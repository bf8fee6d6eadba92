"""The web server: the page, and the way to what computes for it; running it.

Headers of all answers keep other web pages out. It runs in the foreground for the command line, in
a thread for a notebook.
"""

from __future__ import annotations

import asyncio
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import msgspec
import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from stickslip.app.folder import LIMITS, PRESETS, SHIPPED, STATIC, allowed, page, presets

if TYPE_CHECKING:
    from stickslip.app.explorer import Explorer
    from stickslip.app.session import Limits

LOCAL: Final = ("127.0.0.1", "localhost", "[::1]")
EVERYWHERE: Final = ("0.0.0.0", "::")
POLICY_VIOLATION: Final = 1008
POLICY: Final = (
    "default-src 'self'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; object-src 'none'; frame-ancestors 'self'"
)

ALONE: Final = 1.0  # seconds for which files alone are served before a page comes


def hosts_of(host: str) -> tuple[str, ...]:
    """Names by which a server at this address may be asked; none if it is at all addresses."""
    if host in EVERYWHERE:
        return ()
    return (*LOCAL, f"[{host}]" if ":" in host else host)


class SafeHeaders:
    """Add headers to every answer, and refuse requests of other sites' pages."""

    # Browsers name the page's origin with what it posts and with WebSockets. A site that has its
    # own name resolved to this machine names a foreign host: `hosts` are taken, any if empty.

    def __init__(self, app: ASGIApp, *, hosts: tuple[str, ...], framed_by: tuple[str, ...]) -> None:
        self.app = app
        self.hosts = hosts
        self.headers = {
            "content-security-policy": " ".join((POLICY, *framed_by)),
            "x-content-type-options": "nosniff",
            "referrer-policy": "no-referrer",
            "cross-origin-resource-policy": "same-origin",
            "permissions-policy": "camera=(), geolocation=(), microphone=()",
            "cache-control": "no-cache",
        }

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        if not self._is_ours(Headers(scope=scope)):
            await self._refuse(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self.headers.items():
                    headers[name] = value
            await send(message)

        await self.app(scope, receive, send_with_headers)

    def _is_ours(self, headers: Headers) -> bool:
        host = headers.get("host", "")
        name = host[: host.rfind(":")] if host.rpartition(":")[2].isdigit() else host
        origin = headers.get("origin")
        foreign = origin is not None and urlsplit(origin).netloc != host
        return not foreign and (not self.hosts or name in self.hosts)

    async def _refuse(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": POLICY_VIOLATION})
            return
        answer = PlainTextResponse("a request of another site\n", status_code=403)
        await answer(scope, receive, send)


def application(
    *,
    host: str = "127.0.0.1",
    limits: Limits | None = None,
    framed_by: tuple[str, ...] = (),
    warm: bool = True,
    opened: dict[str, Any] | None = None,
) -> Starlette:
    """Build the explorer, `warm` if it compiles kernels in the background at once."""
    # Requests that name another host than `host` are refused, unless it is served at all addresses.
    # A preset that is `opened` comes first, before those that everybody has.
    # Pages of its own origin and of `framed_by` may show it in a frame.
    site = _Site(limits, warm, None if opened is None else opened["state"]["model"])
    listed = msgspec.json.encode(presets() if opened is None else [opened, *presets()])
    json = partial(Response, media_type="application/json")
    routes = [
        Route("/", lambda _: HTMLResponse(page())),
        Route("/healthz", lambda _: json(msgspec.json.encode(site.health()))),
        Route("/open", site.opened, methods=["POST"]),
        Route("/export", site.export, methods=["POST"]),
        WebSocketRoute("/ws", site.talk),
        Route(f"/static/{SHIPPED.name}/{PRESETS}", lambda _: json(listed)),
        Route(f"/static/{SHIPPED.name}/{LIMITS}", lambda _: json(msgspec.json.encode(allowed()))),
        Mount("/static", StaticFiles(directory=STATIC)),
    ]
    middleware = [Middleware(SafeHeaders, hosts=hosts_of(host), framed_by=framed_by)]
    return Starlette(routes=routes, middleware=middleware, lifespan=site.lifespan)


class _Site:
    """Serves files at once; what computes is loaded while the first page shows them."""

    def __init__(self, limits: Limits | None, warm: bool, model: Any = None) -> None:
        self._limits = limits
        self._model = model
        self._warm = warm
        self._greeted = asyncio.Event()
        self._explorer: Explorer | None = None

    @asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        self._loading = asyncio.create_task(self._load())
        yield
        self._loading.cancel()
        if self._explorer is not None:
            self._explorer.stop()

    async def _load(self) -> Explorer:
        with suppress(TimeoutError):
            await asyncio.wait_for(self._greeted.wait(), ALONE)
        explorer = await asyncio.to_thread(_explorer, self._limits, self._model)
        if self._warm:
            explorer.warmth.start()
        self._explorer = explorer
        return explorer

    async def _loaded(self) -> Explorer:
        self._greeted.set()
        return await asyncio.shield(self._loading)

    def health(self) -> dict[str, Any]:
        known = self._explorer
        warm, complete, pages = False, False, 0
        if known:
            warm, complete = known.warmth.is_warm, known.warmth.is_complete
            pages = len(known.pages)
        return {"status": "ok", "warm": warm, "complete": complete, "pages": pages}

    async def talk(self, socket: WebSocket) -> None:
        await (await self._loaded()).talk(socket)

    async def opened(self, request: Request) -> Response:
        return await (await self._loaded()).opened(request)

    async def export(self, request: Request) -> Response:
        return await (await self._loaded()).downloads.answer(request)


def _explorer(limits: Limits | None, model: Any) -> Explorer:
    from stickslip.app.explorer import Explorer  # loads the library

    return Explorer(limits, model)


MESSAGE_SIZE: Final = 64 * 1024  # bytes of a request; answers are larger
SWITCH: Final = 1e-3  # seconds: so that answers are sent while others compute
START_SECONDS: Final = 10.0


def listening_socket(host: str, port: int) -> socket.socket:
    """Open the port; an OSError where it is taken, or not allowed."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.create_server((host, port), family=family, backlog=128)
    # Its connections inherit this; asyncio sets it for sockets that name their protocol. Without it
    # the second part of an answer waits 40 ms for word that the first has arrived.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


def url_of(listener: socket.socket) -> str:
    """Address of the page on this machine."""
    host, port = listener.getsockname()[:2]
    if host in ("0.0.0.0", "::"):
        host = "127.0.0.1"
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def serve(
    listener: socket.socket, host: str, *, page: str | None, opened: dict[str, Any] | None = None
) -> None:
    """Serve until interrupted; open the `page` in a browser once the server runs."""
    server = _server(application(host=host, opened=opened))
    if page is not None:
        threading.Thread(target=_open_when_started, args=(server, page), daemon=True).start()
    with _quick_switches():
        server.run(sockets=[listener])


def _server(app: Starlette) -> uvicorn.Server:
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        server_header=False,
        ws_max_size=MESSAGE_SIZE,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=2,
    )
    return uvicorn.Server(config)


def _open_when_started(server: uvicorn.Server, page: str) -> None:
    while not (server.started or server.should_exit):
        time.sleep(0.05)
    if server.started:
        webbrowser.open(page)


@contextmanager
def _quick_switches() -> Iterator[None]:
    previous = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(previous)


class BackgroundServer:
    """The explorer in a thread of this process, at a free port of this machine alone."""

    def __init__(self, framed_by: tuple[str, ...] = ()) -> None:
        listener = listening_socket("127.0.0.1", 0)
        self.url = url_of(listener)
        self._server = _server(application(framed_by=framed_by))
        self._thread = threading.Thread(
            target=self._server.run, kwargs={"sockets": [listener]}, daemon=True
        )
        self._thread.start()
        end = time.monotonic() + START_SECONDS
        while not self._server.started:
            if time.monotonic() > end or not self._thread.is_alive():
                raise RuntimeError("the explorer's server did not start")
            time.sleep(0.01)

    def stop(self) -> None:
        """End the server and wait for it."""
        self._server.should_exit = True
        self._thread.join(START_SECONDS)
