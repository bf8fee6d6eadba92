"""Branches proven over intervals of a parameter, and confirmed by the second program."""

import functools
import json
from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from flint import arb, arb_series, ctx
from tests.sizes import slow

import stickslip as ss
from stickslip.proofs.certify import certify_branch
from stickslip.proofs.verify.branch import in_tube
from stickslip.proofs.verify.check import check, check_text
from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import Refused, read

RANGE = (0.0366, 0.0372)
FIXED_POINTS = {"S1": -0.0399143, "U1": 0.0886133, "U2": 0.3716257}
V_STAR = Fraction("0.0369759235203076003816096018771")
RANDOM = (("alpha", 0.001), ("beta", 0.0005), ("V", 0.0001), ("mu", 0.0002))  # half of a range


def model(**changes):
    return ss.examples.coulomb(**changes)


def distance(document, value, points):
    """How far the nearest of an orbit's points is from the tube's line, in radii."""
    nodes = np.array([[float(x) for x in node] for node in document["nodes"]])
    k = min(max(np.searchsorted(nodes[:, 0], value) - 1, 0), len(nodes) - 2)
    line = np.interp(value, nodes[:, 0], nodes[:, 1])
    return min(abs(points - line)) / float(document["radii"][k])


def restated(document):
    """The document with the statement that its entries make, as a forger writes it."""
    return {**document, "statement": read(document).statement()}


@pytest.mark.parametrize("name", FIXED_POINTS)
def test_the_fixed_points_exist_all_over_figure_4(name):
    proof = certify_branch(model(), FIXED_POINTS[name], 1, "V", RANGE, digits=12)
    assert proof.proven
    assert proof.document["stable"] is name.startswith("S")
    assert [proof.document["nodes"][k][0] for k in (0, -1)] == ["0.0366", "0.0372"]
    assert check_text(proof.text()).statement() == proof.statement
    for value in np.random.default_rng(1).uniform(*RANGE, 10):
        orbits = ss.periodic_orbits(model(V=value))
        assert min(distance(proof.document, value, orbit.points) for orbit in orbits) < 1


def test_a_curve_is_certified_up_to_where_its_orbit_is_lost():
    (orbit,) = [o for o in ss.periodic_orbits(model(V=0.03697), 4) if o.period == 4]
    curve = ss.follow(orbit, "V", (0.03697, 0.0371))
    assert curve.end_reasons == ("end of range", "breakpoint")
    proof = ss.certify(curve, model(), digits=8)
    assert proof.proven
    assert "is lost at a jump of the event map, at V = 0.0369759235 +/- 5e-11" in proof.statement
    assert "block 2 grazes" in proof.document["lost"][0]["mechanism"]
    end = Fraction(proof.document["nodes"][-1][0])
    assert 0 < V_STAR - end < Fraction(1, 10**12)
    # The second program takes a third of a second for each piece: the last ones.
    document = json.loads(proof.text())
    last = {"nodes": document["nodes"][-6:], "radii": document["radii"][-5:]}
    assert "block 2 grazes" in check(restated(document | last)).remark


@pytest.mark.slow
def test_s4_from_0_0366_to_the_grazing_to_30_digits():
    proof = certify_branch(model(), 0.2774, 4, "V", RANGE)
    assert proof.document["lost"][0]["value"].startswith("0.0369759235203076003816096018771 ")
    assert check_text(proof.text()).statement() == proof.statement


def test_downwards_and_upwards():
    proof = certify_branch(model(V=0.0369), -0.0397, 1, "V", RANGE, digits=6)
    assert check_text(proof.text())
    assert len(proof.document["nodes"]) > 8


@pytest.mark.parametrize("seed", [*range(4), *slow(4, 5)])
def test_branches_of_random_systems_are_confirmed(seed):
    rng = np.random.default_rng(seed)
    system = ss.TwoBlock(
        alpha=round(rng.uniform(0.3, 2), 3),
        beta=round(rng.uniform(0.6, 1.8), 3),
        V=round(rng.uniform(0.02, 0.2), 3),
        friction=ss.Coulomb(mu=round(rng.uniform(0.1, 0.7), 3)),
    )
    name, width = RANDOM[seed % len(RANDOM)]
    own = system.parameters[name]
    orbits = ss.periodic_orbits(system)
    if not len(orbits):
        return
    orbit = orbits[0]
    proof = certify_branch(
        system, orbit.points[0], 1, name, (round(own - width, 6), round(own + width, 6)), digits=6
    )
    if not proof:
        assert "the branch is proven no further" in proof.statement
        return
    assert check_text(proof.text()).statement() == proof.statement
    ends = [float(node[0]) for node in (proof.document["nodes"][0], proof.document["nodes"][-1])]
    for value in rng.uniform(*ends, 5):
        orbits = ss.periodic_orbits(system.replace(**{name: value}))
        assert min(distance(proof.document, value, orbit.points) for orbit in orbits) < 1 + 1e-6


