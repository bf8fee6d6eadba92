"""Maps by formulas: proven lists against closed forms and the search, both programs alike."""

import contextlib
import copy
import itertools
import json
import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.numerics.test_formula_text import sums

pytest.importorskip("flint", reason="needs the extra 'certify'")

from flint import arb, ctx

import stickslip as ss
from stickslip.cli import main
from stickslip.proofs.complete import Survey
from stickslip.proofs.formulas import FormulaMap, formula_map_values
from stickslip.proofs.jet import variables
from stickslip.proofs.power import step
from stickslip.proofs.verify import words
from stickslip.proofs.verify.check import check, check_text
from stickslip.proofs.verify.formulas import FormulaMotion
from stickslip.proofs.verify.words import Refused
from stickslip.proofs.wave import Undecided

ROUNDING = 1e-12


def broken(**changes):
    return ss.PiecewiseMap(
        ["a - 1.1*x - 0.35*x**2", "0.55*x - 0.62"],
        (-1.5, 1.5),
        parameters={"a": 0.45},
        breakpoints=[0.2],
    ).replace(**changes)


def logistic(r, domain=(-0.1, 1.1)):
    return ss.PiecewiseMap("r*x*(1 - x)", domain, parameters={"r": r})


def listed(document):
    """Period, points and itinerary of each orbit, the points in rational numbers."""
    return {
        (o["period"], tuple(o["itinerary"]), tuple(Fraction(p.split()[0]) for p in o["points"]))
        for o in document["orbits"]
    }


def confirmed(proof):
    assert proof.proven, proof.statement
    assert check_text(proof.text()).statement() == proof.statement
    return proof.document


# ---------------------------------------------------------------- lists


def affine_orbits(lines, breakpoints, domain, max_period):
    """All orbits of x -> slope x + constant on each piece, by solving for every itinerary."""
    ends = [Fraction(-10), *breakpoints, Fraction(10)]
    found = set()
    for period in range(1, max_period + 1):
        for word in itertools.product(range(len(lines)), repeat=period):
            slope, constant = Fraction(1), Fraction(0)
            for k in word:
                slope, constant = lines[k][0] * slope, lines[k][0] * constant + lines[k][1]
            if slope == 1:
                continue
            x = constant / (1 - slope)
            points = []
            for k in word:
                points.append(x)
                x = lines[k][0] * x + lines[k][1]
            inside = all(
                ends[k] <= p < ends[k + 1] and domain[0] <= p <= domain[1]
                for k, p in zip(word, points, strict=True)
            )
            if inside and len(set(points)) == period and points[0] == min(points):
                found.add((period, tuple(map(str, word)), tuple(points)))
    return found


@pytest.mark.parametrize("seed", range(12))
def test_lists_of_affine_pieces_are_those_of_the_closed_form(seed):
    rng = np.random.default_rng(seed)
    pieces, max_period = int(rng.integers(1, 4)), 4
    breakpoints = sorted(
        Fraction(int(k), 97) for k in rng.choice(np.arange(-60, 60), pieces - 1, replace=False)
    )
    lines = [
        (Fraction(int(rng.integers(-180, 180)), 100), Fraction(int(rng.integers(-90, 90)), 100))
        for _ in range(pieces)
    ]
    f = ss.PiecewiseMap(
        [f"({slope})*x + ({constant})" for slope, constant in lines],
        (-1, 1),
        breakpoints=[f"{b}" for b in breakpoints],
    )
    document = confirmed(ss.certify_orbits(f, max_period))
    expected = affine_orbits(lines, breakpoints, (-1, 1), max_period)
    assert document["undecided"] == []
    assert len(document["orbits"]) == len(expected)
    for (period, word, points), (p, w, exact) in zip(
        sorted(listed(document)), sorted(expected), strict=True
    ):
        assert (period, word) == (p, w)
        assert all(abs(a - b) < Fraction(1, 10**28) for a, b in zip(points, exact, strict=True))


@pytest.mark.parametrize("seed", range(6))
def test_lists_of_quadratic_pieces_hold_what_the_search_finds(seed):
    rng = np.random.default_rng(seed)
    a, b, c, d, e, edge = (round(x, 3) for x in rng.uniform(-1.5, 1.5, 6))
    f = ss.PiecewiseMap(
        [f"{a} + ({b})*x + c*x**2", f"d + ({e})*x - c*x**2"],
        (-2.0, 2.0),
        parameters={"c": c, "d": d, "edge": edge},
        breakpoints=["edge"],
    )
    document = confirmed(ss.certify_orbits(f, 5))
    found = ss.periodic_orbits(f, 5)
    assert document["undecided"] == []
    assert len(document["orbits"]) == len([o for o in found if not o.infinitely_unstable])
    points = sorted(float(p) for _, _, several in listed(document) for p in several)
    expected = sorted(x for o in found if not o.infinitely_unstable for x in o.points)
    assert np.allclose(points, expected, rtol=0, atol=1e-9)


