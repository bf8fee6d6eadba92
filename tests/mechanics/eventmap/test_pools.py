"""Motions in pools of lanes: the answers of the scalar engine, whatever is asked together."""

import math
import platform
import re
import subprocess
import sys

import numpy as np
import pytest
from tests.mechanics.eventmap.unequal import LAWS, random_models
from tests.mechanics.flow.systems import random_model
from tests.reference import laws
from tests.reference.law9 import Smooth

import stickslip as ss
from stickslip.mechanics.eventmap.backend import ScalarBackend
from stickslip.mechanics.eventmap.lanes import (
    BatchBackend,
    EqualLaneBackend,
    LaneBackend,
    PoolBackend,
)
from stickslip.mechanics.flow.lanes import layout
from stickslip.mechanics.flow.lanes.layout import KEPT, MOTIONS, PLACES
from stickslip.mechanics.flow.lanes.pair import pair_numbers
from stickslip.mechanics.flow.lanes.steps import Steps, lane_kernels
from stickslip.mechanics.friction import friction_law
from stickslip.mechanics.friction.series import law_series
from stickslip.numerics.targets import kernel_uncached
from stickslip.numerics.vector import LANES
from stickslip.status import EVENT_LIMIT, NEVER_CYCLE, NEVER_SLIPPING, OK, TIME_LIMIT

FIELDS = ("value", "derivative", "duration", "n_events", "label", "margin", "status")
# Taylor steps of other lengths: what rounding and truncation leave, per unit of slope.
AGREEMENT = 1e-13
# A decision nearer than this to another one may be taken differently by rounding.
DECIDED = 1e-9


def weakening(s, a, b):
    """A law of a user: two ways of weakening, one of them exponential."""
    return (1 - a) / (1 + 2 * s) ** 2 + a * np.exp(-b * s)


def law_of(kind, rng):
    if kind == "stribeck":
        return ss.Stribeck(mu=rng.uniform(0.1, 0.9), speed=rng.uniform(0.2, 1), exponent=2)
    return ss.friction_law(
        weakening, parameters={"a": rng.uniform(0.1, 0.9), "b": rng.uniform(0.1, 2)}
    )


def one_at_a_time(f, d):
    """The same by the scalar engine."""
    backend = f._backend
    while isinstance(backend, BatchBackend):
        backend = backend.scalar
    return backend.carry(d, slope=True, watch=True)


def assert_agreement(f, d):
    together, single = f.evaluate(d), one_at_a_time(f, d)
    # Of a motion that goes on for so long the lanes may know that it does so for ever.
    decided = (single.margin > DECIDED) & (single.status != EVENT_LIMIT)
    np.testing.assert_array_equal(together.status[decided], single.status[decided])
    ok = decided & (single.status == OK)  # others end where it is known why
    for field in ("label", "n_events"):
        np.testing.assert_array_equal(getattr(together, field)[ok], getattr(single, field)[ok])
    slope = np.abs(single.derivative[ok, 0])
    scale = np.maximum(1.0, slope)
    assert np.all(np.abs(together.value - single.value)[ok] <= AGREEMENT * scale)
    # what a slope makes of rounding: along the motion, and dividing by a small rate at a graze
    growth = 1e-10 * scale**2 + 1e-14 * scale / np.minimum(1.0, single.margin[ok]) ** 2
    assert np.all(np.abs(together.derivative - single.derivative[:, 0])[ok] <= growth)
    return ok


@pytest.mark.parametrize("seed", range(4))
def test_random_systems_with_law_9(seed):
    rng = np.random.default_rng(seed)
    returned = 0
    for _ in range(5):
        f = ss.event_map(random_model(rng, "law9"), threads=1, max_events=300)
        assert isinstance(f._backend, PoolBackend)
        returned += assert_agreement(f, rng.uniform(-1, 1, 70) * f.domain[1]).sum()
    assert returned > 200


