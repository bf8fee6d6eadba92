"""Bifurcations of maps of R^n in the plane of two parameters, where curves are known."""

from dataclasses import replace

import numpy as np
import pytest
from tests.analysis.known_maps_nd import SmoothMap, henon, kinked

import stickslip as ss
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import OrbitSurvey
from stickslip.analysis.orbits.orbits_nd import distinct_orbits
from stickslip.analysis.work import Work
from stickslip.following import follow
from stickslip.results.files import load, save

EXACT = 1e-11


def first(f, name, ends, kind, max_period=1):
    survey = OrbitSurvey(f, name, *ends, max_period, 64)
    survey.run(4, Work())
    return next(item for item in survey.events if item.kind == kind)


def delayed(a=2.5, e=0.1):
    """x' = a x (1 - (1 - e) y - e x), y' = x: at x = y = 1 - 1/a trace 1 - e (a - 1).

    The determinant is (1 - e)(a - 1): Neimark-Sacker at a = 1 + 1/(1 - e), flip at
    a = 1 + 2/(2 e - 1); both end at e = 3/4, a = 5 in a double multiplier -1.
    """

    def stacked(*entries):
        return np.stack(np.broadcast_arrays(*entries), axis=-1)

    def jacobian(z, a, e):
        x, y = z[..., 0], z[..., 1]
        rows = stacked(a * (1 - (1 - e) * y - 2 * e * x), -a * (1 - e) * x), stacked(1 + 0 * x, 0)
        return np.stack(rows, axis=-2)

    def func(z, a, e):
        x, y = z[..., 0], z[..., 1]
        return stacked(a * x * (1 - (1 - e) * y - e * x), x)

    def by_e(z, a, e):
        return stacked(a * z[..., 0] * (z[..., 1] - z[..., 0]), 0)

    rates = {"a": lambda z, a, e: stacked(func(z, 1.0, e)[..., 0], 0), "e": by_e}
    box = ((0.05, 1.5), (0.05, 1.5))
    return SmoothMap(func, jacobian, rates, box, (("a", a), ("e", e)))


def cubic(q=0.3, s=1.0, gain=1.0):
    """x' = K q + (1 + s) x - x^3, y' = y / 2 + x: folds at 3 x^2 = s, K q = -2 x^3; a cusp at 0."""

    def jacobian(z, q, s):
        one = np.ones(z.shape[:-1])
        rows = [[1 + s - 3 * z[..., 0] ** 2, 0 * one], [one, 0.5 * one]]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    def func(z, q, s):
        x = z[..., 0]
        return np.stack([gain * q + (1 + s) * x - x**3, 0.5 * z[..., 1] + x], axis=-1)

    none = lambda x: 0 * x  # noqa: E731
    rates = {
        "q": lambda z, q, s: np.stack([gain + none(z[..., 0]), none(z[..., 0])], axis=-1),
        "s": lambda z, q, s: np.stack([z[..., 0], none(z[..., 0])], axis=-1),
    }
    return SmoothMap(func, jacobian, rates, ((-2.0, 2.0), (-4.0, 4.0)), (("q", q), ("s", s)))


# ------------------------------------------------------------------ closed forms


@pytest.mark.parametrize(("kind", "share"), [("fold", -0.25), ("flip", 0.75)], ids=["fold", "flip"])
def test_folds_and_flips_of_the_henon_map(kind, share, tmp_path):
    """a = -(1 - b)^2 / 4, and 3 (1 - b)^2 / 4."""
    curve = follow(first(henon(0.1), "a", (-0.2, 1.0), kind), "b", (-0.9, 0.5), solve_for="a")
    assert curve.kind == f"bifurcation: {kind}"
    assert curve.end_reasons == ("end of range", "end of range")
    b = curve.parameters["b"]
    np.testing.assert_allclose(curve.parameters["a"], share * (1 - b) ** 2, rtol=0, atol=EXACT)
    assert curve.bifurcations == ()
    assert curve.at(b=0.123).value == pytest.approx(share * 0.877**2, abs=EXACT)
    assert curve.at(a=4 * share * 0.09).value == pytest.approx(0.4, abs=EXACT)
    save(curve, tmp_path / "curve")
    again = load(tmp_path / "curve", system=henon())
    assert again[3].value == pytest.approx(curve.parameters["a"][3], abs=EXACT)


