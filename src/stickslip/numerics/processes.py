"""Tasks on all cores: what is Python between the kernels runs in processes of its own.

Threads would wait for each other's interpreter lock. Processes start when a piece of work is long
enough, wait for the next one, and end when none comes. What cannot travel to them is done here.
"""

from __future__ import annotations

import atexit
import importlib
import os
import signal
import threading
import time
from collections import deque
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from functools import cached_property
from pickle import PicklingError
from typing import TYPE_CHECKING, Any, Final, TypeVar

from stickslip.numerics.threads import PROCESS, threads_start

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from contextvars import ContextVar

WORTH: Final = 2.0  # seconds of work for which processes are started
MOST: Final = 16  # processes: each takes some 200 MB
IDLE: Final = 300  # seconds after which processes end
AHEAD: Final = 1  # tasks of one caller that wait for a process: others get their turn
ORPHAN: Final = 2.0  # seconds for which a process may outlive the one that started it
QUIET: Final = "ignore:resource_tracker:UserWarning"
WATCH: Final = 0.05  # seconds between two looks whether the work is still wanted

Item = TypeVar("Item")
Result = TypeVar("Result")

_travelling: Final[dict[str, ContextVar[Any]]] = {}


def travels(variable: ContextVar[Result]) -> ContextVar[Result]:
    """Let tasks in other processes see a variable of their caller's context."""
    _travelling[variable.name] = variable
    return variable


def in_processes(
    task: Callable[[Item], Result],
    items: Iterable[Item],
    tell: Callable[[float], None] = lambda share: None,
) -> Iterator[Result]:
    """Iterate over ``task(item)`` of each item, in order; on several cores where that pays.

    `tell` is told which share is done, again and again; what it raises ends the work.
    """
    waiting = deque(items)
    n, spent, lost = len(waiting), 0.0, False
    while waiting:
        done = n - len(waiting)
        is_long = done > 0 and spent / done * len(waiting) > WORTH
        if len(waiting) > 1 and not lost and (PROCESSES.are_up or is_long) and PROCESSES.start:
            yield from _sent(task, waiting, lambda left: tell(1 - left / n))
            lost = True  # if any is left
            continue
        begun = time.monotonic()
        result = task(waiting.popleft())
        spent += time.monotonic() - begun
        tell(1 - len(waiting) / n)
        yield result


def _sent(
    task: Callable[[Item], Result], waiting: deque[Item], tell: Callable[[int], None]
) -> Iterator[Result]:
    """Iterate over results from processes, until one is lost: its item waits with the rest."""
    context = {name: variable.get() for name, variable in _travelling.items()}
    sent: deque[tuple[Item, Future[Result]]] = deque()
    try:
        while waiting or sent:
            at_work = [future for _, future in sent if not future.done()]
            while waiting and len(at_work) < PROCESSES.count + AHEAD:
                item = waiting.popleft()
                at_work.append(PROCESSES.submit(_within, context, task, item))
                sent.append((item, at_work[-1]))
            tell(len(waiting) + len(sent))
            if not sent[0][1].done():  # any that ends makes room for the next
                wait(at_work, WATCH, FIRST_COMPLETED)
            if sent[0][1].done():
                result = sent[0][1].result()
                sent.popleft()
                yield result
    except (PicklingError, BrokenExecutor, CancelledError):
        waiting.extendleft(item for item, _ in reversed(sent))
    except KeyboardInterrupt:
        PROCESSES.end()
        raise
    finally:
        for _, future in sent:
            future.cancel()


def _within(context: dict[str, Any], task: Callable[[Item], Result], item: Item) -> Result:
    for name in context.keys() & _travelling.keys():  # the task may know less than its caller
        _travelling[name].set(context[name])
    return task(item)


class _Processes:
    """Processes that wait for tasks."""

    are_up = False
    niceness = 0  # of each: how far they give way to others

    def __init__(self) -> None:
        self._pool: Any = None
        self._starting = threading.Lock()

    @cached_property
    def start(self) -> bool:
        """Whether processes can start here, and there are cores for them."""
        if not threads_start():
            return False
        # Not everywhere, and slow to load: only where they are used.
        from multiprocessing import current_process

        from stickslip.numerics.kernel_cache import cache_root

        return not current_process().daemon and cache_root() is not None and self.count > 1

    @cached_property
    def count(self) -> int:
        """How many there are."""
        return min(MOST, int(importlib.import_module("loky").cpu_count()))

    def begin(self, niceness: int) -> None:
        """Start them for tasks that are about to come."""
        if self.start and not self.are_up:
            self.niceness = niceness
            self.submit(int)

    def submit(self, *task: Any) -> Future[Any]:
        """Give a task to one of them; they start, if they have not, or if one has died."""
        self.are_up = True
        pool = self._running()
        try:
            future: Future[Any] = pool.submit(*task)
        except BrokenExecutor:
            self._forget(pool)
            future = self._running().submit(*task)
        return future

    def end(self) -> None:
        """End them, whatever they do."""
        self.are_up = False
        if (pool := self._pool) is not None:
            self._forget(pool)
            pool.shutdown(kill_workers=True)

    def _running(self) -> Any:
        # One pool for all threads: loky's reusable one is each thread's own.
        with self._starting:
            if self._pool is None:
                _start_cleaner()
                own = {PROCESS: "1", "OPENBLAS_NUM_THREADS": "1"}
                self._pool = importlib.import_module("loky").ProcessPoolExecutor(
                    self.count,
                    timeout=IDLE,
                    initializer=_begin,
                    initargs=(self.niceness, os.getpid()),
                    env=own,
                )
            return self._pool

    def _forget(self, pool: Any) -> None:
        with self._starting:
            if self._pool is pool:  # another thread may have started others
                self._pool = None


PROCESSES: Final = _Processes()
atexit.register(PROCESSES.end)


def _start_cleaner() -> None:
    """Start what cleans up after processes, which tells nobody that an interrupt left it some."""
    given = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = f"{given},{QUIET}" if given else QUIET
    try:
        importlib.import_module("loky.backend.resource_tracker").ensure_running()
    finally:
        os.environ.pop("PYTHONWARNINGS")
        if given is not None:
            os.environ["PYTHONWARNINGS"] = given


def _begin(niceness: int, parent: int) -> None:
    """Leave Ctrl-C to the process that waits, and end with it however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(niceness)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(ORPHAN)
    os._exit(1)
