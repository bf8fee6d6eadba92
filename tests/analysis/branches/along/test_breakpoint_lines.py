"""Breakpoints followed over many values: against closed forms, and born and lost on the way."""

import numpy as np
import pytest

from stickslip import examples
from stickslip.analysis.branches.along.breakpoint_lines import follow_breakpoints
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.mechanics.eventmap.of_model import event_map


def followed(f, name, values, n_anchors=3):
    maps = [f.replace(**{name: float(q)}) for q in values]
    places = np.linspace(0, len(values) - 1, n_anchors).astype(int)
    anchors = [(float(values[k]), branch_table(maps[k])) for k in places]
    return follow_breakpoints(maps, values, anchors)


def moving(func, **parameters):
    """Map of [0, 1] that breaks where x passes sin(c) / 2 + c / 10."""
    return PiecewiseMap(
        func,
        (0.0, 1.0),
        parameters=parameters,
        breakpoints=lambda c: [np.sin(c) / 2 + c / 10],
    )


def place(c):
    return np.sin(c) / 2 + c / 10


VALUES = np.linspace(0.3, 1.1, 57)


@pytest.mark.parametrize(
    ("kind", "func"),
    [
        ("jump", lambda x, c: np.where(x < place(c), 0.2 + 0.3 * x, 0.9 - 0.4 * x)),
        ("corner", lambda x, c: 0.2 + 0.6 * np.abs(x - place(c))),
        ("edge", lambda x, c: np.where(x < place(c), 0.3 + 0.5 * x, np.nan)),
    ],
)
def test_each_kind_is_followed(kind, func):
    (line,) = followed(moving(func, c=0.5), "c", VALUES)
    assert line.kind == kind
    np.testing.assert_allclose(line.d, place(VALUES), rtol=0, atol=3e-12)


def test_smooth_changes_of_label_are_left_out():
    f = moving(lambda x, c: 0.2 + 0.5 * x, c=0.5)
    assert followed(f, "c", VALUES) == ()


def test_a_jump_that_closes_is_lost_there_and_found_again_behind():
    """The jump's height c - 1/2 passes zero; near zero there is nothing to see."""
    f = PiecewiseMap(
        lambda x, c: np.where(x < 0.4, 0.3 * x, 0.3 * x + (c - 0.5)),
        (0.0, 1.0),
        parameters={"c": 0.3},
        breakpoints=[0.4],
    )
    values = np.linspace(0.3, 0.7, 40)
    lines = followed(f, "c", values)
    seen = np.isfinite([line.d for line in lines])
    assert np.all(seen.sum(axis=0)[np.abs(values - 0.5) > 0.02] == 1)
    for line in lines:
        np.testing.assert_allclose(line.d[np.isfinite(line.d)], 0.4, rtol=0, atol=1e-11)


def test_a_break_that_enters_the_domain_begins_there():
    """The break 2 (c - 0.6) is inside [0, 1] from c = 0.6 on."""
    f = PiecewiseMap(
        lambda x, c: np.where(x < 2 * (c - 0.6), 0.8, 0.2 + 0.1 * x),
        (0.0, 1.0),
        parameters={"c": 0.5},
        breakpoints=lambda c: [2 * (c - 0.6)] if 0.6 < c < 1.1 else [],
    )
    values = np.linspace(0.4, 1.0, 61)
    (line,) = followed(f, "c", values)
    exists = values > 0.6 + 1e-9
    np.testing.assert_allclose(line.d[exists], 2 * (values[exists] - 0.6), rtol=0, atol=3e-12)
    assert np.isnan(line.d[values < 0.6 - 1e-9]).all()


def test_a_break_that_leaves_the_domain_ends_there_though_another_is_near():
    """Of jumps at -c and 0.04 - c the first is inside [0, 1] for c < 0 only."""
    f = PiecewiseMap(
        lambda x, c: 0.1 + 0.3 * (x > -c) + 0.3 * (x > 0.04 - c),
        (0.0, 1.0),
        parameters={"c": 0.0},
        breakpoints=lambda c: [d for d in (-c, 0.04 - c) if d > 0],
    )
    values = np.linspace(-0.02, 0.02, 40)
    first, second = followed(f, "c", values)
    expected = np.where(values < 0, -values, np.nan)
    np.testing.assert_allclose(first.d, expected, rtol=0, atol=3e-12)
    np.testing.assert_allclose(second.d, 0.04 - values, rtol=0, atol=3e-12)


def test_lines_of_an_event_map_are_its_breakpoints():
    """Branches beside these jumps change their labels on the way."""
    values = np.linspace(0.0366, 0.0372, 41)
    f = event_map(examples.coulomb())
    lines = followed(f, "V", values)
    assert len(lines) == 6
    assert np.isfinite([line.d for line in lines]).all()
    table = branch_table(f.replace(V=float(values[13])))
    jumps = [item.d for item in table.breakpoints if item.kind != "smooth"]
    np.testing.assert_allclose([line.d[13] for line in lines], jumps, rtol=0, atol=3e-12)


def test_margins_foretell_breaks_in_few_evaluations(monkeypatch):
    """Halving took 21 for each break and value: where motions never return, most of a diagram."""
    values = np.linspace(0.0366, 0.0372, 41)
    f = event_map(examples.coulomb())
    maps = [f.replace(V=float(q)) for q in values]
    anchors = [(float(values[k]), branch_table(maps[k])) for k in (0, -1)]
    counts = []
    plain = type(f).evaluate

    def counting(self, d):
        counts.append(np.size(d))
        return plain(self, d)

    monkeypatch.setattr(type(f), "evaluate", counting)
    lines = follow_breakpoints(maps, values, anchors)
    assert sum(counts) <= 8 * np.isfinite([line.d for line in lines]).sum()
