"""A map that remembers asks for nothing twice and changes nothing."""

import numpy as np
import pytest
from tests.analysis.known_maps import logistic

from stickslip.analysis.bifurcations.conditions.conditions import Connection
from stickslip.analysis.bifurcations.crisis.crises import RememberingMap
from stickslip.analysis.branches.along.tracked import TurningPoint
from stickslip.analysis.maps.derived import WindowMap


class Counting:
    """A map that counts how often it is asked."""

    def __init__(self, f):
        self.f, self.calls = f, 0

    def __getattr__(self, name):
        return getattr(self.f, name)

    def evaluate(self, x):
        self.calls += 1
        return self.f.evaluate(x)


def test_conditions_read_the_same_from_memory():
    counting = Counting(logistic(3.7))
    f = RememberingMap(counting)
    fixed = 1 - 1 / 3.7
    readings, calls = [], []
    for k in (3, 3, 4):
        readings.append(Connection(TurningPoint(0.49), 1, k, (fixed,)).at(f))
        calls.append(counting.calls)
    assert calls[0] == calls[1] < calls[2] <= calls[1] + 2
    plain = Connection(TurningPoint(0.49), 1, 4, (fixed,)).at(logistic(3.7))
    assert readings[2].value == plain.value
    assert readings[2].noise == plain.noise


def test_the_whole_of_a_window_remembers_too():
    counting = Counting(logistic(3.7))
    f = RememberingMap(WindowMap(counting, (0.2, 0.9)))
    assert f.domain == (0.2, 0.9)
    for _ in range(2):
        assert f.whole.evaluate(0.1).value == pytest.approx(3.7 * 0.09)
        assert f.evaluate(np.array([0.3])).value == pytest.approx(3.7 * 0.21)
    assert counting.calls == 2
    with pytest.raises(ValueError, match="outside"):
        f.evaluate(0.1)
