"""The event map as a function: values, shapes, itineraries, iterates, errors, equal bits."""

import itertools
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq
from tests.mechanics.flow.systems import (
    COULOMB,
    LAW_9,
    LAW_OF,
    STEPPERS,
    models,
    random_model,
    regular_points,
)
from tests.reference.checks import by_solve_ivp
from tests.reference.law9 import Smooth
from tests.reference.laws import PoppStelter
from tests.reference.values import COULOMB_JUMPS, COULOMB_ORBITS, LAW9_ORBITS
from tests.sizes import tries

import stickslip as ss
from stickslip.analysis.maps.derived import windowed

PAPER = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))


def map_of(stepper: str, **settings):
    law, engine = STEPPERS[stepper]
    model = ss.TwoBlock(alpha=1.208, beta=1.301, V=0.15, friction=law)
    return ss.event_map(model, engine=engine, **settings)


# --- what it is --------------------------------------------------------------------------------


@tries(12, 60)
@given(model=models(COULOMB, LAW_9), share=st.floats(-1.0, 1.0))
def test_the_image_lies_inside_the_domain(model, share):
    f = ss.event_map(model, threads=1, max_events=300)
    result = f.evaluate(share * f.domain[1])
    if result.status == ss.status.OK:
        # rounding of d = (e_2 - e_1) / (1 + 2 alpha) of two forces at most at their limits
        assert abs(result.value) <= f.domain[1] * (1.0 + 1e-14)
        assert result.duration > 0.0
        assert result.n_events >= 1
    else:
        assert np.isnan(result.value)
        assert np.isnan(result.derivative)
    assert result.margin >= 0.0
    assert result.status in range(len(ss.status.NAMES))


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_step_of_the_map_is_a_motion_between_global_sticks(stepper):
    f = map_of(stepper)
    for d in (-0.3, 0.05, 0.42):
        trajectory = ss.simulate(f.model, d=d, until="stick", engine=f.engine)
        result = f.evaluate(d)
        # the same steps, but one kernel call at a time and with quadrature-sized steps
        assert trajectory.d == pytest.approx([d, result.value], abs=1e-13)
        assert trajectory.t[-1] == pytest.approx(result.duration, abs=1e-12)
        assert len(trajectory.t) - 1 == result.n_events
        symbols = {-1: "-", 0: ".", 1: "+"}
        modes = [symbols[a] + symbols[b] for a, b in trajectory.modes] + [".."]
        assert f.itinerary(d) == " ".join(modes)
        assert trajectory.final_state.v.tolist() == [f.model.V] * 2


def test_values_at_ordinary_points_are_those_of_a_solver_with_sign_change_events():
    reference = Smooth(1.208, 1.301, 0.15, PoppStelter(3.0, 0.1, 0.05))
    f = map_of("taylor")
    law = f.model.laws[0]
    points = regular_points(f, 4, np.random.default_rng(4), margin=3e-2)
    assert points.size == 4
    for d in points.tolist():
        # a small push off the surface, as such solvers need where the slip starts tangentially
        value, itinerary = by_solve_ivp(
            reference, d, lambda i, s: f.model.limits[i] * float(law.force(s)), push=1e-7
        )
        assert f(d) == pytest.approx(value, abs=1e-4)
        assert f.itinerary(d) == itinerary


@pytest.mark.parametrize("stepper", STEPPERS)
def test_results_have_the_shape_of_their_argument(stepper):
    f = map_of(stepper)
    d = np.linspace(-0.5, 0.5, 6)
    grid = d.reshape(2, 3)
    assert isinstance(f(0.1), float)
    assert isinstance(f.derivative(0.1), float)
    assert isinstance(f.parameter_derivative(0.1, "V"), float)
    assert isinstance(f.itinerary(0.1), str)
    for result in (f(grid), f.derivative(grid), f.parameter_derivative(grid, "V")):
        assert result.shape == (2, 3)
    assert f(np.zeros((0, 4))).shape == (0, 4)
    assert f(grid).ravel().tolist() == f(d).tolist() == [f(x) for x in d.tolist()]
    assert f(list(d)).tolist() == f(d).tolist()
    assert f.itinerary(grid).shape == (2, 3)
    assert f.iterate(grid, 4).shape == (2, 3, 5)
    result = f.evaluate(grid)
    for field in ("value", "derivative", "duration", "n_events", "label", "margin", "status"):
        assert getattr(result, field).shape == (2, 3)
        assert np.ndim(getattr(f.evaluate(0.1), field)) == 0
    assert (result.label.dtype, result.status.dtype) == (np.uint64, np.int64)
    assert f(1) == f(1.0) if 1.0 <= f.domain[1] else True


