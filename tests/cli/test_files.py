"""A file is whole or not there, and never replaced unasked."""

import os
import stat

import pytest

from stickslip.cli.failure import REFUSED, RefusalError, UsageError
from stickslip.cli.files import new_file


def listing(folder):
    return sorted(path.name for path in folder.iterdir())


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
