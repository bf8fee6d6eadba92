"""Law (9) proven: Taylor steps with enclosed tails, germs, and what stands on them."""

from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from flint import arb, arb_poly, ctx
from hypothesis import given
from hypothesis import strategies as st
from tests.reference.law9 import Smooth
from tests.reference.laws import PoppStelter
from tests.reference.values import LAW9, LAW9_ORBITS

import stickslip as ss
from stickslip.proofs.certify import certify_bifurcation, certify_orbit
from stickslip.proofs.germ import Germ, germ
from stickslip.proofs.jet import precision, variables
from stickslip.proofs.power import Setting, step
from stickslip.proofs.system import System, exact_parameters
from stickslip.proofs.taylor import Expansion, Falling, TaylorStep, Unbounded
from stickslip.proofs.verify.check import check_text
from stickslip.proofs.verify.words import Refused

BINARY = {name: Fraction(value) for name, value in LAW9.items()}
FLIP = {"alpha": 1.20985979564076}
DEGREE = 6


def middle(text):
    return Fraction(text.split(" +/- ")[0])


def balls(x):
    """Every enclosure that a number consists of."""
    if isinstance(x, Germ):
        return [ball for c in x.coefficients for ball in balls(c)]
    return [x.centre, x.range, *x.gradient]


def flip(**changes):
    asked = {"kind": "flip", "d": 0.382742448843, "period": 1, "parameter": "alpha"}
    return certify_bifurcation(ss.examples.law9(**FLIP), **(asked | changes))


@given(st.lists(st.floats(-1, 1), min_size=2, max_size=20), st.floats(-0.9, 0.9))
def test_the_algebra_encloses_what_it_leaves_out(terms, x):
    whole = arb_poly([arb(2), *map(arb, terms)])  # |x| <= 1
    u = Expansion(arb_poly(whole.coeffs()[: DEGREE + 1]), arb(0), DEGREE)
    u = Expansion(u.head, sum((abs(c) for c in whole.coeffs()[DEGREE + 1 :]), arb(0)), DEGREE)
    value = whole(arb(x))
    cases = [(u * u, value**2), (u.integral(arb(1)), whole.integral()(arb(x)))]
    try:
        cases.append((1 / u, 1 / value))
    except Unbounded:
        assert sum(map(abs, terms)) > 0.5
    for found, expected in cases:
        assert (found.head(arb(x)) + arb(0, found.tail)).overlaps(expected)


def test_a_reciprocal_without_a_bound_is_refused():
    with pytest.raises(Unbounded):
        1 / Expansion(arb_poly([1, 2]), arb(0), DEGREE)  # a zero inside the disc
    assert ctx.cap >= DEGREE


def test_germs_are_derivatives():
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    with precision(128):
        setting = Setting(exact_parameters(model))
        (x,) = variables([arb(0.27)], [arb(0)])
        (piece,) = step(setting, germ(x, 3))
    _, slope, bend, third = (float(c.range) for c in piece.value.coefficients)
    h = 1e-4
    before, here, after = f.derivative(np.array([0.27 - h, 0.27, 0.27 + h]))
    assert slope == pytest.approx(here, rel=1e-12)
    assert 2 * bend == pytest.approx((after - before) / (2 * h), rel=1e-6)
    assert 6 * third == pytest.approx((after - 2 * here + before) / h**2, rel=1e-4)


