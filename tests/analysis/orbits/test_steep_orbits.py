"""Orbits close to where a map is as steep as a square root."""

import math

import numpy as np
import pytest

import stickslip as ss


def root_beside_a_jump(level):
    """Map with the fixed point -x = u^2, u + u^2 = level, beside the jump at 0 if level > 0."""
    return ss.PiecewiseMap(
        lambda x, level: np.where(x < 0, level - np.sqrt(np.maximum(-x, 0)), 0.1 * x - 0.5),
        (-0.7, 1),
        parameters={"level": level},
        derivative=lambda x, level: np.where(x < 0, 0.5 / np.sqrt(np.maximum(-x, 1e-300)), 0.1),
        breakpoints=[0.0],
    )


@pytest.mark.parametrize("level", [1e-3, 1e-6, 1e-7, 1e-8, 1e-10])
def test_an_orbit_closer_to_a_root_than_rounding_of_the_domain_is_found(level):
    found = ss.periodic_orbits(root_beside_a_jump(level))
    u = 2 * level / (1 + math.sqrt(1 - 4 * level))
    (orbit,) = found
    assert (orbit.quality, found.unresolved) == ("located", ())
    np.testing.assert_allclose(orbit.points, -(u**2), rtol=1e-4)


@pytest.mark.parametrize("level", [-1e-9, 0.0])
def test_an_orbit_that_is_on_the_root_or_beyond_is_not_listed(level):
    found = ss.periodic_orbits(root_beside_a_jump(level))
    assert len(found) == 0
    assert [item.reason for item in found.unresolved] == ["an orbit point is on the jump"] * (
        level == 0
    )


def test_an_orbit_is_born_on_a_root():
    found = ss.bifurcations(root_beside_a_jump(0.01), "level", (-0.05, 0.06), max_period=1)
    (born,) = found
    assert (born.kind, len(born.orbits_before), len(born.orbits_after)) == (
        "border_collision",
        0,
        1,
    )
    assert abs(born.value) < 1e-15
    assert found.unresolved == ()
