"""`reproduce` writes whole files, the same bytes each time, and refuses before it computes."""

import json

import pytest

from stickslip import studies
from stickslip.studies import figures
from stickslip.studies.sources import GALVANETTO, source_named

PACKAGE = source_named(GALVANETTO).package

QUICK = (1, 2, 3)


def test_writes_every_format_and_the_table(tmp_path):
    done = studies.reproduce(QUICK, tmp_path / "out")
    names = {path.name for path in done.files}
    expected = {f"fig{n:02d}.{kind}" for n in QUICK for kind in ("svg", "pdf", "png")}
    assert names == expected | {"values.json", "values.md", "report.json", "report.md"}
    assert names == {path.name for path in (tmp_path / "out").iterdir()}


def test_a_second_run_writes_the_same_bytes(tmp_path):
    first = studies.reproduce((2,), tmp_path / "a")
    second = studies.reproduce((2,), tmp_path / "b")
    for one, other in zip(first.files, second.files, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_captions_are_in_the_table(tmp_path):
    studies.reproduce((3,), tmp_path, ("svg",))
    document = json.loads((tmp_path / "values.json").read_text())
    assert "gamma = 3, delta = 0.4" in document["figures"]["3"]
    assert "The paper prints no parameters" in document["figures"]["3"]


def test_other_files_in_the_folder_stay(tmp_path):
    (tmp_path / "mine.txt").write_text("keep")
    studies.reproduce((1,), tmp_path, ("svg",))
    assert (tmp_path / "mine.txt").read_text() == "keep"


def test_track_sees_the_figures_that_will_be_drawn(tmp_path):
    seen = []

    def track(numbers):
        seen.extend(numbers)
        return numbers

    studies.reproduce((2, 1, 2), tmp_path, ("svg",), track=track)
    assert seen == [1, 2]


@pytest.mark.parametrize("wrong", [(18,), (0,), (2, 99)])
def test_unknown_figure_lists_the_available(tmp_path, wrong):
    with pytest.raises(ValueError, match=r"cannot be computed\. Available figures: 1, 2, 3, 4, 5,"):
        studies.reproduce(wrong, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_unknown_format_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(ValueError, match="'jpg'"):
        studies.reproduce((1,), tmp_path / "out", ("jpg",))
    assert not (tmp_path / "out").exists()


def test_the_folder_may_not_be_a_file(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(OSError, match="out"):
        studies.reproduce((1,), tmp_path / "out")


def test_none_and_no_number_mean_all():
    known = tuple(figures.of_study(PACKAGE))
    assert figures.select(None, PACKAGE) == figures.select((), PACKAGE) == known


def test_every_figure_of_the_paper_can_be_computed():
    assert tuple(figures.of_study(PACKAGE)) == tuple(range(1, 18))
