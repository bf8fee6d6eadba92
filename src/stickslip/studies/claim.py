"""Claims of a paper: what it says, what was found, and the verdict that follows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from stickslip.studies.values import Value

Verdict: TypeAlias = Literal["holds", "holds with a correction", "does not hold", "undecided"]
VERDICTS: Final[tuple[Verdict, ...]] = (
    "holds",
    "holds with a correction",
    "does not hold",
    "undecided",
)


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
    figure: int  # beside which it stands
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


def claims_by_figure(
    made: Mapping[int, Callable[[], Iterable[Claim]]], figures: Iterable[int] | None
) -> tuple[Claim, ...]:
    """Make the claims that belong to some figures, all by default, given what makes them."""
    wanted = made if figures is None else [number for number in made if number in set(figures)]
    return tuple(claim for number in wanted for claim in made[number]())


def _in_words(value: Value) -> str:
    text = f"{value.name} = {value.text} ± {value.error:.0e}"
    return f"{text} (printed: {value.printed})" if value.printed else text
