"""Time the map against scipy's solver with events, and count the wrong answers of both.

Both together: a solver that steps over a grazing contact is fast and wrong.
"""

from collections import Counter

import numpy as np
import pytest
from benchmarks.cases import CASES
from benchmarks.measure import CPU, in_turns
from benchmarks.scipy_map import ScipyMap
from tests.reference.settle import RIGHT, WRONG, settle

from stickslip.status import NAMES, OK, TIME_LIMIT

SPEED = "Event map on one core against scipy solve_ivp with events (DOP853, 1e-10)"
ANSWERS = "Answers held against a reference of higher precision"
# Starting points in one timing: ours takes them as one array.
SIZE = {"Coulomb": (100_000, 100), "law (9)": (5_000, 25)}
RANDOM = {"Coulomb": 2_000, "law (9)": 100}
# scipy is wrong where it leaves the true motion, not where it keeps to its own tolerance.
SCIPY_TOLERANCE = 1e-6

each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


@each_case
@pytest.mark.benchmark(timer=CPU, group="against scipy")
def bench_speed(benchmark, report, case):
    n, n_scipy = SIZE[case.name]
    f, scipy_map = case.map(), ScipyMap(case.model)
    d = case.uniform(n)
    few = d[:: n // n_scipy]  # of the same inputs
    pairs = in_turns(benchmark, lambda: f(d), lambda: scipy_map(few))
    low, high = pairs.spread(n / few.size)
    report.add(
        SPEED,
        law=case.name,
        maps=n,
        **{
            "stickslip us/map": 1e6 * float(np.median(pairs.ours)) / n,
            "scipy us/map": 1e6 * float(np.median(pairs.other)) / few.size,
            "ratio": pairs.ratio(n / few.size),
            "pairs": f"{low:.0f} to {high:.0f}",
        },
    )


@each_case
@pytest.mark.parametrize("where", ["random", "near breakpoints"])
@pytest.mark.benchmark(timer=CPU, group="wrong answers")
def bench_answers(benchmark, report, case, where):
    d = case.uniform(RANDOM[case.name], seed=2) if where == "random" else case.near_grazing()
    result = benchmark.pedantic(case.map().evaluate, args=(d,), rounds=1, warmup_rounds=1)
    by_scipy = ScipyMap(case.model)(d)
    peer_status = np.where(np.isnan(by_scipy), TIME_LIMIT, OK)
    ours = _verdicts(case, d, result.value, result.status, case.tolerance)
    scipys = _verdicts(case, d, by_scipy, peer_status, SCIPY_TOLERANCE)
    for name, verdicts, tolerance in (
        ("stickslip", ours, case.tolerance),
        ("scipy", scipys, SCIPY_TOLERANCE),
    ):
        count = Counter(verdict.verdict for verdict in verdicts)
        errors = [v.error / v.kappa for v in verdicts if v.verdict == RIGHT and v.error == v.error]
        report.add(
            ANSWERS,
            law=case.name,
            points=where,
            by=name,
            n=d.size,
            **{
                "tolerance/kappa": tolerance,
                "wrong": count[WRONG],
                "not decided": d.size - count[RIGHT] - count[WRONG],
                "largest other error/kappa": max(errors),
            },
        )


def _verdicts(case, d, values, statuses, tolerance):
    points = zip(d.tolist(), values.tolist(), statuses.tolist(), strict=True)
    return [settle(case.oracle, x, y, NAMES[code], tolerance) for x, y, code in points]
