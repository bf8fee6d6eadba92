"""Samples of two sizes: the small one in every run, the large one in `make evidence`."""

import sys

import pytest
from hypothesis import settings


def slow(*cases):
    """Arguments of a test, or tuples of them, for `make evidence` alone."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)
        for case in cases
    ]


def sizes(few, many):
    """Arguments of a test, or tuples of them, for a small and a large sample: that one is slow."""
    return [few, *slow(many)]


def tries(few, many):
    """How many random examples a property is tried with, in every run and in `make evidence`."""
    in_evidence = settings.get_current_profile_name() == "many"
    return settings(max_examples=many if in_evidence else few)


def calls_in(work):
    """What some work returns, and how many calls of functions it makes: no clock says as much."""
    calls, before = 0, sys.getprofile()

    def count(_, event, __):
        nonlocal calls
        calls += event.endswith("call")

    sys.setprofile(count)
    try:
        result = work()
    finally:
        sys.setprofile(before)
    return result, calls
