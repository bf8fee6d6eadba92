"""Compare the ratios of the last benchmark run with the committed ones; times are not compared.

    python -m benchmarks.guard

Reads ``results/latest.json`` and ``ratios.json``: for a row of a table, found by some of its cells,
the least that a column may show. The bands are generous, a third to a half below what was measured,
because ratios vary by that much on a busy machine. Exit code 1 if one is missed; rows that
were not measured are named.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from benchmarks.report import RESULTS

RATIOS = Path(__file__).parent / "ratios.json"


def compare(tables: dict[str, list[dict[str, Any]]], ratios: list[dict[str, Any]]) -> list[str]:
    """One line for each ratio; those that are missed begin with "MISSED"."""
    lines = []
    for ratio in ratios:
        where = f"{ratio['table']}, {', '.join(map(str, ratio['row'].values()))}"
        found = [
            row[ratio["column"]]
            for row in tables.get(ratio["table"], [])
            if all(row.get(key) == value for key, value in ratio["row"].items())
        ]
        if not found:
            lines.append(f"not measured  {where}")
            continue
        word = "MISSED" if found[-1] < ratio["least"] else "ok"
        wanted = f"{ratio['column']}: {found[-1]:.3g}, at least {ratio['least']}"
        lines.append(f"{word:12}  {where}: {wanted}")
    return lines


def main() -> int:
    """Print the comparison."""
    tables = json.loads((RESULTS / "latest.json").read_text())["tables"]
    lines = compare(tables, json.loads(RATIOS.read_text()))
    print("\n".join(lines))
    return 1 if any(line.startswith("MISSED") for line in lines) else 0


if __name__ == "__main__":
    sys.exit(main())
