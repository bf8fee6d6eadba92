"""The second program: it confirms what was proven, and no certificate with a digit changed."""

import ast
import inspect
import json
import re

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

import flint

import stickslip as ss
from stickslip.proofs.certify import certify_bifurcation, certify_jump, certify_orbit
from stickslip.proofs.verify import check, falling, formulas, motion, words
from stickslip.proofs.verify.check import check_text
from stickslip.proofs.verify.words import Refused


def model(V=0.0366):
    return ss.examples.coulomb(V=V)


@pytest.fixture(scope="module")
def s4():
    return certify_orbit(model(), 0.27739, 4)


def test_an_orbit_is_confirmed(s4, tmp_path):
    s4.save(tmp_path / "s4.json")
    assert check_text((tmp_path / "s4.json").read_text()).statement() == s4.statement


@pytest.mark.parametrize("d", [-0.1979783505951514, -0.1102905472447209, 0.3018367042445524])
def test_a_jump_is_confirmed(d):
    proof = certify_jump(model(), d)
    assert check_text(proof.text()).statement() == proof.statement


@pytest.mark.slow
def test_the_grazing_of_s4_is_confirmed():
    proof = certify_bifurcation(model(0.036976), "border_collision", 0.27943, 4, "V")
    assert check_text(proof.text()).statement() == proof.statement
    wrong = proof.text().replace(
        "0.0369759235203076003816096018771", "0.0369759235203076003816096018781"
    )
    with pytest.raises(Refused, match="nothing changes there"):
        check_text(wrong)


@pytest.mark.slow
def test_the_complete_list_is_confirmed_and_no_shorter_one():
    proof = ss.certify_orbits(model())
    assert check_text(proof.text()).statement() == proof.statement
    document = json.loads(proof.text())
    del document["orbits"][1]
    document["statement"] = words.read(document).statement()
    with pytest.raises(Refused, match=r"missed near d = \[?0\.0886"):
        check.check(document)


@pytest.mark.slow
def test_beside_the_preimage_of_a_graze_no_orbit_is_missed():
    # The images of an interval there are too wide until it is 1e-10 long.
    numbers = {"alpha": "1.2", "beta": "1.3", "V": "0.0366", "mu_1": "0.22", "mu_2": "0.22"}
    near = flint.arb("0.4232418625", 1e-7)
    with flint.ctx.workprec(128):
        check.check_no_other(motion.Motion(numbers), [near], 3, [], check.NARROWEST)


def test_a_long_orbit_is_confirmed():
    assert check_text(certify_orbit(model(0.0372), 0.27982381588921773, 55).text())


def test_every_changed_digit_is_refused(s4):
    text = s4.text()
    places = [m.start() for m in re.finditer(r"\d", text)]
    rng = np.random.default_rng(5)
    for place in rng.choice(places, 40, replace=False):
        digit = str((int(text[place]) + rng.integers(1, 10)) % 10)
        with pytest.raises(Refused):
            check_text(text[:place] + digit + text[place + 1 :])


@pytest.mark.parametrize(
    ("entry", "value", "reason"),
    [
        ("multiplier", "0.750772666108569555889401889854 +/- 5e-31", "multiplier is stated"),
        ("stable", False, "stable is stated"),
        ("period", 3, "4 points"),
        ("itinerary", ["-. .."] * 4, "itinerary is stated"),
        ("alone", "1e-01", "itinerary"),
        ("statement", "All is well.", "statement"),
        ("digits", 20, "points"),
        ("claim", "list", "not of its form"),
        ("schema", "2", "not a certificate"),
        ("system", {"alpha": "1.2"}, "system"),
    ],
)
def test_a_changed_entry_is_refused_with_the_reason(s4, entry, value, reason):
    with pytest.raises(Refused, match=reason):
        check.check(json.loads(s4.text()) | {entry: value})


def test_a_changed_digit_is_refused_by_arithmetic_even_if_the_statement_follows(s4):
    document = json.loads(s4.text())
    point = document["points"][0]
    document["points"][0] = point.replace("971 +/-", "972 +/-")
    assert document["points"][0] != point
    document["statement"] = words.read(document).statement()
    with pytest.raises(Refused, match=r"points\[0\] is stated"):
        check.check(document)


@pytest.mark.parametrize(
    "text", ["", "[]", "[" * 100_000, "{}", '{"schema": "stickslip-certificate-1"}']
)
def test_what_is_no_certificate_is_refused(text):
    with pytest.raises(Refused):
        check_text(text)


def test_it_shares_nothing_with_the_certifier_but_flint():
    for module in (check, falling, formulas, motion, words):
        for node in ast.walk(ast.parse(inspect.getsource(module))):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("stickslip"):
                assert node.module.startswith("stickslip.proofs.verify")
            elif isinstance(node, ast.Import):
                assert all(
                    name.name.split(".")[0] not in {"numpy", "stickslip"} for name in node.names
                )


@pytest.mark.parametrize("digits", [5, 12, 30])
@pytest.mark.parametrize(("p", "q"), [(6, 11), (5, 11), (-6, 11), (1, 2), (9, 20), (2, 3)])
def test_every_rational_number_can_be_written(p, q, digits):
    with flint.ctx.workprec(300):
        x = flint.arb(flint.fmpq(p, q)) + flint.arb(0, 1e-60)
        text = words.rounded(x, digits)
        assert words.ball(text).contains(x)
    assert len(text.split()[0].lstrip("-0.")) <= digits + 3


def test_a_ball_around_zero_is_written_as_zero():
    assert words.rounded(flint.arb(1e-60, 1e-50), 5) == "0.0000 +/- 5e-5"
    with pytest.raises(ValueError, match="fewer than 5 digits"):
        words.rounded(flint.arb(0, 0.1), 5)
