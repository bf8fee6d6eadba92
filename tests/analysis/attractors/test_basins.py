"""Basins against maps whose basin edges are known, and against brute force."""

import numpy as np
import pytest
from tests.analysis.known_maps import border_collision, logistic, square_root, tent_with_hole

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basins import basins
from stickslip.analysis.maps.piecewise_map import PiecewiseMap

EXACT = 1e-12


def cubic(a):
    return PiecewiseMap(
        lambda x, a: a * x - x**3,
        (-1.6, 1.6),
        parameters={"a": a},
        derivative=lambda x, a: a - 3 * x**2,
    )


def cut_logistic():
    """Logistic map at 3.2 with a gap in [0.1, 0.12]."""

    def func(x):
        return np.where((x > 0.1) & (x < 0.12), np.nan, 3.2 * x * (1 - x))

    return PiecewiseMap(
        func,
        (0, 1),
        derivative=lambda x: 3.2 * (1 - 2 * x),
        breakpoints=[0.1, 0.12],
    )


def ends(f, x, found, steps=3000):
    """Index of the attractor that points reach, by iteration alone."""
    last = f.iterate(x, steps)[..., -8:]
    index = np.full(len(x), -1)
    index[~np.isfinite(last[:, -1])] = -2
    for k, attractor in enumerate(found):
        index[np.any(attractor.contains(last, slack=1e-9), axis=1)] = k
    return index


@pytest.fixture(scope="module")
def bistable():
    return basins(cubic(1.5))


def test_a_slow_attractor_takes_few_rounds():
    """At multiplier 0.98 a small interval about it would grow by a fiftieth a round."""
    found = basins(cubic(1.99))
    assert abs(found.attractors[0].orbit.multiplier) > 0.95
    assert found.rounds < 100
    x = np.linspace(-1.5, 1.5, 300)  # without the unstable fixed point 0
    np.testing.assert_array_equal(found.at(x), ends(cubic(1.99), x, found.attractors))


class TestBistableCubic:
    """x -> 1.5 x - x^3: unstable fixed point 0, unstable 2-cycle ±sqrt(2.5)."""

    def test_immediate_edges(self, bistable):
        at = np.searchsorted(bistable.edges, [-0.1, 1.0])
        assert bistable.edges[at] == pytest.approx([0, np.sqrt(1.5)], abs=EXACT)
        causes = [bistable.causes[k] for k in at]
        assert [(c.kind, c.order, c.period) for c in causes] == [("orbit", 0, 1), ("orbit", 1, 1)]

    def test_outermost_edges_are_a_two_cycle(self, bistable):
        assert bistable.edges[[1, -2]] == pytest.approx(
            [-np.sqrt(2.5), np.sqrt(2.5)], abs=2e-10
        )  # basins accumulate there: all edges within 1e-10 of the domain are one
        assert (bistable.causes[1].kind, bistable.causes[1].period) == ("orbit", 2)
        assert bistable.index[0] == bistable.index[-1] == -2

    def test_edges_are_preimages_of_each_other(self, bistable):
        f = cubic(1.5)
        for edge, cause in zip(bistable.edges[2:-2], bistable.causes[2:-2], strict=True):
            assert cause.kind == "orbit"
            assert cause.source == pytest.approx(0, abs=EXACT)
            end = f.iterate(edge, cause.order)
            slope = np.prod(np.abs(f.derivative(end[:-1]))) if cause.order else 1.0
            assert abs(end[-1]) < 1e-14 * max(slope, 1)

    def test_everything_is_decided(self, bistable):
        assert bistable.undecided == 0
        assert bistable.reason == ""
        assert bistable.left == pytest.approx(1 - np.sqrt(2.5) / 1.6, abs=1e-9)
        assert bistable.share(0) == pytest.approx(bistable.share(1), abs=1e-9)


@pytest.mark.parametrize(
    "f",
    [
        cubic(1.5),
        cubic(2.5),
        border_collision(a=0.5, b=0.5, mu=-0.5, jump=1.0),
        border_collision(a=0.5, b=-1.5, mu=1.0),
        border_collision(a=-1.4, b=-0.5, mu=-0.2, jump=0.7),
        square_root(),
        cut_logistic(),
    ],
    ids=repr,
)
def test_iteration_agrees(f):
    found = attractors(f)
    result = basins(f, found)
    low, high = f.domain
    x = low + (high - low) * np.random.default_rng(5).random(2000)
    clear = np.min(np.abs(x[:, None] - result.edges), axis=1) > 1e-9
    assert np.array_equal(result.at(x[clear]), ends(f, x[clear], found))
    assert result.undecided < 1e-6


def test_jump_is_an_edge():
    result = basins(border_collision(a=0.5, b=0.5, mu=-0.5, jump=1.0))
    assert result.edges == pytest.approx([-10, 0, 10])
    assert (result.causes[1].kind, result.causes[1].order) == ("breakpoint", 0)


def test_what_leaves_the_domain():
    result = basins(border_collision(a=0.5, b=-1.5, mu=1.0))
    assert result.edges == pytest.approx([-10, 22 / 3, 10])  # -1.5 x + 1 = -10
    assert list(result.index) == [0, -2]
    assert (result.causes[1].kind, result.causes[1].order) == ("domain", 1)


def test_gap_and_its_preimages():
    result = basins(cut_logistic())
    assert result.edges[0] == 0
    gap = np.searchsorted(result.edges, [0.0999, 0.1199])
    assert result.edges[gap] == pytest.approx([0.1, 0.12], abs=EXACT)
    assert [str(result.causes[k]) for k in gap] == ["end of a gap 0.1", "end of a gap 0.12"]
    assert result.index[gap[0]] == -2
    # Both preimages of the gap, one on each side of the top: 3.2 x (1 - x) = 0.1.
    before = np.sort(np.roots([-3.2, 3.2, -0.1]))
    at = np.searchsorted(result.edges, before - 1e-4)
    assert result.edges[at[0]] == pytest.approx(before[0], abs=EXACT)
    assert str(result.causes[at[0]]) == "preimage 1 of end of a gap 0.1"


def test_one_attractor_has_no_inner_edge():
    result = basins(logistic(3.2))
    assert list(result.edges) == [0, 1]
    assert result.share(0) == 1


def test_interwoven_basins_end_undecided():
    result = basins(tent_with_hole(3.0), resolution=1e-5)
    assert 0 < result.undecided < 0.05
    assert "interwoven" in result.reason
    assert result.left + result.undecided == pytest.approx(1)
    undecided = np.diff(result.edges)[result.index == -1]
    assert undecided.max() <= 2e-5


def test_neutral_attractor_leaves_its_basin_undecided():
    result = basins(logistic(3.0))
    assert result.undecided == pytest.approx(1)
    assert "unit circle" in result.reason


def test_resolution_is_checked():
    with pytest.raises(ValueError, match="resolution = 0"):
        basins(logistic(3.2), resolution=0)


def test_at_has_the_shape_of_its_argument(bistable):
    assert bistable.at(0.5) == bistable.at([[0.5]])[0, 0]
    with pytest.raises(ValueError, match="outside the domain"):
        bistable.at(5.0)


def test_repr_and_plot(bistable):
    assert "undecided" in repr(bistable)
    ax = bistable.plot()
    assert len(ax.collections) == 3  # two basins and what leaves
    assert len(ax.lines) == 2