def test_the_flip_of_an_orbit_of_period_two():
    """a = (1 - b)^2 + (1 + b)^2 / 4."""
    item = first(henon(0.1), "a", (0.4, 1.0), "flip", 2)
    assert item.period == 2
    curve = follow(item, "b", (0.0, 0.5), solve_for="a")
    b = curve.parameters["b"]
    expected = (1 - b) ** 2 + (1 + b) ** 2 / 4
    np.testing.assert_allclose(curve.parameters["a"], expected, rtol=0, atol=EXACT)


def test_a_neimark_sacker_curve_passes_its_resonances_and_ends_in_the_one_of_order_two():
    item = first(delayed(e=0.1), "a", (1.5, 2.5), "neimark_sacker")
    curve = follow(item, "e", (-1.0, 0.9), solve_for="a")
    e = curve.parameters["e"][:-1]
    np.testing.assert_allclose(curve.parameters["a"][:-1], 1 + 1 / (1 - e), rtol=1e-11)
    np.testing.assert_allclose(
        np.cos(curve.data["angle"][:-1]), 0.5 - 0.5 * e / (1 - e), rtol=0, atol=1e-10
    )
    found = {event.kind: event for event in curve.bifurcations}
    known = {"resonance 1:4": 1 / 2, "resonance 1:3": 2 / 3, "resonance 1:2": 3 / 4}
    assert set(found) == set(known)
    for kind, value in known.items():
        # A double multiplier -1 is a root of second order: half of the digits.
        assert found[kind].value == pytest.approx(value, abs=1e-8 if value == 0.75 else EXACT)
    assert curve.end_reasons == ("end of range", "resonance 1:2")


def test_the_flip_curve_meets_it_there():
    """a = 1 + 2 / (2 e - 1)."""
    item = first(delayed(e=0.9), "a", (3.0, 4.5), "flip")
    curve = follow(item, "e", (0.7, 0.95), solve_for="a")
    e = curve.parameters["e"]
    np.testing.assert_allclose(curve.parameters["a"], 1 + 2 / (2 * e - 1), rtol=1e-11)
    (event,) = curve.bifurcations
    assert event.kind == "resonance 1:2"
    assert event.value == pytest.approx(0.75, abs=EXACT)


def test_a_fold_turns_round_in_a_cusp():
    curve = follow(first(cubic(), "q", (-0.1, 0.9), "fold"), "s", (-0.5, 1.5), solve_for="q")
    x, q, s = curve.points[:, 0, 0], *(curve.parameters[name] for name in "qs")
    np.testing.assert_allclose(s, 3 * x**2, rtol=0, atol=EXACT)
    np.testing.assert_allclose(q, -2 * x**3, rtol=0, atol=EXACT)
    (cusp,) = curve.bifurcations
    assert cusp.kind == "cusp"
    assert abs(cusp.value) < 1e-12
    assert curve.end_reasons == ("end of range", "end of range")
    assert len(curve.all_at(s=1.0)) == 2


# ------------------------------------------------------------------ borders


def lozi(a=2.1, b=0.3):
    """x' = 1 - a |x| + y, y' = b x; an orbit of period 3 through x = 0 has
    a^2 - (1 + b) a - (1 + b + b^2) = 0: compose the three affine pieces."""

    def func(z, a, b):
        return np.stack([1 - a * np.abs(z[..., 0]) + z[..., 1], b * z[..., 0]], axis=-1)

    def jacobian(z, a, b):
        one = np.ones(z.shape[:-1])
        rows = [[-a * np.sign(z[..., 0]), one], [b * one, 0 * one]]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    rates = {
        "a": lambda z, a, b: np.stack([-np.abs(z[..., 0]), 0 * z[..., 0]], axis=-1),
        "b": lambda z, a, b: np.stack([0 * z[..., 0], z[..., 0]], axis=-1),
    }
    box = ((-3.0, 3.0), (-3.0, 3.0))
    values = (("a", a), ("b", b))
    return SmoothMap(
        func, jacobian, rates, box, values, label=lambda z, a, b: 1 + (z[..., 0] >= 0.0)
    )


def test_an_interval_contains_the_value_where_the_parameter_acts_weakly():
    f = cubic(q=0.3e6, gain=1e-6)
    curve = follow(first(f, "q", (-4e5, 4e5), "fold"), "s", (0.5, 1.2), solve_for="q")
    for s in (0.6, 0.77, 1.1):
        item = curve.at(s=s)
        low, high = item.interval
        exact = np.sign(item.value) * 2e6 * (s / 3) ** 1.5
        assert low <= exact <= high
        assert high - low < 1e-7


