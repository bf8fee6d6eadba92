"""A range of a parameter surveyed: complete lists, all their orbits joined, every change explained.

Each located event gets lists just below and above: nothing is born or lost without being noticed.
"""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise
from threading import Lock
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import OUTSIDE, UnresolvedChange
from stickslip.analysis.bifurcations.scan.between import Found, Range, between
from stickslip.analysis.bifurcations.scan.events import Event, Suspect
from stickslip.analysis.bifurcations.scan.near_misses import (
    NearZero,
    hidden_values,
    near_zeros,
    zeros_at_end,
)
from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses, returns_to_crowd
from stickslip.analysis.branches.discontinuities import LONG_GAPS, LONG_MOTIONS
from stickslip.analysis.branches.mesh import WIDE
from stickslip.analysis.branches.table import (
    NOT_FOLLOWED,
    branch_table,
    resolution_of_lists,
    tables_complete_above,
)
from stickslip.analysis.work import Work
from stickslip.numerics.arrays import GOLDEN
from stickslip.numerics.processes import in_processes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from contextlib import AbstractContextManager

    from stickslip.analysis.bifurcations.scan.tracking import Span
    from stickslip.analysis.continuation.curve import Curve

LISTED: Final = 0.4  # share of the work that the lists of the grid are, roughly
SECOND_LOOKS: Final = 2  # rounds of lists added where a pair of events may hide
EVERY: Final = 3  # value of the grid that has a list where breaks accumulate, and each costs much
JITTER: Final = 0.11  # of a spacing: values of a grid keep away from round numbers


