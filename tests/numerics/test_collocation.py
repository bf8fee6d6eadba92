"""Matrices of collocation, on polynomials, which they treat exactly."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial, chebyshev

from stickslip.numerics.collocation import (
    integration,
    nodes,
    shifted_chebyshev,
    to_coefficients,
)

DEGREES = (1, 2, 5, 12, 16)
ROUNDING = 1e-14


@pytest.mark.parametrize("degree", DEGREES)
def test_nodes_ascend_and_hold_both_ends(degree):
    t = nodes(degree)
    assert t.shape == (degree + 1,)
    assert (t[0], t[-1]) == (0.0, 1.0)
    assert np.all(np.diff(t) > 0.0)
    np.testing.assert_allclose(t + t[::-1], 1.0, rtol=0, atol=1e-15)


@pytest.mark.parametrize("degree", DEGREES)
def test_integrals_of_polynomials_are_exact(degree):
    p = Polynomial(np.random.default_rng(degree).uniform(-1, 1, degree + 1))
    t = nodes(degree)
    np.testing.assert_allclose(integration(degree) @ p(t), p.integ()(t), rtol=0, atol=ROUNDING)
    assert not integration(degree)[0].any()  # up to the start: nothing, without rounding


@pytest.mark.parametrize("degree", DEGREES)
def test_coefficients_interpolate(degree):
    t = nodes(degree)
    values = np.random.default_rng(degree).uniform(-1, 1, degree + 1)
    coefficients = to_coefficients(degree) @ values
    np.testing.assert_allclose(
        chebyshev.chebval(2 * t - 1, coefficients), values, rtol=0, atol=10 * ROUNDING
    )


@pytest.mark.parametrize("degree", DEGREES)
def test_powers_of_time_are_exact_integers(degree):
    matrix = shifted_chebyshev(degree)
    assert np.array_equal(matrix, np.round(matrix))
    for k in range(degree + 1):
        expected = chebyshev.Chebyshev.basis(k, domain=[0, 1]).convert(kind=Polynomial).coef
        np.testing.assert_allclose(matrix[: k + 1, k], expected, rtol=1e-9, atol=1e-6)
        assert not matrix[k + 1 :, k].any()
    # T_k is 1 at the right end and +-1 at the left: exact sums of integers
    assert np.array_equal(matrix.sum(axis=0), np.ones(degree + 1))
    assert np.array_equal(matrix[0], (-1.0) ** np.arange(degree + 1))
