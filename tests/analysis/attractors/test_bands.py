"""Bands of chaotic attractors: how they grow, and how orbits go round in them."""

import math

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.attractors import bands
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.protocol import SAME, domain_width


@pytest.mark.parametrize("seed", range(4))
def test_turns_are_the_lengths_of_ways_from_a_band_back_to_itself(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 9))
    after = (np.arange(n) + 1) % n
    first = np.maximum(after - rng.integers(0, 2, n), 0)
    last = np.minimum(after + rng.integers(0, 2, n), n - 1)

    def f(x):
        k = np.minimum(np.floor(x), n - 1).astype(int)
        return first[k] + np.minimum(2 * (x - k), 1) * (last[k] + 0.5 - first[k])

    edges = np.unique([*range(1, n), *(np.arange(n) + 0.5)])
    table = branch_table(ss.PiecewiseMap(f, (0, n), breakpoints=edges.tolist()))
    meets = np.array([[a <= j <= b for j in range(n)] for a, b in zip(first, last, strict=True)])
    ways, lengths = np.eye(n, dtype=bool), []
    for length in range(1, 2 * n * n):
        ways = (ways.astype(int) @ meets) > 0
        lengths += [length] * bool(ways.diagonal().any())
    filled = np.column_stack([np.arange(n), np.arange(n) + 0.5])
    found = bands._turns(table.f, table.laps, filled, 1e-9)
    assert found == (math.gcd(*lengths), min(lengths))


@pytest.mark.parametrize("slope", [1.05, 1.3, 1.9])
def test_an_interval_in_a_lap_is_carried_on_by_its_ends(slope, monkeypatch):
    f = ss.PiecewiseMap(lambda x: slope * np.minimum(x, 1 - x), (0, 1), breakpoints=[0.5])
    laps = branch_table(f).laps
    start = 0.3 + np.array([[0.0, 1e-7]])
    grown = bands.grow(f, laps, start)
    ahead = list(bands._in_laps(f, laps, start))
    one_by_one = [start]
    for _ in ahead[1:]:
        one_by_one.append(bands.image(f, laps, one_by_one[-1], SAME * domain_width(f))[0])
    assert len(ahead) > 5
    np.testing.assert_allclose(ahead, one_by_one, rtol=1e-13)
    monkeypatch.setattr(bands, "_in_laps", lambda f, laps, intervals: iter([intervals]))
    alone = bands.grow(f, laps, start)
    assert (grown.period, grown.lowest_period) == (alone.period, alone.lowest_period)
    np.testing.assert_allclose(grown.intervals, alone.intervals, rtol=1e-13)
