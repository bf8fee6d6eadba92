"""The event map of n blocks: against the two-block engines, 30 digits, and differences."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from tests.reference import blocks as reference
from tests.sizes import slow

import stickslip as ss
from stickslip import status
from stickslip.mechanics.flow.blocks.system import GROUP

K = [[2.5, -1.0, -0.3], [-1.0, 3.0, -1.2], [-0.3, -1.2, 2.8]]
C = [[0.25, -0.1, 0.0], [-0.1, 0.3, -0.1], [0.0, -0.1, 0.28]]
LAWS = {
    "coulomb": (ss.Coulomb(mu=0.22), lambda s: mpmath.mpf(0.22), 0.05),
    "law9": (
        ss.PoppStelter(gamma=3, delta=0.25, eta=0.125),  # exact in binary
        lambda s: mpmath.mpf(0.75) / (1 + 3 * s) + 0.25 + 0.125 * s**2,
        0.1,
    ),
}


def three_blocks(name: str) -> ss.Blocks:
    law, _, V = LAWS[name]
    return ss.Blocks(
        mass=[1, 1.5, 0.8], stiffness=K, damping=C, static=[1, 1.3, 0.9], friction=law, V=V
    )


def chain(name: str, n: int) -> ss.Chain:
    law, _, V = LAWS[name]
    return ss.Chain(static=[1, 1.3, 1.1, 0.9, 1.2][:n], alpha=1.2, V=V, friction=law)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", LAWS)
def test_two_blocks_agree_with_their_own_engines(name: str, seed: int) -> None:
    """Random systems of the physics contract; the two engines share nothing but the laws."""
    rng = np.random.default_rng(seed)
    law = (
        ss.Coulomb(mu=rng.uniform(0.05, 0.9))
        if name == "coulomb"
        else ss.PoppStelter(rng.uniform(0.3, 4), rng.uniform(0, 0.5), rng.uniform(0, 0.1))
    )
    low, high = (0.005, 0.3) if name == "coulomb" else (0.1, 0.3)
    model = ss.TwoBlock(rng.uniform(0.1, 3), rng.uniform(0.5, 2), rng.uniform(low, high), law)
    d = model.sample_domain(100 if name == "coulomb" else 20, rng)
    one = ss.event_map(model, max_events=1000).evaluate(d)
    many = ss.event_map(model.chain, max_events=1000).evaluate(d)
    settled = (one.margin > 1e-9) & (many.margin > 1e-9)
    both = settled & (one.status == status.OK)
    np.testing.assert_array_equal(one.status[settled], many.status[settled])
    size = np.maximum(1.0, np.abs(one.derivative[both]))
    assert both.sum() > 5
    assert (np.abs(one.value - many.value)[both] / size).max() < 1e-13
    assert (np.abs(one.derivative - many.derivative)[both] / size).max() < 1e-10
    np.testing.assert_array_equal(one.n_events[both], many.n_events[both])
    # Two events of one block in turn make no margin smaller; how fast a rider comes to its limit
    # may, here by V or more.
    assert (many.margin >= np.minimum(one.margin, model.V) - 1e-8)[both].all()


def short_motions(model: ss.Blocks | ss.Chain, count: int) -> np.ndarray:
    """Starting points of short motions of a few events, far from any other itinerary."""
    d = model.sample_domain(200, 7)
    found = ss.event_map(model, max_events=50).evaluate(d)
    clear = (found.status == status.OK) & (found.margin > 1e-2) & (found.n_events > 2)
    order = np.argsort(found.duration[clear], kind="stable")
    return d[clear][order[:count]]


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("kind", ["full", *slow("chain of 3", "chain of 5")])
def test_values_in_30_digits(name: str, kind: str) -> None:
    model = three_blocks(name) if kind == "full" else chain(name, int(kind[-1]))
    s, (_, law, _) = model.plant, LAWS[name]
    f = ss.event_map(model)
    for d in short_motions(model, 1):
        exact = reference.event_map(s.mass, s.stiffness, s.damping, s.static, model.V, law, d)
        np.testing.assert_allclose(f(d), exact, rtol=0, atol=2e-15)


@pytest.mark.parametrize("name", LAWS)
def test_derivatives_agree_with_differences(name: str) -> None:
    model = three_blocks(name)
    f = ss.event_map(model)
    (d,) = short_motions(model, 1)
    h = 1e-5
    steps = h * np.eye(2)
    ahead, behind = f(d + steps), f(d - steps)
    wide = (f(d + 2 * steps) - f(d - 2 * steps)) / (4 * h)
    quotient = (4 * (ahead - behind) / (2 * h) - wide) / 3
    np.testing.assert_allclose(f.derivative(d), quotient.T, rtol=1e-8, atol=1e-9)
    for parameter, value in model.parameters.items():
        values = [
            ss.event_map(model.replace(**{parameter: value + k * h}))(d) for k in (-2, -1, 1, 2)
        ]
        quotient = (8 * (values[2] - values[1]) - (values[3] - values[0])) / (12 * h)
        np.testing.assert_allclose(
            f.parameter_derivative(d, parameter), quotient, rtol=1e-8, atol=1e-9
        )


@pytest.mark.parametrize("name", LAWS)
def test_tangents_that_fill_more_than_one_group_agree_with_differences(name: str) -> None:
    law, _, V = LAWS[name]
    static = [1, 1.3, 1.1, 0.9, 1.2, 1.05, 0.95]
    f = ss.event_map(ss.Chain(static=static, alpha=1.2, V=V, friction=law))
    assert f.dimension > GROUP
    assert f.dimension % GROUP
    (d,) = short_motions(f.model, 1)
    steps = 1e-5 * np.eye(f.dimension)
    wide = (f(d + 2 * steps) - f(d - 2 * steps)) / 4e-5
    quotient = (4 * (f(d + steps) - f(d - steps)) / 2e-5 - wide) / 3
    np.testing.assert_allclose(f.derivative(d), quotient.T, rtol=1e-8, atol=1e-9)


def test_shapes_labels_and_itineraries() -> None:
    model = chain("coulomb", 3)
    f = ss.event_map(model)
    d = model.sample_domain(6, 1).reshape(2, 3, 2)
    found = f.evaluate(d)
    assert found.value.shape == (2, 3, 2)
    assert found.derivative.shape == f.derivative(d).shape == (2, 3, 2, 2)
    assert found.label.shape == found.status.shape == (2, 3)
    np.testing.assert_array_equal(f(d), found.value)
    texts = f.itinerary(d)
    assert texts.shape == (2, 3)
    for i in np.ndindex(2, 3):
        assert texts[i].endswith(" ...")
        assert len(texts[i].split()) == found.n_events[i] + 1
        same = found.label == found.label[i]
        np.testing.assert_array_equal(same, texts == texts[i])
    assert len(repr(found).splitlines()) == 8
    assert f"{found.value[0, 0, 1]:.8g}" in repr(found)
    orbit = f.iterate(d[0, 0], 5)
    np.testing.assert_array_equal(orbit[1:], [f(x) for x in orbit[:-1]])


def test_one_block_and_forced_models_have_no_event_map() -> None:
    law = ss.Coulomb(mu=0.22)
    with pytest.raises(ValueError, match="two blocks"):
        ss.event_map(ss.Oscillator(V=0.1, friction=law))
    with pytest.raises(ValueError, match="stroboscopic_map"):
        ss.event_map(chain("coulomb", 3).replace(forcing=ss.Harmonic(0.1, 1.0)))
    with pytest.raises(ValueError, match="engine = 'exact'"):
        ss.event_map(chain("coulomb", 3), engine="exact")


@pytest.mark.parametrize("damping", [0.05, 2.0, 5.0])
def test_two_damped_blocks_are_a_map_of_the_line(damping: float) -> None:
    """Below, at and above critical damping of a block alone."""
    model = ss.TwoBlock(1.2, 1.3, 0.05, ss.PoppStelter(gamma=3), damping=damping)
    f, g = ss.event_map(model), ss.event_map(model.chain)
    d = model.sample_domain(30, 3)
    np.testing.assert_array_equal(f(d), g(d))
    np.testing.assert_array_equal(f.derivative(d), g.derivative(d))
    np.testing.assert_array_equal(f.iterate(d, 2), g.iterate(d, 2))
    beta = g.parameter_derivative(d, "static_2")
    np.testing.assert_array_equal(f.parameter_derivative(d, "beta"), beta)
    assert f.itinerary(d[0]) == g.itinerary(d[0])
    assert f.replace(damping=0.0) == ss.event_map(model.replace(damping=0.0))
    for name in ("support", []):
        with pytest.raises(ValueError, match="is not a parameter of the model"):
            f.parameter_derivative(0.1, name)


def test_damping_that_outweighs_a_falling_law_ends_in_sliding() -> None:
    """F falls at every speed here, so that damping alone makes the energy decrease."""
    falling = ss.PoppStelter(gamma=3)
    chain = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=falling, damping=5.0)
    found = ss.event_map(chain).evaluate(chain.sample_domain(10, 1))
    assert (found.status == status.NEVER_SLIPPING).all()
    assert found.duration.max() < 100
    assert (ss.equilibria(chain)[0].eigenvalues.real < 0).all()


def test_light_damping_hardly_changes_the_map() -> None:
    model = ss.TwoBlock(1.2, 1.3, 0.0366, ss.Coulomb(mu=0.22))
    d = np.array([-0.2, 0.1, 0.4])
    slopes = ss.event_map(model.replace(damping=1e-9)).parameter_derivative(d, "damping")
    change = ss.event_map(model.replace(damping=1e-6))(d) - ss.event_map(model)(d)
    np.testing.assert_allclose(change, 1e-6 * slopes, rtol=1e-4)


def test_values_do_not_depend_on_what_was_computed_before() -> None:
    """With dampers a rider's loading must not see accelerations of an earlier motion."""
    rng = np.random.default_rng(0)
    for _ in range(24):
        model = ss.Chain(
            static=rng.uniform(0.8, 1.4, 4),
            alpha=rng.uniform(0.3, 2),
            V=0.2,
            friction=ss.Coulomb(mu=0.3),
            damping=0.3,
        )
        d = model.sample_domain(10, rng)
        together = ss.event_map(model, threads=1, max_events=300)(d)
        alone = [ss.event_map(model, threads=1, max_events=300)(row) for row in d]
        np.testing.assert_array_equal(together, alone)
