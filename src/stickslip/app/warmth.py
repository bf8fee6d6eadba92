"""Kernels compiled in the background, so that the first slider moves without a wait."""

from __future__ import annotations

import logging
import threading
import time
from typing import TYPE_CHECKING, Any, Final

import stickslip
from stickslip import examples
from stickslip.app import requests
from stickslip.app.views import VIEWS
from stickslip.study.model_values import model_values

if TYPE_CHECKING:
    from stickslip.app.session import Session

__all__ = ["Warmth"]

LOG: Final = logging.getLogger(__name__)


class Warmth:
    """Whether the kernels are compiled, and who wants to know."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._cold_pages: list[Session] = []
        self.is_warm = False

    def greet(self, session: Session) -> None:
        """Tell a page whether it has to wait, and later when the wait is over."""
        with self._lock:
            if not self.is_warm:
                self._cold_pages.append(session)
            session.send(self._hello())

    def _hello(self) -> dict[str, Any]:
        data = {"part_name": "hello", "warm": self.is_warm, "version": stickslip.__version__}
        return {"id": 0, "view": "hello", "part": 0, "last": True, "data": data}

    def warm_up(self) -> None:
        """Ask one of everything that compiles."""
        started = time.perf_counter()
        for model in (examples.coulomb(), examples.law9()):
            values = model_values(model)
            asked: list[requests.Request] = [
                requests.EventMap(values, window=(0.38, 0.39), points=50, max_period=2),
                requests.Motion(values, d=0.1, t_end=20.0),
                requests.Cobweb(values, d=0.1, n=5),
            ]
            for request in asked:
                for _ in VIEWS[type(request)](request):
                    pass
        LOG.info("kernels are ready after %.1f s", time.perf_counter() - started)
        with self._lock:
            self.is_warm = True
            for session in self._cold_pages:
                session.send(self._hello())
            self._cold_pages.clear()
