"""``stickslip fit``."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main
from stickslip.cli.process import BAD_USAGE, COMPUTATION_FAILED, DONE, REFUSED

UNITS = ss.Units(m=2.0, k=800.0, fs1=4.0)
TRUE = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1)
PHYSICAL = ["--columns", "t=time [s]", "x=pos [m]", "--units", "m=2", "k=800", "fs1=4"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a model to start from, a record in metres and seconds, and forces."""
    monkeypatch.chdir(tmp_path)
    ss.write_model(TRUE.replace(mu=0.4, speed=0.4), "mine.toml")
    t = np.linspace(0.0, 40.0, 400)
    noise = 0.005 * np.random.default_rng(1).normal(size=t.size)
    x = ss.simulate(TRUE, [0.0], [0.0], t_end=40).x(t)[:, 0] + noise
    rows = zip(UNITS.to_physical("time", t), UNITS.to_physical("displacement", x), strict=True)
    lines = ["time [s],pos [m]", *(f"{a!r},{b!r}" for a, b in np.array(list(rows)).tolist())]
    Path("record.csv").write_text("\n".join(lines), encoding="utf-8")
    s = np.linspace(0.01, 1.5, 20)
    lines = [
        f"{a!r},{b!r}" for a, b in zip(s.tolist(), TRUE.friction.force(s).tolist(), strict=True)
    ]
    Path("forces.csv").write_text("\n".join(["speed,force", *lines]), encoding="utf-8")
    return tmp_path


FIT = ["--model", "mine.toml", "--parameters", "mu", "speed"]


