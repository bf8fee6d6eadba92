"""What lies between two values of a parameter, foretold from what is seen at them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.analysis.bifurcations.conditions.conditions import Fold
from stickslip.analysis.bifurcations.scan.near_misses import NearZero, _extrema, hidden_values
from stickslip.analysis.bifurcations.scan.nodes import Family, Node
from stickslip.analysis.branches.mesh import Nodes, _sign_is_sure
from stickslip.analysis.maps.piecewise_map import PiecewiseMap

WIDTH = 1.0  # of a domain


def hidden(values, distances):
    return hidden_values(
        values, [[NearZero("a fold", 0.3, y, Fold(1, (0.3,)))] for y in distances], WIDTH
    )


@given(
    touch=st.floats(0.55, 1.45),
    curvature=st.floats(0.2, 5.0) | st.floats(-5.0, -0.2),
    last=st.floats(1.6, 3.0),
)
def test_a_function_that_touches_zero_between_two_values_is_foretold_there(touch, curvature, last):
    values = [0.0, 1.0, last]
    found = hidden(values, [curvature * (q - touch) ** 2 for q in values])
    if min(abs(touch - q) for q in values) > 0.05:
        assert found == [pytest.approx(touch, abs=1e-9)]


def test_slopes_beyond_the_range_of_floats_foretell_nothing(monkeypatch):
    f = PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.2})
    node = Node.make(Family(f, "r"), 2, 3.2)
    n_found = len(list(_extrema(node, 2)))
    fast = node.fast

    class Steep:
        def iterate_with_slopes(self, x, n):
            orbit, slopes = fast.iterate_with_slopes(x, n)
            return orbit, np.sign(slopes) * 1e300

    monkeypatch.setitem(vars(node), "fast", Steep())
    assert 0 < len(list(_extrema(node, 2))) <= n_found


def test_nothing_is_foretold_of_a_function_that_turns_far_from_zero():
    values = [0.0, 1.0, 2.0]
    assert hidden(values, [1e3 + (q - 0.8) ** 2 for q in values]) == []
    assert hidden(values, [-((q - 0.8) ** 2) - 1e3 for q in values]) == []
    assert hidden(values, [1.0 - (q - 0.8) ** 2 for q in values]) == []  # away from zero
    assert hidden(values, [-1.0, 0.1, 2.0]) == []  # the lists at both ends show the change


def test_what_comes_closer_to_zero_is_foretold_first():
    values = [0.0, 1.0, 2.0, 3.0, 4.0]
    distances = [(0.05 if q < 2 else 0.01) + (abs(q - 2) - 0.6) ** 2 for q in values]
    nearer, farther = hidden(values, distances)
    assert 2 < nearer < 3
    assert 1 < farther < 2


def cells(left, right, slopes_left, slopes_right):
    def nodes(x, value, slope):
        n = len(slope)
        fill = np.ones(n)
        return Nodes(
            np.full(n, x), value, slope, np.ones(n, dtype=np.uint64), fill.astype(bool), fill
        )

    return nodes(0.0, left, slopes_left), nodes(1.0, right, slopes_right)


@given(values=st.lists(st.floats(-2, 2), min_size=4, max_size=4), error=st.floats(0.0, 0.3))
def test_whether_a_slope_keeps_its_sign_is_as_sure_of_the_mirror_image(values, error):
    start, end, first, last = (np.array([v]) for v in values)
    sure = _sign_is_sure(*cells(start, end, first, last), np.array([error]))
    mirrored = _sign_is_sure(*cells(-start, -end, -first, -last), np.array([error]))
    assert sure == mirrored


def test_a_slope_is_not_sure_of_its_sign_next_to_zero():
    zero, slope = np.zeros(1), np.array([0.01])
    rising = cells(zero, np.array([0.01]), slope, slope)  # a line of slope 0.01
    assert _sign_is_sure(*rising, np.array([1e-4]))
    assert not _sign_is_sure(*rising, np.array([1.0]))
