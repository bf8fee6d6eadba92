"""Where the time of a Coulomb map goes: its arithmetic against what the core can do."""

import ctypes
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, library
from benchmarks.cases import CASES
from benchmarks.measure import CPU, in_turns

TABLE = "Arithmetic of a Coulomb map against the limit of the core"
ROUNDS, CHAINS = 2_000_000, 128
SIZE = 200_000


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.benchmark(timer=CPU, group="arithmetic")
def bench_arithmetic(benchmark, report):
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "benchmarks.counted"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    count = json.loads(done.stdout)
    peak = library("peak").peak
    peak.restype = ctypes.c_double
    case = CASES[0]
    f, d = case.map(), case.uniform(SIZE)
    pairs = in_turns(
        benchmark,
        lambda: f(d),
        lambda: peak(ctypes.c_long(ROUNDS), ctypes.c_double(0.5)),
        rounds=7,
    )
    limit = 2 * ROUNDS * CHAINS / float(np.median(pairs.other))
    seconds = float(np.median(pairs.ours)) / SIZE
    total = sum(count.values())
    report.add(
        TABLE,
        **{
            **{f"{kind}/map": n for kind, n in count.items()},
            "ns/map": 1e9 * seconds,
            "1e9 operations/s": 1e-9 * total / seconds,
            "core's limit, 1e9/s": 1e-9 * limit,
            "share": total / seconds / limit,
        },
    )
