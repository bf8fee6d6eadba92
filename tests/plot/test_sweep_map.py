"""Maps of sweeps: which cell has which colour, and curves where they belong."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.continuation.curve import Curve, CurveEnd
from stickslip.plot.style import PALETTE, new_figure
from stickslip.plot.sweep_map import sweep

xarray = pytest.importorskip("xarray")

NOT_COMPUTED = np.iinfo("int32").min


def dataset(**more):
    coordinates = {"V": [0.1, 0.2, 0.3], "alpha": [1.0, 2.0]}
    flags = {"flag_values": [-1, 0, 1, 2], "flag_meanings": "undecided left periodic chaotic"}
    variables = {
        "kind": (("V", "alpha"), np.array([[1, 2], [0, -1], [1, -128]], dtype="int8"), flags),
        "period": (
            ("V", "alpha"),
            np.array([[1, 0], [6, 7], [100, NOT_COMPUTED]], dtype="int32"),
        ),
        "lyapunov_exponent": (
            ("V", "alpha"),
            np.array([[-9.0, 0.2], [np.nan, 0.1], [-0.3, np.nan]]),
            {"long_name": "the exponent"},
        ),
        "orbit": (("V", "alpha", "iterate"), np.zeros((3, 2, 4))),
    }
    return xarray.Dataset({**variables, **more}, coordinates)


def colours(ax):
    """Colour of each cell, rows upwards; None where nothing is drawn."""
    mesh = ax.collections[0]
    mesh.update_scalarmappable()
    drawn = mesh.to_rgba(mesh.get_array()).reshape(-1, 4)
    hidden = np.ma.getmaskarray(mesh.get_array()).ravel()
    from matplotlib.colors import to_hex

    return [None if no else to_hex(c).upper() for c, no in zip(drawn, hidden, strict=True)]


def test_kinds_have_a_colour_each():
    ax = sweep(dataset())
    light, grey, sky, orange = (PALETTE[name] for name in ("light", "grey", "sky", "orange"))
    assert colours(ax) == [sky, grey, sky, orange, light, None]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "undecided",
        "left",
        "periodic",
        "chaotic",
    ]
    assert ax.get_ylabel() == r"$\alpha$"


def test_over_one_axis_a_line_is_drawn():
    ax = sweep(dataset().sel(alpha=1.0))
    (line,) = ax.lines
    assert line.get_xdata().tolist() == [0.1, 0.2, 0.3]
    assert line.get_ydata().tolist() == [1.0, 0.0, 1.0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$V_{\mathrm{dr}}$", "kind")
    names = [text.get_text() for text in ax.get_yticklabels()]
    assert names == ["undecided", "left", "periodic", "chaotic"]
    ax = sweep(dataset().sel(alpha=2.0), "period")
    assert np.ma.getmaskarray(ax.lines[0].get_ydata(orig=True)).tolist() == [False, False, True]


def test_long_periods_are_grouped():
    ax = sweep(dataset(), "period")
    found = colours(ax)
    assert found[:2] == [PALETTE["sky"], PALETTE["vermillion"]]
    assert (found[3], found[5]) == (PALETTE["light"], None)
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["not periodic", "1", "6", "7 to 15", "64 and more"]


def test_numbers_have_a_scale_that_shows_chaos():
    figure = new_figure()
    ax = sweep(dataset(), "lyapunov_exponent", figure.add_subplot())
    low, high = ax.collections[0].get_clim()
    assert high == pytest.approx(0.2, abs=0.01)
    assert low == pytest.approx(-2 * high)
    assert figure.axes[1].get_ylabel() == "the exponent"
    assert [cell is None for cell in colours(ax)] == [False, True, False, False, False, True]


def test_axes_with_even_ratios_are_logarithmic():
    even = dataset().assign_coords(V=[0.1, 1.0, 10.0])
    assert sweep(even).get_xscale() == "log"
    assert sweep(dataset()).get_xscale() == "linear"


def curve(along="alpha", solve_for="V"):
    parameters = {along: np.array([1.0, 2.0]), solve_for: np.array([0.12, 0.28])}
    end = CurveEnd("", {}, np.zeros(1))
    return Curve(
        "bifurcation: fold",
        parameters,
        np.zeros((2, 1)),
        np.ones(2),
        np.zeros(2, dtype=bool),
        (end, end),
        bifurcations=(),
        data={},
        problem=None,
        period=3,
    )


def test_curves_are_drawn_over_the_map_whichever_way_they_run():
    for given in (curve(), curve("V", "alpha")):
        ax = sweep(dataset(), curves=(given,))
        line = ax.lines[-1]
        np.testing.assert_array_equal(line.get_xdata(), given.parameters["V"])
        np.testing.assert_array_equal(line.get_ydata(), given.parameters["alpha"])
        assert line.get_label() == "fold of period 3"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"variable": "orbit"}, "has the axes V, alpha, iterate: a picture has one or two"),
        ({"variable": "kinds"}, "'kinds' is unknown.* Did you mean 'kind'"),
        ({"curves": (curve("beta"),)}, "a curve of V over beta does not lie in the plane"),
    ],
)
def test_what_cannot_be_drawn_is_told(arguments, words):
    with pytest.raises(ValueError, match=words):
        sweep(dataset(), **arguments)


@pytest.mark.slow
def test_the_raster_of_periods_agrees_with_the_exact_curve(tmp_path):
    # The paper's S4 ends where block 2 grazes; followed in alpha, between cells of 3e-6 in V.
    model = ss.examples.coulomb()
    (collision,) = ss.bifurcations(model, "V", (0.0369, 0.0371), max_period=4, n_lists=6)
    exact = ss.follow(collision, "alpha", (1.1998, 1.2002), solve_for="V")
    found = ss.sweep(
        model,
        {"V": (0.03696, 0.03699, 11), "alpha": (1.1998, 1.2002, 3)},
        [ss.observables.Attractor(transient=1500, n=300)],
        store=tmp_path / "x",
        d=collision.points[0],
        threads=1,
    )
    for alpha in found.alpha.values:
        at = exact.at(alpha=alpha).value
        below = found.V.values < at
        period = found.period.sel(alpha=alpha).values
        assert (period[below] == 4).all()
        assert (period[~below] != 4).all()
        assert below.any()
        assert not below.all()