@pytest.mark.slow  # a compilation for each law
@pytest.mark.parametrize("kind", ["stribeck", "user"])
def test_random_systems_with_other_formulas(kind):
    rng = np.random.default_rng(5)
    for _ in range(6):
        model = random_model(rng, "law9").replace(friction=law_of(kind, rng))
        f = ss.event_map(model, threads=1, max_events=300)
        assert isinstance(f._backend, PoolBackend)
        assert_agreement(f, rng.uniform(-1, 1, 50) * f.domain[1])


@pytest.mark.parametrize(
    ("kind", "n"),
    [("coulomb", 20), ("law9", 10), *(pytest.param(k, 250, marks=pytest.mark.slow) for k in LAWS)],
)
def test_random_unequal_blocks(kind, n):
    """Masses, springs and dampers that nobody tuned: the answers of the engine of N blocks."""
    rng = np.random.default_rng(n)
    returned = 0
    for model in random_models(kind, n, rng):
        f = ss.event_map(model, threads=1, max_events=300, engine="adaptive")
        assert isinstance(f._backend, PoolBackend)
        d = model.sample_domain(40, rng)
        returned += assert_agreement(f, d).sum()
        f = ss.event_map(model, threads=1, max_events=300)
        pulls = model.plant.stiffness[0, 1] <= 0.0
        if kind == "coulomb" and pulls and not model.plant.damping.any():
            assert isinstance(f._backend, LaneBackend)
            assert_agreement(f, d)
    assert returned > 20 * n


@pytest.mark.parametrize(
    ("kind", "n"),
    [("coulomb", 2), ("law9", 3), *(pytest.param(k, 60, marks=pytest.mark.slow) for k in LAWS)],
)
def test_derivatives_in_every_parameter(kind, n):
    """Of equal and of unequal blocks, damped or not: those of the scalar engine."""
    rng = np.random.default_rng(40 + n)
    equal = [random_model(rng, "law9") for _ in range(n if kind == "law9" else 0)]
    compared = 0
    for model in [*equal, *random_models(kind, n, rng)]:
        f = ss.event_map(model, threads=1, max_events=300, engine="adaptive")
        assert isinstance(f._backend, PoolBackend)
        d = model.sample_domain(40, rng)
        single = one_at_a_time(f, d)
        near = np.minimum(1.0, single.margin)
        ok = (single.margin > DECIDED) & (single.status == OK)
        steep = np.maximum(1.0, np.abs(single.derivative[:, 0]))
        for name in f.parameters:
            one, other = f.parameter_derivative(d, name), f._backend.scalar.parameter_slope(d, name)
            scale = steep * np.maximum(1.0, np.abs(other))
            growth = 1e-10 * scale + 1e-14 * scale / near**2
            assert np.all(np.abs(one - other)[ok] <= growth[ok]), name
            assert np.array_equal(np.isnan(one)[ok], np.isnan(other)[ok])
            compared += ok.sum()
    assert compared > 100 * n


def test_a_parameter_named_as_the_start_is_a_parameter():
    law, same = (
        ss.friction_law(f"1 / (1 + {name} * s)", parameters={name: 3.0}) for name in ("d", "g")
    )
    one, other = (ss.event_map(ss.examples.law9(alpha=1.2099, friction=of)) for of in (law, same))
    x = np.array([0.38, 0.385])
    np.testing.assert_array_equal(
        one.parameter_derivative(x, "d"), other.parameter_derivative(x, "g")
    )


def test_matrices_of_any_symmetry():
    """Follower forces, dampers that feed, masses as a matrix: Structures whose inertias all rub."""
    rng = np.random.default_rng(8)
    for _ in range(4):
        stiffness = np.diag(rng.uniform(1.0, 4.0, 2)) + rng.uniform(-0.9, 0.4, (2, 2))
        model = ss.Structure(
            mass=np.diag(rng.uniform(0.5, 2.0, 2)),
            stiffness=stiffness,
            damping=rng.uniform(-0.05, 0.2, (2, 2)),
            contacts=[ss.Contact(at=i, static=1.0 + i / 3, friction=LAW_9, V=0.1) for i in (0, 1)],
        )
        f = ss.event_map(model, threads=1, max_events=300)
        assert isinstance(f._backend, PoolBackend)
        assert assert_agreement(f, model.sample_domain(40, rng)).sum() > 20


