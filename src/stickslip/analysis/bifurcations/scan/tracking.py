"""Orbits joined from one value of a parameter to the next, or followed to where they end.

One look at the middle proves most joints; few orbits are followed one by one.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import OUTSIDE, UnresolvedChange
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.continuation.follower import Half, Passed
from stickslip.analysis.continuation.half_period import shrinks_to_half
from stickslip.analysis.continuation.orbit_follower import LineOrbitFollower
from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Labels, domain_width, sample
from stickslip.analysis.orbits.newton import polish_on
from stickslip.numerics.continuation import CurvePoint, turns_back
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.bifurcations.scan.events import Event
    from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses

TRUST: Final = 0.05  # share of an orbit's way by which the cubic's prediction may be wrong
FLOOR: Final = 1e-7  # of the domain's width: errors of a prediction that count for nothing
FIRST: Final = 0.25  # of the way: the first step
LEAST: Final = 1e-2  # of the domain's width: points are taken to move so much
MAX_STEPS: Final = 400
BEYOND: Final = (1e-6, 1e-5, 1e-4, 1e-3)  # scaled ways past an end: who leaves his branch there
ON_CORNER: Final = np.uint64(0)  # in the place of a label


@dataclass(frozen=True, eq=False)
class Piece:
    """An orbit between two nodes: samples in ascending order of the parameter."""

    left: int | None  # places of the orbit in the lists at both nodes; None where it does not reach
    right: int | None
    values: Floats
    points: Floats
    multipliers: Floats

    @property
    def period(self) -> int:
        """Of the orbit."""
        return int(self.points.shape[1])


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
    pieces: list[Piece]  # orbits that cross the span
    loose_left: list[int]  # places of the orbits that were not found in the other list
    loose_right: list[int]
    # at one value of the parameter; empty for a span between events
    events: list[Event] = field(default_factory=list)
    # between events: orbits that leave the window there, or end unexplained
    endings: list[Ending] = field(default_factory=list)

    def open(
        self, reason: str, period: int, near_left: Floats, near_right: Floats
    ) -> UnresolvedChange:
        """Tell of an orbit that nothing explains, by its points next to both nodes."""
        unlisted = self.left.why_unlisted(near_left) or self.right.why_unlisted(near_right)
        if unlisted:
            reason = f"{OUTSIDE}: {unlisted}"
        return UnresolvedChange(reason, self.left.q, self.right.q, period, float(near_left[0]))


def join(left: Node, right: Node, family: Family, classes: SymbolClasses) -> Span:
    """Join the orbits of two neighbouring nodes as far as the middle between them proves it."""
    rows, columns = _candidates(left, right, classes)
    pieces: list[Piece] = []
    if rows.size:
        proved, pieces = _proved(left, right, rows, columns, family, classes)
        rows, columns = rows[proved], columns[proved]
    loose_left = sorted(set(range(len(left.orbits))) - set(rows.tolist()))
    loose_right = sorted(set(range(len(right.orbits))) - set(columns.tolist()))
    return Span(left, right, pieces, loose_left, loose_right)


def _candidates(left: Node, right: Node, classes: SymbolClasses) -> tuple[Indices, Indices]:
    """Pairs of orbits of one word that foretell each other best, by both velocities."""
    half = 0.5 * (right.q - left.q)
    telling = left.telling and right.telling
    names = [_names(node, classes, telling=telling) for node in (left, right)]
    rows: list[int] = []
    columns: list[int] = []
    shared = set(left.bundle.periods.tolist()) & set(right.bundle.periods.tolist())
    for period in sorted(shared):
        i = np.flatnonzero(left.bundle.periods == period)
        j = np.flatnonzero(right.bundle.periods == period)
        ahead = (left.bundle.points + half * left.velocity)[i, :period]
        back = (right.bundle.points - half * right.velocity)[j, :period]
        cost = np.abs(ahead[:, None] - back[None]).max(axis=2)
        one, other = names[0][i], names[1][j]
        agree = (one[:, None, :period] == other[None, :, :period]).all(axis=2)
        cost = np.where(agree & np.isfinite(cost), cost, np.inf)
        best, back_best = cost.argmin(axis=1), cost.argmin(axis=0)
        mutual = (back_best[best] == np.arange(len(i))) & np.isfinite(cost.min(axis=1))
        rows += i[mutual].tolist()
        columns += j[best[mutual]].tolist()
    return np.array(rows, dtype=np.intp), np.array(columns, dtype=np.intp)


def _names(node: Node, classes: SymbolClasses, *, telling: bool) -> Labels:
    """Name the branches of all points, none on a corner; by order where labels do not tell."""
    names = classes.of(node.bundle.labels) if telling else node.segments
    return np.where(node.on_corner, ON_CORNER, names)


def _proved(
    left: Node, right: Node, rows: Indices, columns: Indices, family: Family, classes: SymbolClasses
) -> tuple[Bools, list[Piece]]:
    """Look in the middle, and keep the pairs that are found where the cubic foretells them."""
    q = 0.5 * (left.q + right.q)
    f = family.at(q)
    one, other = left.bundle.take(rows), right.bundle.take(columns)
    own = slice(one.periods.max())  # of the longest that both have
    x0, x1 = one.points[:, own], other.points[:, own]
    v0, v1 = left.velocity[rows, own], right.velocity[columns, own]
    step = right.q - left.q
    guess = 0.5 * (x0 + x1) + step / 8 * (v0 - v1)
    there = polish_on(f, guess, periods=one.periods)
    used = there.used
    with np.errstate(invalid="ignore"):
        way = np.where(used, np.abs(x1 - x0), 0.0).max(axis=1) + FLOOR * domain_width(f)
        expected = there.surprise <= TRUST * way
    free = left.on_corner[rows, own]
    # An orbit on a corner: its multiplier depends on the side, and changes nothing.
    stays = np.asarray(free.any(axis=1))
    same = (~used | free | (classes.of(there.labels) == classes.of(one.labels[:, own]))).all(axis=1)
    all_three = (one, there, other)
    sides = [np.sign(bundle.multipliers - 1) for bundle in all_three]
    proved = there.converged & ~there.collapsed & expected & same
    proved &= ((sides[0] == sides[1]) & (sides[1] == sides[2])) | stays
    pieces = [
        Piece(
            int(rows[k]),
            int(columns[k]),
            np.array([left.q, q, right.q]),
            np.array([x[k, : one.periods[k]] for x in (x0, there.points, x1)]),
            np.array([bundle.multipliers[k] for bundle in ((one,) * 3 if stays[k] else all_three)]),
        )
        for k in np.flatnonzero(proved)
    ]
    return proved, pieces


# ------------------------------------------------------------------ one orbit at a time


@dataclass(frozen=True, eq=False)
class Way:
    """An orbit's way from a node: samples in the order of travel, and the end."""

    values: Floats
    points: Floats
    multipliers: Floats
    end: CurveEnd
    labels: Labels  # at the end, of the branches that the orbit was on
    gone: tuple[int, ...] = ()  # numbers of points that leave their branches there

    @property
    def arrived(self) -> bool:
        """Whether the goal is reached."""
        return self.end.reason == "end of range"

    def piece(self, left: int | None, right: int | None) -> Piece:
        """Return the samples in ascending order."""
        order = np.argsort(self.values, kind="stable")
        return Piece(left, right, self.values[order], self.points[order], self.multipliers[order])


