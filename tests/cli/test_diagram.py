"""``stickslip diagram``: the library's diagram as a picture and as rows, one for each point."""

import csv
import io
import json
import subprocess
import sys

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.branches.along.break_lines import BreakLine
from stickslip.analysis.diagrams.assemble import StrandEnd
from stickslip.analysis.diagrams.diagram import AttractorTable, Diagram, OrbitCurve
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.cli import main
from stickslip.mechanics.model.file import write_model

NAN = np.nan
ENDS = (0.0369, 0.037)
QUESTION = f"--parameter V --range {ENDS[0]} {ENDS[1]} --values 5"
SIGNATURES = {"svg": b"<?xml", "pdf": b"%PDF", "png": b"\x89PNG"}


@pytest.fixture(scope="module")
def diagram():
    return bifurcation_diagram(ss.event_map(ss.examples.coulomb()), "V", np.linspace(*ENDS, 5))


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def exact(table):
    return [list(map(str, column.tolist())) for column in table.values()]


def by_hand():
    """One orbit of period 2 that ends, two attractors at the first value, a jump."""
    end = StrandEnd(0.0, np.zeros(2), "end of range")
    points = np.array([[0.1, 0.2], [0.3, 0.4], [NAN, NAN]])
    orbit = OrbitCurve(2, points, np.array([0.5, -1.5, NAN]), (end, end))
    attractors = AttractorTable(
        where=np.array([0, 0, 2]),
        kind=np.array(["periodic", "chaotic", "undecided"]),
        period=np.array([1, 0, 0]),
        lyapunov=np.array([-0.5, 0.25, NAN]),
        points=np.array([[0.7, NAN], [0.8, 0.9], [0.6, NAN]]),
    )
    jump = BreakLine("jump", np.array([NAN, 0.0, 0.5]))
    values = np.array([1.0, 1.5, 2.0])
    return Diagram("V", values, 2, None, {}, (orbit,), attractors, (jump,))


def test_every_point_has_a_row_and_nothing_else_does():
    table = by_hand().table()
    rows = list(zip(*(column.tolist() for column in table.values()), strict=True))
    expected = [
        (1.0, "orbit", 1, "stable", 2, 1, 0.1, 0.5, NAN),
        (1.0, "orbit", 1, "stable", 2, 2, 0.2, 0.5, NAN),
        (1.5, "orbit", 1, "unstable", 2, 1, 0.3, -1.5, NAN),
        (1.5, "orbit", 1, "unstable", 2, 2, 0.4, -1.5, NAN),
        (1.0, "attractor", 1, "periodic", 1, 1, 0.7, NAN, -0.5),
        (1.0, "attractor", 2, "chaotic", 0, 1, 0.8, NAN, 0.25),
        (1.0, "attractor", 2, "chaotic", 0, 2, 0.9, NAN, 0.25),
        (2.0, "attractor", 1, "undecided", 0, 1, 0.6, NAN, NAN),
        (1.5, "breakpoint", 1, "jump", 0, 1, 0.0, NAN, NAN),
        (2.0, "breakpoint", 1, "jump", 0, 1, 0.5, NAN, NAN),
    ]
    assert list(map(str, rows)) == list(map(str, expected))
    names = ["V", "what", "number", "kind", "period", "point", "d", "multiplier", "lyapunov"]
    assert list(table) == names


def test_picture_and_points_through_the_real_program(here, diagram):
    write_model(ss.examples.coulomb(V=0.05), here / "mine.toml")  # its V does not matter
    command = f"diagram --model mine.toml {QUESTION} --out fig.svg --csv points.csv"
    done = subprocess.run(
        [sys.executable, "-m", "stickslip.cli", *command.split()],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "fig.svg\npoints.csv\n"), done.stderr
    assert sorted(path.name for path in here.iterdir()) == ["fig.svg", "mine.toml", "points.csv"]
    assert (here / "fig.svg").read_bytes().startswith(SIGNATURES["svg"])
    rows = list(csv.DictReader(io.StringIO((here / "points.csv").read_text())))
    read = [[row[name] for row in rows] for name in rows[0]]
    assert read == exact(diagram.table())


