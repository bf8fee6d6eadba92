"""Chaos proven: intervals that are taken into themselves, in which every orbit is unstable."""

import copy
import functools
import json
import re

import numpy as np
import pytest
from tests.sizes import slow

pytest.importorskip("flint", reason="needs the extra 'certify'")

import stickslip as ss
from stickslip.proofs.verify.check import check
from stickslip.proofs.verify.words import Refused

START = 0.27


def model():
    return ss.TwoBlock(alpha=3.1, beta=1.26, V=0.065, friction=ss.Coulomb(mu=0.061))


@functools.cache
def document():
    proof = ss.certify_chaos(model(), START)
    assert proof, proof.statement
    return json.loads(proof.text())


def columns(document):
    return (np.array([float(row[k]) for row in document["intervals"]]) for k in range(3))


@pytest.mark.slow  # 22 s of processor time
def test_the_second_program_confirms_it():
    assert check(document()).statement() == document()["statement"]


def test_no_orbit_is_slower_than_stated():
    (attractor,) = ss.attractors(model())
    exponent = float(document()["exponent"])
    low, high, _ = columns(document())
    for a, b in attractor.bands:
        assert low[0] <= a < b <= high[-1]
    f = ss.event_map(model())
    orbits = [o for o in ss.periodic_orbits(f, 5) if low[0] < o.points[0] < high[-1]]
    rates = [np.log(abs(o.multiplier)) / o.period for o in orbits]
    assert len(rates) >= 5
    assert 0.5 * min(rates) < exponent < min(rates)
    assert exponent < attractor.lyapunov.value


def test_each_step_stays_and_grows_by_the_weights_in_floating_point():
    f, growth = ss.event_map(model()), np.exp(float(document()["exponent"]))
    low, high, weight = columns(document())
    x = (low + np.linspace(0.01, 0.99, 25)[:, None] * (high - low)).ravel()
    y, slope = f(x), abs(f.derivative(x))
    before, after = (np.searchsorted(low, at, side="right") - 1 for at in (x, y))
    assert np.all((after >= 0) & (y <= high[after]))
    assert np.all(slope * weight[after] >= growth * weight[before])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda d: d.update(exponent="0.3"), "expand"),
        (lambda d: d.update(exponent="0"), "positive"),
        (lambda d: d["intervals"].pop(), "stay"),
        (lambda d: d["intervals"].reverse(), "order"),
        (lambda d: d["intervals"].append(d["intervals"][-1]), "order"),
        (lambda d: d["intervals"][-1].__setitem__(1, "0.5"), "domain"),
        # Far out, where many pieces are enclosed before one is refused.
        *slow((lambda d: d["intervals"][-1].__setitem__(1, "0.31"), "stay|expand")),
        (lambda d: d["intervals"][0].__setitem__(2, 10**18), "expand"),
        (lambda d: [row.__setitem__(2, 1) for row in d["intervals"]], "expand"),
        (lambda d: d["system"].update(gamma_1="3"), "system"),
    ],
)
def test_a_forged_expansion_is_refused(change, reason):
    forged = copy.deepcopy(document())
    change(forged)
    with pytest.raises(Refused, match=reason):
        check(forged)


@pytest.mark.parametrize(
    ("system", "d", "reason"),
    [
        (ss.examples.coulomb(), 0.28, "expand|slope"),  # S4 attracts
        *slow(
            (
                ss.TwoBlock(alpha=3.007, beta=0.6146, V=0.0199, friction=ss.Coulomb(mu=0.542)),
                -0.03,
                "slope",  # the band has a fold
            )
        ),
    ],
)
def test_what_does_not_expand_is_not_proven(system, d, reason):
    proof = ss.certify_chaos(system, d)
    assert not proof
    assert re.search(reason, proof.statement)


def test_less_than_asked_for_is_no_proof_and_bad_input_is_named():
    assert "only an exponent of" in ss.certify_chaos(model(), START, at_least=0.3).statement
    with pytest.raises(ValueError, match="d = 3"):
        ss.certify_chaos(model(), 3.0)
    with pytest.raises(ValueError, match="Coulomb friction alone"):
        ss.certify_chaos(ss.examples.law9(), 0.1)
