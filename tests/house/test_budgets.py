"""The sizes of the house are counted rightly, and kept."""

import json

from tests.house import budgets

SOURCE = """
import math
SMALL = 1e-9
LIST = (1, 2)
NAMED: int = -3
PRODUCT = 2 * 0.5
def _once(): pass
def _twice(): pass
def _never(): pass
class Thing:
    def _method(self): return _once() + _twice() + _twice()
    def asked(self): return self._method()
"""


def test_constants_and_functions_used_once_are_counted(tmp_path):
    file = tmp_path / "module.py"
    file.write_text(SOURCE)
    assert budgets.constants(file) == ["SMALL", "NAMED", "PRODUCT"]
    assert budgets.used_once(file) == ["_method", "_once"]


def test_a_count_above_and_one_far_below_are_told():
    told = budgets.failures({"a": 101, "b": 99, "c": 50, "d": 1}, {"a": 100, "b": 100, "c": 100})
    assert [line.split(":")[0] for line in told] == ["a", "c", "d"]


def test_the_house_keeps_its_budgets():
    known = json.loads(budgets.BUDGETS.read_text(encoding="utf-8"))
    assert budgets.failures(budgets.counts(), known) == []


def test_rooms_of_analysis_are_few_and_small():
    found = budgets.counts()
    assert found["storeys of analysis"] <= 8
    assert found["most files in a room of analysis"] <= 12
