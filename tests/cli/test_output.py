"""What commands write: files, whole or not there, documents and tables."""

import io
import json
import os
import stat
import sys
from contextlib import contextmanager

import numpy as np
import pytest

from stickslip.cli import main
from stickslip.cli.output import Spoken, document, error_document, new_files, new_folder, show_table
from stickslip.cli.process import REFUSED, RefusalError, UsageError
from stickslip.files import write_csv


def listing(folder):
    return sorted(path.name for path in folder.iterdir())


@contextmanager
def new_file(path, *, force):
    with new_files([path], force=force) as (temporary,), temporary.open("w") as stream:
        yield stream


def test_the_file_appears_under_its_name_at_the_end(tmp_path):
    path = tmp_path / "map.csv"
    with new_file(path, force=False) as stream:
        stream.write("d,value\n")
        assert not path.exists()
    assert path.read_text() == "d,value\n"
    assert listing(tmp_path) == ["map.csv"]


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_when_the_work_fails(tmp_path, failure):
    def work():
        with new_file(tmp_path / "map.csv", force=False) as stream:
            stream.write("half of a")
            stream.flush()
            raise failure

    with pytest.raises(failure):
        work()
    assert listing(tmp_path) == []


def test_an_existing_file_is_kept(tmp_path):
    path = tmp_path / "map.csv"
    path.write_text("precious")
    with pytest.raises(RefusalError, match="--force") as refusal, new_file(path, force=False):
        pass
    assert refusal.value.exit_code == REFUSED
    assert path.read_text() == "precious"


def test_force_replaces_and_failed_work_does_not(tmp_path):
    path = tmp_path / "map.csv"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), new_file(path, force=True):
        raise ZeroDivisionError
    assert path.read_text() == "old"
    with new_file(path, force=True) as stream:
        stream.write("new")
    assert path.read_text() == "new"


@pytest.mark.parametrize("name", ["missing/map.csv", "file/map.csv", "."])
def test_a_place_that_cannot_be_written_is_said_at_once(tmp_path, name):
    (tmp_path / "file").write_text("not a folder")
    path = tmp_path / name
    with pytest.raises(UsageError, match=r"map\.csv|folder"), new_file(path, force=False):
        pytest.fail("the work began")
    assert listing(tmp_path) == ["file"]


def test_the_file_is_as_readable_as_others(tmp_path):
    previous = os.umask(0o022)
    try:
        with new_file(tmp_path / "map.csv", force=False):
            pass
    finally:
        os.umask(previous)
    assert stat.S_IMODE((tmp_path / "map.csv").stat().st_mode) == 0o644


# --- several files ----------------------------------------------------------------------------


def test_several_files_appear_together(tmp_path):
    first, second = tmp_path / "fig.svg", tmp_path / "points.csv"
    with new_files([first, second], force=False) as (one, two):
        assert (one.name, two.name) == (first.name, second.name)
        one.write_text("picture")
        two.write_text("points")
        assert not first.exists()
    assert (first.read_text(), second.read_text()) == ("picture", "points")
    assert listing(tmp_path) == ["fig.svg", "points.csv"]


def test_none_of_several_is_touched_where_one_is_in_the_way(tmp_path):
    (tmp_path / "points.csv").write_text("precious")
    paths = [tmp_path / "fig.svg", tmp_path / "points.csv"]
    with pytest.raises(RefusalError, match="points"), new_files(paths, force=False):
        pytest.fail("the work began")
    assert listing(tmp_path) == ["points.csv"]


def test_a_folder_is_made_and_filled_at_the_end(tmp_path):
    folder = tmp_path / "new" / "out"
    with new_folder(folder, ["a", "b"], force=False) as (a, b):
        a.write_text("1")
        b.write_text("2")
        assert [path.is_dir() for path in folder.iterdir()] == [True, True]
    assert listing(folder) == ["a", "b"]


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_a_folder_made_for_failed_work_goes_again(tmp_path, failure):
    def work():
        with new_folder(tmp_path / "new" / "out", ["a"], force=False) as (a,):
            a.write_text("half")
            raise failure

    with pytest.raises(failure):
        work()
    assert listing(tmp_path) == []


