"""A chain of three blocks: attractors, basins, spectra, bifurcations, against plain iteration."""

import numpy as np
import pytest
from tests.sizes import slow

import stickslip as ss
from stickslip.analysis.orbits.orbits_nd import distinct_orbits

COULOMB = ss.Coulomb(mu=0.59)
CHAIN = ss.Chain(static=(0.753, 1.374, 1.078), alpha=1.616, V=0.12, friction=COULOMB)
CHAOTIC = ss.Chain(
    static=(0.902, 0.768, 1.219), alpha=1.406, V=0.1331, friction=ss.Coulomb(mu=0.13)
)
SLOW = ss.Chain(static=(0.968, 0.986, 0.732), alpha=0.383, V=0.1, friction=ss.Coulomb(mu=0.7))
SIGMA = 4.0


@pytest.fixture(scope="module")
def found():
    return ss.attractors(CHAIN)


def ends(f, found, x, n):
    """Which attractor each point is at after n steps, by its distance; -1 for none."""
    here = f.iterate(x, n)[:, -1]
    away = [np.abs(here[:, None] - each.points).max(axis=2).min(axis=1) for each in found]
    return np.where(np.min(away, axis=0) < 1e-4, np.argmin(away, axis=0), -1)


def test_two_fixed_points_attract_and_attract_by_their_multipliers(found):
    f = ss.event_map(CHAIN)
    assert [(each.kind, each.period) for each in found] == [("periodic", 1)] * 2
    for each in found:
        np.testing.assert_allclose(f(each.points), each.points, rtol=0, atol=1e-13)
        near = each.points[0] + 1e-6 * np.array([0.6, -0.8])
        off = np.linalg.norm(f.iterate(near, 12) - each.points, axis=1)
        slope = np.polyfit(np.arange(12), np.log(off[1:]), 1)[0]
        # Complex multipliers turn: the distance oscillates about its decay.
        assert slope == pytest.approx(each.lyapunov.value, rel=0, abs=0.1)


def test_fates_of_starts_are_those_of_plain_iteration(found):
    f = ss.event_map(CHAIN)
    basins = ss.basins(f, found, n_samples=512)
    assert basins.undecided == 0.0
    assert basins.mistaken == 0
    np.testing.assert_array_equal(basins.index, ends(f, found, f.spread(512), 120))


def test_starts_whose_motions_are_given_up_are_undecided(found):
    basins = ss.basins(ss.event_map(CHAIN, max_events=2), found, n_samples=16)
    assert (basins.left, basins.undecided) == (0.0, 1.0)


@pytest.mark.slow
def test_shares_agree_with_those_of_100_000_starts(found):
    """Drawn at random, not spread evenly as the answer's own."""
    f, n = ss.event_map(CHAIN), 100_000
    basins = ss.basins(f, found, n_samples=4096)
    fate = ends(f, found, CHAIN.sample_domain(n, np.random.default_rng(0)), 120)
    assert (fate >= 0).all()
    for k in range(2):
        share, error = basins.share(k)
        p = (fate == k).mean()
        assert abs(share - p) < SIGMA * np.hypot(error, np.sqrt(p * (1 - p) / n))


@pytest.mark.slow
def test_a_cycle_with_its_border_beside_it_takes_no_foreign_starts():
    """Ten steps beside a cycle of period 4 mistook one start in eleven."""
    f = ss.event_map(SLOW)
    found = ss.attractors(f)
    basins = ss.basins(f, found, n_samples=256)
    assert basins.mistaken == 0
    assert basins.hits > 10
    np.testing.assert_array_equal(basins.index, ends(f, found, f.spread(256), 1500))


def test_exponents_are_those_of_plain_iteration_of_differences():
    """Slopes by differences of values, orthogonalised with NumPy's QR."""
    f, n, h = ss.event_map(CHAOTIC), 4000, 1e-7
    spectrum = ss.lyapunov_spectrum(f, [0.1, 0.05], 20_000)
    path = f.iterate([0.05, 0.1], 200 + n)[200:-1]
    sides = [f(path[:, None] + sign * h * np.eye(2)) for sign in (1, -1)]
    slopes = np.swapaxes(sides[0] - sides[1], 1, 2) / (2 * h)
    frame, growth = np.eye(2), []
    for slope in slopes:
        frame, upper = np.linalg.qr(slope @ frame)
        growth.append(np.log(np.abs(np.diag(upper))))
    growth = np.array(growth)
    batches = growth.reshape(40, -1, 2).mean(axis=1)
    error = batches.std(axis=0, ddof=1) / np.sqrt(40)
    assert (np.abs(growth.mean(axis=0) - spectrum.values) < SIGMA * (error + spectrum.errors)).all()
    assert spectrum.values[0] > 0.3


