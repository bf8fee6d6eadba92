"""A range of a parameter surveyed: complete lists, all their orbits joined, every change explained.

Each located event gets lists just below and above: nothing is born or lost without being noticed.
"""

from __future__ import annotations

import math
from bisect import insort
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange, attempted
from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.bifurcations.scan.break_images import hidden_collisions, same_places
from stickslip.analysis.bifurcations.scan.events import (
    SAME_VALUE,
    Event,
    Suspect,
    flips_on,
    in_the_middle,
    located,
    suspects_at_end,
)
from stickslip.analysis.bifurcations.scan.near_misses import (
    NearZero,
    hidden_values,
    near_zeros,
    zeros_at_end,
)
from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses
from stickslip.analysis.bifurcations.scan.tracking import Piece, Way, follow, join
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.table import RESOLUTION, branch_table, tables_complete_above
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.maps.protocol import domain_width
from stickslip.analysis.work import Work, in_threads

if TYPE_CHECKING:
    from collections.abc import Sequence
    from contextlib import AbstractContextManager

BESIDE: Final = 1e-5  # of the range: how far from an event the lists beside it are made
SPLIT: Final = 1e-9  # of the range: closer to each other no lists are made
CLEAR: Final = 0.2  # share of the way to the next event that these may take up
FOUND: Final = 1e-7  # of the domain's width: an orbit that arrives is looked up in the list
NARROW: Final = 4e-4  # of the parameter: where a range is narrower, lists keep apart for rounding
NARROWEST: Final = 1e-4  # of the range: an unexplained change is not narrowed down further
SECOND_LOOKS: Final = 2  # rounds of lists added where a pair of events may hide
MAX_NODES: Final = 1000
MAX_CROWDED: Final = 60  # ... where breaks accumulate, and each list costs much
JITTER: Final = 0.11  # of a spacing: values of a grid keep away from round numbers
GOLDEN: Final = 0.6180339887498949


@dataclass(frozen=True, eq=False)
class Ending:
    """An orbit that does not reach the other end of a span."""

    piece: Piece  # as far as it was followed
    event: Event | None  # what ended it
    reason: str  # see `CurveEnd`


@dataclass(eq=False)
class Span:
    """What lies between two neighbouring nodes."""

    left: Node
    right: Node
    # at one value of the parameter; empty for a span between events
    events: list[Event] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)  # orbits that cross the span
    # where there are events, or no explanation: places of orbits that do not cross
    loose_left: list[int] = field(default_factory=list)
    loose_right: list[int] = field(default_factory=list)
    # between events: orbits that leave the window there, or end unexplained
    endings: list[Ending] = field(default_factory=list)


