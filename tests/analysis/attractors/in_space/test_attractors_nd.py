"""Attractors and basins in R^n: closed forms, published numbers, and the peers' public tests.

Peers: Attractors.jl (test/mapping/attractor_mapping.jl, test/basins/uncertainty_tests.jl,
test/basins/wada_tests.jl, test/continuation/recurrences_continuation.jl), ChaosTools.jl
(test/stability/fixedpoints.jl, test/periodicity/periodicorbits.jl), PeriodicOrbits.jl
(test/stability.jl, test/algorithms/discrete_time/davidchack_lai.jl).
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.analysis.plane_maps import (
    TURN,
    duffing,
    grebogi,
    henon,
    newton,
    pendulum,
    points,
)

import stickslip as ss
from stickslip.analysis.attractors.in_space import fates as where_points_end
from stickslip.analysis.attractors.in_space import search_nd
from stickslip.analysis.attractors.in_space.basins_nd import BasinsND
from stickslip.analysis.attractors.in_space.fates import Grid, cells_of, fates
from stickslip.analysis.maps.map import kernels_of
from stickslip.analysis.maps.protocol import box_points
from stickslip.analysis.orbits.newton import solve_orbits
from stickslip.analysis.scales import IN_A_ROW
from stickslip.analysis.work import Work

SIGMA = 4.0  # standard errors by which a sampled share may be off
PEER_SAMPLES = 1000  # behind the shares of Attractors.jl


def within_samples(ours, theirs, samples=PEER_SAMPLES):
    """Whether two shares agree, the other one from samples."""
    error = math.sqrt(theirs * (1 - theirs) / samples)
    return abs(ours.value - theirs) <= SIGMA * math.hypot(error, ours.error)


# ------------------------------------------------------------------ closed forms


@pytest.mark.parametrize("n", [1, 2, 5])
def test_a_contraction_has_one_attractor_wherever_orbits_start(n):
    f = ss.Map(lambda z, c: z / 2 + c, n, parameters={"c": 0.25}, domain=[(-3, 3)] * n)
    (found,) = ss.attractors(f)
    assert (found.kind, found.period, found.basin_share) == ("periodic", 1, 1.0)
    assert np.allclose(found.points, 0.5, rtol=1e-12, atol=1e-14)
    assert found.lyapunov.value == pytest.approx(math.log(0.5))
    basins = ss.basins(f, ss.attractors(f), n_samples=64)
    assert (basins.share(0).value, basins.left, basins.undecided) == (1.0, 0.0, 0.0)
    assert basins.mistaken == 0


def test_basins_of_the_cubic_map_are_known():
    """x' = (3x - x^3) / 2 has fixed points ±1 and 0; y' = y / 2: the boundary is x = 0."""
    f = ss.Map(
        lambda z, r: points(0.5 * r * (3 * z[..., 0] - z[..., 0] ** 3), z[..., 1] / 2),
        2,
        parameters={"r": 1.0},
        domain=[(-1.7, 1.7), (-1, 1)],
    )
    basins = ss.basins(f, grid=[(-1.6, 1.6, 64), (-1, 1, 33)])
    x = np.broadcast_to(basins.axes[0][:, None], basins.index.shape)
    ends = np.array([attractor.points[0, 0] for attractor in basins.attractors])
    assert np.array_equal(ends[basins.index], np.sign(x))
    dimension = basins.boundary_dimension()
    assert dimension.value == pytest.approx(1.0, abs=0.02)  # a line


def test_many_points_are_followed_compiled_with_the_same_fates(monkeypatch):
    """Once a name was changed on one side only, and NumPy did it all, forty times slower."""
    f = henon()
    cells = cells_of(f, ss.attractors(f))
    x = box_points(f.domain, 200_000)

    def refused(*_):
        raise AssertionError("not compiled")

    fate, steps = np.empty(2000, dtype=np.int16), np.empty(2000, dtype=np.int32)
    limits = (IN_A_ROW, 500, fate, steps)
    where_points_end._fates_by_steps(f, x[:2000], cells, limits, Work())
    monkeypatch.setattr(where_points_end, "_fates_by_steps", refused)
    found = fates(f, x, cells, 500)
    assert np.array_equal(found[0][:2000], fate)
    assert np.array_equal(found[1][:2000], steps)


def test_an_irrational_turn_is_quasiperiodic_and_what_keeps_areas_attracts_nothing():
    def spiral(z, w):
        x, y = z[..., 0], z[..., 1]
        pull = 1.5 - 0.5 * (x**2 + y**2)  # towards the unit circle
        return points(
            pull * (x * np.cos(w) - y * np.sin(w)), pull * (x * np.sin(w) + y * np.cos(w))
        )

    f = ss.Map(spiral, 2, parameters={"w": TURN * 0.6180339887}, domain=[(-1.2, 1.2)] * 2)
    (found,) = ss.attractors(f)
    assert found.kind == "quasiperiodic"
    assert np.allclose(np.linalg.norm(found.points, axis=1), 1.0, rtol=1e-12, atol=1e-12)

    def standard(z, K):
        p = z[..., 1] + K / TURN * np.sin(TURN * z[..., 0])
        return points(z[..., 0] + p, p)

    g = ss.Map(standard, 2, parameters={"K": 5.0}, domain=[(0, 1), (0, 1)], periodic=[1.0, 1.0])
    for attractor in ss.attractors(g, n_starts=4):
        assert attractor.kind == "undecided"
        assert "volumes" in attractor.reason


def test_bands_visited_in_turn_do_not_blur_a_set():
    """Chaos in two bands: the distance of neighbours is that within one of them."""
    f = ss.Map(lambda x, r: r * x * (1 - x), 1, parameters={"r": 3.6}, domain=[(0, 1)])
    found = ss.attractors(f)
    assert found[0].kind == "chaotic"
    assert found.resolution < 0.01


def test_lozi_map_is_chaotic_with_the_exponents_of_plain_iteration():
    f = ss.Map(
        lambda z, a, b: points(1 - a * np.abs(z[..., 0]) + z[..., 1], b * z[..., 0]),
        2,
        parameters={"a": 1.7, "b": 0.5},
        domain=[(-1.5, 1.5), (-1, 1)],
    )
    (found,) = ss.attractors(f)
    assert found.kind == "chaotic"
    x, tangent, total = np.array([0.1, 0.1]), np.array([1.0, 0.0]), 0.0
    for _ in range(20_000):
        slope = np.array([[-1.7 * np.sign(x[0]), 1.0], [0.5, 0.0]])
        x = np.array([1 - 1.7 * abs(x[0]) + x[1], 0.5 * x[0]])
        tangent = slope @ tangent
        size = np.linalg.norm(tangent)
        total, tangent = total + math.log(size), tangent / size
    assert abs(found.lyapunov.value - total / 20_000) < SIGMA * found.lyapunov.error + 0.01


def test_border_collision_to_chaos_in_the_plane():
    """Banerjee and Grebogi, Phys. Rev. E 59 (1999) 4052: tau 0.5, -1.9, delta 0.3."""

    def func(z, mu):
        x, y = z[..., 0], z[..., 1]
        tau = np.where(x <= 0, 0.5, -1.9)
        return points(tau * x + y + mu, -0.3 * x)

    f = ss.Map(func, 2, parameters={"mu": -0.1}, domain=[(-3, 3), (-3, 3)])
    (left,) = ss.attractors(f)
    assert np.allclose(left.points[0], np.array([-0.1, 0.03]) / 0.8, rtol=1e-12)
    after = ss.attractors(f.replace(mu=0.1))
    assert [a.kind for a in after] != ["periodic"] or after[0].period > 1


@pytest.mark.parametrize("k", [0.5, 0.9])
def test_an_irrational_turn_of_the_whole_circle_is_quasiperiodic(k):
    """Volumes keep their mean, as of all that fills the space; lengths do not."""
    (found,) = ss.attractors(_circle((math.sqrt(5) - 1) / 2, k))
    assert (found.kind, found.basin_share) == ("quasiperiodic", 1.0)
    assert np.ptp(found.points % 1.0) > 0.99


@pytest.mark.parametrize("bend", [0.0, 0.1])
def test_what_keeps_areas_in_some_coordinates_attracts_nothing(bend):
    """The standard map, of the momentum y + bend sin y: only for bend = 0 is |det| 1."""

    def func(z, k):
        x, y = z[..., 0], z[..., 1]
        p = y + (bend * np.sin(TURN * y) + k * np.sin(TURN * x)) / TURN
        y = p
        for _ in range(16):
            y = p - bend / TURN * np.sin(TURN * y)
        return points(x + p, y)

    f = ss.Map(func, 2, parameters={"k": 0.3}, domain=[(0, 1)] * 2, periodic=[1.0, 1.0])
    found = ss.attractors(f, n_starts=4)
    assert len(found) == 4
    assert all(item.kind == "undecided" and "volumes" in item.reason for item in found)


@pytest.mark.parametrize(("turn", "period"), [(1.0, "step"), (-1.0, "2 steps")])
def test_cycles_of_a_family_are_not_quasiperiodic(turn, period):
    """As of a block that dry friction holds: wherever it is, it stays."""
    f = ss.Map(lambda z: z * np.array([0.5, turn]), 2, domain=[(-1, 1)] * 2)
    for found in ss.attractors(f, n_starts=4, max_steps=1000):
        assert (found.kind, found.recurrence) == ("undecided", 1.0)
        assert f"repeats every {period}," in found.reason


def test_an_orbit_that_repeats_exactly_is_not_tried_in_every_multiple_of_its_period(monkeypatch):
    tried = []

    def solved(f, guesses):
        tried.append(guesses.shape[1])
        return solve_orbits(f, guesses)

    monkeypatch.setattr(search_nd, "solve_orbits", solved)
    f = ss.Map(lambda z: z * np.array([0.0, 1.0]), 2, domain=[(-1, 1)] * 2)
    ss.attractors(f, n_starts=1, max_steps=1000)
    assert set(tried) == {1}


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_points_of_a_grid_are_those_of_a_mesh(axes):
    values = [np.linspace(k, k + 1, 3 + k) for k in range(axes)]
    coordinates = (2, 0, 3)[:axes]
    grid = Grid(tuple(values), coordinates, np.array([np.nan, 7.0, np.nan, np.nan]))
    mesh = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, axes)
    points = grid[np.arange(len(grid))]
    assert np.array_equal(points[:, coordinates], mesh)
    assert (points[:, 1] == 7.0).all()
    n_rows = len(grid) // grid.inner
    rows = [grid.rows(k, min(k + 2, n_rows)) for k in range(0, n_rows, 2)]
    assert np.array_equal(np.concatenate(rows), points, equal_nan=True)


def test_an_attractor_on_an_edge_of_the_domain_holds_no_points_outside():
    f = ss.Map(lambda z, c: z / 2, 2, parameters={"c": 1.0}, domain=[(0, 1), (-1, 1)])
    index = ss.basins(f, grid=[[-1e-6, 0.0, 0.5], [-1.0, 0.0, 1.0]]).index
    assert index.tolist() == [[-2] * 3, [0] * 3, [0] * 3]


def test_maps_that_differ_in_parameters_are_compiled_together():
    f = henon()
    assert kernels_of(f, 1, 1) is None
    assert kernels_of(f.replace(a=1.1), 10**6, 10**6) is not None
    assert kernels_of(f.replace(a=1.2), 1, 1) is not None


# ------------------------------------------------------------------ Attractors.jl


def test_henon_basin_share_of_attractors_jl():
    f = henon(domain=((-2.5, 2.5), (-2.5, 2.5)))
    found = ss.attractors(f)
    assert [a.kind for a in found] == ["chaotic"]
    basins = ss.basins(f, found, grid=[(-2, 2, 100), (-2, 2, 100)])
    assert within_samples(basins.share(0), 0.451)
    assert within_samples(basins.share(-2), 0.549)
    assert basins.share(0).value + basins.share(-2).value == pytest.approx(1.0, abs=1e-14)
    # templates of the peer: [0, 0] is attracted, [0, 2] diverges
    at = ss.basins(f, found, grid=[(0.0, 1e-9, 2), (0.0, 2.0, 2)]).index
    assert at[0].tolist() == [0, -2]
    assert basins.index.ndim == 2


def test_uncertainty_exponent_of_the_grebogi_map():
    """Attractors.jl: 0.2 <= alpha <= 0.3 (the paper: roughly 0.2); attractors at angles 0, pi."""
    basins = ss.basins(grebogi(), grid=[(0, TURN, 251), (-0.5, 0.5, 251)])
    alpha = 2 - basins.boundary_dimension().value
    assert 0.2 <= alpha <= 0.3
    assert len(basins.attractors) == 2
    ends = sorted(float(a.points[0, 0]) for a in basins.attractors)
    assert np.allclose(ends, [0, math.pi], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("a", "fractal"), [(1.3, False), (1.33, True), (1.39, True)])
def test_the_boundary_of_the_henon_map_becomes_fractal(a, fractal):
    """Grebogi, Ott & Yorke (1986): the edge of infinity's basin is smooth up to a = 1.315."""
    f = henon(a, -0.3, domain=((-2.5, 2.5), (-2.5, 1.5)))
    dimension = ss.basins(f, grid=[(-2.0, 2.0, 500), (-1.9, 1.0, 500)]).boundary_dimension()
    if fractal:
        assert dimension.value - SIGMA * dimension.error > 1.05
    else:
        assert abs(dimension.value - 1.0) < max(0.02, SIGMA * dimension.error)