def test_json_has_a_null_where_the_table_has_nan(diagram, capsys):
    assert main(f"diagram --preset coulomb {QUESTION} --json".split()) == 0
    document = json.loads(capsys.readouterr().out)
    asked = {"parameter": "V", "range": list(ENDS), "values": 5, "max_period": 4, "beta": 1.3}
    assert document["parameters"].items() >= asked.items()
    table = diagram.table()
    result = document["result"]
    assert list(result) == list(table)
    assert result["d"] == table["d"].tolist()
    assert result["multiplier"].count(None) == np.isnan(table["multiplier"]).sum() > 0


def test_without_files_it_prints_where_each_orbit_exists(diagram, capsys):
    assert main(f"diagram --preset coulomb {QUESTION}".split()) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert list(rows[0]) == list(diagram.overview())
    assert [float(row["to"]) for row in rows] == [orbit.ends[1].value for orbit in diagram.orbits]
    (lost,) = (row for row in rows if row["period"] == "4")
    assert lost["ends"] == "border_collision"
    assert float(lost["to"]) == pytest.approx(0.036975923520307, abs=1e-12)


@pytest.mark.parametrize("suffix", ["pdf", "png"])
def test_the_name_of_the_picture_chooses_its_format(suffix, here, capsys):
    command = f"diagram --preset coulomb {QUESTION} --max-period 1 --out a.b.{suffix}"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == f"a.b.{suffix}\n"
    (path,) = here.iterdir()
    assert path.name == f"a.b.{suffix}"
    assert path.read_bytes().startswith(SIGNATURES[suffix])


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--out fig.jpg", ["fig.jpg", ".svg", ".pdf", ".png"]),
        ("--out fig", ["--out = 'fig'", ".svg"]),
        ("--out nowhere/fig.svg", ["nowhere"]),
        ("--out fig.svg --csv nowhere/points.csv", ["nowhere"]),
        ("--out fig.svg --values 1", ["--values 1", "at least 2"]),
        ("--out fig.svg --values 99999999999999999999", ["--values 999", "at most"]),
        ("--out fig.svg --values 10.5", ["--values", "10.5"]),
        ("--out fig.svg --max-period 0", ["max_period", "0"]),
        ("--out fig.svg --range 0.04 0.03", ["0.04", "0.03"]),
        ("--out fig.svg --range nan 0.03", ["nan"]),
        ("--out fig.svg --range 0 0.03", ["V = 0", "> 0"]),
        ("--out fig.svg --parameter U", ["'U'", "alpha, beta, V, mu"]),
        ("--out fig.svg --window 0.2 0.1", ["window", "0.2", "0.1"]),
        ("--csv points.csv --alpha -1", ["alpha", "-1"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_names_what_came_and_leaves_nothing(options, fragments, as_json, here, capsys):
    command = f"diagram --preset coulomb {options}"
    command += "" if "--range" in options else " --range 0.036 0.037"
    command += "" if "--parameter" in options else " --parameter V"
    command += "" if "--values" in options else " --values 5"
    assert main(command.split() + ["--json"] * as_json) == 2
    captured = capsys.readouterr()
    message = json.loads(captured.out)["error"]["message"] if as_json else captured.err
    assert (captured.err if as_json else captured.out) == ""
    assert "Traceback" not in message
    for fragment in fragments:
        assert fragment in message
    assert list(here.iterdir()) == []


def test_files_are_replaced_only_by_force(here, capsys):
    (here / "points.csv").write_text("precious")
    command = f"diagram --preset coulomb {QUESTION} --out fig.svg --csv points.csv"
    assert main(command.split()) == 3
    assert "--force" in capsys.readouterr().err
    assert [path.name for path in here.iterdir()] == ["points.csv"]
    assert (here / "points.csv").read_text() == "precious"
