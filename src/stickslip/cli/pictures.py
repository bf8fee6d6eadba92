"""Pictures of results as files, in the style of the paper's figures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from stickslip.cli.failure import UsageError

HEIGHT = 4.0  # inches, over the width of two columns


def check_suffix(path: Path) -> None:
    """Refuse a picture's file whose format does not exist, before anything is computed."""
    from stickslip.plot.style import FORMATS

    if path.suffix.removeprefix(".") not in FORMATS:
        endings = ", ".join(f".{name}" for name in FORMATS)
        raise UsageError(f"--out {path}: the name of a picture ends in one of {endings}")


def draw(result: Any, paths: Iterable[Path], **style_of_result: Any) -> None:
    """Draw a result by its own ``plot`` and write it to files, the format as each is named."""
    from stickslip.plot.style import new_figure, save, style

    with style():
        figure = new_figure("two", height=HEIGHT)
        axes = result.plot(figure.add_subplot(), **style_of_result)
        if labels := axes.get_legend_handles_labels()[1]:
            figure.legend(loc="outside upper right", ncols=len(labels))
        for path in paths:
            save(figure, path.with_suffix(""), (path.suffix.removeprefix("."),))
