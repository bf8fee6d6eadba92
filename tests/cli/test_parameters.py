"""``stickslip bifurcations`` and ``diagram``: reports, tables and pictures."""

import csv
import functools
import io
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.diagrams.diagram import AttractorTable, Diagram, OrbitCurve
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.cli import main
from stickslip.cli.parameters import FILES, PICTURES
from stickslip.mechanics.model.file import read_model, write_model
from stickslip.results.files import load

RANGE = (0.03697, 0.03698)
BIFURCATIONS = f"--parameter V --range {RANGE[0]} {RANGE[1]}"
GRAZE = 0.036975923520307  # where S4 meets the jump
SIGNATURES_OF_REPORTS = {"diagram.svg": b"<?xml", "diagram.pdf": b"%PDF", "diagram.png": b"\x89PNG"}


@pytest.fixture(scope="module")
def found():
    return bifurcations(ss.event_map(ss.examples.coulomb()), "V", RANGE)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """One run of the real program on a user's file, with its folder."""
    folder = tmp_path_factory.mktemp("report")
    write_model(ss.examples.coulomb(V=0.05), folder / "mine.toml")  # its V does not matter
    command = f"bifurcations --model mine.toml {BIFURCATIONS} --values 9 --out new/out"
    done = subprocess.run(
        [sys.executable, "-m", "stickslip.cli", *command.split()],
        capture_output=True,
        text=True,
        check=False,
        cwd=folder,
    )
    return done, folder / "new" / "out"


def test_the_report_says_where_what_and_why(report):
    done, _ = report
    assert done.returncode == 0, done.stderr
    names, _, text = done.stdout.partition("\n\n")
    assert names.splitlines() == [os.path.join("new", "out", name) for name in FILES]
    for fragment in ("border collision", "0.0369759235203", "block 2 grazes", "mu = 0.22"):
        assert fragment in text


def test_the_folder_holds_everything_and_nothing_half_written(report, found):
    _, folder = report
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    assert read_model(folder / "model.toml") == ss.examples.coulomb(V=0.05)
    for name, signature in SIGNATURES_OF_REPORTS.items():
        assert (folder / name).read_bytes().startswith(signature)
    assert PICTURES[0] in (folder / "report.md").read_text()
    document = json.loads((folder / "report.json").read_text())
    assert [item["value"] for item in document["bifurcations"]] == [b.value for b in found]
    loaded = load(folder / "bifurcations.json")
    assert [b.value for b in loaded] == [b.value for b in found]


def test_csv_reads_back_exactly(found, report, capsys):
    assert main(f"bifurcations --preset coulomb {BIFURCATIONS} --csv".split()) == 0
    printed = capsys.readouterr().out
    (row,) = csv.DictReader(io.StringIO(printed))
    (expected,) = found
    assert list(row) == list(found.table())
    assert float(row["value"]) == expected.value == pytest.approx(GRAZE, abs=1e-14)
    assert float(row["error"]) == expected.error
    assert [float(x) for x in row["points"].split()] == expected.points.tolist()
    assert (row["kind"], row["period"], row["block"]) == ("border_collision", "4", "2")
    assert row["mechanism"] == expected.mechanism
    assert (report[1] / "bifurcations.csv").read_text() == printed


