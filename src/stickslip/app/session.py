"""One open page: its requests answered in parts, the latest of each slot winning."""

from __future__ import annotations

import asyncio
import logging
import time
from collections import deque
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import anyio
from starlette.requests import HTTPConnection
from starlette.websockets import WebSocket, WebSocketDisconnect

from stickslip.app.compiler import Compiler
from stickslip.app.jobs import CalledOffError, Gate, Job, TimeIsUpError
from stickslip.app.requests import (
    BadRequestError,
    Message,
    Part,
    Request,
    decoded,
    is_ours,
    message,
    request_of,
)
from stickslip.app.views import VIEWS, is_slow
from stickslip.files import plain

LOG: Final = logging.getLogger(__name__)

AT_ONCE: Final = 2  # quick jobs of a page in threads, and slow ones
SLOTS: Final = 16  # that a page may ask in
TRY_AGAIN: Final = 1013  # code with which a page is closed for want of room
PAUSE: Final = 1e-3  # seconds after each message of a page, and to it: others are heard, too
SHARE: Final = 8e-3  # seconds for which each message of a client counts, all its pages together
BEAT: Final = 1.0  # seconds between two words to a page that waits, whatever is computed for it
BURST: Final = 0.5  # seconds of them that are heard without waiting


@dataclass(frozen=True)
class Limits:
    """What one page, and all of them together, may use."""

    # When all connections are taken, a newcomer takes the place of a page of the client that has
    # most of them, if that has more than the newcomer's would then.

    connections: int = 128
    seconds: float = 20.0  # for which a quick request may compute, waiting aside
    slow_seconds: float = 180.0
    unsent: int = 64 * 2**20  # bytes of answers that wait for a page that does not read them


class Workers:
    """Threads that compute, and the gate at which they take turns."""

    def __init__(self, slots: int, limits: Limits) -> None:
        self.limits = limits
        self.gate = Gate(slots)
        self.compiler = Compiler()
        # Most threads wait at the gate.
        self.pool = ThreadPoolExecutor(2 * AT_ONCE * limits.connections + slots, "explorer")
        self._heard: dict[str, float] = {}

    def pause(self, client: str) -> float:
        """Note a message of a client; tell for how many seconds its page is not listened to."""
        now = time.monotonic()
        self._heard = {who: until for who, until in self._heard.items() if until > now - BURST}
        self._heard[client] = self._heard.get(client, now - BURST) + SHARE
        return max(PAUSE, self._heard[client] - now)


@dataclass(frozen=True)
class _Call:
    """A request, and what the header of every part of its answer says."""

    header: dict[str, Any]
    request: Request


@dataclass(eq=False)
class _Lane:
    """A slot of a page: the request being answered, and the one that comes next."""

    running: Job | None = None
    waiting: _Call | None = None
    is_served: bool = False


