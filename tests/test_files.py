"""Files are read where they are ordinary, and what is wrong with them is said with their name."""

import errno
import os
import resource
from contextlib import contextmanager
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from stickslip.files import checked_path, read_text, whole_file, write_csv, write_text


def test_imaginary_parts_have_a_column_of_their_own_in_csv():
    columns = {"n": [1, 2], "m": [(0.5 + 0.25j, -1.0), (3.0,)], "z": np.array([1j, 2.0]), "x": "ab"}
    write_csv(stream := StringIO(newline=""), columns)
    assert stream.getvalue().splitlines() == [
        "n,m,m_imag,z,z_imag,x",
        "1,0.5 -1.0,0.25 0.0,0.0,1.0,a",
        "2,3.0,0.0,2.0,0.0,b",
    ]


def test_text_comes_back_as_it_stands(tmp_path):
    path = tmp_path / "ä.txt"
    path.write_bytes("\ufeffone\r\nzwö\n".encode())
    assert read_text(path) == read_text(str(path)) == "one\r\nzwö\n"


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/full", "folder", "pipe"])
def test_what_is_no_ordinary_file_is_neither_opened_nor_replaced(tmp_path, name):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    before = list(tmp_path.iterdir())
    path = tmp_path / name
    for use in (read_text, lambda path: write_text(path, "text")):
        with pytest.raises(OSError, match=r"Is a directory|it is a device or a pipe") as error:
            use(path)
        assert error.value.filename == str(path)
    assert list(tmp_path.iterdir()) == before


def test_a_file_may_be_as_large_as_the_limit(tmp_path):
    path = tmp_path / "text"
    path.write_text("x" * 10)
    assert read_text(path, limit=10) == "x" * 10
    with pytest.raises(ValueError, match=r"text: is too large: more than 9 bytes"):
        read_text(path, limit=9)


def test_the_byte_that_is_not_utf8_is_named(tmp_path):
    path = tmp_path / "text"
    path.write_bytes(b"one\ntw\xff\n")
    with pytest.raises(ValueError, match=r"text: not UTF-8 text: byte 0xff in line 2"):
        read_text(path)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError) as error:
        read_text(tmp_path / "none")
    assert error.value.filename == str(tmp_path / "none")


@pytest.mark.parametrize(
    "path", [[10**5000], None, 3, b"file", "", "a\0b", ["file"], "\0" * 100_000]
)
def test_a_path_is_text_or_a_path(path):
    with pytest.raises(ValueError, match=r"^path = ") as error:
        checked_path(path)
    assert len(str(error.value)) < 300
    assert checked_path("file") == checked_path(Path("file")) == Path("file")


@contextmanager
def a_disk_with_room_for(size):
    """Let no file of this process grow further: the system's own refusal."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_names_the_file_and_leaves_nothing(tmp_path):
    path = tmp_path / "text"
    path.write_text("old")
    with a_disk_with_room_for(1000), pytest.raises(OSError, match="too large") as error:
        write_text(path, "x" * 10_000)
    assert error.value.errno == errno.EFBIG
    assert error.value.filename == str(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_file_that_is_named_is_the_one_that_did_not_fit(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"

    def work():
        with whole_file(one) as first, whole_file(two) as second:
            write_text(second, "fits")
            write_text(first, "x" * 10_000)

    with a_disk_with_room_for(1000), pytest.raises(OSError, match="too large") as error:
        work()
    assert error.value.filename == str(one)
    assert list(tmp_path.iterdir()) == []


def test_errors_of_other_files_keep_their_names(tmp_path):
    with pytest.raises(FileNotFoundError) as error, whole_file(tmp_path / "text"):
        read_text(tmp_path / "none")
    assert error.value.filename == str(tmp_path / "none")


def test_a_name_may_be_as_long_as_the_system_allows(tmp_path):
    path = tmp_path / ("ä" * 125 + ".txt")
    write_text(path, "text")
    assert read_text(path) == "text"


def test_a_folder_that_is_not_there_is_said_by_the_files_name(tmp_path):
    path = tmp_path / "none" / "text"
    with pytest.raises(FileNotFoundError) as error:
        write_text(path, "text")
    assert error.value.filename == str(path)


def test_a_link_stays_and_leads_to_what_was_written(tmp_path):
    link, file = tmp_path / "link", tmp_path / "folder" / "file"
    file.parent.mkdir()
    link.symlink_to(file)
    write_text(link, "one")
    write_text(link, "two")
    assert link.is_symlink()
    assert file.read_text() == "two"
