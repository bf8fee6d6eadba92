"""Samples in pieces, on several processes and by the clock."""

import math
import pickle

import pytest
from tests.acceptance.judge import Tally
from tests.acceptance.pieces import carried_out
from tests.acceptance.systems import paper_case
from tests.reference.settle import WRONG, settle


@pytest.mark.parametrize(("seconds", "done"), [(math.inf, [1.0, 2.0, 3.0]), (0.0, [])])
def test_tasks_are_done_in_order_and_none_is_begun_too_late(seconds, done):
    pieces = list(carried_out(math.sqrt, [1, 4, 9], jobs=2, seconds=seconds))
    assert [piece for piece, _ in pieces] == done
    assert all(took >= 0 for _, took in pieces)


def test_a_wrong_answer_crosses_processes_as_text():
    system, tally = paper_case("coulomb"), Tally()
    verdict = settle(system.oracle(), 0.1, 0.2, "OK", system.tolerance)
    tally.add(system, "exact", verdict)
    tally = pickle.loads(pickle.dumps(tally))
    assert tally.verdicts == {WRONG: 1}
    assert "TwoBlock(alpha=1.2" in str(tally)
    assert "wrong: d=0.1 value=0.2" in str(tally)
