"""Kernels compiled in the background, so that the first slider moves without a wait."""

from __future__ import annotations

import logging
import threading
import time
from typing import TYPE_CHECKING, Any, Final

import stickslip
from stickslip import examples
from stickslip.app import requests
from stickslip.app.presets import presets
from stickslip.app.views import VIEWS
from stickslip.mechanics.model.values import model_values

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.app.compiler import Compiler
    from stickslip.app.jobs import Gate
    from stickslip.app.session import Session

LOG: Final = logging.getLogger(__name__)

WINDOW: Final = (0.38, 0.39)  # of law (9), where every motion soon returns


class Warmth:
    """Whether the kernels are compiled, and who wants to know."""

    def __init__(self, gate: Gate, compiler: Compiler) -> None:
        self._gate = gate
        self._compiler = compiler
        self._lock = threading.Lock()
        self._cold_pages: list[Session] = []
        self.is_warm = False

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
        data = {"part_name": "hello", "warm": self.is_warm, "version": stickslip.__version__}
        return {"id": 0, "view": "hello", "part": 0, "last": True, "data": data}

    def start(self) -> None:
        """Compile in the background; until then no job begins: it would wait for the compiler."""
        self._gate.shut()
        threading.Thread(target=self._warm_up, daemon=True).start()

    def _warm_up(self) -> None:
        started = time.perf_counter()
        try:
            self._compiler.prepare(_asked())
            for request in _asked():
                for _ in VIEWS[type(request)](request):
                    pass
            LOG.info("kernels are ready after %.1f s", time.perf_counter() - started)
        finally:
            with self._lock:
                self.is_warm = True
                for session in self._cold_pages:
                    session.send(self._hello())
                self._cold_pages.clear()
            self._gate.open()


def _asked() -> Iterator[requests.Request]:
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
        values = preset["state"]["model"]
        if values["kind"] != "two_block":
            rest = (0.0,) * len(values.get("static", [0.0]))
            yield requests.Motion(values, x=rest, v=rest, t_end=20.0)
