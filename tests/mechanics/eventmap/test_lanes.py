"""Many motions at once against one at a time.

A finite `max_time` has the exact engine carry every motion alone: the oracle here.
"""

import itertools
import platform
import re

import numpy as np
import pytest
from tests.mechanics.eventmap.unequal import pair

import stickslip as ss
from stickslip.mechanics.eventmap import _lane_trace_kernels
from stickslip.mechanics.eventmap._lane_kernels import Carried
from stickslip.mechanics.eventmap.lanes import new_lane_scratch
from stickslip.mechanics.flow._lane_kernels import constants_of_row
from stickslip.numerics.targets import config, kernel_uncached
from stickslip.status import OK

ALONE = {"max_time": 1e300}
# What the design allows of two engines, each within 1e-14, per unit of sensitivity.
TOLERANCE = 2e-14
# Two engines may see different itineraries only closer than this to another one.
CLEAR = 1e-12
NEVER_RETURNING = {"alpha": 1.885, "beta": 1.076, "mu": 0.898, "V": 0.294}
LONG = {"alpha": 1.0, "beta": 1.5, "mu": 0.05, "V": 0.2}
PAPER = {"alpha": 1.2, "beta": 1.3, "mu": 0.22, "V": 0.0366}


def model(alpha, beta, mu, V):
    return ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=ss.Coulomb(mu=mu))


def random_models(n, seed):
    """Systems from the ranges of the design, every fourth with two laws."""
    rng = np.random.default_rng(seed)
    ranges = ((0.1, 3), (0.5, 2), (0.05, 0.9), (0.05, 0.9), (0.005, 0.3))
    for i in range(n):
        alpha, beta, mu_1, mu_2, V = (float(rng.uniform(*ends)) for ends in ranges)
        laws = (ss.Coulomb(mu=mu_1), ss.Coulomb(mu=mu_2)) if i % 4 == 3 else ss.Coulomb(mu=mu_1)
        yield ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=laws)


def starts(system, n, seed=0):
    return np.random.default_rng(seed).uniform(*system.domain, n)


def assert_agree(system, d, max_events):
    """Values, slopes and endings of both engines where no other itinerary is near."""
    together = ss.event_map(system, max_events=max_events, threads=1)
    alone = ss.event_map(system, max_events=max_events, threads=1, **ALONE).evaluate(d)
    value, slope = together(d), together.derivative(d)
    clear = alone.margin > CLEAR
    assert np.array_equal(np.isnan(value[clear]), alone.status[clear] != OK)
    ok = clear & (alone.status == OK)
    kappa = np.maximum(1.0, np.abs(alone.derivative[ok])) * np.maximum(
        1.0, 0.1 * alone.n_events[ok]
    )
    assert (np.abs(value[ok] - alone.value[ok]) <= TOLERANCE * kappa).all(), system
    # Beside a graze the slope grows like the inverse of its own error.
    sharp = np.maximum(1.0, np.abs(alone.derivative[ok])) ** 2
    assert (np.abs(slope[ok] - alone.derivative[ok]) <= 1e-11 * sharp * kappa).all(), system


def test_lanes_agree_with_one_motion_at_a_time():
    for system in random_models(24, seed=1):
        assert_agree(system, starts(system, 400), max_events=60)


@pytest.mark.slow
def test_lanes_agree_on_many_systems():
    for system in random_models(400, seed=2):
        assert_agree(system, starts(system, 500), max_events=200)