@pytest.fixture(scope="module")
def roots():
    f = newton()
    found = ss.attractors(f, starts=box_points(np.array([[-1.0, 1.0]] * 2), 64))
    return ss.basins(f, found, grid=[(-1, 1, 150), (-1, 1, 150)])


def test_uncertainty_exponent_of_newtons_method(roots):
    """Attractors.jl: 0.55 <= alpha <= 0.65, the published dimension being 1.42."""
    dimension = roots.boundary_dimension()
    assert 0.55 - SIGMA * dimension.error <= 2 - dimension.value <= 0.65 + SIGMA * dimension.error
    found = sorted(tuple(np.round(a.points[0], 6)) for a in roots.attractors)
    exact = sorted(tuple(np.round([math.cos(a), math.sin(a)], 6)) for a in (0, TURN / 3, -TURN / 3))
    assert np.allclose(found, exact, rtol=1e-5)
    assert "complex" in roots.attractors.system.engine


def test_newtons_basins_have_the_wada_property_and_strips_have_not(roots):
    assert roots.wada_distance() <= 5.0  # steps of 150
    strips = np.repeat([0, 1, 2], 4)[:, None] * np.ones(12, dtype=int)  # Attractors.jl, smooth
    smooth = replace(roots, index=strips)
    assert smooth.wada_distance() > 3.0
    mixed = np.tile([0, 1, 2], 4)[:, None] * np.ones(12, dtype=int)  # its fractal one
    assert replace(roots, index=mixed).wada_distance() <= 1.0
    assert replace(roots, index=np.minimum(strips, 1)).wada_distance() == math.inf


