"""Two drivers of each law on very many random maps; where they differ the oracle says who is right.

    python -m tests.acceptance.drivers coulomb --systems 100000 --points 100
    python -m tests.acceptance.drivers law9 --systems 10000 --points 20

Coulomb: motions in lanes against the exact engine, one motion at a time. Law (9): Taylor series in
pools against collocation, one motion at a time. Both give a motion up after 400 events. Values that
differ by more than the design's tolerance times max(1, |f'|), endings that differ, and a random
thousand of the rest are settled in high precision. Exit code 1 if any is wrong.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from tests.reference.settle import WRONG, Verdict, settle

import stickslip as ss
from stickslip.status import EVENT_LIMIT, NAMES, OK

from .evidence import opaque
from .systems import Case, random_cases, random_points

MAX_EVENTS = 400
SETTLED = 1000  # of the maps on which the drivers agree
MAX_TIME = 20_000  # of the reference's motions


@dataclass
class Count:
    """What came out."""

    maps: int = 0
    returned: int = 0
    gave_up: int = 0
    differ: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)

    def add(self, system: Case, driver: str, verdict: Verdict) -> None:
        """One point settled."""
        self.verdicts[verdict.verdict] += 1
        if verdict.verdict == WRONG:
            self.wrong.append(f"{system} {driver}\n    {verdict}")

    def __str__(self) -> str:
        head = (
            f"{self.maps} maps, {self.returned} returned, {self.gave_up} given up by both, "
            f"{self.differ} differ; settled: {dict(self.verdicts)}"
        )
        return "\n".join([head, *self.wrong[:30]])


def drivers(system: Case) -> tuple[tuple[str, ss.EventMap], tuple[str, ss.EventMap]]:
    """The two event maps of a system, each by its own driver."""
    settings = {"max_events": MAX_EVENTS, "threads": 1}
    together = ss.event_map(system.model(), **settings)
    if system.kind == "coulomb":
        # A time limit, here without effect, has the exact engine carry every motion alone.
        return ("lanes", together), (
            "alone",
            ss.event_map(system.model(), max_time=1e300, **settings),
        )
    return ("pools", together), ("collocation", ss.event_map(opaque(system), **settings))


def compare(system: Case, d: np.ndarray, share: float, rng: np.random.Generator, count: Count):
    """Ask both drivers and settle where they differ, and a share of the rest."""
    named = drivers(system)
    (_, first), (_, second) = named
    value, other = first(d), second.evaluate(d)
    ok = other.status == OK
    tolerance = 2 * system.tolerance * np.maximum(1.0, np.abs(np.where(ok, other.derivative, 0.0)))
    same = np.where(ok, np.abs(value - other.value) <= tolerance, np.isnan(value))
    gave_up = same & (other.status == EVENT_LIMIT)
    count.maps += d.size
    count.returned += int((ok & same).sum())
    count.gave_up += int(gave_up.sum())
    count.differ += int((~same).sum())
    chosen = ~same | (~gave_up & (rng.random(d.size) < share))
    for i in np.flatnonzero(chosen):
        for name, f in named:
            result = f.evaluate(float(d[i]))
            given = float(f(float(d[i])))
            status = NAMES[int(result.status)]
            verdict = settle(
                system.oracle(),
                float(d[i]),
                given,
                status,
                system.tolerance,
                float(result.duration),
                max_events=MAX_EVENTS,
                max_time=MAX_TIME,
            )
            count.add(system, name, verdict)


def main(arguments: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=("coulomb", "law9"))
    parser.add_argument("--systems", type=int, default=1000)
    parser.add_argument("--points", type=int, default=100, help="starts of each system")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=np.inf, help="stop after so long")
    options = parser.parse_args(arguments)
    rng, start, count = np.random.default_rng(options.seed), time.perf_counter(), Count()
    share = SETTLED / (options.systems * options.points)
    for number, system in enumerate(random_cases(options.kind, options.systems, rng)):
        compare(system, random_points(system, options.points, rng), share, rng, count)
        if number % 100 == 0:
            print(f"{time.perf_counter() - start:.0f} s: {count}", flush=True)
        if time.perf_counter() - start > options.seconds:
            break
    print(f"{' '.join(arguments or sys.argv[1:])}: {time.perf_counter() - start:.0f} s")
    print(count)
    return 1 if count.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
