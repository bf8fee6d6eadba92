"""All that happens between two lists of orbits: events located, with lists just beside each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange, found_or_left_out
from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.bifurcations.scan.adding_up import adds_up, flips_at_folds
from stickslip.analysis.bifurcations.scan.break_images import hidden_collisions, same_places
from stickslip.analysis.bifurcations.scan.events import (
    Event,
    Suspect,
    flips_on,
    located,
    suspects_at_end,
)
from stickslip.analysis.bifurcations.scan.near_misses import hidden_folds
from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses
from stickslip.analysis.bifurcations.scan.tracking import Ending, Piece, Span, Way, follow, join
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.mesh import finest
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.maps.protocol import domain_width

BESIDE: Final = 1e-5  # of the range: how far from an event the lists beside it are made
NEARER: Final = 1e-2  # times as far, where these do not add up
SPLIT: Final = 1e-9  # of the range: closer to each other no lists are made
CLEAR: Final = 0.2  # share of the way to the next event that these may take up
FOUND: Final = 1e-7  # of the domain's width: an orbit that arrives is looked up in the list
NARROW: Final = 4e-4  # of the parameter: where a range is narrower, lists keep apart for rounding
NARROWEST: Final = 1e-4  # of the range: an unexplained change is not narrowed down further
MAX_NODES: Final = 1000
FEW: Final = 4  # lists added between two of the grid where breaks accumulate, and each costs much
MOST_CHANGES: Final = 8  # ... and orbits that are not in both lists, which are followed there


@dataclass(eq=False)
class Range:
    """A range of a parameter that is searched for all changes of orbits up to a period."""

    family: Family
    lo: float
    hi: float
    max_period: int
    resolution: float = 0.0  # of the map's tables; 0: `finest`
    crowded: bool = False  # whether breaks accumulate where orbits may pass

    def __post_init__(self) -> None:
        """Make tables as fine as all are, if nothing else is asked."""
        self.resolution = self.resolution or self.finest

    @cached_property
    def finest(self) -> float:
        """Resolution of tables where branches do not crowd."""
        return finest(self.family.at(self.lo))

    @cached_property
    def width(self) -> float:
        """Of the map's domain."""
        return domain_width(self.family.at(self.lo))

    @property
    def scale(self) -> float:
        """Length of the range, or of the narrowest one whose shares rounding leaves clear."""
        return max(self.hi - self.lo, NARROW * max(abs(self.lo), abs(self.hi)))

    @property
    def closest(self) -> float:
        """How close to each other lists are made."""
        return (BESIDE if self.scale > self.hi - self.lo else SPLIT) * self.scale

    def alike(self, event: Event, others: Iterable[Event]) -> Iterator[Event]:
        """Those of other events that are this one, found in another way."""
        return (other for other in others if event.same_as(other, self.scale, self.width))


@dataclass(eq=False)
class Found:
    """What happens between two lists."""

    spans: list[Span] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    unresolved: list[UnresolvedChange] = field(default_factory=list)
    n_nodes: int = 0  # lists that were added


def between(
    whole: Range,
    classes: SymbolClasses,
    at_ends: dict[float, list[Suspect]],
    ends: tuple[Node, Node],
    *,
    n_nodes: int,
    known: Iterable[Event] = (),
) -> Found:
    """Explain what happens between two lists; if that fails, leave them unconnected."""
    left, right = ends
    search = _Between(whole, deepcopy(classes), at_ends, n_nodes, known)
    what = "the changes of orbits"
    found = found_or_left_out(lambda: search.explained(left, right), what, left.q, right.q)
    if isinstance(found, UnresolvedChange):
        all_left, all_right = (list(range(len(node.orbits))) for node in ends)
        return Found([Span(left, right, [], all_left, all_right)], unresolved=[found])
    return found