@pytest.mark.slow
def test_duffing_shares_of_attractors_jl():
    f = duffing()
    basins = ss.basins(f, grid=[(-2.2, 2.2, 200), (-2.2, 2.2, 200)])
    shares = sorted(basins.share(k).value for k in range(2))
    assert within_samples(basins.share(0), 0.511)
    assert within_samples(basins.share(1), 0.489)
    assert sum(shares) == pytest.approx(1.0)


@pytest.mark.slow
def test_magnetic_pendulum_shares_of_attractors_jl():
    """A plane section, velocities 0; the magnets are alike, so that all shares are a third."""
    f = pendulum()
    basins = ss.basins(f, grid=[(-2, 2, 101), (-2, 2, 101), 0.0, 0.0])
    assert len(basins.attractors) == 3
    for k, theirs in enumerate((0.347, 0.335, 0.318)):
        assert within_samples(basins.share(k), theirs)
        assert within_samples(basins.share(k), 1 / 3)
    assert basins.wada_distance() < 0.2 * len(basins.axes[0])


def test_shares_of_two_attractors_that_appear_along_a_parameter():
    """Attractors.jl, a map with known shares: one fixed point for r < 0.5, then two halves."""

    def func(z, r):
        side = np.where(z[..., 0] > 0, r, -r) * (r >= 0.5)
        return points(side, side)

    f = ss.Map(func, 2, parameters={"r": 1.0}, domain=[(-10, 10), (-10, 10)])
    found = ss.basin_fractions(f, "r", (0.0, 2.0, 20))
    for r, known, basins in zip(found.values, found.numbers, found.basins, strict=True):
        assert len(known) == (1 if r < 0.5 else 2)
        shares = [basins.share(k).value for k in range(len(known))]
        assert sum(shares) == pytest.approx(1.0)
        if r > 0.5:
            assert all(0.4 < share < 0.6 for share in shares)
    assert len({frozenset(known) for known in found.numbers[6:]}) == 1  # numbers stay
    assert found.share(0)[:5].tolist() == [1.0] * 5


