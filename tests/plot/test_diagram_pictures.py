"""Diagrams, branches and bifurcation curves: what is drawn, read back from the artists."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.diagrams.diagram import AttractorTable, Diagram, OrbitCurve
from stickslip.plot.bifurcations import (
    BREAK,
    MARKS,
    STABLE,
    UNSTABLE,
    draw_bifurcation,
    draw_bifurcations,
    draw_breakpoint_curve,
    draw_curve,
    draw_orbit_curve,
    parameter_label,
)
from stickslip.plot.diagram import draw_attractors, draw_diagram
from stickslip.plot.style import new_figure, save, style

VALUES = np.linspace(0.0, 1.0, 11)


@pytest.fixture
def ax():
    with style():
        yield new_figure("one").add_subplot()


def ending(value, points, reason):
    return CurveEnd(reason, {"r": value}, np.array(points))


def diagram(**changes):
    """A fixed point that loses its stability at 0.5 and a 2-cycle that begins at 0.45."""
    fixed = OrbitCurve(
        1,
        (0.2 + 0.1 * VALUES)[:, None],
        np.where(VALUES < 0.48, 0.5, -1.5),
        (ending(0.0, [0.2], "end of range"), ending(1.0, [0.3], "end of range")),
    )
    points = np.where(VALUES[:, None] > 0.45, [0.6, 0.8], np.nan)
    multipliers = np.where(VALUES > 0.45, 0.1, np.nan)
    born = OrbitCurve(
        2,
        points,
        multipliers,
        (ending(0.45, [0.7, 0.7], "flip"), ending(1.0, [0.6, 0.8], "end of range")),
    )
    table = AttractorTable(
        where=np.array([0, 7, 8]),
        kind=np.array(["periodic", "chaotic", "periodic"]),
        period=np.array([1, 0, 3]),
        lyapunov=np.array([-0.1, 0.3, -0.2]),
        points=np.array([[0.2, np.nan, np.nan], [0.4, 0.41, 0.42], [0.5, 0.51, 0.52]]),
    )
    fields = {
        "parameter": "V",
        "values": VALUES,
        "max_period": 2,
        "window": (0.0, 1.0),
        "parameters": {},
        "orbits": (fixed, born),
        "attractors": table,
        "breakpoints": (BreakpointLine("jump", 0.9 - 0.1 * VALUES),),
    }
    return Diagram(**{**fields, **changes})


def drawn(ax, looks):
    """Finite points of all lines of one colour."""
    lines = [line for line in ax.lines if to_hex(line.get_color()) == to_hex(looks["color"])]
    points = np.concatenate([line.get_xydata() for line in lines]) if lines else np.empty((0, 2))
    return points[np.isfinite(points).all(axis=1)]


class TestDiagram:
    def test_stable_is_heavy_and_unstable_thin(self, ax):
        draw_diagram(diagram(), ax)
        assert STABLE["lw"] > 2 * UNSTABLE["lw"]
        heavy, thin = drawn(ax, STABLE), drawn(ax, UNSTABLE)
        fixed = heavy[heavy[:, 1] < 0.35]
        assert fixed[:, 0].max() == pytest.approx(0.4)
        assert thin[:, 0].max() == 1.0
        # The thin line begins at the last heavy point: no hole between them.
        assert thin[:, 0].min() == pytest.approx(0.4)

    def test_curves_reach_their_ends_between_the_values(self, ax):
        draw_diagram(diagram(), ax)
        born = drawn(ax, STABLE)
        born = born[born[:, 1] > 0.5]
        assert len(born)
        assert [0.45, 0.7] in born.tolist()
        assert born[:, 0].min() == 0.45

    def test_only_attractors_that_are_no_drawn_orbit_are_dots(self, ax):
        draw_diagram(diagram(), ax)
        (dots,) = [line for line in ax.lines if line.get_marker() == ","]
        expected = {(0.7, 0.4), (0.7, 0.41), (0.7, 0.42), (0.8, 0.5), (0.8, 0.51), (0.8, 0.52)}
        assert {(round(x, 9), y) for x, y in dots.get_xydata().tolist()} == expected

    def test_chaotic_dots_can_be_thinned_out_but_cycles_stay_whole(self, ax):
        draw_diagram(diagram(), ax, dots=1)
        (dots,) = [line for line in ax.lines if line.get_marker() == ","]
        assert sorted(dots.get_ydata().tolist()) == [0.4, 0.5, 0.51, 0.52]

    def test_kinds_of_attractors_can_be_chosen(self, ax):
        draw_attractors(diagram(), ax, kinds=["periodic"])
        assert sorted(ax.lines[0].get_ydata().tolist()) == [0.5, 0.51, 0.52]

    def test_breakpoints_are_dashed_and_can_be_left_out(self, ax):
        draw_diagram(diagram(), ax)
        np.testing.assert_array_equal(drawn(ax, BREAK)[:, 1], 0.9 - 0.1 * VALUES)
        bare = draw_diagram(diagram(), new_figure().add_subplot(), breakpoints=False)
        assert not len(drawn(bare, BREAK))

    def test_ends_of_orbits_are_marked_by_their_kind(self, ax):
        draw_diagram(diagram(), ax)
        (flip,) = [line for line in ax.lines if line.get_marker() == MARKS["flip"][0]]
        assert flip.get_xydata().tolist() == [[0.45, 0.7], [0.45, 0.7]]
        assert ax.get_legend_handles_labels()[1] == ["flip"]
        bare = draw_diagram(diagram(), new_figure().add_subplot(), marks=False)
        assert bare.get_legend_handles_labels()[1] == []

    def test_periods_can_be_chosen(self, ax):
        draw_diagram(diagram(), ax, periods=[2])
        assert drawn(ax, STABLE)[:, 1].min() >= 0.6

    def test_axes_are_named_and_show_the_window(self, ax):
        draw_diagram(diagram(), ax)
        assert ax.get_xlabel() == r"$V_{\mathrm{dr}}$"
        assert ax.get_ylabel() == "$d$"
        assert ax.get_xlim() == (0.0, 1.0)
        assert ax.get_ylim() == (0.0, 1.0)
        draw_diagram(diagram(), ax, window=(0.5, 0.9))
        assert ax.get_ylim() == (0.5, 0.9)

    def test_plot_is_the_same_picture(self):
        assert len(diagram().plot().lines) == len(draw_diagram(diagram()).lines)

    def test_nothing_found_is_an_empty_picture(self, ax):
        empty = AttractorTable(*(np.empty(0) for _ in range(4)), np.empty((0, 1)))
        draw_diagram(diagram(orbits=(), breakpoints=(), attractors=empty), ax)
        assert len(ax.lines) == 0

    def test_bifurcations_are_marked_on_top(self, ax):
        flip = SimpleNamespace(kind="flip", value=0.45, points=np.array([0.7]), parameter="V")
        draw_diagram(diagram(), ax, bifurcations=[flip])
        assert ax.lines[-1].get_xydata().tolist() == [[0.45, 0.7]]
        assert ax.lines[-1].get_marker() == MARKS["flip"][0]

    @pytest.mark.parametrize("suffix", ["svg", "pdf", "png"])
    def test_the_same_diagram_gives_the_same_bytes(self, tmp_path, suffix):
        files = []
        for name in "ab":
            with style():
                figure = new_figure("one")
                draw_diagram(diagram(), figure.add_subplot())
            files += save(figure, tmp_path / name, (suffix,))
        assert files[0].read_bytes() == files[1].read_bytes()


class TestBranch:
    @staticmethod
    def branch():
        """A fold at 0.2: parameter down along the stable half, up along the unstable one."""
        x = np.linspace(-0.5, 0.5, 21)
        fold = SimpleNamespace(kind="fold", value=0.2, points=np.array([0.0]))
        return SimpleNamespace(
            parameter="alpha",
            values=0.2 + x**2,
            points=x[:, None],
            multipliers=1 + x,
            period=1,
            bifurcations=(fold,),
        )

    def test_both_halves_and_the_fold(self, ax):
        draw_orbit_curve(self.branch(), ax)
        heavy, thin = drawn(ax, STABLE), drawn(ax, UNSTABLE)
        assert (heavy[:, 1].min(), heavy[:, 1].max()) == pytest.approx((-0.5, 0.0), abs=1e-12)
        assert (thin[:, 1].min(), thin[:, 1].max()) == pytest.approx((0.0, 0.5), abs=1e-12)
        assert ax.lines[-1].get_xydata().tolist() == [[0.2, 0.0]]
        assert ax.get_xlabel() == r"$\alpha$"

    def test_marks_are_named_once(self, ax):
        draw_orbit_curve(self.branch(), ax)
        draw_orbit_curve(self.branch(), ax)
        assert ax.get_legend_handles_labels()[1] == ["fold"]


class TestBifurcations:
    @staticmethod
    def item(kind, value):
        points = np.array([0.1, 0.4])
        return SimpleNamespace(kind=kind, value=value, points=points, parameter="r")

    def test_every_kind_has_its_own_mark(self):
        markers = [marker for marker, _ in MARKS.values()]
        assert len(set(markers)) == len(MARKS)

    def test_a_mark_per_point(self, ax):
        draw_bifurcation(self.item("border_collision", 0.3), ax)
        assert ax.lines[0].get_xydata().tolist() == [[0.3, 0.1], [0.3, 0.4]]
        assert ax.get_legend_handles_labels()[1] == ["border collision"]

    def test_list_draws_branches_and_marks_with_a_legend(self, ax):
        class Found(list):
            curves = (TestBranch.branch(),)
            parameter, range, window = "alpha", (0.1, 0.5), (-1.0, 1.0)

        found = Found([self.item("fold", 0.2), self.item("flip", 0.3), self.item("fold", 0.4)])
        draw_bifurcations(found, ax)
        assert [text.get_text() for text in ax.get_legend().get_texts()] == ["fold", "flip"]
        assert ax.get_xlim() == (0.1, 0.5)
        assert ax.get_ylim() == (-1.0, 1.0)
        assert len(drawn(ax, STABLE)) > 0


class TestCurve:
    @staticmethod
    def curve():
        special = SimpleNamespace(kind="cusp", parameters={"alpha": 1.2, "V": 0.30})
        return SimpleNamespace(
            kind="fold",
            period=3,
            parameter="alpha",
            solve_for="V",
            parameters={"alpha": np.array([1.1, 1.2, 1.3]), "V": np.array([0.29, 0.30, 0.28])},
            bifurcations=(special,),
        )

    def test_parameters_are_the_axes(self, ax):
        draw_curve(self.curve(), ax)
        assert ax.lines[0].get_xydata().tolist() == [[1.1, 0.29], [1.2, 0.30], [1.3, 0.28]]
        assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\alpha$", r"$V_{\mathrm{dr}}$")
        assert ax.get_legend_handles_labels()[1] == ["fold, period 3"]

    def test_special_points_are_marked_and_named(self, ax):
        draw_curve(self.curve(), ax)
        assert ax.lines[1].get_xydata().tolist() == [[1.2, 0.30]]
        assert [text.get_text() for text in ax.texts] == ["cusp"]
        bare = draw_curve(self.curve(), new_figure().add_subplot(), names=False)
        assert not bare.texts

    def test_breakpoint_curve_is_dashed(self, ax):
        curve = SimpleNamespace(parameter="V", values=VALUES, points=VALUES[:, None] ** 2)
        draw_breakpoint_curve(curve, ax)
        np.testing.assert_array_equal(drawn(ax, BREAK), np.column_stack([VALUES, VALUES**2]))


@pytest.mark.parametrize(
    ("name", "label"),
    [("alpha", r"$\alpha$"), ("mu_2", r"$\mu_{\mathrm{k},2}$"), ("r", "r"), ("my_rate", "my_rate")],
)
def test_parameters_without_a_symbol_keep_their_name(name, label):
    assert parameter_label(name) == label


def test_mu_of_a_map_of_ones_own_is_not_that_of_friction():
    own = SimpleNamespace(parameters={"mu": 0.2, "a": 1.0})
    assert parameter_label("mu", own) == "mu"
    assert parameter_label("mu", SimpleNamespace(system=own)) == "mu"
    model = SimpleNamespace(parameters={"mu": 0.2, "V": 1.0})
    assert parameter_label("mu", model) == parameter_label("mu") == r"$\mu_{\mathrm{k}}$"
