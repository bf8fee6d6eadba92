"""Orbits of the event maps of N blocks: two blocks as on the line, three against iteration."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.maps.protocol import PointValues

COULOMB = ss.examples.coulomb()
CHAIN = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.0366, friction=ss.Coulomb(mu=0.22))


@pytest.fixture(scope="module")
def orbits():
    return ss.periodic_orbits(CHAIN, 3, n_starts=256)


class OnTheLine:
    """The map of two blocks as one of R^1."""

    dimension = 1

    def __init__(self, model):
        self.model, self.f = model, ss.event_map(model)
        self.parameters = model.parameters

    def contains(self, x):
        return self.model.contains(x[..., 0])

    def spread(self, n):
        return self.model.spread_domain(n)[:, None]

    def evaluate(self, x):
        found = self.f.evaluate(x[..., 0])
        value, derivative = found.value[..., None], found.derivative[..., None, None]
        return PointValues(value, derivative, found.label, found.status, found.margin)

    def itinerary(self, x):
        return self.f.itinerary(x[..., 0])

    def replace(self, **changes):
        return OnTheLine(self.model.replace(**changes))

    def parameter_derivative(self, x, name):
        return np.asarray(self.f.parameter_derivative(x[..., 0], name))[..., None]


def test_two_blocks_have_the_orbits_that_the_complete_list_on_the_line_has():
    """S1, U1, U2 and S4 of the paper."""
    found = ss.periodic_orbits(OnTheLine(COULOMB.chain), 4, n_starts=128)
    known = ss.periodic_orbits(COULOMB, 4)
    assert [orbit.period for orbit in found] == [orbit.period for orbit in known] == [1, 1, 1, 4]
    for one, other in zip(found, known, strict=True):
        np.testing.assert_allclose(one.points[:, 0], other.points, rtol=0, atol=1e-13)
        assert one.multipliers[0].real == pytest.approx(other.multiplier, rel=1e-10)
        assert one.stable == other.stable
        assert one.itinerary == other.itinerary


def test_the_border_collision_of_s4_is_that_on_the_line():
    (s4,) = ss.periodic_orbits(OnTheLine(COULOMB.chain), period=4, n_starts=32)
    branch = ss.follow(s4, "V", (0.0366, 0.0372))
    line = ss.follow(ss.periodic_orbits(COULOMB, period=4)[0], "V", (0.0366, 0.0372))
    end = branch.ends[1]
    assert (end.reason, end.kind) == ("breakpoint", "jump")
    assert end.value == pytest.approx(line.ends[1].value, abs=1e-10)
    assert abs(end.value - line.ends[1].value) <= end.error + 1e-14


def test_orbits_of_three_blocks_return_and_their_multipliers_are_those_of_differences(orbits):
    f = ss.event_map(CHAIN)
    assert len(orbits) >= 3
    h = 1e-7
    for orbit in orbits:
        p, first = orbit.period, orbit.points[0]
        np.testing.assert_allclose(
            f.iterate(orbit.points, 1)[:, 1], np.roll(orbit.points, -1, axis=0), rtol=0, atol=1e-13
        )
        sides = [f.iterate(first + s * h * np.eye(2), p)[:, -1] for s in (1, -1)]
        jacobian = ((sides[0] - sides[1]) / (2 * h)).T
        size = np.abs(jacobian).max()
        expected = np.linalg.eigvals(jacobian)
        for multiplier in orbit.multipliers:
            assert np.abs(expected - multiplier).min() < 1e-5 * size
        assert orbit.itinerary == tuple(f.itinerary(orbit.points))


def test_a_change_in_the_order_of_two_events_is_passed(orbits):
    """The fixed point of three blocks, at V = 0.04297: its map is smooth there."""
    branch = ss.follow(orbits.of_period(1)[0], "V", (0.036, 0.046))
    assert [end.reason for end in branch.ends] == ["end of range"] * 2
    assert len(set(branch.data["labels"].ravel().tolist())) == 2
    f = ss.event_map(CHAIN.replace(V=0.045))
    orbit = branch.at(V=0.045)
    np.testing.assert_allclose(f(orbit.points), orbit.points, rtol=0, atol=1e-13)


def test_lists_and_branches_are_saved_with_their_model(orbits, tmp_path):
    branch = ss.follow(orbits.of_period(2)[0], "V", (0.036, 0.037))
    branch.save(tmp_path / "branch")
    again = ss.load(tmp_path / "branch")
    assert again.system == ss.event_map(CHAIN)
    assert np.array_equal(again.points, branch.points)
    assert again.at(V=0.0365).points == pytest.approx(branch.at(V=0.0365).points, abs=1e-14)


def test_options_of_the_other_kind_of_map_are_refused():
    with pytest.raises(ValueError, match="infinitely_unstable is for maps of a line"):
        ss.periodic_orbits(CHAIN, infinitely_unstable=True)
    with pytest.raises(ValueError, match="n_starts is for maps of R"):
        ss.periodic_orbits(COULOMB, n_starts=3)
    orbit = ss.periodic_orbits(CHAIN, 1, n_starts=32)[0]
    with pytest.raises(ValueError, match="window is for orbits of maps of a line"):
        ss.follow(orbit, "V", (0.03, 0.04), window=(-0.5, 0.5))
