"""Work on several maps at once that needs orbits of them: those asked for go on side by side."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Final, TypeAlias, TypeVar

import numpy as np

from stickslip.analysis.maps.protocol import Floats, Map1D, advance_each

R = TypeVar("R")
# Asks for orbits from points (m,), of so many steps, and is sent them, (m, steps + 1).
Asking: TypeAlias = Generator[tuple[Map1D, Floats, int], Floats, R]

STRIDE: Final = 16  # steps that all take together at least, though some need fewer


def side_by_side(tasks: Sequence[Asking[R]]) -> list[R]:
    """Run tasks that ask for orbits of maps of one kind, all of them together."""
    results: dict[int, R] = {}
    waiting: dict[int, tuple[Map1D, Floats, int]] = {}  # orbits so far, and steps left

    def resume(k: int, orbits: Floats | None) -> None:
        """Let a task go on until it asks again, or has its result."""
        try:
            asked = tasks[k].send(orbits)  # type: ignore[arg-type]  # None starts it
        except StopIteration as end:
            results[k] = end.value
            waiting.pop(k, None)
        else:
            f, x, left = asked
            waiting[k] = f, x[:, None], left

    for k in range(len(tasks)):
        resume(k, None)
    while waiting:
        maps, ways, lefts = zip(*waiting.values(), strict=True)
        steps = max(STRIDE, min(lefts))
        found = advance_each(maps, [way[:, -1] for way in ways], steps)
        for k, more in zip(list(waiting), found, strict=True):
            f, way, left = waiting[k]
            way = np.hstack([way, more[:, 1 : left + 1]])
            waiting[k] = f, way, left - steps
            if left <= steps:
                resume(k, way)
    return [results[k] for k in range(len(tasks))]