LAW_9 = ss.PoppStelter(3.0, 0.1, 0.05)
TABLE = ss.TabulatedFriction([0.0, 0.5, 1.0], [1.0, 0.6, 0.5])
PLAIN = ss.TwoBlock(1.0, 1.4, 0.1, LAW_9)


@pytest.mark.parametrize(
    ("model", "backend"),
    [
        (PLAIN.replace(friction=ss.Coulomb(0.2)), EqualLaneBackend),
        (PLAIN, PoolBackend),
        (PLAIN.replace(friction=TABLE), ScalarBackend),
        (PLAIN.replace(damping=0.1), PoolBackend),
        (PLAIN.chain, PoolBackend),
        (PLAIN.chain.replace(friction=ss.Coulomb(0.2)), LaneBackend),
        (PLAIN.chain.replace(friction=ss.Coulomb(0.2, viscous=0.1)), PoolBackend),
        (PLAIN.chain.replace(friction=TABLE), ScalarBackend),
        (ss.Chain([1.0, 1.1, 1.2], 1.0, 0.1, LAW_9), ScalarBackend),
    ],
)
def test_what_a_structure_allows(model, backend):
    assert type(ss.event_map(model)._backend) is backend


def test_two_laws_of_one_formula():
    laws = (ss.PoppStelter(3.0, 0.1, 0.05), ss.PoppStelter(1.0, 0.3, 0.02))
    f = ss.event_map(ss.TwoBlock(alpha=1.0, beta=1.4, V=0.1, friction=laws), threads=1)
    assert isinstance(f._backend, PoolBackend)
    assert assert_agreement(f, np.linspace(*f.domain, 80)).any()


@pytest.mark.parametrize(
    "friction",
    [
        (ss.PoppStelter(3.0, 0.1, 0.05), ss.Stribeck(mu=0.4, speed=0.5)),
        ss.friction_law(lambda s: 1 / (1 + s), forward=lambda s: 1 / (1 + 2 * s)),
    ],
)
def test_laws_that_are_no_single_formula_are_carried_one_at_a_time(friction):
    model = ss.TwoBlock(alpha=1.0, beta=1.4, V=0.1, friction=friction)
    assert not isinstance(ss.event_map(model)._backend, PoolBackend)


def test_margins_see_a_turn_of_which_both_ends_lie_in_one_step():
    """A slip that almost ended, 0.015 short of it, and had turned again within the same step."""
    law = ss.PoppStelter(0.6569336149164658, 0.22863890281349242)
    model = ss.TwoBlock(2.8631504614710637, 1.7237256670040861, 0.024293578284881243, law)
    f = ss.event_map(model, threads=1)
    d = 0.1 + np.linspace(-0.02, 0.02, 401)
    np.testing.assert_allclose(f.evaluate(d).margin, one_at_a_time(f, d).margin, rtol=1e-6)
    at = 0.10001105232218105
    motion = ss.simulate(model, d=at, t_end=float(f.evaluate(at).duration))
    t = np.linspace(1.5, 2.5, 20_001)  # while both blocks slip
    assert f.evaluate(at).margin == pytest.approx(np.abs(motion.v(t)[..., 0] - model.V).min())


def test_both_sides_of_breakpoints():
    f = ss.event_map(ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05)), threads=1)
    d = np.linspace(*f.domain, 400)
    label = f.evaluate(d).label
    cells = np.flatnonzero(label[1:] != label[:-1])
    low, high = d[cells], d[cells + 1]
    for _ in range(60):
        middle = 0.5 * (low + high)
        same = f.evaluate(middle).label == label[cells]
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    assert cells.size > 3
    reach = 10.0 ** -np.arange(2, 12)
    near = np.concatenate([low - reach[:, None], low + reach[:, None]]).ravel()
    assert assert_agreement(f, near[np.abs(near) < f.domain[1]]).sum() > 20


