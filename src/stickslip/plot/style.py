"""One style for every picture, and one writer whose files are the same bytes each time."""

from __future__ import annotations

import base64
import importlib
import io
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties

from stickslip.checks import shown
from stickslip.files import PICTURE_FORMATS, whole_file

WIDTHS: Final = MappingProxyType({"one": 3.46, "two": 7.09})
"""Widths in inches of a figure over one and over two columns (88 and 180 mm)."""

NOTEBOOK_DPI: Final = 130.0

PALETTE: Final = MappingProxyType(
    {
        "black": "#000000",
        "blue": "#0072B2",
        "vermillion": "#D55E00",
        "green": "#009E73",
        "purple": "#CC79A7",
        "orange": "#E69F00",
        "sky": "#56B4E9",
        "grey": "#7F7F7F",
        "light": "#D9D9D9",
    }
)
"""Colours that stay apart for colour-blind readers (Okabe and Ito 2008), and two greys."""

DASHED: Final = (0, (4, 2))
"""Style of broken lines in figures."""

# Any: matplotlib types the keys one by one, and newer versions know more of them.
_SETTINGS: Final[Any] = {
    "font.family": "STIXGeneral",  # ships with matplotlib; text and mathtext agree, no LaTeX
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": cycler(
        color=[PALETTE[name] for name in ("blue", "vermillion", "green", "purple", "orange")]
    ),
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "lines.linewidth": 1.0,
    "lines.markersize": 4.0,
    "lines.solid_capstyle": "butt",
    "patch.linewidth": 0.6,
    "hatch.linewidth": 0.4,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.minor.size": 1.6,
    "ytick.minor.size": 1.6,
    "figure.dpi": 100.0,
    "figure.facecolor": "white",
    "savefig.dpi": 300.0,
    "savefig.bbox": None,  # a figure keeps the width it was given
    "svg.fonttype": "path",  # the same picture on machines without the fonts
    "svg.hashsalt": "stickslip",
    "pdf.fonttype": 42,
    "path.simplify_threshold": 0.02,
}

# A date or a version in a file would make two equal pictures differ.
_METADATA: Final[dict[str, dict[str, str | None]]] = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}


@contextmanager
def style() -> Iterator[None]:
    """Draw and save in the house style; the caller's settings come back afterwards."""
    # A user's own style file cannot change a figure of the paper.
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def new_figure(columns: str = "one", *, height: float | None = None) -> Figure:
    """Figure of the width of one or two columns, 88 or 180 mm, apart from pyplot's state."""
    if columns not in WIDTHS:
        raise ValueError(f"columns = {columns!r} must be one of {', '.join(map(repr, WIDTHS))}")
    return Figure(figsize=(WIDTHS[columns], height or 0.75 * WIDTHS["one"]), layout="constrained")


def pictured(draw: Callable[[Axes], Axes], height: float) -> Figure:
    """Draw on axes of a new figure, as wide as two columns or square, with a legend above."""
    figure = new_figure("two", height=height)
    axes = draw(figure.add_subplot())
    if 1.0 in (axes.get_aspect(), axes.get_box_aspect()):
        figure.set_figwidth(height)
    if axes.get_legend() is None:
        _leave_out_unseen(axes)
        if axes.get_legend_handles_labels()[1]:
            figure.legend(loc="outside upper right", ncols=legend_columns(axes))
    return figure


def label_once(axes: Axes, name: str) -> str:
    """Return a label for one more artist of a name, which legends list once."""
    return f"_{name}" if name in axes.get_legend_handles_labels()[1] else name


def _leave_out_unseen(axes: Axes) -> None:
    """Take names of marks that all lie outside the axes' limits out of legends."""
    shown = axes.viewLim
    for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
        named = [line for line in axes.lines if line.get_label() in (name, f"_{name}")]
        if named and all(line.get_linestyle() == "None" for line in named):
            points = np.concatenate([line.get_xydata() for line in named])
            if not ((points >= shown.min) & (points <= shown.max)).all(axis=1).any():
                handle.set_label(f"_{name}")


def legend_columns(axes: Axes) -> int:
    """Tell how many entries of a legend above the axes stand beside each other."""
    markup = str.maketrans("", "", "${}_")
    labels = [label.translate(markup) for label in axes.get_legend_handles_labels()[1]]
    size = FontProperties(size=mpl.rcParams["legend.fontsize"]).get_size_in_points()
    width = 72.0 * axes.figure.bbox.width / axes.figure.dpi / size
    fitting = int(width / (LEGEND_LINE + LEGEND_LETTER * max(map(len, labels))))
    return min(len(labels), max(fitting, 1))


LEGEND_LINE: Final = 4.5
LEGEND_LETTER: Final = 0.63
"""Font sizes that an entry of a legend takes, apart from its letters and for each of them."""


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the axes given, or those of a new figure."""
    # Registered with pyplot only if the caller has imported pyplot: ``plt.show()`` works there, and
    # no window system is touched elsewhere; and in a notebook, which shows pyplot's figures.
    if isinstance(ax, Axes):
        return ax
    if ax is not None:
        raise TypeError(
            f"ax = {shown(ax)} is not allowed: ax must be matplotlib axes, or None for a new "
            "figure. Take ax from matplotlib.pyplot.subplots()."
        )
    if _in_notebook():
        importlib.import_module("matplotlib.pyplot")
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        axes: Axes = pyplot.figure(layout="constrained").add_subplot()
        return axes
    return new_figure().add_subplot()


def _in_notebook() -> bool:
    """Whether a kernel of Jupyter runs, which chooses a backend that shows figures in cells."""
    backend = os.environ.get("MPLBACKEND", "")
    return "IPython" in sys.modules and ("inline" in backend or backend.startswith("module://"))


def png_text(draw: Callable[[Axes], object]) -> str:
    """Draw on axes of a new figure, apart from pyplot's state; return its PNG in base 64."""
    with style():
        figure = new_figure()
        draw(figure.add_subplot())
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=NOTEBOOK_DPI, metadata=_METADATA["png"])
    return base64.b64encode(stream.getvalue()).decode()


def panel_letter(ax: Axes, letter: str, about: str = "") -> None:
    """Name a panel as the paper does: "(a)" above its left end, then what it is about."""
    ax.set_title(f"({letter}) {about}".rstrip(), loc="left", pad=3.0)


def check_formats(formats: Iterable[str]) -> tuple[str, ...]:
    """Return names of file formats, each one of `PICTURE_FORMATS`."""
    given = (formats,) if isinstance(formats, str) else tuple(formats)
    for name in given:
        if name not in PICTURE_FORMATS:
            raise ValueError(f"format {name!r} is not one of {', '.join(PICTURE_FORMATS)}")
    return given


def save(
    figure: Figure, stem: str | Path, formats: Iterable[str] = PICTURE_FORMATS
) -> tuple[Path, ...]:
    """Write a figure in some formats, each file whole or not at all; same figure, same bytes."""
    formats = check_formats(formats)
    stem = Path(stem)
    stem.parent.mkdir(parents=True, exist_ok=True)
    return tuple(_write(figure, Path(f"{stem}.{name}"), name) for name in formats)


def _write(figure: Figure, path: Path, name: str) -> Path:
    with whole_file(path) as partial, style():
        figure.savefig(partial, format=name, metadata=_METADATA[name])
    return path