def test_the_attractor_that_outlives_a_fold_keeps_its_number():
    """The upper fixed point of z - (z^3 - z + c) / 10 is lost where c = 2 / 27^(1/2) = 0.385."""
    f = ss.Map(lambda z, c: z - (z**3 - z + c) / 10, 1, parameters={"c": 0.0}, domain=[(-1.2, 2.9)])
    found = ss.basin_fractions(f, "c", [0.37, 0.4], n_samples=16, n_starts=32)
    ends = [float(a.points[0, 0]) for a in found.basins[0].attractors]
    assert ends[0] > 0.0 > ends[1]
    assert found.numbers == ((0, 1), (1,))
    assert found.share(1)[1] == 1.0


def test_a_table_of_shares_tells_what_leaves_and_what_is_undecided():
    f = ss.Map(lambda z, r: z**3 - r * z, 2, parameters={"r": 0.5}, domain=[(-2, 2)] * 2)
    table = ss.basin_fractions(f, "r", [0.2], n_samples=100, max_steps=12).table()
    assert table["attractor"].tolist() == [-2, -1, 0]
    assert table["kind"].tolist() == ["leaves", "undecided", "periodic"]
    assert min(table["share"]) > 0.05
    assert sum(table["share"]) == pytest.approx(1.0, rel=1e-12, abs=0.0)


