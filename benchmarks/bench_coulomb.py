"""Time the Coulomb map against scalar C, compiled in the same run, and check it on the way.

The C reference gives a motion up after 400 events, and so do we here.
"""

import math

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, map_in_c
from benchmarks.measure import CPU, in_turns

import stickslip as ss

TABLE = "Coulomb map against scalar C, one core"
MAX_EVENTS = 400
TOLERANCE = 1e-12
SYSTEMS = {
    "paper": (1.2, 1.3, 0.22, 0.0366),
    "one or two events": (0.5, 2.0, 0.5, 0.2),
    "forward slips": (1.947, 0.905, 0.085, 0.01),
    "long motions": (1.0, 1.5, 0.05, 0.2),
    "most never return": (1.885, 1.076, 0.898, 0.294),
    "some never return": (2.779, 0.991, 0.891, 0.06),
}
SIZE = {"paper": 200_000, "most never return": 2_000}


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("asked", ["f(d)", "f.derivative(d)"])
@pytest.mark.benchmark(timer=CPU, group="C")
def bench_against_c(benchmark, report, name, asked):
    alpha, beta, mu, V = SYSTEMS[name]
    model = ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=ss.Coulomb(mu=mu))
    f = ss.event_map(model, threads=1, max_events=MAX_EVENTS)
    ours = f if asked == "f(d)" else f.derivative
    d = np.random.default_rng(1).uniform(*f.domain, SIZE.get(name, 20_000))
    in_c = map_in_c(model)
    pairs = in_turns(benchmark, lambda: ours(d), lambda: in_c(d))
    value, other = f(d), in_c(d)
    both = ~np.isnan(value) & ~np.isnan(other)
    report.add(
        TABLE,
        system=name,
        asked=asked,
        **pairs.against_c(d.size),
        **{
            "largest difference": float(np.max(np.abs(value - other)[both], initial=0.0)),
            "one ends, one not": int((np.isnan(value) != np.isnan(other)).sum()),
        },
    )
    assert math.isfinite(pairs.ratio())
