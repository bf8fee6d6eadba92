"""Files: ordinary ones are read, up to a size; what is written is whole or not there."""

from __future__ import annotations

import csv
import errno
import math
import os
import reprlib
import shutil
import stat
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TextIO

PICTURE_FORMATS: Final = ("svg", "pdf", "png")
LONGEST_PATH: Final = 4096
MOST_BYTES: Final = 2**22
"""Of a file that people write by hand."""
FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Why a disk takes no more; the system does not say which file that was for."""


def checked_path(path: object) -> Path:
    """Return the name of a file as a path."""
    text = os.fspath(path) if isinstance(path, os.PathLike) else path
    if not isinstance(text, str) or not 0 < len(text) <= LONGEST_PATH or "\0" in text:
        raise ValueError(
            f"path = {_shown(path)} ({type(path).__name__}) is not allowed: path must be a "
            "file's name, a text of 1 to 4096 characters without null, or a pathlib.Path."
        )
    return Path(text)


def _shown(value: object) -> str:
    try:
        return reprlib.repr(value)
    except ValueError:  # Python writes no whole number of thousands of digits
        return "a long number"


def checked_suffix(path: Path, suffixes: Collection[str], name: str = "path") -> str:
    """Return the suffix of a file to be written; "" among those allowed stands for none."""
    if path.suffix in suffixes:
        return path.suffix
    raise ValueError(
        f"{name} = {reprlib.repr(str(path))}: the suffix of a file says what is written into it. "
        f"Give a name that ends in {' or '.join(filter(None, suffixes))}."
    )


def read_text(path: str | os.PathLike[str], *, limit: int = MOST_BYTES) -> str:
    """Read an ordinary UTF-8 file, no device or pipe; see `text_of`."""
    path = checked_path(path)
    _refuse_special(path)  # before it is opened: a pipe would wait
    try:
        with path.open("rb") as stream:
            content = stream.read(limit + 1)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    if len(content) > limit:
        raise ValueError(f"{path}: is too large: more than {limit:,} bytes.")
    return text_of(content, f"{path}: ")


def text_of(content: bytes, place: str = "") -> str:
    """Return UTF-8 text without its byte-order mark; ValueError names place and line."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ValueError(
            f"{place}not UTF-8 text: byte {content[error.start]:#x} in line {line}. "
            "Save the file as UTF-8."
        ) from None


def _refuse_special(path: Path) -> None:
    """Raise OSError, with its name, for what is neither an ordinary file nor missing."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        told = "it is a device or a pipe, not an ordinary file"
        raise OSError(errno.EINVAL, told, str(path))


_undo: list[Callable[[], object]] = []


@contextmanager
def undone_unless_finished(undo: Callable[[], object]) -> Iterator[None]:
    """Call `undo` when the block fails, or when the program ends within it."""
    # To be entered before the first file is made: an interrupt may come between any two lines.
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
    """Give a file to write, of the same name; it becomes `path` when the block ends well."""
    # A file of that name is replaced; of a link, what it leads to. When the block fails or is
    # interrupted nothing is left.
    _refuse_special(path)
    target = Path(os.path.realpath(path))  # a link stays one
    beside = f".{path.name[:40]}."  # short: a name of the longest length has no room for more
    folder = target.parent / f"{beside}{os.urandom(4).hex()}.partial"
    try:
        with undone_unless_finished(lambda: shutil.rmtree(folder, ignore_errors=True)):
            folder.mkdir(0o700)
            temporary = folder / path.name
            yield temporary
            temporary.replace(target)
            folder.rmdir()
    except OSError as error:
        ours = beside in str(error.filename)
        if ours or (error.filename is None and error.errno in FULL):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file, UTF-8 with the line ends it has; see `whole_file`."""
    with whole_file(checked_path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")


# ------------------------------------------------------------------ CSV


def write_table(path: Path, columns: Mapping[str, Any]) -> None:
    """Write columns as a CSV file; see `whole_file` and `write_csv`."""
    with whole_file(path) as temporary:
        with temporary.open("w", encoding="utf-8", newline="") as stream:
            write_csv(stream, columns)


def write_csv(stream: TextIO, columns: Mapping[str, Any]) -> None:
    """Write a header and one line per row.

    Floats keep every digit, NaN is ``nan``; numbers of a list stand in one cell with spaces
    between them; None is an empty cell. Imaginary parts have a column of their own, ``..._imag``.
    """
    columns = real_columns(columns)
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    cells = ([flat(cell, _exact) for cell in as_list(column)] for column in columns.values())
    writer.writerows(zip(*cells, strict=True))


def real_columns(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Give the imaginary parts of each column with complex numbers one of their own, `x_imag`."""
    real: dict[str, Any] = {}
    for name, column in columns.items():
        cells = as_list(column)
        if not any(map(_is_complex, cells)):
            real[name] = column
            continue
        real[name] = [_part("real", cell) for cell in cells]
        real[f"{name}_imag"] = [_part("imag", cell) for cell in cells]
    return real


def _is_complex(cell: Any) -> bool:
    return any(map(_is_complex, cell)) if isinstance(cell, tuple) else isinstance(cell, complex)


def _part(part: str, cell: Any) -> Any:
    several = isinstance(cell, tuple)
    return tuple(_part(part, item) for item in cell) if several else getattr(cell, part, cell)


def as_list(column: Any) -> list[Any]:
    """Turn an array or any sequence into a list of Python's own numbers and strings."""
    return list(column.tolist() if hasattr(column, "tolist") else column)


def plain(value: Any) -> Any:
    """Return values as JSON has them: lists, numbers, texts; None for NaN and infinities."""
    if hasattr(value, "tolist"):  # an array, or a number of NumPy's
        return plain(value.tolist())
    match value:
        case float():
            return value if math.isfinite(value) else None
        case complex():
            return [plain(value.real), plain(value.imag)]
        case Mapping():
            return {str(key): plain(item) for key, item in value.items()}
        case list() | tuple():
            return [plain(item) for item in value]
    return value


def flat(cell: Any, text: Callable[[float], str]) -> Any:
    """Write floats and lists of them by `text`; leave anything else as it is."""
    if isinstance(cell, list | tuple):
        return " ".join(str(flat(item, text)) for item in cell)
    if cell is None:
        return ""
    return text(cell) if isinstance(cell, float) else cell


def _exact(number: float) -> str:
    """Write every digit, of a NumPy float as of Python's."""
    return repr(float(number))
