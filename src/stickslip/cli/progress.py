"""Progress of long work on stderr, and only where someone watches a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from typing import TypeVar

Item = TypeVar("Item")


def tracked(items: Iterable[Item], total: int, what: str, *, quiet: bool) -> Iterator[Item]:
    """Pass `items` on, with a bar that counts them."""
    if quiet or total < 2 or not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import track

    yield from track(items, what, total, console=Console(stderr=True), transient=True)


def note(text: str, *, quiet: bool) -> None:
    """Say something beside the result."""
    if not quiet:
        print(f"stickslip: {text}", file=sys.stderr)
