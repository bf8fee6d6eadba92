"""``stickslip simulate`` and ``cycles``."""

import csv
import io
import json

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main


def columns_of(text):
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@pytest.mark.parametrize("preset", ["coulomb", "law9"])
def test_samples_are_the_librarys_motion(preset, tmp_path, capsys):
    path = tmp_path / "run.csv"
    command = f"simulate --preset {preset} -d 0.1 --t-end 20 --samples 101 --out {path}"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == f"{path}\n"
    table = columns_of(path.read_text())
    t = np.linspace(0, 20, 101)
    motion = ss.simulate(getattr(ss.examples, preset)(), d=0.1, t_end=20)
    np.testing.assert_array_equal(table["t"], t)
    for name, values in {
        "x": motion.x(t),
        "v": motion.v(t),
        "friction": motion.friction(t),
    }.items():
        both = np.stack([table[f"{name}_1"], table[f"{name}_2"]], axis=-1)
        np.testing.assert_array_equal(both, values)


def test_modes_say_who_rides_the_belt(capsys):
    assert main("simulate --preset coulomb -d 0.1 --t-end 20".split()) == 0
    table = columns_of(capsys.readouterr().out)
    for block in "12":
        relative = table[f"v_{block}"] - 0.0366
        mode = table[f"mode_{block}"]
        assert set(mode) == {-1, 0}
        assert np.abs(relative[mode == 0]).max() < 1e-14
        assert relative[mode == -1].max() <= 1e-14


def test_json_from_any_state(capsys):
    command = "simulate --preset coulomb --x 0.5 --x 0.6 --v 0 --v 0.0366 --t-end 10 --samples 3"
    assert main([*command.split(), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document) == ["schema", "command", "parameters", "result"]
    assert document["parameters"]["x"] == [0.5, 0.6]
    assert document["result"]["t"] == [0.0, 5.0, 10.0]
    assert document["result"]["v_1"][0] == 0.0


def test_energy_balances(capsys):
    command = "simulate --preset law9 -d 0.3812 --t-end 30 --samples 50 --energy"
    assert main(command.split()) == 0
    table = columns_of(capsys.readouterr().out)
    balance = table["kinetic"] + table["elastic"] - table["belt_work"] + table["dissipation"]
    np.testing.assert_allclose(balance, balance[0], rtol=0, atol=1e-11)


def test_events_instead_of_samples(capsys):
    assert main("simulate --preset coulomb -d 0.1 --t-end 50 --events --json".split()) == 0
    result = json.loads(capsys.readouterr().out)["result"]
    events = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=50).events
    assert result["time"] == [event.time for event in events]
    assert result["block"] == [event.block for event in events]
    assert result["kind"] == [event.kind for event in events]
    assert len(events) > 3


def test_a_motion_that_could_not_be_followed_fails(capsys):
    command = "simulate --preset coulomb -d 0.1 --t-end 50 --max-events 3 --samples 2"
    assert main(command.split()) == 1
    captured = capsys.readouterr()
    assert columns_of(captured.out)["t"][-1] < 50
    assert "raise --max-events" in captured.err


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("", ["-d", "--x"]),
        ("-d 0.1 --x 0.5 --x 0.6 --v 0 --v 0", ["-d", "--x"]),
        ("--x 0.5 --x 0.6", ["v"]),
        ("--x 0.5 --v 0", ["x", "0.5"]),
        ("-d 3", ["3.0", "0.676"]),
        ("-d 0.1 --samples 1", ["--samples 1"]),
        ("-d 0.1 --events --samples 9", ["--events", "--samples"]),
        ("-d 0.1 --events --energy", ["--events", "--energy"]),
        ("-d 0.1 --samples 99999999999999999999", ["--samples 999", "at most"]),
        ("-d 0.1 --t-end -1", ["--t-end", "-1"]),
        ("-d 0.1 --t-end nan", ["--t-end", "nan"]),
        ("-d 0.1 --alpha -1", ["alpha", "-1"]),
    ],
)
def test_bad_input_leaves_a_message_and_no_file(options, fragments, tmp_path, capsys):
    command = f"simulate --preset coulomb --out {tmp_path / 'run.csv'} {options}"
    command += "" if "--t-end" in options else " --t-end 10"
    assert main(command.split()) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Traceback" not in captured.err
    for fragment in fragments:
        assert fragment in captured.err
    assert list(tmp_path.iterdir()) == []


THREE = """
kind = "chain"
static = [1.0, 1.3, 1.1]
alpha = 1.2
V = 0.0366
friction = {law = "coulomb", mu = 0.22}
"""


def test_one_option_takes_a_number_for_each_block(tmp_path, capsys):
    (tmp_path / "three.toml").write_text(THREE)
    told = []
    for state in ("--x 0 0.1 0 --v 0 -0.1 1e-3", "--x 0 --x 0.1 --x 0 --v 0 --v -0.1 --v 1e-3"):
        command = f"simulate --model {tmp_path / 'three.toml'} {state} --t-end 1 --samples 3"
        assert main(command.split()) == 0
        told.append(capsys.readouterr().out)
    assert told[0] == told[1]
    assert main(f"simulate --model {tmp_path / 'three.toml'} -d 0.1 --t-end 1".split()) == 2
    assert "along its last axis 2 numbers are needed" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["orbits", "basins", "map -d 0.1"])
def test_a_return_map_without_bounds_is_not_searched(command, tmp_path, capsys):
    forced = f"{THREE}forcing = {{amplitude = 0.3, frequency = 0.9}}\n"
    (tmp_path / "forced.toml").write_text(forced)
    assert main([*command.split(), "--model", str(tmp_path / "forced.toml")]) == 2
    told = capsys.readouterr().err
    assert "has 5 numbers and no bounds within which to search. stickslip cycles" in told


FIELDS = [
    "cycle",
    "period",
    "multiplier",
    "multiplier_imag",
    "stable",
    "events",
    "global_sticks",
    "hits",
]


def test_json_carries_every_cycle_to_the_last_digit(capsys):
    assert main("cycles --preset coulomb --n-starts 6 --seed 3 --json".split()) == 0
    captured = capsys.readouterr()
    assert "estimated share" in captured.err
    document = json.loads(captured.out)
    found = ss.limit_cycles(ss.examples.coulomb(), n_starts=6, rng=3)
    assert list(document["result"]) == FIELDS
    assert document["result"]["period"] == [cycle.period for cycle in found]
    largest = [cycle.largest_multiplier for cycle in found]
    assert document["result"]["multiplier"] == [m.real for m in largest]
    assert document["result"]["multiplier_imag"] == [m.imag for m in largest]
    assert document["result"]["hits"] == found.hits.tolist()
    assert document["parameters"].items() >= {"n_starts": 6, "seed": 3, "V": 0.0366}.items()


def test_csv_has_a_row_for_each_cycle(tmp_path, capsys):
    path = tmp_path / "cycles.csv"
    assert main(f"cycles --preset coulomb --V 0.5 --n-starts 6 -q --out {path}".split()) == 0
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == (f"{path}\n", "")
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert list(rows[0]) == FIELDS
    assert [row["cycle"] for row in rows] == [str(k + 1) for k in range(len(rows))]
    assert "0" in {row["global_sticks"] for row in rows}


def test_options_that_mean_nothing_here_are_refused(capsys):
    assert main("cycles --preset coulomb --engine exact".split()) == 2
    assert "--engine" in capsys.readouterr().err
    assert main("cycles --preset coulomb --n-starts 0".split()) == 2
    assert "--n-starts 0" in capsys.readouterr().err
