"""``stickslip map`` end to end: the library's own numbers, in every form, and honest endings."""

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
from stickslip.cli import main

PAPER = "--alpha 1.2 --beta 1.3 --V 0.0366 --friction coulomb:mu=0.22".split()
FIELDS = ("value", "derivative", "duration", "n_events", "label", "margin", "status")


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_json_carries_the_librarys_numbers_to_the_last_digit(capsys):
    assert main(["map", *PAPER, "-d", "-0.2", "-d", "0.1", "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    document = json.loads(captured.out)
    assert list(document) == ["schema", "command", "parameters", "result"]
    assert (document["schema"], document["command"]) == (1, "map")
    model = ss.examples.coulomb()
    assert document["parameters"].items() >= model.parameters.items()
    assert document["parameters"]["friction"] == ["coulomb:mu=0.22"]
    expected = ss.event_map(model).evaluate([-0.2, 0.1])
    assert document["result"]["d"] == [-0.2, 0.1]
    for field in FIELDS:
        assert document["result"][field] == getattr(expected, field).tolist()


def test_csv_of_a_grid_reads_back_exactly(tmp_path, capsys):
    path = tmp_path / "map.csv"
    assert main(["map", "--preset", "coulomb", "--grid", "200", "--out", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    rows = rows_of(path.read_text())
    f = ss.event_map(ss.examples.coulomb())
    d = np.linspace(*f.domain, 200)
    assert [float(row["d"]) for row in rows] == d.tolist()
    assert [float(row["value"]) for row in rows] == f(d).tolist()
    assert {row["status_name"] for row in rows} == {"OK"}


def test_a_window_bounds_the_grid(capsys):
    command = "map --preset coulomb --grid 3 --window -0.1 0.1".split()
    assert main(command) == 0
    assert [float(row["d"]) for row in rows_of(capsys.readouterr().out)] == [-0.1, 0.0, 0.1]


def test_itineraries_are_a_column(capsys):
    assert main(["map", *PAPER, "-d", "0.1", "--itinerary"]) == 0
    (row,) = rows_of(capsys.readouterr().out)
    assert row["itinerary"] == ss.event_map(ss.examples.coulomb()).itinerary(0.1)


def test_options_override_the_preset(capsys):
    command = "map --preset law9 --alpha 1.21 --V 0.3 -d 0.38 --json".split()
    assert main(command) == 0
    document = json.loads(capsys.readouterr().out)
    model = ss.examples.law9(alpha=1.21, V=0.3)
    assert document["parameters"].items() >= model.parameters.items()
    assert document["result"]["value"] == [ss.event_map(model)(0.38)]


def test_a_law_for_each_block(capsys):
    laws = ["--friction", "coulomb:mu=0.3", "--friction", "coulomb:mu=0.1"]
    assert main(["map", "--preset", "coulomb", *laws, "-d", "0.1", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    model = ss.examples.coulomb().replace(friction=(ss.Coulomb(mu=0.3), ss.Coulomb(mu=0.1)))
    assert document["result"]["value"] == [ss.event_map(model)(0.1)]


def test_a_motion_without_return_is_null_with_its_reason(capsys):
    command = "map --preset law9 -d 0.577367 --json".split()
    assert main(command) == 0  # never returning is an answer
    captured = capsys.readouterr()
    result = json.loads(captured.out)["result"]
    assert result["value"] == [None]
    assert result["status_name"] == ["NEVER_CYCLE"]
    assert "without global stick" in captured.err


def test_giving_up_everywhere_is_a_failure(capsys):
    assert main(["map", *PAPER, "-d", "0.1", "--max-time", "3"]) == 1
    captured = capsys.readouterr()
    assert rows_of(captured.out)[0]["status_name"] == "TIME_LIMIT"
    assert "raise max_time" in captured.err
    assert main(["map", *PAPER, "-d", "0.1", "--max-time", "3", "--quiet"]) == 1
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        (["--alpha", "-1"], ["alpha", "-1", ">= 0"]),
        (["--V", "0"], ["V", "0", "> 0"]),
        (["--V", "nan"], ["V", "nan"]),
        (["--V", "-0.1"], ["V", "-0.1", "(X, V) -> -(X, V)"]),
        (["--beta", "0"], ["beta", "> 0"]),
        (["--friction", "coulomb:mu=1.5"], ["mu", "1.5", "<= 1"]),
        (["--friction", "coulom:mu=0.2"], ["coulom", "coulomb"]),
        (["--friction", "coulomb:nu=0.2"], ["nu", "mu"]),
        (["--friction", "coulomb"], ["mu"]),
        (["--friction", "coulomb:mu=a"], ["mu", "'a'"]),
        (["-d", "3"], ["3.0", "0.676"]),
        (["-d", "nan"], ["nan"]),
        (["--grid", "10"], ["-d", "--grid"]),
        (["--window", "0", "1"], ["--grid"]),
        (["--grid", "10.5"], ["--grid", "10.5"]),
        (["--max-events", "1e3"], ["--max-events", "1e3", "whole number"]),
        (["--max-events", "0"], ["max_events", "0", ">= 1"]),
        (["--threads", "0"], ["threads", "0", ">= 1"]),
        (["--out", "/dev/null/map.csv"], ["/dev/null/map.csv"]),
        (["--out", "nowhere/map.csv"], ["nowhere"]),
        (["--out", "."], ["folder"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_names_what_came_and_what_is_allowed(
    options, fragments, as_json, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    command = ["map", "--preset", "coulomb", "-d", "0.1", *options]
    assert main(command + ["--json"] * as_json) == 2
    captured = capsys.readouterr()
    if as_json:
        assert captured.err == ""
        document = json.loads(captured.out)
        assert list(document) == ["schema", "command", "error"]
        message = document["error"]["message"]
    else:
        assert captured.out == ""
        assert "Traceback" not in captured.err
        message = captured.err
    for fragment in fragments:
        assert fragment in message
    assert list(tmp_path.iterdir()) == []


def test_an_incomplete_model_names_what_lacks(capsys):
    assert main(["map", "--alpha", "1", "--V", "0.1", "-d", "0"]) == 2
    error = capsys.readouterr().err
    assert "--beta, --friction" in error
    assert "--preset" in error


def test_a_file_is_replaced_only_by_force(tmp_path, capsys):
    path = tmp_path / "map.csv"
    path.write_text("precious")
    command = ["map", *PAPER, "-d", "0.1", "--out", str(path)]
    assert main(command) == 3
    assert path.read_text() == "precious"
    assert "--force" in capsys.readouterr().err
    assert main([*command, "--force"]) == 0
    assert rows_of(path.read_text())[0]["status_name"] == "OK"


def test_no_file_is_left_by_bad_input(tmp_path):
    assert main(["map", *PAPER, "-d", "3", "--out", str(tmp_path / "map.csv")]) == 2
    assert list(tmp_path.iterdir()) == []


def test_head_may_leave_early():
    command = f"{sys.executable} -m stickslip.cli map --preset coulomb --grid 50000 | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("d,value,")
    assert done.stderr == ""


def test_no_progress_where_nobody_watches():
    command = [sys.executable, "-m", "stickslip.cli", "map", "--preset", "coulomb"]
    command += ["--grid", "100000"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stderr == ""


def test_an_interrupt_leaves_no_file(tmp_path):
    assert main(["map", "--preset", "coulomb", "-d", "0.1"]) == 0  # compiled from here on
    command = [sys.executable, "-m", "stickslip.cli", "map", "--preset", "coulomb"]
    command += ["--grid", "20000000", "--out", str(tmp_path / "map.csv")]
    # A shell's background job ignores interrupts, and its children inherit that.
    heed = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=heed)
    try:
        deadline = time.monotonic() + 60
        while not os.listdir(tmp_path) and time.monotonic() < deadline:
            time.sleep(0.02)
        assert os.listdir(tmp_path)
        time.sleep(2.0)  # loading is over, the work has begun
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130
    assert error == "stickslip: interrupted\n"
    assert os.listdir(tmp_path) == []