def test_a_map_with_a_jump_and_a_quadratic_piece_has_one_orbit():
    document = confirmed(ss.certify_orbits(broken(), 8))
    ((period, word, _),) = listed(document)
    assert (period, word) == (2, ("0", "1"))
    assert ss.certify_orbits(broken(), 2).statement.startswith(
        "The map f of [-1.5, 1.5] with f(x) = a - 1.1*x - 0.35*x**2 for x < 0.2, "
        "0.55*x - 0.62 for x >= 0.2, a = 0.45 (exact numbers). On its whole domain the map has "
        "exactly 1 periodic orbit of period up to 2 (period 2, x = -0.238934429837469"
    )


def test_the_logistic_map_has_as_many_orbits_as_necklaces_tell():
    # Beyond r = 4 it is a full horseshoe.
    periods = [o["period"] for o in confirmed(ss.certify_orbits(logistic(4.1), 5))["orbits"]]
    assert [periods.count(p) for p in range(1, 6)] == [2, 1, 2, 3, 6]


def test_no_orbit_is_listed_twice():
    # The one of period 3 passes beside an interval in which it is not, where it was found again.
    periods = [o["period"] for o in confirmed(ss.certify_orbits(logistic(3.9), 5))["orbits"]]
    assert periods == [1, 1, 2, 3, 3, 4, 5, 5]


def test_a_root_at_the_edge():
    f = ss.PiecewiseMap(
        ["a*x + mu", "mu - b*sqrt(x)"],
        (-1.0, 0.5),
        parameters={"a": 0.4, "b": 1.0, "mu": 0.05},
        breakpoints=[0.0],
    )
    periods = [o["period"] for o in confirmed(ss.certify_orbits(f, 4))["orbits"]]
    assert periods == [o.period for o in ss.periodic_orbits(f, 4)] == [1, 2, 3, 3, 4]


def test_powers_of_negative_numbers_with_an_exponent_that_is_only_enclosed_stay_undecided():
    # 0.1*30 is exactly 3, and the fixed point -0.05: were it taken for 3.01, there would be none.
    f = ss.PiecewiseMap(["0.9", "1 + 8400*x**(0.1*30)"], (-1, 1), breakpoints=[-0.055])
    values = formula_map_values(f)
    (x,) = variables([arb(-0.02)], [arb(0.0325)])
    with pytest.raises(Undecided, match="no value on all of the box"):
        FormulaMap(values).images(x, (), forks=8, at_touch=False)
    with pytest.raises(Refused, match="may have been missed"):
        check(forged(of_map(values)))


def test_an_orbit_on_a_breakpoint_or_an_end_stays_undecided():
    for f, place in (
        (ss.PiecewiseMap(["-0.1*x", "-0.5*x"], (-1, 1), breakpoints=[0]), 0),
        (logistic(3.7, (0, 1)), 0),
    ):
        proof = ss.certify_orbits(f)
        document = confirmed(proof)
        ((low, high),) = document["undecided"]
        assert float(low) < place < float(high)
        assert float(high) - float(low) < 1e-8
        assert proof.undecided == ((float(low), float(high)),)
        assert " has at least " in proof.statement


def test_a_fold_stays_undecided():
    document = confirmed(ss.certify_orbits(ss.PiecewiseMap("1 - 1.75*x**2", (-1.2, 1.2)), 3))
    assert len(document["undecided"]) == 3
    assert [o["period"] for o in document["orbits"]] == [1, 1, 2]


def test_orbits_that_fill_an_interval_end_the_search():
    proof = ss.certify_orbits(ss.PiecewiseMap("-x", (-1, 1)), 2)
    assert not proof.proven
    assert "orbits of period 2 may fill them" in proof.statement


def test_of_a_map_without_values_on_an_interval_nothing_is_proven():
    proof = ss.certify_orbits(ss.PiecewiseMap("sqrt(x - 0.5)", (0, 1)))
    assert not proof.proven
    assert "the map has no value there" in proof.statement


