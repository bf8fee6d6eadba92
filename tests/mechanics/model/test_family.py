"""Blocks, Chain, Oscillator: parameters by name, checks, global stick."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss

LAW = ss.Coulomb(mu=0.22)
K = [[2.5, -1.0, -0.3], [-1.0, 3.0, -1.2], [-0.3, -1.2, 2.8]]
CHAIN = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=LAW)
BLOCKS = ss.Blocks(mass=[1, 2, 3], stiffness=K, static=[1, 1.3, 0.9], friction=LAW, V=0.05)
FORCED = ss.Oscillator(
    V=0.0, friction=ss.PoppStelter(gamma=3), forcing=ss.Harmonic(amplitude=0.5, frequency=1.3)
)
STRUCTURE = ss.Structure(
    mass=[1, 2, 3],
    stiffness=[[2.5, -1.0, 0.4], [-1.3, 3.0, -1.2], [-0.3, -1.2, 2.8]],
    damping=np.diag([0.1, 0.2, 0.3]),
    contacts=[
        ss.Contact(at=(0, 2), friction=LAW, V=(0.2, ss.Harmonic(0.1, 1.7)), load=[0.1, 0, 0.2]),
        ss.Contact(at=1, friction=ss.PoppStelter(gamma=3)),
    ],
    force=[0.1, 0.0, 0.2],
    forcing=[ss.Harmonic((0.1, 0.2, 0.3), 1.1), ss.Harmonic(0.2, 0.7, 0.3)],
)


def test_the_papers_model_is_a_chain_of_two() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.05, friction=LAW, damping=0.1)
    for name in ("mass", "stiffness", "damping", "static"):
        one, other = (getattr(m.plant, name) for m in (model, model.chain))
        np.testing.assert_allclose(one, other, rtol=1e-15)


@pytest.mark.parametrize(("ends", "row"), [("free", 2.2), ("fixed", 3.4), ("periodic", 3.4)])
def test_ends_of_a_chain(ends: str, row: float) -> None:
    chain = ss.Chain(static=[1] * 4, alpha=1.2, V=0.05, friction=LAW, ends=ends)  # type: ignore[arg-type]
    stiffness = chain.plant.stiffness
    assert stiffness[0, 0] == pytest.approx(row)
    assert stiffness[0, 3] == pytest.approx(-1.2 if ends == "periodic" else 0.0)
    np.testing.assert_array_equal(stiffness, stiffness.T)


@pytest.mark.parametrize("model", [CHAIN, BLOCKS, FORCED, STRUCTURE])
def test_every_parameter_can_be_replaced_by_its_name(model: ss.Chain) -> None:
    for name, value in model.parameters.items():
        changed = model.replace(**{name: value + 0.01})
        assert changed.parameters[name] == pytest.approx(value + 0.01)
        others = {k: v for k, v in changed.parameters.items() if k != name}
        assert others == {k: v for k, v in model.parameters.items() if k != name}
        assert changed != model
        assert changed.replace(**{name: value}) == model
    assert hash(model.replace()) == hash(model)


@pytest.mark.parametrize("model", [CHAIN, BLOCKS, FORCED, STRUCTURE])
def test_the_plant_is_differentiated_exactly_in_each_number(model: ss.Chain) -> None:
    step = 1e-3
    for name in (*model.numbers, *(n for n in model.parameters if "." in n)):
        here = model.replace(**{name: model.parameters[name] + 0.05})  # away from the ranges' ends
        direction = here.plant_direction(name)
        values = [
            here.replace(**{name: here.parameters[name] + k * step}).plant.reduced
            for k in (-2, -1, 1, 2)
        ]
        for field in direction._fields:
            far_low, low, high, far_high = (getattr(value, field) for value in values)
            expected = (8 * (high - low) - (far_high - far_low)) / (12 * step)
            np.testing.assert_allclose(getattr(direction, field), expected, rtol=0, atol=1e-9)


def test_a_pair_of_laws_has_numbered_parameters() -> None:
    model = CHAIN.replace(friction=[LAW, ss.PoppStelter(gamma=3), LAW])
    assert model.parameters["mu_1"] == 0.22
    assert model.parameters["gamma_2"] == 3
    assert model.replace(mu_3=0.3).laws[2] == ss.Coulomb(mu=0.3)


def test_a_number_of_one_of_several_laws_is_refused_by_its_name() -> None:
    laws = ss.Coulomb(mu=0.2), ss.friction_law("a + b*exp(-s)", parameters={"a": 0.5, "b": 0.5})
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.05, friction=laws)
    with pytest.raises(ValueError, match=r"^mu_1: mu = 7 of the friction law coulomb is not"):
        model.replace(mu_1=7)
    with pytest.raises(ValueError, match=r"^a_2, b_2: F\(0\) = 1.2 of the friction law"):
        model.replace(a_2=0.6, b_2=0.6)
    with pytest.raises(ValueError, match=r"^mu = 7 of the friction law coulomb"):
        model.replace(friction=laws[0]).replace(mu=7)


def test_samples_are_legal() -> None:
    rng = np.random.default_rng(1)
    for model in (CHAIN, BLOCKS, ss.TwoBlock(alpha=1.2, beta=1.3, V=0.05, friction=LAW)):
        assert model.contains(model.sample_domain(200, rng)).all()
        x, v = model.sample_state(rng, riding=True)
        force = model.plant.needed_force(x, v)
        assert (np.abs(force) < model.plant.static).all()
        assert (v == model.V).all()


def test_the_domain_of_two_blocks_is_that_of_the_paper() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.05, friction=LAW)
    _, end = model.domain
    chain = model.chain
    np.testing.assert_allclose(chain.domain, model.domain, rtol=1e-15)
    assert chain.contains(np.array([[0.1], [end * 1.001]])).tolist() == [[True], [False]]
    np.testing.assert_allclose(chain.admit([end, end * (1 + 4e-16)]), end, rtol=1e-15)
    with pytest.raises(ValueError, match="outside the global stick locus"):
        chain.admit([np.nan])
    with pytest.raises(ValueError, match="belongs to no global stick phase"):
        CHAIN.admit([np.nan, 0.1])
    with pytest.raises(ValueError, match="the domain of 3 blocks is no interval"):
        _ = CHAIN.domain


def test_positions_have_the_given_differences() -> None:
    np.testing.assert_allclose(np.diff(CHAIN.positions([0.1, -0.3])), [0.1, -0.3], rtol=1e-14)
    with pytest.raises(ValueError, match="2 numbers are needed, the differences"):
        CHAIN.positions([0.1])


@pytest.mark.parametrize("d", [0.1, [0.1]])
def test_one_block_has_no_differences(d: object) -> None:
    model = ss.Oscillator(V=0.2, friction=LAW)
    with pytest.raises(ValueError, match=r"no neighbour .* x and v"):
        ss.simulate(model, d=d, t_end=1)
    assert ss.simulate(model, d=[], t_end=1).status == 0


BAD = {
    "shape": (dict(stiffness=[[1.0]]), r"stiffness has the shape \(1, 1\)"),
    "asymmetric": (
        dict(stiffness=np.eye(3) + np.eye(3, k=1)),
        r"stiffness\[0, 1\] = 1\.0 but stiffness\[1, 0\] = 0\.0: the matrix must be symmetric",
    ),
    "indefinite": (dict(stiffness=np.diag([1.0, 1.0, -1.0])), "positive definite"),
    "singular": (dict(stiffness=np.diag([1.0, 1.0, 0.0])), "positive definite"),
    "nan": (dict(stiffness=np.diag([1.0, 1.0, np.nan])), "not a finite number"),
    "text": (dict(stiffness="soft"), "not made of real numbers"),
    "damper": (dict(damping=-np.eye(3)), "positive semidefinite"),
    "mass": (dict(mass=[1, -1, 1]), r"mass\[1\] = -1"),
    "masses": (dict(mass=[1, 1]), "stiffness has the shape"),
    "limit": (dict(static=[1, 0, 1]), r"static\[1\] = 0"),
    "limits": (dict(static=[1, 1]), "for 3 blocks"),
    "laws": (dict(friction=[LAW]), "1 laws for 3 blocks"),
    "law": (dict(friction=0.22), "neither a friction law"),
    "velocity": (dict(V=-0.1), "mirror image"),
    "rest": (dict(V=0), "forced models only"),
    "forcing": (dict(forcing=0.5), "must be a Harmonic"),
    "amplitudes": (dict(forcing=ss.Harmonic([0.5, 0.1], 1.0)), "2 entries for 3 blocks"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_told(case: str) -> None:
    changes, message = BAD[case]
    good = dict(mass=[1, 1, 1], stiffness=K, static=[1, 1.3, 0.9], friction=LAW, V=0.05)
    with pytest.raises(ValueError, match=message):
        ss.Blocks(**{**good, **changes})


def test_bad_chains_are_told() -> None:
    with pytest.raises(ValueError, match="list with the static limit"):
        ss.Chain(static=1.0, alpha=1.2, V=0.05, friction=LAW)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="'periodic'"):
        ss.Chain(static=[1, 1], alpha=1.2, V=0.05, friction=LAW, ends="periodical")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="static_2"):
        CHAIN.replace(sttic_2=1.0)
    with pytest.raises(ValueError, match="amplitude"):
        ss.Harmonic(amplitude=np.inf, frequency=1.0)
    for amplitude in ([[1.0, 2.0], [3.0, 4.0]], [1.0, np.nan], []):
        with pytest.raises(ValueError, match=r"amplitude = .*one finite number per coordinate"):
            ss.Harmonic(amplitude, frequency=1.0)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="frequency"):
        ss.Harmonic(amplitude=1.0, frequency=0.0)


def test_physical_damping_goes_both_ways() -> None:
    numbers = dict(m=2.0, k=50.0, k12=60.0, fs1=10.0, fs2=13.0, v_dr=0.1, c=0.4)
    model = ss.TwoBlock.from_physical(**numbers, friction=LAW)
    assert model.damping == pytest.approx(0.4 / np.sqrt(2.0 * 50.0))
    assert model.physical_parameters() == pytest.approx(numbers)


def test_matrices_are_given_whole_or_by_their_diagonals():
    contacts = [ss.Contact(at=0, friction=LAW)]
    given = ss.Structure([1, 2], [3, 4], [0.1, 0.2], contacts=contacts)
    whole = ss.Structure(np.diag([1, 2]), np.diag([3, 4]), np.diag([0.1, 0.2]), contacts=contacts)
    np.testing.assert_array_equal(given.stiffness, whole.stiffness)
    np.testing.assert_array_equal(given.damping, whole.damping)
    with pytest.raises(ValueError, match=r"stiffness has the shape \(3,\): \(2, 2\) is needed"):
        ss.Structure([1, 2], [3, 4, 5], contacts=contacts)


def test_a_structure_takes_other_laws_of_friction() -> None:
    law, other = ss.Stribeck(mu=0.9, speed=0.1), ss.Coulomb(mu=0.5)
    assert STRUCTURE.replace(friction=law).friction == (law, law)
    found = STRUCTURE.replace(friction=(law, other), V_1=0.3)
    assert found.friction == (law, other)
    assert found.contacts[0].load == STRUCTURE.contacts[0].load
    with pytest.raises(ValueError, match=r"friction\[2\]|2 laws|friction"):
        STRUCTURE.replace(friction=(law,) * 3)
