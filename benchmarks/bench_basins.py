"""Time basins in the plane against a C loop written for the Henon map, in the same run."""

import ctypes

import numpy as np
import pytest
from benchmarks.c_code import COMPILER, library
from benchmarks.measure import CPU, in_turns

import stickslip as ss
from stickslip.analysis.attractors.in_space.fates import cells_of, fates
from stickslip.analysis.scales import IN_A_ROW

TABLE = "Basins of the Henon map, 1000 x 1000 starts, against a C loop written for it"
SIDE = 1000
MAX_STEPS = 20_000


def henon(z, a, b):
    """Hénon (1976)."""
    return np.stack([1 - a * z[..., 0] ** 2 + z[..., 1], b * z[..., 0]], axis=-1)


def loop_in_c(f, cells, x):
    """Run the loop on the same points, box and cells, these in a dense array."""
    marked = np.zeros(int(cells.counts.prod()), dtype=np.int8)
    marked[cells.keys] = 1
    fate = np.empty(len(x), dtype=np.int64)
    arrays = [np.ascontiguousarray(each) for each in (f.domain, cells.box, cells.per_cell)]
    box, held, per_cell = (ctypes.c_void_p(each.ctypes.data) for each in arrays)
    a, b = (ctypes.c_double(f.parameters[name]) for name in "ab")
    library("henon").henon(
        ctypes.c_long(len(x)),
        *(ctypes.c_void_p(x.ctypes.data), a, b, box, held, per_cell),
        *(ctypes.c_long(int(cells.counts[1])), ctypes.c_void_p(marked.ctypes.data)),
        *(ctypes.c_long(IN_A_ROW), ctypes.c_long(MAX_STEPS), ctypes.c_void_p(fate.ctypes.data)),
    )
    return fate


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.benchmark(timer=CPU, group="basins in the plane")
@pytest.mark.parametrize("call", ["fates of points", "ss.basins"])
def bench_henon_basins(benchmark, report, call):
    f = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3}, domain=[(-2.5, 2.5)] * 2)
    found = ss.attractors(f)
    cells = cells_of(f, found)
    ends = np.linspace(-2.0, 2.0, SIDE)
    x = np.stack(np.meshgrid(ends, ends, indexing="ij"), axis=-1).reshape(-1, 2).copy()
    grid = [(-2.0, 2.0, SIDE)] * 2
    calls = {
        "fates of points": lambda: fates(f, x, cells, MAX_STEPS)[0],
        "ss.basins": lambda: ss.basins(f, found, grid=grid, max_steps=MAX_STEPS).index.ravel(),
    }
    assert np.array_equal(calls[call](), loop_in_c(f, cells, x))
    pairs = in_turns(benchmark, calls[call], lambda: loop_in_c(f, cells, x))
    report.add(TABLE, call=call, starts=len(x), **pairs.against_c(len(x)))
