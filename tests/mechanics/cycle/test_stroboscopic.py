"""Forced models, looked at once per period of the forcing."""

from __future__ import annotations

import math
import pickle
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import OrbitSurvey
from stickslip.analysis.orbits.orbits_nd import distinct_orbits, search_orbits
from stickslip.analysis.work import Work
from stickslip.mechanics.cycle.shooting import Shooter

BLOCK = ss.Oscillator(
    V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(2.0, 0.7)
)


def test_values_are_those_of_the_motion_in_time() -> None:
    f = ss.stroboscopic_map(CHAIN)
    x, v = CHAIN.sample_state(3)
    end = ss.simulate(CHAIN, x, v, t_end=f.period).final_state
    np.testing.assert_allclose(f(np.concatenate([x, v])), [*end.x, *end.v], rtol=0, atol=1e-14)
    later = ss.simulate(CHAIN, x, v, t_end=4 * f.period).final_state
    orbit = f.iterate(np.concatenate([x, v]), 4)
    np.testing.assert_allclose(orbit[-1], [*later.x, *later.v], rtol=0, atol=1e-12)


def test_the_jacobian_without_events_is_that_of_the_linear_motion() -> None:
    """A block that slips all the time: the exponential of a damped oscillator's matrix."""
    block = ss.Oscillator(
        V=5.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(0.3, 1.7)
    )
    f = ss.stroboscopic_map(block)
    with mp.workdps(30):  # scipy's expm errs by 1.6e-14 here
        expected = mp.expm(mp.matrix([[0.0, 1.0], [-1.0, -0.2]]) * 2 * mp.pi / mp.mpf(1.7))
    expected = np.array(expected.tolist(), dtype=float)
    np.testing.assert_allclose(f.derivative([0.4, 0.2]), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_the_jacobian_through_events_is_the_slope_of_the_map(seed: int) -> None:
    f = ss.stroboscopic_map(BLOCK.replace(V=0.2, friction=ss.PoppStelter(gamma=3)))
    state = np.concatenate(f.model.sample_state(seed))
    h = 1e-6
    ahead, behind = (f(state + sign * h * np.eye(2)) for sign in (1, -1))
    np.testing.assert_allclose(f.derivative(state), (ahead - behind).T / (2 * h), rtol=0, atol=2e-8)


CHAIN = ss.Chain(
    static=[1, 1.2],
    alpha=0.8,
    V=0.3,
    friction=ss.PoppStelter(gamma=2),
    damping=0.1,
    forcing=ss.Harmonic([0.4, 0.0], 1.3, 0.5),
)
# Masses that share inertia make coordinates depend on parameters; so does a belt that sways.
SHARED = ss.Structure(
    mass=[[2.0, 0.3], [0.3, 1.0]],
    stiffness=[[3.0, -1.0], [-1.0, 2.0]],
    damping=[[0.1, 0.0], [0.0, 0.2]],
    contacts=[
        ss.Contact(at=0, static=1.0, friction=ss.PoppStelter(gamma=2), V=ss.Harmonic(0.3, 1.1, 0.4))
    ],
)


@pytest.mark.parametrize("model", [CHAIN, SHARED], ids=["chain", "shared"])
def test_derivatives_in_all_parameters_are_slopes_of_the_map(model: Any) -> None:
    """Those that move the period of the forcing, the belt and the coordinates among them."""
    f, names = ss.stroboscopic_map(model), 0
    state = np.concatenate(model.sample_state(2))
    for name, value in model.parameters.items():
        h = 1e-6 * max(abs(value), 1.0)
        try:
            ahead, behind = (f.replace(**{name: value + sign * h})(state) for sign in (1, -1))
        except ValueError:
            continue  # at the end of what is allowed
        slope, size = f.parameter_derivative(state, name), np.abs(ahead).max()
        np.testing.assert_allclose(
            slope, (ahead - behind) / (2 * h), rtol=2e-8, atol=2e-8 * (1 + size), err_msg=name
        )
        names += 1
    assert names >= 10


def test_a_frequency_without_the_others_is_no_parameter() -> None:
    """The forces would lose their common period."""
    two = SHARED.replace(forcing=[ss.Harmonic([0.1, 0.0], 2.2)])
    with pytest.raises(ValueError, match="common period"):
        ss.stroboscopic_map(two).parameter_derivative(np.zeros(4), "forcing.frequency")


def test_frequencies_without_a_common_period_are_told_as_they_were_given() -> None:
    two = SHARED.replace(forcing=[ss.Harmonic([0.1, 0.0], 1.1 * np.sqrt(2.0))])
    with pytest.raises(ValueError, match=r"^the frequencies 1\.1 and 1\.5556\d* have no common"):
        ss.stroboscopic_map(two)


def test_labels_tell_the_events_of_a_period() -> None:
    """A map of R^n has a label for each piece: here from one sequence of modes to another."""
    f = ss.stroboscopic_map(BLOCK)
    states = np.random.default_rng(1).uniform(-2.0, 2.0, size=(40, 2))
    labels = f.evaluate(states).label
    legs = [f._backend.leg(Shooter(BLOCK), s) for s in states]
    words = [tuple(e[1:] for e in leg.events) for leg in legs]
    starts = np.sign(states[:, 1])
    told = {(start, word): label for start, word, label in zip(starts, words, labels, strict=True)}
    assert len(set(told.values())) == len(set(labels.tolist())) > 3
    assert len(told) == len(set(labels.tolist()))
    texts = f.itinerary(states).tolist()
    assert len(set(zip(texts, labels.tolist(), strict=True))) == len(set(texts)) == len(told)
    assert f.itinerary([0.0, 0.0])[0] == "+"  # pushed at once


def test_a_map_is_known_by_its_model_and_settings() -> None:
    f = ss.stroboscopic_map(BLOCK, domain=[(-1.0, 1.0), (-2.0, 2.0)])
    again = pickle.loads(pickle.dumps(f))
    assert again == f
    assert hash(again) == hash(f)
    np.testing.assert_array_equal(again([0.1, 0.2]), f([0.1, 0.2]))
    assert f != ss.stroboscopic_map(BLOCK)
    assert f.replace(damping=0.3) != f
    clocked = ss.stroboscopic_map(ss.examples.coulomb(), period=2.0)
    assert clocked.replace(V=0.04).settings == clocked.settings


def test_a_state_beyond_the_ranges_given_is_no_point_of_the_map() -> None:
    """The map said that it contains every state."""
    free = ss.stroboscopic_map(BLOCK)
    f = ss.stroboscopic_map(BLOCK, domain=[(-1.0, 1.0), (-2.0, 2.0)])
    states = np.array([[0.5, 0.0], [1.5, 0.0], [0.0, np.nan]])
    np.testing.assert_array_equal(f.contains(states), [True, False, False])
    np.testing.assert_array_equal(free.contains(states), [True, True, False])
    there, here = free.iterate([0.5, 0.0], 3), f.iterate([0.5, 0.0], 3)
    assert not f.contains(there[1])
    np.testing.assert_array_equal(here[:2], there[:2])
    assert np.isnan(here[2:]).all()


@pytest.mark.slow  # in every run: events along the amplitude, test_attractors_of_forced_blocks.py
def test_the_corner_of_a_forced_block_where_one_orbit_becomes_three() -> None:
    """At a frequency of 0.586135: all orbits, and two folds beside it, are located."""
    block = BLOCK.replace(damping=0.05, **{"forcing.frequency": 0.586})
    f = ss.stroboscopic_map(block, domain=[(2.0, 4.0), (0.0, 1.0)])
    survey = OrbitSurvey(f, "forcing.frequency", 0.5855, 0.5867, 1, 16)
    survey.run(2, Work())
    kinds = [item.kind for item in survey.events]
    assert kinds == ["border_collision", "fold", "fold"]
    corner, *folds = survey.events
    assert corner.value == pytest.approx(0.5861350016, abs=1e-10)
    assert [len(corner.orbits_before), len(corner.orbits_after)] == [1, 3]
    assert corner.block == 1
    assert corner.mechanism.startswith("block 1 comes to rest at the upper end of its stick")
    # The mirror symmetry of the motion makes the folds a pair.
    assert folds[0].value == pytest.approx(folds[1].value, abs=1e-11)
    assert survey.unresolved == []


def test_what_creeps_within_rounding_rests() -> None:
    """Kinetic friction holds less than rest: a creep of 1e-32 made points that are no orbit's."""
    block = BLOCK.replace(damping=0.05, forcing=ss.Harmonic(1.4, 0.45, 4.0))
    f = ss.stroboscopic_map(block, domain=[(-4.0, 4.0), (-2.0, 2.0)])
    at_rest = f.evaluate([-1.86888133, 0.0])
    for creep in (2e-32, -1e-18, 1e-15):
        got = f.evaluate([-1.86888133, creep])
        assert got.label == at_rest.label
        np.testing.assert_array_equal(got.value, at_rest.value)
    for orbit in search_orbits(f, 1, None, 4):
        np.testing.assert_allclose(f(f(orbit.points)), orbit.points, rtol=0, atol=1e-11)


@pytest.mark.parametrize("phase", [3.0, 4.0])
def test_orbits_are_followed_where_an_event_crosses_the_phase_of_the_map(phase: float) -> None:
    """A corner of the map that leaves multipliers as they are: a landing, a release."""
    block = BLOCK.replace(damping=0.05, forcing=ss.Harmonic(1.4, 0.45, phase))
    f = ss.stroboscopic_map(block, domain=[(-4.0, 4.0), (-2.0, 2.0)])
    cycle = ss.find_cycle(block, [0.0], [0.0])
    (orbit,) = distinct_orbits(f, np.concatenate([cycle.x, cycle.v])[None, None])
    curve = ss.follow(orbit, "forcing.amplitude", (1.2, 2.0))
    assert curve.end_reasons == ("end of range", "end of range")
    assert len(set(curve.data["labels"][:, 0].tolist())) == 2
    other = curve.at(**{"forcing.amplitude": 1.9})
    known = ss.find_cycle(block.replace(**{"forcing.amplitude": 1.9}), [0.0], [0.0])
    np.testing.assert_allclose(other.points[0], [*known.x, *known.v], rtol=0, atol=1e-9)
    np.testing.assert_allclose(other.multipliers[0], known.multipliers[0], rtol=0, atol=1e-8)


def test_sticking_forgets_exactly() -> None:
    """At rest on the belt a push of the velocity changes nothing; a stick leaves rank one."""
    f = ss.stroboscopic_map(BLOCK.replace(forcing=ss.Harmonic(1.2, 0.7, math.pi / 2)))
    jacobian = f.derivative([0.1, 0.0])
    np.testing.assert_array_equal(jacobian[:, 1], 0.0)
    assert np.isneginf(ss.lyapunov_spectrum(f, [0.1, 0.0], 50, transient=100).values[-1])


def test_periodic_points_repeat_and_diagrams_find_them() -> None:
    f = ss.stroboscopic_map(BLOCK)
    cycle = f.periodic_point([0.0, 0.0])
    point = np.concatenate([cycle.x, cycle.v])
    times = round(cycle.period / f.period)
    np.testing.assert_allclose(f.iterate(point, times)[-1], point, rtol=0, atol=1e-12)
    visited = f.diagram("forcing.amplitude", [2.0, 2.0], [0.0, 0.0], transient=60, n=4)
    assert visited.shape == (2, 4, 2)
    np.testing.assert_allclose(visited[1, :, :], visited[0, :, :], rtol=0, atol=1e-10)
    assert ss.lyapunov_spectrum(f, [0.0, 0.0], 60, transient=100).values[0] < 0


def test_multipliers_of_a_forced_cycle_are_slopes_of_the_map() -> None:
    """Damping 0.3 and a law that flattens: two multipliers, complex or real, none forgotten."""
    block = ss.Oscillator(
        V=0.0, friction=ss.PoppStelter(gamma=1), damping=0.1, forcing=ss.Harmonic(4.0, 1.7)
    )
    f = ss.stroboscopic_map(block)
    cycle = f.periodic_point([0.3, 0.0])
    assert cycle.events
    point, h = np.concatenate([cycle.x, cycle.v]), 1e-6
    times = round(cycle.period / f.period)
    ahead, behind = (f.iterate(point + sign * h * np.eye(2), times)[:, -1] for sign in (1, -1))
    values = np.linalg.eigvals((ahead - behind).T / (2 * h))
    expected = values[np.argsort(-np.abs(values), kind="stable")]
    np.testing.assert_allclose(np.abs(cycle.multipliers), np.abs(expected), rtol=0, atol=1e-7)
    assert 0 < abs(cycle.multipliers[1]) < 1


# ------------------------------------------------------------------ exponents in time


def test_exponents_of_sliding_blocks_are_growth_rates() -> None:
    chain = CHAIN.replace(V=30.0, friction=ss.Coulomb(mu=0.3), damping=0.2, forcing=None)
    f = ss.stroboscopic_map(chain, period=1.3)
    found = ss.lyapunov_spectrum(f, np.concatenate(chain.sample_state(0)), 400)
    rates = np.linalg.eigvals(chain.plant.reduced.flow).real
    np.testing.assert_allclose(found.per_time, np.sort(rates)[::-1], rtol=0, atol=1e-11)


def test_exponents_of_a_chaotic_motion_are_those_of_the_event_map_by_the_time_of_a_return() -> None:
    """Sticking leaves two directions of four: that of the flow, and that of the map."""
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.05, friction=ss.Coulomb(mu=0.22))
    f = ss.stroboscopic_map(model, period=7.0)
    found = ss.lyapunov_spectrum(f, np.concatenate(model.sample_state(1)), 1500, transient=100)
    motion = ss.simulate(model, d=0.1, t_end=20_000, record="events")
    of_map = ss.lyapunov_exponent(model, 0.1, len(motion.d))
    rate = of_map.value * len(motion.d) / 20_000
    (first, flow, *gone), errors = found.per_time, found.errors / f.period
    assert first > 5 * errors[0]
    assert abs(first - rate) < 4 * errors[0]
    assert abs(flow) < 4 * errors[1]
    assert gone == [-np.inf, -np.inf]
    assert (found.dimension, found.dimension_error) == (2.0, 0.0)


