"""Running the server: in the foreground for the command line, in a thread for a notebook."""

from __future__ import annotations

import logging
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import uvicorn
from starlette.applications import Starlette

from stickslip.app.server import application

MESSAGE_SIZE: Final = 64 * 1024  # bytes of a request; answers are larger
SWITCH: Final = 1e-3  # seconds: so that answers are sent while others compute
START_SECONDS: Final = 10.0


def listening_socket(host: str, port: int) -> socket.socket:
    """Open the port; an OSError where it is taken, or not allowed."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    return socket.create_server((host, port), family=family, backlog=128)


def url_of(listener: socket.socket) -> str:
    """Address of the page on this machine."""
    host, port = listener.getsockname()[:2]
    if host in ("0.0.0.0", "::"):
        host = "127.0.0.1"
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def serve(listener: socket.socket, host: str, *, page: str | None) -> None:
    """Serve until interrupted; open the `page` in a browser once the server runs."""
    logging.basicConfig(format="stickslip: %(message)s", stream=sys.stderr)
    logging.getLogger("stickslip").setLevel(logging.INFO)
    server = _server(application(host=host))
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
