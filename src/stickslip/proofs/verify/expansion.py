"""Check an expansion: intervals that the map takes into themselves, and grows in."""

from __future__ import annotations

import bisect
from functools import partial

from flint import arb

from stickslip.proofs.verify.cover import System, Union, everywhere, possible
from stickslip.proofs.verify.words import (
    Expansion,
    Refused,
    enclosed,
    fraction,
    middle_of,
)


def check_expansion(values: dict[str, str], c: Expansion) -> None:
    """Refuse unless |f'| times the weight at the image is at least the weight times the growth."""
    # Along n steps the factors make |(f^n)'| at least growth^n (least weight) / (largest weight).
    lows = [fraction(low) for low, _, _ in c.intervals]
    highs = [fraction(high) for _, high, _ in c.intervals]
    weights = [weight for *_, weight in c.intervals]
    if any(a >= b for a, b in zip(lows, highs, strict=True)) or any(
        a > b for a, b in zip(highs, lows[1:], strict=False)
    ):
        raise Refused("the intervals are not in order from left to right")
    system = System(values, (), None)
    if not all(system.all.inside(enclosed(end)) for end in (lows[0], highs[-1])):
        raise Refused("the intervals are not in the domain")
    union = Union(lows[0], highs[0])
    for low, high in zip(lows, highs, strict=True):
        union.add(low, high)
    growth = enclosed(fraction(c.exponent)).exp()

    def least(value: arb) -> int:
        """Least weight of the intervals that a ball meets; 0 if it may lie outside of all."""
        if not union.holds(value):
            return 0
        first = bisect.bisect_left(highs, middle_of(value.lower()))
        return min(weights[first : bisect.bisect_right(lows, middle_of(value.upper()))])

    def grows(system: System, x: arb, weight: int) -> None:
        for value, slope in possible(system, x):
            if not abs(slope) * least(value) >= growth * weight:
                raise Refused(f"the map is not shown to stay and to expand at d = {x.str(12)}")

    for low, high, weight in zip(lows, highs, weights, strict=True):
        everywhere(partial(grows, weight=weight), system, (low, high))
