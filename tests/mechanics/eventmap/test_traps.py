"""Regions that no motion leaves: on maps of the plane that are known, and of two blocks."""

import math

import numpy as np
import pytest

import stickslip as ss
from stickslip.mechanics.eventmap.backend import NO_TRAPS, ScalarBackend
from stickslip.mechanics.eventmap.event_map import Controls
from stickslip.mechanics.eventmap.traps import Turned, trap, traps_of, turned
from stickslip.mechanics.flow.engine import engine_for
from stickslip.status import NEVER_CYCLE, OK

CENTRE = np.array([-0.4, 0.7])


def spiral(*, growth, damping, angle=1.9, fold=0.0, wall=math.inf):
    """Rotation and growth about a centre, cubic damping; beyond a wall another way is taken."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])

    def turned(places):
        x = places - CENTRE
        size = np.sum(x**2, axis=1, keepdims=True)
        image = x @ turn.T * (growth - damping * size) + fold * x[:, :1] ** 2
        beyond = x[:, 0] > wall
        margin = np.minimum(np.abs(wall - x[:, 0]), 9.0)
        return Turned(CENTRE + image, margin, beyond.astype(np.uint64))

    return turned


def way(turn, n=96, start=(0.2, 0.1)):
    points = [CENTRE + start]
    for _ in range(n):
        points.append(turn(points[-1][None]).place[0])
    return np.array(points)


def inside(corners, n, rng):
    """Points of a star-shaped polygon, most of them near its border."""
    k, share = rng.integers(0, len(corners), n), rng.uniform(0, 1, (n, 1))
    border = corners[k] + share * (np.roll(corners, -1, axis=0)[k] - corners[k])
    middle = corners.mean(axis=0)
    return middle + (border - middle) * np.sqrt(rng.uniform(0, 1, (n, 1)))


@pytest.mark.parametrize(
    "system",
    [
        {"growth": 0.997, "damping": 0.4},  # a focus, hardly attracting
        {"growth": -0.98, "damping": -0.4, "angle": 0.0},  # about to double its period
        {"growth": 1.05, "damping": 2.0},  # round which motions go for ever
        {"growth": 1.05, "damping": 2.0, "fold": 0.2},
        {"growth": 1.05, "damping": 2.0, "wall": 0.2},
    ],
)
def test_what_begins_in_a_trap_stays_in_it(system):
    turn = spiral(**system)
    start = (0.15, 0.05)
    corners = trap(way(turn, start=start), turn)
    assert corners is not None
    points = inside(corners, 400, np.random.default_rng(0))
    size = np.abs(corners - CENTRE).max()
    for _ in range(300):
        found = turn(points)
        assert (found.label == 0).all()
        points = found.place
        assert np.abs(points - CENTRE).max() < 1.01 * size


@pytest.mark.parametrize(
    "system",
    [
        {"growth": 1.0, "damping": 0.0},  # nothing attracts
        {"growth": 1.02, "damping": 0.0},
        {"growth": 1.05, "damping": 2.0, "wall": 0.15},  # which the motion crosses
    ],
)
def test_what_is_left_again_is_no_trap(system):
    turn = spiral(**system)
    assert trap(way(turn, start=(0.03, 0.05)), turn) is None


def test_where_a_clearance_vanishes_at_the_centre_there_is_none():
    turn = spiral(growth=0.9, damping=0.0, wall=1e-9)
    assert trap(way(turn, start=(0.0, 0.1)), turn) is None
    still = CENTRE + np.zeros((97, 2))  # exactly at its end
    assert trap(still, spiral(growth=0.9, damping=0.0)) is None


def test_a_map_that_folds_over_itself_is_no_trap():
    # (x, y) -> (|x|-like, y): the border goes inside, orientation changes within.
    def turned(places):
        x = places - CENTRE
        image = np.stack([0.5 * x[:, 0] ** 2, 0.5 * x[:, 1]], axis=1)
        return Turned(CENTRE + image, np.ones(len(x)), np.zeros(len(x), np.uint64))

    assert trap(way(turned), turned) is None


SLOW = {"gamma": 2.2158642752162994, "delta": 0.17564415049338622, "eta": 0.02457726209836969}
ROUND = {"gamma": 2.835328723456887, "delta": 0.25161607283808274, "eta": 0.0752902633761185}
WEAK = {"gamma": 0.9060499171456196, "delta": 0.30400570012805345}
SYSTEMS = {
    # a torus that attracts by 0.2 % a turn, from twice as far as it reaches
    "weak": ((0.5320929869425925, 0.9973872222289848, 0.02939523433932023), WEAK),
    # a cycle that attracts by 0.4 % a turn
    "slow": ((0.6929587208761537, 0.9321713231345198, 0.15194836754011987), SLOW),
    # a torus
    "torus": ((1.1825305326986943, 0.5819364712525074, 0.13490497481701186), ROUND),
}


@pytest.mark.parametrize("which", SYSTEMS)
def test_motions_in_a_trap_do_not_return(which):
    (alpha, beta, V), law = SYSTEMS[which]
    model = ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=ss.PoppStelter(**law))
    f = ss.event_map(model)
    d = np.linspace(*f.domain, 301)
    told = f.evaluate(d)
    assert set(told.status) == {OK, NEVER_CYCLE}
    late = d[told.status == NEVER_CYCLE]
    # Asked without the traps, many go on for hundreds of events, those on tori without a word.
    plain = ScalarBackend(model, engine_for(model), Controls(1e-15, 3000, math.inf), 1)
    outputs = plain.room(len(late))
    plain.task(late[:, None], outputs, 3000)(0, len(late))
    assert (outputs.status != OK).all()
    alone = f._backend.scalar.carry(late, slope=True, watch=True)
    assert outputs.n_events.max() > 5 * alone.n_events.max()
    assert outputs.n_events.mean() > 5 * alone.n_events.mean()
    for block, *corners in traps_of(model, "taylor", 1e-15):
        points = inside(np.reshape(corners, (-1, 2)), 60, np.random.default_rng(1))
        last = turned(plain, int(block), points, 50)
        assert np.isfinite(last.place).all()


def test_without_long_motions_nothing_is_asked():
    model = ss.examples.coulomb()
    traps_of.cache_clear()
    ss.event_map(model).evaluate(np.linspace(-0.5, 0.5, 100))
    assert traps_of.cache_info().misses == 0
    assert traps_of(model, "exact", 1e-15) is NO_TRAPS
