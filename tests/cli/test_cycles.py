"""``stickslip cycles`` end to end."""

import csv
import io
import json

import stickslip as ss
from stickslip.cli import main

FIELDS = ["cycle", "period", "multiplier", "stable", "events", "global_sticks", "hits"]


def test_json_carries_every_cycle_to_the_last_digit(capsys):
    assert main("cycles --preset coulomb --starts 6 --seed 3 --json".split()) == 0
    captured = capsys.readouterr()
    assert "estimated share" in captured.err
    document = json.loads(captured.out)
    found = ss.limit_cycles(ss.examples.coulomb(), n_starts=6, rng=3)
    assert list(document["result"]) == FIELDS
    assert document["result"]["period"] == [cycle.period for cycle in found]
    assert document["result"]["hits"] == found.hits.tolist()
    assert document["parameters"].items() >= {"starts": 6, "seed": 3, "V": 0.0366}.items()


def test_csv_has_a_row_for_each_cycle(tmp_path, capsys):
    path = tmp_path / "cycles.csv"
    assert main(f"cycles --preset coulomb --V 0.5 --starts 6 -q --out {path}".split()) == 0
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == (f"{path}\n", "")
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert list(rows[0]) == FIELDS
    assert [row["cycle"] for row in rows] == [str(k + 1) for k in range(len(rows))]
    assert "0" in {row["global_sticks"] for row in rows}


def test_options_that_mean_nothing_here_are_refused(capsys):
    assert main("cycles --preset coulomb --engine exact".split()) == 2
    assert "--engine" in capsys.readouterr().err
    assert main("cycles --preset coulomb --starts 0".split()) == 2
    assert "n_starts" in capsys.readouterr().err