def test_motions_of_many_events_are_not_handed_over(monkeypatch):
    # Breaks accumulate at d: nearer to it motions go around an unstable cycle more often.
    numbers, law = (1.0959, 1.1923402178674560, 0.1775192043541176), (1.9783069511411593, 0.0126)
    f = ss.event_map(ss.TwoBlock(*numbers, ss.PoppStelter(*law)), threads=1)
    low, high = 0.412, 0.4135
    for _ in range(40):
        middle = np.linspace(low, high, 9)
        k = int(np.argmax(f.evaluate(middle).n_events))
        low, high = middle[max(k - 1, 0)], middle[min(k + 1, 8)]
    reach = 10.0 ** -np.linspace(1, 11, 60)
    d = np.concatenate([low - reach, low + reach])
    ok = assert_agreement(f, d)
    told = f.evaluate(d[ok])
    long = np.flatnonzero((told.n_events > 40) & (told.status == OK))
    assert long.size > 30
    oracle = Smooth(*numbers, laws.PoppStelter(*law))
    for k in long[:: long.size // 4]:
        error = float(abs(oracle.motion(float(d[ok][k])).value - float(told.value[k])))
        assert error <= 2e-15 * max(1.0, abs(told.derivative[k]))

    monkeypatch.setattr(ScalarBackend, "carry_along", refuse)
    f.evaluate(d[ok][long])


def refuse(*_, **__):
    raise AssertionError("handed over")


def test_motions_that_return_after_hundreds_of_events_are_not_handed_over(monkeypatch):
    f = ss.event_map(ss.TwoBlock(2.297, 0.775, 0.269, ss.PoppStelter(3.5, 0.076)), threads=1)
    d = np.linspace(-0.31, -0.2, 60)
    long = d[f.evaluate(d).n_events > 256]
    assert long.size > 5
    assert assert_agreement(f, long).all()
    monkeypatch.setattr(ScalarBackend, "carry_along", refuse)
    f.evaluate(long)


@pytest.mark.parametrize("exponent", [1, 2])
def test_motions_under_a_law_that_rises_in_a_narrow_range_are_not_handed_over(
    monkeypatch, exponent
):
    """Where it is flat to rounding its series do not tell of the rise: steps are halved."""
    law = ss.Stribeck(0.567, 0.0228, exponent=exponent)
    f = ss.event_map(ss.TwoBlock(2.777, 1.374, 0.0833, law), threads=1)
    d = np.random.default_rng(4).uniform(-1, 1, 300) * f.domain[1]
    single = one_at_a_time(f, d)
    monkeypatch.setattr(ScalarBackend, "carry_along", refuse)
    together = f.evaluate(d)
    for field in ("status", "label", "n_events"):
        np.testing.assert_array_equal(getattr(together, field), getattr(single, field))
    # Series may be off by a hundred times the tolerance of 1e-15, in both engines.
    slope = np.abs(single.derivative[:, 0])
    assert (np.abs(together.value - single.value) <= 2e-12 * np.maximum(1.0, slope)).all()
    off = np.abs(together.derivative - single.derivative[:, 0])
    assert (off <= 2e-8 * np.maximum(1.0, slope)).all()


def test_a_motion_does_not_know_its_company():
    f = ss.event_map(ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05)), threads=1)
    d = np.random.default_rng(3).uniform(-0.6, 0.6, 3 * PLACES)
    expected = f.evaluate(d)
    for size in (1, 2, LANES - 1, LANES, MOTIONS + 1):
        some = f.evaluate(d[:size])
        for field in FIELDS:
            np.testing.assert_array_equal(getattr(some, field), getattr(expected, field)[:size])
    np.testing.assert_array_equal(f(d[::-1])[::-1], expected.value)
    np.testing.assert_array_equal(f.derivative(d), expected.derivative)
    orbits = f.iterate(d[:7], 5)
    for k in range(5):
        np.testing.assert_array_equal(orbits[:, k + 1], f(orbits[:, k]))


