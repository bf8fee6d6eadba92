"""What commands write: files, whole or not there, JSON documents, tables, pictures and progress.

Files are opened before the computation: one that cannot be written is said at once, not in an hour.
They never replace others unasked. Progress goes to stderr, and only where someone watches.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import msgspec
from cyclopts import CycloptsError

from stickslip.app.words import without_clauses
from stickslip.cli.process import CommandError, RefusalError, UsageError, all_or_none, shortened
from stickslip.files import (
    PICTURE_FORMATS,
    as_list,
    flat,
    undone_unless_finished,
    whole_file,
    write_csv,
)
from stickslip.numerics.waiting import waiting

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCHEMA = 1
TABLE_ROWS = 40
# Columns that a reader on a terminal has in another form or cannot use.
MACHINE_ONLY = {"label", "status"}
PICTURE_HEIGHT = 4.0  # inches, over the width of two columns
# An argument of Python in a message, with or without a place in it and a value; no part of a call,
# a quotation or a list of names.
ARGUMENT = re.compile(
    r"""Known: [^.]*\.|[\w.]+\((?:[^()]|\([^()]*\))*?(?:\)|\.\.\. )|(?<!\w)(['"]).*?\1(?!\w)|"""
    r"""(?<![\w.:-])(?<!-p )(?P<name>[a-z]\w*)(?P<at>(?:\[[^]]*\])*)"""
    r"""(?P<given>=True\b|=| = |(?![\w(=[]))"""
)
# What only Python has: the kind of a value, and what is said of an object's parts.
KIND = re.compile(r" \((?:tuple|list|dict|ndarray)\)")
PARTS = re.compile(r"\b(?:(?:ss|model|dataset)\.[a-z]\w*(?:\(|\.(?!\S))|stickslip\.[a-z])")
PICTURE_SUFFIXES = tuple(f".{name}" for name in PICTURE_FORMATS)


@contextmanager
def new_files(paths: Sequence[Path], *, force: bool) -> Iterator[list[Path]]:
    """Give files to write; they appear under their names when the block ends well."""
    for path in paths:
        check_new(path, force=force)
    with ExitStack() as stack:
        yield [_entered(stack, path) for path in paths]
        with all_or_none():
            stack.close()


def check_new(path: Path, *, force: bool) -> None:
    """Refuse a file that exists, unless `force` replaces it."""
    if path.is_dir():
        raise UsageError(f"{path} is a folder; give the name of a file")
    if path.is_file() and not force:
        raise RefusalError(f"{path} exists; --force replaces it")


def _entered(stack: ExitStack, path: Path) -> Path:
    try:
        return stack.enter_context(whole_file(path))
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        told = getattr(error, "strerror", None) or error
        reason = f"cannot write {path}: {told} ({path.parent})"
        raise UsageError(reason) from error


@contextmanager
def new_folder(folder: Path, names: Sequence[str], *, force: bool) -> Iterator[list[Path]]:
    """Give files of a folder to write, as `new_files`; other files in the folder stay."""
    # The folder is made if it is not there, with those above it, and taken away if the block fails.
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder} is a file; give the name of a folder")
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    with undone_unless_finished(lambda: _remove_empty(missing)):
        folder.mkdir(parents=True, exist_ok=True)
        with new_files([folder / name for name in names], force=force) as paths:
            yield paths


def _remove_empty(folders: Sequence[Path]) -> None:
    for each in folders:
        with suppress(OSError):  # not made, or somebody else uses it by now
            each.rmdir()


def document(command: str, parameters: Mapping[str, Any], result: Mapping[str, Any]) -> str:
    """Write one JSON document; numbers keep every digit, NaN and infinities become null."""
    lists = {name: as_list(column) for name, column in result.items()}
    content = {"schema": SCHEMA, "command": command, "parameters": parameters, "result": lists}
    return msgspec.json.encode(content).decode() + "\n"


def error_document(command: str, error: BaseException) -> str:
    """Write the reason for a failure in the same form."""
    reason = {"type": type(error).__name__, "message": shortened(told_as(error))}
    content = {"schema": SCHEMA, "command": command, "error": reason}
    return msgspec.json.encode(content).decode() + "\n"


