"""``stickslip map``, ``orbits`` and ``basins``: through the real program, and its parts."""

import csv
import functools
import io
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main, models

PAPER = "--alpha 1.2 --beta 1.3 --V 0.0366 --friction coulomb:mu=0.22".split()
MAP_FIELDS = ("value", "derivative", "duration", "n_events", "label", "margin", "status")


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
    for field in MAP_FIELDS:
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


@pytest.mark.parametrize("window", ["5 -5", "2 3"])
def test_a_window_that_holds_no_point_is_refused_by_its_name(window, capsys):
    assert main(f"map --preset coulomb --grid 3 --window {window}".split()) == 2
    assert capsys.readouterr().err.startswith("stickslip map: --window (")


def test_of_a_window_the_part_inside_the_domain_counts(capsys):
    assert main("map --preset coulomb --grid 3 --window -5 0.1".split()) == 0
    lo, _ = ss.event_map(ss.examples.coulomb()).domain
    d = [float(row["d"]) for row in rows_of(capsys.readouterr().out)]
    assert d == np.linspace(lo, 0.1, 3).tolist()


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
    assert "no such event comes again" in captured.err


def test_giving_up_everywhere_is_a_failure(capsys):
    assert main(["map", *PAPER, "-d", "0.1", "--max-time", "3"]) == 1
    captured = capsys.readouterr()
    assert rows_of(captured.out)[0]["status_name"] == "TIME_LIMIT"
    assert "raise --max-time" in captured.err
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
        (["--max-events", "0"], ["--max-events", "0", ">= 1"]),
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


@pytest.mark.parametrize("count", ["1", "1000000000"])
def test_a_grid_is_no_larger_than_a_table(count, capsys):
    assert main(["map", *PAPER, "--grid", count]) == 2
    assert f"--grid {count}: both ends count, so at least 2; at most" in capsys.readouterr().err


def test_no_file_is_left_by_bad_input(tmp_path):
    assert main(["map", *PAPER, "-d", "3", "--out", str(tmp_path / "map.csv")]) == 2
    assert list(tmp_path.iterdir()) == []


def test_head_may_leave_early():
    command = f"{sys.executable} -m stickslip.cli map --preset coulomb --grid 50000 | head -n 1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("d,value,")
    assert done.stderr == ""


def test_help_may_be_left_early():
    command = [sys.executable, "-m", "stickslip.cli", "map", "--help"]
    gone, closed = os.pipe()
    os.close(gone)
    done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True)
    os.close(closed)
    assert (done.returncode, done.stderr) == (0, "")


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
    assert error.endswith("stickslip: interrupted\n")
    assert os.listdir(tmp_path) == []


ORBIT_FIELDS = ["orbit", "period", "kind", "multiplier", "point", "d", "error", "itinerary"]


@pytest.fixture(scope="module")
def found_orbits():
    return ss.periodic_orbits(ss.examples.coulomb(), 4, infinitely_unstable=True)


def test_json_carries_every_orbit_to_the_last_digit(capsys, found_orbits):
    command = "orbits --preset coulomb --max-period 4 --infinitely-unstable --json"
    assert main(command.split()) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    document = json.loads(captured.out)
    assert (document["schema"], document["command"]) == (1, "orbits")
    asked = {"V": 0.0366, "max_period": 4, "infinitely_unstable": True, "resolution": 1e-9}
    assert document["parameters"].items() >= asked.items()
    result = document["result"]
    assert list(result) == ORBIT_FIELDS
    assert result["d"] == np.concatenate([orbit.points for orbit in found_orbits]).tolist()
    assert (
        result["orbit"]
        == np.repeat(np.arange(len(found_orbits)) + 1, [o.period for o in found_orbits]).tolist()
    )
    crosses_a_jump = [kind == "infinitely unstable" for kind in result["kind"]]
    assert [m is None for m in result["multiplier"]] == crosses_a_jump  # JSON has no infinity
    assert any(crosses_a_jump)


@pytest.mark.parametrize("command", ["orbits", "basins"])
def test_a_map_whose_motions_are_all_given_up_has_no_answer(command, capsys):
    assert main(f"{command} --preset coulomb --max-events 1".split()) == 1
    assert "--max-events" in capsys.readouterr().err


