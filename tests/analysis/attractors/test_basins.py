"""Basins against maps whose basin edges are known, and against brute force."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from tests.analysis.known_maps import border_collision, logistic, square_root, tent_with_hole
from tests.sizes import slow

import stickslip as ss
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basin_pieces import (
    LEFT,
    UNDECIDED,
    Pieces,
    first_pieces,
    refined,
)
from stickslip.analysis.attractors.basins import basins
from stickslip.analysis.branches.discontinuities import ACCUMULATE, Unresolved
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import SAME, shaped
from stickslip.status import EVENT_LIMIT, NEVER_CYCLE, OK

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
        cubic(2.5),
        border_collision(a=0.5, b=0.5, mu=-0.5, jump=1.0),
        *slow(cubic(1.5), border_collision(a=0.5, b=-1.5, mu=1.0)),
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


def test_what_is_unknown_beside_a_gap_does_not_leave():
    f = cut_logistic()
    unknown = (Unresolved(ACCUMULATE, 0.1, 0.104), Unresolved(ACCUMULATE, 0.113, 0.12))
    pieces = first_pieces(f, replace(branch_table(f), unresolved=unknown), [])
    assert list(pieces.fate([0.101, 0.108, 0.115])) == [UNDECIDED, LEFT, UNDECIDED]


@dataclass(frozen=True)
class GivesUp:
    """The logistic map at 3.2, which has no value in [0.1, 0.12] and is given up in part of it."""

    domain = (0.0, 1.0)

    def evaluate(self, x):
        x = np.asarray(x, dtype=float)
        status = np.where((x > 0.1) & (x < 0.12), NEVER_CYCLE, OK)
        status[(x > 0.104) & (x < 0.113)] = EVENT_LIMIT
        value = np.where(status == OK, 3.2 * x * (1 - x), np.nan)
        return shaped(
            x.shape, value, 3.2 - 6.4 * x, np.zeros(x.shape, np.uint64), status, 0 * value
        )


def test_where_motions_are_given_up_nothing_is_claimed():
    f = GivesUp()
    (lo, hi) = branch_table(f).given_up[0]
    assert 0.1 <= lo <= 0.104
    assert 0.113 <= hi <= 0.12
    (told,) = ss.periodic_orbits(f, 2).unresolved
    assert (told.lo, told.hi) == (lo, hi)
    assert "raise max_events" in str(told)
    found = basins(f)
    assert list(found.at([0.5 * (0.1 + lo), 0.108, 0.5 * (hi + 0.12)])) == [LEFT, UNDECIDED, LEFT]
    # Preimages of what is given up, one on each side of the top: 3.2 x (1 - x) = 0.108.
    assert list(found.at(np.roots([-3.2, 3.2, -0.108]))) == [UNDECIDED, UNDECIDED]
    whole = found.left + found.undecided + found.share(0)
    assert found.undecided > hi - lo
    assert whole == pytest.approx(1, abs=EXACT)
    assert "raise max_events" in found.reason


def test_values_at_ends_of_laps_are_not_asked_for_again():
    asked = []

    def func(x):
        asked.append(np.size(x))
        return 3.2 * x * (1 - x)

    f = PiecewiseMap(func, (0, 1), derivative=lambda x: 3.2 - 6.4 * x)
    branches = branch_table(f)
    asked.clear()
    first_pieces(f, branches, [])
    assert sum(asked) == 0


def test_one_attractor_has_no_inner_edge():
    result = basins(logistic(3.2))
    assert list(result.edges) == [0, 1]
    assert result.share(0) == 1


def test_what_is_interwoven_is_sampled():
    result = basins(tent_with_hole(3.0), resolution=1e-5)
    share, error = result.sampled(-2)
    assert 0 < result.proved(-1) < 0.05
    assert share == result.proved(
        -1
    )  # all samples leave, the Cantor set of the others has no length
    assert 0 < error < 1e-3 * share
    assert (result.undecided, result.reason) == (0, "")
    assert result.left == pytest.approx(1)
    assert np.diff(result.edges)[result.index == -1].max() <= 2e-5
    assert "sampled" in repr(result)


def test_a_share_is_told_to_the_digits_of_its_error():
    found = basins(tent_with_hole(3.0), resolution=1e-5)
    rare = replace(found, counts=np.array([1, 19_999]))
    assert 0 < rare.sampled(LEFT)[0] < 5e-5
    for text in (repr(rare), *rare.plot().get_legend_handles_labels()[1]):
        assert " 0.000 " not in text
        assert " 0.0000 " not in text


def test_sampled_shares_agree_with_brute_force():
    f = cubic(2.5)
    proved = basins(f)
    coarse = basins(f, resolution=0.3, n_samples=2000)
    total = sum(coarse.share(k) for k in range(-2, len(coarse.attractors)))
    assert total == pytest.approx(1)
    for k in range(-2, len(proved.attractors)):
        error = coarse.sampled(k)[1]
        assert abs(coarse.share(k) - proved.share(k)) <= 5 * error + 1e-9


ONE_OWNER = {
    "period 12": ss.TwoBlock(alpha=0.9873, beta=1.5585, V=0.00698, friction=ss.Coulomb(mu=0.518)),
    "period 91": ss.TwoBlock(alpha=4.4865, beta=1.6083, V=0.06342, friction=ss.Coulomb(mu=0.388)),
    "law (9)": ss.TwoBlock(
        alpha=1.6897, beta=1.7686, V=0.02581, friction=ss.PoppStelter(gamma=1.97, delta=0.383)
    ),
}


@pytest.mark.parametrize("name", ONE_OWNER)
def test_one_attractor_owns_everything(name):
    """The intervals alone prove a few per cent of these, and once took ten minutes to do so."""
    result = basins(ss.event_map(ONE_OWNER[name]))
    assert len(result.attractors) == 1
    assert result.share(0) == pytest.approx(1)
    assert result.undecided == 0
    assert result.sampled(0)[1] < 1e-3


def random_system(seed):
    rng = np.random.default_rng(seed)
    friction = ss.Coulomb(mu=rng.uniform(0.05, 0.9))
    if seed % 2:
        friction = ss.PoppStelter(gamma=rng.uniform(0.3, 4), delta=rng.uniform(0, 0.5))
    sizes = {"alpha": rng.uniform(0.1, 3), "beta": rng.uniform(0.5, 2), "V": rng.uniform(0.02, 0.3)}
    return ss.TwoBlock(**sizes, friction=friction)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 100))]
)
def test_random_systems_agree_with_brute_force(seed):
    """Shares of 1000 starts that are iterated, against proved and sampled shares."""
    f = ss.event_map(random_system(seed))
    try:
        found = attractors(f)
    except ValueError:
        pytest.skip("no global stick phase is reached")
    result = basins(f, found)
    shares = np.array([result.share(k) for k in (*range(len(found)), -2, -1)])
    assert shares.sum() == pytest.approx(1)
    low, high = f.domain
    x = low + (high - low) * (np.arange(1000) + 0.5) / 1000
    inside = result.at(x)
    known = [k for k, a in enumerate(found) if a.kind != "undecided"]
    brute = ends(f, x, found, 2000)
    decided = (inside != -1) & np.isin(brute, [*known, -2])
    # An edge may pass between a point and its orbit in floats. Of the basin of an undecided
    # attractor the result claims nothing: where it owns everything, no point is compared.
    assert np.sum(inside[decided] != brute[decided]) <= 0.002 * decided.sum()
    for k in known:
        error = np.hypot(result.sampled(k)[1], np.sqrt(0.25 / 1000))
        assert abs(result.share(k) - np.mean(brute == k)) < 5 * error + np.mean(brute == -1)


def test_a_family_of_neutral_orbits_owns_its_basin():
    """Two equal blocks that slip in turn: every start of an interval has an orbit of period 2."""
    model = ss.TwoBlock(alpha=1.2, beta=1.0, V=0.05, friction=ss.Coulomb(mu=0.3))
    f = ss.event_map(model)
    result = basins(f)
    (family,) = [a for a in result.attractors if a.kind == "neutral"]
    assert family.period == 2
    assert family.bands == pytest.approx(-family.bands[::-1, ::-1])  # the mirror symmetry's
    x = family.bands[0, 0] + np.diff(family.bands[0]) * np.linspace(0.01, 0.99, 20)
    np.testing.assert_allclose(f.iterate(x, 2)[:, -1], x, rtol=1e-7, atol=1e-14)
    k = result.attractors.attractors.index(family)
    assert set(result.at(family.bands.mean(axis=1))) == {k}
    # Starts that creep towards the family's end, at multiplier 1 - 1e-7, are nobody's.
    assert result.undecided < 0.01
    assert sum(result.share(j) for j in range(-2, len(result.attractors))) == pytest.approx(1)


@pytest.mark.parametrize(
    ("func", "bands", "period"),
    [
        (lambda x: 1 - x, [[0, 1]], 2),
        (lambda x: np.where(x < 0.5, x + 0.5, x - 0.5), [[0, 1]], 2),
        (lambda x: np.where(x < 0.3, x, 0.1 + 0 * x), [[0, 0.3]], 1),
    ],
)
def test_a_neutral_family_is_one_entry(func, bands, period):
    f = PiecewiseMap(func, (0, 1), breakpoints=[0.3, 0.5])
    (family,) = attractors(f)
    assert (family.kind, family.period) == ("neutral", period)
    assert family.bands[[0, -1], [0, -1]] == pytest.approx(np.array(bands)[[0, -1], [0, -1]])
    assert basins(f).share(0) == pytest.approx(1)


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


def test_preimages_of_a_sliver_are_slivers():
    """Rounded preimages of its two ends may change places: what lies beside it keeps its fate."""
    f = PiecewiseMap("3.9*x*(1 - x) + 0.02*sin(7*x)", (0, 1))
    table = branch_table(f).laps
    whole = first_pieces(f, branch_table(f), [])
    for low in np.random.default_rng(0).uniform(0.05, 0.95, 60):
        k = int(np.searchsorted(whole.edges, low)) - 1
        high, number = float(low + 2 * np.spacing(low)), np.arange(len(whole.edges) + 2)
        pieces = Pieces(
            np.insert(whole.edges, k + 1, [low, high]),
            np.insert(whole.index, k + 1, [LEFT, UNDECIDED]),
            np.insert(whole.lap, k, [whole.lap[k]] * 2),
            np.insert(whole.value_left, k + 1, [f(low), f(high)]),
            np.insert(whole.value_right, k, [f(low), f(high)]),
            number,
            np.zeros_like(number),
        )
        for _ in range(3):
            pieces = refined(f, table, pieces, SAME)
        assert np.diff(pieces.edges)[pieces.index == LEFT].max() < 1e-13


@pytest.mark.parametrize(("plateau", "undecided"), [(0.7, 0.0), (0.75, 0.0), (0.8, 1.0)])
def test_a_plateau_on_the_way_of_a_cycle(plateau, undecided):
    # All but the origin falls on the plateau, whose image is one point. At 0.8 a corner is on the
    # cycle: one of its slopes alone would say that the cycle repels.
    f = PiecewiseMap(
        ["2*x", f"{plateau}", "2-2*x"], (0, 1), breakpoints=[plateau / 2, 1 - plateau / 2]
    )
    found = basins(f, n_samples=64)
    assert (len(found.attractors), found.undecided) == (1, undecided)
    assert found.share(0) == 1.0 - undecided


def test_an_interval_that_maps_into_itself_is_no_trap_if_another_cycle_is_inside():
    middle, wide = 0.013, 1e-4

    def bump(x):
        return 0.5 * middle * np.exp(-(((x - middle) / wide) ** 2))

    f = PiecewiseMap(
        lambda x: 0.5 * x + bump(x),
        (-1, 1),
        derivative=lambda x: 0.5 - 2 * (x - middle) / wide**2 * bump(x),
        breakpoints=[middle - 4 * wide, middle + 4 * wide],
    )
    found = basins(f)
    x = np.random.default_rng(0).uniform(middle - 2 * wide, middle + 2 * wide, 10_000)
    own = np.abs(f.iterate(x, 200)[:, -1] - middle) < wide
    low, high = x[own].min(), x[own].max()
    assert found.undecided == 0
    (inner,) = np.flatnonzero((found.edges[:-1] < middle) & (found.edges[1:] > middle))
    assert found.edges[inner : inner + 2] == pytest.approx([low, high], abs=1e-7)
