"""Time a sweep against its kernels alone, and the engine without kernels."""

import numpy as np
import pytest
from benchmarks.measure import CPU, in_turns

import stickslip as ss

pytest.importorskip("zarr")

from stickslip.mechanics.eventmap.follow import ModelTable, follow
from stickslip.mechanics.eventmap.records import Controls
from stickslip.mechanics.flow.engine import engine_for
from stickslip.sweeps import sweep as sweeping
from stickslip.sweeps.axis import as_axes
from stickslip.sweeps.job import Computed, Job
from stickslip.sweeps.observables import as_observables
from stickslip.sweeps.seeds import spread_starts
from stickslip.sweeps.systems import as_system
from stickslip.sweeps.target import target

TABLE = "A sweep against its kernels alone (Coulomb, exponent and period, 1000 + 1000 maps)"
ENGINE = "A sweep without kernels"
OBSERVABLES = ("attractor", "lyapunov_exponent")
SIDE = 64  # a tile of the default size
LARGE = 1000


def _axes(n):
    return {"V": (0.03, 0.05, n), "alpha": (1.1, 1.3, n)}


def _job(n):
    axes = as_axes(_axes(n))
    system, wanted = as_system(ss.examples.coulomb()), as_observables(OBSERVABLES)
    return Job(system, tuple(axes), (n, n), wanted, 0, None), axes


def _kernels_alone(model, axes, count):
    """Follow the same orbits in one call; `count` points."""
    V, alpha = (
        grid.ravel() for grid in np.meshgrid(*(a.values for a in axes.values()), indexing="ij")
    )
    end = (1 + model.beta) / (1 + 2 * alpha)
    starts = spread_starts(0, np.arange(count, dtype=np.uint64), 1, -end, end)[:, 0]
    engine = engine_for(model)
    table = ModelTable(
        alpha,
        np.full(count, model.beta),
        V,
        laws=engine.laws[None],
        law_row=np.zeros(count, dtype=np.int64),
        of_start=np.arange(count),
    )
    controls = Controls(1e-15, 10_000, np.inf)
    return follow(
        engine, table, starts, controls=controls, transient=1000, n=1000, max_period=256, tail=1
    )


@pytest.mark.benchmark(timer=CPU, group="sweeps")
def bench_against_kernels(benchmark, report, tmp_path):
    model = ss.examples.coulomb()
    axes, count = as_axes(_axes(SIDE)), SIDE * SIDE
    stores = iter(range(100))

    def whole():
        store = tmp_path / f"{next(stores)}"
        return ss.sweep(
            model, axes, OBSERVABLES, store=store, threads=1, chunks={"V": SIDE, "alpha": SIDE}
        )

    pairs = in_turns(benchmark, whole, lambda: _kernels_alone(model, axes, count), rounds=3)
    report.add(
        TABLE,
        points=count,
        **{
            "ms/point": 1e3 * float(np.median(pairs.other)) / count,
            "sweep / kernels": 1 / pairs.ratio(),
        },
    )


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
