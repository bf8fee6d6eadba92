"""Check a branch: an orbit for every value of a parameter, alone in a tube around a polygon."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from fractions import Fraction
from functools import reduce
from typing import Final, NamedTuple

from flint import arb, arb_series

from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import Branch, Refused, enclosed, fraction

FINEST: Final = 8  # halvings of the part of the parameter between two nodes
WHOLE: Final = 3  # the first of them, in which the tube is not cut lengthwise


class _Stretch(NamedTuple):
    """The tube between two nodes: around a line in the plane of the parameter and d."""

    low: Fraction
    high: Fraction
    start: Fraction
    slope: Fraction
    radius: Fraction

    def line(self, p: Fraction) -> Fraction:
        """Return d in the middle of the tube at a value of the parameter."""
        return self.start + self.slope * (p - self.low)


def check_branch(values: dict[str, str], names: tuple[str, ...], c: Branch) -> None:
    """Refuse unless the branch runs through its tube from end to end, as stated."""
    # `names` are those of the parameter in the system. At a node both tubes have the same centre:
    # the orbit alone in the wider one is that in the narrower one, and the pieces are one branch.
    for stretch in _stretches(c):
        waiting = [(stretch.low, stretch.high, 0)]
        while waiting:
            low, high, depth = waiting.pop()
            part = stretch._replace(low=low, high=high, start=stretch.line(low))
            try:
                _holds(values, names, c, part, 1 + 2 * (2**depth >> WHOLE + 1))
            except Refused as reason:
                if depth == FINEST:
                    told = f"{c.parameter} = {float(low):.17g}"
                    raise Refused(f"nothing is shown at {told}: {reason}") from None
                middle = (low + high) / 2
                waiting += [(middle, high, depth + 1), (low, middle, depth + 1)]


def in_tube(c: Branch, p: arb, x: arb) -> bool:
    """Whether a point lies in the tube, at a value of the parameter that it reaches."""
    for stretch in _stretches(c):
        low, high, start, slope, radius = (enclosed(each) for each in stretch)
        if low <= p <= high:
            return bool(abs(x - start - slope * (p - low)) < radius)
    return False


def tube_around(c: Branch, low: Fraction, high: Fraction) -> arb:
    """Enclose the branch's first point for all values of the parameter between two."""
    found = []
    for stretch in _stretches(c):
        if stretch.low <= high and stretch.high >= low:
            for p in (max(stretch.low, low), min(stretch.high, high)):
                found.append(enclosed(stretch.line(p)) + arb(0, enclosed(stretch.radius).upper()))
    return reduce(arb.union, found)


def _stretches(c: Branch) -> Iterator[_Stretch]:
    nodes = [(fraction(p), fraction(d)) for p, d in c.nodes]
    for ((low, start), (high, end)), radius in zip(itertools.pairwise(nodes), c.radii, strict=True):
        yield _Stretch(low, high, start, (end - start) / (high - low), fraction(radius))


def _holds(
    values: dict[str, str], names: tuple[str, ...], c: Branch, tube: _Stretch, strips: int
) -> None:
    """Refuse unless a tube holds one orbit, as stated, for each value of the parameter."""
    middle = (tube.low + tube.high) / 2
    along = arb(0, enclosed(tube.high - middle).upper())
    p, x, slope, radius = (
        enclosed(each) for each in (middle, tube.line(middle), tube.slope, tube.radius)
    )
    still, fixed, varied = (
        Motion(values, **dict.fromkeys(names, each))
        for each in (p, p + along, arb_series([p + along, 1]))
    )

    def strip(x: arb, across: arb) -> tuple[arb, arb]:
        """Return f^p(d) - d along a line and (f^p)' around it; each step on a box of its own."""
        # By the chain rule, derivatives along the line and across it: `varied` has them in the
        # parameter, `fixed` in d.
        points, end, drift, multiplier = [], x, slope, arb(1)
        box = x + slope * along + across
        for word in c.itinerary:
            points.append(box)
            told, value = fixed.series(box)
            if told != word:
                raise Refused(f"the itinerary is stated as {word!r} and is {told!r}")
            _, end, _ = still.step(end)
            _, push = varied.series(arb_series([box]))
            drift = value[1] * drift + push[1]
            multiplier = value[1] * multiplier
            box = value[0].intersection(end + drift * along + multiplier * across)
        ordered = sorted(points, key=arb.mid)
        if any(a.overlaps(b) for a, b in itertools.pairwise(ordered)):
            raise Refused("two points of the orbit are not told apart")
        if not (abs(multiplier) < 1 if c.stable else abs(multiplier) > 1):
            told = multiplier.str(5)
            raise Refused(f"stable is stated as {c.stable}, the multiplier is {told} in the tube")
        return end - x + (drift - slope) * along, multiplier

    across = arb(0, (radius / strips).upper())
    miss, multiplier = strip(x, across)
    for k in range(1, strips // 2 + 1):
        for sign in (1, -1):
            multiplier = multiplier.union(strip(x + sign * 2 * k * radius / strips, across)[1])
    # f^p(d) - d is monotone across the tube, and has opposite signs on its two sides.
    if not abs(miss) < radius * abs(multiplier - 1):
        raise Refused("the orbit is not shown to be in the tube")
