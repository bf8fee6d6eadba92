"""What the Coulomb system of section 4 settles on, and who is attracted where.

The paper calls the motion past the grazing of S4 non-periodic. It is periodic; the oracle's
arithmetic of 96 digits settles it.
"""

from itertools import pairwise

import numpy as np
import pytest
from flint import arb
from tests.reference.coulomb import Coulomb
from tests.reference.values import COULOMB_JUMPS, COULOMB_ORBITS

import stickslip as ss

pytestmark = pytest.mark.paper

ROUNDING = 1e-14


@pytest.fixture(scope="module")
def at_start():
    f = ss.event_map(ss.examples.coulomb(V=0.0366))
    return f, ss.attractors(f)


def test_two_attractors_coexist(at_start):
    _, found = at_start
    assert {(a.kind, a.period) for a in found} == {("periodic", 1), ("periodic", 4)}
    for attractor, name in zip(sorted(found, key=lambda a: a.period), ("S1", "S4"), strict=True):
        point, multiplier = map(float, COULOMB_ORBITS[name])
        assert np.min(np.abs(attractor.orbit.points - point)) < ROUNDING
        assert attractor.orbit.multiplier == pytest.approx(multiplier, rel=1e-11)


def test_every_basin_edge_is_explained(at_start):
    f, found = at_start
    result = ss.basins(f, found)
    assert result.undecided == result.left == result.thin == 0
    preimage, jump, orbit = result.causes[1:-1]
    assert (jump.kind, jump.order) == ("breakpoint", 0)
    assert result.edges[2] == pytest.approx(float(COULOMB_JUMPS[1][0]), abs=ROUNDING)
    assert (orbit.kind, orbit.order, orbit.period) == ("orbit", 0, 1)
    assert result.edges[3] == pytest.approx(float(COULOMB_ORBITS["U1"][0]), abs=ROUNDING)
    assert (preimage.kind, preimage.order, preimage.period) == ("orbit", 1, 1)
    assert f(result.edges[1]) == pytest.approx(result.edges[3], abs=ROUNDING)
    small = next(k for k, a in enumerate(found) if a.period == 1)
    assert list(result.index == small) == [True, False, True, False]


@pytest.mark.parametrize(("V", "period"), [(0.0370, 83), (0.0371, 63), (0.0372, 55)])
def test_the_motion_past_the_grazing_is_periodic(V, period):
    found = ss.attractors(ss.event_map(ss.examples.coulomb(V=V)))
    assert {(a.kind, a.period) for a in found} == {("periodic", 1), ("periodic", period)}
    orbit = next(a.orbit for a in found if a.period == period)
    assert orbit.stable

    system = Coulomb(alpha=1.2, beta=1.3, V=V, mu=0.22)
    x, words, rounds = arb(float(orbit.points[0])), [], []
    for _ in range(6):
        rounds.append(x)
        word = []
        for _ in range(period):
            motion = system.motion(x)
            x = arb(motion.value.mid())
            word.append(motion.itinerary)
        words.append(tuple(word))
    assert len(set(words)) == 1
    # Rounds approach each other by the multiplier, far below what doubles can tell.
    steps = [b - a for a, b in pairwise(rounds)]
    ratios = [float((b / a).mid()) for a, b in pairwise(steps)]
    assert ratios[1:] == pytest.approx([orbit.multiplier] * len(ratios[1:]), rel=1e-6)
    spacing = np.spacing(np.abs(orbit.points).min())
    assert abs(float(steps[-1].mid())) < 0.01 * spacing
    # The period is minimal: no shift of the word repeats it.
    assert all(words[0][k:] + words[0][:k] != words[0] for k in range(1, period))
