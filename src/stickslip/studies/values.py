"""Numbers beside the paper's: what is computed, how well, and whether the two agree."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Any

from stickslip.studies.digits import digits

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

SCHEMA = 1


@dataclass(frozen=True)
class Value:
    """One computed number."""

    name: str  # short and unique, such as "V at the collision of S4"
    computed: float
    error: float  # estimate of the absolute error
    figure: int  # of the paper, to which it belongs
    how: str  # which equation was solved
    printed: str = ""  # as the paper prints it; empty if it does not
    note: str = ""  # what a reader should know, such as why the two differ

    @property
    def agrees(self) -> bool | None:
        """Whether the printed number is within one unit of its own last digit; None without one."""
        # One unit and not a half: the paper does not say whether it rounds or cuts, and reads some
        # values off a diagram ("approximately").
        if not self.printed:
            return None
        printed = Decimal(self.printed)
        unit = 10.0 ** int(printed.as_tuple().exponent)
        return abs(self.computed - float(printed)) <= unit + self.error

    @property
    def text(self) -> str:
        """The computed number, to the decimal place of its error."""
        return digits(self.computed, self.error)


def as_json(values: Sequence[Value], captions: Mapping[int, str], source: str) -> str:
    """Document for programs; numbers in full precision, NaN as null."""
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "source": source,
        "figures": {str(number): caption for number, caption in captions.items()},
        "values": value_rows(values),
    }
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def as_markdown(values: Sequence[Value], captions: Mapping[int, str], source: str) -> str:
    """Table for readers; as many digits as the error allows."""
    lines = [f"# Values of {source}, computed", ""]
    if values:
        lines += [*value_table(values), ""]
    lines += ["## Figures", ""]
    lines += [f"**Figure {number}.** {caption}\n" for number, caption in captions.items()]
    return "\n".join(lines)


def value_rows(values: Sequence[Value]) -> list[dict[str, Any]]:
    """Turn values into plain data for a document; numbers that are not finite become None."""
    rows = [{**asdict(value), "agrees": value.agrees} for value in values]
    for row in rows:
        row |= {key: None for key in ("computed", "error") if not math.isfinite(row[key])}
    return rows


def value_table(values: Sequence[Value]) -> list[str]:
    """Write values, at least one, as lines of a Markdown table, with the notes below it."""
    lines = ["| figure | value | printed | computed | error | agrees | how |"]
    lines += ["|---|---|---|---|---|---|---|"]
    lines += [_row(value) for value in values]
    notes = [f"- {value.name}: {value.note}" for value in values if value.note]
    lines += ["", "Notes", "", *notes] if notes else []
    if any(value.printed for value in values):
        lines += ["", 'A printed number "agrees" within one unit of its last digit.']
    return lines


def _row(value: Value) -> str:
    agrees = {True: "yes", False: "**no**", None: ""}[value.agrees]
    error = f"{value.error:.0e}"
    cells = [value.figure, value.name, value.printed, value.text, error, agrees]
    return "| " + " | ".join(map(str, [*cells, value.how])) + " |"
