"""Orbits of several maps side by side."""

import numpy as np
import pytest
from tests.analysis.known_maps import logistic

import stickslip as ss
from stickslip.analysis.maps import side_by_side as module
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import advance, advance_each
from stickslip.analysis.maps.side_by_side import side_by_side

WINDOW = (0.379, 0.390)


def law9(alpha):
    return WindowMap(ss.event_map(ss.examples.law9().replace(alpha=alpha)), WINDOW)


@pytest.mark.parametrize("family", [logistic, law9])
def test_several_maps_advance_as_each_does(family):
    parameters = (3.2, 3.9, 4.1) if family is logistic else (1.209, 1.211, 1.218)
    maps = [family(r) for r in parameters]
    lo, hi = maps[0].domain
    xs = [np.array([np.nan, 0.5 * (lo + hi)]), np.array([hi + 1.0]), np.linspace(lo, hi, 5)]
    for f, x, orbits in zip(maps, xs, advance_each(maps, xs, 9), strict=True):
        np.testing.assert_array_equal(orbits, advance(f, x, 9))
    assert np.isnan(advance_each(maps[:1], [np.array([np.nan])], 3)).all()


def test_tasks_get_what_they_ask_for(monkeypatch):
    """Of any lengths, whoever else asks; a task may ask for nothing, and several in one go."""
    launches = []

    def counted(maps, xs, n):
        launches.append(n)
        return advance_each(maps, xs, n)

    monkeypatch.setattr(module, "advance_each", counted)

    def task(f, lengths):
        x, seen = np.array([0.1, 0.7]), []
        for n in lengths:
            orbits = yield f, x, n
            np.testing.assert_array_equal(orbits, advance(f, x, n))
            x = orbits[:, -1]
            seen.append(orbits.shape[1] - 1)
        return seen

    plans = [(3, 40), (), (25,), (8, 8, 8, 8), (1,)]
    tasks = [task(logistic(3.0 + 0.1 * k), plan) for k, plan in enumerate(plans)]
    assert side_by_side(tasks) == [list(plan) for plan in plans]
    assert len(launches) < 12
    assert side_by_side([]) == []
