"""Progress of long work on stderr, and only where someone watches a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from datetime import timedelta
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from stickslip.sweeps.sweep import Progress

Item = TypeVar("Item")

MOST_NOTES = 20


def tracked(items: Iterable[Item], total: int, what: str, *, quiet: bool) -> Iterator[Item]:
    """Pass `items` on, with a bar that counts them."""
    if total < 2 or not _watched(quiet):
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, what, total, console=Console(stderr=True), transient=True)


@contextmanager
def shares(what: str, *, quiet: bool) -> Iterator[Callable[[float], None] | None]:
    """Give a function that shows the share of the work that is done; None if nobody watches."""
    if not _watched(quiet):
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def points(what: str, *, quiet: bool) -> Iterator[Callable[[Progress], None] | None]:
    """Give a function that shows points done, their rate and the time left; None as above."""
    if not _watched(quiet):
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None, rate="")

        def show(progress: Progress) -> None:
            rate = ""
            if progress.rate > 0:
                left = timedelta(seconds=round(progress.remaining))
                rate = f"{progress.rate:.3g}/s, {left} left"
            bar.update(task, completed=progress.done, total=progress.total, rate=rate)

        yield show


def _watched(quiet: bool) -> bool:
    return not quiet and sys.stderr.isatty()


def note(text: str, *, quiet: bool) -> None:
    """Say something beside the result."""
    if not quiet:
        print(f"stickslip: {text}", file=sys.stderr)


def notes(texts: Sequence[str], what: str, *, quiet: bool) -> None:
    """Say several things beside the result; of many the first ones, and how many more there are."""
    for text in texts[:MOST_NOTES]:
        note(text, quiet=quiet)
    if len(texts) > MOST_NOTES:
        note(f"{len(texts) - MOST_NOTES} more {what}", quiet=quiet)
