"""Reports of bifurcations of any system: text, JSON that keeps its schema, Markdown."""

import dataclasses
import json
import re

import msgspec
import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.lyapunov import LyapunovExponent
from stickslip.analysis.bifurcations.bifurcation import (
    Bifurcation,
    BifurcationList,
    Cascade,
    UnresolvedChange,
)
from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.analysis.bifurcations.outcome import LocalAttractor, Outcome
from stickslip.cli.report import Report, agrees
from stickslip.studies.claim import digits, with_error

CYCLE, CHAOS = LocalAttractor("periodic", 2), LocalAttractor("chaotic", 1)


class OrbitRow(msgspec.Struct, forbid_unknown_fields=True):
    kind: str
    period: int
    multiplier: float | None
    points: list[float]
    itinerary: list[str]


class AttractorRow(msgspec.Struct, forbid_unknown_fields=True):
    kind: str
    period: int
    bands: list[tuple[float, float]]
    lyapunov: float | None
    lyapunov_error: float | None


class OutcomeRow(msgspec.Struct, forbid_unknown_fields=True):
    orbits: str
    attractors: str
    text: str


class Row(msgspec.Struct, forbid_unknown_fields=True):
    kind: str
    criticality: str | None
    parameter: str
    value: float
    error: float
    period: int
    points: list[float]
    multipliers: list[float | None]
    orbits_before: list[OrbitRow]
    orbits_after: list[OrbitRow]
    attractors_before: list[AttractorRow]
    attractors_after: list[AttractorRow]
    outcome: OutcomeRow | None
    predicted_outcome: OutcomeRow | None
    as_predicted: bool | None
    mechanism: str
    block: int | None
    quality: str
    in_cascade: bool
    note: str
    interval: tuple[float | None, float | None]
    residual: float | None


class CascadeRow(msgspec.Struct, forbid_unknown_fields=True):
    periods: list[int]
    values: list[float]
    errors: list[float]
    accumulation: float | None
    error: float | None
    ratios: list[float]


class UnresolvedRow(msgspec.Struct, forbid_unknown_fields=True):
    reason: str
    lo: float
    hi: float
    period: int
    x: float | None


class Searched(msgspec.Struct, forbid_unknown_fields=True):
    max_period: int
    window: tuple[float, float] | None
    n_lists: int


class Document(msgspec.Struct, forbid_unknown_fields=True):
    """Schema 1 of a report of bifurcations."""

    schema: int
    kind: str
    version: str
    title: str
    parameter: str
    range: tuple[float, float]
    parameters: dict[str, float]
    searched: Searched
    bifurcations: list[Row]
    cascades: list[CascadeRow]
    unresolved: list[UnresolvedRow]
    outside: list[UnresolvedRow]
    picture: str


def validated(report):
    return msgspec.json.decode(report.as_json(), type=Document)


def outcome(orbits="born in pairs", before=CYCLE, after=CHAOS):
    return Outcome(orbits, after.kind, "what happens", before, after)


def chaos():
    return Attractor(
        "chaotic",
        2,
        None,
        np.array([[0.1, 0.2], [0.6, 0.7]]),
        LyapunovExponent(0.3, 1e-3, 10),
        1.0,
        0.15,
    )


def collision(**changes):
    item = Bifurcation(
        "border_collision",
        "V",
        0.0369759235203071,
        5e-15,
        4,
        np.array([-0.4, -0.2, 0.2, 0.4, 0.5]),
        multipliers=(0.7, np.inf),
        attractors_after=(chaos(),),
        outcome=outcome(),
        predicted_outcome=outcome(),
        mechanism="block 2 grazes",
        block=2,
    )
    return dataclasses.replace(item, **changes)


def listed(*items, **changes):
    found = BifurcationList(
        items, "V", (0.0, 1.0), {"alpha": 1.2, "V": 0.5}, 4, (0.1, 0.9), n_lists=24
    )
    return dataclasses.replace(found, **changes)


