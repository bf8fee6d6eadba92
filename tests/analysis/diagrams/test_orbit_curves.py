"""Orbits solved for at many values, between a few at which they are known."""

import numpy as np
import pytest
from tests.analysis.known_maps import logistic

from stickslip.analysis.diagrams.orbit_curves import SampledOrbit, fill
from stickslip.analysis.maps.protocol import PointValues


def two_cycle(r):
    r = np.asarray(r)[..., None]
    root = np.sqrt((r - 3) * (r + 1))
    return np.concatenate([(r + 1 - root) / (2 * r), (r + 1 + root) / (2 * r)], axis=-1)


def strand(values, roots=(True, False)):
    values = np.array(values)
    return SampledOrbit(values, two_cycle(values), 4 + 2 * values - values**2, roots)


def filled(known, values):
    maps = [logistic(float(r)) for r in values]
    (points, multipliers), *_ = fill(maps, np.asarray(values), [known])
    return points, multipliers


def test_a_few_known_places_suffice_up_to_the_birth():
    values = np.linspace(2.9, 3.6, 71) + 0.003
    points, multipliers = filled(strand([3.0, 3.2, 3.4, 3.6]), values)
    inside = (values > 3.0) & (values <= 3.6)
    np.testing.assert_array_equal(np.isfinite(multipliers), inside)
    np.testing.assert_allclose(points[inside], two_cycle(values[inside]), rtol=0, atol=1e-9)
    expected = 4 + 2 * values[inside] - values[inside] ** 2
    np.testing.assert_allclose(multipliers[inside], expected, rtol=0, atol=1e-7)


def test_nothing_is_entered_outside_the_strand():
    values = np.linspace(3.1, 3.5, 21)
    _, multipliers = filled(strand([3.2, 3.3, 3.4], (False, False)), values)
    known = values[np.isfinite(multipliers)]
    assert known.min() == pytest.approx(3.2)
    assert known.max() == pytest.approx(3.4)


def test_the_root_is_foretold_in_the_root():
    """The parabola through three places in sqrt(r - 3) beats that in r near the birth."""
    r = 3.001
    errors = [
        np.abs(strand([3.0, 3.05, 3.2], (root, False)).foretell(r, []) - two_cycle(r)).max()
        for root in (True, False)
    ]
    assert errors[0] < 1e-3 < 5e-3 < errors[1]


def test_a_known_place_is_foretold_exactly():
    known = strand([3.0, 3.2, 3.4])
    np.testing.assert_array_equal(known.foretell(3.2, []), known.points[1])


def test_periods_are_solved_for_together():
    values = np.linspace(3.1, 3.4, 13)
    fixed = SampledOrbit(values[[0, -1]], 1 - 1 / values[[0, -1], None], 2 - values[[0, -1]])
    maps = [logistic(float(r)) for r in values]
    (one, slope), (two, _) = fill(maps, values, [fixed, strand([3.1, 3.25, 3.4], (False, False))])
    np.testing.assert_allclose(one[:, 0], 1 - 1 / values, rtol=0, atol=1e-12)
    np.testing.assert_allclose(slope, 2 - values, rtol=0, atol=1e-7)
    np.testing.assert_allclose(two, two_cycle(values), rtol=0, atol=1e-9)


def test_the_other_orbit_of_a_fold_is_not_taken():
    """A wrong guess leads to the partner, whose multiplier is on the other side of 1."""
    r = np.array([3.85, 3.86])  # the 3-cycles of the logistic map: one stable, one not
    stable = np.array([[0.15, 0.49, 0.96]] * 2)
    wrong = SampledOrbit(r, stable, np.array([2.0, 2.0]))
    _, multipliers = filled(wrong, r)
    assert np.isnan(multipliers).all()


def test_an_orbit_far_from_its_guess_is_not_entered():
    r = np.linspace(3.2, 3.3, 5)
    shifted = two_cycle(r[[0, -1]]) + np.array([0.02, -0.02])
    _, multipliers = filled(SampledOrbit(r[[0, -1]], shifted, np.array([0.1, 0.1])), r)
    assert np.isnan(multipliers).all()


class Rough:
    """Logistic map whose values are off by 1e-14, as those of a map that is integrated."""

    domain = (0.0, 1.0)

    def __init__(self, r):
        self.f = logistic(r)

    def evaluate(self, x):
        got = self.f.evaluate(x)
        off = 1e-14 * np.sin(1e12 * np.asarray(x))
        return PointValues(got.value + off, got.derivative, got.label, got.status, got.margin)


def test_orbits_are_found_where_rounding_hides_small_steps():
    """At multipliers of 1 - 1e-6 Newton's steps end at 1e-8, not at rounding."""
    values = 3.0 + np.linspace(4e-7, 2e-6, 15)
    known = strand([3.0, 3.0000004, 3.0000011, 3.0000021])
    ((points, multipliers),) = fill([Rough(float(r)) for r in values], values, [known])
    assert np.isfinite(multipliers).all()
    np.testing.assert_allclose(points, two_cycle(values), rtol=0, atol=1e-7)