def test_shares_are_drawn_by_ascending_values():
    f = ss.Map(lambda z, r: z**3 - r * z, 2, parameters={"r": 0.5}, domain=[(-2, 2)] * 2)
    ax = ss.basin_fractions(f, "r", [0.6, 0.2, 0.4], n_samples=16, n_starts=4).plot()
    outline = ax.collections[0].get_paths()[0].vertices
    upper = outline[outline[:, 1] > 0.0]
    assert np.unique(upper[:, 0]).tolist() == [0.2, 0.4, 0.6]
    assert ax.get_xlim() == (0.2, 0.6)


def test_shares_of_a_single_value_are_seen():
    f = ss.Map(lambda z, r: z**3 - r * z, 2, parameters={"r": 0.5}, domain=[(-2, 2)] * 2)
    found = ss.basin_fractions(f, "r", [0.2], n_samples=16, n_starts=4)
    ax = found.plot()
    areas = [np.ptp(band.get_paths()[0].vertices, axis=0).prod() for band in ax.collections]
    assert max(areas) > 0.0
    assert ax.get_xlim() == (-0.3, 0.7)
    np.testing.assert_array_equal(ax.get_xticks(), [0.2])


@pytest.mark.parametrize("number", [-3, 1, 0.5, None])
def test_an_attractor_that_was_never_there_has_no_shares(number):
    f = ss.Map(lambda z, r: r * z, 2, parameters={"r": 0.5}, domain=[(-1, 1)] * 2)
    found = ss.basin_fractions(f, "r", [0.2, 0.6], n_samples=8)
    with pytest.raises(ValueError, match=r"number = .* must be a whole number from -2 to 0"):
        found.share(number)


