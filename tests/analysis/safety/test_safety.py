"""Safety of attractors: closed forms, an integral equation, plain iteration, motions in time."""

import math

import numpy as np
import pytest
from tests.analysis.plane_maps import henon, points

import stickslip as ss
from stickslip.analysis.safety import kicks, surroundings
from stickslip.analysis.safety.safety import Settling
from stickslip.numerics.zeros import halved

SIGMA = 4.0  # standard errors by which an estimate may be off
ROUNDING = 1e-12  # of lengths of about 1


def cubic(r, width=1.5):
    """Fixed points 0 and ±sqrt(r - 1); the basins of these meet at 0 and ±sqrt(r)."""
    return ss.PiecewiseMap(lambda x, r: r * x - x**3, (-width, width), parameters={"r": r})


def cubic_beside_contraction():
    return ss.Map(
        lambda z, r: points(r * z[..., 0] - z[..., 0] ** 3, z[..., 1] / 2),
        2,
        parameters={"r": 1.6},
        domain=[(-1.5, 1.5), (-1, 1)],
    )


def contraction(a, half):
    return ss.PiecewiseMap(lambda x, a: a * x, (-half, half), parameters={"a": a})


# ------------------------------------------------------------------ displacements and shares


@pytest.mark.parametrize("r", [1.2, 1.45, 1.9])
def test_a_cubic_maps_basin_ends_at_the_origin_or_at_its_preimage(r):
    top = math.sqrt(1.0 + r) - 1e-3  # inside the cycle beyond which orbits leave
    found = ss.safety(cubic(r, top))
    fixed = math.sqrt(r - 1.0)
    assert abs(abs(found.displacement.point[0]) - fixed) < ROUNDING
    assert abs(found.displacement.size - min(fixed, math.sqrt(r) - fixed)) < 1e-10
    assert found.displacement.into == 1
    assert found.displacement.tested == 0
    assert found.share.value == pytest.approx(0.5, abs=1e-9)
    assert found.share.error == 0.0


def test_the_only_attractor_is_safe_up_to_the_ends_of_the_domain():
    f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0.0, 1.0), parameters={"r": 3.2})
    found = ss.safety(f)
    low, high = np.sort(found.attractor.orbit.points)
    assert found.displacement.size == pytest.approx(min(low, 1.0 - high), rel=1e-12)
    assert found.displacement.into == -2
    assert found.share.value == pytest.approx(1.0)
    tent = ss.PiecewiseMap(lambda x, m: m * np.minimum(x, 1 - x), (0.0, 1.0), parameters={"m": 1.9})
    chaos = ss.safety(tent)  # its bands: f(m / 2) to m / 2
    ends = 1.9 * (1 - 0.95), 0.95
    assert chaos.displacement.size == pytest.approx(min(ends[0], 1 - ends[1]), rel=1e-9)
    assert chaos.time_constant == math.inf


def test_in_the_plane_the_search_finds_what_a_line_knows():
    """The cubic map beside a contraction: the nearest boundary is a line at a known distance."""
    f = cubic_beside_contraction()
    found = ss.safety(f, n_samples=1024)
    exact = math.sqrt(1.6) - math.sqrt(0.6)
    assert exact - 1e-9 <= found.displacement.size <= 1.001 * exact
    assert found.displacement.tested == 1024
    assert abs(found.share.value - 0.5) < SIGMA * found.share.error


def test_only_ways_that_may_be_the_shortest_are_bisected_to_the_end(monkeypatch):
    """And the way that is found is the one of all ways bisected alike."""
    f = cubic_beside_contraction()
    near, rng = surroundings.SpaceSurroundings(f, ss.attractors(f), 0), np.random.default_rng(0)
    ways = rng.normal(size=(2048, 2))
    base = near.points[np.zeros(2048, dtype=int)]
    ways, base = (each[near.fate(base + ways) != near.k] for each in (ways, base))
    fate, asked = near.fate, []
    monkeypatch.setattr(near, "fate", lambda x: (asked.append(len(x)), fate(x))[1])
    found, ends = near._bisected(base, ways)
    assert len(asked) == surroundings.HALVINGS
    assert sum(asked) < 0.2 * surroundings.HALVINGS * len(ways)
    _, high = halved(
        lambda share: fate(base + share[:, None] * ways) == near.k,
        np.zeros(len(ways)),
        np.ones(len(ways)),
        surroundings.HALVINGS,
    )
    k = np.argmin(high * np.linalg.norm(ways, axis=1))
    np.testing.assert_array_equal(found.way, high[k] * ways[k])
    least = [near._distances(x)[0].min() for x in (ends, base + high[:, None] * ways)]
    assert least[0] == least[1]