@pytest.mark.parametrize("stepper", STEPPERS)
def test_all_ways_to_ask_give_the_same_numbers(stepper):
    f = map_of(stepper)
    d = np.linspace(*f.domain, 41)
    result = f.evaluate(d)
    np.testing.assert_array_equal(f(d), result.value)
    np.testing.assert_array_equal(f.derivative(d), result.derivative)
    both = result.value, result.derivative
    np.testing.assert_array_equal(f.value_and_derivative(d), both)
    for other in (f.power(2), windowed(f, (-0.1, 0.1))):
        inside = d[np.abs(d) < 0.1]
        result = other.evaluate(inside)
        both = result.value, result.derivative
        np.testing.assert_array_equal(other.value_and_derivative(inside), both)
    result = f.evaluate(d)
    np.testing.assert_array_equal(f.iterate(d, 1)[:, 1], result.value)


# --- itineraries and labels --------------------------------------------------------------------


@pytest.mark.parametrize("stepper", STEPPERS)
def test_labels_name_itineraries(stepper):
    f = map_of(stepper)
    d = np.linspace(*f.domain, 121)[1:-1]
    result = f.evaluate(d)
    texts = f.itinerary(d)
    for (label_1, text_1), (label_2, text_2) in itertools.combinations(
        sorted(set(zip(result.label.tolist(), texts.tolist(), strict=True))), 2
    ):
        assert label_1 != label_2
        assert text_1 != text_2
    assert len(set(texts)) > 3
    for text, n_events in zip(texts.tolist(), result.n_events.tolist(), strict=True):
        phases = text.split(" ")
        assert len(phases) == n_events + 1
        assert phases[0] in ("-.", ".-", "--")
        assert phases[-1] == ".."
        assert ".." not in phases[:-1]
        # sticks of zero length leave the itinerary: every phase differs from the one before
        assert all(a != b for a, b in itertools.pairwise(phases))


def test_the_first_slip_is_that_of_the_onset_rule():
    corner = 0.3 / 3.4  # (beta - 1) / (1 + 2 alpha)
    f = ss.event_map(PAPER)
    assert f.itinerary(corner - 1e-12).startswith("-.")
    assert f.itinerary(corner).startswith("--")
    assert f.itinerary(corner + 1e-12).startswith(".-")


def test_long_itineraries_are_complete():
    model = ss.TwoBlock(
        alpha=2.91737005609785,
        beta=1.958962156189406,
        V=0.08971306694414999,
        friction=ss.Coulomb(mu=0.06224244484511507),
    )
    f = ss.event_map(model)
    d = 0.0542355 + 1e-9 * np.arange(200)  # chaotic transients: where each ends rounding decides
    found = f.evaluate(d)
    long = np.flatnonzero((found.status == ss.status.OK) & (found.n_events > 1000))[0]
    text = f.itinerary(d[long])
    assert len(text.split(" ")) == found.n_events[long] + 1
    assert text.endswith(" ..")
    assert text.split(" ").count("..") == 1


# --- iterates, threads, batches ----------------------------------------------------------------


@pytest.mark.parametrize("stepper", STEPPERS)
def test_an_iterate_is_repeated_calls_bit_for_bit(stepper):
    f = map_of(stepper)
    d = np.linspace(*f.domain, 17)
    orbits = f.iterate(d, 8)
    np.testing.assert_array_equal(orbits[:, 0], d)
    for k in range(8):
        np.testing.assert_array_equal(orbits[:, k + 1], f(orbits[:, k]))
    assert f.iterate(0.1, 0).tolist() == [0.1]


def test_nan_stays_nan_inside_an_iterate():
    f = ss.event_map(PAPER, max_events=3)
    d = np.linspace(*f.domain, 201)
    orbits = f.iterate(d, 20)
    lost = np.isnan(orbits)
    assert 0 < lost[:, -1].sum() < d.size
    assert np.all(lost[:, 1:] >= lost[:, :-1])


@pytest.mark.parametrize(("stepper", "size"), [("exact", 20_000), ("taylor", 700)])
def test_threads_and_batches_change_no_bit(stepper, size):
    d = np.random.default_rng(1).uniform(-0.6, 0.6, size)
    expected = map_of(stepper, threads=1).evaluate(d)
    fields = ("value", "derivative", "duration", "n_events", "label", "margin", "status")
    for threads in (2, 3, 7):
        f = map_of(stepper, threads=threads)
        result = f.evaluate(d)
        for field in fields:
            np.testing.assert_array_equal(getattr(result, field), getattr(expected, field))
        np.testing.assert_array_equal(f.iterate(d, 2)[:, 1], expected.value)
    f = map_of(stepper, threads=2)
    for chunk in (1, 3, 50):
        some = d[:100]
        pieces = [f(some[i : i + chunk]) for i in range(0, 100, chunk)]
        np.testing.assert_array_equal(np.concatenate(pieces), expected.value[:100])
    np.testing.assert_array_equal(f(d[::-1])[::-1], expected.value)