@pytest.fixture(scope="module")
def logistic():
    f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.2})
    return bifurcations(f, "r", (2.9, 3.1), max_period=1)


def test_text_of_a_flip(logistic):
    text = Report(logistic, title="Logistic map").text()
    assert text.startswith("Logistic map\n1 bifurcation over r in (2.9, 3.1)\n")
    assert re.search(r"^3\.0{12,}\s+\S+\s+flip \(super\)\s+1\s", text, re.MULTILINE)
    assert "1. supercritical flip of period 1 at r = 3.0000" in text
    assert "orbits after" in text
    assert "nothing: every change" in text


def test_json_of_a_flip(logistic):
    document = validated(Report(logistic, "diagram.svg"))
    assert (document.schema, document.kind) == (1, "bifurcation report")
    (row,) = document.bifurcations
    assert row.value == pytest.approx(3.0, abs=1e-12)
    assert abs(row.value - 3.0) <= 4 * row.error
    assert (row.kind, row.criticality) == ("flip", "super")
    assert [orbit.kind for orbit in row.orbits_after] == ["unstable", "stable"]
    assert [attractor.period for attractor in row.attractors_after] == [2]
    assert document.picture == "diagram.svg"


def test_parameters_and_search_are_stated():
    text = Report(listed(collision())).text()
    assert "parameters: alpha = 1.2\n" in text
    assert "searched: orbits to period 4 in the window (0.1, 0.9)" in text
    assert "complete lists of orbits at 24 values of V" in text


@pytest.mark.parametrize(
    ("predicted", "observed", "expected"),
    [
        (outcome(), outcome(), True),
        (outcome(), outcome(orbits="persist"), False),
        (outcome(), outcome(after=CYCLE), False),
        (None, outcome(), None),
        (outcome(), None, None),
    ],
)
def test_agreement_of_prediction_and_observation(predicted, observed, expected):
    item = collision(predicted_outcome=predicted, outcome=observed)
    assert agrees(item) is expected
    report = Report(listed(item))
    assert validated(report).bifurcations[0].as_predicted is expected
    word = {True: "yes", False: "no: ", None: None}[expected]
    facts = dict(re.findall(r"^   (\S.*?)  +(.*)$", report.text(), re.MULTILINE))
    if word is None:
        assert "as predicted" not in facts
    else:
        assert facts["as predicted"].startswith(word)


def test_mechanism_block_and_slopes_are_told():
    text = Report(listed(collision())).text()
    facts = dict(re.findall(r"^   (\S.*?)  +(.*)$", text, re.MULTILINE))
    assert facts["mechanism"] == "block 2 grazes"
    assert facts["block"] == "2"
    assert facts["multipliers, left and right"] == "0.7, inf"
    assert facts["attractors after"].startswith("chaotic, 2 bands [0.1, 0.2], [0.6, 0.7]")
    assert facts["orbit there"] == "-0.4, -0.2, 0.2, 0.4, ..."
    assert validated(Report(listed(collision()))).bifurcations[0].points == [
        -0.4,
        -0.2,
        0.2,
        0.4,
        0.5,
    ]


def test_numbers_that_are_not_finite_are_null():
    row = validated(Report(listed(collision()))).bifurcations[0]
    assert row.multipliers == [0.7, None]
    assert row.residual is None


def test_cascades_and_what_stayed_open():
    flips = tuple(
        collision(kind="flip", value=v, period=p) for v, p in ((0.1, 1), (0.2, 2), (0.22, 4))
    )
    cascade = Cascade(flips, 0.2254501, 1e-6, np.array([5.0]))
    change = UnresolvedChange("an orbit is lost", 0.3, 0.4, 2, 0.5)
    apart = UnresolvedChange("outside the question: period 9", 0.6, 0.7)
    report = Report(listed(cascades=(cascade,), unresolved=(change,), outside=(apart,)))
    for text in (report.text(), report.as_markdown()):
        assert "flips of the periods 1, 2, 4" in text
        assert "accumulating at 0.225450 ± 1e-06; ratios of the gaps 5" in text
        assert "between 0.3 and 0.4, period 2 near 0.5: an orbit is lost" in text
        assert "nothing: every change" not in text
        assert "Outside the question" in text
        assert "between 0.6 and 0.7: period 9" in text
    document = validated(report)
    assert document.cascades[0].periods == [1, 2, 4]
    assert document.unresolved[0].reason == "an orbit is lost"
    assert document.outside[0].reason == "outside the question: period 9"


