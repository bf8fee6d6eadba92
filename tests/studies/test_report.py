"""The paper's report: its JSON keeps the schema, its Markdown embeds what is there."""

import json
import re

import msgspec
import pytest

from stickslip import studies
from stickslip.studies.claim import Claim, Finding, Value
from stickslip.studies.galvanetto2001 import SOURCE, TITLE
from stickslip.studies.report import Report, _summary

pytestmark = pytest.mark.paper


class ValueRow(msgspec.Struct, forbid_unknown_fields=True):
    name: str
    computed: float | None
    error: float | None
    figure: int
    how: str
    printed: str
    note: str
    agrees: bool | None


class FindingRow(msgspec.Struct, forbid_unknown_fields=True):
    says: str
    found: str
    passed: bool
    essential: bool


class ClaimRow(msgspec.Struct, forbid_unknown_fields=True):
    key: str
    figure: int
    place: str
    statement: str
    findings: list[FindingRow]
    values: list[ValueRow]
    mechanism: str
    note: str
    undecided: str
    verdict: str
    evidence: str


class FigureRow(msgspec.Struct, forbid_unknown_fields=True):
    caption: str
    picture: str


class Document(msgspec.Struct, forbid_unknown_fields=True):
    """Schema 1 of report.json."""

    schema: int
    kind: str
    version: str
    source: str
    verdicts: dict[str, int]
    claims: list[ClaimRow]
    values: list[ValueRow]
    figures: dict[str, FigureRow]


def validated(text):
    return msgspec.json.decode(text, type=Document)


def claim(key="map.x", passed=True, figure=5, printed="0.5", **rest):
    finding = Finding("x is |1|", "x = 1 | 2", passed)
    value = Value("x", 0.5, 1e-12, figure, "g(x) = 0", printed, "read off a diagram")
    return Claim(key, figure, "section 4", f"{key} is so", (finding,), (value,), **rest)


@pytest.fixture
def report():
    claims = (
        claim("a", figure=4, mechanism="block 2 grazes"),
        claim("b", passed=False),
        claim("c", printed="0.9"),
    )
    values = tuple(value for one in claims for value in one.values)
    return Report(SOURCE, TITLE, claims, values, {5: "The map."}, {5: "fig05.svg"})


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    return folder, studies.reproduce((2, 5, 9), folder, ("svg", "png"))


def test_counts(report):
    assert report.counts() == {
        "holds": 1,
        "holds with a correction": 1,
        "does not hold": 1,
        "undecided": 0,
    }


def test_text_has_a_line_per_claim_and_says_what_fails(report):
    first, _, *lines = report.text().splitlines()
    assert (
        first == "Galvanetto (2001): 3 claims: 1 holds, 1 holds with a correction, 1 does not hold"
    )
    assert lines[0].split(maxsplit=1)[0] == "holds"
    assert "a is so" in lines[0]
    assert lines[2].strip() == "x is |1|: no; x = 1 | 2"
    assert lines[4].strip() == "x: printed 0.9, computed 0.500000000000"
    assert len(lines) == 5


def test_json_keeps_the_schema(report):
    document = validated(report.as_json())
    assert (document.schema, document.kind) == (1, "paper report")
    assert [c.verdict for c in document.claims] == [c.verdict for c in report.claims]
    assert document.figures["5"].picture == "fig05.svg"
    assert document.verdicts["does not hold"] == 1


def test_markdown_puts_claims_under_their_figures(report):
    text = report.as_markdown()
    figures = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert figures == ["Figure 4", "Figure 5", "Numbers"]
    assert "![Figure 5](fig05.svg)" in text
    assert "Verdict: **does not hold**." in text
    assert "Mechanism: block 2 grazes." in text
    # What looks like a border of a cell is none.
    assert "| x is \\|1\\| | x = 1 \\| 2 | yes |" in text


def test_a_picture_that_cannot_be_embedded_is_linked():
    text = Report(SOURCE, TITLE, (claim(),), (), {5: "The map."}, {5: "fig05.pdf"}).as_markdown()
    assert "[Figure 5](fig05.pdf)" in text
    assert "![Figure 5]" not in text


def test_an_undecided_claim_says_why():
    one = Claim("u", 5, "section 4", "x is 1", undecided="x is not defined")
    assert "x is not defined" in Report(SOURCE, TITLE, (one,), ()).text()
    assert "x is not defined" in Report(SOURCE, TITLE, (one,), ()).as_markdown()
    assert (
        validated(Report(SOURCE, TITLE, (one,), ()).as_json()).claims[0].undecided
        == "x is not defined"
    )


def test_no_claims_no_table():
    assert "|" not in Report(SOURCE, TITLE, (), (), {1: "caption"}).as_markdown()


def test_reproduce_writes_the_report_beside_the_figures(reproduced):
    folder, done = reproduced
    document = validated((folder / "report.json").read_text())
    assert {row.figure for row in document.claims} == {2, 5, 9}
    assert [row.key for row in document.claims] == [one.key for one in done.report.claims]
    assert [row.verdict for row in document.claims] == [one.verdict for one in done.report.claims]
    assert json.loads((folder / "values.json").read_text())["values"] == [
        msgspec.to_builtins(row) for row in document.values
    ]


def test_links_of_the_page_lead_to_files(reproduced):
    folder, _ = reproduced
    links = re.findall(r"\]\(([^)]+)\)", (folder / "report.md").read_text())
    assert links == ["fig02.svg", "fig05.svg", "fig09.svg"]
    assert all((folder / link).is_file() for link in links)


def test_every_claim_of_the_figures_is_on_the_page(reproduced):
    folder, done = reproduced
    text = (folder / "report.md").read_text()
    for one in done.report.claims:
        assert f"**{one.statement}** ({one.place})" in text


def test_counts_are_in_the_plural_where_they_are_of_several_claims():
    counts = {"holds": 46, "holds with a correction": 1, "does not hold": 2, "undecided": 0}
    told = "49 claims: 46 hold, 1 holds with a correction, 2 do not hold"
    assert _summary(counts) == told
    assert _summary({"holds": 1}) == "1 claim: 1 holds"
    assert _summary({"undecided": 2}) == "2 claims: 2 undecided"