def test_a_record_in_si_units_is_fitted(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["fit", "record.csv", *FIT, *PHYSICAL, "--sigma", "2.5e-5", "--out", "fitted"]
    assert main(given) == DONE
    out, err = capsys.readouterr()
    names = ("fit.csv", "fit.json", "model.toml", "fit.svg", "fit.pdf", "fit.png")
    assert out.split() == [f"fitted/{name}" for name in names]
    assert "400 values of a record" in err
    found = ss.load("fitted/fit.json")
    assert found.scale == 1.0
    off = found.values - [0.5, 0.3]
    assert (np.abs(off) < 4.0 * found.standard_errors).all()
    assert ss.read_model("fitted/model.toml") == found.model
    assert (here / "fitted" / "fit.png").stat().st_size > 1000
    assert main(given) == REFUSED
    assert "fitted/fit.csv exists" in capsys.readouterr().err


def test_a_sensor_that_counts_from_anywhere(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head, *lines = Path("record.csv").read_text(encoding="utf-8").splitlines()
    moved = [f"{t},{float(x) + 0.05!r}" for t, x in (line.split(",") for line in lines)]
    Path("moved.csv").write_text("\n".join([head, *moved]), encoding="utf-8")
    given = ["fit", "moved.csv", *FIT, *PHYSICAL, "--any-units"]
    assert main(given) == COMPUTATION_FAILED
    assert "displacements count from where springs are slack" in capsys.readouterr().err
    assert main([*given, "--free-zero", "--json"]) == DONE
    found = json.loads(capsys.readouterr().out)["result"]
    off = np.subtract(found["value"], [0.5, 0.3])
    assert (np.abs(off) < 4.0 * np.array(found["standard_error"])).all()


def test_records_at_several_speeds_of_the_belt(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.linspace(0.0, 15.0, 60)
    for V in (0.15, 0.3):
        x = ss.simulate(TRUE.replace(V=V), [0.0], [0.0], t_end=15).x(t)[:, 0]
        rows = zip(UNITS.to_physical("time", t), UNITS.to_physical("displacement", x), strict=True)
        lines = [f"{a!r},{b!r}" for a, b in np.array(list(rows)).tolist()]
        lines[5] = lines[5].split(",")[0] + ","  # missing
        Path(f"at{V}.csv").write_text("\n".join(["t,x", *lines]), encoding="utf-8")
    given = ["fit", "at0.15.csv", "at0.3.csv", *FIT, "--units", "m=2", "k=800", "fs1=4"]
    speeds = [repr(UNITS.scale("velocity") * V) for V in (0.15, 0.3)]
    assert main([*given, "--pieces", "1", "--json", "--speeds", *speeds]) == DONE
    document = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose(document["result"]["value"], [0.5, 0.3], rtol=1e-5)
    assert document["parameters"]["speeds"] == list(map(float, speeds))
    assert main([*given, "--speeds", "1"]) == BAD_USAGE
    assert "--speeds has 1 numbers, and there are 2 files" in capsys.readouterr().err


def test_json_of_a_law_from_forces(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more = ["--bounds", "mu=0.1:0.9", "--priors", "speed=0.3:0.1", "--n-starts", "8"]
    assert main(["fit", "forces.csv", *FIT, *more, "--sigma", "0.01", "--json"]) == DONE
    document = json.loads(capsys.readouterr().out)
    assert document["result"]["parameter"] == ["mu", "speed"]
    np.testing.assert_allclose(document["result"]["value"], [0.5, 0.3], rtol=1e-4)


def test_where_a_motion_starts_is_an_option(capsys: pytest.CaptureFixture[str], here: Path) -> None:
    """The advice to give it had no option on the command line."""
    model = ss.examples.coulomb()
    t = np.linspace(0.0, 20.0, 40)
    rows = zip(t.tolist(), ss.simulate(model, d=0.1, t_end=20).x(t)[:, 0].tolist(), strict=True)
    Path("one.csv").write_text("\n".join(["t,x", *(f"{a!r},{b!r}" for a, b in rows)]))
    given = ["fit", "one.csv", "--preset", "coulomb", "--V", "0.037", "--parameters", "V"]
    assert main(given) == BAD_USAGE
    advice = "give --x0 and --v0, with --free-start if they are guesses"
    assert advice in capsys.readouterr().err
    assert main([*given, "--x0", "1", "--v0", "0"]) == BAD_USAGE
    assert "--x0 array([1.]) is not allowed: x0 must be 2 finite" in capsys.readouterr().err
    assert main([*given, "--x0", "1", "2"]) == BAD_USAGE
    assert "give both --x0 and --v0, or --d alone" in capsys.readouterr().err
    assert main([*given, "-d", "0.1", "--json"]) == DONE
    result = json.loads(capsys.readouterr().out)["result"]
    np.testing.assert_allclose(result["value"], [0.0366], rtol=1e-9)


@pytest.mark.parametrize(
    ("given", "code", "told"),
    [
        (["forces.csv", *FIT, "--columns", "t"], BAD_USAGE, "--columns t: NAME=VALUE is needed"),
        (["forces.csv", *FIT, "--columns", "speed=s"], BAD_USAGE, "no column 's', for speed"),
        (["forces.csv", *FIT, "--units", "m=2"], BAD_USAGE, "m, k and fs1 are needed"),
        (["forces.csv", *FIT, "--units", "m=2", "k=x", "fs1=1"], BAD_USAGE, "--units k=x: NAME"),
        (["forces.csv", *FIT, "--units", "m=2", "m =3"], BAD_USAGE, "m is given twice"),
        (["forces.csv", *FIT, "--bounds", "mu=0:1", "mu =0:2"], BAD_USAGE, "mu is given twice"),
        (["forces.csv", *FIT, "--units", "model"], BAD_USAGE, r"the model has no [units]"),
        (["forces.csv", *FIT, "--bounds", "mu=0.1"], BAD_USAGE, "as --bounds mu=0.1:0.9"),
        (["forces.csv", *FIT, "--sigma-v", "0.1"], BAD_USAGE, "sigma_v"),
        (["none.csv", *FIT], BAD_USAGE, "cannot use none.csv"),
        (["record.csv", *FIT, *PHYSICAL[:3]], BAD_USAGE, "Are both in the same units?"),
        (["record.csv", *FIT, *PHYSICAL[:3]], BAD_USAGE, "if False (--any-units), takes them as"),
        (["record.csv", *FIT], BAD_USAGE, """they are: columns {"t": 'time [s]', ...} (--"""),
        (["record.csv", *FIT, *PHYSICAL, "--max-evaluations", "1"], COMPUTATION_FAILED, "--max-ev"),
        (["record.csv", *FIT, *PHYSICAL[:3], "--any-units"], COMPUTATION_FAILED, "does not tell"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told(
    here: Path, capsys: pytest.CaptureFixture[str], given: list[str], code: int, told: str
) -> None:
    assert main(["fit", *given]) == code
    error = capsys.readouterr().err
    assert told in error
    assert "is for Python" not in error