def assert_told_alike(system, d, max_events=60):
    """What lanes tell besides values is what is told of one motion at a time."""
    f, g = (
        ss.event_map(system, max_events=max_events, threads=1, **alone) for alone in ({}, ALONE)
    )
    told, alone = f.evaluate(d), g.evaluate(d)
    clear = alone.margin > CLEAR
    for name in ("status", "label", "n_events"):
        assert np.array_equal(getattr(told, name)[clear], getattr(alone, name)[clear]), system
    ok = clear & (alone.status == OK)
    grown = np.maximum(1.0, np.abs(alone.derivative)) * np.maximum(1.0, 0.1 * alone.n_events)
    late = np.abs(told.duration - alone.duration)
    assert (late[ok] <= (1e-12 * grown * np.maximum(1.0, alone.duration))[ok]).all(), system
    # Newton's method ends at the bottom of a lobe a little above it.
    assert (np.abs(told.margin - alone.margin)[ok] <= 1e-10 * grown[ok]).all(), system
    sharp = grown * np.maximum(1.0, np.abs(alone.derivative)) ** 2
    for name in f.parameters:
        slope, other = f.parameter_derivative(d, name), g.parameter_derivative(d, name)
        assert np.array_equal(np.isnan(slope)[clear], np.isnan(other)[clear]), (system, name)
        allowed = 1e-11 * sharp * np.maximum(1.0, np.abs(other))
        assert (np.abs(slope - other)[ok] <= allowed[ok]).all(), (system, name)


def test_lanes_tell_what_is_told_of_one_motion_at_a_time():
    for system in random_models(12, seed=8):
        assert_told_alike(system, starts(system, 300))


def test_a_shallow_lobe_is_found_where_a_step_of_newton_would_leave_it():
    friction = ss.Coulomb(0.4197054193913707)
    system = ss.TwoBlock(1.9918704236051643, 0.8517653025047359, 0.2698148943920219, friction)
    assert_told_alike(system, np.array([0.0745855986774655]))


def test_a_rider_that_comes_to_its_limit_slowly_is_told():
    friction = ss.Coulomb(0.06440228370167352)
    system = ss.TwoBlock(1.2468787774716041, 0.9540217658329699, 0.1411448260667256, friction)
    assert_told_alike(system, np.array([-0.199253143084422]))


@pytest.mark.slow
def test_lanes_tell_it_of_many_systems():
    for system in random_models(400, seed=9):
        assert_told_alike(system, starts(system, 500), max_events=200)


@pytest.mark.parametrize("system", [model(**PAPER), *random_models(2, seed=5)])
def test_lanes_tell_it_beside_breakpoints(system):
    f = ss.event_map(system, max_events=100, threads=1)
    distance = 10.0 ** -np.arange(1.5, 10.01, 0.5)
    edges = list(itertools.islice(label_changes(f), 8))
    d = np.array([edge + side * h for edge in edges for side in (-1, 1) for h in distance])
    assert_told_alike(system, d[np.abs(d) < system.domain[1]], max_events=100)


def test_a_forward_slip_past_its_crest_frees_no_rider():
    """Its rider's force only grows; where the speed was greater before, lanes let it go."""
    system = model(3.5496057596530566, 1.528928043352203, 0.060795301940578486, 0.17362328135621927)
    assert_agree(system, np.linspace(-0.16206, -0.16204, 400), 100)


def test_times_and_margins_are_told_without_slopes_too():
    f = ss.event_map(model(**PAPER), threads=1)
    d = starts(model(**PAPER), 600)
    told, alone = (f._backend.carry(d, slope=slope, watch=True) for slope in (True, False))
    for field in ("value", "duration", "n_events", "label", "margin", "status"):
        assert np.array_equal(getattr(told, field), getattr(alone, field)), field


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads x86 assembly")
@pytest.mark.parametrize("name", ["return_margins", "release_margins", "landing_margins"])
def test_margins_are_vector_code(name):
    lanes = ss.event_map(model(**PAPER))._backend.lanes
    carried = Carried(constants_of_row(lanes.row), lanes.pair, lanes.row)
    told = kernel_uncached(getattr(_lane_trace_kernels, name).py_func)
    told(carried, new_lane_scratch().streams, np.uint64(0))
    (assembly,) = told.inspect_asm().values()
    packed, scalar = (
        len(re.findall(rf"\bv?(?:fn?m(?:add|sub)\w*|mul|add|sub){kind}\b", assembly))
        for kind in ("pd", "sd")
    )
    assert packed > scalar + 50
    assert "gather" not in assembly  # of numbers that lie side by side


