"""What a study computes and says: numbers beside the printed ones, claims and their verdicts."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from decimal import Decimal
from typing import Any, Final, Literal, TypeAlias

SCHEMA = 1
Verdict: TypeAlias = Literal["holds", "holds with a correction", "does not hold", "undecided"]
VERDICTS: Final[tuple[Verdict, ...]] = (
    "holds",
    "holds with a correction",
    "does not hold",
    "undecided",
)


def digits(number: float, error: float) -> str:
    """Write a number to the decimal place of its error; with all 17 digits if that is 0."""
    if not math.isfinite(number) or not math.isfinite(error):
        return f"{number:.17g}"
    places = 17 if error <= 0.0 else min(17, max(0, math.ceil(-math.log10(error))))
    return f"{number:.{places}f}"


def with_error(number: float, error: float) -> str:
    """Write a number to the decimal place of its error, and the error."""
    return f"{digits(number, error)} ± {error:.0e}"


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
    head = ("figure", "value", "printed", "computed", "error", "agrees", "how")
    lines = table(head, map(_row, values))
    notes = [f"- {value.name}: {value.note}" for value in values if value.note]
    lines += ["", "Notes", "", *notes] if notes else []
    if any(value.printed for value in values):
        lines += ["", 'A printed number "agrees" within one unit of its last digit.']
    return lines


def _row(value: Value) -> tuple[object, ...]:
    agrees = {True: "yes", False: "**no**", None: ""}[value.agrees]
    error = f"{value.error:.0e}"
    return (value.figure, value.name, value.printed, value.text, error, agrees, value.how)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """Write lines of a Markdown table; a bar in a text does not end its cell."""
    lines = (" | ".join(str(x).replace("|", "\\|") for x in row) for row in (head, *rows))
    first, *rest = (f"| {line} |" for line in lines)
    return [first, "|" + "---|" * len(head), *rest]


@dataclass(frozen=True)
class Finding:
    """One thing that a claim says, put so that a computed quantity decides it."""

    says: str  # what would have to be the case
    found: str  # what is, in words and numbers; true whether or not `passed`
    passed: bool
    essential: bool = True  # else a detail: without it the claim holds with a correction

    def __post_init__(self) -> None:
        """Make a comparison of array elements a bool of Python's own."""
        object.__setattr__(self, "passed", bool(self.passed))


@dataclass(frozen=True)
class Claim:
    """Something that the paper says of its systems."""

    key: str  # short and unique, such as "coulomb.u4"
    figure: int  # beside which it stands; 0 until the study's table of claims says which
    place: str  # section and paragraph
    statement: str  # what is claimed, in our words
    findings: tuple[Finding, ...] = ()  # all that the verdict depends on besides printed numbers
    # numbers that the claim is about; the printed ones have to agree
    values: tuple[Value, ...] = ()
    mechanism: str = ""  # what happens in the motion
    note: str = ""  # what a reader should know beside the evidence
    undecided: str = ""  # why no verdict is possible; empty where one is

    def __post_init__(self) -> None:
        """Refuse a claim that nothing could refute."""
        decisive = [*self.findings, *(value for value in self.values if value.printed)]
        if not (decisive or self.undecided):
            raise ValueError(f"claim {self.key!r}: nothing decides it")

    @property
    def verdict(self) -> Verdict:
        """What the findings and the printed numbers amount to."""
        if self.undecided:
            return "undecided"
        if not all(finding.passed for finding in self.findings if finding.essential):
            return "does not hold"
        details = (finding.passed for finding in self.findings)
        numbers = (value.agrees is not False for value in self.values)
        return "holds" if all(details) and all(numbers) else "holds with a correction"

    @property
    def evidence(self) -> str:
        """Everything that was found, in a few sentences."""
        found = [finding.found for finding in self.findings]
        return "; ".join([*found, *map(_in_words, self.values)]) or self.undecided

    @property
    def line(self) -> str:
        """Verdict, figure and statement."""
        return f"{self.verdict:23s}  figure {self.figure:<2d}  {self.statement}"


def claim(
    key: str,
    place: str,
    statement: str,
    *findings: Finding,
    values: tuple[Value, ...] = (),
    mechanism: str = "",
    note: str = "",
) -> Claim:
    """Make a claim that something decides, for a study's table, which tells its figure."""
    return Claim(key, 0, place, statement, findings, values, mechanism, note)


def _in_words(value: Value) -> str:
    text = f"{value.name} = {value.text} ± {value.error:.0e}"
    return f"{text} (printed: {value.printed})" if value.printed else text