def test_a_call_that_lasts_says_what_is_tried(monkeypatch):
    said = []
    for module in (surroundings, kicks):
        monkeypatch.setattr(module, "doing", said.append)
    f = cubic_beside_contraction()
    ss.safety(f, n_samples=64, kicks=0.1, within=3, n_runs=10)
    assert said[0].startswith("starts all over the domain, 64: ")
    first = said.index("displacements: any that lead away")
    assert said[first + 1].startswith("displacements, round 1: shortest so far 0.")
    assert said[-1] == "kicks: step 3 of at most 3, 0 of 10 runs escaped"


def test_nothing_foreign_is_nearer_than_the_displacement_of_henon():
    f = henon(domain=((-2.5, 2.5), (-2.5, 2.5)))
    listed = ss.attractors(f)
    found = ss.safety(f, found=listed)
    near = ss.basins(f, listed, grid=[(1.0, 1.4, 300), (-0.3, 0.3, 300)])
    i, j = np.nonzero(near.index != 0)
    foreign = np.stack([near.axes[0][i], near.axes[1][j]], axis=-1)
    distance = min(np.linalg.norm(foreign - x, axis=1).min() for x in listed[0].points)
    assert 0.97 * distance < found.displacement.size < 1.02 * distance  # a grid of 0.0013
    at = np.array(found.displacement.point) + np.array(found.displacement.by)
    orbit = at
    for _ in range(200):
        orbit = np.array([1 - 1.4 * orbit[0] ** 2 + orbit[1], 0.3 * orbit[0]])
        if np.abs(orbit).max() > 2.5:
            break
    assert np.abs(orbit).max() > 2.5
    inside = sum(np.abs(f.iterate(x, 100)[-1]).max() < 2.5 for x in f.spread(4096))  # NaN is not
    assert abs(found.share.value - inside / 4096) < SIGMA * found.share.error


# ------------------------------------------------------------------ times to settle


def test_a_contraction_settles_after_as_many_steps_as_its_slope_says():
    found = ss.safety(contraction(0.5, 1.0), tolerance=1e-3, n_samples=2000)
    near = 2e-3  # of the width 2
    for share in (0.25, 0.5, 0.9):
        exact = max(0, math.ceil(math.log2(share / near)))  # |x| is below that share of the domain
        got = found.settling.quantile(share)
        assert abs(got.value - exact) <= 1.0
        assert got.error <= 1.0
    assert found.settling.steps.max() == math.ceil(math.log2(1.0 / near))
    assert found.time_constant == pytest.approx(1.0 / math.log(2.0))
    assert found.settling.within == pytest.approx(near)


def test_quantiles_have_the_errors_that_repeated_samples_show():
    rng = np.random.default_rng(3)
    samples = [Settling(np.sort(rng.exponential(size=400)), 1.0) for _ in range(200)]
    values, errors = np.array([each.quantile(0.5) for each in samples]).T
    assert abs(values.mean() - math.log(2.0)) < SIGMA * values.std() / math.sqrt(200)
    assert errors.mean() == pytest.approx(values.std(), rel=0.3)


# ------------------------------------------------------------------ random kicks


