"""Diagrams of maps of R^n against closed forms."""

import numpy as np
import pytest
from tests.analysis.known_maps_nd import henon, kinked

from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.analysis.maps.map import Map
from stickslip.results.files import load, save

EXACT = 1e-11


@pytest.fixture(scope="module")
def diagram():
    return bifurcation_diagram(henon(0.1), "a", (0.2, 1.2, 21), max_period=2, n_lists=3)


def test_orbits_are_solved_for_at_every_value(diagram):
    stable, saddle = sorted(diagram.of_period(1), key=lambda o: -np.nanmax(o.points))
    a = diagram.values
    root = np.sqrt(0.49 + 4 * a)
    np.testing.assert_allclose(stable.points[:, 0, 0], (-0.7 + root) / (2 * a), rtol=0, atol=EXACT)
    np.testing.assert_allclose(saddle.points[:, 0, 0], (-0.7 - root) / (2 * a), rtol=0, atol=EXACT)
    assert (stable.stable == (a < 3 * 0.49 / 4)).all()
    assert not saddle.stable.any()


def test_an_orbit_begins_where_another_flips(diagram):
    (double,) = diagram.of_period(2)
    begin, end = double.ends
    assert (begin.reason, end.reason) == ("flip", "end of range")
    assert begin.value == pytest.approx(3 * 0.49 / 4, abs=EXACT)
    assert (double.exists == (diagram.values > begin.value)).all()
    assert np.nansum(np.diff(double.points[double.exists], axis=1) ** 2) > 0


def test_attractors_are_cycles_and_then_chaos(diagram):
    table = diagram.attractors
    first = table.where == 0
    assert table.kind[first].tolist() == ["periodic"]
    assert table.points.shape[2] == 2
    assert (table.kind[table.where == 20] == "chaotic").all()
    assert (table.lyapunov[table.where == 20] > 0).all()


def test_a_border_collision_ends_orbits():
    found = bifurcation_diagram(
        kinked(-0.1), "mu", (-0.3, 0.3, 7), max_period=1, n_lists=2, attractors=False
    )
    reasons = {end.reason for orbit in found.of_period(1) for end in orbit.ends}
    assert reasons == {"border_collision", "end of range"}
    # Even if none are looked for, the fixed point of the left piece is an attractor.
    assert found.values[found.attractors.where].tolist() == found.values[found.values < 0].tolist()


@pytest.mark.parametrize("range_", [(0.32, 0.38), (0.45, 0.55)])
def test_a_closed_curve_is_two_orbits_that_meet_in_two_folds(range_):
    """A tongue of Arnold's map of the circle: the points drift round as it is crossed."""

    def func(x, om):
        return x + om - 0.9 / (2 * np.pi) * np.sin(2 * np.pi * x)

    f = Map(func, 1, parameters={"om": 0.3}, periodic=[1.0])
    found = bifurcation_diagram(f, "om", (*range_, 21), max_period=3, n_lists=4, attractors=False)
    assert [[end.reason for end in orbit.ends] for orbit in found.orbits] == [["fold"] * 2] * 2
    one, other = ([end.value for end in orbit.ends] for orbit in found.orbits)
    np.testing.assert_allclose(one, other, rtol=EXACT)
    assert not found.unresolved
    assert sorted(orbit.stable.sum() > 0 for orbit in found.orbits) == [False, True]
    for orbit in found.orbits:
        within = (found.values > one[0]) & (found.values < one[1])
        assert (orbit.exists == within).all()
        for om, points in zip(found.values[within], orbit.points[within], strict=True):
            off = func(points, om) - np.roll(points, -1, axis=0)
            np.testing.assert_allclose(off, np.round(off), rtol=0, atol=EXACT)


def test_a_diagram_is_a_table_and_a_file(diagram, tmp_path):
    table = diagram.table()
    assert {"d_1", "d_2"} < set(table)
    assert np.isrealobj(np.concatenate([table["multiplier"], table["multiplier_imag"]]))
    first = (table["what"] == "orbit") & (table["point"] == 1)
    parts = table["multiplier"][first] + 1j * table["multiplier_imag"][first]
    known = np.concatenate([orbit.multipliers[orbit.exists] for orbit in diagram.orbits])
    assert (np.sort_complex(parts) == np.sort_complex(known)).all()
    save(diagram, tmp_path / "diagram")
    assert load(tmp_path / "diagram") == diagram
    assert diagram.overview()["begins"].tolist().count("flip") == 1


def test_netcdf_holds_both_parts_of_multipliers(diagram, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is an extra")
    diagram.save(tmp_path / "diagram.nc")
    data = xarray.load_dataset(tmp_path / "diagram.nc")
    multipliers = np.array([orbit.multipliers for orbit in diagram.orbits])
    np.testing.assert_array_equal(data.multiplier_real + 1j * data.multiplier_imag, multipliers)


def test_points_are_foretold_in_the_root_up_to_the_flip():
    a = 3 * 0.49 / 4 + np.geomspace(1e-6, 0.1, 9)
    found = bifurcation_diagram(henon(0.1), "a", a, max_period=2, n_lists=2, attractors=False)
    (double,) = found.of_period(2)
    assert double.exists.all()
    assert found.unresolved == ()
    # x + y is (1 - b) / a on the cycle of period two.
    sums = double.points[:, :, 0].sum(axis=1)
    np.testing.assert_allclose(sums, 0.7 / a, rtol=0, atol=1e-9)


def test_interrupted_diagrams_say_where_they_end():
    def interrupt(done):
        if done > 0.63:
            raise KeyboardInterrupt

    found = bifurcation_diagram(
        henon(0.1), "a", (0.2, 0.3, 130), max_period=1, n_lists=2, progress=interrupt, partial=True
    )
    assert found.unresolved == ("interrupted: 65 of 130 values",)
    assert len(found.values) == 65


def test_windows_are_for_lines():
    with pytest.raises(ValueError, match="window is for maps of a line"):
        bifurcation_diagram(henon(), "a", (0.2, 1.2, 3), window=(0.0, 1.0))