def state_after(backend, d, n_events):
    """State at an event on the way, as lanes keep it."""
    backend.task(np.array([[d]]), backend.room(1), n_events)(0, 1)
    motion = backend.scratch(backend.no_directions).motion
    limits = backend.model.plant.static
    return np.concatenate([motion.mode, motion.event, motion.w, motion.e / limits])


@pytest.mark.parametrize(
    "model",
    [
        ss.TwoBlock(1.208, 1.301, 0.295, ss.PoppStelter(3.0, 0.1, 0.05)),
        ss.Blocks(
            mass=[1, 2.3],
            stiffness=[[2.2, -1.2], [-1.2, 1.9]],
            damping=[[0.02, -0.01], [-0.01, 0.03]],
            static=[1, 1.3],
            friction=ss.PoppStelter(3.0, 0.1, 0.05),
            V=0.05,
        ),
    ],
    ids=["equal", "unequal"],
)
def test_motions_go_on_from_a_state_at_an_event(model):
    f = ss.event_map(model, threads=1)
    backend, taken = f._backend.scalar, 0
    for d in np.random.default_rng(2).uniform(*f.domain, 30):
        whole = backend.carry(np.array([d]), watch=True)
        if whole.status[0] != OK or whole.n_events[0] < 3:
            continue
        for k in range(1, min(whole.n_events[0], 16)):
            rest = backend.go_on(state_after(backend, d, k)[None], watch=True)
            assert rest.status[0] == OK
            assert rest.n_events[0] == whole.n_events[0] - k
            assert rest.value[0, 0, 0] == pytest.approx(whole.value[0], abs=1e-12)
            assert rest.margin[0] >= whole.margin[0] * (1 - 1e-9)
            taken += 1
    assert taken > 20


def test_motions_without_return_are_told_where_they_are(monkeypatch):
    model = ss.TwoBlock(1.2099, 1.301, 0.295, ss.PoppStelter(3.0, 0.1, 0.05))
    f = ss.event_map(model, threads=1)
    d = np.random.default_rng(4).uniform(-0.6, 0.6, 200)
    result = f.evaluate(d)
    assert {NEVER_CYCLE, NEVER_SLIPPING} & set(result.status.tolist())
    assert (result.status == OK).any()
    single = one_at_a_time(f, d)
    np.testing.assert_array_equal(result.status, single.status)
    lost = result.status != OK
    assert (result.margin[lost] > 0).all()
    assert np.isnan(result.derivative[lost]).all()
    # Contacts are as far away: the scalar engine sees fewer turns.
    close = np.minimum(result.margin, single.margin)[lost]
    np.testing.assert_allclose(close, single.margin[lost], rtol=0.1)
    monkeypatch.setattr(ScalarBackend, "carry_along", refuse)
    orbits = f.iterate(d, 3)
    np.testing.assert_array_equal(np.isnan(orbits[:, 1]), lost)
    assert np.isnan(orbits[lost, 1:]).all()


def test_limits_are_those_of_the_scalar_engine():
    model = ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05))
    d = np.linspace(-0.6, 0.6, 60)
    free = ss.event_map(model, threads=1).evaluate(d)
    for most in (1, 3, 5):
        few = ss.event_map(model, threads=1, max_events=most).evaluate(d)
        over = free.n_events > most
        assert over.any()
        np.testing.assert_array_equal(few.status == EVENT_LIMIT, over)
        np.testing.assert_array_equal(few.n_events[over], most)
        np.testing.assert_array_equal(few.value[~over], free.value[~over])
    limit = float(np.median(free.duration))
    short = ss.event_map(model, threads=1, max_time=limit).evaluate(d)
    np.testing.assert_array_equal(short.status == TIME_LIMIT, free.duration > limit)


def test_a_tie_has_the_margin_and_slope_of_the_scalar_engine():
    model = ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05))
    f = ss.event_map(model, threads=1)
    corner = (model.beta - 1) / (1 + 2 * model.alpha)
    result, single = f.evaluate([corner, 0.3]), one_at_a_time(f, np.array([corner]))
    for field in FIELDS:
        assert np.ravel(getattr(result, field))[0] == np.ravel(getattr(single, field))[0]
    assert result.margin[0] == 0.0
    assert math.isfinite(result.derivative[0])


