"""Studies are found by name, computed by one command, and say what they have not read."""

from __future__ import annotations

import json

import pytest

from stickslip import studies
from stickslip.cli import main
from stickslip.studies import figures

NAMES = [source.name for source in studies.sources()]


def test_the_paper_is_one_of_the_studies() -> None:
    assert "galvanetto2001" in NAMES
    assert NAMES == sorted(NAMES)


@pytest.mark.parametrize("source", studies.sources(), ids=lambda source: source.name)
def test_a_study_has_figures_each_with_what_drawing_needs(source: studies.Source) -> None:
    found = figures.of_study(source.package)
    assert list(found) == list(range(1, len(found) + 1))
    for figure in found.values():
        assert figure.columns in {"one", "two"}
        assert 1.0 <= figure.height <= 7.0
        assert callable(figure.draw)


def test_an_unknown_study_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="quasistatic"):
        studies.source_named("quasistatics")


def test_the_list_names_every_study(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "--list"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in NAMES)
    assert main(["study", "--list", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["name"] == NAMES


def test_without_a_name_it_says_how_to_find_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study"]) == 2
    assert "--list" in capsys.readouterr().err


def test_a_study_writes_what_reproduce_writes(tmp_path, capsys) -> None:
    command = ["study", "quasistatic", "1", "--out", str(tmp_path), "--json", "--check"]
    assert main(command) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["parameters"]["name"] == "quasistatic"
    assert set(document["result"]["verdict"]) == {"holds"}
    written = {path.name for path in tmp_path.iterdir()}
    assert {"fig01.svg", "report.md", "values.json"} <= written
    assert "Huang and Turcotte" in (tmp_path / "report.md").read_text(encoding="utf-8")
