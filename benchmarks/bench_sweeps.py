"""Time a sweep against its kernels alone, and the engine without kernels."""

from resource import RUSAGE_SELF, getrusage
from time import process_time, thread_time

import numpy as np
import pytest
from benchmarks.measure import CPU

import stickslip as ss

pytest.importorskip("zarr")

from stickslip.mechanics.eventmap.follow import follow
from stickslip.sweeps import sweep as sweeping
from stickslip.sweeps import systems
from stickslip.sweeps.engines import in_dask, in_threads
from stickslip.sweeps.identity import target
from stickslip.sweeps.job import Computed, Job, Tile, as_axes
from stickslip.sweeps.observables import as_observables
from stickslip.sweeps.systems import as_system

TABLE = "A sweep over its kernels (Coulomb, exponent and period, 1000 + 1000 maps)"
POOLS = "A sweep of other laws (32 x 32 points, exponent and period, 1000 + 1000 maps)"
ENGINE = "A sweep without kernels"
HANDING = "Handing trivial tiles to an engine: processor time of a tile, ms"
COUNTS = (1000, *(pytest.param(n, marks=pytest.mark.slow) for n in (10_000, 100_000)))
OBSERVABLES = ("attractor", "lyapunov_exponent")
SIDE = 64  # a tile of the default size
LARGE, FEW, MAPS = 1000, 32, 2000


def _axes(n):
    return {"V": (0.03, 0.05, n), "alpha": (1.1, 1.3, n)}


def _job(n):
    axes = as_axes(_axes(n))
    system, wanted = as_system(ss.examples.coulomb()), as_observables(OBSERVABLES)
    return Job(system, tuple(axes), (n, n), wanted, 0, None), axes


@pytest.mark.benchmark(timer=CPU, group="sweeps")
@pytest.mark.parametrize("n", [300, pytest.param(LARGE, marks=pytest.mark.slow)])
def bench_plane(benchmark, report, tmp_path, monkeypatch, n):
    """All costs of a sweep over the time inside its kernels, and what memory it takes."""
    inside, memory = [], []

    def timed(*arguments, **more):
        began = thread_time()
        found = follow(*arguments, **more)
        inside.append(thread_time() - began)
        return found

    monkeypatch.setattr(systems, "follow", timed)
    ss.sweep(ss.examples.coulomb(), {"V": [0.0366]}, OBSERVABLES, store=tmp_path / "warm")
    inside.clear()

    def whole():
        return ss.sweep(
            ss.examples.coulomb(),
            _axes(n),
            OBSERVABLES,
            store=tmp_path / "x",
            threads=1,
            chunks={"V": SIDE, "alpha": SIDE},
            progress=lambda _: memory.append(getrusage(RUSAGE_SELF).ru_maxrss / 1024),
        )

    benchmark.pedantic(whole, rounds=1)
    report.add(
        TABLE,
        points=n * n,
        **{
            "ms/point": 1e3 * sum(inside) / n**2,
            "sweep / kernels": benchmark.stats.stats.median / sum(inside),
            "MB after a tenth": memory[len(memory) // 10],
            "MB at the end": memory[-1],
        },
    )


@pytest.mark.benchmark(timer=CPU, group="sweeps")
@pytest.mark.parametrize("law", [ss.PoppStelter(3.0), ss.Stribeck(0.4, 0.5)], ids=str)
def bench_pools(benchmark, report, tmp_path, law):
    """Time a plane whose orbits share pools, and orbits of its models one after the other."""
    model = ss.examples.law9().replace(friction=law)
    axes = {"V": (0.1, 0.2, FEW), "alpha": (1.1, 1.3, FEW)}
    ss.sweep(model, {"V": [0.12]}, OBSERVABLES, store=tmp_path / "warm")
    rng = np.random.default_rng(0)
    f = ss.event_map(model, threads=1)
    some = [f.replace(V=V, alpha=a) for V, a in rng.uniform([0.1, 1.1], [0.2, 1.3], (FEW, 2))]

    def follow_alone():
        for each in some:
            each.iterate([rng.uniform(*each.domain)], MAPS // 10)

    follow_alone()
    began = process_time()
    follow_alone()
    alone = (process_time() - began) / (FEW * MAPS // 10)
    benchmark.pedantic(
        lambda: ss.sweep(model, axes, OBSERVABLES, store=tmp_path / "x", threads=1), rounds=1
    )
    a_map = benchmark.stats.stats.median / (FEW**2 * MAPS)
    report.add(POOLS, law=type(law).__name__, **{"us/map": 1e6 * a_map, "alone": alone / a_map})


@pytest.mark.benchmark(timer=CPU, group="sweeps")
def bench_engine(benchmark, report, tmp_path, monkeypatch):
    """1000 x 1000 points whose values are random numbers."""
    job, axes = _job(LARGE)
    rng = np.random.default_rng(0)

    def without_kernels(_job, tile):
        arrays = {}
        for output in job.outputs:
            values = 60 * rng.random(tile.shape)
            arrays[output.name] = values.astype(output.dtype)
        return Computed(arrays, target())

    monkeypatch.setattr(sweeping, "compute", without_kernels)
    stores = iter(range(100))

    def run():
        store = tmp_path / f"{next(stores)}"
        chunks = {"V": SIDE, "alpha": SIDE}
        ss.sweep(ss.examples.coulomb(), axes, OBSERVABLES, store=store, threads=1, chunks=chunks)

    benchmark.pedantic(run, rounds=3)
    tiles = (-(-LARGE // SIDE)) ** 2
    folder = tmp_path / "0"
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    report.add(
        ENGINE,
        points=LARGE**2,
        tiles=tiles,
        **{
            "s": benchmark.stats.stats.median,
            "ms/tile": 1e3 * benchmark.stats.stats.median / tiles,
            "bytes/point": size / LARGE**2,
        },
    )


def _nothing(_job, _tile):
    return Computed({}, {})


def _tiles(n):
    one = np.zeros(1)
    return (Tile((i, 0), (0, 0), (one, one)) for i in range(n))


@pytest.mark.benchmark(timer=CPU, group="sweeps")
@pytest.mark.parametrize("n", COUNTS)
def bench_threads(benchmark, report, n):
    """Time a tile that is given to a thread."""
    job, _ = _job(LARGE)
    benchmark.pedantic(lambda: list(in_threads(_nothing, job, _tiles(n), 2)), rounds=1)
    report.add(HANDING, engine="threads", tiles=n, here=1e3 * benchmark.stats.stats.median / n)


@pytest.mark.benchmark(timer=CPU, group="sweeps")
@pytest.mark.parametrize("n", COUNTS)
def bench_dask(benchmark, report, n):
    """Time a tile in client and scheduler, in this process, and in the worker."""
    distributed = pytest.importorskip("distributed")
    job, _ = _job(LARGE)
    with (
        distributed.LocalCluster(1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):

        def worker():
            return sum(client.run(process_time).values())

        list(in_dask(_nothing, job, _tiles(100), client))  # connections, imports
        before = worker()
        benchmark.pedantic(lambda: list(in_dask(_nothing, job, _tiles(n), client)), rounds=1)
        there = worker() - before
    seconds = benchmark.stats.stats.median
    report.add(HANDING, engine="dask", tiles=n, here=1e3 * seconds / n, worker=1e3 * there / n)