@pytest.mark.parametrize("modes", [(-1, 0), (1, -1), (-1, -1)])
@pytest.mark.parametrize("order", [0, 1, 3])
def test_a_taylor_step_solves_the_equations(modes, order):
    with precision(200):
        d, alpha = variables([arb("0.2"), arb("1.2")], [arb(0), arb(0)])
        d, alpha = (germ(d, order), germ(alpha, order)) if order else (d, alpha)
        laws = (Falling(arb(3), arb(0), arb(0)), Falling(arb(2), arb("0.1"), arb("0.3")))
        system = System(alpha, arb("1.3"), arb("0.1"), laws)
        w = tuple((d * d + arb("0.1")) * arb(mode) for mode in modes)
        motion = TaylorStep(system, modes, w, (d, d * 2), None)
        t = motion.reach / 2
        for i, mode in enumerate(modes):
            needed, rate = motion.e[i](t), motion.w[i].derivative()(t)
            slip = motion.w[i](t) * arb(mode)
            forces = -(laws[i].force(slip) * system.limits[i] * arb(mode)) - needed
            load = motion.w[i](t) * (alpha + 1) - motion.w[1 - i](t) * alpha + system.V
            pairs = [(motion.e[i].derivative()(t), load), *([(rate, forces)] if mode else [])]
            for found, expected in pairs:
                assert all(x.rad() < 1e-30 for x in balls(found))
                assert all(
                    a.overlaps(b) for a, b in zip(balls(found), balls(expected), strict=True)
                )


def test_a_germ_over_a_number_is_exact():
    third, *_ = (germ(arb(1), 2) / 3).coefficients
    assert (third * 3).overlaps(arb(1))


@pytest.mark.parametrize("d", ["0.1", "-0.4"])
def test_an_enclosure_holds_the_oracles_value(d):
    found = ss.enclose(ss.examples.law9(), Fraction(float(d)), exact=BINARY)
    law = PoppStelter(LAW9["gamma"], 0.0, 0.0)
    oracle = Smooth(LAW9["alpha"], LAW9["beta"], LAW9["V"], law).motion(float(d))
    assert found.proven
    assert found.itinerary == oracle.itinerary
    assert found.value[0] <= float(oracle.value) <= found.value[1]
    assert found.value[1] - found.value[0] < 1e-15
    assert found.derivative == pytest.approx(
        (ss.event_map(ss.examples.law9()).derivative(float(d)),) * 2, rel=1e-10
    )


def test_p1_is_proven():
    proof = certify_orbit(ss.examples.law9(), 0.3832953740383583, digits=8, exact=BINARY)
    point, multiplier = LAW9_ORBITS["P1"]
    assert proof.proven
    assert "friction law (9)" in proof.statement
    assert proof.document["stable"] is True
    assert abs(middle(proof.document["points"][0]) - Fraction(point)) < Fraction(1, 10**8)
    assert abs(middle(proof.document["multiplier"]) - Fraction(multiplier)) < Fraction(1, 10**7)


def test_a_wide_interval_is_refused_with_the_reason():
    found = ss.enclose(ss.examples.law9(), ("0.38", "0.39"))
    assert not found.proven
    assert "too wide" in found.reason


@pytest.mark.slow
def test_a_wrong_orbit_is_refused():
    assert not certify_orbit(ss.examples.law9(), 0.38330, digits=10)


@pytest.mark.slow
def test_p1_is_confirmed_and_no_changed_digit():
    text = certify_orbit(ss.examples.law9(), 0.3832953740383583, digits=12).text()
    assert check_text(text)
    with pytest.raises(Refused, match="multiplier"):
        check_text(text.replace("-0.936895739733", "-0.936895739732"))


def assert_the_oracle_agrees(document, multiplier):
    """The point returns to 29 digits, with a multiplier that differences show to 13."""
    alpha, point = (arb(x.split(" +/- ")[0]) for x in (document["value"], *document["points"]))
    law = PoppStelter(arb(3), arb(0), arb(0))
    system = Smooth(alpha, arb("1.301"), arb("0.295"), law)
    h = arb("1e-10")
    before, here, after = (system.motion(d).value for d in (point - h, point, point + h))
    assert abs(here - point) < 1e-29
    assert abs((after - before) / (2 * h) - multiplier) < 1e-13