def test_one_map_serves_many_threads_at_once():
    from concurrent.futures import ThreadPoolExecutor

    f = map_of("exact", threads=1)
    d = np.linspace(-0.6, 0.6, 500)
    expected = f(d)
    with ThreadPoolExecutor(4) as pool:
        for result in pool.map(f, [d] * 12):
            np.testing.assert_array_equal(result, expected)


# --- domain and errors -------------------------------------------------------------------------


@pytest.mark.parametrize("stepper", STEPPERS)
def test_both_ends_are_one_sided_limits_and_reach_four_ulp_further(stepper):
    f = map_of(stepper)
    for end in f.domain:
        value = f(end)
        ulp = np.spacing(end)
        for k in (1, 2, 3, 4):
            assert f(end + k * ulp) == value  # ulp has the sign of end: further out
        # From inside: block 2 (block 1) still rides at its lower limit, so the branch goes on
        assert f.itinerary(end) == f.itinerary(end * (1 - 1e-9))
        assert f(end * (1 - 1e-9)) == pytest.approx(value, abs=1e-6)
        with pytest.raises(ValueError, match="outside the global stick locus"):
            f(end + 64 * ulp)


def test_errors_name_index_value_and_domain():
    f = ss.event_map(PAPER)
    with pytest.raises(ValueError, match=r"d\[2\] = 0\.7012 .*\|d\| <= 0\.67647.*alpha=1\.2"):
        f([0.1, 0.2, 0.7012])
    with pytest.raises(ValueError, match=r"d\[0, 1\] = nan"):
        f([[0.1, np.nan], [0.0, 0.0]])
    with pytest.raises(ValueError, match=r"d = -inf"):
        f(-np.inf)
    with pytest.raises(ValueError, match=r"d = '0\.1' is not made of real numbers"):
        f("0.1")
    for method in (f.derivative, f.evaluate, f.itinerary):
        with pytest.raises(ValueError, match=r"d = nan"):
            method(np.nan)
    with pytest.raises(ValueError, match=r"d = nan"):
        f.iterate(np.nan, 3)
    with pytest.raises(ValueError, match=r"d = nan"):
        f.parameter_derivative(np.nan, "V")


@pytest.mark.parametrize("n", [-1, 1.5, True])
def test_a_number_of_iterations_that_is_none(n):
    with pytest.raises(ValueError, match="n = "):
        ss.event_map(PAPER).iterate(0.1, n)


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("rtol", 0.0),
        ("rtol", float("nan")),
        ("rtol", 0.1),
        ("max_events", 0),
        ("max_events", 2.5),
        ("max_events", True),
        ("max_time", 0.0),
        ("max_time", float("nan")),
        ("engine", "fast"),
        ("device", "gpu"),
        ("threads", 0),
        ("threads", -2),
    ],
)
def test_settings_that_are_not_allowed_are_named(setting, value):
    with pytest.raises(ValueError, match=f"{setting} = ") as error:
        ss.event_map(PAPER, **{setting: value})
    assert repr(value) in str(error.value)


def test_a_wrong_model_engine_or_parameter_is_explained():
    with pytest.raises(ValueError, match=r"model = 'coulomb' is not a model.*ss\.TwoBlock"):
        ss.event_map("coulomb")
    with pytest.raises(ValueError, match=r"constant kinetic friction.*engine='auto'"):
        ss.event_map(ss.examples.law9(), engine="exact")
    for name in ("mu_1", []):
        with pytest.raises(
            ValueError, match=rf"name = {re.escape(repr(name))}.* is not a parameter"
        ):
            ss.event_map(PAPER).parameter_derivative(0.1, name)


def test_maps_are_values():
    f = ss.event_map(PAPER, max_events=50)
    assert f == ss.event_map(PAPER, max_events=50)
    assert hash(f) == hash(ss.event_map(PAPER, max_events=50))
    assert f != ss.event_map(PAPER)
    assert f != "f"
    changed = f.replace(V=0.04)
    assert changed.parameters["V"] == 0.04
    assert changed.max_events == 50
    assert f.parameters["V"] == 0.0366
    assert f.domain == PAPER.domain
    assert "EventMap(TwoBlock(alpha=1.2" in repr(f)


def test_a_result_prints_as_a_table():
    f = ss.event_map(PAPER, max_events=2)
    text = repr(f.evaluate(np.linspace(-0.6, 0.6, 20)))
    assert "EVENT_LIMIT" in text.splitlines()[0]
    assert "12 more" in text.splitlines()[-1]
    messages = f.evaluate([0.1, 0.0]).message
    assert messages.shape == (2,)
    assert all(isinstance(str(m), str) and m for m in messages)


# --- engines and the paper's numbers -----------------------------------------------------------