class Survey:
    """The range of a parameter, cut into spans without and around events, both ascending."""

    def __init__(
        self,
        family: Family,
        lo: float,
        hi: float,
        max_period: int,
        work: Work | None = None,
    ) -> None:
        self.family, self.lo, self.hi, self.max_period = family, lo, hi, max_period
        self.work = Work() if work is None else work
        self.width = domain_width(family.at(lo))
        self.classes = SymbolClasses()
        self.spans: list[Span] = []
        self.events: list[Event] = []
        self.unresolved: list[UnresolvedChange] = []
        self.grid_nodes: list[Node] = []
        self.n_nodes = 0
        self.resolution = RESOLUTION  # of the map's tables
        self._known: dict[tuple[float, int, int], Way] = {}
        self._at_ends: dict[float, list[Suspect]] = {}  # events there are in no list's middle

    @property
    def scale(self) -> float:
        """Length of the range, or of the narrowest one whose shares rounding leaves clear."""
        return max(self.hi - self.lo, NARROW * max(abs(self.lo), abs(self.hi)))

    @property
    def closest(self) -> float:
        """How close to each other lists are made."""
        return (BESIDE if self.scale > self.hi - self.lo else SPLIT) * self.scale

    def run(self, n_lists: int) -> None:
        """Explain all changes; Ctrl-C leaves out the rest where a ``partial`` answer is wanted."""
        kept: list[Node] = []
        known = self._known_so_far()
        n = min(n_lists, 2 + int((self.hi - self.lo) / self.closest))
        values = grid(self.lo, self.hi, n)
        with self.work.until_interrupted(), self._coarsened(values):
            known = self._known_so_far()
            self.grid_nodes = self._nodes(values)
            self._look_for_hidden()
            kept.append(self.grid_nodes[0])
            for right in self.grid_nodes[1:]:
                self._explain_or_tell(kept[-1], right)
                off = [abs(event.value - right.q) for event in self.events]
                if right is not self.grid_nodes[-1] and min(off, default=math.inf) <= self.closest:
                    # What a list shows in the very middle of an event is an accident: not this one.
                    self._go_back(known)
                    self._known.clear()  # ways that have come too close to the event to miss it
                    continue
                kept.append(right)
                known = self._known_so_far()
                self.work.tell((right.q - self.lo) / (self.hi - self.lo))
        if self.work.interrupted:
            self._go_back(known)
            reached = kept[-1].q if kept else self.lo
            self.unresolved.append(UnresolvedChange("interrupted: not looked at", reached, self.hi))
        self.grid_nodes = kept
        self.spans.sort(key=lambda span: span.left.q)

    @property
    def crowded(self) -> bool:
        """Whether breaks accumulate, so that the map is resolved less."""
        return self.resolution > RESOLUTION

    def resolved(self) -> AbstractContextManager[None]:
        """Make tables as fine as the lists of this range."""
        return tables_complete_above(self.resolution)

    def _coarsened(self, values: Sequence[float]) -> AbstractContextManager[None]:
        """Resolve less where breaks accumulate, and say so."""
        looked_at = values[0], values[len(values) // 2], values[-1]
        self.resolution = max(branch_table(self.family.at(q)).resolution for q in looked_at)
        if self.crowded:
            reason = (
                f"breaks accumulate: lists are complete above {self.resolution:.2g}, "
                "and fewer values are looked at"
            )
            self.unresolved.append(UnresolvedChange(reason, self.lo, self.hi))
        return self.resolved()

    def _known_so_far(self) -> tuple[int, int, list[Event]]:
        return len(self.spans), len(self.unresolved), list(self.events)

    def _go_back(self, known: tuple[int, int, list[Event]]) -> None:
        """Forget what was found since."""
        del self.spans[known[0] :], self.unresolved[known[1] :]
        self.events = known[2]

    def _look_for_hidden(self) -> None:
        """Add lists where a pair of events may hide between two of the grid."""
        seen: dict[float, list[NearZero]] = {}
        for _ in range(SECOND_LOOKS):
            for node in self.grid_nodes:
                if node.q not in seen:
                    seen[node.q] = near_zeros(node, self.max_period, self.classes)
            values = [node.q for node in self.grid_nodes]
            fresh = hidden_values(values, [seen[q] for q in values], self.width)
            if not fresh:
                break
            self.grid_nodes += self._nodes(fresh)
            self.grid_nodes.sort(key=lambda node: node.q)
        for q, before in (values[:2], values[:-3:-1]):
            conditions = zeros_at_end(seen[q], seen[before], self.width)
            self._at_ends[q] = [Suspect(one, q, self.closest) for one in conditions]

    def _nodes(self, values: Sequence[float], besides: Sequence[float] = ()) -> list[Node]:
        """Make lists at several values, two at a time: most of the work is the map's own."""

        def make(place: tuple[float, float]) -> Node:
            return Node.make(self.family, place[0], self.max_period, place[1])

        nodes = in_threads(make, zip(values, besides or [math.inf] * len(values), strict=True))
        for node in nodes:
            self.classes.learn(node.table)
        self.n_nodes += len(nodes)
        return nodes

    # ------------------------------------------------------------------ between events

    def _explain_or_tell(self, left: Node, right: Node) -> None:
        """Explain what happens between two nodes; if that fails, leave them unconnected."""
        known = self._known_so_far()
        noted: list[UnresolvedChange] = []
        what = "the changes of orbits"
        attempted(lambda: self._explain(left, right), what, left.q, right.q, noted)
        if noted:
            self._go_back(known)
            ends = [list(range(len(node.orbits))) for node in (left, right)]
            self.spans.append(Span(left, right, loose_left=ends[0], loose_right=ends[1]))
            self.unresolved += noted

    def _explain(self, left: Node, right: Node) -> None:
        """Explain all that happens between two nodes, by adding nodes if need be."""
        todo = [(left, right)]
        while todo:
            span = Span(*todo.pop())
            fresh, unexplained = self._look(span)
            if fresh:
                todo += self._cut(span, fresh)
            elif unexplained and self._may_narrow(span):
                (middle,) = self._nodes([0.5 * (span.left.q + span.right.q)])
                todo += [(span.left, middle), (middle, span.right)]
            else:
                self.spans.append(span)
                self.unresolved += unexplained

    def _may_narrow(self, span: Span) -> bool:
        wide = span.right.q - span.left.q > NARROWEST * self.scale
        return wide and self.n_nodes < (MAX_CROWDED if self.crowded else MAX_NODES)

    def _look(self, span: Span) -> tuple[list[Event], list[UnresolvedChange]]:
        """Join two lists; return events that are new, and what none explains."""
        joined = join(span.left, span.right, self.family, self.classes)
        span.pieces = joined.pieces
        ways = self._ways(span, joined.left, joined.right)
        fresh: list[Event] = []
        unexplained: list[UnresolvedChange] = []
        for piece in span.pieces:
            for suspect in flips_on(piece):
                event = located(suspect, self.family, self._within(span))
                if event is None:
                    unexplained.append(
                        self._open(span, piece, "the multiplier passes -1, but no flip is found")
                    )
                else:
                    self._add(event, fresh)
            if (np.diff(np.sign(piece.multipliers - 1)) != 0).any():
                unexplained.append(
                    self._open(span, piece, "the multiplier passes 1 without a fold")
                )
        for left, right, way in ways:
            piece = way.piece(left, right)
            event = self._end_of(way, span, fresh)
            if event is not None:
                self._add(event, fresh)
            elif way.arrived:
                reason = "an orbit arrives that the complete list does not contain"
                unexplained.append(self._open(span, piece, reason))
            elif way.end.reason != "end of domain":
                unexplained.append(self._open(span, piece, f"an orbit ends ({way.end.reason})"))
            span.endings.append(Ending(piece, event, way.end.reason))
        for node in (span.left, span.right):
            for suspect in self._at_ends.get(node.q, []):
                event = located(suspect, self.family, self._within(span))
                if event is not None and in_the_middle(node.q, [event.value]):
                    self._add(event, fresh)
        if not (fresh or unexplained):
            unexplained += self._hidden_collisions(span, fresh)
        return fresh, unexplained

    def _hidden_collisions(self, span: Span, fresh: list[Event]) -> list[UnresolvedChange]:
        """Find the collisions of orbits that are in neither list; return what is no collision."""
        unexplained = []
        # Where a crowd takes a table at each value, those at the ends of the span have to do.
        coarse = self.crowded and not self.classes.telling
        narrowest = math.inf if coarse else BESIDE * self.scale
        for suspect in hidden_collisions(
            span.left, span.right, self.family, self.max_period, self.classes, narrowest
        ):
            event = located(suspect, self.family, self._within(span))
            if event is not None:
                self._add(event, fresh)
                continue
            reason = "an image of a break passes it, but no collision is found"
            assert isinstance(suspect.condition, Collision)
            period, x = suspect.condition.period, suspect.condition.border.x
            ends = span.left.q, span.right.q
            unexplained.append(UnresolvedChange(reason, *ends, period, x))
        return unexplained

    def _ways(
        self, span: Span, loose_left: list[int], loose_right: list[int]
    ) -> list[tuple[int | None, int | None, Way]]:
        """Follow the orbits that were not matched; those that arrive become pieces."""
        missing = {-1: set(loose_left), 1: set(loose_right)}
        todo = [(side, k) for side in (-1, 1) for k in sorted(missing[side])]
        # Those whose way is known in part come first: it ends where the others begin.
        todo.sort(key=lambda item: self._key(span, *item) not in self._known)
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
        way = follow(start, k, goal.q, self.family, self.classes, self._known.get(key))
        if not self.classes.telling:
            way = self._ended_at_passed_border(way, start, k, goal)
        self._known[key] = way
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
            found = located(suspect, self.family, self._within(span))
            if found is not None:
                alike = (e for e in fresh if found.same_as(e, self.scale, self.width))
                return next(alike, found)
        return None

    def _within(self, span: Span) -> tuple[float, float]:
        """Where events of a span may lie: a little beyond, as they may be known ones there."""
        pad = 2 * BESIDE * self.scale
        return max(span.left.q - pad, self.lo), min(span.right.q + pad, self.hi)

    def _add(self, event: Event, fresh: list[Event]) -> None:
        """Remember an event unless it is known."""
        if not any(event.same_as(known, self.scale, self.width) for known in self.events):
            insort(self.events, event, key=lambda item: item.value)
            fresh.append(event)

    def _open(self, span: Span, piece: Piece, reason: str) -> UnresolvedChange:
        x = float(piece.points[0, 0])
        return UnresolvedChange(reason, span.left.q, span.right.q, piece.period, x)

    # ------------------------------------------------------------------ around events

    def _cut(self, span: Span, fresh: list[Event]) -> list[tuple[Node, Node]]:
        """Put nodes on both sides of new events; return the spans between them."""
        groups = self._groups(fresh)
        bounds = [span.left.q, *(group[0].value for group in groups), span.right.q]
        places: dict[tuple[int, int], tuple[float, float]] = {}
        for k, group in enumerate(groups):
            rooms = bounds[k + 1] - bounds[k], bounds[k + 2] - bounds[k + 1]
            # An event at the value of a list, as at an end of the range, has its list already.
            open_sides = [side for side in (0, 1) if rooms[side] > self.closest]
            beside = min([BESIDE * self.scale, *(CLEAR * rooms[side] for side in open_sides)])
            for side in open_sides:
                value = group[-1].value + beside if side else group[0].value - beside
                places[k, side] = value, beside
        columns = ([place[k] for place in places.values()] for k in (0, 1))
        nodes = dict(zip(places, self._nodes(*columns), strict=True))
        plain: list[tuple[Node, Node]] = []
        last = span.left
        for k, group in enumerate(groups):
            before, after = nodes.get((k, 0), last), nodes.get((k, 1), span.right)
            if before is not last:
                plain.append((last, before))
            # What does not cross the span that holds the events is what they concern.
            joined = join(before, after, self.family, self.classes)
            self.spans.append(Span(before, after, group, joined.pieces, joined.left, joined.right))
            last = after
        if last is not span.right:
            plain.append((last, span.right))
        return plain

    def _groups(self, fresh: list[Event]) -> list[list[Event]]:
        """Events in ascending order, those at one value together."""
        groups: list[list[Event]] = []
        for event in sorted(fresh, key=lambda item: item.value):
            if groups:
                last = groups[-1][-1]
                slack = 8 * (last.located.error + event.located.error) + SAME_VALUE * self.scale
                if event.value - last.value <= slack:
                    groups[-1].append(event)
                    continue
            groups.append([event])
        return groups


def grid(lo: float, hi: float, n: int) -> list[float]:
    """Return n ascending values with both ends, the others at no special places."""
    step = (hi - lo) / (n - 1)
    shift = JITTER * step * (2 * ((GOLDEN * np.arange(n)) % 1.0) - 1)
    values = lo + step * np.arange(n) + shift
    values[0], values[-1] = lo, hi
    return [float(value) for value in values]
