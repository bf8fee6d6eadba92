"""Time the engines on equal maps: what a law costs that is not constant, or not a formula."""

import numpy as np
import pytest
from benchmarks.cases import coulomb, law9
from benchmarks.measure import CPU, in_turns

import stickslip as ss

TABLE = "Engines and steppers on the same maps, one core"


def _weakening(s, gamma):
    # A comparison of the argument is what no trace can follow: the law stays a callable.
    return 1.0 / (1.0 + gamma * s) if s >= 0.0 else 1.0


def _law9_as_callable():
    law = ss.friction_law(_weakening, parameters={"gamma": 3.0})
    return ss.event_map(law9().model.replace(friction=law), threads=1)


STEPPERS = {
    "Coulomb: closed forms": (coulomb, lambda: coulomb().map(engine="exact"), 50_000),
    "Coulomb: Taylor series": (coulomb, lambda: coulomb().map(engine="adaptive"), 2_000),
    "law (9): Taylor series": (law9, lambda: law9().map(), 1_000),
    "law (9) as a callable: collocation": (law9, _law9_as_callable, 200),
}


@pytest.mark.parametrize("name", STEPPERS)
@pytest.mark.benchmark(timer=CPU, group="steppers")
def bench_steppers(benchmark, report, name):
    make_case, make_map, n = STEPPERS[name]
    case, f = make_case(), make_map()
    default = case.map()
    d = case.uniform(n)
    pairs = in_turns(benchmark, lambda: f(d), lambda: default(d))
    report.add(
        TABLE,
        map=name,
        **{
            "us/map": 1e6 * float(np.median(pairs.ours)) / n,
            "times the default": 1 / pairs.ratio(),
            "largest difference": float(np.nanmax(abs(f(d) - default(d)))),
        },
    )