def test_nothing_found_is_said():
    text = Report(listed()).text()
    assert text.startswith("no bifurcations over V in (0, 1)\n")
    assert validated(Report(listed())).bifurcations == []


def test_markdown_embeds_the_picture_and_escapes_cells():
    text = Report(listed(collision(mechanism="|w| vanishes")), "diagram.svg", "Mine").as_markdown()
    assert text.startswith("# Mine\n")
    assert "![Bifurcation diagram](diagram.svg)" in text
    assert "\\|w\\| vanishes" in text
    assert "![" not in Report(listed(), "diagram.pdf").as_markdown()
    assert "](" not in Report(listed()).as_markdown()


def test_every_row_of_a_markdown_table_has_as_many_cells_as_its_head():
    lines = Report(listed(collision(), collision()), "d.svg").as_markdown().splitlines()
    widths = [len(re.findall(r"(?<!\\)\|", line)) for line in lines if line.startswith("|")]
    assert set(widths) == {3, 8}


def test_documents_are_plain_json():
    assert json.loads(Report(listed(collision())).as_json())["range"] == [0.0, 1.0]


@pytest.mark.parametrize(
    ("number", "error", "text"),
    [
        (0.0369759235203071, 5e-15, "0.036975923520307"),
        (1.25, 1e-2, "1.25"),
        (1.25, 3.0, "1"),
        (float("nan"), 1e-3, "nan"),
        (0.5, 0.0, "0.50000000000000000"),
    ],
)
def test_digits_follow_the_error(number, error, text):
    assert digits(number, error) == text


def test_with_error():
    assert with_error(1.25, 1e-2) == "1.25 ± 1e-02"


def test_maps_of_the_plane_are_reported():
    # x' = 1 - a x^2 + y, y' = b x: the fixed point x = (b - 1 + s) / (2 a), where
    # s^2 = (1 - b)^2 + 4 a, flips at 4 a = 3 (1 - b)^2 with the multipliers -1 and b
    plane = ss.Map(
        lambda x, a: np.stack([1 - a * x[..., 0] ** 2 + x[..., 1], 0.1 * x[..., 0]], axis=-1),
        2,
        parameters={"a": 0.5},
        domain=[(-2, 2), (-2, 2)],
    )
    found = bifurcations(plane, "a", (0.5, 0.7), max_period=1, n_lists=2)
    report = Report(found)
    (row,) = json.loads(report.as_json())["bifurcations"]
    assert row["kind"] == "flip"
    assert row["value"] == pytest.approx(0.6075, rel=1e-12)
    assert row["multipliers"] == [pytest.approx([-1, 0], abs=1e-9), pytest.approx([0.1, 0])]
    x = 0.9 / (2 * 0.6075)
    assert row["points"] == [pytest.approx([x, 0.1 * x], rel=1e-9)]
    (before,), (_, doubled) = row["orbits_before"], row["orbits_after"]
    assert (before["period"], doubled["period"]) == (1, 2)
    assert all(abs(complex(*value)) < 1 for value in before["multipliers"])
    attractor = np.array(row["attractors_after"][0]["points"])
    assert attractor == pytest.approx(np.array(doubled["points"]), rel=1e-9)
    assert f"orbit there        ({x:.4f}" in report.text()
    assert "lists, which may lack some, of orbits at 2 values" in report.text()
    assert (
        "the last half of these lists found 1 of 1 known orbits again, and 0 new" in report.text()
    )
    assert "nothing: every change" not in report.text()
    assert "nothing of what lists show; they may lack orbits" in report.text()
