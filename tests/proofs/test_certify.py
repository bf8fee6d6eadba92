"""What is proven about the paper's Coulomb system, against the oracle's 30 digits."""

from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from tests.reference.values import COULOMB, COULOMB_JUMPS, COULOMB_ORBITS

import stickslip as ss
from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.proofs.certify import certify_bifurcation, certify_jump, certify_orbit

BINARY = {name: Fraction(value) for name, value in COULOMB.items()}
PERIODS = {"S1": 1, "U1": 1, "U2": 1, "S4": 4}
ROUNDED = Fraction(2, 10**30)  # of both sides' last digits


def model(V=0.0366):
    return ss.examples.coulomb(V=V)


def parts(text):
    middle, radius = text.split(" +/- ")
    return Fraction(middle), Fraction(radius)


def holds(text, expected, unit=ROUNDED):
    middle, radius = parts(text)
    return abs(middle - Fraction(expected)) <= radius + unit


@pytest.mark.parametrize("name", COULOMB_ORBITS)
def test_orbits_to_30_digits(name):
    point, multiplier = COULOMB_ORBITS[name]
    proof = certify_orbit(model(), float(point), PERIODS[name], exact=BINARY)
    assert proof.proven
    assert holds(proof.enclosures["points[0]"], point)
    assert holds(
        proof.enclosures["multiplier"], multiplier, Fraction(1, 10**16)
    )  # its central difference
    assert proof.document["stable"] is name.startswith("S")
    assert all(len(p.split()[0].lstrip("-0.")) >= 30 for p in proof.document["points"])


@pytest.mark.parametrize("jump", COULOMB_JUMPS, ids=lambda jump: jump[0][:8])
def test_jumps_to_30_digits(jump):
    d, left, right = jump
    proof = certify_jump(model(), float(d), exact=BINARY)
    assert proof.proven
    assert holds(proof.enclosures["d"], d)
    for name, expected in (("left", left), ("right", right)):
        assert holds(proof.enclosures[name], expected, Fraction(1, 10**29))


def test_mechanisms_are_those_of_the_search():
    told = [certify_jump(model(), float(d)).document["mechanism"] for d, _, _ in COULOMB_JUMPS]
    assert [text.split()[2] for text in told] == ["of", "grazes", "comes", "grazes", "comes", "of"]


def test_closed_forms_of_one_sided_values():
    # Block 1 lands at 2 mu - 1 while block 2 stands at its limit, and the other way round.
    first, last = (certify_jump(model(), float(COULOMB_JUMPS[k][0])) for k in (0, -1))
    assert holds(first.enclosures["left"], Fraction(186, 340), 0)
    assert holds(last.enclosures["right"], -Fraction(1728, 3400), 0)


def test_the_grazing_of_s4():
    found = Bifurcation(
        "border_collision", "V", 0.036975923520307, 0.0, 4, np.array([0.2794319401])
    )
    proof = ss.certify(found, model())
    assert proof.proven
    assert holds(proof.enclosures["value"], "0.036975923520307", Fraction(1, 10**15))
    assert proof.document["exists"] == "below"
    assert "block 2 grazes" in proof.document["mechanism"]
    # A little below, the orbit is there; a little above, it would be at 0.279453.
    assert certify_orbit(model(0.03697), 0.27940091088170527, 4).proven
    assert not certify_orbit(model(0.03698), 0.279453, 4).proven


@pytest.mark.parametrize(
    ("V", "period", "d"),
    [
        (0.0370, 83, 0.27946839425114073),
        (0.0371, 63, 0.2796631804623622),
        (0.0372, 55, 0.27982381588921773),
    ],
)
def test_the_motion_past_the_grazing_is_periodic_and_stable(V, period, d):
    proof = certify_orbit(model(V), d, period)
    assert proof.proven
    assert proof.document["stable"]
    assert proof.document["period"] == len(set(proof.document["points"])) == period


