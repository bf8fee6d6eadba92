"""Two things timed in turns, so that a busy machine slows both and their ratio stays."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

# On one core only the time of this process counts: others on the machine do not.
CPU = time.process_time
WALL = time.perf_counter


@dataclass(frozen=True)
class Pairs:
    """Seconds of ours and of the other, taken alternately in one run."""

    ours: list[float]
    other: list[float]

    def ratio(self, weight: float = 1.0) -> float:
        """Median over the pairs of other / ours; `weight`: work of ours over work of the other."""
        return weight * statistics.median(self._ratios())

    def spread(self, weight: float = 1.0) -> tuple[float, float]:
        """Smallest and largest ratio of a pair."""
        return weight * min(self._ratios()), weight * max(self._ratios())

    def against_c(self, n: int) -> dict[str, Any]:
        """Columns of a table: `n` maps of ours, as many in C."""
        low, high = self.spread()
        return {
            "us/map": 1e6 * statistics.median(self.ours) / n,
            "C, us/map": 1e6 * statistics.median(self.other) / n,
            "times faster": self.ratio(),
            "pairs": f"{low:.1f} to {high:.1f}",
        }

    def _ratios(self) -> list[float]:
        return [b / a for a, b in zip(self.ours, self.other, strict=True)]


def in_turns(
    benchmark: Any, ours: Callable[[], Any], other: Callable[[], Any], rounds: int = 7
) -> Pairs:
    """Time `other` and `ours` alternately; the fixture `benchmark` keeps ours.

    A first pair, in which kernels are loaded and caches filled, does not count. The clock is
    the fixture's: ``@pytest.mark.benchmark(timer=...)``.
    """
    others: list[float] = []
    clock = benchmark._timer

    def before() -> None:
        start = clock()
        other()
        others.append(clock() - start)

    benchmark.pedantic(ours, setup=before, rounds=rounds, warmup_rounds=1)
    return Pairs(list(benchmark.stats.stats.data), others[1:])