def show_table(columns: Mapping[str, Any]) -> None:
    """Print columns to stdout: a table for eyes on a terminal, CSV into a pipe."""
    if not sys.stdout.isatty():
        write_csv(sys.stdout, columns)
        return
    from rich.console import Console
    from rich.table import Table

    from stickslip.results.table import aligned

    shown = {name: as_list(columns[name]) for name in columns if name not in MACHINE_ONLY}
    names = [name.removesuffix("_name") for name in shown]
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name, cells in zip(names, shown.values(), strict=True):
        text = any(isinstance(cell, str) for cell in cells)
        table.add_column(
            name, justify="left" if text else "right", overflow="fold", no_wrap=not text
        )
    rows = list(zip(*shown.values(), strict=True))
    told = [[str(flat(cell, "{:.6g}".format)) for cell in row] for row in rows[:TABLE_ROWS]]
    for row in told:
        table.add_row(*row)
    console = Console(highlight=False)
    unbounded = console.options.update(width=sys.maxsize)
    if not told or console.measure(table, options=unbounded).minimum <= console.width:
        console.print(table)
    else:  # a row below the other: numbers in pieces cannot be read
        blocks = ("\n".join(aligned(zip(names, row, strict=True), "<<")) for row in told)
        print("\n\n".join(blocks))
    if len(rows) > TABLE_ROWS:
        console.print(f"... {len(rows) - TABLE_ROWS} more rows; a pipe or a file gets all")


def draw_pictures(plot: Callable[[Axes], Axes], paths: Iterable[Path]) -> None:
    """Draw a result with its ``plot`` into files; each file's name tells its format."""
    from stickslip.plot.style import pictured, save, style

    with style():
        figure = pictured(plot, PICTURE_HEIGHT)
        for path in paths:
            save(figure, path.with_suffix(""), (path.suffix.removeprefix("."),))


Item = TypeVar("Item")

MOST_NOTES = 20


def tracked(items: Sequence[Item], what: str) -> Iterator[Item]:
    """Pass `items` on, and tell which share of them is done."""
    with waiting(what) as tell:
        for done, item in enumerate(items, start=1):
            yield item
            if tell is not None:
                tell(done / len(items))


class Spoken:
    """How arguments of Python are called on the command line."""

    options: Callable[[], Mapping[str, str]] = dict  # of the command that runs, by argument


def in_options(text: str) -> str:
    """Name the options of a message's arguments, and the arguments that have none."""
    options = Spoken.options() if "=" in text or "_" in text else {}
    lacking: list[str] = []

    def told(found: re.Match[str]) -> str:
        name, given, after = found["name"], found["given"], found.string[found.end() :]
        if name in options and (given or found["at"] or "_" in name):
            words = [options[name], *re.findall(r"\['(.*?)'\]", found["at"])]
            value = after[:1].strip(")],.; ")
            return " ".join(words) + " " * bool(value and given.strip() == "=")
        # With a number behind it, alpha=1.2, it is what a model has.
        if name and given.startswith("=") and not re.match(r"-?\.?\d", after):
            lacking.append(f"{name}=")
        return found[0]

    text = _without_python(ARGUMENT.sub(told, text))
    missing = ", ".join(dict.fromkeys(lacking))
    return f"{text} ({missing} is for Python; this command has no such option)" if lacking else text


def _without_python(text: str) -> str:
    return KIND.sub("", without_clauses(text, PARTS))


@contextmanager
def of_file() -> Iterator[None]:
    """Repeat what is wrong in a file in the file's words: its keys are no options."""
    try:
        yield
    except ValueError as error:
        raise UsageError(_without_python(str(error))) from error


def told_as(error: BaseException) -> str:
    """Repeat an error in words of the command line, which the program's own errors have."""
    if isinstance(error, OSError) and error.filename is not None:
        return f"cannot use {error.filename}: {error.strerror}"
    own = isinstance(error, CommandError | CycloptsError)
    return str(error) if own else in_options(str(error))


def note(text: str, *, quiet: bool) -> None:
    """Say something beside the result."""
    if not quiet:
        print(f"stickslip: {in_options(text)}", file=sys.stderr)


def notes(texts: Sequence[str], what: str, *, quiet: bool) -> None:
    """Say several things beside the result; of many the first ones, and how many more there are."""
    for text in texts[:MOST_NOTES]:
        note(text, quiet=quiet)
    if len(texts) > MOST_NOTES:
        note(f"{len(texts) - MOST_NOTES} more {what}", quiet=quiet)
