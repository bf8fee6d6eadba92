"""Time an event of a chain against its length: only slipping blocks and their neighbours count."""

import numpy as np
import pytest
from benchmarks.measure import CPU

import stickslip as ss

COST = "Cost of an event of a Coulomb chain, one core"
EVENTS = 20_000


@pytest.mark.parametrize("n", [10, 30, 100])
@pytest.mark.benchmark(timer=CPU, group="chains")
def bench_event_of_a_chain(benchmark, report, n):
    limits = 1 + 0.3 * np.random.default_rng(1).random(n)
    chain = ss.Chain(static=limits, alpha=1.2, V=0.0366, friction=ss.Coulomb(mu=0.22))
    f = ss.event_map(chain, max_events=EVENTS, threads=1)
    starts = chain.sample_domain(max(1, 2000 // n), 3)
    events = f.evaluate(starts).n_events.sum()
    benchmark.pedantic(lambda: f(starts), rounds=5, warmup_rounds=1)
    seconds = benchmark.stats.stats.median
    report.add(COST, blocks=n, events=int(events), **{"us/event": 1e6 * seconds / events})