def test_csv_of_orbits_reads_back_exactly(tmp_path, capsys, found_orbits):
    path = tmp_path / "orbits.csv"
    command = f"orbits --preset coulomb --period 4 --infinitely-unstable --out {path}"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == f"{path}\n"
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert list(rows[0]) == ORBIT_FIELDS
    assert {row["period"] for row in rows} == {"4"}
    expected = [d for orbit in found_orbits.of_period(4) for d in orbit.points]
    assert [float(row["d"]) for row in rows] == expected
    assert [row["point"] for row in rows] == ["1", "2", "3", "4"] * (len(rows) // 4)
    assert all(float(row["error"]) < 1e-13 for row in rows)
    kinds = [orbit.kind for orbit in found_orbits.of_period(4)]
    assert [row["kind"] for row in rows[::4]] == kinds
    assert {row["multiplier"] for row in rows if row["kind"] != "stable"} == {"inf"}


def test_fixed_points_are_the_default(capsys):
    assert main("orbits --preset coulomb".split()) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    f = ss.event_map(ss.examples.coulomb())
    assert [round(float(row["d"]), 4) for row in rows] == [-0.0399, 0.0886, 0.3716]
    assert [row["kind"] for row in rows] == ["stable", "unstable", "unstable"]
    assert [row["itinerary"] for row in rows] == [f.itinerary(float(row["d"])) for row in rows]


def test_a_list_that_is_not_complete_fails_and_says_what_is_open(found_orbits, capsys):
    """Few maps come here within seconds, so the ending is asked alone."""
    from dataclasses import replace

    from stickslip.analysis.branches.discontinuities import Unresolved
    from stickslip.analysis.orbits.orbit import NearFold

    near = NearFold(3, 0.25, 1e-17, resolved=False)
    reason = Unresolved("more than 1000 pieces:", -0.6, 0.6, 4)
    cut = replace(found_orbits, complete=3, near_folds=(near,), unresolved=(reason,))
    assert models._orbit_ending(cut, quiet=False) == 1
    error = capsys.readouterr().err
    assert "period 3 at d = 0.25" in error
    assert "more than 1000 pieces: [-0.6, 0.6], period 4" in error
    assert models._orbit_ending(found_orbits, quiet=False) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--max-period 0", ["--max-period", "0", "from 1 to"]),
        ("--period -2", ["period", "-2", "from 1 to"]),
        ("--period 2 --max-period 3", ["--period", "--max-period"]),
        ("--max-period 1.5", ["--max-period", "1.5", "whole number"]),
        ("--period many", ["--period", "many"]),
        ("--resolution 0", ["resolution", "0", "positive"]),
        ("--resolution nan", ["resolution", "nan", "finite"]),
        ("--V 0", ["V", "> 0"]),
        ("--max-events 0", ["--max-events", ">= 1"]),
        ("--out nowhere/orbits.csv", ["nowhere"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_about_orbits_names_what_came_and_leaves_no_file(
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


def test_a_file_of_orbits_is_replaced_only_by_force(tmp_path, capsys):
    path = tmp_path / "orbits.csv"
    path.write_text("precious")
    assert main(["orbits", "--preset", "coulomb", "--out", str(path)]) == 3
    assert path.read_text() == "precious"
    assert "--force" in capsys.readouterr().err


BASIN_FIELDS = ["left", "right", "share", "attractor", "kind", "period", "d", "lyapunov"]
BASIN_FIELDS += ["left_cause", "right_cause"]


@pytest.fixture(scope="module")
def found_basins():
    return ss.basins(ss.examples.coulomb())


def test_json_carries_the_librarys_intervals(capsys, found_basins):
    assert main("basins --preset coulomb --json".split()) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    document = json.loads(captured.out)
    assert (document["schema"], document["command"]) == (1, "basins")
    assert document["parameters"].items() >= {"V": 0.0366, "resolution": 1e-5}.items()
    result = document["result"]
    assert list(result) == BASIN_FIELDS
    assert [*result["left"], result["right"][-1]] == found_basins.edges.tolist()
    assert result["attractor"] == (found_basins.index + 1).tolist()
    assert sum(result["share"]) == pytest.approx(1.0, abs=1e-14)
    periods = [found_basins.attractors[k].period for k in found_basins.index]
    assert result["period"] == periods
    assert sorted(set(periods)) == [1, 4]
    causes = [str(cause) for cause in found_basins.causes]
    assert result["left_cause"] == causes[:-1]
    assert result["right_cause"] == causes[1:]


def test_csv_of_basins_reads_back_exactly(tmp_path, capsys, found_basins):
    path = tmp_path / "basins.csv"
    assert main(["basins", "--preset", "coulomb", "--out", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert [float(row["left"]) for row in rows] == found_basins.edges[:-1].tolist()
    assert {row["kind"] for row in rows} == {"periodic"}
    f = ss.event_map(ss.examples.coulomb())
    for row in rows:  # a point of each interval ends where the row says
        middle = 0.5 * (float(row["left"]) + float(row["right"]))
        tail = f.iterate(middle, 2000)[-int(row["period"]) :]
        assert np.abs(tail - float(row["d"])).min() < 1e-10


def test_motions_that_leave_and_undecided_ones_belong_to_no_attractor(found_basins):
    partly = replace(found_basins, index=np.array([0, -1, -2, 1]))
    table = partly.table()
    assert list(table["attractor"]) == [1, 0, 0, 2]
    assert list(table["kind"]) == ["periodic", "not proved", "leaves", "periodic"]
    assert np.isnan(table["d"][1:3]).all()


def _nowhere(found):
    """Counts of samples that came to no attractor."""
    return np.append(np.zeros(len(found.attractors) + 1, dtype=int), 9)


def test_an_undecided_rest_is_told_and_nothing_decided_fails(found_basins, capsys):
    partly = replace(
        found_basins,
        index=np.array([0, -1, 0, 1]),
        counts=_nowhere(found_basins),
        reason="interwoven",
    )
    assert models._basin_ending(partly, quiet=False) == 0
    assert "0.404 of the domain undecided: interwoven" in capsys.readouterr().err
    nothing = replace(
        found_basins,
        index=np.full(4, -1),
        counts=_nowhere(found_basins),
        reason="no attractor",
        thin=3,
    )
    assert models._basin_ending(nothing, quiet=False) == 1
    assert "3 intervals" in capsys.readouterr().err
    assert models._basin_ending(nothing, quiet=True) == 1
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--resolution 0", ["resolution", "0", "between 0 and 1"]),
        ("--resolution 1", ["resolution", "1", "between 0 and 1"]),
        ("--resolution nan", ["resolution", "nan"]),
        ("--samples 64", ["--samples", "several numbers"]),
        ("--beta 0", ["beta", "> 0"]),
        ("--max-events 0", ["--max-events", ">= 1"]),
        ("--out .", ["folder"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_about_basins_names_what_came_and_leaves_no_file(
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


def test_a_shaken_block_is_asked_for_its_return_map(tmp_path, capsys):
    forcing = ss.Harmonic(amplitude=0.3, frequency=0.45)
    block = ss.Oscillator(V=0.02, friction=ss.Coulomb(mu=0.4), damping=0.02, forcing=forcing)
    ss.write_model(block, tmp_path / "shaken.toml")
    assert main(["orbits", "--model", str(tmp_path / "shaken.toml"), "--json"]) == 0
    orbits = json.loads(capsys.readouterr().out)["result"]
    assert len(orbits["orbit"]) == len(ss.periodic_orbits(ss.return_map(block)))


# ------------------------------------------------------------------ safety


def test_safety_along_a_parameter_tells_where_the_attractor_is_lost(capsys):
    command = "safety --preset coulomb --parameter V --values 0.0366 --values 0.15"
    assert main(command.split()) == 0
    told = capsys.readouterr()
    (row,) = csv.DictReader(io.StringIO(told.out))
    assert row["period"] == "4"
    assert "the attractor is not found again at V = 0.15" in told.err


@pytest.mark.parametrize("half", ["--values 0.1", "--parameter V"])
def test_values_of_no_parameter_are_refused(half, capsys):
    assert main(f"safety --preset coulomb {half}".split()) == 2
    assert "--parameter and --values belong together" in capsys.readouterr().err
