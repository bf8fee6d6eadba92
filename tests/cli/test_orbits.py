"""``stickslip orbits`` end to end: the library's orbits, a row for each point."""

import csv
import io
import json

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main, maps

FIELDS = ["orbit", "period", "kind", "multiplier", "point", "d", "error", "itinerary"]


@pytest.fixture(scope="module")
def found():
    return ss.periodic_orbits(ss.examples.coulomb(), 4, infinitely_unstable=True)


def test_json_carries_every_orbit_to_the_last_digit(capsys, found):
    command = "orbits --preset coulomb --max-period 4 --infinitely-unstable --json"
    assert main(command.split()) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    document = json.loads(captured.out)
    assert (document["schema"], document["command"]) == (1, "orbits")
    asked = {"V": 0.0366, "max_period": 4, "infinitely_unstable": True, "resolution": 1e-9}
    assert document["parameters"].items() >= asked.items()
    result = document["result"]
    assert list(result) == FIELDS
    assert result["d"] == np.concatenate([orbit.points for orbit in found]).tolist()
    assert (
        result["orbit"] == np.repeat(np.arange(len(found)) + 1, [o.period for o in found]).tolist()
    )
    crosses_a_jump = [kind == "infinitely unstable" for kind in result["kind"]]
    assert [m is None for m in result["multiplier"]] == crosses_a_jump  # JSON has no infinity
    assert any(crosses_a_jump)


def test_csv_reads_back_exactly(tmp_path, capsys, found):
    path = tmp_path / "orbits.csv"
    command = f"orbits --preset coulomb --period 4 --infinitely-unstable --out {path}"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == f"{path}\n"
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert list(rows[0]) == FIELDS
    assert {row["period"] for row in rows} == {"4"}
    expected = [d for orbit in found.of_period(4) for d in orbit.points]
    assert [float(row["d"]) for row in rows] == expected
    assert [row["point"] for row in rows] == ["1", "2", "3", "4"] * (len(rows) // 4)
    assert all(float(row["error"]) < 1e-13 for row in rows)
    kinds = [orbit.kind for orbit in found.of_period(4)]
    assert [row["kind"] for row in rows[::4]] == kinds
    assert {row["multiplier"] for row in rows if row["kind"] != "stable"} == {"inf"}


def test_fixed_points_are_the_default(capsys):
    assert main("orbits --preset coulomb".split()) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    f = ss.event_map(ss.examples.coulomb())
    assert [round(float(row["d"]), 4) for row in rows] == [-0.0399, 0.0886, 0.3716]
    assert [row["kind"] for row in rows] == ["stable", "unstable", "unstable"]
    assert [row["itinerary"] for row in rows] == [f.itinerary(float(row["d"])) for row in rows]


def test_a_list_that_is_not_complete_fails_and_says_what_is_open(found, capsys):
    """Few maps come here within seconds, so the ending is asked alone."""
    from dataclasses import replace

    from stickslip.analysis.branches.discontinuities import Unresolved
    from stickslip.analysis.orbits.orbit import NearFold

    near = NearFold(3, 0.25, 1e-17, resolved=False)
    reason = Unresolved("more than 1000 pieces:", -0.6, 0.6, 4)
    cut = replace(found, complete=3, near_folds=(near,), unresolved=(reason,))
    assert maps._orbit_ending(cut, quiet=False) == 1
    error = capsys.readouterr().err
    assert "period 3 at d = 0.25" in error
    assert "more than 1000 pieces: [-0.6, 0.6], period 4" in error
    assert maps._orbit_ending(found, quiet=False) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--max-period 0", ["max_period", "0", "from 1 to"]),
        ("--period -2", ["period", "-2", "from 1 to"]),
        ("--period 2 --max-period 3", ["--period", "--max-period"]),
        ("--max-period 1.5", ["--max-period", "1.5", "whole number"]),
        ("--period many", ["--period", "many"]),
        ("--resolution 0", ["resolution", "0", "positive"]),
        ("--resolution nan", ["resolution", "nan", "finite"]),
        ("--V 0", ["V", "> 0"]),
        ("--max-events 0", ["max_events", ">= 1"]),
        ("--out nowhere/orbits.csv", ["nowhere"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_names_what_came_and_leaves_no_file(
    options, fragments, as_json, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    command = f"orbits --preset coulomb {options}".split()
    command += [] if "--out" in options else ["--out", "orbits.csv"]
    assert main(command + ["--json"] * as_json) == 2
    captured = capsys.readouterr()
    message = json.loads(captured.out)["error"]["message"] if as_json else captured.err
    assert (captured.err if as_json else captured.out) == ""
    assert "Traceback" not in message
    for fragment in fragments:
        assert fragment in message
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_replaced_only_by_force(tmp_path, capsys):
    path = tmp_path / "orbits.csv"
    path.write_text("precious")
    assert main(["orbits", "--preset", "coulomb", "--out", str(path)]) == 3
    assert path.read_text() == "precious"
    assert "--force" in capsys.readouterr().err
