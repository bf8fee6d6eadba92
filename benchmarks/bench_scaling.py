"""Maps per second and memory against the size of the array, threads, and events of a map.

What the number of blocks costs: `bench_chain.py`.
"""

import subprocess
import sys

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, map_in_c
from benchmarks.cases import CASES
from benchmarks.measure import CPU, WALL, in_turns

import stickslip as ss
from stickslip.numerics.targets import available_threads, kernel, launch

BATCH = "Maps per second against the size of the array, one core"
THREADS = "Threads: gain of a second one, for maps, bare arithmetic in turns, and C (wall time)"
EVENTS = "Events of a map: one core"
ORBIT = "Long orbits at fixed parameters, one core"
MEMORY = "Memory against the size of the array"
SIZES = (1, 8, 16, 64, 256, 512, 4096, 65_536, 1_000_000)
LARGEST = {"Coulomb": 1_000_000, "law (9)": 65_536}
MAX_EVENTS = 400
MANY = 1_000_000
SHARED = {
    "two blocks": (ss.examples.coulomb(), MANY),
    "chain of three": (
        ss.Chain(static=[1.0, 1.2, 0.9], alpha=1.2, V=0.1, friction=ss.Coulomb(mu=0.22)),
        10_000,
    ),
}

each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
needs_c = pytest.mark.skipif(COMPILER is None, reason="no C compiler")


@each_case
@pytest.mark.parametrize("n", SIZES)
@pytest.mark.benchmark(timer=CPU, group="batch")
def bench_batch(benchmark, report, case, n):
    if n > LARGEST[case.name]:
        pytest.skip("takes too long")
    f, d = case.map(), case.uniform(n)
    x = float(d[0])
    repeats = max(1, (20_000 if case.name == "Coulomb" else 400) // n)

    def maps():
        for _ in range(repeats):
            f(x if n == 1 else d)

    benchmark.pedantic(maps, rounds=7, warmup_rounds=1)
    seconds = benchmark.stats.stats.median / repeats
    report.add(BATCH, law=case.name, n=n, **{"us/map": 1e6 * seconds / n, "maps/s": n / seconds})


@pytest.mark.parametrize("mu", [0.05, 0.1, 0.2, 0.4, 0.7, 0.9])
@pytest.mark.benchmark(timer=CPU, group="events")
@needs_c
def bench_events(benchmark, report, mu):
    alpha, beta, V = 1.0, 1.5, 0.2
    model = ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=ss.Coulomb(mu=mu))
    f = ss.event_map(model, threads=1, max_events=MAX_EVENTS)
    d = np.random.default_rng(1).uniform(*f.domain, 20_000)
    events = f.evaluate(d[:4000]).n_events
    in_c = map_in_c(model)
    pairs = in_turns(benchmark, lambda: f(d), lambda: in_c(d), rounds=5)
    report.add(
        EVENTS,
        system=f"alpha = {alpha}, beta = {beta}, V = {V}, mu = {mu}",
        **{
            "events/map": float(events.mean()),
            "us/map": 1e6 * float(np.median(pairs.ours)) / d.size,
            "ns/event": 1e9 * float(np.median(pairs.ours)) / d.size / float(events.mean()),
            "times faster than C": pairs.ratio(),
        },
    )


@kernel
def _bare_arithmetic(arrays, n):
    """Products and sums, as many as a core can do: no memory, no waiting."""
    for rows in arrays:
        row = rows[0]
        for _ in range(n):
            for i in range(row.size):
                row[i] = row[i] * 0.999 + 0.001


