"""Time the way from the shell to the first number.

Whole processes, interpreter included. Processor time stands beside wall time, since only the
first does not depend on what else the machine does.
"""

import os
import subprocess
import sys
import time

import pytest

TABLE = "From the shell to the first number"
VALUE = "import stickslip as ss; ss.event_map(ss.examples.{system}())({d})"
STARTS = {
    "python -c pass": ["-c", "pass"],
    "stickslip --version": ["-m", "stickslip.cli", "--version"],
    "import stickslip": ["-c", "import stickslip"],
    "first Coulomb value": ["-c", VALUE.format(system="coulomb", d=0.1)],
    "first law (9) value": ["-c", VALUE.format(system="law9", d=0.38)],
}
COLD = ("first Coulomb value", "first law (9) value")


def _children() -> float:
    times = os.times()
    return times.children_user + times.children_system


def _run(benchmark, report, name, cache, rounds, warmup_rounds, environment=None):
    spent = []

    def start():
        before = _children()
        subprocess.run(
            [sys.executable, *STARTS[name]],
            check=True,
            env=os.environ | (environment or {}),
            stderr=subprocess.PIPE,
        )
        spent.append(_children() - before)

    benchmark.pedantic(start, rounds=rounds, warmup_rounds=warmup_rounds)
    processor = sorted(spent[warmup_rounds:])
    report.add(
        TABLE,
        process=name,
        cache=cache,
        **{
            "wall s": benchmark.stats.stats.median,
            "processor s": processor[len(processor) // 2],
        },
    )


@pytest.mark.parametrize("name", STARTS)
@pytest.mark.benchmark(timer=time.perf_counter, group="start")
def bench_warm(benchmark, report, name):
    _run(benchmark, report, name, "warm", rounds=5, warmup_rounds=1)


@pytest.mark.parametrize("name", COLD)
@pytest.mark.benchmark(timer=time.perf_counter, group="start")
def bench_cold(benchmark, report, name, tmp_path):
    environment = {"STICKSLIP_CACHE_DIR": str(tmp_path)}
    _run(benchmark, report, name, "empty", rounds=1, warmup_rounds=0, environment=environment)