def test_a_folder_keeps_what_else_is_in_it(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "mine").write_text("precious")
    (folder / "a").write_text("old")
    with pytest.raises(RefusalError, match="--force"), new_folder(folder, ["a"], force=False):
        pytest.fail("the work began")
    with pytest.raises(ZeroDivisionError), new_folder(folder, ["a", "b"], force=True) as (a, _):
        a.write_text(f"new {1 // 0}")
    assert (folder / "a").read_text() == "old"
    assert listing(folder) == ["a", "mine"]
    with new_folder(folder, ["a"], force=True) as (a,):
        a.write_text("new")
    assert (folder / "a").read_text() == "new"
    assert (folder / "mine").read_text() == "precious"


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "out").write_text("precious")
    with pytest.raises(UsageError, match="is a file"):
        with new_folder(tmp_path / "out", ["a"], force=True):
            pytest.fail("the work began")
    assert (tmp_path / "out").read_text() == "precious"


@pytest.mark.parametrize(
    "command",
    [
        "map -d 0.1 -d 0.2",
        "map --grid 50 --window 0.0 0.2",
        "orbits --max-period 2",
        "simulate -d 0.1 --t-end 20",
        "cycles --n-starts 3",
    ],
)
def test_a_table_becomes_a_picture_if_its_file_is_named_so(command, tmp_path, capsys):
    out = tmp_path / "picture.png"
    assert main([*command.split(), "--preset", "coulomb", "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert out.read_bytes().startswith(b"\x89PNG")
    assert list(tmp_path.iterdir()) == [out]


TABLE = {
    "value": np.array([0.1 + 0.2, np.nan, -np.inf]),
    "label": np.array([2**64 - 1, 0, 7], dtype=np.uint64),
    "status_name": ["OK", "NEVER_CYCLE", "OK"],
}


def test_a_document_has_the_four_parts():
    parts = json.loads(document("map", {"alpha": 1.2}, TABLE))
    assert parts == {
        "schema": 1,
        "command": "map",
        "parameters": {"alpha": 1.2},
        "result": {
            "value": [0.30000000000000004, None, None],
            "label": [2**64 - 1, 0, 7],
            "status_name": ["OK", "NEVER_CYCLE", "OK"],
        },
    }


def test_an_error_document_names_type_and_reason(monkeypatch):
    monkeypatch.setattr(Spoken, "options", dict)  # those of a command that ran before
    missing = FileNotFoundError(2, "No such file", "mine.toml")
    told = json.loads(error_document("map", missing))["error"]
    assert told == {"type": "FileNotFoundError", "message": "cannot use mine.toml: No such file"}
    parts = json.loads(error_document("map", ValueError("alpha = -1")))
    assert parts == {
        "schema": 1,
        "command": "map",
        "error": {"type": "ValueError", "message": "alpha = -1"},
    }


def test_csv_has_a_header_and_reads_back_exactly():
    stream = io.StringIO()
    write_csv(stream, TABLE)
    assert stream.getvalue().splitlines() == [
        "value,label,status_name",
        "0.30000000000000004,18446744073709551615,OK",
        "nan,0,NEVER_CYCLE",
        "-inf,7,OK",
    ]


def test_csv_writes_lists_into_one_cell_and_nothing_for_none():
    stream = io.StringIO()
    write_csv(
        stream, {"points": [[0.1 + 0.2, 1.0], []], "block": [None, 2], "x": [np.float64(1)] * 2}
    )
    assert stream.getvalue().splitlines() == [
        "points,block,x",
        "0.30000000000000004 1.0,,1.0",
        ",2,1.0",
    ]


@pytest.mark.parametrize("width", [10, 40, 60, 200])
def test_no_terminal_is_too_narrow_for_a_number(width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    columns = {"left": [-0.676471, 0.5], "right": [0.123456e-17, 1.0], "cause": ["end of it"] * 2}
    show_table(columns)
    told = capsys.readouterr().out
    assert all(number in told for number in ("-0.676471", "1.23456e-18", "0.5", "left", "right"))