# --- kernels -----------------------------------------------------------------------------------


def test_a_second_process_compiles_nothing():
    model = ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05))
    value = ss.event_map(model, threads=1)(0.1)
    code = """
import stickslip as ss
f = ss.event_map(ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05)), threads=1)
print(repr(f(0.1)))
stats = f._backend._driver.advance_orbits.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == [repr(value), "1 0"]


def test_another_model_of_the_law_writes_no_code(monkeypatch):
    model = ss.TwoBlock(1.208, 1.301, 0.15, ss.PoppStelter(3.0, 0.1, 0.05))
    f = ss.event_map(model, threads=1)
    values = f(0.1), f.parameter_derivative(0.1, "V")
    monkeypatch.setattr("stickslip.mechanics.flow.lanes.steps.written", None)
    again = ss.event_map(model.replace(V=0.16), threads=1).replace(V=0.15)
    assert (again(0.1), again.parameter_derivative(0.1, "V")) == values


def test_the_masses_are_those_of_the_reduced_plant():
    blocks = ss.Blocks(
        mass=[1.3, 0.7],
        stiffness=[[2, -1], [-1, 3]],
        V=0.1,
        static=[1, 1.2],
        friction=ss.Coulomb(0.3),
    )
    for plant in (ss.examples.law9().plant, blocks.plant):
        mass = pair_numbers(plant)[0, layout.MASS : layout.MASS + 2]
        np.testing.assert_array_equal(mass, plant.reduced.mass)


@pytest.mark.parametrize(
    "law", [ss.PoppStelter(2.0, 0.3), pytest.param(ss.Stribeck(0.4, 0.3), marks=pytest.mark.slow)]
)
def test_steps_that_are_written_out_give_the_numbers_of_their_python(law):
    rng = np.random.default_rng(2)
    series = law_series((law, law))
    compiled, steps = lane_kernels(series), Steps(series)
    p, q = np.repeat(series.rows([law, law]), layout.PLACES, axis=1)
    numbers = np.repeat(pair_numbers(ss.examples.law9().plant)[2], layout.PLACES)
    for n, name in ((1, "one"), (2, "both")):
        x, taken = rng.uniform(0.05, 0.4, KEPT), np.zeros(compiled.SIZE)
        for sign in (layout.SIGN_1, layout.SIGN_2):
            x[sign : sign + LANES] = rng.choice([-1.0, 1.0], LANES)
        x[layout.LAST_TERM : layout.LAST_TERM + LANES] = -50.0
        ours = x.copy(), taken.copy()
        for kind in ("step", "tangent", "turns"):
            given = (numbers,) if kind == "turns" else (p, q, numbers)
            getattr(steps, kind)(n, *ours, *given)
            getattr(compiled, f"{kind}_{name}")(x, taken, *given)
            for written, plain in zip((x, taken), ours, strict=True):
                np.testing.assert_allclose(written, plain, rtol=1e-10, atol=1e-13)
        assert np.ptp(taken[layout.LENGTH : layout.LENGTH + LANES]) > 0.0


@pytest.mark.slow  # compiles a step
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads x86 assembly")
def test_a_step_is_vector_code():
    laws = [ss.PoppStelter(3.0)] * 2
    series = law_series(tuple(laws))
    steps = lane_kernels(series)
    step = kernel_uncached(steps.step_one.py_func)
    p, q = np.repeat(series.rows(laws), layout.PLACES, axis=1)
    numbers = np.repeat(pair_numbers(ss.examples.law9().plant)[0], layout.PLACES)
    step(np.zeros(KEPT), np.zeros(steps.SIZE), p, q, numbers)
    (assembly,) = step.inspect_asm().values()
    packed, scalar = (
        len(re.findall(rf"\bv?(?:fn?m(?:add|sub)\w*|mul|add|sub){kind}\b", assembly))
        for kind in ("pd", "sd")
    )
    assert packed > 200
    assert scalar < packed / 10


def test_an_optional_parameter_that_is_zero_leaves_the_text_and_not_the_answer():
    laws = [ss.PoppStelter(3.0, 0.1, 0.05), ss.PoppStelter(3.0, 0.1), ss.PoppStelter(3.0)]
    square, no_square, neither = (law_series((law, law)) for law in laws)
    assert no_square.force.n_recurrences < square.force.n_recurrences
    assert no_square.key == neither.key != square.key  # delta is in no recurrence
    d = np.linspace(-0.5, 0.5, 20)
    model = ss.TwoBlock(1.208, 1.301, 0.15, laws[2])
    almost = model.replace(eta=1e-300)
    np.testing.assert_allclose(ss.event_map(almost)(d), ss.event_map(model)(d), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("law", "tells"),
    [
        (ss.PoppStelter(3.0, 0.1, 0.05), True),
        (friction_law(lambda s, a: 1 + a * s / 4 - s**3, parameters={"a": 1.0}), True),
        (friction_law(lambda s, a: 0.5 / (1 + a * s) + 0.5 / (1 + s), parameters={"a": 1.0}), True),
        (friction_law(lambda s, a: 1 / (1 + a * s) ** 8, parameters={"a": 1e4}), False),
        (friction_law(lambda s, a: 1 / (1 + a * s * s), parameters={"a": 1e4}), False),
        (friction_law(lambda s, a: s / (1 + a * s), parameters={"a": 1e4}), False),
        (ss.Stribeck(0.4, 0.3), False),
        (ss.Stribeck(0.4, 0.3, exponent=2), False),
    ],
)
def test_only_series_of_polynomials_and_simple_fractions_tell_how_far_they_hold(law, tells):
    assert law_series((law, law)).tells is tells


def test_orbits_of_several_models_are_those_of_each_alone():
    """Law (9) damped or not, of equal and unequal blocks, a gap, constant friction: bit for bit."""
    rng = np.random.default_rng(8)
    models = [
        *(random_model(rng, "law9") for _ in range(9)),
        *random_models("law9", 4, rng),
        *(ss.examples.law9().replace(V=V) for V in (0.05, 0.2, 0.25, 0.3)),
        ss.examples.coulomb(),
        ss.examples.law9().replace(damping=0.01),
    ]
    maps = [ss.event_map(model, threads=1, max_events=300) for model in models]
    starts = [rng.uniform(-1, 1, 3 * (k % 4)) * f.domain[1] for k, f in enumerate(maps)]
    starts[2:4] = [[*d, f.domain[1]] for d, f in zip(starts[2:4], maps[2:4], strict=True)]  # ties
    together = type(maps[0]).iterate_each(maps, starts, 12)
    for f, d, orbits in zip(maps, starts, together, strict=True):
        np.testing.assert_array_equal(orbits, f.iterate(d, 12))
    assert 5 < sum(np.isnan(orbits[:, -1]).sum() for orbits in together) < 20
    kin = [f._backend.kin for f in maps if isinstance(f._backend, PoolBackend)]
    assert len(set(kin)) < len(kin) - 9


def test_orbits_of_several_models_start_in_the_domain_of_each():
    maps = [ss.event_map(ss.examples.law9().replace(alpha=alpha)) for alpha in (0.5, 2.0)]
    start = 0.9 * maps[0].domain[1]
    assert start > maps[1].domain[1]
    with pytest.raises(ValueError, match=r"d\[0\] = 1\.\d+ is outside"):
        maps[0].iterate_each(maps, [[start], [start]], 3)
    with pytest.raises(ValueError, match=r"starts = .* must hold 2 entries, one for each map"):
        maps[0].iterate_each(maps, [[start]], 3)
    with pytest.raises(ValueError, match="n = -1"):
        maps[0].iterate_each(maps, [0.1, 0.1], -1)
    assert maps[0].iterate_each(maps, [[[0.1]], 0.1], 3)[0].shape == (1, 1, 4)
