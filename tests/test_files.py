"""Files are read where they are ordinary, and what is wrong with them is said with their name."""

import os
from pathlib import Path

import pytest

from stickslip.files import checked_path, read_text


def test_text_comes_back_as_it_stands(tmp_path):
    path = tmp_path / "ä.txt"
    path.write_bytes("\ufeffone\r\nzwö\n".encode())
    assert read_text(path) == read_text(str(path)) == "one\r\nzwö\n"


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/full", "folder", "pipe"])
def test_what_may_have_no_end_is_not_opened(tmp_path, name):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ValueError, match=f"{name}: is a folder, a device or a pipe"):
        read_text(tmp_path / name)


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


@pytest.mark.parametrize("path", [None, 3, b"file", "", "a\0b", ["file"], "\0" * 100_000])
def test_a_path_is_text_or_a_path(path):
    with pytest.raises(ValueError, match=r"^path = ") as error:
        checked_path(path)
    assert len(str(error.value)) < 300
    assert checked_path("file") == checked_path(Path("file")) == Path("file")