class Session:
    """Answer the requests of one page until it closes."""

    # Pages of one `client`, an address, share what is due to it; `heard` is when this one last
    # asked.

    def __init__(self, socket: WebSocket, workers: Workers) -> None:
        self.client = client_of(socket)
        self.heard = time.monotonic()
        self._socket = socket
        self._farewell = ""
        self._workers = workers
        self._lanes: dict[str, _Lane] = {}
        self._turns = {slow: asyncio.Semaphore(AT_ONCE) for slow in (False, True)}
        self._loop = asyncio.get_running_loop()
        self._unsent: deque[bytes] = deque()
        self._unsent_size = 0
        self._news = asyncio.Event()

    async def run(self) -> None:
        """Read requests and write answers until either side ends it."""
        async with anyio.create_task_group() as self._tasks:
            self._tasks.start_soon(self._until_closed, self._read)
            self._tasks.start_soon(self._until_closed, self._write)
            self._tasks.start_soon(self._beat)
        if self._farewell:
            with suppress(RuntimeError):  # it has gone meanwhile
                await self._socket.close(TRY_AGAIN, self._farewell)

    def dismiss(self, reason: str) -> None:
        """End the session from this side."""
        self._farewell = reason
        self._end()

    async def _until_closed(self, task: Callable[[], Awaitable[None]]) -> None:
        """Read or write until either ends, which ends the other and all work."""
        with suppress(WebSocketDisconnect):
            await task()
        self._end()

    def _end(self) -> None:
        for lane in self._lanes.values():
            self._call_off(lane)
        self._tasks.cancel_scope.cancel()

    # --- writing ------------------------------------------------------------------------------

    def send(self, header: dict[str, Any], arrays: Any = None) -> None:
        """Send a message, when its turn comes; from any thread."""
        content = message(plain(header), arrays)
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(self._append, content)

    def _append(self, content: bytes) -> None:
        self._unsent.append(content)
        self._unsent_size += len(content)
        self._news.set()
        if self._unsent_size > self._workers.limits.unsent:
            LOG.warning("a page that does not read its answers is closed")
            self._end()

    async def _write(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            while self._unsent:
                content = self._unsent.popleft()
                self._unsent_size -= len(content)
                await self._socket.send_bytes(content)

    async def _beat(self) -> None:
        """Give a sign of life while something is asked: a long answer is none for long."""
        while True:
            await asyncio.sleep(BEAT)
            if any(lane.is_served for lane in self._lanes.values()):
                self.send({"id": 0, "view": "beat", "last": True, "data": {"part_name": "beat"}})

    # --- reading ------------------------------------------------------------------------------

    async def _read(self) -> None:
        while True:
            received = await self._socket.receive()
            if received["type"] == "websocket.disconnect":
                raise WebSocketDisconnect(received.get("code", 1005))
            self.heard = time.monotonic()
            try:
                content = received.get("text") or received.get("bytes") or b""
                self._take(decoded(content, Message))
            except BadRequestError as error:
                self.send({"id": None, "view": "", "last": True, "error": _told(error)})
            await asyncio.sleep(self._workers.pause(self.client))

    def _take(self, asked: Message) -> None:
        if asked.cancel is not None:
            self._call_off(self._lanes.get(asked.cancel, _Lane()))
            return
        try:
            call = _Call(_header(asked), request_of(asked.view, asked.request))
            lane = self._lane(asked.place)
        except BadRequestError as error:
            self.send(_header(asked) | {"last": True, "error": _told(error)})
            return
        self._call_off(lane)
        lane.waiting = call
        if not lane.is_served:
            lane.is_served = True
            self._tasks.start_soon(self._serve, lane)

    def _lane(self, slot: str) -> _Lane:
        if slot not in self._lanes and len(self._lanes) >= SLOTS:
            raise BadRequestError(f"slot = {slot!r}: a page has {SLOTS} slots at most", "slot")
        return self._lanes.setdefault(slot, _Lane())

    def _call_off(self, lane: _Lane) -> None:
        if lane.running is not None:
            lane.running.call_off()
        if lane.waiting is not None:
            self.send(lane.waiting.header | {"last": True, "cancelled": True})
            lane.waiting = None

    async def _serve(self, lane: _Lane) -> None:
        """Answer what waits in a slot until nothing does."""
        while (first := lane.waiting) is not None:
            turns = self._turns[slow := is_slow(first.request)]
            if slow and turns.locked():
                data = {"part_name": "progress", "waiting": True}
                self.send(first.header | {"last": False, "progress": 0.0, "data": data})
            async with turns:
                call, lane.waiting = lane.waiting, None
                if call is None:
                    continue
                lane.running = self._job(call)
                try:
                    await self._loop.run_in_executor(
                        self._workers.pool, self._answer, lane.running, call
                    )
                finally:
                    lane.running = None
        lane.is_served = False

    def _job(self, call: _Call) -> Job:
        slow = is_slow(call.request)
        limits = self._workers.limits
        seconds = limits.slow_seconds if slow else limits.seconds
        report = partial(self._report, call)
        gate = self._workers.gate
        return Job(gate, id(self), seconds, client=self.client, patient=slow, report=report)

    # --- in a thread --------------------------------------------------------------------------

    def _report(self, call: _Call, share: float) -> None:
        part = {"last": False, "progress": share, "data": {"part_name": "progress"}}
        self.send(call.header | part)

    def _patience(self, job: Job, call: _Call) -> Callable[[], None]:
        """Check whether an answer is wanted while kernels are compiled, and tell how long it is."""
        begun = told = time.monotonic()

        def check() -> None:
            nonlocal told
            job.check_wanted()
            if (now := time.monotonic()) - told > 1.0:
                told = now
                data = {"part_name": "progress", "compiling": round(now - begun)}
                self.send(call.header | {"last": False, "progress": 0.0, "data": data})

        return check

    def _answer(self, job: Job, call: _Call) -> None:
        """Compute an answer and send its parts, then why it ends."""
        try:
            self._workers.compiler.prepare([call.request], check=self._patience(job, call))
            with job.running():
                for number, part in enumerate(VIEWS[type(call.request)](call.request)):
                    job.check()
                    self.send(call.header | described(part, number), part.arrays)
                    time.sleep(PAUSE)  # or it is sent only when this work lets the interpreter go
            ending: dict[str, Any] = {"progress": 1.0, "data": {"part_name": "end"}}
        except CalledOffError:
            ending = {"cancelled": True}
        except (Exception, TimeIsUpError) as error:
            ending = {"error": told(error, call.request)}
        self.send(call.header | {"last": True} | ending)


def told(error: BaseException, request: Request) -> dict[str, str]:
    """Tell the user of an error; one that is nobody's fault but the program's goes to the log."""
    match error:
        case BadRequestError():
            return _told(error)
        case TimeIsUpError():
            return {"message": TOO_LONG, "field": ""}
        case ValueError() if is_ours(error):  # what models and maps say of what they cannot use
            return _told(BadRequestError(str(error)))
    LOG.error("%s failed for %r", type(request).__name__, request, exc_info=error)
    return {"message": FAILED, "field": ""}


TOO_LONG: Final = (
    "took too long. Ask for a smaller window, fewer points, shorter periods or motions."
)
FAILED: Final = "a fault of the program: this view failed. The log of the server tells why."
LONGEST: Final = 1000  # characters of a message


def client_of(connection: HTTPConnection) -> str:
    """Address that a request comes from."""
    return connection.client.host if connection.client else ""


def described(part: Part, number: int) -> dict[str, Any]:
    """Header of a part of an answer."""
    data = {"part_name": part.name, **part.data}
    return {"part": number, "last": False, "progress": part.progress, "data": data}


def _header(asked: Message) -> dict[str, Any]:
    return {"id": asked.id, "view": asked.view, "slot": asked.place}


def _told(error: BadRequestError) -> dict[str, str]:
    text = str(error)
    short = text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
    return {"message": short, "field": error.field[:LONGEST]}