def test_what_is_told_does_not_depend_on_what_else_is_asked():
    for system in (model(**LONG), model(**PAPER | {"mu": 0.0})):
        f = ss.event_map(system, max_events=300, threads=1)
        d = starts(system, 700, seed=3)
        whole = f.evaluate(d)
        parts = [f.evaluate(d[:3]), f.evaluate(d[3:])]
        for name in ("duration", "n_events", "label", "margin", "status"):
            joined = np.concatenate([getattr(part, name) for part in parts])
            assert np.array_equal(getattr(whole, name), joined), name
        slope = f.parameter_derivative(d, "V")
        joined = np.concatenate([f.parameter_derivative(part, "V") for part in (d[:3], d[3:])])
        assert np.array_equal(slope, joined, equal_nan=True)


def label_changes(f, n=400):
    """Last doubles of some branches."""
    d = np.linspace(*f.domain, n)[1:-1]
    label = f.evaluate(d).label
    for i in np.flatnonzero(label[1:] != label[:-1]):
        low, high = d[i], d[i + 1]
        while low < (middle := 0.5 * (low + high)) < high:
            same = f.evaluate(middle).label == label[i]
            low, high = (middle, high) if same else (low, middle)
        yield float(low)


@pytest.mark.parametrize("system", [model(**PAPER), *random_models(3, seed=5)])
def test_lanes_agree_beside_breakpoints(system):
    f = ss.event_map(system, max_events=100, **ALONE)
    distance = 10.0 ** -np.arange(1.5, 13.01, 0.5)
    edges = list(itertools.islice(label_changes(f), 12))
    d = np.array([edge + side * h for edge in edges for side in (-1, 1) for h in distance])
    assert edges
    assert_agree(system, d[np.abs(d) < system.domain[1]], max_events=100)


def test_a_force_that_rounding_puts_on_the_limit_is_no_tie():
    """Next to a breakpoint, where block 1 lands at its limit."""
    model = ss.TwoBlock(
        1.820831307771322, 0.8147891671178327, 0.2779713352211227, ss.Coulomb(0.05575049346768197)
    )
    f = ss.event_map(model, threads=1)
    d = -0.06408996985047997 + np.spacing(0.064) * np.arange(-8, 9)
    result = f.evaluate(d)
    np.testing.assert_array_equal(np.isfinite(result.value), result.status == OK)
    np.testing.assert_array_equal(f(d), result.value)
    # in 320 bits they return from the eleventh on; the tenth changes within rounding of its start
    assert list(np.flatnonzero(result.status == OK)[-6:]) == [11, 12, 13, 14, 15, 16]
    assert not np.any(result.status[:10] == OK)


EQUAL = [model(**parameters) for parameters in (PAPER, LONG, NEVER_RETURNING, PAPER | {"mu": 0.0})]


@pytest.mark.parametrize("system", [*EQUAL, pair(ss.Coulomb(0.05), 0.2)])
def test_a_value_is_the_same_bits_however_it_is_asked(system):
    f = ss.event_map(system, max_events=300, threads=1)
    d = starts(system, 1100, seed=3)
    value = f(d)
    assert np.array_equal(value, f.evaluate(d).value, equal_nan=True)
    assert np.array_equal(value, f(d[::-1])[::-1], equal_nan=True)
    assert np.array_equal(value[:40], [f(x) for x in d[:40].tolist()], equal_nan=True)
    assert np.array_equal(value, np.concatenate([f(d[:7]), f(d[7:])]), equal_nan=True)
    assert np.array_equal(value, f.iterate(d, 1)[:, 1], equal_nan=True)
    slope = f.derivative(d)
    assert np.array_equal(slope, f.evaluate(d).derivative, equal_nan=True)
    assert np.array_equal(slope[:40], [f.derivative(x) for x in d[:40]], equal_nan=True)


