"""``stickslip bifurcations`` end to end: the library's list as report, table, data and files."""

import csv
import functools
import io
import json
import os
import signal
import subprocess
import sys
import time

import pytest

import stickslip as ss
from stickslip.analysis.bifurcations.bifurcations import bifurcations
from stickslip.cli import main
from stickslip.cli.parameters import FILES, PICTURES
from stickslip.mechanics.model.file import read_model, write_model
from stickslip.results.files import load

RANGE = (0.03697, 0.03698)
QUESTION = f"--parameter V --range {RANGE[0]} {RANGE[1]}"
GRAZE = 0.036975923520307  # where S4 meets the jump
SIGNATURES = {"diagram.svg": b"<?xml", "diagram.pdf": b"%PDF", "diagram.png": b"\x89PNG"}


@pytest.fixture(scope="module")
def found():
    return bifurcations(ss.event_map(ss.examples.coulomb()), "V", RANGE)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """One run of the real program on a user's file, with its folder."""
    folder = tmp_path_factory.mktemp("report")
    write_model(ss.examples.coulomb(V=0.05), folder / "mine.toml")  # its V does not matter
    command = f"bifurcations --model mine.toml {QUESTION} --values 9 --out new/out"
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
    for name, signature in SIGNATURES.items():
        assert (folder / name).read_bytes().startswith(signature)
    assert PICTURES[0] in (folder / "report.md").read_text()
    document = json.loads((folder / "report.json").read_text())
    assert [item["value"] for item in document["bifurcations"]] == [b.value for b in found]
    loaded = load(folder / "bifurcations.json")
    assert [b.value for b in loaded] == [b.value for b in found]


def test_csv_reads_back_exactly(found, report, capsys):
    assert main(f"bifurcations --preset coulomb {QUESTION} --csv".split()) == 0
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
    assert main(f"bifurcations --preset coulomb {QUESTION} --json".split()) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert (document["schema"], document["command"]) == (1, "bifurcations")
    asked = {"parameter": "V", "range": list(RANGE), "max_period": 4, "window": None, "mu": 0.22}
    assert document["parameters"].items() >= asked.items()
    result = document["result"]
    assert list(result) == ["bifurcations", "cascades", "unresolved"]
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
        (f"{QUESTION} --max-period 0", ["max_period", "0", "from 1 to"]),
        (f"{QUESTION} --max-period 1.5", ["--max-period", "1.5", "whole number"]),
        (f"{QUESTION} --values 1", ["--values 1", "at least 2"]),
        (f"{QUESTION} --window 0.2 0.1", ["window", "0.2", "0.1"]),
        (f"{QUESTION} --window nan 0.1", ["window", "nan"]),
        (f"{QUESTION} --preset law9 --model mine.toml", ["--model", "--preset"]),
        (f"{QUESTION} --model missing.toml", ["missing.toml"]),
        (f"{QUESTION} --out mine.toml", ["mine.toml", "file", "folder"]),
        (f"{QUESTION} --max-events 0", ["max_events"]),
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
    assert main(f"bifurcations --preset coulomb {QUESTION} --csv --json".split()) == 2
    message = json.loads(capsys.readouterr().out)["error"]["message"]
    assert "--csv" in message
    assert "--json" in message


def test_a_report_is_replaced_only_by_force(tmp_path, capsys):
    (tmp_path / "report.md").write_text("precious")
    command = f"bifurcations --preset coulomb {QUESTION} --out {tmp_path}"
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
