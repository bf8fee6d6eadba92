"""What came out of a comparison: counts that add up, and the row that a piece adds to the table."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Self

from tests.reference.settle import EXCUSED, GAVE_UP, WRONG

from .results import record


@dataclass
class Count:
    """Answers on which two differ, those that neither gives, and what was settled."""

    endless: int = 0
    differ: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)

    def add(self, verdict: str, what: str) -> None:
        """One answer settled."""
        self.verdicts[verdict] += 1
        if verdict == WRONG:
            self.wrong.append(what)

    def merge(self, other: Self) -> None:
        """Both counts together."""
        for each in fields(self):
            setattr(self, each.name, getattr(self, each.name) + getattr(other, each.name))

    def listed(self, head: str) -> str:
        """A line, and the first answers that are wrong."""
        return "\n".join([head, *self.wrong[:30]])

    def keep(self, sample: str, answers: int, seconds: float, table: Path) -> None:
        """Add a piece to the table of results."""
        record(
            sample,
            answers=answers,
            settled=self.verdicts.total(),
            wrong=self.verdicts[WRONG],
            excused=self.verdicts[EXCUSED],
            undecided=self.endless + self.verdicts[GAVE_UP],
            seconds=seconds,
            table=table,
        )
