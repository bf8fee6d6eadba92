"""The event map of two blocks that are not equal: against 96 digits, differences and symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from tests.mechanics.eventmap.unequal import LAWS, oracle, pair, random_models
from tests.reference.settle import GAVE_UP, RIGHT, settle

import stickslip as ss
from stickslip import status
from stickslip.status import NAMES

TOLERANCE = 1e-13  # of a value, per unit of what the motion stretches
LIMITS = {"max_events": 200}
LONGEST = 400.0  # duration of a motion that the oracle is asked for
COULOMB = ss.Coulomb(mu=0.22)
LAW9 = ss.PoppStelter(gamma=3.0)
FORWARD = ((0, 1, 2, 3, 4), (-25, 48, -36, 16, -3))
PAIRS = {
    "coulomb": pair(COULOMB, 0.0366),
    "coulomb, damped": pair(COULOMB, 0.0366, damped=True),
    "law9": pair(LAW9, 0.1),
    "law9, damped": pair(LAW9, 0.1, damped=True),
}


def verdicts(model: ss.Blocks, d: np.ndarray) -> list[str]:
    """What the oracle says of the map's values; of motions that do not return, nothing."""
    found = ss.event_map(model, threads=1, **LIMITS).evaluate(d)
    judge, said = oracle(model), []
    for k in np.flatnonzero((found.status == status.OK) & (found.duration < LONGEST)):
        verdict = settle(
            judge, float(d[k]), float(found.value[k]), NAMES[found.status[k]], TOLERANCE,
            float(found.duration[k]), **LIMITS, max_time=LONGEST,
        )  # fmt: skip
        assert verdict.verdict != "wrong", f"{model}\n{verdict}"
        said.append(verdict.verdict)
    return said


@pytest.mark.parametrize(
    ("kind", "n"),
    [
        ("coulomb", 120),
        ("law9", 12),
        pytest.param("coulomb", 10_000, marks=pytest.mark.slow),
        pytest.param("law9", 500, marks=pytest.mark.slow),
    ],
)
def test_no_value_of_random_blocks_is_wrong(kind: str, n: int) -> None:
    rng = np.random.default_rng(n)
    said = [
        word
        for model in random_models(kind, n, rng)
        for word in verdicts(model, model.sample_domain(1, rng))
    ]
    assert said.count(RIGHT) > 0.7 * n
    assert said.count(GAVE_UP) < 0.02 * n + 1


@pytest.mark.parametrize("name", PAIRS)
def test_no_value_next_to_a_breakpoint_is_wrong(name: str) -> None:
    """Grazing, ties and landings at a limit, from both sides, down to the last digits."""
    model = PAIRS[name]
    breakpoints = ss.breakpoints(model)
    causes = " ".join(item.mechanism for item in breakpoints)
    assert "grazes its stick interval" in causes
    assert "coincide" in causes
    reach = np.array([1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15])
    for item in breakpoints[:1] if name.startswith("law9") else breakpoints:
        d = np.concatenate([item.d - reach, [item.d], item.d + reach])
        assert verdicts(model, d).count(RIGHT) >= 12


@pytest.mark.parametrize("name", PAIRS)
def test_slopes_agree_with_differences(name: str) -> None:
    model, h = PAIRS[name], 1e-5
    f = ss.event_map(model)
    d = model.sample_domain(200, 3)
    found = f.evaluate(d)
    d = d[(found.margin > 1e-2) & (np.abs(found.derivative) < 20) & (found.n_events > 2)][:4]
    assert len(d) == 4
    quotient = (8 * (f(d + h) - f(d - h)) - (f(d + 2 * h) - f(d - 2 * h))) / (12 * h)
    np.testing.assert_allclose(f.derivative(d), quotient, rtol=1e-8, atol=1e-9)
    assert isinstance(f.derivative(d[0]), float)
    for parameter, value in model.parameters.items():
        # Numbers that are 0 may only grow.
        nodes, weights = ((-2, -1, 1, 2), (1, -8, 8, -1)) if value else FORWARD
        steps = [f.replace(**{parameter: value + k * h})(d) for k in nodes]
        quotient = np.tensordot(weights, steps, 1) / (12 * h)
        slopes = f.parameter_derivative(d, parameter)
        np.testing.assert_allclose(slopes, quotient, rtol=1e-7, atol=1e-8, err_msg=parameter)


