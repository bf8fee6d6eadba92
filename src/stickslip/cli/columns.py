"""Columns of numbers as a JSON document, a CSV file or a table on the terminal."""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Mapping
from typing import Any, TextIO

import msgspec

SCHEMA = 1
TABLE_ROWS = 40
# Columns that a reader on a terminal has in another form or cannot use.
MACHINE_ONLY = {"label", "status"}


def document(command: str, parameters: Mapping[str, Any], result: Mapping[str, Any]) -> str:
    """Write one JSON document; numbers keep every digit, NaN and infinities become null.

    `result` holds columns by name, or what JSON can say as it is.
    """
    lists = {name: _as_list(column) for name, column in result.items()}
    content = {"schema": SCHEMA, "command": command, "parameters": parameters, "result": lists}
    return msgspec.json.encode(content).decode() + "\n"


def error_document(command: str, error: BaseException) -> str:
    """Write the reason for a failure in the same form."""
    reason = {"type": type(error).__name__, "message": str(error)}
    content = {"schema": SCHEMA, "command": command, "error": reason}
    return msgspec.json.encode(content).decode() + "\n"


def write_csv(stream: TextIO, columns: Mapping[str, Any]) -> None:
    """Write a header and one line per row.

    Floats keep every digit, NaN is ``nan``; numbers of a list stand in one cell with spaces
    between them; None is an empty cell.
    """
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    cells = ([_flat(cell, _exact) for cell in _as_list(column)] for column in columns.values())
    writer.writerows(zip(*cells, strict=True))


def show(columns: Mapping[str, Any]) -> None:
    """Print columns to stdout: a table for eyes on a terminal, CSV into a pipe."""
    if not sys.stdout.isatty():
        write_csv(sys.stdout, columns)
        return
    from rich.console import Console
    from rich.table import Table

    shown = {name: _as_list(columns[name]) for name in columns if name not in MACHINE_ONLY}
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name, cells in shown.items():
        text = any(isinstance(cell, str) for cell in cells)
        table.add_column(
            name.removesuffix("_name"), justify="left" if text else "right", overflow="fold"
        )
    rows = list(zip(*shown.values(), strict=True))
    for row in rows[:TABLE_ROWS]:
        table.add_row(*(str(_flat(cell, _short)) for cell in row))
    console = Console(highlight=False)
    console.print(table)
    if len(rows) > TABLE_ROWS:
        console.print(f"... {len(rows) - TABLE_ROWS} more rows; a pipe or a file gets all")


def _as_list(column: Any) -> list[Any]:
    """Turn an array or any sequence into a list of Python's own numbers and strings."""
    return list(column.tolist() if hasattr(column, "tolist") else column)


def _flat(cell: Any, text: Callable[[float], str]) -> Any:
    """Write floats and lists of them by `text`; leave anything else as it is."""
    if isinstance(cell, list):
        return " ".join(text(item) for item in cell)
    if cell is None:
        return ""
    return text(cell) if isinstance(cell, float) else cell


def _exact(number: float) -> str:
    """Write every digit, of a NumPy float as of Python's."""
    return repr(float(number))


def _short(number: float) -> str:
    return f"{number:.6g}"
