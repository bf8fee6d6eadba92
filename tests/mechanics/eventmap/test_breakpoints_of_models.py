"""Branches and orbits of the paper's two event maps (section 4), whole domain."""

import numpy as np
import pytest

from stickslip import examples
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap

PRINTED = 1e-3  # the paper prints three digits

pytestmark = pytest.mark.paper


@pytest.fixture(scope="module")
def coulomb():
    return EventMap(examples.coulomb(V=0.0366))


def test_shape_of_the_coulomb_map(coulomb):
    table = branch_table(coulomb)
    found = breakpoints(coulomb)
    assert len(table) == 9
    assert [len(found.of_kind(kind)) for kind in ("jump", "smooth", "corner", "edge")] == [
        6, 2, 0, 0,
    ]  # fmt: skip
    assert len(table.pieces) == 12
    assert not table.unresolved
    assert not len(table.gaps)


def test_labels_of_the_coulomb_map_agree_with_a_dense_sample(coulomb):
    table = branch_table(coulomb)
    x = np.linspace(*coulomb.domain, 20_011)
    # On a tie of events the itinerary may be one of its own.
    breaks = np.array([b.d for b in table.breakpoints])
    x = x[np.abs(x[:, None] - breaks).min(axis=1) > 1e-12]
    assert np.array_equal(table.labels_at(x), coulomb.evaluate(x).label)


def test_orbits_of_the_coulomb_map(coulomb):
    orbits = periodic_orbits(coulomb, 8)
    assert [(o.period, o.stable) for o in orbits] == [(1, True), (1, False), (1, False), (4, True)]
    assert not orbits.near_folds
    assert not orbits.unresolved
    for orbit in orbits:
        assert coulomb(orbit.points) == pytest.approx(np.roll(orbit.points, -1), abs=1e-14)
        assert np.prod(coulomb.derivative(orbit.points)) == pytest.approx(orbit.multiplier)


def test_infinitely_unstable_orbit_of_figure_6(coulomb):
    orbits = periodic_orbits(coulomb, period=4, infinitely_unstable=True)
    printed = np.array([-0.466, 0.279, -0.254, 0.492])
    (u4,) = [
        o for o in orbits if o.infinitely_unstable and np.abs(o.points - printed).max() < PRINTED
    ]
    assert u4.jump.rising
    assert 0 < u4.jump.share < 1
    # From y on the map itself leads back to the jump.
    y = u4.jump.y
    assert coulomb.iterate(y, 3)[-1] == pytest.approx(u4.jump.d, abs=1e-14)
    jump = next(b for b in breakpoints(coulomb) if b.d == u4.jump.d)
    assert min(jump.left, jump.right) < y < max(jump.left, jump.right)


@pytest.mark.slow
def test_shape_and_orbits_of_the_map_of_law_9():
    f = EventMap(examples.law9(alpha=1.208))
    table = branch_table(f)
    found = breakpoints(f)
    assert len(table) == 18
    assert [len(found.of_kind(kind)) for kind in ("jump", "smooth", "corner", "edge")] == [
        6, 8, 2, 2,
    ]  # fmt: skip
    # The cusp of f that the paper gives.
    assert any(abs(b.d - 0.3815) < 1e-4 for b in found.of_kind("corner"))
    orbits = periodic_orbits(f, 2)
    assert [o.points[0] for o in orbits.of_period(1)] == pytest.approx(
        [-0.2426, 0.0927, 0.3833, 0.5462], abs=1e-4
    )
    assert not orbits.unresolved
