"""Work on several maps at once that needs orbits of them: those asked for go on side by side."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, TypeVar

import numpy as np

from stickslip.analysis.maps.protocol import Floats, Map1D, advance_each

R = TypeVar("R")
# Asks for orbits from points (m,), of so many steps, and is sent them, (m, steps + 1).
Asking: TypeAlias = Generator[tuple[Map1D, Floats, int], Floats, R]

STRIDE: Final = 16  # steps that all take together at least, though some need fewer


@dataclass
class _Way:
    """Orbits that a task waits for, as far as they have come."""

    f: Map1D
    orbits: Floats
    steps: int

    @property
    def left(self) -> int:
        return self.steps + 1 - self.orbits.shape[1]


def side_by_side(tasks: Sequence[Asking[R]]) -> list[R]:
    """Run tasks that ask for orbits of maps of one kind, all of them together."""
    results: dict[int, R] = {}
    waiting: dict[int, _Way] = {}

    def resume(k: int, orbits: Floats | None) -> None:
        """Let a task go on until it asks again, or has its result."""
        try:
            asked = tasks[k].send(orbits)  # type: ignore[arg-type]  # None starts it
        except StopIteration as end:
            results[k] = end.value
            waiting.pop(k, None)
        else:
            f, x, steps = asked
            waiting[k] = _Way(f, x[:, None], steps)

    for k in range(len(tasks)):
        resume(k, None)
    while waiting:
        ways = list(waiting.values())
        steps = max(STRIDE, min(way.left for way in ways))
        found = advance_each([way.f for way in ways], [way.orbits[:, -1] for way in ways], steps)
        for k, more in zip(list(waiting), found, strict=True):
            way = waiting[k]
            way.orbits = np.hstack([way.orbits, more[:, 1:]])
            if way.left <= 0:
                resume(k, way.orbits[:, : way.steps + 1])
    return [results[k] for k in range(len(tasks))]