def test_threads_do_not_change_a_bit():
    system = model(**LONG)
    d = starts(system, 50_000, seed=4)
    one, two = (ss.event_map(system, threads=n, max_events=100) for n in (1, 2))
    assert np.array_equal(one(d), two(d), equal_nan=True)
    assert np.array_equal(one.derivative(d), two.derivative(d), equal_nan=True)


def test_an_orbit_is_the_map_again_and_again():
    f = ss.event_map(model(**LONG), max_events=300)
    orbits = f.iterate(starts(f, 600), 5)
    for k in range(5):
        alive = ~np.isnan(orbits[:, k])
        assert np.array_equal(orbits[alive, k + 1], f(orbits[alive, k]), equal_nan=True)


def test_an_orbit_that_ends_stays_ended_and_disturbs_no_other():
    f = ss.event_map(model(**NEVER_RETURNING), max_events=200)
    d = starts(f, 40)
    ends = np.isnan(f(d))
    assert ends.any()
    assert not ends.all()
    orbits = f.iterate(d, 3)
    assert np.isnan(orbits[ends, 1:]).all()
    for start, orbit in zip(d.tolist(), orbits, strict=True):
        assert np.array_equal(orbit, f.iterate(start, 3), equal_nan=True)


@pytest.mark.parametrize("max_events", [1, 2, 3, 5, 40])
def test_the_limit_of_events_is_that_of_one_motion(max_events):
    system = model(**LONG)
    d = starts(system, 300)
    value = ss.event_map(system, max_events=max_events)(d)
    status = ss.event_map(system, max_events=max_events, **ALONE).evaluate(d).status
    assert np.array_equal(np.isnan(value), status != OK)


@pytest.mark.parametrize("mu", [0.0, 0.999999, 1.0])
@pytest.mark.parametrize("alpha", [0.0, 0.4, 50.0])
@pytest.mark.parametrize("beta", [0.5, 1.0])
def test_degenerate_systems(mu, alpha, beta):
    system = model(alpha, beta, mu, 0.1)
    # With mu = 1 a slip touches w = 0 once a period, for ever: 20,000 steps a start.
    d = np.concatenate([starts(system, 60 if mu < 1.0 else 6), system.domain])
    assert_agree(system, d, max_events=30)


@pytest.mark.parametrize("make", [ss.examples.coulomb, ss.examples.law9])
def test_models_that_differ_in_parameters_take_turns_in_one_scratch(make):
    one = ss.event_map(make())
    other = one.replace(alpha=one.model.alpha + 0.01)
    d = np.linspace(-0.3, 0.3, 40)
    first = one(d)
    assert not np.array_equal(other(d), first, equal_nan=True)
    np.testing.assert_array_equal(one(d), first)
    if make is ss.examples.coulomb:
        assert one._backend.lanes.scratch() is other._backend.lanes.scratch()
    else:
        assert one._backend.pools(None) is other._backend.pools(None)


@pytest.mark.parametrize("ask", [None, {}, {"slope": True}, {"slope": True, "watch": True}])
def test_a_start_that_lanes_decline_goes_through_them_once(ask, monkeypatch):
    backend = ss.event_map(model(0.5, 1.5, 0.22, 0.1), threads=1)._backend
    d = 0.25  # (beta - 1) / (1 + 2 alpha): both blocks slip at once, too close a decision for lanes
    assert np.isnan(backend.lanes.value(d))
    asked = []
    lanes_carry = backend.lanes._carry
    monkeypatch.setattr(
        backend.lanes, "_carry", lambda *given: asked.append(given) or lanes_carry(*given)
    )
    found = backend.value(d) if ask is None else backend.carry(np.array([d]), **ask).value
    assert len(asked) == 1
    assert np.isfinite(found).all()
