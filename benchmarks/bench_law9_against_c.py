"""Time law (9), and laws given as formulas, against scalar C for law (9) of the same run."""

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, map_in_c
from benchmarks.cases import law9
from benchmarks.measure import CPU, in_turns

import stickslip as ss

TABLE = "Law (9) against scalar C (Taylor series, gcc), one core"
SIZE = 10_000
CALLS = {
    "f(d)": lambda f: f,
    "f.derivative(d)": lambda f: f.derivative,
    "f.evaluate(d)": lambda f: f.evaluate,
}
OWN_TABLE = "Laws of one's own, f(d), against C for law (9), one core"
OWN_LAWS = {
    "0.3 + 0.7 exp(-3 s)": lambda s: 0.3 + 0.7 * np.exp(-3.0 * s),
    "0.4 + 0.6 exp(-4 s^2) + 0.05 s": lambda s: 0.4 + 0.6 * np.exp(-4.0 * s * s) + 0.05 * s,
    "1 - 0.6 tanh(2 s)": lambda s: 1.0 - 0.6 * np.tanh(2.0 * s),
    "1 / (1 + 3 s)": lambda s: 1.0 / (1.0 + 3.0 * s),
}


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.benchmark(timer=CPU, group="against C")
def bench_law9_against_c(benchmark, report, call):
    case = law9()
    f = case.map()
    ask = CALLS[call](f)
    d = case.uniform(SIZE)
    in_c = map_in_c(case.model)
    pairs = in_turns(benchmark, lambda: ask(d), lambda: in_c(d))
    report.add(
        TABLE,
        call=call,
        maps=d.size,
        **pairs.against_c(d.size),
        **{"largest difference of values": float(np.nanmax(abs(f(d) - in_c(d))))},
    )


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("law", OWN_LAWS)
@pytest.mark.benchmark(timer=CPU, group="laws of one's own")
def bench_own_law(benchmark, report, law):
    case = law9()
    f = ss.event_map(case.model.replace(friction=ss.friction_law(OWN_LAWS[law])), threads=1)
    d = case.uniform(SIZE)
    evidence = f.evaluate(d)
    assert not evidence.status.any()
    in_c = map_in_c(case.model)
    pairs = in_turns(benchmark, lambda: f(d), lambda: in_c(d))
    report.add(
        OWN_TABLE,
        law=law,
        **{"events/map": float(evidence.n_events.mean())},
        **pairs.against_c(d.size),
    )
