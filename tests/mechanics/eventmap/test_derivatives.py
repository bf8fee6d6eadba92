"""Derivatives in d and in every parameter, against differences of eighth order."""

import numpy as np
import pytest
from tests.mechanics.flow.systems import LAW_OF, random_model, regular_points

import stickslip as ss

NODES = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
# What the project promises, relative to the derivative or to 1.
RELATIVE = 1e-7
SYSTEMS = {"exact": 25, "taylor": 12, "collocation": 2}
POINTS = {"exact": 12, "taylor": 6, "collocation": 2}


def difference(values: np.ndarray, step: float) -> np.ndarray:
    """Derivative from values at the nodes, which are its first axis."""
    return np.tensordot(WEIGHTS, values, axes=1) / step


def maps(stepper: str, seed: int):
    """Random systems of a stepper with points away from breakpoints."""
    rng = np.random.default_rng(seed)
    for _ in range(SYSTEMS[stepper]):
        f = ss.event_map(random_model(rng, LAW_OF[stepper]), max_events=500)
        d = regular_points(f, POINTS[stepper], rng, margin=0.06)
        if d.size:
            yield f, d


@pytest.mark.parametrize("stepper", LAW_OF)
def test_slope_of_the_map(stepper):
    checked = 0
    for f, d in maps(stepper, 21):
        # Far less than the distance of the breakpoint, which the label confirms.
        step = 3e-5 / np.maximum(1.0, np.abs(f.derivative(d))).max()
        near = f.evaluate(d + step * NODES[:, None])
        same = np.all(near.label == f.evaluate(d).label, axis=0)
        found = f.derivative(d)[same]
        expected = difference(near.value, step)[same]
        allowed = RELATIVE * np.maximum(1.0, np.abs(expected))
        assert np.all(np.abs(found - expected) <= allowed), (f, d[same], found - expected)
        checked += same.sum()
    assert checked > SYSTEMS[stepper]


@pytest.mark.parametrize("stepper", LAW_OF)
def test_derivatives_in_every_parameter(stepper):
    checked, step = 0, 3e-5
    for f, d in maps(stepper, 22):
        d = 0.9 * d  # the domain itself moves with the parameters
        d = d[f.evaluate(d).status == ss.status.OK]
        here = f.evaluate(d)
        for name, value in f.parameters.items():
            if value - 4 * step < 0.0 or (name == "V" and value < 0.02):
                continue  # no room for a central difference
            near = [f.replace(**{name: value + step * k}).evaluate(d) for k in NODES]
            same = np.all([n.label == here.label for n in near], axis=0) & (here.margin > 0.05)
            expected = difference(np.array([n.value for n in near]), step)[same]
            found = f.parameter_derivative(d, name)[same]
            allowed = RELATIVE * np.maximum(1.0, np.abs(expected))
            assert np.all(np.abs(found - expected) <= allowed), (f, name, d[same], found - expected)
            checked += same.sum()
    assert checked > 2 * SYSTEMS[stepper]


@pytest.mark.parametrize(
    ("model", "d", "itinerary"),
    [
        # slips of both: from rest, after a landing, one forward
        (
            ss.TwoBlock(alpha=2.56, beta=0.55, V=0.28, friction=ss.Coulomb(0.51)),
            0.008,
            ".- -- .- -- .- ..",
        ),
        (
            ss.TwoBlock(alpha=2.6, beta=1.82, V=0.09, friction=ss.Coulomb(0.81)),
            0.161,
            ".- -- -. ..",
        ),
        (
            ss.TwoBlock(alpha=1.78, beta=1.22, V=0.28, friction=ss.Coulomb(0.18)),
            -0.155,
            "-. -- +- +. ..",
        ),
    ],
)
def test_derivatives_through_slips_of_both_blocks(model, d, itinerary):
    f, step = ss.event_map(model), 3e-5
    assert f.itinerary(d) == itinerary
    expected = difference(f(d + step * NODES), step)
    assert f.derivative(d) == pytest.approx(expected, rel=RELATIVE, abs=RELATIVE)
    for name, value in f.parameters.items():
        near = np.array([f.replace(**{name: value + step * k})(d) for k in NODES])
        expected = difference(near, step)
        assert abs(expected) > 0.01, "a wrong one would show"
        assert f.parameter_derivative(d, name) == pytest.approx(expected, rel=RELATIVE)


@pytest.mark.parametrize("friction", ["coulomb", "law9"])
def test_a_pair_of_laws_has_parameters_of_its_own(friction):
    pair = {
        "coulomb": (ss.Coulomb(0.2), ss.Coulomb(0.5)),
        "law9": (ss.PoppStelter(1.0, 0.1, 0.05), ss.PoppStelter(3.0, 0.2, 0.01)),
    }[friction]
    model = ss.TwoBlock(alpha=1.1, beta=1.4, V=0.1, friction=pair)
    f = ss.event_map(model)
    d = regular_points(f, 8, np.random.default_rng(5), margin=0.05)
    here = f.evaluate(d)
    total = {}
    for name in ("mu_1", "mu_2") if friction == "coulomb" else ("gamma_1", "gamma_2", "eta_2"):
        value, step = model.parameters[name], 3e-5
        near = [f.replace(**{name: value + step * k}).evaluate(d) for k in NODES]
        same = np.all([n.label == here.label for n in near], axis=0)
        assert same.sum() > 3
        total[name] = f.parameter_derivative(d, name)
        expected = difference(np.array([n.value for n in near]), step)
        np.testing.assert_allclose(total[name][same], expected[same], rtol=1e-7, atol=1e-7)
    assert any(np.abs(values).max() > 1e-3 for values in total.values())


def test_a_common_parameter_moves_both_blocks():
    one = ss.TwoBlock(alpha=1.1, beta=1.4, V=0.1, friction=ss.Coulomb(0.3))
    two = one.replace(friction=(ss.Coulomb(0.3), ss.Coulomb(0.3)))
    d = np.linspace(-0.6, 0.6, 25)
    f, g = ss.event_map(one), ss.event_map(two)
    both = g.parameter_derivative(d, "mu_1") + g.parameter_derivative(d, "mu_2")
    np.testing.assert_allclose(f.parameter_derivative(d, "mu"), both, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("stepper", ["exact", "taylor"])
def test_the_slope_at_a_breakpoint_is_that_of_one_side(stepper):
    # At the ends of the domain only the inside exists.
    f = ss.event_map(random_model(np.random.default_rng(6), LAW_OF[stepper]))
    for end in f.domain:
        inside = end * (1 - 1e-7)
        assert f.itinerary(inside) == f.itinerary(end)
        assert f.derivative(end) == pytest.approx(f.derivative(inside), abs=1e-4)


@pytest.mark.parametrize("friction", [ss.Coulomb(0.22), ss.Coulomb(0.6), ss.PoppStelter(3.0)])
def test_the_slope_where_both_blocks_leave_together_is_that_of_smaller_d(friction):
    model = ss.TwoBlock(alpha=1.25, beta=1.5, V=0.1, friction=friction)
    f = ss.event_map(model)
    corner = 0.5 / 3.5
    assert f.itinerary(corner).startswith("--")
    assert f.itinerary(corner - 1e-8).startswith("-. --")
    assert f.derivative(corner) == pytest.approx(f.derivative(corner - 1e-8), rel=1e-5)
    for name in f.parameters:
        # in parameters as well: the same side of the tie
        beside = f.parameter_derivative(corner - 1e-8, name)
        assert f.parameter_derivative(corner, name) == pytest.approx(beside, rel=1e-5, abs=1e-6)
