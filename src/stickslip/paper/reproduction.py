"""Write the paper's figures and the table of its numbers."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.paper import figures
from stickslip.paper.galvanetto2001 import printed
from stickslip.paper.values import Value, as_json, as_markdown
from stickslip.plot.style import FORMATS, check_formats, new_figure, save, style

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

__all__ = ["Reproduction", "reproduce"]


@dataclass(frozen=True)
class Reproduction:
    """What was written.

    Attributes
    ----------
    files : tuple of pathlib.Path
        Figures first, then ``values.json`` and ``values.md``.
    values : tuple of Value
        The numbers of the table.
    """

    files: tuple[Path, ...]
    values: tuple[Value, ...]


def reproduce(
    numbers: Iterable[int] | None = None,
    out: str | Path = "out",
    formats: Iterable[str] = FORMATS,
    *,
    track: Callable[[Sequence[int]], Iterable[int]] = iter,
) -> Reproduction:
    """Compute and draw figures of the paper, and the numbers that belong to them.

    Parameters
    ----------
    numbers : iterable of int, optional
        Figures as numbered in the paper; all that there are if none is given.
    out : str or path
        Folder to write to; made if missing. Files of the same names are replaced.
    formats : iterable of {"svg", "pdf", "png"}
        What to write each figure as.
    track : callable, optional
        Passes the figure numbers on one by one: a place for a progress bar.

    Returns
    -------
    Reproduction
        Paths and values.

    Raises
    ------
    ValueError
        A figure or format that does not exist; nothing has been written then.
    OSError
        The folder cannot be made or written. No partial file is left.
    """
    wanted = figures.select(numbers)
    formats = check_formats(formats)
    folder = _writable(Path(out))
    files: list[Path] = []
    captions: dict[int, str] = {}
    for number in track(wanted):
        captions[number], written = _figure(number, folder, formats)
        files += written
    # Some printed numbers belong to figures that cannot be drawn yet.
    values = printed.compute(wanted if set(wanted) < set(figures.available()) else None)
    files.append(_write(folder / "values.json", as_json(values, captions)))
    files.append(_write(folder / "values.md", as_markdown(values, captions)))
    return Reproduction(tuple(files), values)


def _figure(number: int, folder: Path, formats: tuple[str, ...]) -> tuple[str, tuple[Path, ...]]:
    module = figures.load(number)
    data = module.compute()
    with style():
        figure = new_figure(module.COLUMNS, height=module.HEIGHT)
        module.draw(data, figure)
        return module.caption(data), save(figure, folder / f"fig{number:02d}", formats)


def _writable(folder: Path) -> Path:
    """Fail before the first computation, not after it."""
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"cannot write to the output folder {folder}")
    return folder


def _write(path: Path, text: str) -> Path:
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    return path
