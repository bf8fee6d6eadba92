"""Long calls tell what is done and how far it is: on a terminal, in a notebook, else in a log."""

from __future__ import annotations

import functools
import inspect
import logging
import os
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, SupportsFloat, TypeVar, cast

from stickslip.numerics.threads import threads_start

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

LOG: Final = logging.getLogger(__name__)
PATIENCE: Final = 2.0  # seconds that a call may take without a word
REDRAWN: Final = 0.5  # seconds from one picture, or look, to the next
HOUR: Final = 3600.0  # seconds; what takes longer is told

Function = TypeVar("Function", bound="Callable[..., Any]")


class _Watch:
    """Whether somebody is told; of the main thread, of one call at a time."""

    quiet = False  # the command line was asked to be
    told = False  # of a call that is not over
    compiled = 0  # kernels, in this process

    def __init__(self) -> None:
        self.lock, self.looks = threading.Lock(), False  # whether a thread looks at calls
        self.call: _Wait | None = None

    def look(self) -> None:
        """Wait for a call that lasts, and show it; end once there is none."""
        # One thread for many short calls: to start one for each took a quarter of a millisecond.
        while True:
            with self.lock:
                call = self.call
                left = 0.0 if call is None else call.begun + PATIENCE - time.monotonic()
                self.looks = left > 0.0
                if call is not None:
                    call.shown = not self.looks
            if not self.looks:
                break
            time.sleep(min(left, REDRAWN))
        if call is not None:
            call.show()


WATCH: Final = _Watch()
if hasattr(os, "register_at_fork"):  # a fork has none of its parent's threads
    os.register_at_fork(after_in_child=functools.partial(_Watch.__init__, WATCH))


def waits(function: Function) -> Function:
    """Let a public function that may last tell of itself, unless its caller takes `progress`."""
    code = inspect.unwrap(function).__code__
    takes = "progress" in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    what = code.co_name.replace("_", " ")

    @functools.wraps(function)
    def watched(*args: Any, **keywords: Any) -> Any:
        own = keywords.get("progress") is not None
        with waiting(what, shown=not own) as tell:
            if takes and not own and tell is not None:
                keywords["progress"] = tell
            return function(*args, **keywords)

    return cast("Function", watched)


@contextmanager
def waiting(what: str, *, shown: bool = True) -> Iterator[Callable[[float], None] | None]:
    """Give what takes the share that is done; None where another call, or nobody, is told of."""
    main = threading.current_thread() is threading.main_thread()
    if WATCH.told or WATCH.quiet or not main or not threads_start():
        yield None
        return
    wait = _Wait(what)
    WATCH.told = True
    try:
        if shown:
            wait.start()
        yield wait.tell
    finally:
        WATCH.told = False
        wait.end()


def doing(what: str) -> None:
    """Say what is done now, by the call that is told of, if there is one; nothing when it is."""
    call = WATCH.call
    if call is not None and threading.current_thread() is threading.main_thread():
        call.doing = what


class _Wait:
    """A call that may last."""

    def __init__(self, what: str) -> None:
        self._what, self._compiled = what, WATCH.compiled
        self.doing = ""
        self._share: SupportsFloat = 0.0
        self.begun, self.shown = time.monotonic(), False
        self._over, self._gone = threading.Event(), threading.Event()

    def tell(self, share: SupportsFloat) -> None:
        """Take the share that is done: a number, or what says more by the time it has `waited`."""
        self._share, self._told = share, time.monotonic()

    def start(self) -> None:
        """Let the call be looked at."""
        with WATCH.lock:
            WATCH.call, starts, WATCH.looks = self, not WATCH.looks, True
        if starts:
            threading.Thread(target=WATCH.look, daemon=True).start()

    def end(self) -> None:
        """Say no more."""
        with WATCH.lock:
            WATCH.call = None
        if self.shown:
            self._over.set()
            self._gone.wait()

    def show(self) -> None:
        """Show how far the call is until it ends."""
        try:
            if sys.stderr.isatty():
                self._on_terminal()
            elif type(sys.stderr).__module__.startswith("ipykernel"):
                self._in_notebook()
            else:
                self._in_log()
        finally:
            self._gone.set()

    def __str__(self) -> str:
        share: Any = self._share
        seconds = time.monotonic() - self.begun
        if isinstance(share, int | float):
            hours = seconds / HOUR * (1.0 - share) / share if share else 0.0
            left = f", some {hours:.3g} hours left" if hours > 1.0 else ""
            share = f"{share:.0%} done{left}" if share else ""
        else:
            share = replace(share, waited=time.monotonic() - self._told)
        compiled = WATCH.compiled - self._compiled
        kernels = f"kernels compiled: {compiled}" if compiled else ""
        told = (f"{seconds:.0f} s", str(share), self.doing, kernels)
        return f"{self._what}: {', '.join(filter(None, told))}"

    def _on_terminal(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        columns = TextColumn("{task.description}"), BarColumn()
        console = Console(stderr=True)
        with Progress(*columns, console=console, transient=True, redirect_stdout=False) as bar:
            task = bar.add_task("", total=None)
            while True:
                share = float(self._share)
                bar.update(
                    task, description=str(self), total=1.0 if share else None, completed=share
                )
                if self._over.wait(REDRAWN):
                    return

    def _in_notebook(self) -> None:
        """Write the same line again and again."""
        width = 0
        while not self._over.wait(REDRAWN):
            line = f"stickslip: {self}"
            width = max(width, len(line))
            print(f"\r{line:{width}}", end="", file=sys.stderr, flush=True)
        print(f"\r{'':{width}}\r", end="", file=sys.stderr, flush=True)

    def _in_log(self) -> None:
        """Write a line after twice as long each time."""
        while True:
            LOG.info("%s", self)
            if self._over.wait(time.monotonic() - self.begun):
                return