def test_exact_and_adaptive_engine_agree_on_coulomb():
    rng = np.random.default_rng(11)
    compared = 0
    for _ in range(12):
        model = random_model(rng, "coulomb")
        exact = ss.event_map(model)
        adaptive = ss.event_map(model, engine="adaptive")
        d = regular_points(exact, 15, rng, margin=1e-3)
        one, other = exact.evaluate(d), adaptive.evaluate(d)
        np.testing.assert_array_equal(one.label, other.label)
        np.testing.assert_allclose(one.value, other.value, rtol=0, atol=2e-13)
        np.testing.assert_allclose(one.derivative, other.derivative, rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(one.margin, other.margin, rtol=1e-6)
        compared += d.size
    assert compared > 100


def test_taylor_and_collocation_steppers_agree_on_law_9():
    rng = np.random.default_rng(12)
    compared = 0
    for _ in range(6):
        model = random_model(rng, "untraced")
        twin = model.replace(friction=ss.PoppStelter(gamma=model.parameters["g"]))
        taylor, collocation = ss.event_map(twin), ss.event_map(model)
        d = regular_points(taylor, 8, rng, margin=1e-3)
        one, other = taylor.evaluate(d), collocation.evaluate(d)
        np.testing.assert_array_equal(one.label, other.label)
        np.testing.assert_allclose(one.value, other.value, rtol=0, atol=1e-11)
        np.testing.assert_allclose(one.derivative, other.derivative, rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(one.margin, other.margin, rtol=1e-5)
        compared += d.size
    assert compared > 30


@pytest.mark.paper
@pytest.mark.parametrize(("name", "period"), [("S1", 1), ("U1", 1), ("U2", 1), ("S4", 4)])
@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_coulomb_orbits_of_figure_5(name, period, engine):
    point, multiplier = map(float, COULOMB_ORBITS[name])
    f = ss.event_map(PAPER, engine=engine)
    found = brentq(
        lambda d: f.iterate(d, period)[-1] - d, point - 1e-4, point + 1e-4, xtol=1e-16, rtol=1e-15
    )
    assert found == pytest.approx(point, abs=1e-13)
    slopes = f.derivative(f.iterate(found, period)[:-1])
    assert np.prod(slopes) == pytest.approx(multiplier, abs=1e-10)


@pytest.mark.paper
@pytest.mark.parametrize("stepper", ["taylor", "collocation"])
def test_law_9_fixed_point_of_figure_12(stepper):
    point, multiplier = map(float, LAW9_ORBITS["P1"])
    law = ss.PoppStelter(gamma=3.0) if stepper == "taylor" else STEPPERS["collocation"][0]
    f = ss.event_map(ss.examples.law9(friction=law))
    found = brentq(lambda d: f(d) - d, point - 1e-4, point + 1e-4, xtol=1e-16, rtol=1e-15)
    assert found == pytest.approx(point, abs=1e-11)
    assert f.derivative(found) == pytest.approx(multiplier, abs=1e-9)


@pytest.mark.paper
@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_jumps_of_figure_5_from_both_sides(engine):
    f = ss.event_map(PAPER, engine=engine)
    for where, left, right in COULOMB_JUMPS:
        d = float(where)
        # a contact made or missed 1e-9 away leaves a trace of size sqrt(1e-9)
        assert f(d - 1e-9) == pytest.approx(float(left), abs=3e-3)
        assert f(d + 1e-9) == pytest.approx(float(right), abs=3e-3)
        assert f.itinerary(d - 1e-13) != f.itinerary(d + 1e-13)


def test_random_systems_use_every_stepper():
    for stepper, law in LAW_OF.items():
        model = random_model(np.random.default_rng(0), law)
        assert repr(stepper) in repr(ss.event_map(model))


@pytest.mark.parametrize("shape", [(0,), (0, 3), (3, 0)])
def test_a_result_without_motions_can_be_shown(shape):
    result = ss.event_map(PAPER).evaluate(np.empty(shape))
    assert repr(result).startswith("EventMapResult")
    assert result.value.shape == shape


@pytest.mark.parametrize(
    "f",
    [
        ss.event_map(ss.examples.coulomb(), max_events=300),
        ss.event_map(ss.examples.law9(), threads=1),
        ss.event_map(ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.1, friction=ss.Coulomb(mu=0.3))),
        ss.return_map(
            ss.Oscillator(
                V=0.02,
                friction=ss.Coulomb(mu=0.4),
                forcing=ss.Harmonic(amplitude=0.3, frequency=0.45),
            )
        ),
        ss.quasistatic_map(ss.examples.coulomb()),
    ],
    ids=lambda f: type(f).__name__,
)
def test_a_map_travels_to_other_processes_as_model_and_settings(f):
    again = pickle.loads(pickle.dumps(f))
    assert type(again) is type(f)
    assert again == f
    assert again.settings == f.settings