def test_json_is_one_document(found, capsys):
    assert main(f"bifurcations --preset coulomb {BIFURCATIONS} --json".split()) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert (document["schema"], document["command"]) == (1, "bifurcations")
    asked = {"parameter": "V", "range": list(RANGE), "max_period": 4, "window": None, "mu": 0.22}
    assert document["parameters"].items() >= asked.items()
    result = document["result"]
    assert list(result) == ["bifurcations", "cascades", "unresolved", "outside"]
    assert len(result["unresolved"]) == len(found.unresolved)
    (item,) = result["bifurcations"]
    assert item["value"] == found[0].value
    assert item["points"] == found[0].points.tolist()
    (before,) = item["orbits_before"]
    assert before["multiplier"] == found[0].orbits_before[0].multiplier
    assert {a["period"] for a in item["attractors_before"]} == {1, 4}


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--parameter U --range 0 1", ["'U'", "alpha, beta, V, mu"]),
        ("--parameter alhpa --range 0 1", ["'alhpa'", "'alpha'?"]),
        ("--parameter V --range 0.04 0.03", ["--range", "0.04", "0.03", "lower one first"]),
        ("--parameter V --range 0.03 0.03", ["--range", "lower one first"]),
        ("--parameter V --range 0.03 nan", ["--range", "nan", "finite"]),
        ("--parameter V --range 0 0.03", ["V = 0", "> 0"]),
        ("--parameter mu --range 0.5 1.5", ["mu", "1.5", "<= 1"]),
        ("--parameter V --range 0.03", ["--range"]),
        ("--parameter V", ["--range"]),
        ("--range 0.03 0.04", ["--parameter"]),
        (f"{BIFURCATIONS} --max-period 0", ["--max-period", "0", "from 1 to"]),
        (f"{BIFURCATIONS} --max-period 1.5", ["--max-period", "1.5", "whole number"]),
        (f"{BIFURCATIONS} --values 1", ["--values 1", "at least 2"]),
        (f"{BIFURCATIONS} --window 0.2 0.1", ["window", "0.2", "0.1"]),
        (f"{BIFURCATIONS} --window nan 0.1", ["window", "nan"]),
        (f"{BIFURCATIONS} --preset law9 --model mine.toml", ["--model", "--preset"]),
        (f"{BIFURCATIONS} --model missing.toml", ["missing.toml"]),
        (f"{BIFURCATIONS} --out mine.toml", ["mine.toml", "file", "folder"]),
        (f"{BIFURCATIONS} --max-events 0", ["--max-events"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_names_what_came_and_leaves_nothing(
    options, fragments, as_json, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    write_model(ss.examples.coulomb(), tmp_path / "mine.toml")
    command = f"bifurcations {options}"
    command += "" if "--model" in options else " --model mine.toml"
    command += "" if "--out" in options else " --out new/out"
    assert main(command.split() + ["--json"] * as_json) == 2
    captured = capsys.readouterr()
    message = json.loads(captured.out)["error"]["message"] if as_json else captured.err
    assert (captured.err if as_json else captured.out) == ""
    assert "Traceback" not in message
    for fragment in fragments:
        assert fragment in message
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


def test_one_form_at_a_time(capsys):
    assert main(f"bifurcations --preset coulomb {BIFURCATIONS} --csv --json".split()) == 2
    message = json.loads(capsys.readouterr().out)["error"]["message"]
    assert "--csv" in message
    assert "--json" in message


def test_a_report_is_replaced_only_by_force(tmp_path, capsys):
    (tmp_path / "report.md").write_text("precious")
    command = f"bifurcations --preset coulomb {BIFURCATIONS} --out {tmp_path}"
    assert main(command.split()) == 3
    assert "--force" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["report.md"]
    assert (tmp_path / "report.md").read_text() == "precious"


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_nothing(kind, tmp_path):
    command = [sys.executable, "-m", "stickslip.cli", "bifurcations", "--preset", "law9"]
    command += "--parameter alpha --range 1.208 1.21865 --window 0.379 0.390".split()
    command += ["--out", str(tmp_path / "new" / "out")]
    # A shell's background job ignores interrupts, and its children inherit that.
    heed = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=heed)
    try:
        deadline = time.monotonic() + 60
        while not os.listdir(tmp_path) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert os.listdir(tmp_path)
        time.sleep(1.0)  # the work has begun
        process.send_signal(kind)
        _, error = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130
    assert error.endswith("stickslip: interrupted\n")
    assert os.listdir(tmp_path) == []


NAN = np.nan
ENDS = (0.0369, 0.037)
DIAGRAM = f"--parameter V --range {ENDS[0]} {ENDS[1]} --values 5"
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
    end = CurveEnd("end of range", {"V": 0.0}, np.zeros(2))
    points = np.array([[0.1, 0.2], [0.3, 0.4], [NAN, NAN]])
    orbit = OrbitCurve(2, points, np.array([0.5, -1.5, NAN]), (end, end))
    attractors = AttractorTable(
        where=np.array([0, 0, 2]),
        kind=np.array(["periodic", "chaotic", "undecided"]),
        period=np.array([1, 0, 0]),
        lyapunov=np.array([-0.5, 0.25, NAN]),
        points=np.array([[0.7, NAN], [0.8, 0.9], [0.6, NAN]]),
    )
    jump = BreakpointLine("jump", np.array([NAN, 0.0, 0.5]))
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


def test_a_picture_and_its_points(here, diagram, capsys):
    write_model(ss.examples.coulomb(V=0.05), here / "mine.toml")  # its V does not matter
    command = f"diagram --model mine.toml {DIAGRAM} --out fig.svg --csv points.csv"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == "fig.svg\npoints.csv\n"
    assert sorted(path.name for path in here.iterdir()) == ["fig.svg", "mine.toml", "points.csv"]
    assert (here / "fig.svg").read_bytes().startswith(SIGNATURES["svg"])
    rows = list(csv.DictReader(io.StringIO((here / "points.csv").read_text())))
    read = [[row[name] for row in rows] for name in rows[0]]
    assert read == exact(diagram.table())


def test_json_has_a_null_where_the_table_has_nan(diagram, capsys):
    assert main(f"diagram --preset coulomb {DIAGRAM} --json".split()) == 0
    document = json.loads(capsys.readouterr().out)
    asked = {"parameter": "V", "range": list(ENDS), "values": 5, "max_period": 4, "beta": 1.3}
    assert document["parameters"].items() >= asked.items()
    table = diagram.table()
    result = document["result"]
    assert list(result) == list(table)
    assert result["d"] == table["d"].tolist()
    assert result["multiplier"].count(None) == np.isnan(table["multiplier"]).sum() > 0


def test_without_files_it_prints_where_each_orbit_exists(diagram, capsys):
    assert main(f"diagram --preset coulomb {DIAGRAM}".split()) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert list(rows[0]) == list(diagram.overview())
    assert [float(row["to"]) for row in rows] == [orbit.ends[1].value for orbit in diagram.orbits]
    (lost,) = (row for row in rows if row["period"] == "4")
    assert lost["ends"] == "border_collision"
    assert float(lost["to"]) == pytest.approx(0.036975923520307, abs=1e-12)


@pytest.mark.parametrize("suffix", ["pdf", "png"])
def test_the_name_of_the_picture_chooses_its_format(suffix, here, capsys):
    command = f"diagram --preset coulomb {DIAGRAM} --max-period 1 --out a.b.{suffix}"
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
        ("--out fig.svg --max-period 0", ["--max-period", "0"]),
        ("--out fig.svg --range 0.04 0.03", ["0.04", "0.03"]),
        ("--out fig.svg --range nan 0.03", ["nan"]),
        ("--out fig.svg --range 0 0.03", ["V = 0", "> 0"]),
        ("--out fig.svg --parameter U", ["'U'", "alpha, beta, V, mu"]),
        ("--out fig.svg --window 0.2 0.1", ["window", "0.2", "0.1"]),
        ("--csv points.csv --alpha -1", ["alpha", "-1"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_about_diagrams_names_what_came_and_leaves_nothing(
    options, fragments, as_json, here, capsys
):
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
    command = f"diagram --preset coulomb {DIAGRAM} --out fig.svg --csv points.csv"
    assert main(command.split()) == 3
    assert "--force" in capsys.readouterr().err
    assert [path.name for path in here.iterdir()] == ["points.csv"]
    assert (here / "points.csv").read_text() == "precious"
