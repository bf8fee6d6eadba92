"""Pictures of results as files, in the style of the paper's figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.files import PICTURE_FORMATS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEIGHT = 4.0  # inches, over the width of two columns
SUFFIXES = tuple(f".{name}" for name in PICTURE_FORMATS)


def draw(plot: Callable[[Axes], Axes], paths: Iterable[Path]) -> None:
    """Draw a result, as its ``plot`` does, into files; the format as each is named."""
    from stickslip.plot.style import new_figure, save, style

    with style():
        figure = new_figure("two", height=HEIGHT)
        axes = plot(figure.add_subplot())
        if labels := axes.get_legend_handles_labels()[1]:
            figure.legend(loc="outside upper right", ncols=len(labels))
        for path in paths:
            save(figure, path.with_suffix(""), (path.suffix.removeprefix("."),))
