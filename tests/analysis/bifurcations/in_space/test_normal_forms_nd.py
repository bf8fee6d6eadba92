"""Cubic coefficients of flips and Neimark-Sacker bifurcations in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.known_maps_nd import delayed_logistic, henon, kinked, plain

from stickslip.analysis.bifurcations.normal_forms import CubicCoefficient, coefficient


def rotating(theta, d):
    """z' = exp(i theta) z (1 + d |z|^2), in the plane: a = 2 d for |q| = 1."""

    def turn(z):
        return np.exp(1j * theta) * z

    def func(x):
        z = x[..., 0] + 1j * x[..., 1]
        z = turn(z) * (1 + d * np.abs(z) ** 2)
        return np.stack([z.real, z.imag], axis=-1)

    def jacobian(x):
        z = x[..., 0] + 1j * x[..., 1]
        size = np.abs(z) ** 2
        by_x, by_y = (turn(w * (1 + d * size) + z * 2 * d * (z * np.conj(w)).real) for w in (1, 1j))
        rows = [np.stack([w.real, w.imag], axis=-1) for w in (by_x, by_y)]
        return np.stack(rows, axis=-1)

    return plain(func, jacobian)


@settings(max_examples=10)
@given(b=st.floats(-0.6, 0.8))
def test_the_flip_of_the_henon_map(b):
    """c = a^2 / (1 - b^4), from q = (1, -b), p = (1, -1) and (I - A)^-1 of (1, 0)."""
    a = 3 * (1 - b) ** 2 / 4
    x = (1 - b) / (2 * a)
    got = coefficient(henon(a, b), np.array([[x, b * x]]), "flip")
    assert got.value == pytest.approx(a**2 / (1 - b**4), rel=1e-9)
    assert got.error < 1e-6
    assert got.criticality == "super"


@settings(max_examples=15)
@given(theta=st.floats(0.2, 1.4), d=st.floats(-3, 3).filter(lambda d: abs(d) > 0.01))
def test_a_turning_map_is_its_own_normal_form(theta, d):
    f = rotating(theta, d)
    f = type(f)(f.func, f.jacobian, {}, ((-1.0, 1.0), (-1.0, 1.0)), ())
    got = coefficient(f, np.zeros((1, 2)), "neimark_sacker")
    assert abs(got.value - 2 * d) <= got.error + 1e-9
    assert got.criticality == ("super" if d < 0 else "sub")


def test_the_delayed_logistic_map_is_supercritical():
    """Kuznetsov, Elements of Applied Bifurcation Theory, example 4.1: a(0) < 0."""
    got = coefficient(delayed_logistic(2.0), np.array([[0.5, 0.5]]), "neimark_sacker")
    assert got.value == pytest.approx(-1.0, abs=1e-9)
    assert got.criticality == "super"


def test_a_strong_resonance_is_left_open():
    got = coefficient(rotating(2 * np.pi / 3, -1.0), np.zeros((1, 2)), "neimark_sacker")
    assert got.criticality is None


def test_no_neighbours_on_the_piece_no_coefficient():
    """The fixed point lies on the border: differences would mix two pieces."""
    got = coefficient(kinked(0.0), np.zeros((1, 2)), "flip")
    assert got.criticality is None


def test_signs_within_the_error_decide_nothing():
    assert CubicCoefficient(1.0, 2.0).criticality is None
    assert CubicCoefficient(-1.0, 0.5).criticality == "sub"
    assert CubicCoefficient(-1.0, 0.5, "neimark_sacker").criticality == "super"
