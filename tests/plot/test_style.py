"""The style leaves no trace, and files are whole and the same bytes each time."""

import sys

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

from stickslip.files import PICTURE_FORMATS
from stickslip.plot.style import (
    PALETTE,
    WIDTHS,
    axes_or_new,
    label_once,
    new_figure,
    panel_letter,
    pictured,
    save,
    style,
)

PNG_START = b"\x89PNG\r\n"


def picture():
    with style():
        figure = new_figure("one")
        ax = figure.add_subplot()
        ax.plot([0.0, 1.0], [0.0, -0.5], label=r"$d_{n+1}$")
        ax.fill_between([0.0, 1.0], [0.0, 1.0], hatch="//")
        ax.legend()
        panel_letter(ax, "a")
    return figure


class TestSave:
    def test_the_same_picture_gives_the_same_bytes(self, tmp_path):
        first = save(picture(), tmp_path / "a" / "fig")
        second = save(picture(), tmp_path / "b" / "fig")
        assert [p.suffix for p in first] == [".svg", ".pdf", ".png"]
        for one, other in zip(first, second, strict=True):
            assert one.read_bytes() == other.read_bytes()

    def test_a_users_settings_change_no_byte(self, tmp_path):
        (plain,) = save(picture(), tmp_path / "plain", ("svg",))
        with mpl.rc_context({"font.size": 20.0, "lines.linewidth": 9.0, "svg.hashsalt": "x"}):
            (other,) = save(picture(), tmp_path / "other", ("svg",))
        assert plain.read_bytes() == other.read_bytes()

    def test_no_date_and_no_font_that_the_reader_may_lack(self, tmp_path):
        svg, pdf, png = save(picture(), tmp_path / "fig")
        assert "<dc:date>" not in svg.read_text()
        assert "<text" not in svg.read_text()
        assert b"CreationDate" not in pdf.read_bytes()
        assert png.read_bytes().startswith(PNG_START)

    def test_width_is_the_columns(self, tmp_path):
        (svg,) = save(picture(), tmp_path / "fig", ("svg",))
        assert f'width="{WIDTHS["one"] * 72:g}pt"' in svg.read_text()

    def test_unknown_format_writes_nothing(self, tmp_path):
        with pytest.raises(ValueError, match="'jpg' is not one of svg, pdf, png"):
            save(picture(), tmp_path / "new" / "fig", ("png", "jpg"))
        assert not (tmp_path / "new").exists()

    def test_a_failure_leaves_no_partial_file(self, tmp_path, monkeypatch):
        def fail(self, path, **kwargs):
            path.write_bytes(b"half")
            raise OSError("disk full")

        monkeypatch.setattr(Figure, "savefig", fail)
        with pytest.raises(OSError, match="disk full"):
            save(picture(), tmp_path / "fig")
        assert list(tmp_path.iterdir()) == []

    def test_the_folder_may_be_a_file(self, tmp_path):
        (tmp_path / "out").write_text("")
        with pytest.raises(OSError, match="out"):
            save(picture(), tmp_path / "out" / "fig")

    def test_replaces_an_earlier_file(self, tmp_path):
        (tmp_path / "fig.png").write_text("old")
        save(picture(), tmp_path / "fig", ("png",))
        assert (tmp_path / "fig.png").read_bytes().startswith(PNG_START)


class TestStyle:
    def test_settings_come_back(self):
        before = dict(mpl.rcParams)
        with style():
            assert mpl.rcParams["mathtext.fontset"] == "stix"
            assert mpl.rcParams["text.usetex"] is False
        assert dict(mpl.rcParams) == before

    def test_settings_come_back_after_an_error(self):
        size = mpl.rcParams["font.size"]
        with pytest.raises(RuntimeError, match="inside"), style():
            raise RuntimeError("inside")
        assert mpl.rcParams["font.size"] == size

    def test_unknown_width_is_an_error(self):
        with pytest.raises(ValueError, match="'three' must be one of 'one', 'two'"):
            new_figure("three")


class TestAxes:
    def test_given_axes_come_back(self):
        ax = new_figure().add_subplot()
        assert axes_or_new(ax) is ax

    def test_new_axes_need_no_pyplot(self, monkeypatch):
        monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)
        assert axes_or_new(None).figure is not None
        assert "matplotlib.pyplot" not in sys.modules

    def test_new_axes_are_pyplots_where_the_user_has_imported_it(self):
        plt = pytest.importorskip("matplotlib.pyplot")
        plt.switch_backend("agg")
        ax = axes_or_new(None)
        assert ax.figure.number in plt.get_fignums()
        plt.close(ax.figure)


def test_formats_and_colours_are_distinct():
    assert len(set(PICTURE_FORMATS)) == len(PICTURE_FORMATS)
    assert len(set(PALETTE.values())) == len(PALETTE)


@pytest.mark.parametrize("n", [1, 7, 30])
def test_a_legend_above_the_axes_fits(n):
    def draw(ax):
        for k in range(n):
            ax.plot([0.0, 1.0], [0.0, k], label=f"period {k + 0.123456}")
        return ax

    with style():
        figure = pictured(draw, 4.0)
        figure.draw_without_rendering()
        (legend,) = figure.legends
        box, (ax,) = legend.get_window_extent(), figure.axes
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.x1 + 1.0
    assert box.y0 >= ax.get_window_extent().y1 - 1.0


@pytest.mark.parametrize(
    ("limits", "named"), [((0.0, 1.0), "abc"), ((0.5, 1.0), "ac"), ((2.0, 3.0), "c")]
)
def test_a_legend_names_what_is_seen(limits, named):
    def draw(ax):
        for name, x in (("b", 0.1), ("a", 0.3), ("a", 0.7)):
            ax.plot([x, x], [-9.0, 0.5], "o", label=label_once(ax, name))
        ax.plot([0.0, 9.0], [0.0, 0.0], label="c")
        ax.set(xlim=limits, ylim=(-1.0, 1.0))
        return ax

    with style():
        (legend,) = pictured(draw, 4.0).legends
    assert sorted(text.get_text() for text in legend.get_texts()) == list(named)


def test_a_legend_is_drawn_once_and_equal_scales_leave_no_empty_quarters():
    def draw(ax):
        ax.plot([0.0, 1.0], label="a line")
        ax.legend()
        ax.set_aspect("equal")
        return ax

    with style():
        figure = pictured(draw, 4.0)
    assert not figure.legends
    assert figure.get_figwidth() == figure.get_figheight()