def test_henon_attractor_is_matched_into_its_period_7_window():
    """Attractors.jl: chaotic at a = 1.2, a cycle of period 7 from a = 1.2265 on."""
    found = ss.basin_fractions(henon(), "a", [1.2, 1.21, 1.24, 1.25], n_samples=200)
    kinds = [(b.attractors[0].kind, b.attractors[0].period) for b in found.basins]
    assert kinds[0] == ("chaotic", 0)
    assert kinds[2:] == [("periodic", 7)] * 2
    assert found.numbers[0][0] in found.numbers[3]
    assert all(b.undecided == 0.0 for b in found.basins)


def test_no_attractor_is_an_answer():
    """Attractors.jl, "non-found attractors": the grid -25 .. -5 holds none of the Hénon map."""
    f = henon(domain=((-25, -5), (-25, -5)))
    found = ss.attractors(f)
    assert len(found) == 0
    assert found.left == 1.0
    assert ss.basins(f, found, n_samples=64).left == 1.0


# ------------------------------------------------------------------ periodic orbits of the peers


def test_fixed_points_of_chaostools():
    found = ss.periodic_orbits(henon(domain=((-1.5, 1.5), (-0.5, 0.5))))
    assert len(found) == 2
    assert [orbit.stable for orbit in found] == [False, False]
    x = -0.7 / 2.8 - math.sqrt(0.49 + 5.6) / 2.8
    assert any(np.allclose(orbit.points[0], [x, 0.3 * x], rtol=1e-9) for orbit in found)


def test_orbits_of_the_standard_map_of_chaostools():
    """All orbits of periods 2 and 3 found are among its published points; K = 0.971635."""
    f = ss.Map(
        lambda z, K: points(
            z[..., 0] + z[..., 1] + K * np.sin(z[..., 0]), z[..., 1] + K * np.sin(z[..., 0])
        ),
        2,
        parameters={"K": 0.971635},
        periodic=[TURN, TURN],
    )
    known = {
        2: [(1.3346, 2.6693), (4.9486, 3.6139), (0, 3.1416), (3.1416, 3.1416)],
        3: [
            *((0.8121, 1.6243), (5.471, 2.3295), (0.8121, 3.9537), (3.1416, 2.3295)),
            *((5.471, 4.6589), (3.1416, 3.9537), (1.7774, 1.7774), (4.5058, 4.5058)),
            *((0, 1.7774), (0, 4.5058), (1.7774, 3.5548), (4.5058, 2.7284)),
        ],
    }
    found = ss.periodic_orbits(f, 3, n_starts=512)
    for p, listed in known.items():
        ours = np.concatenate([orbit.points for orbit in found.of_period(p)])
        for point in ours:
            off = (point - np.array(listed) + math.pi) % TURN - math.pi
            assert np.abs(off).max(axis=1).min() < 1e-4
        assert len(ours) == len(listed)