def mean_exit(a, half, density, n=200):
    """T(x) = 1 + integral of density(y - a x) T(y) over the domain, at 0, by quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    y, w = half * nodes, half * weights
    kernel = density(y[None, :] - a * y[:, None]) * w
    times = np.linalg.solve(np.eye(n) - kernel, np.ones(n))
    return 1.0 + float(density(y) * w @ times)


@pytest.mark.parametrize("a", [0.0, 0.5, -0.8])
def test_escape_from_a_contraction_fulfils_its_integral_equation(a):
    sigma = 0.4
    exact = mean_exit(
        a, 1.0, lambda y: np.exp(-0.5 * (y / sigma) ** 2) / sigma / math.sqrt(2 * math.pi)
    )
    got = ss.safety(contraction(a, 1.0), kicks=sigma, n_runs=2000).escape
    assert abs(got.mean.value - exact) < SIGMA * got.mean.error
    assert got.mean.error < 0.05 * exact
    assert got.escaped.value == 1.0
    assert got.into == {-2: 2000}


def test_uniform_kicks_and_runs_that_are_given_up():
    def density(y):
        return np.where(np.abs(y) <= 0.8, 1 / 1.6, 0.0)

    exact = mean_exit(0.5, 1.0, density, 1000)
    f = contraction(0.5, 1.0)
    got = ss.safety(f, kicks=0.8, distribution="uniform", n_runs=1000).escape
    assert abs(got.mean.value - exact) < SIGMA * got.mean.error + 0.01 * exact
    few = ss.safety(f, kicks=0.8, distribution="uniform", n_runs=1000, within=10).escape
    assert 0.0 < few.escaped.value < 1.0
    assert abs(few.mean.value - exact) < SIGMA * few.mean.error + 0.1 * exact  # memoryless
    none = ss.safety(f, kicks=0.1, distribution="uniform", n_runs=10, within=50).escape
    assert none.mean.value == math.inf  # |x| stays below 0.2
    assert none.escaped.value == 0.0
    assert none.escaped.error > 0.0


def test_escape_of_henon_agrees_with_plain_iteration():
    f = henon(domain=((-2.5, 2.5), (-2.5, 2.5)))
    listed = ss.attractors(f)
    got = ss.safety(f, found=listed, kicks=0.05, n_runs=300, n_samples=64).escape

    def leaves(x):
        for _ in range(60):
            x = np.stack([1 - 1.4 * x[:, 0] ** 2 + x[:, 1], 0.3 * x[:, 0]], axis=-1)
            x = np.where(np.abs(x).max(axis=1, keepdims=True) > 2.5, np.inf, x)
            x = np.nan_to_num(x, nan=np.inf)
        return ~np.isfinite(x).all(axis=1)

    rng = np.random.default_rng(5)
    x = listed[0].points[rng.integers(len(listed[0].points), size=300)]
    total = 0
    for n in range(1, 1000):
        x = np.stack([1 - 1.4 * x[:, 0] ** 2 + x[:, 1], 0.3 * x[:, 0]], axis=-1)
        x = x + 0.05 * rng.normal(size=x.shape)
        with np.errstate(over="ignore", invalid="ignore"):
            gone = (np.abs(x).max(axis=1) > 2.5) | leaves(x)
        total += n * int(gone.sum())
        x = x[~gone]
        if not len(x):
            break
    error = math.hypot(got.mean.error, total / 300 / math.sqrt(300))
    assert abs(got.mean.value - total / 300) < SIGMA * error


# ------------------------------------------------------------------ models


@pytest.fixture(scope="module")
def coulomb():
    model = ss.examples.coulomb()
    return model, ss.safety(model, n_impulses=12, n_samples=256)


def least_of_a_grid(f, cycle, n):
    """The least displacement among n starts that leads away from a cycle, and the grid's step."""
    ends = f.iterate(np.linspace(*f.domain, n), 300)
    mine = np.abs(ends[:, -1:] - cycle).min(axis=1) < 1e-6
    domain = np.abs(np.subtract.outer(np.array(f.domain), cycle)).min()
    foreign = ends[~mine, 0]
    least = np.abs(foreign[:, None] - cycle).min() if len(foreign) else np.inf
    return min(least, domain), (f.domain[1] - f.domain[0]) / (n - 1)


def test_a_displacement_of_two_blocks_is_the_least_of_a_fine_grid(coulomb):
    model, found = coulomb
    least, gap = least_of_a_grid(ss.event_map(model), found.attractor.orbit.points, 20_001)
    assert abs(found.displacement.size - least) <= gap
    assert found.displacement.reason


@pytest.mark.slow
def test_displacements_of_random_blocks_are_the_least_of_fine_grids():
    """Systems that nobody chose: their cycles, against plain iteration of 2001 starts."""
    rng = np.random.default_rng(27)
    compared = 0
    for _ in range(40):
        alpha, beta = rng.uniform(0.1, 3.0), rng.uniform(0.5, 2.0)
        law, V = ss.Coulomb(mu=rng.uniform(0.05, 0.9)), rng.uniform(0.005, 0.15)
        f = ss.event_map(ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=law))
        listed = ss.attractors(f)
        for k, attractor in enumerate(listed):
            if attractor.kind != "periodic" or attractor.lyapunov.value > -0.1:
                continue  # 300 steps would not settle
            near = ss.safety(f, found=listed, attractor=k, n_impulses=0).displacement
            least, gap = least_of_a_grid(f, attractor.orbit.points, 2001)
            assert near.size - near.error <= least + gap
            assert near.size >= least - gap or near.error > ROUNDING
            compared += 1
    assert compared > 15


