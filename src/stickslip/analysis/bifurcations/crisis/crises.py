"""Crises and mergings of bands: where chaotic attractors end, jump in size or join their bands.

There an image of a critical point meets an unstable orbit beside the attractor (Grebogi, Ott and
Yorke, Physica D 7, 181, 1983); a zero counts if the attractors on both its sides confirm it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from heapq import heappop, heappush
from itertools import chain, islice
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.accounting import BESIDE, Look, may_be_asked, of_cascade
from stickslip.analysis.bifurcations.conditions.conditions import Condition, Connection, Contact
from stickslip.analysis.bifurcations.conditions.locate import Located, MapAt, found_near, solve_near
from stickslip.analysis.bifurcations.crisis.comparison import (
    KINDS,
    Change,
    CrisisKind,
    ParameterPoint,
    changes,
    is_of_doublings,
    kind_of_change,
    parameter_point,
    partner_of,
    ratio_of,
)
from stickslip.analysis.bifurcations.crisis.unstable_neighbours import (
    Meeting,
    borders_beside,
    edges_of,
    late,
    meetings,
    on_border,
)
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.maps.protocol import domain_width

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor


NUDGES: Final = (1.0, 8.0, 0.1)  # times that, where windows or transients are in the way
NEARER: Final = 0.2  # of the distance at which a meeting was refuted, to look at it again
FINEST: Final = 1e-3  # of a grid interval: parts of it are halved down to this width
SHARES: Final = (0.5, 0.57, 0.41)  # of an interval: where it is cut, outside windows if possible
SHORT: Final = 0.25  # of an interval: distance of an event beyond its end that sets a scale
LONG_WINDOW: Final = 128.0  # ... or this many times that, between two of long period
UNLIKELY: Final = 16.0  # ... or this many times that, towards windows of long period
MEETINGS: Final = 8  # of edges with orbits beside them that are tried, the closest first
LOOKS: Final = 96  # values between two of the grid at which attractors are found, about
GLANCE: Final = 1e-4  # of an interval: step that tells where an edge and an orbit move
OVERSHOOT: Final = 3.0  # intervals: meetings foretold further away are not tried
CLEAR: Final = 100  # errors of a value to where its sides are looked at
STEP: Final = 0.2  # of the way to a meeting: how well it is foretold
TOUCHING: Final = 1e-8  # of the domain's width: an edge this close to an orbit meets it


Sides: TypeAlias = tuple[ParameterPoint, ParameterPoint]


@dataclass(frozen=True, eq=False)
class CrisisEvent:
    """A chaotic attractor that is lost, or changes suddenly, at a parameter value."""

    kind: CrisisKind
    located: Located
    attractor: Attractor  # that changes
    sides: Sides  # just below and just above `value`

    @property
    def value(self) -> float:
        """Of the parameter."""
        return self.located.value

    @property
    def condition(self) -> Condition:
        """A `Connection` or `Contact`, started from here."""
        return self.located.reading.condition

    @property
    def points(self) -> tuple[float, ...]:
        """The unstable orbit that is met, the point that is met first; or the break met."""
        return self.located.reading.points

    @property
    def attractors_before(self) -> tuple[Attractor, ...]:
        """All attractors just below, without transients: what is undecided beside a crisis."""
        return tuple(a for a in self.sides[0].attractors if a.kind != "undecided")

    @property
    def attractors_after(self) -> tuple[Attractor, ...]:
        """All attractors just above."""
        return tuple(a for a in self.sides[1].attractors if a.kind != "undecided")

    def same_as(self, other: CrisisEvent) -> bool:
        """Tell whether two events are one: twins change at one value, each with its own orbit."""
        if abs(self.value - other.value) > self.located.error + other.located.error:
            return False
        one, two = np.sort(self.points), np.sort(other.points)
        met = len(one) == len(two) and np.abs(one - two).max() <= TOUCHING * np.ptp(
            self.attractor.bands
        )
        return bool(met) or partner_of(self.attractor, [other.attractor]) is not None


@dataclass(frozen=True, eq=False)
class CrisesFound:
    """Events between values of a grid, and pairs of looks with mergings of bands between them."""

    events: list[CrisisEvent] = field(default_factory=list)
    left_open: list[Sides] = field(default_factory=list)  # too many looks were needed
    too_close: list[Sides] = field(default_factory=list)  # closer together than is searched for
    looks: list[Look] = field(default_factory=list)  # between those of the grid


@dataclass(frozen=True)
class _Ahead:
    """A condition that will be met after some way, as its value and slope foretell."""

    condition: Condition
    way: float
    slope: float


def _leaves(
    located: Located, attractor: Attractor, near: ParameterPoint, far: ParameterPoint
) -> bool:
    """Tell whether an edge beyond what it has met goes elsewhere for good."""
    try:
        (*_, x) = located.reading.condition.at(far.f).path
    except ConditionLost:
        return True  # the domain
    lo, hi = far.f.domain
    if not lo <= x <= hi:
        return True
    orbit = late(far.fast, x)
    bands = partner_of(attractor, near.attractors)
    return bands is None or not bands.contains(orbit[np.isfinite(orbit)]).any()


class CrisisSearch:
    """A search for crises and band mergings, the widest of the intervals that wait first.

    What changes across ``breaks``, values of known bifurcations, is their doing.
    """

    def __init__(
        self, at: MapAt, breaks: Sequence[float] = (), max_period: int = 4, looks: int = LOOKS
    ) -> None:
        self.given = at, breaks, max_period, looks
        self.at, self.max_period, self.looks_left = at, max_period, looks
        self.breaks = np.unique(np.array(breaks, dtype=np.float64))
        self.found = CrisesFound()
        self.waiting: list[tuple[float, float, ParameterPoint, ParameterPoint]] = []
        # By value, attractor, and whether the border of its basin was followed.
        self.foretold: dict[tuple[float, float, bool], list[_Ahead]] = {}
        self.refuted: dict[tuple[float, float], list[tuple[Located, float]]] = {}  # and how near

    def parts(self, intervals: Sequence[Sides]) -> list[Callable[[], CrisesFound]]:
        """Return the searches of intervals, each for any process."""
        return [partial(CrisisSearch(*self.given).interval, *ends) for ends in intervals]

    def joined(self, intervals: Sequence[Sides], parts: Iterable[CrisesFound]) -> CrisesFound:
        """Join what ascending intervals have, each event once, with what is at the ends of all."""
        for found in parts:
            self.found.left_open.extend(found.left_open)
            self.found.too_close.extend(found.too_close)
            self.found.looks.extend(found.looks)
            for event in found.events:
                self.keep(event)
        (first, second), (last_but_one, last) = intervals[0], intervals[-1]
        self.at_end(first, first.value - second.value)
        self.at_end(last, last.value - last_but_one.value)
        return replace(self.found, events=sorted(self.found.events, key=lambda e: e.value))

    def _look(self, value: float) -> ParameterPoint:
        self.looks_left -= 1
        point = parameter_point(self.at, value, quick=True)
        self.found.looks.append(Look(point.value, point.attractors, quick=True))
        return point

    def interval(self, left: ParameterPoint, right: ParameterPoint) -> CrisesFound:
        """Find the events between two values of the grid."""
        smallest = FINEST * (right.value - left.value)
        self._wait(left, right)
        while self.waiting and self.looks_left > 0:
            *_, left, right = heappop(self.waiting)
            self._explain(left, right, smallest)
        for *_, left, right in self.waiting:
            if any(map(self._merges, changes(left, right))):
                self.found.left_open.append((left, right))
        return self.found

    def _wait(self, left: ParameterPoint, right: ParameterPoint) -> None:
        if right.value > left.value and (changes(left, right) or self._windows(left, right)):
            heappush(self.waiting, (left.value - right.value, left.value, left, right))

    def _windows(self, left: ParameterPoint, right: ParameterPoint) -> list[int]:
        """List periods of long stable cycles that may stand for chaos between: no end shows it."""
        one, two = ({a.period for a in p.attractors if a.kind == "periodic"} for p in (left, right))
        return [
            period
            for periods, others in ((one, two), (two, one))
            for period in periods - others
            if period > self.max_period
            and not any(is_of_doublings(ratio_of(period, other)) for other in others)
        ]

    def _explain(self, left: ParameterPoint, right: ParameterPoint, smallest: float) -> None:
        """Find the event that comes first, or cut the interval in two."""
        seen = changes(left, right)
        width = right.value - left.value
        worths = [self._worth(change) for change in seen]
        # Where a cycle alone hints at chaos, that may be of a cascade asked for.
        windows = self._windows(left, right)
        worths += [1.0 if of_cascade(n, self.max_period) else LONG_WINDOW for n in windows]
        narrow = width <= smallest * min(worths)
        for change in seen:
            event = self._event(change, BESIDE * width, narrow)
            if event is None:
                continue
            below, above = event.sides
            self.keep(event)
            for twin in changes(below, above):
                if partner_of(twin.attractor, [event.attractor]) is None:
                    same = self._event(twin, BESIDE * width, narrow)
                    if same is not None:
                        self.keep(same)
            if change.start is left:
                self._wait(above, right)
            else:
                self._wait(left, below)
            return
        if not narrow:
            self._cut(left, right, min(seen, key=self._room, default=None))
        elif any(map(self._merges, seen)):
            self.found.too_close.append((left, right))

    def _cut(self, left: ParameterPoint, right: ParameterPoint, change: Change | None) -> None:
        """Cut at a known bifurcation, leaving out what it does, or else between."""
        inside = self.breaks[(self.breaks > left.value) & (self.breaks < right.value)]
        if not inside.size:
            middle = self._look_between(left, right, change)
            self._wait(left, middle)
            self._wait(middle, right)
            return
        at = float(inside[len(inside) // 2])
        others = np.append(inside[inside != at], [left.value, right.value])
        beside = BESIDE * float(np.min(np.abs(others - at)))
        if beside > 4 * np.spacing(abs(at)):
            self._wait(left, self._look(at - beside))
            self._wait(self._look(at + beside), right)

    def _look_between(
        self, left: ParameterPoint, right: ParameterPoint, change: Change | None
    ) -> ParameterPoint:
        """Look at the middle, or beside it if a narrow window of long period is there."""
        # Such a window hides the chaos around it, from either side.
        for share in SHARES:
            middle = self._look(self._place(left, right, change, share))
            seen = changes(left, middle) + changes(middle, right)
            if not any(c.stop is middle and self._ends_in_window(c) for c in seen):
                break
        return middle

    def _place(
        self, left: ParameterPoint, right: ParameterPoint, change: Change | None, share: float
    ) -> float:
        """Return a value between; of logarithms where an attractor is lost beside an event."""
        # It is lost at any distance of the event's own scale or more.
        width = right.value - left.value
        scale = np.inf if change is None else self._room(change) / width
        if change is None or scale >= SHORT:
            return left.value + share * width
        way = width * scale**share
        return right.value - way if change.start is right else left.value + way

    def _room(self, change: Change) -> float:
        """Return how far beyond an attractor that is lost the next known bifurcation is."""
        if change.partner is not None:
            return np.inf
        off = (self.breaks - change.start.value) * np.sign(change.start.value - change.stop.value)
        return float(np.min(off[off > 0], initial=np.inf))

    def _worth(self, change: Change) -> float:
        """Say how far to halve an interval in which an attractor changes: a factor of `finest`."""
        # Only chaos that holds cycles asked for, or of their cascades, is searched thoroughly.
        if not change.certain:
            return np.inf
        asked = may_be_asked(change.attractor.lowest_period, self.max_period)
        return 1.0 if asked and not self._in_long_window(change) else UNLIKELY

    def _in_long_window(self, change: Change) -> bool:
        """Whether periods are those of chaos and of a window in it, of many turns."""
        whole = change.ratio.denominator == 1 and change.ratio > self.max_period
        return whole and not change.is_of_doublings

    def _ends_in_window(self, change: Change) -> bool:
        """Whether what is there instead is of a window, of this chaos or of other."""
        longer = change.period_there > change.attractor.period
        apart = change.ratio.denominator > 1 or self._in_long_window(change)
        return longer and apart

    def _merges(self, change: Change) -> bool:
        """Whether bands merge between: no more than the last ones of a cascade may be left out."""
        asked = may_be_asked(change.attractor.lowest_period, self.max_period)
        apart = change.ratio.denominator > 1 or change.is_of_doublings
        return change.certain and asked and change.ratio > 1 and apart

    def _event(self, change: Change, beside: float, narrow: bool) -> CrisisEvent | None:
        """Return an event that the attractors on both sides confirm."""
        start, stop = change.start, change.stop
        refuted = self.refuted.setdefault((start.value, change.attractor.point), [])
        borders = (False, True) if narrow or change.partner is None else (False,)
        for zero in chain.from_iterable(self._ahead(change, border) for border in borders):
            located = self._solved(zero, start, stop)
            if located is None or any(
                abs(located.value - known.value) <= known.error and NEARER * near < beside
                for known, near in refuted
            ):
                continue
            upwards = start.value < stop.value
            # Beyond the start the attractor need not be this one.
            room = 0.5 * min(abs(located.value - end.value) for end in (start, stop))
            aside = min(beside, room / max(NUDGES))
            event = self._confirmed(located, change.attractor, upwards, aside)
            if event is not None:
                return event
            refuted.append((located, beside))
        return None

    def _confirmed(
        self, located: Located, attractor: Attractor, upwards: bool, beside: float
    ) -> CrisisEvent | None:
        """Look at the attractors on both sides, further away if something hides them."""
        last = None
        for nudge in NUDGES:
            aside = max(nudge * beside, CLEAR * located.error)
            below, above = self._look(located.value - aside), self._look(located.value + aside)
            near, far = (below, above) if upwards else (above, below)
            kind = kind_of_change(attractor, near, far)
            if kind in KINDS:
                return CrisisEvent(kind, located, attractor, (below, above))
            if kind is None:
                return None
            # Transients beside a boundary crisis live long, but the attractor is gone.
            left = kind == "transient" and _leaves(located, attractor, near, far)
            if left or kind == "window":
                last = CrisisEvent("boundary_crisis", located, attractor, (below, above))
            elif kind == "several" and isinstance(located.reading.condition, Contact):
                # A break may join many bands at once, an orbit joins two and two.
                last = CrisisEvent("band_merging", located, attractor, (below, above))
        return last

    def _ahead(self, change: Change, border: bool) -> list[_Ahead]:
        """Where edges will meet the orbits beside them if they go on as they start, in order."""
        width = change.stop.value - change.start.value
        key = change.start.value, change.attractor.point, border
        if key not in self.foretold:
            self.foretold[key] = list(self._foretold(change, GLANCE * width, border))
        found = [zero for zero in self.foretold[key] if 0 <= zero.way / width <= OVERSHOOT]
        return sorted(found, key=lambda zero: abs(zero.way))

    def _foretold(self, change: Change, step: float, border: bool) -> Iterator[_Ahead]:
        """Where edges will meet the orbits beside them, either way, as one step foretells."""
        start = change.start
        try:
            beside = self.at(start.value + step)
        except ValueError:
            return  # the family ends there
        met: Iterable[Meeting] = self._meetings(change.attractor, start)
        if border:  # the orbits on the border of the basin beside its edges
            edges = edges_of(change.attractor, start.table)
            met = islice(on_border(start.fast, change.attractor, edges), MEETINGS)
        for item in met:
            try:
                here = item.condition.at(start.f)
                there = here.condition.at(beside)
            except ConditionLost:
                continue
            slope = (there.value - here.value) / step
            if slope != 0:
                yield _Ahead(there.condition, -here.value / slope, slope)

    def _solved(self, zero: _Ahead, start: ParameterPoint, stop: ParameterPoint) -> Located | None:
        low, high = sorted((start.value, stop.value))
        guess = min(max(start.value + zero.way, low), high)
        how = {"step": STEP * abs(zero.way), "slope": zero.slope, "within": (low, high)}
        located = found_near(zero.condition, self.at, guess, **how)
        # Both sides are looked at beyond the error: they must lie in the family.
        return located if located and CLEAR * located.error < high - low else None

    def _meetings(self, attractor: Attractor, point: ParameterPoint) -> Iterator[Meeting]:
        """Yield edges of an attractor with unstable orbits beside them, the closest first."""
        periods = {*range(1, self.max_period + 1), attractor.period}
        if attractor.period % 2 == 0:
            periods.add(attractor.period // 2)
        edges = edges_of(attractor, point.table)
        yield from islice(meetings(point.fast, edges, tuple(sorted(periods))), MEETINGS)
        yield from borders_beside(point.table, edges)

    def at_end(self, point: ParameterPoint, width: float) -> None:
        """Look for an event exactly at the first or last value; outwards is where width points."""
        for attractor in point.chaotic:
            for item in self._meetings(attractor, point):
                if abs(item.x - item.edge.x) > TOUCHING * domain_width(point.f):
                    continue
                event = self._just_here(item.condition, attractor, point, width)
                if event is not None and self.keep(event):
                    return

    def _just_here(
        self,
        condition: Connection | Contact,
        attractor: Attractor,
        point: ParameterPoint,
        width: float,
    ) -> CrisisEvent | None:
        """Return the event of a condition that holds at a value, if that is one."""
        try:
            beside = BESIDE * abs(width)
            located = solve_near(condition, self.at, point.value, step=beside)
            if abs(located.value - point.value) > located.error:
                return None
            return self._confirmed(located, attractor, width > 0, beside)
        except (ConditionLost, ValueError):
            return None  # the family may end here, too

    def keep(self, event: CrisisEvent) -> bool:
        """Add an event unless it is there already; tell which."""
        new = not any(event.same_as(known) for known in self.found.events)
        if new:
            self.found.events.append(event)
        return new
