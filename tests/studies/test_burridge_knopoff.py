"""The chain of 200 blocks: how exponents are fitted, and what a lone slip is."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip import studies
from stickslip.studies.burridge_knopoff.facts import chain, lone_moment
from stickslip.studies.burridge_knopoff.power_law import fit_power_law


@pytest.mark.parametrize("exponent", [1.7, 2.5])
def test_a_power_law_above_a_cut_is_found_again(exponent: float) -> None:
    rng = np.random.default_rng(3)
    tail = 0.02 * (1.0 + rng.pareto(exponent - 1.0, size=2000))
    law = fit_power_law(np.concatenate([tail, rng.uniform(0.0, 0.02, 2000)]), rng)
    assert abs(law.exponent - exponent) < 3 * law.error
    assert law.error == pytest.approx((law.exponent - 1.0) / np.sqrt(law.n))
    assert law.smallest == pytest.approx(0.02, rel=0.5)
    assert law.p_value > 0.05
    assert law.exponential > 2.0
    assert law.share_above(np.array([law.smallest, np.inf])).tolist() == [1.0, 0.0]


def test_an_exponential_law_is_told_apart() -> None:
    rng = np.random.default_rng(4)
    law = fit_power_law(1.0 + rng.exponential(size=3000), rng)
    assert law.exponential < 0.0
    assert law.p_value < 0.05 or law.n < 300


@pytest.mark.parametrize("V", [0.01, 0.001])
def test_a_lone_slip_of_the_chain_is_that_of_one_block(V: float) -> None:
    model = chain(100.0, V, n=5)
    x = np.array([0.0, 0.0, 2e-3, 0.0, 0.0])  # the third one is loaded most
    slip = next(ss.slips(model, x, np.full(5, V), t_end=2.0 / V))
    assert slip.blocks == (3,)
    assert slip.moment == pytest.approx(lone_moment(100.0, V), rel=1e-9)


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="burridge_knopoff")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 6