class Survey(Range):
    """The range of a parameter, cut into spans without and around events, both ascending."""

    def __init__(
        self, family: Family, lo: float, hi: float, max_period: int, work: Work | None = None
    ) -> None:
        super().__init__(family, lo, hi, max_period)
        self.work = Work() if work is None else work
        self.spans: list[Span] = []
        self.events: list[Event] = []
        self.unresolved: list[UnresolvedChange] = []  # and what is outside the question
        self.grid_nodes: list[Node] = []
        self.curves: tuple[Curve, ...] | None = None  # of all orbits, once they are joined
        self.joining = Lock()  # a diagram and a list may want them at once
        self.n_nodes = 0
        self._classes = SymbolClasses()
        self._at_ends: dict[float, list[Suspect]] = {}  # events there are in no list's middle

    def run(self, n_lists: int) -> None:
        """Explain all changes; Ctrl-C leaves out the rest where a ``partial`` answer is wanted."""
        n = min(n_lists, 2 + int((self.hi - self.lo) / self.closest))
        values = grid(self.lo, self.hi, n)
        kept: list[Node] = []
        with self.work.until_interrupted(), self._coarsened(values):
            values = [*values[:-1:EVERY], values[-1]] if self.crowded else values
            nodes = self._nodes(values, self.work.part(0.0, LISTED).tell)
            self._tell_crowd(nodes)
            nodes = self._where_hidden(nodes)
            kept.append(nodes[0])
            self._explain(nodes, kept)
        if self.work.interrupted:
            reached = kept[-1].q if kept else self.lo
            self.unresolved.append(UnresolvedChange("interrupted: not looked at", reached, self.hi))
        self.grid_nodes = kept
        self.spans.sort(key=lambda span: span.left.q)
        self.events.sort(key=lambda event: event.value)

    def resolved(self) -> AbstractContextManager[None]:
        """Make tables as fine as the lists of this range."""
        return tables_complete_above(self.resolution)

    def _coarsened(self, values: Sequence[float]) -> AbstractContextManager[None]:
        """Resolve less where breaks accumulate."""
        for q in (values[len(values) // 2], values[0], values[-1]):
            with self.resolved():
                table = branch_table(self.family.at(q))
            found = resolution_of_lists(table, self.max_period)
            self.crowded |= found > table.resolution
            if found > self.resolution:
                # Tables that need hardly less than others are the same, and serve the lists, too.
                self.resolution = min(2.0 ** math.ceil(math.log2(found)), WIDE * self.width)
            if found > self.finest and not self.crowded:
                self.crowded = returns_to_crowd(table, self.max_period)
        return self.resolved()

    def _tell_crowd(self, nodes: Sequence[Node]) -> None:
        """Say that breaks accumulate, where looks for that were made or between them."""
        open_ = {item.reason for node in nodes for item in node.table.unresolved}
        if LONG_GAPS in open_:
            reason = f"{OUTSIDE}: narrow branches inside gaps, where motions are long"
            self.unresolved.append(UnresolvedChange(reason, self.lo, self.hi))
        for why in sorted(reason for reason in open_ if reason.startswith(NOT_FOLLOWED)):
            at = [n.q for n in nodes if any(item.reason == why for item in n.table.unresolved)]
            reason = f"{OUTSIDE}: in gaps {why.removesuffix(', in')}"
            self.unresolved.append(UnresolvedChange(reason, min(at), max(at)))
        self.resolution = max(self.resolution, *(node.table.resolution for node in nodes))
        if self.resolution == self.finest:
            return
        returning = (returns_to_crowd(node.table, self.max_period) for node in nodes)
        self.crowded = self.crowded or any(returning)
        why = "motions are long" if LONG_MOTIONS in open_ else "breaks accumulate"
        above = f"lists are complete above {self.resolution:.2g}"
        reason = f"{why}: {above}, and fewer values are looked at"
        if not self.crowded:
            reason = (
                f"{OUTSIDE}: {why} where no orbit up to period {self.max_period} passes, {above}"
            )
        self.unresolved.append(UnresolvedChange(reason, self.lo, self.hi))

    def _nodes(self, values: Sequence[float], tell: Callable[[float], None]) -> list[Node]:
        """Make lists at several values."""
        make = partial(Node.make, self.family, self.max_period)
        nodes = list(in_processes(make, values, tell))
        for node in nodes:
            self._classes.learn(node.table)
        self.n_nodes += len(nodes)
        return nodes

    def _where_hidden(self, nodes: list[Node]) -> list[Node]:
        """Add lists where a pair of events may hide between two of the grid."""
        seen: dict[float, list[NearZero]] = {}
        left_out, most = list[float](), 4 * len(nodes)  # lists that a round adds
        for _ in range(SECOND_LOOKS):
            for node in [*nodes[:2], *nodes[-2:]] if self.crowded else nodes:
                if node.q not in seen:
                    seen[node.q] = near_zeros(node, self.max_period, self._classes)
            values = [node.q for node in nodes]
            if self.crowded:
                break
            fresh = hidden_values(values, [seen[q] for q in values], self.width)
            left_out = fresh[most:]
            if not fresh:
                break
            more = self._nodes(sorted(fresh[:most]), lambda share: self.work.tell(LISTED))
            nodes = sorted([*nodes, *more], key=lambda node: node.q)
        if left_out:
            reason = f"pairs of events may hide at {len(left_out)} values where no list is made"
            self.unresolved.append(UnresolvedChange(reason, min(left_out), max(left_out)))
        for q, before in (values[:2], values[:-3:-1]):
            conditions = zeros_at_end(seen[q], seen[before], self.width)
            self._at_ends[q] = [Suspect(one, q, self.closest) for one in conditions]
        return nodes

    def _explain(self, nodes: list[Node], kept: list[Node]) -> None:
        """Explain what happens between neighbours, all at once; then take what fits together."""
        whole = Range(self.family, self.lo, self.hi, self.max_period, self.resolution, self.crowded)
        explain = partial(between, whole, self._classes, self._at_ends)
        tell = self.work.part(LISTED, 1.0).tell
        found_ahead = in_processes(partial(explain, n_nodes=self.n_nodes), pairwise(nodes), tell)
        for (left, right), found in zip(pairwise(nodes), found_ahead, strict=True):
            known = any(any(self.alike(event, self.events)) for event in found.events)
            if kept[-1] is not left or known:
                ends = kept[-1], right
                found = explain(ends, n_nodes=self.n_nodes, known=self.events)
            off = [abs(event.value - right.q) for event in (*self.events, *found.events)]
            self.n_nodes += found.n_nodes
            # What a list shows in the very middle of an event is an accident: not this one.
            if right is nodes[-1] or min(off, default=math.inf) > self.closest:
                self._take(found, kept[-1], right)
                kept.append(right)

    def _take(self, found: Found, left: Node, right: Node) -> None:
        spans = sorted(found.spans, key=lambda span: span.left.q)
        spans[0].left, spans[-1].right = left, right  # not what has travelled
        self.spans += spans
        self.events += found.events
        self.unresolved += found.unresolved


def grid(lo: float, hi: float, n: int) -> list[float]:
    """Return n ascending values with both ends, the others at no special places."""
    step = (hi - lo) / (n - 1)
    shift = JITTER * step * (2 * ((GOLDEN * np.arange(n)) % 1.0) - 1)
    values = lo + step * np.arange(n) + shift
    values[0], values[-1] = lo, hi
    return [float(value) for value in values]
