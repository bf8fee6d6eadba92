"""A study's diagram as theorems: what is proven, what is not and why."""

import json
from fractions import Fraction

import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from stickslip.cli import main
from stickslip.proofs.certificate import refusal
from stickslip.proofs.verify.check import check_text
from stickslip.studies.galvanetto2001 import proven as figure_4
from stickslip.studies.proven import prove

STAR = Fraction("0.0369759235203076")


def nothing(*_, **__):
    return refusal("the box is too wide", 10)


def test_what_is_not_proven_is_said_with_the_reason(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(figure_4, "certify_orbits", nothing)
    monkeypatch.setattr(figure_4, "certify_branch", nothing)
    out = str(tmp_path / "proven")
    assert main(["study", "galvanetto2001", "--proven", "--out", out, "--json", "--check"]) == 4
    told = json.loads(capsys.readouterr().out)["result"]
    assert told["proven"] == [False, False]
    text = (tmp_path / "proven" / "proven.txt").read_text()
    assert text.count("Nothing is proven: the box is too wide.") == 2
    assert "not proven: what follows S4" in text
    assert not list(tmp_path.glob("**/*.json"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["leine1998", "--proven"], "of galvanetto2001 it is"),
        (["galvanetto2001", "4", "--proven"], "takes no figure numbers"),
    ],
)
def test_what_cannot_be_asked_is_an_error(arguments, message, capsys):
    assert main(["study", *arguments]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_figure_4_down_to_2e_4_beyond_the_loss_of_s4(tmp_path, monkeypatch):
    monkeypatch.setattr(figure_4, "BEYOND", Fraction("0.0002"))
    monkeypatch.setattr(figure_4, "certify_orbits", nothing)  # it has tests of its own
    done = prove("galvanetto2001", tmp_path)
    assert [each.name for each in done.proofs] == ["fixed-points", "S4", "P55"]
    star, share = figure_4.covered(done.proofs)
    assert abs(star - STAR) < Fraction(1, 10**11)
    assert share == 1
    for path in tmp_path.glob("*.json"):
        assert check_text(path.read_text())
    assert {path.name for path in done.files} >= {"S4.json", "P55.json", "proven.svg", "proven.txt"}
