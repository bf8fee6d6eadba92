"""Threads, where there are some: not in a browser, and not in one of several processes."""

from __future__ import annotations

import os
import threading
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextvars import ContextVar
from functools import cache
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable

PROCESS = "STICKSLIP_PROCESS"  # set in the environment of those that share the cores

IN_PIECES: Final[ContextVar[Callable[[Callable[[int, int], None], int, int], None] | None]] = (
    ContextVar("in_pieces", default=None)
)
"""Launches what kernels do, in this context, in place of threads: work that may be called off."""


@cache
def threads_start() -> bool:
    """Whether a thread starts here, and has a core."""
    if PROCESS in os.environ:
        return False
    try:
        threading.Thread(target=int, daemon=True).start()
    except RuntimeError:
        return False
    return True


def pool(threads: int, name: str) -> Executor:
    """Return threads that wait for tasks; without threads each task is done when it is given."""
    return ThreadPoolExecutor(threads, name) if threads_start() else _Here()


class _Here(Executor):
    """Does what it is given at once, in the thread that gives it; an interrupt goes through."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except Exception as error:
            done.set_exception(error)
        return done
