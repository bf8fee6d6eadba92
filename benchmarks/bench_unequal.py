"""Time arrays of unequal blocks against scalar C for the same blocks, in one run."""

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, map_in_c
from benchmarks.measure import CPU, in_turns
from tests.mechanics.eventmap.unequal import pair

import stickslip as ss

TABLE = "Blocks of masses 1 and 2 against scalar C, one core"
TOLERANCE = 1e-12  # chaos is short here: two events a map
LAWS = {"Coulomb": (ss.Coulomb(mu=0.22), 0.0366), "law (9)": (ss.PoppStelter(gamma=3.0), 0.1)}
CALLS = {
    "f(d)": lambda f: f,
    "f.derivative(d)": lambda f: f.derivative,
    "f.evaluate(d)": lambda f: f.evaluate,
}


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.benchmark(timer=CPU, group="unequal")
def bench_unequal(benchmark, report, law, call):
    model = pair(*LAWS[law])
    f = ss.event_map(model, threads=1, max_events=400)
    ask = CALLS[call](f)
    d = np.random.default_rng(1).uniform(*f.domain, 20_000)
    in_c = map_in_c(model)
    pairs = in_turns(benchmark, lambda: ask(d), lambda: in_c(d))
    difference = float(np.nanmax(np.abs(f(d) - in_c(d))))
    report.add(TABLE, law=law, call=call, **pairs.against_c(d.size), difference=difference)
    assert difference < TOLERANCE