def follow(
    node: Node,
    place: int,
    goal: float,
    family: Family,
    classes: SymbolClasses,
    known: Way | None = None,
) -> Way:
    """Follow an orbit of a node towards a value; on from what is known of its way."""
    first = node.bundle.orbit_points(place)
    values, points = np.array([node.q]), first[None]
    multipliers = node.bundle.multipliers[[place]]
    if known is not None:
        before = (known.values - goal) * np.sign(goal - node.q) < 0
        if before.all():
            return known
        values, points = known.values[before], known.points[before]
        multipliers = known.multipliers[before]
    moves = np.nanmax(np.abs(node.velocity[place]), initial=0.0) * abs(goal - node.q)
    follower = _SpanFollower(family, float(values[-1]), float(goal), float(moves))
    try:
        half = follower.towards(points[-1], float(values[-1]), float(goal))
    except ValueError:  # too close to where the orbit ends
        end = CurveEnd("step limit", {family.name: float(values[-1])}, points[-1], multipliers[-1])
        return Way(values, points, multipliers, end, node.bundle.labels[place])
    rows = half.rows[1:]
    assert half.end is not None
    return Way(
        np.append(values, [row.parameter for row in rows]),
        np.concatenate([points, *(row.y[None, :-1] for row in rows)]),
        np.append(multipliers, [row.note.multipliers for row in rows]),
        half.end,
        half.rows[-1].note.labels,
        follower.gone(half, classes),
    )


class _SpanFollower(LineOrbitFollower):
    """Follows an orbit of a list to where it turns back, meets another one, a border, or a goal."""

    def __init__(self, family: Family, start: float, goal: float, moves: float) -> None:
        low, high = sorted((start, goal))
        super().__init__(family.at(start), family.name, low, high, 1.0, MAX_STEPS)
        self.control = replace(self.control, first=FIRST)
        self.moves = moves

    def size(self) -> float:
        """How far points may move, at least a share of the domain."""
        width = domain_width(self.f)
        return min(max(self.moves, LEAST * width), width)

    def towards(self, points: Floats, value: float, goal: float) -> Half:
        """Follow an orbit at a value towards another."""
        start = self.start(points, value)
        return self.half(start if goal > value else start.reversed(), [])

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """Solve for what ends the way."""
        if shrinks_to_half(self.f, self.points(here), self.points(new)):
            yield self._merged(here)
        elif turns_back(here, new):
            fold = self.curve.turning_point(here, new)
            yield Passed(fold, end=self.end(fold, "fold"))
        elif (off := here.note.multipliers - 1) * (new.note.multipliers - 1) < 0:
            share = off / (here.note.multipliers - new.note.multipliers)
            there = replace(here, y=here.y + share * (new.y - here.y))
            yield Passed(None, end=self.end(there, "crossing"))

    def gone(self, half: Half, classes: SymbolClasses) -> tuple[int, ...]:
        """Tell which points leave their branches where a way ends, or just beyond."""
        assert half.end is not None
        met = set() if half.end.index is None else {half.end.index}
        if half.end.reason not in ("breakpoint", "gap", "step limit"):
            return tuple(met)
        last, tangent = half.rows[-1], half.rows[-2 if met and len(half.rows) > 1 else -1].tangent
        for way in BEYOND:
            found = [self._left(last, tangent, times * way, classes) for times in (1.0, 2.0)]
            if found[0] or met:
                return tuple(sorted(met.union(*found)))
        return ()

    def _left(
        self, last: CurvePoint, tangent: Floats, way: float, classes: SymbolClasses
    ) -> list[int]:
        """Tell which points have left their branches a way further on."""
        ahead = last.y + way * self.curve.scale * tangent
        try:
            f = self.equations.at(ahead[-1])
        except ValueError:
            return []  # the family ends there
        got = sample(f, ahead[:-1])
        changed = classes.changed(f, ahead[:-1], got.label, last.note.labels)
        return sorted({*np.flatnonzero(got.status != OK).tolist(), *changed})
