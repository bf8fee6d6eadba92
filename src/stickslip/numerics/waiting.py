"""Long calls tell what is done and how far it is: on a terminal, in a notebook, else in a log."""

from __future__ import annotations

import functools
import inspect
import logging
import sys
import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, SupportsFloat, TypeVar, cast

from stickslip.numerics.threads import threads_start

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

LOG: Final = logging.getLogger(__name__)
PATIENCE: Final = 2.0  # seconds that a call may take without a word
REDRAWN: Final = 0.5  # seconds from one picture to the next

Function = TypeVar("Function", bound="Callable[..., Any]")


class _Watch:
    """Whether somebody is told; of the main thread, of one call at a time."""

    quiet = False  # the command line was asked to be
    told = False  # of a call that is not over
    compiled = 0  # kernels, in this process


WATCH: Final = _Watch()


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


class _Wait(threading.Thread):
    """Watches a call from a thread of its own."""

    def __init__(self, what: str) -> None:
        super().__init__(daemon=True)
        self._what, self._share, self._compiled = what, 0.0, WATCH.compiled
        self._begun, self._over = time.monotonic(), threading.Event()

    def tell(self, share: SupportsFloat) -> None:
        """Take the share that is done."""
        self._share = float(share)

    def end(self) -> None:
        """Say no more."""
        self._over.set()
        if self.ident is not None:
            self.join()

    def run(self) -> None:
        """Show how far the call is until it ends."""
        if self._over.wait(PATIENCE):
            return
        if sys.stderr.isatty():
            self._on_terminal()
        elif type(sys.stderr).__module__.startswith("ipykernel"):
            self._in_notebook()
        else:
            self._in_log()

    def __str__(self) -> str:
        share = f", {self._share:.0%} done" if self._share else ""
        compiled = WATCH.compiled - self._compiled
        kernels = f", kernels compiled: {compiled}" if compiled else ""
        return f"{self._what}: {time.monotonic() - self._begun:.0f} s{share}{kernels}"

    def _on_terminal(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        columns = TextColumn("{task.description}"), BarColumn()
        console = Console(stderr=True)
        with Progress(*columns, console=console, transient=True, redirect_stdout=False) as bar:
            task = bar.add_task("", total=None)
            while True:
                share = self._share
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
            if self._over.wait(time.monotonic() - self._begun):
                return
