"""Files that are whole or not there: written elsewhere, then renamed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

__all__ = ["PICTURE_FORMATS", "undo_all", "undone_unless_finished", "whole_file", "write_text"]

PICTURE_FORMATS: Final = ("svg", "pdf", "png")

_undo: list[Callable[[], object]] = []


@contextmanager
def undone_unless_finished(undo: Callable[[], object]) -> Iterator[None]:
    """Call `undo` when the block fails, or when the program ends within it; see `undo_all`.

    To be entered before the first file is made: an interrupt may come between any two lines.
    """
    _undo.append(undo)
    try:
        yield
    except BaseException:
        undo()
        raise
    finally:
        _undo.remove(undo)


def undo_all() -> None:
    """Remove what is half-written: for a program that ends without leaving its blocks."""
    while _undo:
        _undo.pop()()


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a file to write; it becomes `path` when the block ends well.

    A file of that name is replaced. When the block fails or is interrupted nothing is left.

    Parameters
    ----------
    path : pathlib.Path
        Where the file is to appear. Its folder must exist.

    Yields
    ------
    pathlib.Path
        A path of the same name in a temporary folder beside it, for the block to create.

    Raises
    ------
    OSError
        The folder cannot be written, or `path` is a folder.
    """
    folder = path.parent / f".{path.name}.{os.urandom(4).hex()}.partial"
    with undone_unless_finished(lambda: shutil.rmtree(folder, ignore_errors=True)):
        folder.mkdir(0o700)
        temporary = folder / path.name
        yield temporary
        temporary.replace(path)
        folder.rmdir()


def write_text(path: Path, text: str) -> None:
    """Write a text file, UTF-8 with the line ends it has; see `whole_file`.

    Parameters
    ----------
    path : pathlib.Path
        Replaced if it exists.
    text : str
        Its content.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")
