"""Files: ordinary ones are read, up to a size; what is written is whole or not there."""

from __future__ import annotations

import os
import reprlib
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

__all__ = ["PICTURE_FORMATS", "checked_path", "read_text", "whole_file", "write_text"]

PICTURE_FORMATS: Final = ("svg", "pdf", "png")
MOST_BYTES: Final = 2**24
"""Of a file that people write by hand."""


def checked_path(path: object, name: str = "path") -> Path:
    """Return the name of a file as a path.

    Raises
    ------
    ValueError
        It is neither text nor a path, or holds a null character.
    """
    text = os.fspath(path) if isinstance(path, os.PathLike) else path
    if not isinstance(text, str) or not text or "\0" in text:
        raise ValueError(
            f"{name} = {reprlib.repr(path)} ({type(path).__name__}) is not allowed: {name} must "
            "be the name of a file, text without null characters or a pathlib.Path."
        )
    return Path(text)


def read_text(path: str | os.PathLike[str], *, limit: int = MOST_BYTES) -> str:
    """Read an ordinary UTF-8 file; a byte-order mark is dropped.

    Parameters
    ----------
    path : str or path
    limit : int, optional
        Bytes that the file may have.

    Raises
    ------
    ValueError
        It is a folder, a device or a pipe, which may have no end; it is larger, or not UTF-8.
        The message begins with the file's name.
    OSError
        It cannot be read.
    """
    path = checked_path(path)
    if not stat.S_ISREG(path.stat().st_mode):  # before it is opened: a pipe would wait
        raise ValueError(
            f"{path}: is a folder, a device or a pipe. Give the name of an ordinary file."
        )
    with path.open("rb") as stream:
        content = stream.read(limit + 1)
    if len(content) > limit:
        raise ValueError(f"{path}: is too large: more than {limit:,} bytes.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(
            f"{path}: not UTF-8 text: byte {content[error.start]:#x} in line {line}. "
            "Save the file as UTF-8."
        ) from None


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