def test_an_orbit_that_leaves_the_domain_is_none():
    # Of 2.5 x - 0.5 and 2 - 2.5 x the cycle through 0.44 passes 0.6 and 0.5: outside of [0, 0.55].
    wide, narrow = (
        ss.PiecewiseMap(["2.5*x - 0.5", "2 - 2.5*x"], (0, end), breakpoints=[0.5])
        for end in (1, 0.55)
    )
    expected = affine_orbits(
        [(Fraction(5, 2), Fraction(-1, 2)), (Fraction(-5, 2), Fraction(2))],
        [Fraction(1, 2)],
        (0, Fraction(55, 100)),
        4,
    )
    assert len(confirmed(ss.certify_orbits(narrow, 4))["orbits"]) == len(expected)
    assert len(confirmed(ss.certify_orbits(wide, 4))["orbits"]) > len(expected)


def test_a_certificate_is_saved_loaded_and_verified_by_the_program(tmp_path, capsys):
    proof = ss.certify_orbits(broken(), 4)
    path = tmp_path / "orbits.json"
    proof.save(path)
    assert ss.load(path) == proof
    assert main(["verify", str(path)]) == 0
    assert capsys.readouterr().out == f"holds: {proof.statement}\n"
    path.write_text(path.read_text().replace('"0.45"', '"0.46"'))
    assert main(["verify", str(path)]) == 4
    assert capsys.readouterr().err.startswith("refused: ")
    with pytest.raises(ValueError, match="statement is not what the numbers say"):
        ss.load(path)


def test_wide_domains_that_most_points_leave_take_few_boxes(monkeypatch):
    boxes = []
    values = Survey._values
    monkeypatch.setattr(
        Survey, "_values", lambda self, *box: boxes.append(box) or values(self, *box)
    )
    f = ss.PiecewiseMap(["3*x", "-2*x + 1"], (-1e5, 1e5), breakpoints=[0.1])
    document = confirmed(ss.certify_orbits(f, 2))
    assert len(boxes) < 2000
    assert [o["period"] for o in document["orbits"]] == [1, 1]


# ---------------------------------------------------------------- single orbits


def test_an_orbit_is_proven_to_the_digits_asked_for():
    f = logistic(3.2)
    orbit = next(o for o in ss.periodic_orbits(f, 2) if o.period == 2)
    proof = ss.certify(orbit, f, digits=50)
    document = confirmed(proof)
    # The points of the 2-cycle are the roots of r^2 x^2 - r (r + 1) x + r + 1.
    low, high = (Fraction(p.split()[0]) for p in document["points"])
    r = Fraction(32, 10)
    assert abs(low + high - (r + 1) / r) < Fraction(1, 10**48)
    assert abs(low * high - (r + 1) / r**2) < Fraction(1, 10**48)
    assert document["stable"]


def test_floats_are_the_decimals_that_they_print_and_exact_replaces_them():
    f = ss.PiecewiseMap("a*x + 0.35", (-1, 1), parameters={"a": 0.1})
    (orbit,) = ss.periodic_orbits(f)
    for exact, value in ((None, Fraction(35, 90)), ({"a": "1/3"}, Fraction(35, 100) * 3 / 2)):
        document = confirmed(ss.certify_orbits(f, exact=exact))
        point = Fraction(document["orbits"][0]["points"][0].split()[0])
        assert abs(point - value) < Fraction(1, 10**29)
    assert ss.certify(orbit, f).proven


def test_what_cannot_be_certified_is_told():
    f = ss.PiecewiseMap(lambda x: x / 2, (0, 1))
    with pytest.raises(ValueError, match="Give the branches as formulas"):
        ss.certify_orbits(f)
    with pytest.raises(ValueError, match="Give the branches as formulas"):
        ss.certify(ss.periodic_orbits(f)[0], f)
    (found, *_) = ss.breakpoints(broken())
    with pytest.raises(ValueError, match="only its orbits are proven"):
        ss.certify(found, broken())
    with pytest.raises(ValueError, match="exact names 'q'"):
        ss.certify_orbits(broken(), exact={"q": "1"})


# ---------------------------------------------------------------- the two programs


@pytest.fixture(scope="module")
def document():
    return json.loads(ss.certify_orbits(logistic(3.6), 3, digits=12).text())


def forged(document):
    return document | {"statement": words.read(document).statement()}


