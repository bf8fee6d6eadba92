"""Horseshoes: entropies against closed forms, the second program, and forgeries."""

import copy
import functools
import json
from math import log

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

import stickslip as ss
from stickslip.proofs.formulas import FormulaMap, formula_map_values
from stickslip.proofs.horseshoe import proven_horseshoe, snap_back
from stickslip.proofs.jet import precision
from stickslip.proofs.verify.check import check
from stickslip.proofs.verify.words import SCHEMA, Refused, read

LOST = 3e-4  # of the entropy: cuts lie a little beside the values at ends of laps

GOLDEN = log((1 + 5**0.5) / 2)


def own(branches, breakpoints=(), domain=(0, 1), **parameters):
    return ss.PiecewiseMap(branches, domain, parameters=parameters, breakpoints=breakpoints)


def tent(a):
    return own(["a*x", "a*(1 - x)"], [0.5], a=a)


@pytest.mark.parametrize(
    ("f", "entropy", "lost"),
    [
        (tent(1.7), log(1.7), LOST),
        (tent(2.0), log(2), LOST),
        (own(["b*x + 0.1", "b*x - 0.9"], ["0.9/b"], b=1.5), log(1.5), LOST),  # jumps
        (own(["3*x", "2 - 3*x", "3*x - 2"], ["1/3", "2/3"]), log(3), LOST),
        (own(["r*x*(1 - x)"], r=4.0), log(2), 1e-2),
        (own(["r*x*(1 - x)"], r=3.8318740552833155), GOLDEN, 1e-2),  # superstable period 3
    ],
)
def test_the_entropy_is_a_lower_bound_and_close(f, entropy, lost):
    proof = ss.certify_entropy(f)
    assert proof, proof.statement
    assert entropy - lost < float(proof.document["entropy"]) <= entropy
    assert check(json.loads(proof.text())).statement() == proof.statement


def test_of_two_parts_the_richer_one_is_taken():
    f = own(["1.9*x", "1.9*(0.5 - x)", "0.5 + 1.4*(x - 0.5)", "0.5 + 1.4*(1 - x)"],
            [0.25, 0.5, 0.75])  # fmt: skip
    entropy = float(ss.certify_entropy(f).document["entropy"])
    assert log(1.9) - LOST < entropy <= log(1.9)


@pytest.mark.parametrize("r", [2.5, 3.2, 3.5])
def test_where_periods_double_no_chaos_is_proven(r):
    proof = ss.certify_entropy(own(["r*x*(1 - x)"], r=r))
    assert not proof
    assert "several ways" in proof.statement


def test_less_than_asked_for_is_not_proven():
    proof = ss.certify_entropy(tent(1.7), at_least=0.531)
    assert not proof
    assert "0.530" in proof.statement


@functools.cache
def chaotic():
    return ss.TwoBlock(alpha=3.007, beta=0.6146, V=0.0199, friction=ss.Coulomb(mu=0.542))


@functools.cache
def proof_of_chaos():
    return ss.certify_entropy(chaotic(), at_least=0.6)


def test_two_blocks_are_chaotic_and_the_second_program_agrees():
    proof = proof_of_chaos()
    assert proof, proof.statement
    document = json.loads(proof.text())
    assert check(document).statement() == proof.statement
    # As many orbits as walks that close: fixed points of f^n by the search.
    f = ss.event_map(chaotic())
    lows, highs = (np.array([float(row[k]) for row in document["intervals"]]) for k in (0, 1))
    ends = np.sort([f(lows), f(highs)], axis=0)
    covers = (ends[0][:, None] <= lows) & (highs <= ends[1][:, None])
    for n in (1, 2, 3):
        closed = round(np.trace(np.linalg.matrix_power(covers.astype(float), n)))
        orbits = [o for o in ss.periodic_orbits(f, n) if n % o.period == 0]
        assert closed <= sum(orbit.period for orbit in orbits)


def forged(document, change):
    document = copy.deepcopy(document)
    change(document)
    return document


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda d: d.update(entropy="0.530629"), "entropy of 0.530629"),
        (lambda d: d.update(entropy="0"), "positive"),
        (lambda d: d["intervals"].pop(), "enough"),
        (lambda d: d["intervals"].pop(0), "enough"),
        (lambda d: d["intervals"].reverse(), "apart"),
        (lambda d: d["intervals"].append(d["intervals"][-1]), "apart"),
        (lambda d: d["intervals"][3].__setitem__(1, d["intervals"][4][0]), "apart"),
        (lambda d: d["intervals"][3].__setitem__(2, 10**18), "enough"),
        (lambda d: d["intervals"][3].__setitem__(2, 0), "form"),
        (lambda d: d["intervals"][-1].__setitem__(1, "1.1"), "enough|domain"),
        (lambda d: d.update(intervals=[["0.2", "0.7", 1]]), "breakpoint|enough"),
        (lambda d: d["system"]["parameters"].update(a="1.69"), "enough|apart"),
        (lambda d: d["system"].update(branches=["a*x", "a*(1 - x) + 0.1"]), "enough"),
    ],
)
def test_a_forged_horseshoe_is_refused(change, reason):
    document = json.loads(ss.certify_entropy(tent(1.7)).text())
    with pytest.raises(Refused, match=reason):
        check(forged(document, change))


@pytest.mark.slow
def test_law_9_has_a_snap_back_repeller():
    proof = ss.certify_entropy(ss.examples.law9(), at_least=0.1)
    assert proof, proof.statement
    document = json.loads(proof.text())
    assert check(document).statement() == proof.statement
    with pytest.raises(Refused, match="enough"):
        check(forged(document, lambda d: d["intervals"].pop()))


@pytest.mark.parametrize("r", [3.7, 4.0])
def test_a_snap_back_repeller_gives_less_of_the_same_entropy(r):
    f = own(["r*x*(1 - x)"], r=r)
    with precision(128):
        entries = proven_horseshoe(FormulaMap(formula_map_values(f)), snap_back(f))
    assert 0.01 < float(entries["entropy"]) < float(ss.certify_entropy(f).document["entropy"])
    digits = {"schema": SCHEMA, "digits": 12, "claim": "horseshoe"}
    document = {**digits, "system": formula_map_values(f), **entries}
    check(document | {"statement": read(document).statement()})
