"""The web server: the page, what its controls are built from, its WebSocket; and running it.

Headers of all answers keep other web pages out. Kernels are compiled in the background, so that the
first slider moves without a wait. It runs in the foreground for the command line, in a thread for a
notebook.
"""

from __future__ import annotations

import logging
import socket
import sys
import threading
import time
import webbrowser
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from functools import cache
from importlib.resources import files
from typing import Any, Final
from urllib.parse import urlsplit

import msgspec
import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

import stickslip
from stickslip import examples
from stickslip.app import requests
from stickslip.app.compiler import Compiler
from stickslip.app.exports import LARGEST, Downloads, read_body
from stickslip.app.jobs import Gate
from stickslip.app.page import described_limits, of_model, presets
from stickslip.app.requests import BadRequestError, model_of_text
from stickslip.app.session import TRY_AGAIN, Limits, Session, Workers
from stickslip.app.views import VIEWS
from stickslip.mechanics.model.file import model_of_values, model_values
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.targets import available_threads

LOCAL: Final = ("127.0.0.1", "localhost", "[::1]")
EVERYWHERE: Final = ("0.0.0.0", "::")
POLICY_VIOLATION: Final = 1008
POLICY: Final = (
    "default-src 'self'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; object-src 'none'; frame-ancestors 'self'"
)

LOG: Final = logging.getLogger(__name__)
WINDOW: Final = (0.38, 0.39)  # of law (9), where every motion soon returns
STATIC: Final = files("stickslip.app") / "static"
LIMITS: Final = Limits()
FULL: Final = "too many pages are open"
ALONE: Final = 1.0  # seconds that a server waits for its first page before it prepares kernels


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


class Warmth:
    """Whether the kernels are compiled, and who wants to know."""

    def __init__(self, gate: Gate, compiler: Compiler) -> None:
        self._gate = gate
        self._compiler = compiler
        self._lock = threading.Lock()
        self._cold_pages: list[Session] = []
        self._steps = {"done": 0, "of": 1}
        self._greeted = threading.Event()
        self.is_warm = False

    def greet(self, session: Session) -> None:
        """Tell a page whether it has to wait, and later when the wait is over."""
        self._greeted.set()
        with self._lock:
            if not self.is_warm:
                self._cold_pages.append(session)
            session.send(self._hello())

    def forget(self, session: Session) -> None:
        """Drop a page that is closed."""
        with self._lock:
            if session in self._cold_pages:
                self._cold_pages.remove(session)

    def _hello(self) -> dict[str, Any]:
        data = {
            "part_name": "hello",
            "warm": self.is_warm,
            "steps": self._steps,
            "version": stickslip.__version__,
        }
        return {"id": 0, "view": "hello", "part": 0, "last": True, "data": data}

    def start(self) -> None:
        """Compile in the background; until then no job begins: it would wait for the compiler."""
        self._gate.shut()
        threading.Thread(target=self._warm_up, daemon=True).start()

    def _tell(self, done: int, of: int) -> None:
        """Tell the pages that wait how far it is."""
        with self._lock:
            self._steps = {"done": done, "of": of}
            for session in self._cold_pages:
                session.send(self._hello())

    def _warm_up(self) -> None:
        self._greeted.wait(ALONE)  # or the first page's scripts would wait for kernels
        started = time.perf_counter()
        first = list(_first_asked())
        try:
            self._compiler.prepare(first, self._tell)
            for request in first:
                for _ in VIEWS[type(request)](request):
                    pass
            LOG.info("kernels are ready after %.1f s", time.perf_counter() - started)
        finally:
            self.is_warm = True
            self._tell(1, 1)
            self._cold_pages.clear()
            self._gate.open()


def _first_asked() -> Iterator[requests.Request]:
    for model in (examples.coulomb(), examples.law9()):
        values = model_values(model)
        yield requests.EventMap(values, window=WINDOW, points=50, max_period=2)
        yield requests.Motion(values, d=0.1, t_end=20.0)
        yield requests.Cobweb(values, d=0.1, n=5)
    values = model_values(examples.coulomb())
    yield requests.Basins(values)
    yield requests.Diagram(
        values, parameter="V", range=(0.0369, 0.037), window=(-0.1, 0.05), values=2, max_period=1
    )
    for preset in presets():
        each = model_of_values(preset["state"]["model"])
        if not isinstance(each, TwoBlock):
            x = (0.0,) * each.plant.n_bodies
            v = x if each.plant.n_positions else ()
            yield requests.Motion(preset["state"]["model"], x=x, v=v, t_end=20.0)


@cache
def _limits() -> bytes:
    return msgspec.json.encode(described_limits())


def application(
    *,
    host: str = "127.0.0.1",
    limits: Limits = LIMITS,
    framed_by: tuple[str, ...] = (),
    warm: bool = True,
    opened: dict[str, Any] | None = None,
) -> Starlette:
    """Build the explorer, `warm` if it compiles kernels in the background at once."""
    # Requests that name another host than `host` are refused, unless it is served at all addresses.
    # A preset that is `opened` comes first, before those that everybody has.
    # Pages of its own origin and of `framed_by` may show it in a frame.
    explorer = _Explorer(limits, warm, opened)
    routes = [
        Route("/", explorer.page),
        Route("/healthz", explorer.health),
        Route("/presets.json", explorer.listed),
        Route("/limits.json", explorer.listed),
        Route("/open", explorer.opened, methods=["POST"]),
        Route("/export", explorer.downloads.answer, methods=["POST"]),
        WebSocketRoute("/ws", explorer.talk),
        Mount("/static", StaticFiles(directory=str(STATIC))),
    ]
    middleware = [Middleware(SafeHeaders, hosts=hosts_of(host), framed_by=framed_by)]
    return Starlette(routes=routes, middleware=middleware, lifespan=explorer.lifespan)


class _Explorer:
    """What the routes lead to, and what they share."""

    def __init__(self, limits: Limits, warm: bool, opened: dict[str, Any] | None) -> None:
        self._limits = limits
        self._opened = [] if opened is None else [opened]
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
        content: Any = _limits()
        if request.url.path == "/presets.json":
            content = msgspec.json.encode([*self._opened, *presets()])
        return Response(content, media_type="application/json")

    async def opened(self, request: Request) -> Response:
        """Answer a model file with the state that the page begins with."""
        content = await read_body(request)
        answer: dict[str, Any]
        try:
            if content is None:
                raise BadRequestError(f"a model file has {LARGEST} bytes at most")
            answer, code = {"state": of_model(model_of_text(content))}, 200
        except BadRequestError as error:
            answer, code = {"error": str(error)}, 422
        return Response(msgspec.json.encode(answer), code, media_type="application/json")

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
    logging.basicConfig(format="stickslip: %(message)s", stream=sys.stderr)
    logging.getLogger("stickslip").setLevel(logging.INFO)
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
