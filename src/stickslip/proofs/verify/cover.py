"""Check what is claimed of all starts: complete lists over a parameter's interval, and basins."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, Final

from flint import arb, arb_series

from stickslip.proofs.verify.branch import check_branch, tube_around
from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import (
    Attractor,
    Basins,
    Curves,
    Refused,
    check_apart,
    enclosed,
    followed,
    fraction,
    halved,
    middle_of,
)

FINEST: Final = 13  # halvings of the parameter's interval
NARROW: Final = 1e-7  # interval of d at which the part is halved instead
CUTS: Final = 24  # halvings of a cell, or of an interval that is attracted
WEIGHT: Final = 8  # of the parameter's interval beside one of d: the wider one is halved
MOST_IMAGES: Final = 64  # of an interval: more are of no use


class System:
    """The motions of a system whose parameter lies between two values; or has one."""

    coarse = 1e-2  # wider intervals are halved before possibilities are listed

    def __init__(
        self, values: dict[str, str], names: Sequence[str], span: tuple[Fraction, Fraction] | None
    ) -> None:
        self._values, self._names, self.span = values, names, span
        if span is None:
            self.still = self.all = Motion(values)
            self.reach = arb(0)
            return
        middle, half = enclosed((span[0] + span[1]) / 2), enclosed((span[1] - span[0]) / 2)
        self.reach = arb(0, half.upper() + middle.rad())
        between = middle.mid() + self.reach
        self.still, self.all, self._varied = (
            Motion(values, **dict.fromkeys(names, p))
            for p in (middle.mid(), between, arb_series([between, 1]))
        )

    @property
    def width(self) -> Fraction:
        """Width of the span."""
        return self.span[1] - self.span[0] if self.span else Fraction(0)

    @cached_property
    def halves(self) -> tuple[System, System]:
        """Cut the span in two."""
        assert self.span
        low, high = self.span
        spans = (low, (low + high) / 2), ((low + high) / 2, high)
        first, second = (System(self._values, self._names, span) for span in spans)
        return first, second

    def step(self, d: arb) -> tuple[str, arb, arb]:
        """Return itinerary, value and derivative in d, for all d and parameters: one outcome."""
        word, value, slope = self.all.step(d)
        if not self.span:
            return word, value, slope
        centre = self.still.step(d.mid())[1]
        _, push = self._varied.series(arb_series([d]))
        centre = centre + push[1] * self.reach
        return word, value.intersection(centre + slope * (d - d.mid())), slope

    def outcomes(self, d: arb) -> Iterator[tuple[str, arb, arb]]:
        """Yield itinerary, next d and its derivative: all that is possible from a ball."""
        return self.all.outcomes(d)


def possible(system: Any, d: arb) -> list[tuple[arb, arb]]:
    """Enclose all next values that are possible, and slopes."""
    try:
        return [system.step(d)[1:]]
    except Refused:
        if d.rad() > system.coarse:
            raise
        return [(value, slope) for _, value, slope in system.outcomes(d)]


def check_curves(values: dict[str, str], names: tuple[str, ...], c: Curves) -> None:
    """Refuse unless the branches hold, no two meet, and there is no other orbit."""
    for branch in c.branches:
        check_branch(values, names, branch)
    low, high = map(fraction, c.range)
    waiting = [(System(values, names, (low, high)), FINEST)]
    while waiting:
        system, left = waiting.pop()
        try:
            _complete(system, c)
        except Refused:
            if not left:
                raise
            waiting += [(half, left - 1) for half in system.halves]


def _complete(system: System, c: Curves) -> None:
    """Refuse unless, for all parameters of a system, the branches hold all orbits."""
    assert system.span
    orbits = []
    for branch in c.branches:
        points, *_ = followed(system, tube_around(branch, *system.span), branch.itinerary)
        orbits.append((branch.period, points))
    check_apart([x for _, points in orbits for x in points], "two orbits are not told apart")
    where = f", {c.parameter} = {float(system.span[0]):.12g}"
    for period in range(1, c.max_period + 1):
        roots = [x for p, points in orbits if period % p == 0 for x in points]
        check_no_other(system, system.all.boxes(32), period, roots, NARROW, where)


def check_no_other(
    system: Any,
    waiting: list[arb],
    period: int,
    roots: Sequence[arb],
    narrowest: float,
    where: str = "",
    stated: Sequence[arb] = (),
) -> None:
    """Refuse unless intervals hold no orbit of a period but those through balls, the `roots`.

    And but those in intervals that are stated to be undecided.
    """
    while waiting:
        box = waiting.pop()
        if any(s.contains(box) for s in stated) or _no_other(system, box, period, roots):
            continue
        if box.rad() < narrowest:
            raise Refused(
                f"an orbit of period {period} may have been missed near d = {box.str(12)}{where}: "
                "this program cannot tell, and disproves nothing"
            )
        waiting += halved(box)


def _no_other(system: Any, box: arb, period: int, roots: Sequence[arb]) -> bool:
    """Whether an interval holds no orbit of a period besides those through some balls."""
    any_word = [None] * period
    near = next((root for root in roots if root.overlaps(box)), None)
    try:
        _, value, slope = followed(system, box if near is None else box.union(near), any_word)
        if near is None and not value.overlaps(box):
            return True
        if (slope - 1).contains(0):
            return False
        if near is not None:  # the two together hold one: f^p(d) - d is monotone
            return True
        middle = box.mid()
        _, end, _ = followed(system, middle, any_word)
        return not (middle - (end - middle) / (slope - 1)).overlaps(box)
    except Refused:
        return near is None and bool(box.rad() < system.coarse) and _leaves(system, box, period)


def _leaves(system: Any, box: arb, period: int) -> bool:
    """Whether no itinerary that is possible leads back into an interval."""
    balls = [box]
    try:
        for _ in range(period):
            balls = [value for x in balls for _, value, _ in system.outcomes(x)]
            if len(balls) > MOST_IMAGES:
                return False
    except Refused:
        return False
    return not any(value.overlaps(box) for value in balls)


def check_basins(values: dict[str, str], names: tuple[str, ...], c: Basins) -> None:
    """Refuse unless each cell goes to what was proven before it, and this makes the shares."""
    span = (fraction(c.range[0]), fraction(c.range[1])) if c.range else None
    system = System(values, names, span)
    end = system.all.end
    for low, high in (*(a.interval for a in c.attractors), *(cell[:2] for cell in c.cells)):
        if not (-end <= enclosed(fraction(low)) and enclosed(fraction(high)) <= end):
            raise Refused(f"[{low}, {high}] is not in the domain")
    covered = []
    intervals: list[arb] = []
    for attractor in c.attractors:
        ends = fraction(attractor.interval[0]), fraction(attractor.interval[1])
        points = _attracted(system, attractor, ends)
        # One orbit listed twice would pass through an interval before.
        check_apart([*intervals, *points], "two points are not told apart, of one orbit or of two")
        intervals.append(points[0])
        covered.append(Union(*ends))
    for low, high, k in c.cells:
        ends = fraction(low), fraction(high)

        def goes(system: System, box: arb, union: Union = covered[k]) -> None:
            if not all(union.holds(value) for value, _ in possible(system, box)):
                raise Refused(
                    f"d = {box.str(12)} is not shown to be mapped into what is proven before it"
                )

        everywhere(goes, system, ends)
        covered[k].add(*ends)
    for union, attractor in zip(covered, c.attractors, strict=True):
        if not enclosed(union.length) >= 2 * end * enclosed(fraction(attractor.share)):
            raise Refused(f"the share is stated as {attractor.share}, and is not proven")


def _attracted(
    system: System,
    c: Attractor,
    ends: tuple[Fraction, Fraction],
) -> list[arb]:
    """Return where an interval goes in a period; refuse unless f^period contracts it into it."""
    inside = Union(*ends)
    passed: list[arb] = []

    def contracts(system: System, x: arb) -> None:
        points, end, slope = followed(system, x, c.itinerary)
        if not abs(slope) < 1:
            raise Refused(f"the interval is not contracted: the derivative is {slope.str(5)}")
        if not inside.holds(end):
            raise Refused("the interval is not mapped into itself")
        passed[:] = [a.union(b) for a, b in zip(passed, points, strict=True)] if passed else points

    everywhere(contracts, system, ends)
    return passed


def everywhere(
    test: Callable[[System, arb], None],
    system: System,
    ends: tuple[Fraction, Fraction],
) -> None:
    """Refuse what a test refuses on an interval of d, however finely it and the span are cut."""
    waiting = [(system, ends, CUTS)]
    while waiting:
        system, (low, high), left = waiting.pop()
        try:
            test(system, enclosed(low).union(enclosed(high)))
        except Refused:
            if not left:
                raise
            if WEIGHT * system.width > high - low:
                waiting += [(half, (low, high), left - 1) for half in system.halves]
            else:
                middle = (low + high) / 2
                waiting += [(system, pair, left - 1) for pair in ((low, middle), (middle, high))]


class Union:
    """A union of closed intervals, kept as disjoint ones in order."""

    def __init__(self, low: Fraction, high: Fraction) -> None:
        self._lows, self._highs = [low], [high]

    @property
    def length(self) -> Fraction:
        """Of all together."""
        return sum((b - a for a, b in zip(self._lows, self._highs, strict=True)), Fraction(0))

    def add(self, low: Fraction, high: Fraction) -> None:
        """Join one more."""
        first = bisect.bisect_left(self._highs, low)  # the first that reaches to the new one
        last = bisect.bisect_right(self._lows, high)
        if first < last:
            low, high = min(low, self._lows[first]), max(high, self._highs[last - 1])
        self._lows[first:last], self._highs[first:last] = [low], [high]

    def holds(self, x: arb) -> bool:
        """Whether a ball is proven to lie in it."""
        if not x.is_finite():
            return False
        low, high = (middle_of(end) for end in (x.lower(), x.upper()))
        k = bisect.bisect_right(self._lows, low) - 1
        return k >= 0 and high <= self._highs[k]
