"""Tables of polynomials against the maps they stand for: the same values, no break in a cell."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.known_maps import logistic

import stickslip as ss
from stickslip.analysis.attractors.lyapunov import MANY, advance, trace
from stickslip.analysis.interpolation._cell_kernels import DIRECT, cell_of
from stickslip.analysis.interpolation.cell_table import tabulated
from stickslip.analysis.maps.protocol import PointValues, checked_points
from stickslip.status import EVENT_LIMIT, OK

# What the table promises.
SAME = 1e-14
NEAR = 10.0 ** -np.arange(1.5, 13.01, 0.5)


class Windowed:
    """x -> sin(3 x) / 2 with another branch in a window, a root beside it, and a gap at the end."""

    domain = (-1.0, 1.0)

    def __init__(self, at, width, gap=2.0):
        self.at, self.width, self.gap = at, width, gap

    def evaluate(self, x, /):
        x = checked_points(self.domain, x)
        inside = np.abs(x - self.at) < self.width
        lost = x > self.gap
        root = np.sqrt(np.abs(x - self.at - self.width))
        value = np.where(inside, 0.3 + 0.1 * x, 0.5 * np.sin(3 * x) + 0.1 * root * (x > self.at))
        with np.errstate(divide="ignore"):
            smooth = 1.5 * np.cos(3 * x) + 0.05 * (x > self.at) / root
        slope = np.where(inside, 0.1, smooth)
        margin = np.minimum(np.abs(np.abs(x - self.at) - self.width), np.abs(x - self.gap))
        return PointValues(
            np.where(lost, np.nan, value),
            np.where(lost, np.nan, slope),
            np.where(inside, np.uint64(2), np.uint64(1)),
            np.where(lost, EVENT_LIMIT, OK),
            margin,
        )


@settings(max_examples=60)
@given(
    at=st.floats(-0.9, 0.9),
    width=st.floats(-13, -0.5).map(lambda k: 10**k),
)
def test_no_window_however_narrow_lies_in_a_cell(at, width):
    f = Windowed(at, width)
    x = np.random.default_rng(0).uniform(-1, 1, 4000)
    table = tabulated(f, x).table
    for edge in (at - width, at + width):
        assert cell_of(table, edge) == DIRECT
    near = np.concatenate(
        [edge + side * NEAR for edge in (at - width, at + width) for side in (-1, 1)]
    )
    x = np.concatenate([x, near[np.abs(near) < 1]])
    assert_same(f, tabulated(f, x), x)


def assert_same(f, fast, x):
    """One step of the table is that of the map, and not always by asking it."""
    orbit, slopes = fast.iterate_with_slopes(x, 1)
    values = f.evaluate(x)
    np.testing.assert_array_equal(np.isnan(orbit[:, 1]), values.status != OK)
    ok = values.status == OK
    assert np.abs(orbit[ok, 1] - values.value[ok]).max() <= SAME
    steep = np.maximum(1.0, np.abs(values.derivative[ok]))
    assert (np.abs(slopes[ok, 0] - values.derivative[ok]) <= 1e-6 * steep**2).all()
    assert (orbit[ok, 1] != values.value[ok]).any()


def test_where_no_orbit_has_been_the_map_is_asked():
    f = Windowed(-0.2, 0.1, gap=0.7)
    fast = tabulated(f, np.linspace(-0.9, 0.4, 3000))
    assert cell_of(fast.table, 0.2) != DIRECT
    assert cell_of(fast.table, 0.6) == cell_of(fast.table, 0.9) == DIRECT
    assert cell_of(fast.table, 1.5) == cell_of(fast.table, np.nan) == DIRECT
    x = np.array([-1.0, 0.2, 0.6, 0.9, 1.0])
    np.testing.assert_allclose(fast.iterate(x, 1)[:, 1], f.evaluate(x).value, atol=SAME, rtol=0)


def test_orbits_that_leave_stay_away_and_disturb_no_other():
    f = Windowed(-0.2, 0.1, gap=0.45)
    x = np.linspace(-0.9, 0.4, 3000)
    fast = tabulated(f, x)
    together = fast.iterate(x, 6)
    assert np.isnan(together[:, -1]).any()
    assert np.isfinite(together[:, -1]).any()
    for k in range(0, 3000, 300):
        np.testing.assert_array_equal(fast.iterate(x[k], 6), together[k])


def test_a_map_without_margins_or_with_nothing_to_serve_has_no_table():
    assert tabulated(logistic(3.9), np.linspace(0.1, 0.9, 100)) is None
    assert tabulated(Windowed(0.0, 0.5), np.full(3, np.nan)) is None
    assert tabulated(Windowed(0.0, 0.5), np.full(3, 0.5)) is None


def random_maps(n, seed):
    rng = np.random.default_rng(seed)
    ranges = ((0.1, 3), (0.5, 2), (0.005, 0.3), (0.05, 0.9))
    for _ in range(n):
        alpha, beta, V, mu = (float(rng.uniform(*ends)) for ends in ranges)
        model = ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=ss.Coulomb(mu=mu))
        yield ss.event_map(model, threads=1, max_events=60)


def assert_table_is_the_map(f):
    """At random points and beside all breakpoints; none of these in a cell."""
    x = np.random.default_rng(1).uniform(*f.domain, 20_000)
    x = x[np.isfinite(f(x))]
    fast = tabulated(f, x[:4000])
    if fast is None:  # motions of many events, whose own rounding is larger
        return 0
    breaks = np.array([b.d for b in ss.breakpoints(f)])
    assert all(cell_of(fast.table, d) == DIRECT for d in breaks)
    near = (breaks[:, None] + np.concatenate([-NEAR, NEAR])).ravel()
    x = np.concatenate([x, near[np.abs(near) < f.domain[1]]])
    assert_same(f, fast, x)
    return len(breaks)


def test_tables_of_event_maps():
    assert sum(map(assert_table_is_the_map, random_maps(3, seed=4))) > 10


@pytest.mark.slow
def test_tables_of_many_event_maps():
    assert sum(map(assert_table_is_the_map, random_maps(100, seed=5))) > 1000


@pytest.mark.parametrize("V", [0.0366, 0.03])
def test_exponents_are_those_of_the_map_itself(V, monkeypatch):
    f = ss.event_map(ss.examples.coulomb(V=V), threads=1)
    fast = ss.lyapunov_exponent(f, 0.1, MANY)
    values, slopes = trace(f, np.array([0.1]), MANY, 100)
    assert np.abs(values[0, 1:] - f(values[0, :-1])).max() <= SAME
    np.testing.assert_allclose(slopes[0], f.derivative(values[0]), rtol=1e-7)
    monkeypatch.setattr("stickslip.analysis.attractors.lyapunov.MANY", np.inf)
    direct = ss.lyapunov_exponent(f, 0.1, MANY)
    assert abs(fast.value - direct.value) <= 1e-12 + 3 * (fast.error + direct.error)


def test_a_chaotic_orbit_of_law_9_is_that_of_the_map():
    f = ss.event_map(ss.examples.law9(alpha=1.211), threads=1)
    past = advance(f, np.linspace(0.375, 0.39, 64), 40)
    orbit, slopes = tabulated(f, past).iterate_with_slopes(0.38, 20_000)
    x, slopes = orbit[-300:-1], slopes[-299:]
    assert np.abs(orbit[-299:] - f(x)).max() <= SAME
    np.testing.assert_allclose(slopes, f.derivative(x), rtol=1e-7)


def test_a_table_serves_an_orbit_that_starts_beside_a_breakpoint():
    f = ss.event_map(ss.examples.coulomb(V=0.03), threads=1)
    fast = tabulated(f, advance(f, np.array([0.1]), 4000)[0, 1:])
    for b in ss.breakpoints(f):
        np.testing.assert_allclose(fast.iterate(b.d, 1), f.iterate(b.d, 1), atol=SAME, rtol=0)
