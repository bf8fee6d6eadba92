"""Measurements from files: columns by name, units, and what is wrong with a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main

UNITS = ss.Units(m=2.0, k=8.0, fs1=4.0)
RECORD = "t,x\n0,1\n1,2\n2,3\n3,2\n4,1\n"
THREE = "t,x,F\n0,1,3\n1,2,3\n2,3,3\n3,2,1\n4,1,1\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "record.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_what_simulate_writes_is_a_record(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    assert (
        main(f"simulate --preset coulomb -d 0.1 --t-end 20 --samples 41 --out {path}".split()) == 0
    )
    found = ss.read_measurements(path)
    motion = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=20)
    t = np.linspace(0, 20, 41)
    np.testing.assert_array_equal(found.t, t)
    np.testing.assert_array_equal(found.x, motion.x(t))
    np.testing.assert_array_equal(found.v, motion.v(t))
    assert found.blocks == (1, 2)
    second = ss.read_measurements(path, {"x": "x_2", "v": []}, d=0.1)
    np.testing.assert_array_equal(np.asarray(second.x)[:, 0], motion.x(t)[:, 1])
    assert second.v is None
    assert second.blocks == (2,)


@pytest.mark.parametrize("separator", [",", ";", "\t", " ; "])
def test_columns_of_an_instrument_in_its_units(tmp_path: Path, separator: str) -> None:
    rows = [["time [s]", "note", "pos, mm" if ";" in separator else "pos"]]
    rows += [[str(0.1 * k), "-", str(k * k)] for k in range(6)]
    text = "# made on a Monday\n" + "\n".join(separator.join(row) for row in rows) + "\n\n"
    found = ss.read_measurements(
        written(tmp_path, text), {"t": "time [s]", "x": rows[0][2]}, units=UNITS, sigma=0.5
    )
    np.testing.assert_allclose(found.t, 0.2 * np.arange(6), rtol=1e-14)
    np.testing.assert_allclose(np.asarray(found.x)[:, 0], 2.0 * np.arange(6) ** 2, rtol=1e-14)
    assert found.sigma == 1.0


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("speed,force\n0.1,0.9\n0.2,0.8\n", ss.ForcePoints),
        ("value,d\n0.1,0.9\n0.2,0.8\n", ss.MapPoints),
        ("times\n0.1\n0.2\n", ss.EventTimes),
        (RECORD, ss.Record),
    ],
)
def test_columns_tell_what_was_measured(tmp_path: Path, text: str, kind: type) -> None:
    more = {"d": 0.1} if kind is ss.EventTimes else {}
    assert type(ss.read_measurements(written(tmp_path, text), **more)) is kind


def test_what_is_missing_and_the_speed_of_the_belt(tmp_path: Path) -> None:
    rows = [f"{k},{k if k % 2 else ''},{'NaN' if k % 2 else k},0.5" for k in range(12)]
    path = written(tmp_path, "t,x,v,V\n" + "\n".join(rows))
    found = ss.read_measurements(path, units=UNITS)
    even = np.arange(12) % 2 == 0
    np.testing.assert_array_equal(np.isnan(found.x[:, 0]), even)
    np.testing.assert_array_equal(np.isnan(found.v[:, 0]), ~even)
    assert found.V == 0.5 / UNITS.scale("velocity")
    given = ss.read_measurements(path, {"V": []}, units=UNITS, V=1.5)
    assert given.V == 1.5 / UNITS.scale("velocity")


@pytest.mark.parametrize(
    ("text", "columns", "told"),
    [
        (RECORD.replace("3,2", "3;2"), None, "line 5 has 1 cells, and there are 2 columns"),
        (RECORD.replace("3,2", "3,two"), None, "line 5, column 'x': 'two' is not a number"),
        (RECORD.replace("3,2", ",2"), None, "line 5, column 't' is empty"),
        (RECORD.replace("3,2", "nan,2"), None, "line 5, column 't': nan is not a finite"),
        (RECORD.replace("3,2", "3,inf"), None, "line 5, column 'x': inf is not a finite"),
        (RECORD.replace("3,2", "3,"), None, "x of block 1 hold 4 numbers"),
        ("speed,force\n0.1,0.9\n0.2,\n", None, "line 3, column 'force' is empty"),
        ("t,x,V\n0,1,2\n1,2,3\n2,3,3\n3,2,3\n4,1,3\n", None, "column V holds 2 to 3"),
        (
            RECORD.replace("\n1,2\n2,3", "\n2,3\n# ?\n1,2").replace("t,x", "time,x"),
            {"t": "time"},
            "line 5, column 'time': 1 does not come after line 3, column 'time': 2: times must asc",
        ),
        (
            RECORD.replace("3,2", "3,1e300"),
            None,
            "line 5, column 'x': 1e.300 is not a .* at most 1e.1",
        ),
        ("t,x,sigma\n0,1,1\n1,1,0\n", None, "needs at least 5"),
        ("speed,force,sigma\n0,1,1\n1,1,0\n", None, "line 3, column 'sigma': 0: standard errors"),
        (RECORD.replace("3,2\n4,1\n", ""), None, "needs at least 5"),
        (RECORD.replace("t,x\n", ""), None, "must name the columns"),
        (RECORD.replace("t,x", "t,t"), None, "two columns have the name 't'"),
        (RECORD.replace("t,x", "T,pos"), None, "the columns are 'T', 'pos': .* Did you mean 't'"),
        (RECORD, {"x": "y"}, "no column 'y', for x. Known: t, x"),
        (RECORD, {"y": "x"}, "columns: 'y' is not measured"),
        (
            THREE,
            {"t": "t", "x": "x", "force": "F"},
            "'force' is nothing of Record.* leave it out",
        ),
        (THREE, {"speed": "t", "force": "F", "V": "x"}, "'V' is nothing of ForcePoints"),
        (RECORD, {"x": 3}, "names of columns are needed"),
        (RECORD, [1], "columns = "),
        ("t,x\n", None, "lines of numbers below"),
        ('t,x\n0,"1\n2,3\n', None, "quotation mark"),
    ],
)
def test_a_bad_file_is_told(tmp_path: Path, text: str, columns: object, told: str) -> None:
    with pytest.raises(ValueError, match=told) as refused:
        ss.read_measurements(written(tmp_path, text), columns)  # type: ignore[arg-type]
    about_columns = isinstance(columns, list) or "not measured" in told or "names of col" in told
    assert about_columns or str(refused.value).startswith(str(tmp_path / "record.csv"))


def test_a_file_that_is_not_there_and_units_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        ss.read_measurements(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="units = 3"):
        ss.read_measurements(written(tmp_path, RECORD), units=3)  # type: ignore[arg-type]


def test_columns_that_are_asked_for_come_before_those_that_are_there(tmp_path: Path) -> None:
    path = written(tmp_path, THREE.replace("F", "v"))
    assert type(ss.read_measurements(path, {"speed": "x", "force": "v"})) is ss.ForcePoints


def test_an_argument_of_another_kind_of_data_is_named(tmp_path: Path) -> None:
    path = written(tmp_path, "speed,force\n0.1,0.9\n0.2,0.8\n")
    with pytest.raises(ValueError, match=r"'sigma_v' is nothing of ForcePoints.*'sigma'"):
        ss.read_measurements(path, sigma_v=0.1)


def test_a_measured_stroke_tells_its_friction_and_that_the_form_is_another() -> None:
    # A pin rides on a stage that begins its way back, then slides: force over time, as published.
    path = Path(__file__).parent / "stroke.csv"
    assert "MIT License" in path.read_text(encoding="utf-8")
    units = ss.Units(m=1e-4, k=1.0, fs1=2.4e6)  # micronewtons: of the spring its force is told
    record = ss.read_measurements(path, {"t": "Time [s]", "x": "Friction [uN]"}, units=units)
    normal, position = np.loadtxt(path, comments="#", skiprows=len(notes(path)) + 1).T[1:3]
    pin = ss.Oscillator(V=0.03, friction=ss.Coulomb(mu=0.9), damping=2.0)
    found = ss.fit(pin, record, ["V", "mu"], pieces=1)
    sliding = found.values[1] * units.scale("force") / normal.mean()
    plateau = np.asarray(record.x)[-60:].mean() * units.scale("force") / normal.mean()
    assert sliding == pytest.approx(plateau, rel=0.01)
    assert 0.45 < sliding < 0.48
    speed = -np.polyfit(record.t, position, 1)[0] / units.scale("time")  # mm/s
    stiffness = found.values[0] * units.scale("velocity") / speed * 1e-6  # N/mm
    assert 35.0 < stiffness < 45.0
    assert "has another form" in found.message  # it gives way before it slides
    stribeck = pin.replace(friction=ss.Stribeck(mu=0.9, speed=0.05))
    other = ss.fit(stribeck, record, ["V", "mu", "speed"], pieces=1)
    ranked = ss.compare_fits([found, other])
    assert ranked.law[0] == "coulomb"  # one speed tells of no fall with speed
    assert ranked.aic_rise[1] == pytest.approx(2.0, abs=0.1)


def notes(path: Path) -> list[str]:
    """Lines of a file that are none of data."""
    return [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#")]
