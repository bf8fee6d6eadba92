"""A large sample in pieces: carried out by several processes, ended by the clock if asked."""

from __future__ import annotations

import math
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import TypeVar

from .results import TABLE

Task = TypeVar("Task")
Piece = TypeVar("Piece")


def carried_out(
    work: Callable[[Task], Piece], tasks: Iterable[Task], jobs: int, seconds: float = math.inf
) -> Iterator[tuple[Piece, float]]:
    """Pieces in the order of their tasks, each with the time since the one before.

    No task is begun later than ``seconds`` from now; those begun are finished.
    """
    last = time.time()
    with ProcessPoolExecutor(jobs) as pool:
        for piece in pool.map(partial(unless_late, work, last + seconds), tasks):
            if piece is not None:
                now = time.time()
                yield piece, now - last
                last = now


def unless_late(work: Callable[[Task], Piece], end: float, task: Task) -> Piece | None:
    """The task's piece; nothing if it is too late to begin."""
    return work(task) if time.time() < end else None


def add_options(parser: ArgumentParser) -> None:
    """Options of every large sample: for how long, on how many cores, and into which table."""
    parser.add_argument("--seconds", type=float, default=math.inf, help="then begin no more")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--table", type=Path, default=TABLE, help="where counts are added")
