"""Time a derivative and all the evidence beside a bare value, in arrays and one by one."""

import numpy as np
import pytest
from benchmarks.cases import CASES
from benchmarks.measure import CPU, in_turns

COST = "Cost of more than the value, one core, arrays"
SINGLE = "One point at a time from Python"
SIZE = {"Coulomb": 50_000, "law (9)": 1_000}
LOOP = {"Coulomb": 2_000, "law (9)": 100}
CALLS = {
    "f(d)": lambda f: f,
    "f.derivative(d)": lambda f: f.derivative,
    'f.parameter_derivative(d, "V")': lambda f: lambda d: f.parameter_derivative(d, "V"),
    "f.evaluate(d)": lambda f: f.evaluate,
}

each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
each_call = pytest.mark.parametrize("call", CALLS)


@each_case
@each_call
@pytest.mark.benchmark(timer=CPU, group="arrays")
def bench_arrays(benchmark, report, case, call):
    f = case.map()
    d = case.uniform(SIZE[case.name])
    more = CALLS[call](f)
    pairs = in_turns(benchmark, lambda: more(d), lambda: f(d))
    report.add(
        COST,
        law=case.name,
        call=call,
        **{
            "us/map": 1e6 * float(np.median(pairs.ours)) / d.size,
            "times f(d)": 1 / pairs.ratio(),
        },
    )


@each_case
@each_call
@pytest.mark.benchmark(timer=CPU, group="single calls")
def bench_single_calls(benchmark, report, case, call):
    ask = CALLS[call](case.map())
    points = case.uniform(LOOP[case.name]).tolist()
    benchmark.pedantic(lambda: [ask(d) for d in points], rounds=7, warmup_rounds=1)
    median = benchmark.stats.stats.median
    report.add(SINGLE, law=case.name, call=call, **{"us/call": 1e6 * median / len(points)})