def test_the_list_of_fixed_points_is_complete():
    proof = ss.certify_orbits(model(), exact=BINARY)
    assert proof.proven
    assert proof.document["undecided"] == []
    orbits = proof.document["orbits"]
    expected = sorted((COULOMB_ORBITS[n][0] for n in ("S1", "U1", "U2")), key=float)
    assert len(orbits) == len(expected)
    assert all(holds(o["points"][0], e) for o, e in zip(orbits, expected, strict=True))


@pytest.mark.slow
def test_there_is_no_orbit_of_period_2():
    proof = ss.certify_orbits(model(), 2, digits=15)
    assert proof.document["undecided"] == []
    assert [orbit["period"] for orbit in proof.document["orbits"]] == [1, 1, 1]


@pytest.mark.slow
def test_lists_of_random_systems_hold_what_the_search_finds():
    rng = np.random.default_rng(3)
    for _ in range(3):
        system = ss.TwoBlock(
            alpha=round(rng.uniform(0.3, 2), 3),
            beta=round(rng.uniform(0.6, 1.8), 3),
            V=round(rng.uniform(0.02, 0.2), 3),
            friction=ss.Coulomb(mu=round(rng.uniform(0.1, 0.7), 3)),
        )
        proof = ss.certify_orbits(system)
        proven = [float(o["points"][0].split()[0]) for o in proof.document["orbits"]]
        undecided = [tuple(map(float, pair)) for pair in proof.document["undecided"]]
        for orbit in ss.periodic_orbits(system):
            x = float(orbit.points[0])
            near = any(abs(x - y) < 1e-10 for y in proven)
            assert near or any(low <= x <= high for low, high in undecided), (system, x)
        if not undecided:
            assert len(proven) == len(ss.periodic_orbits(system))


def test_found_objects_are_certified():
    f = ss.event_map(model())
    (orbit, *_) = ss.periodic_orbits(f)
    assert ss.certify(orbit, model(), digits=12)
    jump = ss.breakpoints(f).of_kind("jump")[0]
    proof = ss.certify(jump, model(), digits=12)
    assert proof.proven
    assert proof.digits == 12
    smooth = ss.breakpoints(f).of_kind("smooth")[0]
    assert "no jump" in ss.certify(smooth, model()).statement


@pytest.mark.parametrize(
    ("prove", "reason"),
    [
        (lambda: certify_orbit(model(), 0.3), "none within"),
        (lambda: certify_orbit(model(), 0.2774, 3), "none within"),
        (lambda: certify_orbit(model(), -0.0399143134102819, 2), "shorter period"),
        (lambda: certify_orbit(model(), 0.27913539909416657), "block 2 may graze"),
        (lambda: certify_jump(model(), 0.1), "no breakpoint"),
        (lambda: certify_jump(model(), 0.08823529411764706), "no jump"),
        (lambda: certify_bifurcation(model(0.0366), "border_collision", 0.2774, 4, "V"), "Nothing"),
    ],
    ids=["no orbit", "period", "not minimal", "breakpoint", "smooth", "harmless", "no border"],
)
def test_what_is_not_so_is_refused_with_the_reason(prove, reason):
    proof = prove()
    assert not proof
    assert reason in proof.statement
    assert proof.enclosures == {}
    with pytest.raises(ValueError, match="nothing was proven"):
        proof.text()


@pytest.mark.parametrize(
    ("prove", "message"),
    [
        (lambda: ss.certify(3, model()), "give a PeriodicOrbit"),
        (lambda: certify_orbit(model(), 0.1, digits=2), "digits = 2"),
        (lambda: certify_orbit(model(), 0.1, 0), "period = 0"),
        (lambda: certify_bifurcation(model(), "fold", 0.1, 1, "gamma"), "gamma"),
        (lambda: certify_orbit(model(), 0.1, exact={"V": "-1"}), "V = -1"),
    ],
)
def test_bad_arguments_are_errors(prove, message):
    with pytest.raises(ValueError, match=message):
        prove()
