"""Check a horseshoe: intervals that the map takes over one another, and the entropy they force."""

from __future__ import annotations

import bisect
import itertools
from fractions import Fraction
from typing import Any, Final

from flint import arb

from stickslip.proofs.verify.words import Horseshoe, Refused, enclosed, fraction, middle_of

CUTS: Final = 48  # halvings of an interval on which the map is to be continuous
MOST_PARTS: Final = 20_000


def check_horseshoe(motion: Any, c: Horseshoe) -> None:
    """Refuse unless each weight, times the growth, is at most the sum of those that it covers."""
    # From an interval of weight w then start at least growth^n w / (largest weight) walks of n
    # steps, and each is that of a start: f is continuous on all of them.
    lows = [fraction(low) for low, _, _ in c.intervals]
    highs = [fraction(high) for _, high, _ in c.intervals]
    ends = [x for pair in zip(lows, highs, strict=True) for x in pair]
    if any(a >= b for a, b in itertools.pairwise(ends)):
        raise Refused("the intervals are not apart, from left to right")
    sums = [0, *itertools.accumulate(weight for *_, weight in c.intervals)]
    growth = enclosed(fraction(c.entropy)).exp()
    for low, high, (*_, weight) in zip(lows, highs, c.intervals, strict=True):
        _continuous(motion, low, high)
        a, b = sorted((motion.step(enclosed(end))[1] for end in (low, high)), key=arb.mid)
        first = bisect.bisect_left(lows, middle_of(a.upper()))
        last = bisect.bisect_right(highs, middle_of(b.lower()))
        covered = sums[last] - sums[first] if first < last else 0
        if not arb(covered) >= growth * weight:
            raise Refused(
                f"[{float(low):.12g}, {float(high):.12g}] is not shown to be taken over enough of "
                f"the others for an entropy of {c.entropy}"
            )


def _continuous(motion: Any, low: Fraction, high: Fraction) -> None:
    """Refuse unless parts that cover a closed interval have one itinerary each, and a slope."""
    waiting, parts = [(low, high, CUTS)], 0
    while waiting:
        low, high, left = waiting.pop()
        x = enclosed(low).union(enclosed(high))
        try:
            if not motion.inside(x):
                raise Refused(f"{x.str(12)} is not shown to be in the domain")
            motion.step(x)
        except Refused:
            parts += 1
            if not left or parts > MOST_PARTS:
                raise
            middle = (low + high) / 2
            waiting += [(middle, high, left - 1), (low, middle, left - 1)]