@pytest.mark.skipif(available_threads() < 2, reason="this process may use one core only")
@needs_c
@pytest.mark.parametrize("name", SHARED)
@pytest.mark.benchmark(timer=WALL, group="threads")
def bench_threads(benchmark, report, name):
    """Two threads against one; bare arithmetic in turns and C: what the machine has to give.

    A virtual machine's two cores may be the two hyperthreads of one, now and then. C, which waits
    more than it computes, hardly shows that.
    """
    model, n = SHARED[name]
    one, two = (ss.event_map(model, threads=threads) for threads in (1, 2))
    d = model.sample_domain(n, 1)
    arrays = np.ones((2, 2, 512))  # every other row: no cache line of two threads

    def bare(threads):
        launch(lambda i, j: _bare_arithmetic(arrays[i:j], 500_000), 2, threads, 1)

    turns = []

    def turn():
        for work in (lambda: one(d), lambda: two(d), lambda: bare(1), lambda: bare(2)):
            start = WALL()
            work()
            turns.append(WALL() - start)

    benchmark.pedantic(turn, rounds=25, warmup_rounds=1)
    alone, together = ([_c_processes(n) for _ in range(5)] for n in (1, 2))
    seconds = np.reshape(turns, (-1, 4))[1:]
    gain, bare_gain = (seconds[:, [0, 2]] / seconds[:, [1, 3]]).T
    report.add(
        THREADS,
        model=name,
        maps=n,
        **{
            "1 thread, million/s": 1e-6 * n / float(np.median(seconds[:, 0])),
            "2 threads, million/s": 1e-6 * n / float(np.median(seconds[:, 1])),
            "gain": float(np.median(gain)),
            "rounds": f"{gain.min():.2f} to {gain.max():.2f}",
            "of bare arithmetic": float(np.median(bare_gain)),
            "its rounds": f"{bare_gain.min():.2f} to {bare_gain.max():.2f}",
            "of C, 2 processes": 2 * float(np.median(alone)) / float(np.median(together)),
        },
    )


C_PROCESS = """
import time, numpy as np, stickslip as ss
from benchmarks.c_code import map_in_c
in_c = map_in_c(ss.examples.coulomb())
d = np.random.default_rng(1).uniform(-.67, .67, 1_000_000)
in_c(d[:1000])
input()
start = time.perf_counter()
in_c(d)
print(time.perf_counter() - start)
"""


def _c_processes(n):
    """Longest time of 10^6 maps in C, n processes at once."""
    command = [sys.executable, "-c", C_PROCESS]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    started = [subprocess.Popen(command, **pipes) for _ in range(n)]
    for process in started:
        process.stdin.write("\n")
        process.stdin.flush()
    return max(float(process.communicate()[0]) for process in started)


@pytest.mark.parametrize("V", [0.0366, 0.03])
@pytest.mark.benchmark(timer=CPU, group="orbit")
def bench_exponent(benchmark, report, V):
    """10^6 steps with their exponent, on a table of the map and by the map itself."""
    f = ss.event_map(ss.examples.coulomb(V=V), threads=1)
    few = MANY // 50
    start = np.array([0.1])
    pairs = in_turns(
        benchmark,
        lambda: ss.lyapunov_exponent(f, 0.1, MANY, transient=1000),
        lambda: (f.iterate(start, few), f.derivative(f.iterate(start, few))),
        rounds=5,
    )
    low, high = pairs.spread(MANY / few)
    report.add(
        ORBIT,
        V=V,
        steps=MANY,
        **{
            "exponent, s": float(np.median(pairs.ours)),
            "ns/step": 1e9 * float(np.median(pairs.ours)) / MANY,
            "times faster than points, then slopes": pairs.ratio(MANY / few),
            "pairs": f"{low:.0f} to {high:.0f}",
        },
    )


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@each_case
@pytest.mark.parametrize("n", [1000, 100_000, 1_000_000])
@pytest.mark.benchmark(group="memory")
def bench_memory(benchmark, report, case, n):
    """Largest resident memory of a process that evaluates n maps, less that of one with one map."""
    if n > 10 * LARGEST[case.name] or (case.name == "law (9)" and n > 100_000):
        pytest.skip("takes too long")
    law = "coulomb()" if case.name == "Coulomb" else "law9(alpha=1.2099)"
    code = (
        "import re, sys, numpy as np, stickslip as ss\n"
        f"f = ss.event_map(ss.examples.{law}, threads=1)\n"
        f"d = np.linspace(*{case.window}, int(sys.argv[1]))\n"
        "f(d)\n"
        "print(re.search(r'VmHWM:\\s+(\\d+)', open('/proc/self/status').read())[1])"
    )

    def largest(size):
        command = [sys.executable, "-c", code, str(size)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        return 1024 * int(done.stdout)

    base = largest(1)
    most = benchmark.pedantic(largest, args=(n,), rounds=1)
    report.add(
        MEMORY,
        law=case.name,
        n=n,
        **{"MiB of the process": most / 2**20, "bytes/map": (most - base) / n},
    )