@pytest.mark.parametrize("k", [0, 1, 2])
def test_a_list_that_leaves_out_an_orbit_is_refused(document, k):
    shorter = copy.deepcopy(document)
    assert len(shorter["orbits"]) == 3
    del shorter["orbits"][k]
    with pytest.raises(Refused, match="may have been missed"):
        check(forged(shorter))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda s: s.update(branches=["r*x*(1 - x)*1.01"]), "stated as"),
        (lambda s: s["parameters"].update(r="3.61"), "stated as"),
        (lambda s: s["parameters"].update(r="-3.6"), "no such orbit|stated|outside"),
        (lambda s: s["parameters"].clear(), "r is not given"),
        (lambda s: s["parameters"].update(x="1"), "a parameter is named x"),
        (lambda s: s.update(domain=["0", "0.5"]), "outside of the domain"),
        (lambda s: s.update(domain=["1", "0"]), "not shown to be in order"),
        (lambda s: s.update(breakpoints=["0.5"]), "1 branches and 1 breakpoints"),
        (lambda s: s.update(branches=["r*x", "x"], breakpoints=["x"]), "x is not given"),
        (lambda s: s.update(branches=["1", "x", "x"], breakpoints=["1", "1"]), "in order"),
        (lambda s: s.update(branches=["x.__class__"]), "cannot be read"),
        (lambda s: s.update(branches=["__import__(x)"]), "is no function"),
        (lambda s: s.update(branches=["print(x)"]), "is no function"),
        (lambda s: s.update(branches=["x\n"]), "form"),
        (lambda s: s.update(branches=["r x"]), "cannot be read"),
        (lambda s: s.update(branches=["x +"]), "cannot be read"),
        (lambda s: s.update(branches=["(" * 900]), "nested too deep"),
        (lambda s: s.update(branches=["-" * 900 + "x"]), "nested too deep"),
        (lambda s: s.update(branches=["x*" * 500 + "x"]), "form"),
        (lambda s: s.update(branches=["1e999999*x"]), "too large"),
        (lambda s: s.update(branches=["x / (x - x)"]), "a divisor may be 0"),
        (lambda s: s.update(branches=["sqrt(-1 - x)"]), "root"),
        (lambda s: s.update(branches=["log(-1 - x)"]), "no value"),
        (lambda s: s.update(branches=[]), "form"),
        (lambda s: s.update(branches="x"), "form"),
        (lambda s: s.update(more=1), "form"),
    ],
)
def test_another_map_is_refused(document, change, reason):
    other = copy.deepcopy(document)
    change(other["system"])
    with contextlib.suppress(Refused):  # where no statement can be made of it
        other = forged(other)
    with pytest.raises(Refused, match=reason):
        check(other)


def test_a_theorem_of_blocks_is_none_of_formulas(document):
    jump = {"claim": "jump", "d": "0.5 +/- 5e-2", "left": "0.1 +/- 5e-2", "right": "0.2 +/- 5e-2"}
    other = {name: document[name] for name in ("schema", "system", "digits")} | jump
    with pytest.raises(Refused, match="form"):
        check(other)


def setting(text):
    return formula_map_values(ss.PiecewiseMap([text], (0, 2), parameters={"a": 1.3, "b": 0.4}))


@settings(max_examples=300)
@given(sums(3), st.floats(0.05, 1.95), st.sampled_from([1e-12, 1e-3, 0.3]))
def test_both_programs_enclose_the_values_of_any_formula(text, x, width):
    text = re.sub(r"\bs\b", "x", text)
    try:
        values = setting(text)
    except ValueError:
        return
    low, high = max(x - width, 0.0), min(x + width, 2.0)
    points = np.linspace(low, high, 7)
    f = ss.PiecewiseMap([text], (0, 2), parameters={"a": 1.3, "b": 0.4})
    found = f.evaluate(points)
    middle, radius = arb((low + high) / 2), arb((high - low) / 2)
    before, ctx.prec = ctx.prec, 120
    try:
        enclosures = []
        (jet,) = variables([middle], [radius])
        try:
            (piece,) = step(FormulaMap(values), jet)
            enclosures.append((piece.value.range, piece.value.gradient[0]))
        except Undecided:
            pass
        try:
            motion = FormulaMotion(words.read(of_map(values)).system)
            _, value, slope = motion.step(jet.range)
            enclosures.append((value, slope))
        except Refused:
            pass
    finally:
        ctx.prec = before
    for value, slope in enclosures:
        for y, dy in zip(found.value, found.derivative, strict=True):
            for ball, number in ((value, y), (slope, dy)):
                if np.isfinite(number) and ball.is_finite():
                    room = 1e-9 * (1 + abs(number))
                    assert (ball + arb(0, room)).contains(arb(float(number))), (text, ball, number)


def of_map(values):
    return {
        "schema": words.SCHEMA,
        "claim": "list",
        "system": values,
        "digits": 10,
        "max_period": 1,
        "orbits": [],
        "undecided": [],
    }
