"""What computes for the page: its conversations, models that it opens, files of what it shows.

It loads the whole library, so the server makes it when the first page is there. Kernels are
compiled in the background, so that the first slider moves without a wait.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, Final

import msgspec
from starlette.requests import Request
from starlette.responses import Response
from starlette.websockets import WebSocket

import stickslip
from stickslip import examples
from stickslip.app import requests
from stickslip.app.compiler import Compiler
from stickslip.app.exports import LARGEST, Downloads, read_body
from stickslip.app.folder import presets
from stickslip.app.jobs import CalledOffError, Gate
from stickslip.app.page import of_model
from stickslip.app.requests import BadRequestError, model_of_text
from stickslip.app.session import TRY_AGAIN, Limits, Session, Workers
from stickslip.mechanics.model.file import model_values
from stickslip.numerics.targets import available_threads

LOG: Final = logging.getLogger(__name__)
FULL: Final = "too many pages are open"


class Warmth:
    """Whether the first kernels are compiled, or all, and who wants to know."""

    def __init__(self, gate: Gate, compiler: Compiler, model: Any = None) -> None:
        self._gate = gate
        self._compiler = compiler
        self._model = model  # values of one that the page begins with
        self._lock = threading.Lock()
        self._cold_pages: list[Session] = []
        self._steps: dict[str, int] | None = None  # none until there is something to compile
        self.is_warm = self.is_complete = False

    def greet(self, session: Session) -> None:
        """Tell a page whether it has to wait, and later when the wait is over."""
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
        """Compile in the background; no job begins before the first stage: it would wait for it."""
        self._gate.shut()
        threading.Thread(target=self._warm_up, daemon=True).start()

    def _tell(self, done: int, of: int) -> None:
        """Tell the pages that wait how far it is."""
        with self._lock:
            self._steps = {"done": done, "of": of}
            for session in self._cold_pages:
                session.send(self._hello())

    def _warm_up(self) -> None:
        with suppress(CalledOffError):  # the server has ended
            self._compile_in_stages()

    def _compile_in_stages(self) -> None:
        started = time.perf_counter()
        stages = _asked_first(self._model)
        try:
            self._compiler.prepare(next(stages, ()), self._tell)
            LOG.info("kernels are ready after %.1f s", time.perf_counter() - started)
        finally:
            self.is_warm = True
            self._tell(1, 1)
            self._cold_pages.clear()
            self._gate.open()
        for asked in stages:
            self._compiler.prepare(asked)
        self.is_complete = True


def _asked_first(model: Any) -> Iterator[list[requests.Request]]:
    """Yield, in stages, what is asked of the page's model, of two blocks, of the other presets."""
    if model is not None:
        yield _asked_of(model)
    coulomb, law9 = (model_values(each) for each in (examples.coulomb(), examples.law9()))
    diagram = requests.Diagram(coulomb, parameter="V", range=(0.0369, 0.037))
    yield [*_asked_of(coulomb), requests.Basins(coulomb), diagram]
    yield _asked_of(law9)
    others = (preset["state"]["model"] for preset in presets())
    yield [requests.Motion(values) for values in others if values["kind"] != "two_block"]


def _asked_of(values: Any) -> list[requests.Request]:
    """Ask for a motion, and for the map where it is one of two blocks."""
    motion = requests.Motion(values)
    if values["kind"] != "two_block":
        return [motion]
    return [requests.EventMap(values), motion, requests.Cobweb(values, d=0.1)]


class Explorer:
    """Its pages, and what they share."""

    def __init__(self, limits: Limits | None = None, model: Any = None) -> None:
        self._limits = limits or Limits()
        self._workers = Workers(available_threads(), self._limits)
        self.warmth = Warmth(self._workers.gate, self._workers.compiler, model)
        self.pages: set[Session] = set()
        self.downloads = Downloads(self._workers)

    def stop(self) -> None:
        """End what computes and compiles."""
        self._workers.compiler.stop()
        self._workers.pool.shutdown(wait=False, cancel_futures=True)

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
        """Answer a page until it closes."""
        await socket.accept()
        session = Session(socket, self._workers)
        if not self._has_room(session.client):
            await socket.close(TRY_AGAIN, FULL)
            return
        self.pages.add(session)
        try:
            self.warmth.greet(session)
            await session.run()
        finally:
            self.pages.discard(session)
            self.warmth.forget(session)

    def _has_room(self, client: str) -> bool:
        """Tell whether one more page fits, if need be in place of a greedier client's."""
        if len(self.pages) < self._limits.connections:
            return True
        pages = Counter(session.client for session in self.pages)
        ((greedy, most),) = pages.most_common(1)
        if pages[client] + 1 >= most:
            return False
        theirs = [session for session in self.pages if session.client == greedy]
        idlest = min(theirs, key=lambda session: session.heard)
        self.pages.discard(idlest)
        idlest.dismiss(FULL)
        return True
