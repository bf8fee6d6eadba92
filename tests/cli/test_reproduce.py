"""``stickslip reproduce`` end to end; what the figures show is tested in tests/studies."""

import json

import pytest

from stickslip import studies
from stickslip.cli import main
from stickslip.studies.claim import Claim, Finding
from stickslip.studies.report import Report
from stickslip.studies.reproduction import Reproduction

FIGURE_2 = [
    "fig02.pdf",
    "fig02.png",
    "fig02.svg",
    "report.json",
    "report.md",
    "values.json",
    "values.md",
]


def test_it_writes_figures_and_values_and_owns_only_its_files(tmp_path, capsys):
    out = tmp_path / "new" / "out"
    assert main(["reproduce", "2", "--out", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == FIGURE_2
    printed = capsys.readouterr().out.partition("\n\n")[0].splitlines()
    assert sorted(printed) == [str(out / name) for name in FIGURE_2]
    first = {path.name: path.read_bytes() for path in out.iterdir()}

    (out / "notes.txt").write_text("mine")
    (out / "fig02.svg").write_text("spoiled")
    assert main(["reproduce", "2", "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["parameters"] == {"figures": [2]}
    assert sorted(document["result"]["file"]) == [str(out / name) for name in FIGURE_2]
    claims = json.loads((out / "report.json").read_text())["claims"]
    for name in ("key", "figure", "statement", "verdict", "evidence"):
        assert document["result"][name] == [claim[name] for claim in claims]
    assert (out / "notes.txt").read_text() == "mine"
    assert {name: (out / name).read_bytes() for name in FIGURE_2} == first


def test_the_table_of_values_is_json(tmp_path):
    assert main(["reproduce", "2", "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / "values.json").read_text())


def test_each_claim_has_a_line_with_its_verdict(tmp_path, capsys):
    assert main(["reproduce", "2", "--out", str(tmp_path), "--check"]) == 0
    lines = capsys.readouterr().out.partition("\n\n")[2].splitlines()
    claims = json.loads((tmp_path / "report.json").read_text())["claims"]
    assert len(claims) > 1
    for claim in claims:
        (line,) = (line for line in lines if claim["statement"] in line)
        assert line.startswith(claim["verdict"])


@pytest.mark.parametrize(("passed", "code"), [(True, 0), (False, 4)])
def test_check_fails_where_a_claim_does(passed, code, tmp_path, capsys, monkeypatch):
    finding = Finding("figure 2 shows a cube", "it shows a plane", passed)
    claim = Claim("cube", 2, "2", "The world is a cube", (finding,))
    report = Report("Author (2000)", "Title", (claim,), ())
    answer = Reproduction((tmp_path / "report.md",), (), report)
    monkeypatch.setattr(studies, "reproduce", lambda *_, **__: answer)
    assert main(["reproduce", "2", "--out", str(tmp_path)]) == 0
    assert main(["reproduce", "2", "--out", str(tmp_path), "--check"]) == code
    printed = capsys.readouterr().out
    assert "The world is a cube" in printed
    assert ("it shows a plane" in printed) != passed


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["99"], "99"),
        (["2", "--out", "/dev/null/out"], "/dev/null"),
        (["2", "--out", "file"], "folder"),
    ],
)
def test_bad_input_writes_nothing(arguments, fragment, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    assert main(["reproduce", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert fragment in captured.err
    assert "Traceback" not in captured.err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
