"""Check a branch: an orbit for every value of a parameter, alone in a tube around a polygon."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from fractions import Fraction
from functools import reduce
from typing import Final, NamedTuple

from flint import arb, arb_series

from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import Branch, Refused, check_apart, enclosed, fraction, halved

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


class _Slanted(NamedTuple):
    """Points d = middle + drift * (parameter's distance) + stretch * (distance across the tube)."""

    middle: arb
    drift: arb
    stretch: arb
    along: arb
    across: arb
    within: arb | None

    @property
    def d(self) -> arb:
        """Enclose all of them."""
        found = self.middle + self.drift * self.along + self.stretch * self.across
        return found if self.within is None else found.intersection(self.within)

    def halves(self) -> list[_Slanted]:
        """Cut whichever side spreads the points more."""
        if (self.drift * self.along).rad() > (self.stretch * self.across).rad():
            return [self._replace(along=half) for half in halved(self.along)]
        return [self._replace(across=half) for half in halved(self.across)]


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

    def rates(box: _Slanted, word: str) -> tuple[arb, arb, arb]:
        """Return the map's range, and its derivatives in d and in the parameter, on a part."""
        # A step of the map that the whole part is too wide for is taken on halves: near a graze.
        waiting, found = [(box, FINEST)], []
        while waiting:
            box, left = waiting.pop()
            q, d = p + box.along, box.d
            try:
                told, value = Motion(values, **dict.fromkeys(names, q)).series(d)
                if told != word:
                    raise Refused(f"the itinerary is stated as {word!r} and is {told!r}")
                series = dict.fromkeys(names, arb_series([q, 1]))
                push = Motion(values, **series).series(arb_series([d]))[1][1]
                found.append((value[0], value[1], push))
            except Refused:
                if not left:
                    raise
                waiting += [(half, left - 1) for half in box.halves()]
        ranges, slopes, pushes = (reduce(arb.union, each) for each in zip(*found, strict=True))
        return ranges, slopes, pushes

    still = Motion(values, **dict.fromkeys(names, p))

    def strip(x: arb, across: arb) -> tuple[arb, arb]:
        """Return f^p(d) - d along a line and (f^p)' around it; each step on a box of its own."""
        points, box = [], _Slanted(x, slope, arb(1), along, across, None)
        for word in c.itinerary:
            points.append(box.d)
            value, rate, push = rates(box, word)
            box = box._replace(
                middle=still.step(box.middle)[1],
                drift=rate * box.drift + push,
                stretch=rate * box.stretch,
                within=value,
            )
        check_apart(points, "two points of the orbit are not told apart")
        multiplier = box.stretch
        if not (abs(multiplier) < 1 if c.stable else abs(multiplier) > 1):
            told = multiplier.str(5)
            raise Refused(f"stable is stated as {c.stable}, the multiplier is {told} in the tube")
        return box.middle - x + (box.drift - slope) * along, multiplier

    across = arb(0, (radius / strips).upper())
    miss, multiplier = strip(x, across)
    for k in range(1, strips // 2 + 1):
        for sign in (1, -1):
            multiplier = multiplier.union(strip(x + sign * 2 * k * radius / strips, across)[1])
    # f^p(d) - d is monotone across the tube, and has opposite signs on its two sides.
    if not abs(miss) < radius * abs(multiplier - 1):
        raise Refused("the orbit is not shown to be in the tube")
