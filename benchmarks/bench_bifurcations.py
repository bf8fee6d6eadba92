"""Time what is asked along a parameter: all bifurcations of the paper's two systems, and diagrams.

The second of two calls, with the threads that it takes by itself; seconds of the clock and of the
processor. The first compiles kernels, where none are on disk.
"""

import numpy as np
import pytest
from benchmarks.measure import CPU, WALL

import stickslip as ss

TITLE = "Along a parameter: the second of two calls"
VALUES = 2_000
LAW_9 = ("alpha", (1.208, 1.21865), {"window": (0.379, 0.390)})
COULOMB = ("V", (0.0366, 0.0372), {})
SYSTEMS = {"law (9)": (ss.examples.law9, LAW_9), "Coulomb": (ss.examples.coulomb, COULOMB)}


def bifurcations(model, name, between, options):
    return len(ss.bifurcations(model, name, between, **options))


def diagram(model, name, between, options):
    found = ss.bifurcation_diagram(model, name, np.linspace(*between, VALUES), **options)
    return len(found.orbits)


@pytest.mark.parametrize("ask", [bifurcations, diagram], ids=lambda ask: ask.__name__)
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.benchmark(timer=WALL, group="along a parameter")
def bench_one_call(benchmark, report, system, ask):
    make, (name, between, options) = SYSTEMS[system]
    model = make()
    ask(model, name, between, options)
    start = CPU()
    found = benchmark.pedantic(ask, (model, name, between, options), rounds=1)
    report.add(
        TITLE,
        system=system,
        call=ask.__name__,
        found=found,
        **{"clock s": benchmark.stats.stats.min, "processor s": CPU() - start},
    )
