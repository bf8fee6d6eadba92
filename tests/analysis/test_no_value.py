"""A map that has no value anywhere: every question about it has an answer."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.interpolation.interpolated import interpolated_map

MODEL = ss.examples.coulomb(damping=5.0)  # both blocks slip for ever
USERS = ss.PiecewiseMap(lambda x, r: np.where(x < r, x, np.nan), (0, 1), parameters={"r": -1.0})


@pytest.fixture(params=[MODEL, USERS, ss.event_map(MODEL).power(2)], ids=["model", "user's", "f^2"])
def nowhere(request):
    return request.param


def test_its_table_is_one_gap(nowhere):
    table = ss.branches(nowhere)
    assert len(table) == len(table.laps) == 0
    np.testing.assert_array_equal(table.gaps, [table.f.domain])
    assert len(ss.breakpoints(nowhere)) == 0
    orbits = ss.periodic_orbits(nowhere, 3, infinitely_unstable=True)
    assert len(orbits) == 0
    assert orbits.complete


def test_it_is_interpolated_by_no_value(nowhere):
    fast = interpolated_map(ss.branches(nowhere))
    values = fast.evaluate([0.1, 0.2])
    assert np.isnan(values.value).all()
    assert (values.label == 0).all()
    np.testing.assert_array_equal(fast.iterate(0.1, 2), [0.1, np.nan, np.nan])


@pytest.mark.parametrize("interpolate", [True, False])
def test_it_attracts_nothing(nowhere, interpolate):
    found = ss.attractors(nowhere, interpolate=interpolate)
    assert len(found) == 0
    assert found.left == 1.0


def test_all_of_its_domain_leaves(nowhere):
    found = ss.basins(nowhere)
    assert found.index.tolist() == [-2]
    assert found.edges.tolist() == list(ss.branches(nowhere).f.domain)
    assert found.left == 1.0
    assert "no attractor" in repr(found)


@pytest.mark.parametrize(
    ("f", "name", "ends"), [(MODEL, "V", (0.03, 0.04)), (USERS, "r", (-2, -1))]
)
def test_nothing_happens_along_a_parameter(f, name, ends):
    diagram = ss.bifurcation_diagram(f, name, np.linspace(*ends, 4), max_period=2, n_lists=6)
    assert diagram.orbits == ()
    assert len(ss.bifurcations(f, name, ends, max_period=2, n_lists=6)) == 0


def test_branches_come_and_go_along_a_parameter_down_to_none():
    model = ss.examples.coulomb(damping=2.0)
    few = [len(ss.branches(model.replace(V=V))) for V in (0.005, 0.03, 0.1)]
    assert few == [4, 1, 0]
    diagram = ss.bifurcation_diagram(
        model, "V", np.linspace(0.005, 0.1, 4), max_period=2, n_lists=6
    )
    assert diagram.unresolved == ()


def test_where_a_map_is_infinite_it_has_no_value():
    line = ss.PiecewiseMap(lambda x: 1 / x, (0, 1))
    assert np.isnan([line(0.0), line.evaluate(0.0).value, line.iterate(0.0, 1)[1]]).all()
    plane = ss.Map(lambda z: z / z[..., :1], 2)
    assert np.isnan([plane([0.0, 0.0]), plane([0.0, 1.0]), plane.evaluate([0.0, 1.0]).value]).all()
