"""A short sample of random structures, and that a wrong answer is found."""

import numpy as np
import pytest
from tests.acceptance import structures
from tests.reference.settle import WRONG


@pytest.mark.parametrize(
    ("kind", "n", "answers"),
    [("own", 30, 30), ("shared", 30, 30), ("elastic", 20, 20), ("maps", 3, 60), ("returns", 3, 6)],
)
def test_no_answer_is_wrong(kind: str, n: int, answers: int) -> None:
    _, count = structures.piece((kind, 0, n))
    assert count.wrong == []
    assert count.structures == n
    assert count.answers >= answers
    assert count.alike > 0.5 * count.answers


def test_a_wrong_answer_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    right = structures.told

    def shifted(model, q, v):  # type: ignore[no-untyped-def]
        motion = right(model, q, v)
        motion.q = motion.q + 1e-9 * np.arange(1, len(q) + 1)
        return motion

    monkeypatch.setattr(structures, "told", shifted)
    _, count = structures.piece(("own", 0, 3))
    assert count.verdicts == {WRONG: 3}


def test_starts_beside_another_sequence_of_events() -> None:
    _, count = structures.piece(("near", 0, 2))
    assert count.wrong == []
    assert count.alike > 30
