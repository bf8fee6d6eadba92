"""The 0-1 test on what is known to be regular or chaotic.

The logistic and the standard map as in ``test/chaosdetection/01test.jl`` of ChaosTools.jl.
"""

import numpy as np
import pytest
from tests.analysis.known_maps import logistic

from stickslip.analysis.exponents.zero_one import zero_one_test
from stickslip.analysis.maps.protocol import iterate


def momenta(start, n, k=0.9):
    """Of the standard map."""
    t, p = start
    series = np.empty(n)
    for i in range(n):
        p = (p + k * np.sin(t)) % (2 * np.pi)
        t = (t + p) % (2 * np.pi)
        series[i] = t
    return series


def test_the_logistic_map_as_chaostools_has_it():
    chaotic = iterate(logistic(3.97), 0.4, 6000)[1000:]
    regular = iterate(logistic(3.5), 0.4, 6000)[1000:]
    assert zero_one_test(chaotic).value == pytest.approx(1.0, abs=0.01)
    assert zero_one_test(chaotic).chaotic
    assert not zero_one_test(regular).chaotic
    assert zero_one_test(regular).value == pytest.approx(0.0, abs=0.02)


def test_the_standard_map_as_chaostools_has_it():
    assert zero_one_test(momenta((0.01, 0.02), 8000), rng=1).chaotic
    assert not zero_one_test(momenta((np.pi, 0.1), 8000), rng=1).chaotic


def test_noise_and_two_frequencies():
    assert zero_one_test(np.random.default_rng(0).normal(size=3000)).value > 0.9
    t = np.arange(3000.0)
    assert abs(zero_one_test(np.cos(t * np.sqrt(2)) + np.cos(t)).value) < 0.1


def test_displacements_are_those_of_the_definition():
    values = np.random.default_rng(1).normal(size=200) + 0.3
    got = zero_one_test(values, n_frequencies=1, rng=3)
    (c,) = got.frequencies
    j = np.arange(1, 201)
    about = values - values.mean()  # whose mean square displacement has no part that oscillates
    p, q = np.cumsum(about * np.cos(j * c)), np.cumsum(about * np.sin(j * c))
    lag = np.arange(1, 21)
    moved = [
        np.mean((p[n : n + 180] - p[:180]) ** 2 + (q[n : n + 180] - q[:180]) ** 2) for n in lag
    ]
    assert got.growth[0] == pytest.approx(np.corrcoef(lag, moved)[0, 1], abs=1e-10)


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e160, 1e300])
@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_neither_the_unit_nor_the_zero_of_a_series_matters(scale, offset):
    t = np.arange(1000.0)
    for series in (np.random.default_rng(0).uniform(size=1000), np.cos(0.7 * t)):
        moved = zero_one_test(scale * (series + offset))
        assert moved.value == pytest.approx(zero_one_test(series).value, rel=0, abs=1e-6)


def test_a_series_that_never_changes_is_regular():
    assert not zero_one_test(np.full(1000, 0.1)).chaotic
    assert zero_one_test(np.zeros(1000)).value == 0.0


@pytest.mark.parametrize("bad", [[1.0] * 99, [[1.0] * 200], [np.nan] * 200, "chaos"])
def test_bad_series_are_refused(bad):
    with pytest.raises(ValueError, match="series"):
        zero_one_test(bad)
