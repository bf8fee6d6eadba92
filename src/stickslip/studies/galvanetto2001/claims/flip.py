"""Section 4, law (9): P1 and A meet in a subcritical flip."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from stickslip.analysis.bifurcations.normal_forms import CubicCoefficient, flip_coefficient
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import Moment, in_window, moment

FLIP: Final = "alpha of the flip of P1"
APPROACH: Final = (1.20915, 1.2093, 1.2095, 1.2097)  # between the birth of A and the flip
BESIDE: Final = 1e-7  # of alpha: just below and just above the flip


@dataclass(frozen=True)
class Facts:
    """Moments up to the flip and on both sides of it, and its normal form."""

    approach: tuple[Moment, ...]
    below: Moment
    above: Moment
    coefficient: CubicCoefficient
    numbers: dict[str, Value]


def facts() -> Facts:
    """List orbits on the way to the flip and on both sides."""
    numbers = printed.numbers(11)
    at = numbers[FLIP].computed
    return Facts(
        approach=tuple(map(moment, APPROACH)),
        below=moment(at - BESIDE),
        above=moment(at + BESIDE),
        coefficient=flip_coefficient(in_window(at), moment(at).p1.points),
        numbers=numbers,
    )


def _p1(facts: Facts) -> Claim:
    below, above = (m.p1.multiplier for m in (facts.below, facts.above))
    return claim(
        "law9.p1_stability",
        "section 4, second example",
        "As alpha grows P1 changes stability at about 1.2099",
        Finding(
            "the multiplier of P1 leaves the unit circle at -1",
            f"{below:.9f} just below, {above:.9f} just above",
            -1.0 < below < -0.99 and above < -1.0,
        ),
        values=(facts.numbers[FLIP],),
    )


def _flip(facts: Facts) -> Claim:
    below, above = facts.below, facts.above
    c = facts.coefficient
    distance = np.nan
    if below.a is not None:
        distance = float(np.abs(below.a.points - below.p1.points[0]).max())
    return claim(
        "law9.flip",
        "section 4, second example",
        "At 1.2099 P1 and A meet in a smooth subcritical flip: the unstable period-2 orbit is gone "
        "and P1 is unstable",
        Finding(
            "A exists below, unstable, and not above",
            f"A just below: {'no' if below.a is None else f'{below.a.multiplier:.9f}'} "
            f"(multiplier), {distance:.2e} from P1; above: {'yes' if above.a else 'gone'}",
            below.a is not None and not below.a.stable and above.a is None,
        ),
        Finding(
            "the normal form is that of a subcritical flip",
            f"cubic coefficient {c.value:.6g} ± {c.error:.1g}",
            c.criticality == "sub",
        ),
        values=(facts.numbers[FLIP],),
    )


def _approach(facts: Facts) -> Claim:
    moments = (*facts.approach, facts.below)
    apart = [
        float(np.abs(m.a.points - m.p1.points[0]).max()) if m.a is not None else np.nan
        for m in moments
    ]
    listing = ", ".join(
        f"{gap:.3e} (alpha = {m.alpha:.7f})" for m, gap in zip(moments, apart, strict=True)
    )
    return claim(
        "law9.approach",
        "section 4, second example",
        "As alpha grows, A approaches P1",
        Finding("its distance from P1 falls", listing, all(a > b for a, b in pairwise(apart))),
    )


CLAIMS: Final = {11: (_p1, _flip, _approach)}
