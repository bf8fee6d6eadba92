"""The interpolated table of a map against the map itself."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.branches.test_branches import CANTOR
from tests.analysis.known_maps import (
    border_collision,
    doubling,
    logistic,
    square_root,
    tent,
    tent_with_hole,
)

from stickslip import examples
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.interpolation.interpolated import interpolated_map, stand_in
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.maps.protocol import Map1D, iterate, sample
from stickslip.analysis.scales import FINE
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.status import OK

LUCK = 2.0  # estimates come from the middles of cells; elsewhere an error may be a little larger
SLOPES = 1e-3  # of the largest slope: what errors of 1e-9 in the values allow


def wavy(bend):
    """Smooth, so that nothing but the width of the cells decides about the error."""
    return PiecewiseMap(
        lambda x, bend: np.sin(bend * x) * np.exp(-x),
        (0.0, 2.0),
        parameters={"bend": bend},
        derivative=lambda x, bend: (bend * np.cos(bend * x) - np.sin(bend * x)) * np.exp(-x),
    )


def steep():
    """A graze: slope finite, its derivative infinite, on the right of 0."""
    return PiecewiseMap(
        lambda x: np.where(x < 0, 0.3 - x, 0.3 + 0.5 * x - np.maximum(x, 0) ** 1.5),
        (-1.0, 1.0),
        derivative=lambda x: np.where(x < 0, -1.0, 0.5 - 1.5 * np.sqrt(np.maximum(x, 0))),
        breakpoints=[0.0],
    )


MAPS = {
    "logistic": lambda: logistic(3.7),
    "tent": lambda: tent(1.5),
    "doubling": lambda: doubling(2.5),
    "hole": lambda: tent_with_hole(3.0),
    "jump": lambda: border_collision(jump=0.3),
    "square root": lambda: square_root(0.3, 0.05),
    "wavy": lambda: wavy(9.0),
    "graze": steep,
    "coulomb": lambda: EventMap(examples.coulomb()),
    "law 9": lambda: WindowMap(EventMap(examples.law9(alpha=1.213)), (0.379, 0.390)),
}


@pytest.fixture(params=MAPS)
def pair(request):
    f = MAPS[request.param]()
    return f, interpolated_map(branch_table(f))


def test_errors_are_what_is_estimated_and_small(pair):
    f, fast = pair
    x = np.random.default_rng(1).uniform(*f.domain, 3000)
    true, found = sample(f, x), fast.evaluate(x)
    ok = true.status == OK
    assert np.array_equal(found.status == OK, ok)
    off = np.abs(true.value - found.value)[ok]
    assert fast.error <= LUCK * FINE * fast.table.laps.value_scale
    assert off.max() <= LUCK * fast.error + 1e-15
    assert np.array_equal(found.label[ok], true.label[ok])
    slopes = np.abs(true.derivative[ok])
    # Beside a root the slope is as large as one likes, and so is its error.
    usual = slopes < 1e3
    allowed = SLOPES * slopes[usual].max()
    assert np.abs(true.derivative - found.derivative)[ok][usual].max() <= allowed


def test_iteration_is_repeated_evaluation(pair):
    f, fast = pair
    assert isinstance(fast, Map1D)
    x = np.random.default_rng(2).uniform(*f.domain, (5, 4))
    points, slopes = fast.iterate_with_slopes(x, 6)
    assert points.shape == (5, 4, 7)
    assert slopes.shape == (5, 4, 6)
    plain = iterate(replace(fast), x, 6)  # its own iteration and the loop over values
    stepped = np.stack([x], axis=-1)
    for _ in range(6):
        stepped = np.concatenate([stepped, sample(fast, stepped[..., -1:]).value], axis=-1)
    assert np.array_equal(plain, points, equal_nan=True)
    assert np.array_equal(stepped, points, equal_nan=True)
    assert np.array_equal(sample(fast, points[..., :-1]).derivative, slopes, equal_nan=True)


def test_values_at_breaks_are_the_one_sided_limits(pair):
    f, fast = pair
    laps = fast.table.laps
    lo, hi = f.domain
    inner = laps.right[laps.right < hi]
    after = np.nextafter(inner, hi)
    before = np.nextafter(inner, lo)
    for x, y in zip(before, laps.value_right[laps.right < hi], strict=True):
        value = float(fast.evaluate(x).value)
        assert np.isnan(value) or value == pytest.approx(y, abs=1e-7 * laps.value_scale)
    for x in after:
        k = int(laps.locate(np.array([x]))[0])
        if k >= 0 and x - laps.left[k] < 1e-12:
            value = float(fast.evaluate(x).value)
            assert value == pytest.approx(laps.value_left[k], abs=1e-7 * laps.value_scale)


@settings(max_examples=20)
@given(bend=st.floats(0.5, 30.0))
def test_a_smooth_map_is_met_to_its_accuracy(bend):
    f = wavy(bend)
    fast = interpolated_map(branch_table(f))
    x = np.random.default_rng(3).uniform(0, 2, 500)
    assert fast.error <= LUCK * FINE * fast.table.laps.value_scale
    assert np.abs(f(x) - fast.evaluate(x).value).max() <= LUCK * fast.error + 1e-15


def test_a_square_root_is_met_exactly():
    f = square_root(0.3, 0.05)
    fast = interpolated_map(branch_table(f))
    x = 10.0 ** np.linspace(-13, 0, 200)
    assert np.abs(f(x) - fast.evaluate(x).value).max() <= 2e-9


def test_a_graze_needs_few_cells():
    fast = interpolated_map(branch_table(steep()))
    assert len(fast.cell_labels) - len(fast.table.laps.cells) < 500


def test_a_branch_that_the_table_does_not_know_is_noticed():
    plain = logistic(3.7)
    other = PiecewiseMap(
        lambda x: 3.7 * x * (1 - x) + np.where((x > 0.31) & (x < 0.36), 1e-3, 0.0),
        (0, 1),
        derivative=lambda x: 3.7 * (1 - 2 * x),
    )
    wrong = replace(branch_table(plain), f=other)
    assert interpolated_map(wrong).error > 1e-5


def test_where_branches_are_too_narrow_values_are_as_likely_as_the_true_ones():
    table = branch_table(CANTOR)
    fast = interpolated_map(table)
    x = np.random.default_rng(0).uniform(*table.unknown.T, (1000, len(table.unknown))).ravel()
    for values in (fast.evaluate(x).value, fast.iterate(x, 1)[:, 1]):
        quarters, true = (np.quantile(v, [0.25, 0.5, 0.75]) for v in (values, CANTOR(x)))
        assert quarters == pytest.approx(true, abs=0.05)
    assert (fast.evaluate(x).status == OK).all()
    start = np.linspace(0.01, 0.99, 50)
    (orbit, slope), true = fast.iterate_with_slopes(start, 400), iterate(CANTOR, start, 400)
    assert np.isfinite(orbit).all()
    shares = [np.mean(table.labels_at(each) == 0) for each in (orbit, true)]
    assert shares[0] == pytest.approx(shares[1], abs=0.02)
    assert shares[1] > 0.05
    exponent = np.log(CANTOR.derivative(true[:, :-1])).mean()
    assert np.log(slope).mean() == pytest.approx(exponent, abs=0.05)


def test_where_branches_are_too_narrow_the_true_map_can_be_asked():
    fast = stand_in(CANTOR, asks=True)
    x = np.random.default_rng(0).uniform(*fast.table.unknown.T).ravel()
    np.testing.assert_array_equal(fast.evaluate(x).value, CANTOR(x))
    np.testing.assert_array_equal(fast.iterate(x, 1)[:, 1], CANTOR(x))
    assert "_with_estimates" not in vars(fast)  # taken for estimates alone


def test_gaps_say_why_there_is_no_value():
    f = EventMap(examples.law9(alpha=1.213))
    fast = interpolated_map(branch_table(f))
    (low, high) = branch_table(f).gaps[0]
    middle = 0.5 * (low + high)
    assert fast.evaluate(middle).status == f.evaluate(middle).status != OK
    assert np.isnan(fast.iterate(middle, 3)[1:]).all()


def test_points_outside_and_negative_counts_are_refused():
    fast = interpolated_map(branch_table(tent(1.5)))
    with pytest.raises(ValueError, match="outside the domain"):
        fast.evaluate(1.2)
    with pytest.raises(ValueError, match="n = -1"):
        fast.iterate(0.5, -1)
