"""Two drivers of each law on very many random maps; where they differ the oracle says who is right.

    python -m tests.acceptance.drivers coulomb --systems 10000 --points 1000
    python -m tests.acceptance.drivers law9 --systems 10000 --points 100

Coulomb: motions in lanes against the exact engine, one motion at a time. Law (9): Taylor series in
pools against an extrapolation method that shares nothing with the package (`extrapolation.py`).
Both give a motion up after 400 events; why motions do not return is not compared here. Values that
differ by more than twice the design's tolerance times max(1, |f'|), values that only one has, and a
random thousandth of the rest, at most a thousand, are settled in high precision. Counts go to
`docs/evidence.csv`. Exit code 1 if any is wrong.
"""

from __future__ import annotations

import argparse
import secrets
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from tests.reference import extrapolation
from tests.reference.settle import Verdict, settle

import stickslip as ss
from stickslip.status import NAMES, OK

from . import counts
from .pieces import add_options, carried_out
from .systems import Case, random_cases, random_points

MAX_EVENTS = 400
SETTLED = 1000  # of the values on which the drivers agree, and no more than one in so many
MAX_TIME = 20_000  # of the reference's motions
PIECE = 50  # systems a task
SAMPLES = {
    "coulomb": "Coulomb, lanes against one motion at a time",
    "law9": "law (9), Taylor series in pools against extrapolation",
}


@dataclass
class Count(counts.Count):
    """What came out."""

    maps: int = 0
    returned: int = 0

    def __str__(self) -> str:
        head = (
            f"{self.maps} maps, {self.returned} returned alike, {self.endless} by neither, "
            f"{self.differ} differ; settled: {dict(self.verdicts)}"
        )
        return self.listed(head)


def event_maps(system: Case) -> dict[str, ss.EventMap]:
    """The package's drivers of a system that are asked, the one that carries many at once first."""
    settings = {"max_events": MAX_EVENTS, "threads": 1}
    together = ss.event_map(system.model(), **settings)
    if system.kind == "law9":
        return {"pools": together}
    # A time limit, here without effect, has the exact engine carry every motion alone.
    alone = ss.event_map(system.model(), max_time=1e300, **settings)
    return {"lanes": together, "alone": alone}


def other_values(system: Case, maps: dict[str, ss.EventMap], d: np.ndarray) -> np.ndarray:
    """The values by the other driver."""
    if system.kind == "coulomb":
        return maps["alone"](d)
    plant = extrapolation.Plant(system.alpha, system.beta, system.V, **dict(system.law))
    return extrapolation.values(plant, d, MAX_EVENTS)[0]


def compare(system: Case, d: np.ndarray, share: float, rng: np.random.Generator) -> Count:
    """Ask both drivers and settle where they differ, and a share of the rest."""
    maps = event_maps(system)
    first = next(iter(maps.values()))
    value = first(d)
    other = other_values(system, maps, d)
    returned = np.isfinite(value)
    allowed = np.full(d.size, 2 * system.tolerance)
    allowed[returned] *= np.maximum(1.0, np.abs(first.derivative(d[returned])))
    same = np.where(returned, np.abs(value - other) <= allowed, np.isnan(other))
    count = Count(
        maps=d.size,
        returned=int((returned & same).sum()),
        endless=int((~returned & same).sum()),
        differ=int((~same).sum()),
    )
    for i in np.flatnonzero(~same | (returned & (rng.random(d.size) < share))):
        for name, f in maps.items():
            verdict = settled(system, f, float(d[i]))
            count.add(verdict.verdict, f"{system} {name}\n    {verdict}")
    return count


def settled(system: Case, f: ss.EventMap, d: float) -> Verdict:
    """What the oracle says of one answer."""
    result = f.evaluate(d)
    duration = float(result.duration)
    long_enough = 1.1 * duration + 10.0 if result.status == OK else MAX_TIME
    return settle(
        system.oracle(),
        d,
        float(f(d)),
        NAMES[int(result.status)],
        system.tolerance,
        duration,
        max_events=MAX_EVENTS,
        max_time=min(long_enough, MAX_TIME),
    )


def piece(task: tuple[str, int, int, float, tuple[int, int]]) -> Count:
    """Some systems, with random numbers of their own."""
    kind, systems, points, share, seed = task
    rng, count = np.random.default_rng(seed), Count()
    for system in random_cases(kind, systems, rng):
        count.merge(compare(system, random_points(system, points, rng), share, rng))
    return count


def tasks(kind: str, systems: int, points: int, seed: int) -> Iterator[tuple]:
    """The sample in pieces."""
    share = min(SETTLED / (systems * points), 1 / SETTLED)
    for i, done in enumerate(range(0, systems, PIECE)):
        yield kind, min(PIECE, systems - done), points, share, (seed, i)


def main(arguments: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=tuple(SAMPLES))
    parser.add_argument("--systems", type=int, default=1000)
    parser.add_argument("--points", type=int, default=100, help="starts of each system")
    parser.add_argument("--seed", type=int, default=secrets.randbits(31), help="default: any")
    add_options(parser)
    options = parser.parse_args(arguments)
    print(f"{SAMPLES[options.kind]}, seed {options.seed}", flush=True)
    total, elapsed = Count(), 0.0
    work = tasks(options.kind, options.systems, options.points, options.seed)
    for count, took in carried_out(piece, work, options.jobs, options.seconds):
        total.merge(count)
        elapsed += took
        count.keep(SAMPLES[options.kind], count.maps, took, options.table)
        print(f"{elapsed:.0f} s: {total}", flush=True)
    return 1 if total.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
