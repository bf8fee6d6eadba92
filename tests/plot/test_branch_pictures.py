"""Branches of orbits as pictures: heavy up to the bifurcation, thin from there."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.analysis import plane_maps

import stickslip as ss
from stickslip.plot.bifurcations import (
    STABLE,
    UNSTABLE,
    coordinate_label,
    draw_orbit_curve,
    draw_stretches,
)
from stickslip.plot.style import new_figure


def test_an_orbit_is_heavy_up_to_its_flip_and_thin_from_there():
    ax = new_figure().add_subplot()
    values = np.array([0.0, 1.0, 3.0, 4.0])
    multipliers = np.array([-0.5, -0.8, -1.0, -1.5])
    draw_stretches(ax, values, values[:, None], multipliers)
    shown = {line.get_linewidth(): np.isfinite(line.get_ydata()) for line in ax.lines}
    assert shown[STABLE["lw"]].tolist() == [True, True, True, False]
    assert shown[UNSTABLE["lw"]].tolist() == [False, False, True, True]


def test_without_the_point_itself_the_thin_line_reaches_to_the_heavy_one():
    ax = new_figure().add_subplot()
    values = np.array([0.0, 1.0, 2.0])
    draw_stretches(ax, values, values[:, None], np.array([0.5, 0.9, 1.1]))
    shown = {line.get_linewidth(): np.isfinite(line.get_ydata()) for line in ax.lines}
    assert shown[STABLE["lw"]].tolist() == [True, True, False]
    assert shown[UNSTABLE["lw"]].tolist() == [False, True, True]


def test_what_is_not_proven_is_dashed():
    values = np.array([0.0, 1.0, 2.0, 3.0])
    curve = SimpleNamespace(
        parameter="a",
        values=values,
        points=np.array([[0.5, -1.0], [0.5, -1.0], [0.5, -1.01], [0.6, -1.02]]),
        multipliers=np.full(4, 0.5),
        bifurcations=(),
    )
    nodes = [["0.9", "-1.0"], ["2.0", "-1.01"], ["3.0", "-1.03"]]
    document = {"parameter": "a", "nodes": nodes, "radii": ["1e-02", "1e-03"]}
    ax = new_figure().add_subplot()
    draw_orbit_curve(curve, ax, proven=SimpleNamespace(document=document))
    shown = {line.get_linestyle(): np.isfinite(line.get_ydata()).tolist() for line in ax.lines}
    assert shown == {"-": [False, True, True, False], "--": [True, True, True, True]}
    with pytest.raises(ValueError, match="no certificate of a branch"):
        draw_orbit_curve(curve, ax, proven=SimpleNamespace(document={"parameter": "b"}))


@pytest.mark.parametrize(
    ("result", "k", "label"),
    [
        (SimpleNamespace(system=SimpleNamespace(parameters={"V": 0.1})), None, "$d$"),
        (SimpleNamespace(system=SimpleNamespace(parameters={"V": 0.1})), 1, "$d_2$"),
        (SimpleNamespace(attractors=SimpleNamespace(system=plane_maps.henon())), 0, "$x_1$"),
        (SimpleNamespace(parameter="a", parameters={"a": 1.4}), 1, "$x_2$"),
        (SimpleNamespace(system=SimpleNamespace(coordinates=("phase", "w_1"))), 1, "w_1"),
        ([], 0, "$x_1$"),
    ],
)
def test_coordinates_have_the_maps_own_names(result, k, label):
    assert coordinate_label(result, k) == label


@pytest.mark.parametrize("of_model", [False, True])
def test_pictures_of_a_line_have_its_coordinate(of_model):
    """A map of one's own has an x, an event map a d."""
    tent = ss.PiecewiseMap(["1.9*x", "1.9*(1 - x)"], (0, 1), breakpoints=[0.5])
    f = ss.event_map(ss.examples.coulomb()) if of_model else tent
    found, name = ss.attractors(f), "d" if of_model else "x"
    density = ss.invariant_density(tent, ss.attractors(tent)[0])
    strips = [found, found[0], ss.basins(f), *([] if of_model else [density])]
    orbits, branches = ss.periodic_orbits(f), ss.branches(f)
    for result in strips:
        assert result.plot(new_figure().add_subplot()).get_xlabel() == f"${name}$"
    for result in (orbits.plot(), orbits[0].plot(), branches.plot(), branches[0].plot()):
        assert result.get_xlabel() == f"${name}_{{n}}$"
        assert result.get_ylabel() == f"${name}_{{n+1}}$"


def test_a_plane_of_basins_tells_shares():
    basins = ss.basins(plane_maps.henon(), grid=[(-2, 2, 40), (-2, 2, 40)])
    ax = basins.plot(new_figure().add_subplot())
    told = [text.get_text() for text in ax.get_legend().get_texts()]
    assert told == [
        f"0: chaotic, {100 * basins.share(0).value:.3g} %",
        f"leaves, {100 * basins.share(-2).value:.3g} %",
    ]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x_1$", "$x_2$")


def test_each_point_of_a_grid_has_a_cell_about_it():
    f = ss.Map(lambda z: z / 2, 2, domain=[(-1, 1)] * 2)
    plane = ss.basins(f, grid=[[-1, -0.9, 1], (-1, 1, 5)]).plot(new_figure().add_subplot())
    edges = plane.collections[0].get_coordinates()
    np.testing.assert_allclose(edges[0, :, 0], [-1.05, -0.95, 0.05, 1.95], rtol=0, atol=1e-12)
    np.testing.assert_allclose(edges[:, 0, 1], np.linspace(-1.25, 1.25, 6), rtol=0, atol=1e-12)
    strip = ss.basins(f, grid=[(-1, 1, 5), 0.0]).plot(new_figure().add_subplot())
    assert (strip.get_xlim(), strip.get_ylim()) == ((-1.25, 1.25), (0.0, 1.0))
