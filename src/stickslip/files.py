"""Files that are whole or not there: written elsewhere, then renamed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

__all__ = ["PICTURE_FORMATS", "whole_file", "write_text"]

PICTURE_FORMATS: Final = ("svg", "pdf", "png")


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
    beside = TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.", suffix=".partial")
    with beside as folder:
        temporary = Path(folder) / path.name
        yield temporary
        temporary.replace(path)


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
