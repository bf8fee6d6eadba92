"""Columns of numbers as a JSON document, a CSV file or a table on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import msgspec

from stickslip.cli.failure import shortened
from stickslip.results.table import as_list, flat, write_csv

SCHEMA = 1
TABLE_ROWS = 40
# Columns that a reader on a terminal has in another form or cannot use.
MACHINE_ONLY = {"label", "status"}


def document(command: str, parameters: Mapping[str, Any], result: Mapping[str, Any]) -> str:
    """Write one JSON document; numbers keep every digit, NaN and infinities become null.

    `result` holds columns by name, or what JSON can say as it is.
    """
    lists = {name: as_list(column) for name, column in result.items()}
    content = {"schema": SCHEMA, "command": command, "parameters": parameters, "result": lists}
    return msgspec.json.encode(content).decode() + "\n"


def error_document(command: str, error: BaseException) -> str:
    """Write the reason for a failure in the same form."""
    reason = {"type": type(error).__name__, "message": shortened(str(error))}
    content = {"schema": SCHEMA, "command": command, "error": reason}
    return msgspec.json.encode(content).decode() + "\n"


def show(columns: Mapping[str, Any]) -> None:
    """Print columns to stdout: a table for eyes on a terminal, CSV into a pipe."""
    if not sys.stdout.isatty():
        write_csv(sys.stdout, columns)
        return
    from rich.console import Console
    from rich.table import Table

    shown = {name: as_list(columns[name]) for name in columns if name not in MACHINE_ONLY}
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name, cells in shown.items():
        text = any(isinstance(cell, str) for cell in cells)
        table.add_column(
            name.removesuffix("_name"), justify="left" if text else "right", overflow="fold"
        )
    rows = list(zip(*shown.values(), strict=True))
    for row in rows[:TABLE_ROWS]:
        table.add_row(*(str(flat(cell, _short)) for cell in row))
    console = Console(highlight=False)
    console.print(table)
    if len(rows) > TABLE_ROWS:
        console.print(f"... {len(rows) - TABLE_ROWS} more rows; a pipe or a file gets all")


def _short(number: float) -> str:
    return f"{number:.6g}"
