"""Two blocks that are not equal have a map of the line: everything that such maps have."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from tests.mechanics.eventmap.unequal import pair

import stickslip as ss
from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.analysis.orbits.orbit import OrbitList
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.plot.locus import stick_locus, trajectory_in_plane

MODEL = pair(ss.Coulomb(mu=0.22), 0.0366, damped=True)
CHAOS = pair(ss.PoppStelter(gamma=3.0), 0.1)
SPAN = (0.0341, 0.0343)  # of V: a border collision in between


@pytest.fixture(scope="module")
def f() -> EventMap:
    return ss.event_map(MODEL)


@pytest.fixture(scope="module")
def orbits(f: EventMap) -> OrbitList:
    return ss.periodic_orbits(f, 3)


@pytest.fixture(scope="module")
def collision() -> Bifurcation:
    (found,) = ss.bifurcations(MODEL, "V", SPAN, max_period=1, n_lists=6)
    return found


def test_branches_are_the_intervals_of_one_itinerary(f: EventMap) -> None:
    table = ss.branches(f)
    assert len(table.gaps) == 0
    for branch in table:
        d = np.linspace(branch.left, branch.right, 12)[1:-1]
        assert len(set(np.atleast_1d(f.itinerary(d)).tolist())) == 1
    assert (table[0].left, table[-1].right) == f.domain
    for item in ss.breakpoints(f):
        left, right = f(item.d - 1e-12), f(item.d + 1e-12)
        np.testing.assert_allclose([left, right], [item.left, item.right], rtol=1e-7, atol=1e-5)
        assert item.mechanism
        beside = f.itinerary([item.d - 1e-9, item.d + 1e-9])
        assert beside[0] != beside[1]


def test_orbits_return_and_are_saved_with_their_model(f, orbits, tmp_path) -> None:
    assert len(orbits) >= 5
    for orbit in orbits:
        np.testing.assert_allclose(
            f(orbit.points), np.roll(orbit.points, -1), rtol=1e-7, atol=1e-13
        )
        slopes = f.derivative(orbit.points)
        np.testing.assert_allclose(orbit.multiplier, slopes.prod(), rtol=1e-9)
        assert orbit.itinerary == tuple(f.itinerary(orbit.points))
    orbits.save(tmp_path / "orbits.json")
    again = ss.load(tmp_path / "orbits.json")
    assert again == orbits
    assert again[0].system == f
    (x,) = f.preimages(float(orbits[0].points[0]))[:1]
    np.testing.assert_allclose(f(x), orbits[0].points[0], rtol=1e-7, atol=1e-12)
    np.testing.assert_array_equal(f.power(2)(0.1), f(f(0.1)))


def test_attractors_are_where_orbits_go(f: EventMap) -> None:
    found = ss.attractors(f)
    ends = f.iterate(MODEL.sample_domain(20, 1), 3000)[:, -1]
    near = [a.contains(ends, 1e-6) for a in found]
    assert np.any(near, axis=0).mean() > 0.9
    chaotic = ss.attractors(CHAOS)
    assert chaotic[0].kind == "chaotic"
    exponent = ss.lyapunov_exponent(CHAOS, 0.1, 20_000)
    assert abs(float(exponent) - chaotic[0].lyapunov.value) < 6 * (
        exponent.error + chaotic[0].lyapunov.error
    )
    density = ss.invariant_density(CHAOS, chaotic[0])
    orbit = ss.event_map(CHAOS).iterate(0.1, 20_000)[1000:]
    share = np.mean((orbit > 0.0) & (orbit < 0.28))
    assert density.plot() is not None
    covered = np.minimum(density.right, 0.28) - np.maximum(density.left, 0.0)
    weight = float((np.maximum(covered, 0.0) * density.density).sum())
    assert share == pytest.approx(weight, abs=0.02)
    plt.close("all")


def test_basins_say_where_starts_go() -> None:
    model = MODEL.replace(V=0.2)
    f = ss.event_map(model)
    found = ss.attractors(f)
    basins = ss.basins(f, found)
    d = model.sample_domain(50, 2)
    place = np.searchsorted(basins.edges, d) - 1
    ends = f.iterate(d, 2000)[:, -1]
    for k, attractor in enumerate(found):
        mine = basins.index[place] == k
        assert attractor.contains(ends[mine], 1e-6).all()
    assert (basins.index[place] >= 0).mean() > 0.8


def test_a_border_collision_and_its_curve(collision, f) -> None:
    assert collision.kind == "border_collision"
    assert collision.error < 1e-12
    assert "grazes its stick interval" in collision.mechanism
    for V, count in zip(
        SPAN, (len(collision.orbits_before), len(collision.orbits_after)), strict=True
    ):
        assert len(ss.periodic_orbits(f.replace(V=V), 1)) >= count
    curve = ss.follow(collision, "mass_2", (1.99, 2.01), solve_for="V")
    V = curve.at(mass_2=2.005).value
    (found,) = ss.bifurcations(
        MODEL.replace(mass_2=2.005), "V", (V - 1e-4, V + 1e-4), max_period=1, n_lists=6
    )
    assert found.value == pytest.approx(V, abs=1e-10)


def test_orbits_are_followed_in_any_parameter(f, orbits) -> None:
    orbit = orbits[0]
    for name, width in (("mass_1", 0.02), ("stiffness_1_2", 0.02), ("damping_2_2", 0.01)):
        value = MODEL.parameters[name]
        curve = ss.follow(orbit, name, (value - width, value + width))
        there = curve.at(**{name: value + 0.7 * width})
        np.testing.assert_allclose(
            f.replace(**{name: value + 0.7 * width})(there.points), np.roll(there.points, -1),
            rtol=1e-7,
            atol=1e-12,
        )  # fmt: skip


def test_a_diagram_shows_the_orbits(f) -> None:
    diagram = ss.bifurcation_diagram(MODEL, "V", (0.0360, 0.0372, 3), max_period=1)
    assert diagram.plot() is not None
    plt.close("all")


def test_pictures(f, orbits) -> None:
    for result in (ss.branches(f), ss.breakpoints(f), orbits, f.evaluate([0.1, 0.2])):
        assert result.plot() is not None
    assert ss.plot.event_map(f) is not None
    assert ss.plot.cobweb(f, 0.1, steps=5) is not None
    stick_locus(MODEL)
    trajectory_in_plane(ss.simulate(MODEL, d=0.1, t_end=30))
    plt.close("all")


def test_a_motion_passes_the_points_of_the_map(f) -> None:
    motion = ss.simulate(MODEL, d=0.1, t_end=200)
    assert motion.d.ndim == 1
    assert len(motion.d) > 4
    np.testing.assert_allclose(motion.d, f.iterate(0.1, len(motion.d) - 1), rtol=1e-7, atol=1e-12)
    with pytest.raises(ValueError, match="d = "):
        ss.simulate(MODEL, d=[0.1, 0.2], t_end=1)


def test_a_sweep_is_of_the_line(f, tmp_path) -> None:
    pytest.importorskip("zarr")
    run = {"transient": 100, "n": 64, "max_period": 8}
    wanted = [ss.observables.Attractor(**run), ss.observables.OrbitPoints(**run, count=3)]
    axes = {"V": [0.0366, 0.2], "mass_2": [2.0]}
    found = ss.sweep(MODEL, axes, wanted, store=tmp_path / "x", d=0.1, threads=1)
    for V in axes["V"]:
        orbit = f.replace(V=V).iterate(0.1, 164)
        np.testing.assert_array_equal(found.sel(V=V).orbit.values.ravel(), orbit[-3:])
    quasi = ss.quasistatic_map(ss.examples.coulomb())
    found = ss.sweep(quasi, {"beta": [1.3]}, wanted, store=tmp_path / "q", d=0.5, threads=1)
    np.testing.assert_array_equal(found.orbit.values.ravel(), quasi.iterate(0.5, 164)[-3:])