def test_where_the_orbit_loses_its_stability_nothing_is_proven():
    # S1 flips at alpha = 1.1370 and is stable above it.
    proof = certify_branch(model(alpha=1.14), -0.0558, 1, "alpha", (1.135, 1.145), digits=6)
    assert not proof
    assert "the branch is proven no further than 1.137" in proof.statement


@pytest.mark.parametrize(
    ("prove", "message"),
    [
        (lambda: certify_branch(model(), 0.1, 1, "V", (0.037, 0.038)), "the model's own value"),
        (lambda: certify_branch(model(), 0.1, 1, "gamma", RANGE), "gamma"),
        (lambda: certify_branch(model(), 0.1, 1, "mu", (0, 0.3)), "mu = 0"),
        (lambda: certify_branch(ss.examples.law9(), 0.38, 1, "V", (0.29, 0.3)), "Coulomb friction"),
        (
            lambda: ss.certify(
                ss.follow(ss.breakpoints(model())[0], "V", (0.0366, 0.0367)), model()
            ),
            "only one of periodic orbits",
        ),
    ],
)
def test_bad_arguments_are_errors(prove, message):
    with pytest.raises(ValueError, match=message):
        prove()


def test_no_orbit_near_is_an_answer():
    proof = certify_branch(model(), 0.3, 1, "V", RANGE, digits=6)
    assert not proof
    assert proof.enclosures == {}


@pytest.mark.parametrize("name", ["alpha", "beta", "V", "mu"])
def test_the_verifier_knows_derivatives_in_parameters(name):
    values = {"alpha": "1.2", "beta": "1.3", "V": "0.0366", "mu_1": "0.22", "mu_2": "0.22"}
    names = [each for each in values if each.partition("_")[0] == name]
    own = arb(float(values[names[0]]))
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = 128, 2
    try:
        rest = {k: v for k, v in values.items() if k not in names}
        motion = Motion(rest, **dict.fromkeys(names, arb_series([own, 1])))
        _, value = motion.series(arb_series([arb(0.27)]))
    finally:
        ctx.prec, ctx.cap = before
    expected = ss.event_map(model()).parameter_derivative(0.27, name)
    assert float(value[1]) == pytest.approx(expected, rel=1e-10)


def test_a_tube_holds_what_is_within_its_radius():
    proof = certify_branch(model(), FIXED_POINTS["S1"], 1, "V", RANGE, digits=6)
    theorem = read(proof.document).theorem
    low, high = (arb(proof.document["nodes"][k][1]) for k in (0, 1))
    value = (arb(proof.document["nodes"][0][0]) + arb(proof.document["nodes"][1][0])) / 2
    radius = float(proof.document["radii"][0])
    for share, inside in ((0.9, True), (1.1, False)):
        assert in_tube(theorem, value, (low + high) / 2 + share * radius) is inside
    assert not in_tube(theorem, arb("0.04"), low)


@functools.cache
def beside_a_graze():
    """The stable orbit of period 55 that passes a graze at two of its points, as a document."""
    proof = certify_branch(model(V=0.0372), 0.27954114, 55, "V", ("0.037199", "0.0372"), digits=6)
    return proof.text()


def test_an_orbit_that_passes_a_graze_is_proven_in_few_pieces():
    document = json.loads(beside_a_graze())
    assert document["stable"]
    assert len(document["nodes"]) < 12
    assert check(document).statement() == document["statement"]
    f = ss.event_map(model(V=0.0371995))
    orbit = f.iterate(0.2795, 2000)[-55:]
    assert distance(document, 0.0371995, orbit) < 1


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"stable": False}, "stable is stated as False"),
        ({"radii": "1e-03"}, "cannot be told|itinerary|tube"),
        pytest.param({"radii": "1e-12"}, "not shown to be in the tube", marks=pytest.mark.slow),
        pytest.param(
            {"shift": Fraction(1, 10**5)}, "in the tube|itinerary", marks=pytest.mark.slow
        ),
    ],
)
def test_forgeries_beside_a_graze_are_refused(change, reason):
    document = json.loads(beside_a_graze())
    first = document["nodes"][:2]
    document["nodes"], document["radii"] = first, document["radii"][:1]
    if "shift" in change:
        document["nodes"] = [[p, str(float(Fraction(d) + change["shift"]))] for p, d in first]
    elif "radii" in change:
        document["radii"] = [change["radii"]]
    else:
        document |= change
    with pytest.raises(Refused, match=reason):
        check(restated(document))


@pytest.mark.slow
def test_it_is_lost_where_it_grazes():
    near = 0.2794
    points = ss.event_map(model(V=0.03715)).iterate(near, 4000)[-55:]
    near = np.sort(points[abs(points - 0.2796) < 1e-3])[-2]
    proof = certify_branch(model(V=0.03715), near, 55, "V", ("0.0371", "0.03716"), digits=8)
    (border,) = proof.document["lost"]
    assert border["exists"] == "above"
    assert border["value"].startswith("0.037146837")
    assert check_text(proof.text()).statement() == proof.statement
