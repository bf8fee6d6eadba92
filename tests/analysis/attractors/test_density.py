"""Invariant densities against closed forms, normalisation and time averages."""

import numpy as np
import pytest
from tests.analysis.known_maps import border_collision, logistic, tent

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.density import invariant_density


def density_of(f, **options):
    (found,) = attractors(f)
    return found, invariant_density(f, found, **options)


def test_full_tent_map_is_uniform():
    _, density = density_of(tent(2.0))
    assert density.density == pytest.approx(1, abs=1e-5)
    assert density.error < 1e-10
    assert float(density.lyapunov) == pytest.approx(np.log(2), abs=1e-10)


def test_full_logistic_map():
    _, density = density_of(logistic(4.0))
    exact = 2 / np.pi * np.diff(np.arcsin(np.sqrt([density.left, density.right])), axis=0)[0]
    distance = np.abs(density.mass - exact).sum()
    assert distance < 0.01
    assert distance < 3 * density.error
    x = np.array([0.1, 0.3, 0.5, 0.8])
    assert density(x) == pytest.approx(1 / (np.pi * np.sqrt(x * (1 - x))), rel=0.02)
    assert density.cumulative([0, 0.5, 1]) == pytest.approx([0, 0.5, 1], abs=1e-3)
    assert density.mean(lambda x: x) == pytest.approx(0.5, abs=1e-3)


def test_error_falls_with_the_number_of_cells():
    found, coarse = density_of(logistic(3.8), cells=500)
    fine = invariant_density(logistic(3.8), found, cells=8000)
    assert fine.error < 0.5 * coarse.error


@pytest.mark.parametrize(
    "f", [tent(1.3), tent(1.1), logistic(3.6), logistic(3.8), border_collision(1.3, -1.6, 0.2)]
)
def test_normalised_and_in_accord_with_time_averages(f):
    found, density = density_of(f)
    assert density.mass.sum() == pytest.approx(1)
    assert np.all(density.density >= 0)
    assert np.all(found.contains(0.5 * (density.left + density.right)))
    value, error = found.lyapunov
    doubt = np.hypot(error, density.lyapunov.error)
    assert abs(float(density.lyapunov) - value) < 5 * doubt + 1e-10


def test_outside_the_bands_it_is_zero():
    found, density = density_of(logistic(3.6))
    hole = 0.5 * (found.bands[0, 1] + found.bands[1, 0])
    assert density([0.0, hole, 1.0]) == pytest.approx(0)
    assert density.cumulative([hole]) == pytest.approx(0.5, abs=1e-6)  # two bands, equal time


def test_jump_of_the_density_at_a_band_merging_tent_map():
    # At slope sqrt(2) the density is a step: equal mass left and right of the fixed point.
    _, density = density_of(tent(np.sqrt(2)))
    s = np.sqrt(2)
    low, fixed, high = s * (1 - s / 2), s / (1 + s), s / 2
    left, right = (low + fixed) / 2, (fixed + high) / 2
    assert density([left, right]) == pytest.approx(
        [0.5 / (fixed - low), 0.5 / (high - fixed)], rel=1e-6
    )


def test_cycles_have_no_density():
    f = logistic(3.2)
    with pytest.raises(ValueError, match="only a chaotic one"):
        invariant_density(f, attractors(f)[0])


def test_too_few_cells():
    f = logistic(4.0)
    with pytest.raises(ValueError, match="cells = 3"):
        invariant_density(f, attractors(f)[0], cells=3)


def test_repr_and_plot():
    _, density = density_of(logistic(3.6))
    assert "cells" in repr(density)
    ax = density.plot()
    assert len(ax.patches) == 2  # one outline per band
