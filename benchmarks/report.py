"""Tables of a benchmark run: printed when it ends, and kept as JSON and Markdown."""

from __future__ import annotations

import json
import os
import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"
PACKAGES = ("stickslip", "numba", "numpy", "scipy")
PEERS = ("CyRK", "diffrax", "heyoka", "jax", "scikit-sundae")


class Report:
    """Rows by table, in the order in which they were measured."""

    def __init__(self) -> None:
        self.tables: dict[str, list[dict[str, Any]]] = {}

    def add(self, table: str, **row: Any) -> None:
        """One more row; its names are the columns' heads."""
        self.tables.setdefault(table, []).append(row)

    def markdown(self) -> str:
        """All tables."""
        return "\n\n".join(f"### {title}\n\n{_table(rows)}" for title, rows in self.tables.items())

    def save(self) -> Path:
        """Write ``results/latest.json`` and ``results/latest.md``; returns their folder."""
        RESULTS.mkdir(exist_ok=True)
        document = {"machine": machine(), "tables": self.tables}
        (RESULTS / "latest.json").write_text(json.dumps(document, indent=2) + "\n")
        (RESULTS / "latest.md").write_text(self.markdown() + "\n")
        return RESULTS


def machine() -> dict[str, Any]:
    """Tell what the numbers depend on."""
    versions = {}
    for name in (*PACKAGES, *PEERS):
        with suppress(PackageNotFoundError):
            versions[name] = version(name)
    return {
        "architecture": platform.machine(),
        "cores": len(os.sched_getaffinity(0))
        if hasattr(os, "sched_getaffinity")
        else os.cpu_count(),
        "load": [round(load, 2) for load in os.getloadavg()] if hasattr(os, "getloadavg") else None,
        "python": platform.python_version(),
        **versions,
    }


def _table(rows: list[dict[str, Any]]) -> str:
    heads = list(dict.fromkeys(head for row in rows for head in row))
    cells = [heads, *([_text(row.get(head, "")) for head in heads] for row in rows)]
    widths = [max(len(line[i]) for line in cells) for i in range(len(heads))]
    cells.insert(1, ["-" * width for width in widths])
    lines = ("| " + " | ".join(_padded(line, widths)) + " |" for line in cells)
    return "\n".join(lines)


def _padded(line: list[str], widths: list[int]) -> list[str]:
    return [text.ljust(width) for text, width in zip(line, widths, strict=True)]


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.0f}" if 1000 <= abs(value) < 1e7 else f"{value:.3g}"
    return str(value)
