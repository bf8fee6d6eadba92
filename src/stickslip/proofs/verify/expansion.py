"""Check an expansion: intervals that the map takes into themselves, and grows in."""

from __future__ import annotations

import bisect
from typing import Final

from flint import arb

from stickslip.proofs.verify.cover import COARSE, Union
from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import (
    Expansion,
    Refused,
    enclosed,
    fraction,
    halved,
    middle_of,
)

CUTS: Final = 30  # halvings of an interval


def check_expansion(motion: Motion, c: Expansion) -> None:
    """Refuse unless |f'| times the weight at the image is at least the weight times the growth."""
    # Along n steps the factors make |(f^n)'| at least growth^n (least weight) / (largest weight).
    lows = [fraction(low) for low, _, _ in c.intervals]
    highs = [fraction(high) for _, high, _ in c.intervals]
    weights = [weight for *_, weight in c.intervals]
    if any(a >= b for a, b in zip(lows, highs, strict=True)) or any(
        a > b for a, b in zip(highs, lows[1:], strict=False)
    ):
        raise Refused("the intervals are not in order from left to right")
    if not all(motion.inside(enclosed(end)) for end in (lows[0], highs[-1])):
        raise Refused("the intervals are not in the domain")
    union = Union(lows[0], highs[0])
    for low, high in zip(lows, highs, strict=True):
        union.add(low, high)
    growth = enclosed(fraction(c.exponent)).exp()

    def grows(x: arb, weight: int) -> bool:
        for value, slope in _outcomes(motion, x):
            if not union.holds(value):
                return False
            first = bisect.bisect_left(highs, middle_of(value.lower()))
            last = bisect.bisect_right(lows, middle_of(value.upper()))
            if not abs(slope) * min(weights[first:last]) >= growth * weight:
                return False
        return True

    for low, high, weight in zip(lows, highs, weights, strict=True):
        waiting = [(enclosed(low).union(enclosed(high)), CUTS)]
        while waiting:
            x, left = waiting.pop()
            try:
                proven = grows(x, weight)
            except Refused:
                proven = False
            if not proven and not left:
                raise Refused(f"the map is not shown to stay and to expand at d = {x.str(12)}")
            waiting += [] if proven else [(half, left - 1) for half in halved(x)]


def _outcomes(motion: Motion, x: arb) -> list[tuple[arb, arb]]:
    """Enclose all next values that are possible, and slopes."""
    try:
        return [motion.step(x)[1:]]
    except Refused:
        if x.rad() > COARSE:
            raise
        return [(value, slope) for _, value, slope in motion.outcomes(x)]
