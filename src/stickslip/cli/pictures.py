"""Pictures of results as files, in the style of the paper's figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.cli.failure import UsageError
from stickslip.files import PICTURE_FORMATS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEIGHT = 4.0  # inches, over the width of two columns


def is_picture(path: Path) -> bool:
    """Whether a file is to hold a picture, by its name."""
    return path.suffix.removeprefix(".") in PICTURE_FORMATS


def check_suffix(path: Path) -> None:
    """Refuse a picture's file whose format does not exist, before anything is computed."""
    if not is_picture(path):
        endings = ", ".join(f".{name}" for name in PICTURE_FORMATS)
        raise UsageError(f"--out {path}: the name of a picture ends in one of {endings}")


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