@pytest.mark.slow
def test_the_flip_of_p1():
    proof = flip()
    assert proof.proven
    assert_the_oracle_agrees(proof.document, -1)
    assert float(middle(proof.document["cubic"])) == pytest.approx(-6607.54194974, abs=1e-8)
    assert (proof.document["stable"], proof.document["doubled"]) == ("below", "below")
    assert "subcritical" in proof.statement
    assert check_text(flip(digits=8).text())


@pytest.mark.slow
def test_the_fold_of_s1_and_u1():
    model = ss.examples.law9(alpha=1.2151058900461)
    proof = certify_bifurcation(model, "fold", 0.38033784252577, 1, "alpha")
    assert proof.proven
    assert_the_oracle_agrees(proof.document, 1)
    assert proof.document["exists"] == "above"
    short = certify_bifurcation(model, "fold", 0.38033784252577, 1, "alpha", digits=8)
    assert check_text(short.text())


@pytest.mark.parametrize(
    ("parameter", "value", "d", "exists"),
    [("V", 0.1199887, 0.08787, "below"), ("alpha", 0.2697239, 0.28676, "above")],
)
def test_folds_in_the_coulomb_system(parameter, value, d, exists):
    model = ss.examples.coulomb(**{parameter: value})
    proof = certify_bifurcation(model, "fold", d, 1, parameter)
    assert proof.document["exists"] == exists
    text = proof.text()
    assert check_text(text).statement() == proof.statement
    # Two orbits on the one side, none of that itinerary on the other.
    place, point = (
        float(middle(proof.document["value"])),
        float(middle(proof.document["points"][0])),
    )
    numbers = []
    for p in (place * (1 - 1e-4), place * (1 + 1e-4)):
        f = ss.event_map(ss.examples.coulomb(**{parameter: p}))
        numbers.append(sum(abs(x.points[0] - point) < 0.1 for x in ss.periodic_orbits(f, 1)))
    assert numbers[0 if exists == "below" else 1] == 2 + numbers[1 if exists == "below" else 0]
    other = "above" if exists == "below" else "below"
    with pytest.raises(Refused, match="side of the fold"):
        check_text(text.replace(f'"{exists}"', f'"{other}"'))
    for entry, digit in (("value", 20), ("curvature", 20)):
        stated = proof.document[entry]
        wrong = stated[:digit] + str((int(stated[digit]) + 5) % 10) + stated[digit + 1 :]
        with pytest.raises(Refused):
            check_text(text.replace(stated, wrong))


def test_the_flip_of_s1_in_the_coulomb_system():
    model = ss.examples.coulomb(alpha=1.1370148264946178)
    proof = certify_bifurcation(model, "flip", -0.05618813, 1, "alpha")
    assert proof.proven
    assert (proof.document["stable"], proof.document["doubled"]) == ("above", "below")
    assert "supercritical" in proof.statement
    text = proof.text()
    assert check_text(text).statement() == proof.statement
    # A stable orbit of period 2 below, the stable fixed point above.
    below, above = (ss.examples.coulomb(alpha=1.1370148264946178 + h) for h in (-1e-3, 1e-3))
    assert certify_orbit(above, ss.event_map(above).iterate(-0.056, 4000)[-1], digits=12)
    doubled = certify_orbit(below, ss.event_map(below).iterate(-0.056, 4000)[-1], 2, digits=12)
    assert doubled.document["stable"] is True
    with pytest.raises(Refused, match="does not pass -1"):
        check_text(text.replace("1.13701482649461", "1.13701482649471"))
    with pytest.raises(Refused, match="cubic"):
        check_text(text.replace("117.38294972", "117.38294982"))


@pytest.mark.parametrize("kind", ["flip", "fold"])
def test_what_is_no_bifurcation_is_refused(kind):
    proof = certify_bifurcation(ss.examples.coulomb(), kind, -0.03991431341, 1, "alpha", digits=8)
    assert not proof
    assert "Nothing is proven" in proof.statement


def test_another_kind_is_an_error():
    with pytest.raises(ValueError, match="kind = 'crisis'"):
        flip(kind="crisis")