# ------------------------------------------------------------------ along a parameter


FEW = ((0.1295, 0.13), {"max_period": 1, "n_lists": 1, "n_starts": 16})
ALL = ((0.116, 0.13), {"max_period": 2, "n_lists": 2, "n_starts": 32})


@pytest.fixture(scope="module", params=[FEW, *slow((ALL,))], ids=["few", "all"])
def events(request):
    """A border collision; flips, a fold and border collisions of periods 1 and 2."""
    ends, how = request.param
    return ss.bifurcations(CHAIN, "V", ends, **how)


@pytest.mark.parametrize("events", slow((ALL,)), indirect=True, ids=["all"])
def test_everything_is_there(events):
    """Two orbits begin and end with others at jumps, where lists of few starts do not show them."""
    assert {"fold", "flip", "border_collision"} == {item.kind for item in events}
    assert len(events) == 9
    coverage = events.coverage
    assert (coverage.n_lists, coverage.n_starts, coverage.new) == (2, 32, 0)
    assert 0 < coverage.again <= coverage.known


def test_everything_is_located(events):
    found = events
    assert found.unresolved == found.outside == ()
    assert {item.quality for item in found} == {"located"}
    for item in found:
        assert item.error < 1e-11
        if item.kind == "border_collision":
            assert item.mechanism
        else:
            critical = {"fold": 1.0, "flip": -1.0}[item.kind]
            assert np.abs(item.multipliers - critical).min() < 1e-7
            f = ss.event_map(CHAIN.replace(V=item.value))
            np.testing.assert_allclose(
                f(item.points), np.roll(item.points, -1, axis=0), rtol=0, atol=1e-12
            )


@pytest.mark.parametrize("events", slow((ALL,)), indirect=True, ids=["all"])
def test_orbits_of_a_diagram_begin_and_end_in_what_is_located(events):
    diagram = ss.bifurcation_diagram(CHAIN, "V", (0.116, 0.13, 29), max_period=2, n_lists=2)
    values = np.array([item.value for item in events])
    for curve in diagram.orbits:
        for end in curve.ends:
            if end.reason != "end of range":
                assert np.abs(values - end.value).min() < 1e-11
    assert len(diagram.orbits) >= 8
    periodic = diagram.attractors.kind == "periodic"
    assert periodic.all()
    assert np.bincount(diagram.attractors.where, minlength=29).min() >= 2


def test_a_grazing_is_where_the_margin_of_the_orbit_vanishes(events):
    """From the side of the slip the margin is linear, from that of the stick its square."""
    found = [item for item in events if "grazes" in item.mechanism]
    assert [item.block for item in found] in ([3, 2], [2])
    for item in found:
        power = {3: 1, 2: 2}[item.block]
        (orbit,) = item.orbits_before + item.orbits_after
        way, off = (1.0 if item.orbits_after else -1.0), 1e-8
        margins = []
        for k in (1, 2):
            f = ss.event_map(CHAIN.replace(V=item.value + k * way * off))
            (near,) = distinct_orbits(f, orbit.points[None])
            margins.append(f.evaluate(near.points).margin.min() ** power)
        one, two = margins
        assert abs(2 * one - two) / (two - one) * off < 1e-11  # where the straight line vanishes
    borders = [curve.data["margin"] for curve in events.curves]
    assert all((margin >= 0.0).all() and margin.max() > 1e-3 for margin in borders)


def test_a_law_that_starts_at_the_static_limit_has_borders_that_change_nothing():
    """An orbit passes changes of its modes: they are told, and are no bifurcations."""
    law = CHAIN.replace(friction=ss.PoppStelter(gamma=3.0))
    found = ss.bifurcations(law, "V", (0.12, 0.13), max_period=1, n_lists=1, n_starts=16)
    passed = [e for curve in found.curves for e in curve.bifurcations if e.kind == "border"]
    assert passed
    assert {event.outcome for event in passed} == {"persists"}
    assert all("rest" in event.what or "coincide" in event.what for event in passed)
    assert not [item for item in found if item.kind == "border"]