def test_the_smallest_impulse_changes_where_the_motion_ends(coulomb):
    """Followed in time from the kicked state, with nothing of the map."""
    model, found = coulomb
    assert len(found.impulses) == 4
    blow = found.impulse
    mine = found.attractor.orbit.points
    ends = []
    for by in (0.999 * blow.by, blow.by + math.copysign(2 * blow.error, blow.by)):
        start = ss.simulate(model, d=blow.point[0], t_end=0.0).final_state
        v = start.v.copy()
        v[blow.block - 1] += by
        phases = ss.simulate(model, start.x, v, t_end=20_000.0, record="events").d
        ends.append(np.abs(phases[-1] - mine).min())
    assert ends[0] < 1e-6 < 1e-3 < ends[1]


def test_no_impulse_is_one_step_of_the_map():
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    for d in (-0.3, 0.1):
        assert f.after_impulse(d, 1, 0.0) == pytest.approx(f(d), rel=1e-12)
    small = f.after_impulse(0.1, 2, 1e-9)  # block 2 rides: it slips, and is at rest again at once
    assert abs(small - f(0.1)) < 1e-6 or abs(small - 0.1) < 1e-6
    assert np.isnan(ss.event_map(model, max_time=5).after_impulse(0.27, 1, 0.0))  # as f(0.27)


# ------------------------------------------------------------------ along a parameter


def test_safety_along_a_parameter_follows_one_attractor():
    found = ss.safety(cubic(1.2, 1.45), "r", [1.2, 1.4, 1.6], n_samples=64)
    fixed = np.sqrt(np.array([0.2, 0.4, 0.6]))
    exact = np.minimum(fixed, np.sqrt([1.2, 1.4, 1.6]) - fixed)
    assert np.allclose(found.table()["displacement"], exact, rtol=1e-9)
    signs = {math.copysign(1.0, item.displacement.point[0]) for item in found}
    assert len(signs) == 1
    assert found.lost == ""


def test_an_attractor_that_disappears_into_the_basin_of_another_one_ends_the_list():
    """The upper fixed point of x - (x^3 - x + c) / 2 is lost where c = 2 / 27^(1/2) = 0.385."""
    f = ss.PiecewiseMap(lambda x, c: x - (x**3 - x + c) / 2, (-1.25, 1.5), parameters={"c": 0.0})
    upper = ss.safety(f, "c", [0.0, 0.2, 0.5], n_samples=64)
    assert upper[0].displacement.point[0] == pytest.approx(1.0, rel=1e-9)
    assert len(upper) == 2
    assert upper.lost == "the attractor is not found again at c = 0.5"
    lower = ss.safety(f, "c", [0.0, 0.2, 0.5], n_samples=64, attractor=1)
    assert len(lower) == 3
    assert lower.lost == ""


def test_an_attractor_that_disappears_ends_the_list():
    f = ss.PiecewiseMap(lambda x, c: x * x + c, (-2.0, 2.0), parameters={"c": 0.0})
    found = ss.safety(f, "c", [0.0, 0.2, 0.3], n_samples=64)  # a fold at 1/4
    assert len(found) == 2
    assert "c = 0.3" in found.lost
    root = np.sqrt(1 - 4 * 0.2)  # from the stable fixed point to the unstable one
    assert found[1].displacement.size == pytest.approx(root, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"attractor": 9}, "attractor = 9"),
        ({"attractor": 9, "parameter": "r", "values": [1.5]}, "attractor = 9"),
        ({"kicks": -1.0}, "kicks = -1.0"),
        ({"kicks": [0.1, 0.1]}, "give one size, or 1"),
        ({"distribution": "flat"}, "distribution"),
        ({"parameter": "r"}, "both a parameter"),
        ({"parameter": "s", "values": [1.0]}, "'s' is not a parameter"),
    ],
)
def test_what_makes_no_sense_is_refused(options, message):
    with pytest.raises(ValueError, match=message):
        ss.safety(cubic(1.4), **options)


@pytest.mark.parametrize("n", [1, 2])
def test_what_was_found_must_be_attractors_of_such_a_map(n):
    line = ss.attractors(cubic(1.4))
    f, wrong = (cubic(1.4), [1, 2]) if n == 1 else (ss.Map(lambda z: z / 2, 2), line)
    with pytest.raises(ValueError, match=r"found = .* is not the result of ss\.attractors"):
        ss.safety(f, found=wrong)


def test_the_quasistatic_limit_has_no_impulses():
    f = ss.quasistatic_map(ss.TwoBlock(alpha=2, beta=1.1, V=0.05, friction=ss.Coulomb(mu=0.3)))
    assert ss.safety(f, n_samples=16).impulses == ()
    with pytest.raises(ValueError, match="moving belt"):
        f.after_impulse(0.1, 1, 0.1)
