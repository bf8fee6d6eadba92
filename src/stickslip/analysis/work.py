"""Long pieces of work: how much is done, and whether Ctrl-C may cut them short."""

from __future__ import annotations

from contextlib import contextmanager
from threading import Lock
from typing import TYPE_CHECKING

from stickslip.checks import check_callback, flag

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class Work:
    """Tells the share of a work that is done; an interrupt ends it early if that is wanted."""

    def __init__(
        self, progress: Callable[[float], None] | None = None, partial: bool = False
    ) -> None:
        check_callback("progress", progress, "the share of the work that is done")
        self._progress, self._told = progress, 0.0
        self.partial = flag("partial", partial)
        self._interrupts: list[str] = []  # shared by all parts

    def tell(self, share: float) -> None:
        """Tell the share that is done; it never falls."""
        self._told = max(self._told, share)
        if self._progress is not None:
            self._progress(self._told)

    @property
    def interrupted(self) -> bool:
        """Whether the work, or a part of it, was cut short."""
        return bool(self._interrupts)

    def part(self, start: float, stop: float) -> Work:
        """Return the part between two shares, as a work of its own."""
        tell = self.tell
        made = Work(lambda share: tell(start + (stop - start) * share), self.partial)
        made._interrupts = self._interrupts
        return made

    @contextmanager
    def until_interrupted(self) -> Iterator[None]:
        """Do what is inside; Ctrl-C ends it and is noted, where a partial answer is wanted."""
        try:
            yield
        except KeyboardInterrupt:
            if not self.partial:
                raise
            self._interrupts.append("interrupted")

    def steps(self, n: int) -> Callable[[int], None]:
        """Return a function that counts some of n steps as done, for several threads."""
        lock, done = Lock(), 0

        def count(some: int = 1) -> None:
            nonlocal done
            with lock:
                before, done = done, done + some
                if 100 * done // n > 100 * before // n:
                    self.tell(done / n)

        return count
