"""A paper's claims beside what was found: for the terminal, for programs, and as Markdown."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from textwrap import wrap
from typing import Any, Final

from stickslip.studies.claim import (
    VERDICTS,
    Claim,
    Finding,
    Value,
    Verdict,
    table,
    value_rows,
    value_table,
)

SCHEMA: Final = 1
WIDTH: Final = 110  # of the terminal's lines below a claim
INDENT: Final = " " * 25
MARK: Final = {True: "yes", False: "**no**"}


@dataclass(frozen=True)
class Report:
    """What became of a paper's claims and numbers."""

    source: str  # author and year
    title: str  # what was published or studied
    claims: tuple[Claim, ...]  # by figure, in the order of the paper
    values: tuple[Value, ...]  # every number that was computed
    # of the figures drawn, with the parameters that were chosen
    captions: Mapping[int, str] = field(default_factory=dict)
    pictures: Mapping[int, str] = field(default_factory=dict)  # paths relative to the report

    def counts(self) -> dict[Verdict, int]:
        """How many claims have which verdict."""
        verdicts = [claim.verdict for claim in self.claims]
        return {verdict: verdicts.count(verdict) for verdict in VERDICTS}

    def text(self) -> str:
        """Lines for a terminal: a claim, its verdict, and where it fails, why."""
        lines = [f"{self.source}: {_summary(self.counts())}", ""]
        for claim in self.claims:
            lines.append(claim.line)
            for reason in _objections(claim):
                lines += wrap(reason, WIDTH, initial_indent=INDENT, subsequent_indent=INDENT)
        return "\n".join(lines) + "\n"

    def as_json(self) -> str:
        """Document for programs; numbers in full precision, NaN as null."""
        figures = sorted({*self.captions, *self.pictures})
        document: dict[str, Any] = {
            "schema": SCHEMA,
            "kind": "paper report",
            "version": version("stickslip"),
            "source": self.source,
            "verdicts": self.counts(),
            "claims": [_claim_row(claim) for claim in self.claims],
            "values": value_rows(self.values),
            "figures": {
                str(n): {"caption": self.captions.get(n, ""), "picture": self.pictures.get(n, "")}
                for n in figures
            },
        }
        return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n"

    def as_markdown(self) -> str:
        """Page for readers: figure by figure the picture, the claims and the evidence."""
        lines = [f"# {self.source}, “{self.title}”: checked", ""]
        if self.claims:
            lines += [f"{_summary(self.counts())}.", "", *_overview(self.claims), ""]
        for number in sorted({claim.figure for claim in self.claims} | {*self.captions}):
            lines += [f"## Figure {number}", "", *self._picture(number)]
            for claim in self.claims:
                if claim.figure == number:
                    lines += _section(claim)
        if self.values:
            lines += ["## Numbers", "", *value_table(self.values)]
        return "\n".join(lines).rstrip() + "\n"

    def _picture(self, number: int) -> Iterator[str]:
        path, caption = self.pictures.get(number), self.captions.get(number)
        if path:
            embed = "" if path.endswith(".pdf") else "!"
            yield from (f"{embed}[Figure {number}]({path})", "")
        if caption:
            yield from (caption, "")


def _summary(counts: Mapping[Verdict, int]) -> str:
    """Count the verdicts in words."""
    parts = [f"{n} {_of(n, verdict)}" for verdict, n in counts.items() if n]
    total = sum(counts.values())
    return f"{total} claim{'s' * (total != 1)}: {', '.join(parts)}" if parts else "no claims"


def _of(n: int, verdict: str) -> str:
    """Put a verdict into the plural where it is about several claims."""
    if n == 1:
        return verdict
    return verdict.replace("holds", "hold").replace("does not", "do not")


def _objections(claim: Claim) -> list[str]:
    """Say what keeps a claim from holding as it stands."""
    found = [f"{f.says}: no; {f.found}" for f in claim.findings if not f.passed]
    numbers = [
        f"{value.name}: printed {value.printed}, computed {value.text}"
        for value in claim.values
        if value.agrees is False
    ]
    return [*found, *numbers, *([claim.undecided] if claim.undecided else [])]


def _overview(claims: tuple[Claim, ...]) -> list[str]:
    rows = ((claim.figure, claim.statement, _verdict(claim)) for claim in claims)
    return table(("figure", "claim", "verdict"), rows)


def _section(claim: Claim) -> Iterator[str]:
    """One claim with its evidence."""
    yield from (f"**{claim.statement}** ({claim.place})", "")
    yield from (f"Verdict: {_verdict(claim)}.", "")
    if claim.undecided:
        yield from (claim.undecided, "")
    if claim.findings:
        yield from table(("the claim says", "found", "agrees"), map(_finding_row, claim.findings))
        yield ""
    if claim.values:
        yield from value_table(claim.values)
        yield ""
    if claim.mechanism:
        yield from (f"Mechanism: {claim.mechanism}.", "")
    if claim.note:
        yield from (claim.note, "")


def _finding_row(finding: Finding) -> tuple[str, ...]:
    agrees = MARK[finding.passed] + ("" if finding.essential else " (a detail)")
    return (finding.says, finding.found, agrees)


def _verdict(claim: Claim) -> str:
    return claim.verdict if claim.verdict == "holds" else f"**{claim.verdict}**"


def _claim_row(claim: Claim) -> dict[str, Any]:
    row = {**asdict(claim), "verdict": claim.verdict, "evidence": claim.evidence}
    return row | {"values": value_rows(claim.values)}