class _Between:
    """Two lists of orbits, and those that are added between them until nothing is left open."""

    def __init__(
        self,
        whole: Range,
        classes: SymbolClasses,
        at_ends: dict[float, list[Suspect]],
        n_nodes: int,
        known: Iterable[Event],
    ) -> None:
        self.whole, self.family, self.classes = whole, whole.family, classes
        self.found, self.n_nodes, self.known = Found(), n_nodes, list(known)
        self._at_ends = at_ends  # events there are in no list's middle
        self._ways_known: dict[tuple[float, int, int], Way] = {}

    def _node(self, q: float) -> Node:
        """Add a list."""
        node = Node.make(self.family, self.whole.max_period, q)
        self.classes.learn(node.table)
        self.found.n_nodes += 1
        return node

    def explained(self, left: Node, right: Node) -> Found:
        """Explain all that happens between two nodes, by adding nodes if need be."""
        todo = [(left, right)]
        while todo:
            span = join(*todo.pop(), self.family, self.classes)
            fresh, unexplained = self._look(span)
            more = self._may_add(span)
            wide = span.right.q - span.left.q > NARROWEST * self.whole.scale
            if fresh and more:
                todo += self._cut(span, fresh)
            elif more and wide and not all(change.is_outside for change in unexplained):
                middle = self._node(0.5 * (span.left.q + span.right.q))
                todo += [(span.left, middle), (middle, span.right)]
            elif not unexplained and (around := _about(span, fresh)):
                self.found.spans.append(around)
            else:
                self.found.spans.append(span)
                self.found.unresolved += [*unexplained, *self._left_out(span, fresh)]
        return self.found

    def _may_add(self, span: Span) -> bool:
        """Whether another list may be made inside a span."""
        if self.whole.crowded:
            return self.found.n_nodes < FEW and _changes(span) <= MOST_CHANGES
        return self.n_nodes + self.found.n_nodes < MAX_NODES

    def _left_out(self, span: Span, fresh: list[Event]) -> list[UnresolvedChange]:
        """Take events back that no lists may be made beside; say which."""
        found, left_out = self.found, {id(event) for event in fresh}
        found.events = [event for event in found.events if id(event) not in left_out]
        span.endings = [
            replace(ending, event=None) if id(ending.event) in left_out else ending
            for ending in span.endings
        ]
        why = "beside it no list is made, as there are many already"
        return [
            UnresolvedChange(f"a {e.kind}: {why}", e.value, e.value, e.period, float(e.points[0]))
            for e in fresh
        ]

    def _look(self, span: Span) -> tuple[list[Event], list[UnresolvedChange]]:
        """Follow what two lists do not share; return new events, and what none explains."""
        if self.whole.crowded and (n := _changes(span)) > MOST_CHANGES:
            reason = f"less is resolved: {n} orbits begin or end, more than are followed"
            return [], [UnresolvedChange(reason, span.left.q, span.right.q)]
        ways = self._ways(span)
        fresh: list[Event] = []
        unexplained: list[UnresolvedChange] = []
        for piece in span.pieces:
            for suspect in flips_on(piece):
                event = self._located(suspect, span)
                if event is None:
                    reason = "the multiplier passes -1, but no flip is found"
                    unexplained.append(_open(span, piece, reason))
                else:
                    self._add(event, fresh)
            if (np.diff(np.sign(piece.multipliers - 1)) != 0).any():
                unexplained.append(_open(span, piece, "the multiplier passes 1 without a fold"))
        for left, right, way in ways:
            piece = way.piece(left, right)
            event = self._end_of(way, span, fresh)
            if event is not None:
                self._add(event, fresh)
            elif way.arrived:
                reason = "an orbit arrives that the complete list does not contain"
                unexplained.append(_open(span, piece, reason))
            elif way.end.reason != "end of domain":
                unexplained.append(_open(span, piece, f"an orbit ends ({way.end.reason})"))
            span.endings.append(Ending(piece, event, way.end.reason))
        for node in (span.left, span.right):
            for suspect in self._at_ends.get(node.q, []):
                event = self._located(suspect, span)
                if event is not None and event.is_at(node.q):
                    self._add(event, fresh)
        if not (fresh or unexplained):
            unexplained += self._hidden_collisions(span, fresh)
        if not (fresh or unexplained or self.whole.crowded):
            for suspect in hidden_folds(span.left, span.right, self.whole.max_period):
                event = self._located(suspect, span)
                if event is not None:
                    self._add(event, fresh)
        return fresh, unexplained

    def _hidden_collisions(self, span: Span, fresh: list[Event]) -> list[UnresolvedChange]:
        """Find the collisions of orbits that are in neither list; return what is no collision."""
        unexplained = []
        # A crowd has breaks that one list alone tells apart, and values there cost much: what the
        # ends of the span say has to do.
        narrowest = math.inf if self.whole.crowded else BESIDE * self.whole.scale
        for suspect in hidden_collisions(
            span.left, span.right, self.family, self.whole.max_period, self.classes, narrowest
        ):
            event = self._located(suspect, span)
            if event is not None:
                self._add(event, fresh)
                continue
            reason = "an image of a break passes it, but no collision is found"
            assert isinstance(suspect.condition, Collision)
            border = np.array([suspect.condition.border.x])
            unexplained.append(span.open(reason, suspect.condition.period, border, border))
        return unexplained

    def _ways(self, span: Span) -> list[tuple[int | None, int | None, Way]]:
        """Follow the orbits that were not matched; those that arrive become pieces."""
        missing = {-1: set(span.loose_left), 1: set(span.loose_right)}
        todo = [(side, k) for side in (-1, 1) for k in sorted(missing[side])]
        # Those whose way is known in part come first: it ends where the others begin.
        todo.sort(key=lambda item: self._key(span, *item) not in self._ways_known)
        lost: dict[tuple[int, int], Way] = {}
        for side, k in todo:
            if k not in missing[side]:
                continue
            way = self._follow(span, side, k)
            there = self._arrival(way, span.right if side < 0 else span.left)
            if there in missing[-side]:
                left, right = (k, there) if side < 0 else (there, k)
                span.pieces.append(way.piece(left, right))
                missing[side].discard(k)
                missing[-side].discard(there)
                lost.pop((-side, there), None)
            else:
                lost[side, k] = way
        return [(k, None, way) if side < 0 else (None, k, way) for (side, k), way in lost.items()]

    def _key(self, span: Span, side: int, k: int) -> tuple[float, int, int]:
        return (span.left if side < 0 else span.right).q, side, k

    def _follow(self, span: Span, side: int, k: int) -> Way:
        """Follow an orbit of one node of a span towards the other, from as far as is known."""
        start, goal = (span.left, span.right) if side < 0 else (span.right, span.left)
        key = self._key(span, side, k)
        way = follow(start, k, goal.q, self.family, self.classes, self._ways_known.get(key))
        if not (start.telling and goal.telling):
            way = self._ended_at_passed_border(way, start, k, goal)
        self._ways_known[key] = way
        return way

    def _ended_at_passed_border(self, way: Way, start: Node, k: int, goal: Node) -> Way:
        """Where labels do not tell branches apart, an orbit may have passed a break unnoticed."""
        there = self._arrival(way, goal)
        if there is None:
            return way
        before, after = same_places(start.breaks, goal.breaks)
        n = start.orbits[k].period
        old = start.bundle.points[k, :n, None] - start.breaks[before]
        new = goal.bundle.points[there, :n, None] - goal.breaks[after]
        places, passed = np.nonzero((old < 0) != (new < 0))
        if not places.size:
            return way
        breaks = [item for item in goal.table.breakpoints if item.kind != "smooth"]
        off, off_there = old[places[0], passed[0]], new[places[0], passed[0]]
        share = float(off / (off - off_there))
        end = CurveEnd(
            "breakpoint",
            {self.family.name: start.q + share * (goal.q - start.q)},
            goal.orbits[there].points,
            index=int(places[0]),
            side=-1 if off < 0 else 1,
            border=TrackedDiscontinuity.of(breaks[after[passed[0]]]),
        )
        return replace(way, end=end, gone=tuple(np.unique(places).tolist()))

    def _arrival(self, way: Way, node: Node) -> int | None:
        """Place of an orbit that has arrived in the list there."""
        if not way.arrived:
            return None
        points = way.end.points
        return node.find(np.roll(points, -int(np.argmin(points))), FOUND * node.width)

    def _end_of(self, way: Way, span: Span, fresh: list[Event]) -> Event | None:
        """Find the event that ends an orbit's way: a known one, or one to solve for."""
        for suspect in suspects_at_end(way, self.family):
            found = self._located(suspect, span)
            if found is not None:
                return next(self.whole.alike(found, fresh), found)
        return None

    def _located(self, suspect: Suspect, span: Span) -> Event | None:
        """Solve for an event of a span, or a little beyond, where it may be a known one."""
        pad = 2 * BESIDE * self.whole.scale
        within = max(span.left.q - pad, self.whole.lo), min(span.right.q + pad, self.whole.hi)
        return located(suspect, self.family, within)

    def _add(self, event: Event, fresh: list[Event]) -> None:
        """Remember an event unless it is known."""
        if not any(self.whole.alike(event, [*self.known, *self.found.events])):
            self.found.events.append(event)
            fresh.append(event)

    # ------------------------------------------------------------------ around events

    def _cut(self, span: Span, fresh: list[Event]) -> list[tuple[Node, Node]]:
        """Put nodes on both sides of new events; return the spans between them."""
        place = partial(_place, span)
        groups = self._groups(fresh, place)
        bounds = [span.left.q, *(place(group[0]) for group in groups), span.right.q]
        nodes: dict[tuple[int, int], Node] = {}
        for k, group in enumerate(groups):
            rooms = bounds[k + 1] - bounds[k], bounds[k + 2] - bounds[k + 1]
            for side, room in enumerate(rooms):
                if room > self.whole.closest:  # or it has its list, as at an end of the range
                    beside = min(BESIDE * self.whole.scale, CLEAR * room)
                    q = place(group[-1]) + beside if side else place(group[0]) - beside
                    nodes[k, side] = self._node(q)
        plain: list[tuple[Node, Node]] = []
        last = span.left
        for k, group in enumerate(groups):
            before, after = nodes.get((k, 0), last), nodes.get((k, 1), span.right)
            around = self._adding_up(self._around(before, after, group))
            self.found.spans.append(around)
            plain += [(last, before), (before, around.left), (around.right, after)]
            last = after
        plain.append((last, span.right))
        return [(left, right) for left, right in plain if left is not right]

    def _around(self, before: Node, after: Node, events: list[Event]) -> Span:
        """Join the lists beside events: what does not cross is what these concern."""
        return replace(join(before, after, self.family, self.classes), events=events)

    def _adding_up(self, around: Span) -> Span:
        """Return a span about events, narrower if others are so close that it does not add up."""
        first, last = (_place(around, around.events[k]) for k in (0, -1))
        rooms = first - around.left.q, around.right.q - last
        beside = min((room for room in rooms if room > self.whole.closest), default=0.0)
        spans = [around]
        while not adds_up(spans[-1]):
            if self.whole.crowded or not self._may_add(around):
                return around
            if beside < self.whole.closest:
                return next(filter(None, map(self._with_flips, reversed(spans))), around)
            left, right = (
                self._node(q) if 2 * beside < room else node  # clearly nearer
                for q, room, node in (
                    (first - beside, rooms[0], around.left),
                    (last + beside, rooms[1], around.right),
                )
            )
            spans.append(self._around(left, right, around.events))
            nearer = max(NEARER * beside, self.whole.closest)
            beside = nearer if 2 * nearer < beside else 0.0
        return spans[-1]

    def _with_flips(self, span: Span) -> Span | None:
        """Return a span with the flips that are closer to its folds than lists; None if no use."""
        found = [
            event
            for suspect in flips_at_folds(span)
            if (event := self._located(suspect, span))
            and abs(event.value - suspect.guess) <= suspect.reach + event.located.error
        ]
        events = sorted([*span.events, *found], key=lambda event: event.value)
        span = replace(span, events=events)
        if not adds_up(span):
            return None
        self.found.events += found
        return span

    def _groups(self, fresh: list[Event], place: Callable[[Event], float]) -> list[list[Event]]:
        """Events in ascending order, those that no list can be made between together."""
        groups: list[list[Event]] = []
        for event in sorted(fresh, key=lambda item: item.value):
            if groups:
                last = groups[-1][-1]
                errors = last.located.error + event.located.error
                if place(event) - place(last) <= max(8 * errors, self.whole.closest):
                    groups[-1].append(event)
                    continue
            groups.append([event])
        return groups


def _place(span: Span, event: Event) -> float:
    """Value of an event; by its error it may lie a little beyond the span: lists keep order."""
    return min(max(event.value, span.left.q), span.right.q)


def _about(span: Span, fresh: list[Event]) -> Span | None:
    """Return a span about its only event where both its lists tell of no other; None if not so."""
    inside = len(fresh) == 1 and span.left.q < fresh[0].value < span.right.q
    if not inside or any(ending.event is not fresh[0] for ending in span.endings):
        return None
    crossing = ({piece.left for piece in span.pieces}, {piece.right for piece in span.pieces})
    loose = [
        [k for k in places if k not in there]
        for places, there in zip((span.loose_left, span.loose_right), crossing, strict=True)
    ]
    around = replace(span, events=fresh, endings=[], loose_left=loose[0], loose_right=loose[1])
    return around if adds_up(around) else None


def _changes(span: Span) -> int:
    """How many orbits begin or end in a span."""
    return len(span.loose_left) + len(span.loose_right)


def _open(span: Span, piece: Piece, reason: str) -> UnresolvedChange:
    return span.open(reason, piece.period, piece.points[0], piece.points[-1])