def test_a_border_collision_of_an_orbit_of_period_three(tmp_path):
    item = first(lozi(), "a", (1.9, 2.2), "border_collision", 3)
    assert item.period == 3
    curve = follow(item, "b", (-0.4, 0.6), solve_for="a")
    assert curve.kind == "bifurcation: border_collision"
    assert curve.end_reasons == ("end of range", "end of range")
    b, a = curve.parameters["b"], curve.parameters["a"]
    expected = 0.5 * (1 + b + np.sqrt((1 + b) ** 2 + 4 * (1 + b + b**2)))
    np.testing.assert_allclose(a, expected, rtol=0, atol=EXACT)
    save(curve, tmp_path / "curve")
    again = load(tmp_path / "curve", system=lozi())
    value = again.at(b=0.1).value
    assert value == pytest.approx(0.5 * (1.1 + np.sqrt(1.21 + 4.44)), abs=EXACT)


def test_two_sides_of_a_jump_are_two_borders():
    """The fixed point of the left piece is at 0 where mu = 0; that of the right, mu = -jump."""
    survey = OrbitSurvey(kinked(-0.1, 0.2), "mu", -0.3, 0.3, 1, 64)
    survey.run(4, Work())
    curves = [follow(item, "jump", (-0.3, 0.3), solve_for="mu") for item in survey.events]
    for curve, slope in zip(curves, (-1.0, 0.0), strict=True):
        expected = slope * curve.parameters["jump"]
        np.testing.assert_allclose(curve.parameters["mu"], expected, rtol=0, atol=EXACT)


@pytest.mark.slow
def test_a_fold_of_a_chain_of_three_blocks_is_where_its_orbits_turn_back():
    chain = ss.Chain(static=(0.968, 0.986, 0.732), alpha=0.383, V=0.1, friction=ss.Coulomb(mu=0.7))
    survey = OrbitSurvey(ss.event_map(chain, threads=1), "V", 0.15, 0.2, 1, 12)
    survey.run(1, Work())
    fold = max((item for item in survey.events if item.kind == "fold"), key=lambda i: i.value)
    curve = follow(fold, "alpha", (0.378, 0.388), solve_for="V")
    assert curve.end_reasons == ("end of range", "end of range")
    f = curve.system.replace(alpha=0.385, V=curve.at(alpha=0.385).value - 1e-4)
    orbit = distinct_orbits(f, fold.orbits_before[0].points[None])[0]
    turns = [e for e in follow(orbit, "V", (0.18, 0.19)).bifurcations if e.kind == "fold"]
    assert turns[0].value == pytest.approx(curve.at(alpha=0.385).value, abs=EXACT)


@pytest.mark.slow
def test_a_grazing_of_a_chain_of_three_blocks_is_followed():
    """Where the curve leads a list of its own finds the same grazing."""
    chain = ss.Chain(
        static=(0.753, 1.374, 1.078), alpha=1.616, V=0.13, friction=ss.Coulomb(mu=0.59)
    )

    def grazing(alpha, lo, hi):
        survey = OrbitSurvey(ss.event_map(chain.replace(alpha=alpha)), "V", lo, hi, 1, 32)
        survey.run(1, Work())
        return next(item for item in survey.events if "block 2 grazes" in item.mechanism)

    curve = follow(grazing(1.616, 0.129, 0.1305), "alpha", (1.615, 1.617), solve_for="V")
    assert curve.end_reasons == ("end of range", "end of range")
    V = curve.at(alpha=1.617).value
    assert grazing(1.617, V - 5e-4, V + 5e-4).value == pytest.approx(V, abs=EXACT)


# ------------------------------------------------------------------ refusals


def test_what_is_not_followed_is_told():
    corner = first(kinked(-0.1), "mu", (-0.3, 0.3), "border_collision")
    with pytest.raises(ValueError, match="'attractor_change' of a map of R"):
        follow(replace(corner, kind="attractor_change"), "jump", (-0.1, 0.1), solve_for="mu")
    fold = first(henon(0.1), "a", (-0.2, 0.1), "fold")
    with pytest.raises(ValueError, match="two different"):
        follow(fold, "a", (-0.9, 0.5), solve_for="a")
    with pytest.raises(ValueError, match="does not contain"):
        follow(fold, "b", (0.5, 0.6), solve_for="a")
