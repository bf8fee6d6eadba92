"""One open page: its requests answered in parts, the latest of each view winning."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from starlette.websockets import WebSocketDisconnect

from stickslip.app.answers import message, plain
from stickslip.app.jobs import CalledOffError, Gate, Job, TimeIsUpError
from stickslip.app.requests import BadRequestError, message_of, request_of
from stickslip.app.views import SLOW, VIEWS

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from stickslip.app.answers import Part
    from stickslip.app.requests import Message, Request

__all__ = ["Limits", "Session", "Workers"]

LOG: Final = logging.getLogger(__name__)

TRY_AGAIN: Final = 1013  # close code


@dataclass(frozen=True)
class Limits:
    """What one page, and all of them together, may use.

    Attributes
    ----------
    connections : int
        Pages open at a time.
    seconds, slow_seconds : float
        Time that a request of a quick and of a slow view may compute, waiting aside.
    unsent : int
        Bytes of answers that wait for a page that does not read them.
    """

    connections: int = 64
    seconds: float = 20.0
    slow_seconds: float = 180.0
    unsent: int = 64 * 2**20


class Workers:
    """Threads that compute, and the gate at which they take turns."""

    def __init__(self, slots: int, limits: Limits) -> None:
        self.limits = limits
        self.gate = Gate(slots)
        # Of each page a quick and a slow job at a time; most threads wait at the gate.
        self.pool = ThreadPoolExecutor(2 * limits.connections + slots, "explorer")


@dataclass(eq=False)
class _Lane:
    """A view of a page: the request being answered, and the one that comes next."""

    running: Job | None = None
    waiting: Message | None = None
    task: asyncio.Task[None] | None = None


class Session:
    """Answer the requests of one page until it closes.

    Parameters
    ----------
    socket : WebSocket
        Accepted.
    workers : Workers
    """

    def __init__(self, socket: WebSocket, workers: Workers) -> None:
        self._socket = socket
        self._workers = workers
        self._lanes: dict[str, _Lane] = {}
        self._turns = {"quick": asyncio.Semaphore(1), "slow": asyncio.Semaphore(1)}
        self._loop = asyncio.get_running_loop()
        self._unsent: deque[bytes] = deque()
        self._unsent_size = 0
        self._news = asyncio.Event()

    async def run(self) -> None:
        """Read requests and write answers until either side ends it."""
        tasks = {asyncio.create_task(self._read()), asyncio.create_task(self._write())}
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        except WebSocketDisconnect:
            pass
        finally:
            for lane in self._lanes.values():
                self._call_off(lane)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    # --- writing ------------------------------------------------------------------------------

    def send(self, header: dict[str, Any], arrays: Any = None) -> None:
        """Send a message, when its turn comes; from any thread."""
        content = message(plain(header), arrays)
        self._loop.call_soon_threadsafe(self._append, content)

    def _append(self, content: bytes) -> None:
        self._unsent.append(content)
        self._unsent_size += len(content)
        self._news.set()

    async def _write(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            while self._unsent:
                if self._unsent_size > self._workers.limits.unsent:
                    await self._socket.close(TRY_AGAIN, "answers are not read")
                    return
                content = self._unsent.popleft()
                self._unsent_size -= len(content)
                await self._socket.send_bytes(content)

    # --- reading ------------------------------------------------------------------------------

    async def _read(self) -> None:
        while True:
            text = await self._socket.receive_text()
            try:
                self._take(message_of(text))
            except BadRequestError as error:
                self.send({"id": None, "view": "", "last": True, "error": _told(error)})

    def _take(self, asked: Message) -> None:
        if asked.cancel is not None:
            self._call_off(self._lanes.get(asked.cancel, _Lane()))
            return
        try:
            request_of(asked.view, asked.request)
        except BadRequestError as error:
            self.send(_header(asked) | {"last": True, "error": _told(error)})
            return
        lane = self._lanes.setdefault(asked.view, _Lane())
        self._call_off(lane)
        lane.waiting = asked
        if lane.task is None or lane.task.done():
            lane.task = asyncio.create_task(self._serve(lane))

    def _call_off(self, lane: _Lane) -> None:
        if lane.running is not None:
            lane.running.call_off()
        if lane.waiting is not None:
            self.send(_header(lane.waiting) | {"last": True, "cancelled": True})
            lane.waiting = None

    async def _serve(self, lane: _Lane) -> None:
        """Answer what waits on a view until nothing does."""
        limits = self._workers.limits
        while (first := lane.waiting) is not None:
            slow = first.view in SLOW
            async with self._turns["slow" if slow else "quick"]:
                asked, lane.waiting = lane.waiting, None
                if asked is None:
                    continue
                seconds = limits.slow_seconds if slow else limits.seconds
                report = partial(self._report, asked)
                lane.running = Job(self._workers.gate, id(self), seconds, report)
                try:
                    await self._loop.run_in_executor(
                        self._workers.pool, self._answer, lane.running, asked
                    )
                finally:
                    lane.running = None

    # --- in a thread --------------------------------------------------------------------------

    def _report(self, asked: Message, share: float) -> None:
        part = {"last": False, "progress": share, "data": {"part_name": "progress"}}
        self.send(_header(asked) | part)

    def _answer(self, job: Job, asked: Message) -> None:
        """Compute an answer and send its parts, or why there is none."""
        header = _header(asked)
        try:
            request = request_of(asked.view, asked.request)
            with job.running():
                self._send_parts(header, request, job)
        except CalledOffError:
            self.send(header | {"last": True, "cancelled": True})
        except TimeIsUpError:
            self.send(header | {"last": True, "error": too_long(asked.view, self._workers.limits)})
        except BadRequestError as error:
            self.send(header | {"last": True, "error": _told(error)})
        except ValueError as error:  # what the models and maps say of values they cannot use
            self.send(header | {"last": True, "error": {"message": str(error), "field": ""}})
        except Exception:
            LOG.exception("the view %s failed for %r", asked.view, bytes(asked.request)[:2000])
            self.send(header | {"last": True, "error": FAILED})

    def _send_parts(self, header: dict[str, Any], request: Request, job: Job) -> None:
        """Send each part as soon as it is there."""
        for number, part in enumerate(VIEWS[type(request)](request)):
            job.check()
            self.send(header | described(part, number), part.arrays)
        self.send(header | {"last": True, "progress": 1.0, "data": {"part_name": "end"}})


FAILED: Final = {"message": "this view failed; the log of the server tells why", "field": ""}


def too_long(view: str, limits: Limits) -> dict[str, str]:
    """Say that the time of a request is over, and what helps."""
    seconds = limits.slow_seconds if view in SLOW else limits.seconds
    text = f"took longer than {seconds:g} s. Ask for a smaller window, fewer points or periods."
    return {"message": text, "field": ""}


def described(part: Part, number: int) -> dict[str, Any]:
    """Header of a part of an answer."""
    data = {"part_name": part.name, **part.data}
    return {"part": number, "last": False, "progress": part.progress, "data": data}


def _header(asked: Message) -> dict[str, Any]:
    return {"id": asked.id, "view": asked.view}


def _told(error: BadRequestError) -> dict[str, str]:
    return {"message": str(error), "field": error.field}