def test_stability_of_periodicorbits():
    def logistic(r):
        return ss.Map(lambda x, r: r * x * (1 - x), 1, parameters={"r": r}, domain=[(0, 1)])

    for r, stable in ((2.3, True), (3.3, False)):
        orbit = ss.periodic_orbits(logistic(r))[-1]
        assert orbit.points[0, 0] == pytest.approx((r - 1) / r)
        assert orbit.stable is stable
    two = ss.periodic_orbits(henon(), period=2)
    assert all(not orbit.stable for orbit in two)
    ten = ss.periodic_orbits(henon(), 6)
    for orbit in ten:
        for x in orbit.points:
            assert np.abs(henon().iterate(x, orbit.period)[-1] - x).max() < 1e-9


# ------------------------------------------------------------------ the package's own


def test_results_are_kept_and_drawn(tmp_path, roots):
    found = ss.attractors(henon())
    basins = ss.basins(henon(), found, grid=[(-2, 2, 20), 0.0])
    fractions = ss.basin_fractions(henon(), "a", [1.2, 1.25], n_samples=32)
    for result in (found, found[0], basins, fractions, ss.rotation_number(_circle(0.5), 0.1)):
        path = tmp_path / "result.json"
        result.save(path)
        assert ss.load(path) == result
        assert result.table().n_rows >= 1
        assert type(result).__name__ in repr(result)
        result.plot()
    roots.plot()
    assert isinstance(roots, BasinsND)
    assert "undecided" in repr(roots)


def test_attractors_from_a_file_serve_the_map_at_hand(tmp_path):
    """A file holds no Python function: what it held is one of no map."""
    f = ss.Map(lambda z: z / 2, 2, domain=[(-1, 1)] * 2)
    ss.attractors(f).save(tmp_path / "found")
    found = ss.load(tmp_path / "found")
    assert found.system is None
    assert ss.basins(f, found, n_samples=8).share(0).value == 1.0


def test_features_group_orbits():
    """Fixed points ±1 of the cubic map and a third coordinate that nothing changes in effect."""
    f = ss.Map(
        lambda z, r: points(0.5 * r * (3 * z[..., 0] - z[..., 0] ** 3), z[..., 1] / 2),
        2,
        parameters={"r": 1.0},
        domain=[(-1.7, 1.7), (-1, 1)],
    )
    found = ss.attractors(f, features=lambda orbit: orbit[:, 0].mean())
    assert sorted(float(a.points[0, 0]) for a in found) == [-1.0, 1.0]


_line = ss.PiecewiseMap(lambda x: x / 2, (-1, 1))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda f: ss.basins(f, grid=[(0, 1, 5)]), "must hold 2 entries"),
        (lambda f: ss.basins(f, grid=(400, 400)), "is a point: a number holds a coordinate"),
        (lambda f: ss.basins(f, n_samples=8).boundary_dimension(), "give grid="),
        (lambda f: ss.basins(f, n_samples=8).share(7), "attractor = 7"),
        (lambda f: ss.attractors(henon(domain=None)), "no bounds"),
        *(
            (lambda f, wrong=wrong: ss.attractors(f, **wrong), next(iter(wrong)))
            for wrong in (
                *({"starts": x} for x in ([[0.1, 0.2, 0.3]], [], "ab", [[9.0, 0.0]])),
                *({"starts": [[math.nan, 0.0]]}, {"features": 1}, {"rng": 1}),
            )
        ),
        (lambda f: ss.basins(f, resolution=0.1), "resolution is for maps of a line"),
        (lambda f: ss.basins(_line, max_steps=9), "max_steps is for maps of R"),
        (lambda f: ss.attractors(_line, features=np.mean), "features is for maps of R"),
        (lambda f: ss.basin_fractions(f, "c", [1.0]), "'c' is not a parameter"),
        (lambda f: ss.rotation_number(f, [0.0, 0.0]), "no angle"),
    ],
)
def test_what_makes_no_sense_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call(henon())