def test_exponents_of_a_cycle_are_those_of_its_multipliers_and_zero() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.04, friction=ss.Coulomb(mu=0.22))
    cycle = ss.find_cycle(model, *model.sample_state(1))
    f = ss.stroboscopic_map(model, period=cycle.period)
    found = ss.lyapunov_spectrum(f, [*cycle.x, *cycle.v], 30, transient=5)
    expected = [0.0, np.log(abs(cycle.multipliers[0])), -np.inf, -np.inf]
    np.testing.assert_allclose(found.values, expected, rtol=0, atol=1e-9)
    assert found.dimension == pytest.approx(1.0, abs=1e-8)


def test_an_event_map_knows_no_time_of_a_step() -> None:
    """Its durations are those of slips: what sticks longer would be left out."""
    chain = ss.Chain(static=(1.0, 1.1, 1.2), alpha=1.0, V=0.1, friction=ss.Coulomb(mu=0.22))
    assert np.isnan(ss.lyapunov_spectrum(chain, [0.1, 0.2], 20, transient=5).duration)


def test_why_a_motion_ends_within_a_period_is_told() -> None:
    """The load 1 + 0.8 x vanishes as the force pushes the block back."""
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), static=0.5, load=[0.8])
    block = ss.Structure([1], [[1]], contacts=[contact], forcing=ss.Harmonic(2.0, 0.7))
    lost = ss.stroboscopic_map(block).evaluate([0.0, 0.0])
    assert lost.status == ss.status.CONTACT_LOST
    assert np.isnan(lost.value).all()
    few = ss.stroboscopic_map(BLOCK, max_events=1).evaluate([0.0, 0.0])
    assert few.status == ss.status.EVENT_LIMIT


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match="unforced: give period="):
        ss.stroboscopic_map(ss.examples.coulomb())
    with pytest.raises(ValueError, match="its forcing tells"):
        ss.stroboscopic_map(BLOCK, period=3.0)
    with pytest.raises(ValueError, match="period = -1"):
        ss.stroboscopic_map(ss.examples.coulomb(), period=-1)
    with pytest.raises(ValueError, match=r"stickslip\.find_cycle"):
        ss.stroboscopic_map(ss.examples.coulomb(), period=1.0).periodic_point([0.0] * 4)
    f = ss.stroboscopic_map(BLOCK)
    with pytest.raises(ValueError, match="2 finite numbers"):
        f([0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="n = "):
        f.iterate([0.0, 0.0], -1)
    np.testing.assert_array_equal(f.iterate([0.1, 0.0], 0), [[0.1, 0.0]])
    assert f.period == pytest.approx(2 * math.pi / 0.7)


@pytest.mark.parametrize("start", [0.5, 0.45, -0.6])
def test_a_cycle_with_multiplier_one_is_found_as_well_as_rounding_lets(start: float) -> None:
    """Newton's method comes to such a cycle slowly: half of the way in each step.

    Force cos(2t/3) / 0.9 on a block at rest on the ground: it sticks from t = pi/2 to pi.
    """
    forcing = ss.Harmonic(amplitude=1 / 0.9, frequency=2 / 3)
    block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=1.0), forcing=forcing)
    cycle = ss.stroboscopic_map(block).periodic_point([start, 0.0])
    np.testing.assert_allclose(cycle.multipliers, [1.0, 0.0], rtol=0, atol=1e-4)
    times = np.sort([event.time for event in cycle.events])
    np.testing.assert_allclose(times, np.pi * np.array([0.5, 1, 2, 2.5]), rtol=0, atol=1e-4)
