"""The comparison of two drivers, and the table its counts go to."""

import numpy as np
import pytest
from tests.acceptance import drivers
from tests.acceptance.results import TABLE, read, record
from tests.acceptance.systems import paper_case
from tests.reference.settle import RIGHT, WRONG

POINTS = np.linspace(-0.4, 0.4, 4)


def compare(kind, share=0.0):
    return drivers.compare(paper_case(kind), POINTS, share, np.random.default_rng(1))


@pytest.mark.parametrize("kind", ["coulomb", "law9"])
def test_drivers_agree_on_the_papers_systems(kind):
    count = compare(kind)
    assert (count.maps, count.returned, count.differ) == (len(POINTS), len(POINTS), 0)
    assert not count.verdicts


@pytest.mark.parametrize(("kind", "answers"), [("coulomb", 2), ("law9", 1)])
def test_where_the_other_driver_is_wrong_the_package_is_found_right(monkeypatch, kind, answers):
    right = drivers.other_values
    monkeypatch.setattr(drivers, "other_values", lambda *given: right(*given) + 1e-9)
    count = compare(kind)
    assert (count.returned, count.differ) == (0, len(POINTS))
    assert count.verdicts == {RIGHT: len(POINTS) * answers}


class Shifted:
    """An event map with wrong values."""

    def __init__(self, right):
        self.derivative, self.evaluate, self.right = right.derivative, right.evaluate, right

    def __call__(self, d):
        return self.right(d) + 1e-11


def test_a_wrong_answer_of_the_package_is_found(monkeypatch):
    maps = drivers.event_maps
    monkeypatch.setattr(
        drivers, "event_maps", lambda system: {"pools": Shifted(maps(system)["pools"])}
    )
    count = compare("law9")
    assert count.verdicts == {WRONG: len(POINTS)}
    assert len(count.wrong) == len(POINTS)


def test_pieces_of_a_sample_are_added_up(tmp_path):
    counts = {
        "settled": 2,
        "wrong": 1,
        "excused": 0,
        "undecided": 3,
        "table": tmp_path / "table.csv",
    }
    record("one", answers=10, seconds=1.4, **counts)
    record("two", answers=20, seconds=0.6, **counts)
    record("one", answers=5, seconds=2.0, **counts)
    one, two = read(tmp_path / "table.csv")
    assert (one.sample, one.answers, one.settled, one.wrong, one.seconds) == ("one", 15, 4, 2, 3)
    assert (two.sample, two.answers, two.undecided) == ("two", 20, 3)


def test_the_table_that_is_kept_is_about_samples_there_are():
    rows = read(TABLE)
    assert set(drivers.SAMPLES.values()) <= {row.sample for row in rows}
    assert all(0 <= row.wrong + row.undecided <= row.answers for row in rows)
