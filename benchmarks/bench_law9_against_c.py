"""Time law (9) against scalar C for the same equations, compiled in the same run."""

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, law9_map
from benchmarks.cases import law9
from benchmarks.measure import CPU, in_turns

TABLE = "Law (9) against scalar C (Taylor series, gcc), one core"
SIZE = 10_000
CALLS = {
    "f(d)": lambda f: f,
    "f.derivative(d)": lambda f: f.derivative,
    "f.evaluate(d)": lambda f: f.evaluate,
}


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.benchmark(timer=CPU, group="against C")
def bench_law9_against_c(benchmark, report, call):
    case = law9()
    f = case.map()
    ask = CALLS[call](f)
    d = case.uniform(SIZE)
    values = f.model.parameters
    names = ("alpha", "beta", "V", "gamma", "delta", "eta")
    in_c = [float(values[name]) for name in names]
    pairs = in_turns(benchmark, lambda: ask(d), lambda: law9_map(d, *in_c))
    low, high = pairs.spread()
    report.add(
        TABLE,
        call=call,
        maps=d.size,
        **{
            "us/map": 1e6 * float(np.median(pairs.ours)) / d.size,
            "C us/map": 1e6 * float(np.median(pairs.other)) / d.size,
            "ratio": pairs.ratio(),
            "pairs": f"{low:.1f} to {high:.1f}",
            "largest difference of values": float(np.nanmax(abs(f(d) - law9_map(d, *in_c)))),
        },
    )
