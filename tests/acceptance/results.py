"""What large samples gave, in a small table that is kept: `docs/evidence.csv`.

A row for each sample, version and day; a later run of the same adds to it, so that samples may be
taken in pieces, with seeds of their own, and nothing of a run that was stopped is lost but its last
piece.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from pathlib import Path

import stickslip as ss

TABLE = Path(__file__).parents[2] / "docs" / "evidence.csv"


@dataclass
class Row:
    """Counts of answers.

    ``excused``: the reference's itinerary changes within rounding of the start. ``undecided``:
    given up by the package or by the reference; where drivers are compared, no return by either.
    """

    sample: str
    version: str
    date: str
    answers: int
    settled: int
    wrong: int
    excused: int
    undecided: int
    seconds: int

    @property
    def key(self) -> tuple[str, str, str]:
        """What rows that are added up have in common."""
        return self.sample, self.version, self.date

    def add(self, other: Row) -> None:
        """Count another piece."""
        for name in ("answers", "settled", "wrong", "excused", "undecided", "seconds"):
            setattr(self, name, getattr(self, name) + getattr(other, name))


def read(table: Path = TABLE) -> list[Row]:
    """All rows, none if there is no table yet."""
    if not table.exists():
        return []
    with table.open(newline="") as file:
        return [
            Row(*(row[f.name] if f.type == "str" else int(row[f.name]) for f in fields(Row)))
            for row in csv.DictReader(file)
        ]


def record(
    sample: str,
    *,
    answers: int,
    settled: int,
    wrong: int,
    excused: int,
    undecided: int,
    seconds: float,
    table: Path = TABLE,
) -> None:
    """Add a piece of a sample to the table."""
    day = datetime.now(UTC).date().isoformat()
    new = Row(
        sample, ss.__version__, day, answers, settled, wrong, excused, undecided, round(seconds)
    )
    rows = read(table)
    same = [row for row in rows if row.key == new.key]
    if same:
        same[0].add(new)
    else:
        rows.append(new)
    with table.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([f.name for f in fields(Row)])
        writer.writerows([getattr(row, f.name) for f in fields(Row)] for row in rows)
