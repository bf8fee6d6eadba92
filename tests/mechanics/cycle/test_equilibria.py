"""Steady sliding: where it is, its eigenvalues, the speed at which brakes begin to squeal."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss


def test_one_block_in_closed_form() -> None:
    """y'' + (c + F'(V)) y' + y = 0."""
    law = ss.PoppStelter(gamma=3, delta=0.2, eta=0.1)
    model = ss.Oscillator(V=0.4, friction=law, damping=0.05)
    (found,) = ss.equilibria(model)
    assert found.x[0] == pytest.approx(law.force(0.4), abs=1e-15)
    slope = 0.05 + law.slope(0.4)
    root = np.sqrt(complex(slope**2 / 4 - 1))
    np.testing.assert_allclose(found.eigenvalues, [-slope / 2 + root, -slope / 2 - root])
    assert not found.stable
    (critical,) = found.critical_speeds
    assert law.slope(critical) == pytest.approx(-0.05, abs=1e-11)
    (beyond,) = ss.equilibria(model.replace(V=1.01 * critical))
    assert beyond.stable


def test_constant_friction_without_damping_is_neutral() -> None:
    (found,) = ss.equilibria(ss.examples.coulomb())
    assert found.neutral
    assert not found.stable
    np.testing.assert_allclose(np.sort(found.eigenvalues.imag)[2:], [1.0, np.sqrt(3.4)])
    assert found.critical_speeds.size == 0
    assert "neutral" in repr(found)


def test_small_motions_grow_as_the_eigenvalues_say() -> None:
    model = ss.Chain(
        static=[1, 1.3], alpha=1.2, V=1.5, friction=ss.PoppStelter(gamma=1), damping=0.02
    )
    (found,) = ss.equilibria(model)
    x = found.x + 1e-7 * np.array([1.0, -0.5])
    t = np.linspace(0, 30, 7)
    motion = ss.simulate(model, x, np.zeros(2), t_end=30)
    s = model.structure
    slopes = s.damping + np.diag(s.static * model.friction.slope(1.5))  # type: ignore[union-attr]
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-s.stiffness, -slopes]])
    values, vectors = np.linalg.eig(matrix)
    start = np.linalg.solve(vectors, np.concatenate([x - found.x, np.zeros(2)]))
    expected = ((vectors * start) @ np.exp(np.outer(values, t))).real[:2].T
    np.testing.assert_allclose(motion.x(t) - found.x, expected, atol=2e-12)
    np.testing.assert_allclose(np.sort(found.eigenvalues.imag), np.sort(values.imag), atol=1e-12)


def test_forced_models_have_none() -> None:
    model = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.4), forcing=ss.Harmonic(0.1, 1.0))
    with pytest.raises(ValueError, match="no equilibrium"):
        ss.equilibria(model)
