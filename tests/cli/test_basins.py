"""``stickslip basins`` end to end: the library's intervals, and why they end."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main, maps

FIELDS = ["left", "right", "share", "attractor", "kind", "period", "d", "lyapunov"]
FIELDS += ["left_cause", "right_cause"]


@pytest.fixture(scope="module")
def found():
    return ss.basins(ss.examples.coulomb())


def test_json_carries_the_librarys_intervals(capsys, found):
    assert main("basins --preset coulomb --json".split()) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    document = json.loads(captured.out)
    assert (document["schema"], document["command"]) == (1, "basins")
    assert document["parameters"].items() >= {"V": 0.0366, "resolution": 1e-5}.items()
    result = document["result"]
    assert list(result) == FIELDS
    assert [*result["left"], result["right"][-1]] == found.edges.tolist()
    assert result["attractor"] == (found.index + 1).tolist()
    assert sum(result["share"]) == pytest.approx(1.0, abs=1e-14)
    periods = [found.attractors[k].period for k in found.index]
    assert result["period"] == periods
    assert sorted(set(periods)) == [1, 4]
    causes = [str(cause) for cause in found.causes]
    assert result["left_cause"] == causes[:-1]
    assert result["right_cause"] == causes[1:]


def test_csv_reads_back_exactly(tmp_path, capsys, found):
    path = tmp_path / "basins.csv"
    assert main(["basins", "--preset", "coulomb", "--out", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert [float(row["left"]) for row in rows] == found.edges[:-1].tolist()
    assert {row["kind"] for row in rows} == {"periodic"}
    f = ss.event_map(ss.examples.coulomb())
    for row in rows:  # a point of each interval ends where the row says
        middle = 0.5 * (float(row["left"]) + float(row["right"]))
        tail = f.iterate(middle, 2000)[-int(row["period"]) :]
        assert np.abs(tail - float(row["d"])).min() < 1e-10


def test_motions_that_leave_and_undecided_ones_belong_to_no_attractor(found):
    partly = replace(found, index=np.array([0, -1, -2, 1]))
    table = partly.table()
    assert list(table["attractor"]) == [1, 0, 0, 2]
    assert list(table["kind"]) == ["periodic", "undecided", "leaves", "periodic"]
    assert np.isnan(table["d"][1:3]).all()


def test_an_undecided_rest_is_told_and_nothing_decided_fails(found, capsys):
    partly = replace(found, index=np.array([0, -1, 0, 1]), undecided=0.4, reason="interwoven")
    assert maps._basin_ending(partly, quiet=False) == 0
    assert "0.4 of the domain undecided: interwoven" in capsys.readouterr().err
    nothing = replace(found, index=np.full(4, -1), undecided=1.0, reason="no attractor", thin=3)
    assert maps._basin_ending(nothing, quiet=False) == 1
    assert "3 intervals" in capsys.readouterr().err
    assert maps._basin_ending(nothing, quiet=True) == 1
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--resolution 0", ["resolution", "0", "between 0 and 1"]),
        ("--resolution 1", ["resolution", "1", "between 0 and 1"]),
        ("--resolution nan", ["resolution", "nan"]),
        ("--beta 0", ["beta", "> 0"]),
        ("--max-events 0", ["max_events", ">= 1"]),
        ("--out .", ["folder"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_names_what_came_and_leaves_no_file(
    options, fragments, as_json, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    command = f"basins --preset coulomb {options}".split()
    command += [] if "--out" in options else ["--out", "basins.csv"]
    assert main(command + ["--json"] * as_json) == 2
    captured = capsys.readouterr()
    message = json.loads(captured.out)["error"]["message"] if as_json else captured.err
    assert "Traceback" not in message
    for fragment in fragments:
        assert fragment in message
    assert list(tmp_path.iterdir()) == []