def mirrored(model: ss.Blocks, scale: float) -> ss.Blocks:
    """Blocks in the other order, displacements and speeds over `scale`, times as they are."""
    s, swap = model.plant, np.ix_([1, 0], [1, 0])
    laws = []
    for law in model.laws[::-1]:
        if isinstance(law, ss.PoppStelter):  # the same force at a speed over the scale
            law = ss.PoppStelter(law.gamma * scale, law.delta, law.eta * scale**2)
        laws.append(law)
    return ss.Blocks(
        mass=s.mass[::-1],
        stiffness=s.stiffness[swap],
        damping=s.damping[swap],
        static=s.static[::-1] / scale,
        friction=laws,
        V=model.V / scale,
    )


@pytest.mark.parametrize("kind", LAWS)
def test_the_mirror_image_is_the_map_of_the_blocks_in_the_other_order(kind: str) -> None:
    """f(d; system) = -scale f(-d / scale; renumbered system)."""
    rng = np.random.default_rng(5)
    compared = 0
    for model in random_models(kind, 8, rng):
        scale = rng.uniform(0.5, 2.0)
        image = mirrored(model, scale)
        np.testing.assert_allclose(-scale * np.array(image.domain)[::-1], model.domain, rtol=1e-13)
        d = model.sample_domain(12, rng)
        one = ss.event_map(model, **LIMITS).evaluate(d)
        g = ss.event_map(image, **LIMITS)
        other = g.evaluate(-d / scale)
        clear = (one.margin > 1e-6) & (other.margin > 1e-6)
        ok = clear & (one.status == status.OK)
        np.testing.assert_array_equal(one.status[clear], other.status[clear])
        kappa = np.maximum(1.0, np.abs(one.derivative[ok]))
        assert (np.abs(one.value + scale * other.value)[ok] < 1e-12 * kappa).all()
        assert (np.abs(one.derivative - other.derivative)[ok] < 1e-9 * kappa**2).all()
        np.testing.assert_array_equal(one.n_events[ok], other.n_events[ok])
        compared += ok.sum()
    assert compared > 50


@pytest.mark.parametrize("kind", LAWS)
def test_a_belt_that_runs_the_other_way_mirrors_the_map(kind: str) -> None:
    """f(d; -V) = -f(-d; V): displacements change sign."""
    rng = np.random.default_rng(6)
    for model in random_models(kind, 4, rng):
        f, g = (ss.event_map(on_contacts(model, V), **LIMITS) for V in (model.V, -model.V))
        d = model.sample_domain(12, rng)
        one, other = f.evaluate(d), g.evaluate(-d)
        clear = one.margin > 1e-6
        np.testing.assert_array_equal(one.n_events[clear], other.n_events[clear])
        ok = clear & (one.status == status.OK)
        kappa = np.maximum(1.0, np.abs(one.derivative[ok]))
        assert (np.abs(one.value + other.value)[ok] < 1e-12 * kappa).all()
        assert (np.abs(one.derivative - other.derivative)[ok] < 1e-9 * kappa**2).all()
        name = "stiffness_1_2"
        slopes = f.parameter_derivative(d[ok], name), -g.parameter_derivative(-d[ok], name)
        np.testing.assert_allclose(*slopes, rtol=1e-8, atol=1e-8)


def on_contacts(model: ss.Blocks, V: float) -> ss.Structure:
    """The same blocks on a belt with any velocity."""
    s = model.plant
    contacts = [
        ss.Contact(at=i, static=float(s.static[i]), friction=law, V=V)
        for i, law in enumerate(model.laws)
    ]
    return ss.Structure(s.mass, s.stiffness, s.damping, contacts=contacts)