# ------------------------------------------------------------------ rotation numbers


def _circle(omega, k=0.9, reduce=False):
    def func(x, omega, k):
        moved = x + omega + k / TURN * np.sin(TURN * x)
        return np.mod(moved, 1.0) if reduce else moved

    return ss.Map(func, 1, parameters={"omega": omega, "k": k}, periodic=[1.0])


def test_rotation_numbers_of_circle_maps():
    rigid = ss.rotation_number(_circle(math.sqrt(2) - 1, 0.0), 0.3)
    assert abs(float(rigid) - (math.sqrt(2) - 1)) < 1e-13
    locked = ss.rotation_number(_circle(0.5), [[0.1], [0.7]])
    assert np.allclose(locked.value, 0.5, rtol=1e-12, atol=1e-12)
    rho = ss.rotation_number(_circle(0.4), 0.3, 20_000)
    x, n = 0.3, 50_000
    for _ in range(n):
        x += 0.4 + 0.9 / TURN * math.sin(TURN * x)
    assert abs(rho.value - (x - 0.3) / n) < 1.0 / n  # |F^n(x) - x - n rho| < 1 (Poincaré)
    assert rho.error < 1e-6
    with pytest.raises(ValueError, match="as they grow"):
        ss.rotation_number(_circle(0.4, reduce=True), 0.3)


@pytest.mark.parametrize("start", [[0.1, 0.2, 0.3, 0.4], [0.1, 0.2, 0.3], 0.1])
def test_starts_have_as_many_coordinates_as_the_map(start):
    f = ss.Map(lambda z: z + 0.3, 2, periodic=[1.0, 1.0])
    with pytest.raises(ValueError, match=r"x0 = .* 2 numbers"):
        ss.rotation_number(f, start)


def test_basins_of_a_shaken_block_by_its_return_map():
    """Shares of sampled starts against plain iteration of the same starts."""
    block = ss.Oscillator(
        V=0.2,
        friction=ss.Coulomb(mu=0.4),
        damping=0.02,
        forcing=ss.Harmonic(amplitude=0.6, frequency=0.9),
    )
    f = ss.return_map(block, event="landing", domain=[(0, TURN), (-3, 3)])
    found = ss.attractors(f)
    basins = ss.basins(f, found, n_samples=256)
    orbits = f.iterate(f.spread(256), 200)
    ends, there = orbits[:, -1], f.contains(orbits).all(axis=1)
    assert basins.left == pytest.approx(1 - there.mean())
    for k, attractor in enumerate(found):
        near = np.abs(ends[:, None] - attractor.points).max(axis=2).min(axis=1) < 1e-6
        assert basins.share(k).value == (near & there).mean()


def test_an_edge_closer_to_an_attractor_than_its_cells_is_seen():
    """Orbits from |x| > 0.001 creep away from 0: ten steps in a cell about 0 do not show it."""

    def func(z, c):
        x = z[..., 0]
        far = np.where(np.abs(x) < 0.9, 1.02 * x, (x + np.sign(x)) / 2)
        return points(np.where(np.abs(x) < c, 0.98 * x, far), z[..., 1] / 2)

    f = ss.Map(func, 2, parameters={"c": 1e-3}, domain=[(-1.5, 1.5), (-1, 1)])
    found = ss.attractors(f, starts=[[0.0, 0.1], [0.5, 0.1], [-0.5, 0.1]])
    basins = ss.basins(f, found, grid=[(-0.01, 0.01, 201), 0.5])
    ends = np.array([attractor.points[0, 0] for attractor in found])[basins.index]
    x = basins.axes[0]
    away = np.abs(np.abs(x) - 1e-3) > 1e-9
    assert np.array_equal(ends[away], np.where(np.abs(x) < 1e-3, 0.0, np.sign(x))[away])
    assert basins.mistaken == 0
    assert basins.hits > 10
