"""Time two threads against one.

Wall time, so the only table here that a busy machine spoils: what other programs take of the
second core is missing from the gain.
"""

import numpy as np
import pytest
from benchmarks.cases import CASES
from benchmarks.measure import WALL, in_turns

from stickslip.numerics.targets import available_threads

TABLE = "Two threads against one (wall time)"
SIZE = {"Coulomb": 1_000_000, "law (9)": 10_000}


@pytest.mark.skipif(available_threads() < 2, reason="this process may use one core only")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.benchmark(timer=WALL, group="threads")
def bench_two_threads(benchmark, report, case):
    one, two = case.map(threads=1), case.map(threads=2)
    d = case.uniform(SIZE[case.name])
    pairs = in_turns(benchmark, lambda: two(d), lambda: one(d), rounds=5)
    low, high = pairs.spread()
    report.add(
        TABLE,
        law=case.name,
        maps=d.size,
        **{
            "1 thread, million maps/s": 1e-6 * d.size / float(np.median(pairs.other)),
            "2 threads, million maps/s": 1e-6 * d.size / float(np.median(pairs.ours)),
            "gain": pairs.ratio(),
            "pairs": f"{low:.2f} to {high:.2f}",
        },
    )
