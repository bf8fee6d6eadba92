"""Side by side: speed and wrong answers of the map by `stickslip`, by C and by others' solvers.

Both together: a solver that steps over a grazing contact is fast and wrong.
"""

from functools import cache

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, map_in_c
from benchmarks.cases import CASES
from benchmarks.measure import CPU, WALL, in_turns
from benchmarks.peers import PEERS, peer
from tests.reference.settle import RIGHT, WRONG, settle

import stickslip as ss
from stickslip.numerics.targets import available_threads
from stickslip.status import NAMES, OK, TIME_LIMIT

TABLE = "Side by side on the same inputs: one core, processor time"
CORES = "All cores and the GPU against one core, wall time"
# Starting points in one timing: ours takes all of them, others every so many.
SIZE = {"Coulomb": 100_000, "law (9)": 10_000}
OTHERS = {
    "Coulomb": {"C": 20_000, "heyoka.py Taylor": 2_000, "CyRK DOP853": 200, "diffrax Dopri8": 1000},
    "law (9)": {"C": 2_000, "heyoka.py Taylor": 200, "CyRK DOP853": 25, "diffrax Dopri8": 500},
}
FEW = {"Coulomb": 50, "law (9)": 10}
RANDOM = {"Coulomb": 2_000, "law (9)": 100}
# Another solver is wrong where it leaves the true motion, not where it keeps to its tolerance.
LOOSE = 1e-6
OURS = "stickslip"

each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


@each_case
@pytest.mark.parametrize("name", [OURS, "C", *PEERS])
@pytest.mark.benchmark(timer=CPU, group="side by side")
def bench_side_by_side(benchmark, report, case, name):
    other = case.map() if name == OURS else solver(name, case)
    f, n = case.map(), SIZE[case.name]
    d = case.uniform(n)
    few = d if name == OURS else d[:: n // OTHERS[case.name].get(name, FEW[case.name])]
    pairs = in_turns(benchmark, lambda: f(d), lambda: other(few), rounds=5)
    weight = n / few.size
    low, high = pairs.spread(weight)
    tolerance = case.tolerance if name == OURS else LOOSE
    random, near = (wrong(case, points, other, tolerance) for points in sets(case))
    report.add(
        TABLE,
        law=case.name,
        by=name,
        **{
            "us/map": 1e6 * float(np.median(pairs.other)) / few.size,
            "times stickslip's": pairs.ratio(weight),
            "pairs": f"{low:.3g} to {high:.3g}",
            "median error": random[1],
            "wrong, random": f"{random[0]} of {RANDOM[case.name]}",
            "wrong, near breakpoints": f"{near[0]} of {sets(case)[1].size}",
        },
    )


def solver(name, case):
    """Map of an array by another program, or a skip that says why not."""
    if name == "C":
        if COMPILER is None:
            pytest.skip("no C compiler")
        return map_in_c(case.model)
    made, reason = peer(name)
    if made is None:
        pytest.skip(f"{name}: {reason}")
    return made(case.model)


@cache
def sets(case):
    """Random points, and points next to the breakpoints."""
    return case.uniform(RANDOM[case.name], seed=2), case.near_grazing()


@cache
def ours(case, which):
    """Values of `stickslip` at one of the sets, each held against the oracle."""
    d = sets(case)[which]
    result = case.map().evaluate(d)
    points = zip(d.tolist(), result.value.tolist(), result.status.tolist(), strict=True)
    return result, [settle(case.oracle, x, y, NAMES[s], case.tolerance) for x, y, s in points]


def wrong(case, d, f, tolerance):
    """Count the wrong answers at a set; the median error of the others."""
    which = 0 if d is sets(case)[0] else 1
    result, verdicts = ours(case, which)
    errors, bad = [], 0
    for x, y, own, verdict in zip(d.tolist(), f(d).tolist(), result.value, verdicts, strict=True):
        if verdict.verdict == RIGHT and abs(y - own) <= tolerance:
            errors.append(abs(y - float(verdict.reference.value)))
            continue
        status = NAMES[TIME_LIMIT if np.isnan(y) else OK]
        found = settle(case.oracle, x, y, status, tolerance)
        bad += found.verdict == WRONG or (np.isnan(y) and np.isfinite(own))
    return bad, float(np.median(errors))


@each_case
@pytest.mark.parametrize("device", ["all cores", "cuda"])
@pytest.mark.benchmark(timer=WALL, group="cores")
def bench_cores(benchmark, report, case, device):
    threads = available_threads()
    if device == "cuda":
        try:
            many = ss.event_map(case.model, device="cuda")
        except (ValueError, ImportError) as reason:
            pytest.skip(str(reason))
    elif threads < 2:
        pytest.skip("this process may use one core only")
    else:
        many = case.map(threads=threads)
    one, d = case.map(), case.uniform(10 * SIZE[case.name])
    pairs = in_turns(benchmark, lambda: many(d), lambda: one(d), rounds=5)
    low, high = pairs.spread()
    report.add(
        CORES,
        law=case.name,
        by=f"{threads} cores" if device == "all cores" else device,
        maps=d.size,
        **{
            "million maps/s": 1e-6 * d.size / float(np.median(pairs.ours)),
            "times one core": pairs.ratio(),
            "pairs": f"{low:.2f} to {high:.2f}",
        },
    )