@pytest.mark.parametrize("kind", LAWS)
def test_equal_blocks_have_the_map_of_two_equal_blocks(kind: str) -> None:
    """Other engines; with f_s1 = k = m = 2 all motions are the same."""
    rng = np.random.default_rng(11)
    for _ in range(3):
        law = (
            ss.Coulomb(mu=rng.uniform(0.1, 0.6))
            if kind == "coulomb"
            else ss.PoppStelter(rng.uniform(1.0, 4.0), rng.uniform(0.0, 0.3))
        )
        alpha, beta, V = rng.uniform(0.3, 2.0), rng.uniform(0.7, 1.6), rng.uniform(0.05, 0.2)
        two = ss.TwoBlock(alpha, beta, V, law)
        model = ss.Blocks([2, 2], 2 * two.plant.stiffness, static=[2, 2 * beta],
                          friction=law, V=V)  # fmt: skip
        f, g = ss.event_map(two, max_events=300), ss.event_map(model, max_events=300)
        np.testing.assert_allclose(g.domain, f.domain, rtol=1e-14)
        one, other = ss.breakpoints(f), ss.breakpoints(g)
        assert [b.kind for b in one] == [b.kind for b in other]
        assert [b.block for b in one] == [b.block for b in other]
        np.testing.assert_allclose([b.d for b in one], [b.d for b in other], rtol=1e-7, atol=1e-12)
        for side in ("left", "right"):
            values = [[getattr(b, side) for b in each] for each in (one, other)]
            np.testing.assert_allclose(*values, rtol=1e-7, atol=1e-9)
        orbits, others = ss.periodic_orbits(f, 2), ss.periodic_orbits(g, 2)
        assert [o.itinerary for o in orbits] == [o.itinerary for o in others]
        for a, b in zip(orbits, others, strict=True):
            np.testing.assert_allclose(a.points, b.points, rtol=1e-7, atol=1e-11)
            np.testing.assert_allclose(a.multiplier, b.multiplier, rtol=1e-6)


def test_loading_that_unloads_a_block_starts_slips_the_other_way() -> None:
    """A row of the stiffness with a negative sum: the belt takes block 1 to its lower limit."""
    model = ss.Blocks(
        [1, 1.5], [[1.0, -1.4], [-1.4, 3.0]], static=[1, 1.2], friction=COULOMB, V=0.1
    )
    f = ss.event_map(model)
    d = model.sample_domain(40, 1)
    assert {text[0] for text in f.itinerary(d)} >= {"+", "."}
    assert len(verdicts(model, d)) > 30
    assert not model.monotone_loading


@pytest.mark.parametrize("mu", [(0.3, 0.2), (0.4, 0.4)])
def test_constant_forces_shift_the_locus_and_the_map(mu: tuple[float, float]) -> None:
    rng = np.random.default_rng(8)
    model = ss.Structure(
        mass=[1.0, 2.0],
        stiffness=[[2.2, -1.2], [-1.2, 2.7]],
        contacts=[ss.Contact(k, ss.Coulomb(mu[k]), 1.0, V=0.15) for k in range(2)],
        force=rng.uniform(-0.5, 0.5, 2),
    )
    # Forces on blocks at rest at x0 = K^-1 g are none: the same blocks, about x0.
    free = ss.Structure(mass=model.mass, stiffness=model.stiffness, contacts=list(model.contacts))
    x0 = np.linalg.solve(model.stiffness, model.force)
    shift = x0[1] - x0[0]
    np.testing.assert_allclose(model.domain, np.add(free.domain, shift), rtol=1e-14)
    f, g = ss.event_map(model), ss.event_map(free)
    d = np.linspace(*free.domain, 203)[1:-1]
    found, expected = f.evaluate(d + shift), g.evaluate(d)
    clear = expected.margin > 1e-9
    assert clear.mean() > 0.9
    np.testing.assert_array_equal(found.status[clear], expected.status[clear])
    np.testing.assert_allclose(
        found.value[clear], expected.value[clear] + shift, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(
        found.derivative[clear], expected.derivative[clear], rtol=1e-9, atol=1e-9
    )
    stick = ss.simulate(model, d=d[40] + shift, until="stick")
    assert stick.d[-1] == pytest.approx(f(d[40] + shift), abs=1e-12)
