"""The limit of a belt that hardly moves: closed forms, the moving belt's limit, sizes of slips."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import stickslip as ss

COULOMB = ss.examples.coulomb()
SPEEDS = 4e-5 * np.array([1.0, 0.75, 0.5, 0.25])
AWAY = 1e-3  # from a breakpoint, where the limit is not uniform


def limit_of_moving_belt(model: ss.TwoBlock, d: np.ndarray) -> np.ndarray:
    """Values of event maps at small speeds, extrapolated to V = 0 by the cubic through them."""
    rows = np.array([ss.event_map(model.replace(V=float(V)))(d) for V in SPEEDS])
    weights = [np.prod([V / (V - U) for V in np.delete(SPEEDS, k)]) for k, U in enumerate(SPEEDS)]
    return np.array(weights) @ rows


def far_from_breakpoints(f: ss.EventMap, d: np.ndarray) -> np.ndarray:
    found = np.array([item.d for item in ss.breakpoints(f)])
    if not found.size:
        return d
    return d[np.abs(d[:, None] - found).min(axis=1) > AWAY]


def test_it_is_the_limit_of_the_papers_coulomb_map() -> None:
    f = ss.quasistatic_map(COULOMB)
    d = far_from_breakpoints(f, np.linspace(*f.domain, 203))
    assert d.size > 150
    np.testing.assert_allclose(f(d), limit_of_moving_belt(COULOMB, d), atol=1e-10, rtol=0)


def test_the_belts_speed_does_not_matter() -> None:
    d = np.linspace(*COULOMB.domain, 41)
    one, other = (ss.quasistatic_map(COULOMB.replace(V=V)) for V in (0.01, 3.0))
    np.testing.assert_array_equal(one(d), other(d))
    assert "V" not in one.parameters
    assert one != ss.event_map(one.model)


@settings(max_examples=30)
@given(
    alpha=st.floats(0.0, 3.0),
    beta=st.floats(0.5, 2.0),
    mu=st.floats(0.05, 0.9),
    share=st.floats(-0.999, 0.999),
)
def test_a_block_that_slips_alone_goes_through_half_a_period(
    alpha: float, beta: float, mu: float, share: float
) -> None:
    """From its limit L about the force mu L and as far beyond: 2 L (1 - mu) / (1 + alpha)."""
    f = ss.quasistatic_map(ss.TwoBlock(alpha, beta, 1.0, ss.Coulomb(mu)))
    d = share * f.domain[1]
    words = f.itinerary(d)
    sizes = f.slips(d)
    if words in ("-. ..", ".- .."):
        block = words.index("-")
        length = 2.0 * (1.0, beta)[block] * (1.0 - mu) / (1.0 + alpha)
        assert sizes.displacement[block] == pytest.approx(length, abs=1e-13)
        assert sizes.displacement[1 - block] == pytest.approx(0.0, abs=1e-13)
        assert f(d) == pytest.approx(d + (length, -length)[block], abs=1e-13)
    assert sizes.value == pytest.approx(f(d), abs=1e-12)
    assert sizes.moment == pytest.approx(sizes.displacement.sum(), abs=1e-13)
    assert sizes.wait >= 0.0


@settings(max_examples=50)
@given(
    alpha=st.floats(0.0, 3.0),
    beta=st.floats(0.5, 2.0),
    mu=st.tuples(st.floats(0.1, 0.9), st.floats(0.1, 0.9)),
    share=st.floats(-0.999, 0.999),
)
def test_friction_is_only_a_scale(
    alpha: float, beta: float, mu: tuple[float, float], share: float
) -> None:
    """Of u = (d - d_0) / (1 - mu), d_0 where both leave together, while no block slips forward."""
    one, other = (ss.quasistatic_map(ss.TwoBlock(alpha, beta, 1.0, ss.Coulomb(m))) for m in mu)
    middle = (beta - 1.0) / (1.0 + 2.0 * alpha)
    d = share * one.domain[1]
    twin = middle + (d - middle) * (1.0 - mu[1]) / (1.0 - mu[0])
    assume(abs(twin) < one.domain[1])
    step, same = one.evaluate(d), other.evaluate(twin)
    assume(min(step.margin, same.margin) > 1e-6)
    assume("+" not in one.itinerary(d) + other.itinerary(twin))
    assert one.itinerary(d) == other.itinerary(twin)
    scaled = [(f.value - middle) / (1.0 - m) for f, m in zip((step, same), mu, strict=True)]
    rounding = 1e-13 * max(1.0, abs(step.derivative)) / (1.0 - max(mu))
    assert scaled[0] == pytest.approx(scaled[1], abs=rounding)
    assert step.derivative == pytest.approx(same.derivative, rel=1e-9)


@settings(max_examples=20)
@given(mu=st.floats(0.05, 0.9), share=st.floats(-0.999, 0.999))
def test_friction_takes_the_energy_that_the_springs_give(mu: float, share: float) -> None:
    """As no block ever slips forward here, the work of friction is mu times the path."""
    model = COULOMB.replace(mu=mu)
    f = ss.quasistatic_map(model)
    d = share * f.domain[1]
    sizes = f.slips(d)
    if "+" in f.itinerary(d):
        return
    stiffness = np.array([[2.2, -1.2], [-1.2, 2.2]])
    before = np.array(model.onset(d))
    after = before - sizes.displacement
    energy = [0.5 * x @ stiffness @ x for x in (before, after)]
    work = mu * (np.array([1.0, 1.3]) @ sizes.displacement)
    assert energy[0] - energy[1] == pytest.approx(work, abs=1e-12)


def test_where_both_leave_together_the_slope_is_infinite() -> None:
    f = ss.quasistatic_map(COULOMB)
    d = (1.3 - 1.0) / 3.4
    slope = f.derivative(d)
    assert np.isinf(slope)
    near, nearer = ((f(d) - f(d - h)) / h for h in (1e-8, 1e-10))
    assert nearer / near == pytest.approx(10.0, rel=0.01)
    assert np.sign(nearer) == np.sign(slope)


def separations(alpha: float, beta: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """How far starts 1e-9 apart come in 300 slips, after 20 000, and whether they repeat."""
    f = ss.quasistatic_map(ss.TwoBlock(alpha, beta, 1.0, ss.Coulomb(0.8)), threads=1)
    starts = np.random.default_rng(seed).uniform(*f.domain, 8)
    d = f.iterate(starts, 20_000)[:, -1]
    orbits, neighbours = f.iterate(d, 300), f.iterate(d + 1e-9, 300)
    repeats = (np.abs(orbits[:, -25:-1] - orbits[:, -1:]) < 1e-9).any(axis=1)
    return np.abs(orbits - neighbours).max(axis=1), repeats


@pytest.mark.parametrize("alpha", np.random.default_rng(1).uniform(0.05, 4.0, 6))
def test_symmetric_pairs_move_periodically(alpha: float) -> None:
    """A neutral family or an attractor, whatever the coupling: neighbours stay neighbours."""
    apart, repeats = separations(alpha, 1.0, 2)
    assert repeats.all()
    assert apart.max() < 1e-8


@pytest.mark.parametrize(
    ("alpha", "beta", "chaotic"),
    [(3.05, 1.3, {True}), (1.55, 1.3, {False}), (1.05, 1.7, {True, False})],
)
def test_asymmetric_pairs_are_chaotic_or_periodic_or_the_start_decides(
    alpha: float, beta: float, chaotic: set[bool]
) -> None:
    apart, repeats = separations(alpha, beta, 2)
    assert set((apart > 0.01).tolist()) == chaotic
    np.testing.assert_array_equal(repeats, apart < 1e-8)


def test_the_analysis_takes_it_and_files_keep_it(tmp_path) -> None:
    f = ss.quasistatic_map(COULOMB)
    assert len(ss.branches(f)) > 3
    found = ss.periodic_orbits(f, 2)
    for orbit in found:
        np.testing.assert_allclose(f(orbit.points), np.roll(orbit.points, -1), rtol=0, atol=1e-10)
    branch = ss.follow(found[0], "mu", (0.2, 0.24))
    path = tmp_path / "branch.json"
    branch.save(path)
    read = ss.load(path)
    np.testing.assert_array_equal(read.points, branch.points)


@pytest.mark.parametrize(
    ("model", "reason"),
    [
        (ss.examples.law9(), r"F\(0\) = 1"),
        (COULOMB.replace(mu=1.0), r"F\(0\) = 1"),
        (COULOMB.replace(damping=0.1), "damping = 0.1"),
        (ss.Oscillator(V=0.1, friction=ss.Coulomb(0.3)), "TwoBlock"),
    ],
)
def test_what_has_no_such_limit_is_refused_with_the_reason(model, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        ss.quasistatic_map(model)


def test_the_speed_is_no_parameter() -> None:
    f = ss.quasistatic_map(COULOMB)
    with pytest.raises(ValueError, match="V -> 0"):
        f.replace(V=0.1)
    with pytest.raises(ValueError, match="'V'"):
        f.parameter_derivative(0.1, "V")


@pytest.mark.slow
def test_a_law_of_speed_has_the_limit_too() -> None:
    model = COULOMB.replace(friction=ss.Stribeck(mu=0.3, speed=0.5))
    with pytest.raises(ValueError, match=r"F\(0\)"):
        ss.quasistatic_map(model)
    law = ss.friction_law(lambda s, a: 0.8 / (1 + a * s), parameters={"a": 1.5})
    model = model.replace(friction=law)
    f = ss.quasistatic_map(model)
    d = far_from_breakpoints(f, np.linspace(*f.domain, 41))
    np.testing.assert_allclose(f(d), limit_of_moving_belt(model, d), atol=1e-9, rtol=0)


def test_breakpoints_say_what_happens() -> None:
    """A release beside the other block's landing; a tie at the onset where both limits meet."""
    model = ss.TwoBlock(alpha=0.3, beta=2.2, V=0.1, friction=ss.Coulomb(mu=0.1))
    found = ss.breakpoints(ss.quasistatic_map(model))
    assert all(item.mechanism for item in found)
    (tie,) = [item for item in found if "together at the onset" in item.mechanism]
    assert tie.d == pytest.approx((model.beta - 1) / (1 + 2 * model.alpha), abs=1e-12)
    first = ss.breakpoints(ss.quasistatic_map(COULOMB))[0]
    # Alone, block 1 slips by 2 (1 - mu) / (1 + alpha) and so loads block 2 just to its limit.
    assert first.mechanism == "the coming to rest of block 1 and the release of block 2 coincide"
    ends = [item for item in found if item.block is not None]
    assert ends
    assert all(f"block {item.block}" in item.mechanism for item in ends)
