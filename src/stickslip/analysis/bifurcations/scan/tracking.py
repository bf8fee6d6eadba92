"""Orbits joined from one value of a parameter to the next, or followed to where they end.

One look at the middle proves most joints; few orbits are followed one by one.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.scan.nodes import velocity
from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.analysis.orbits.newton import polish_on
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses
    from stickslip.analysis.maps.protocol import Floats, MapFamily
    from stickslip.analysis.orbits.bundles import OrbitBundle

TRUST: Final = 0.05  # share of an orbit's way by which the cubic's prediction may be wrong
FLOOR: Final = 1e-7  # of the domain's width: errors of a prediction that count for nothing
SURPRISE: Final = 0.25  # share of a step by which an orbit may miss where it was foretold
EASY: Final = 0.06  # a smaller one lets the next step grow
CONTRACTS: Final = 0.5  # a longer step of Newton's method, beside the last, mistrusts the guess
TRUST_RADIUS: Final = 1.0  # of a step: an orbit may not come close to missing by so much
SHORTEST: Final = 1e-3  # of the way left: steps below it mean that the orbit ends here
FIRST: Final = 0.25  # of the way: the first step
MANY: Final = 4.0  # of the first step: the rest of the way counts for no more
MAX_STEPS: Final = 400
NEUTRAL: Final = 0.2  # a doubled orbit this close to multiplier 1 is about to meet its parent
COLLAPSING: Final = 0.2  # shrinking of the distance to half an orbit later that shows a flip
ON_CORNER: Final = np.uint64(0)  # in the place of a label
LOOK_AHEAD: Final = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # steps, to see what stops an orbit

Reason: TypeAlias = Literal["arrived", "doubling", "border", "outside", "standstill"]


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
class Joined:
    """What two neighbouring lists have in common."""

    pieces: list[Piece]  # orbits that reach from one node to the other
    left: list[int]  # places of the orbits that were not found in the other list
    right: list[int]


def join(left: Node, right: Node, family: Family, classes: SymbolClasses) -> Joined:
    """Join the orbits of two neighbouring nodes as far as the middle between them proves it."""
    rows, columns = _candidates(left, right, classes)
    pieces: list[Piece] = []
    if rows.size:
        proved, pieces = _proved(left, right, rows, columns, family, classes)
        rows, columns = rows[proved], columns[proved]
    return Joined(
        pieces,
        sorted(set(range(len(left.orbits))) - set(rows.tolist())),
        sorted(set(range(len(right.orbits))) - set(columns.tolist())),
    )


def _candidates(
    left: Node, right: Node, classes: SymbolClasses
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pairs of orbits of one word that foretell each other best, by both velocities."""
    half = 0.5 * (right.q - left.q)
    rows: list[int] = []
    columns: list[int] = []
    shared = set(left.bundle.periods.tolist()) & set(right.bundle.periods.tolist())
    for period in sorted(shared):
        i = np.flatnonzero(left.bundle.periods == period)
        j = np.flatnonzero(right.bundle.periods == period)
        ahead = (left.bundle.points + half * left.velocity)[i, :period]
        back = (right.bundle.points - half * right.velocity)[j, :period]
        cost = np.abs(ahead[:, None] - back[None]).max(axis=2)
        one, other = _names(left, classes)[i], _names(right, classes)[j]
        agree = (one[:, None, :period] == other[None, :, :period]).all(axis=2)
        cost = np.where(agree & np.isfinite(cost), cost, np.inf)
        best, back_best = cost.argmin(axis=1), cost.argmin(axis=0)
        mutual = (back_best[best] == np.arange(len(i))) & np.isfinite(cost.min(axis=1))
        rows += i[mutual].tolist()
        columns += j[best[mutual]].tolist()
    return np.array(rows, dtype=np.intp), np.array(columns, dtype=np.intp)


def _names(node: Node, classes: SymbolClasses) -> NDArray[np.uint64]:
    """Name the branches of all points, none on a corner; by order where labels tell nothing."""
    names = classes.of(node.bundle.labels) if classes.telling else node.segments
    return np.where(node.on_corner, ON_CORNER, names)


def _proved(
    left: Node,
    right: Node,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    family: Family,
    classes: SymbolClasses,
) -> tuple[NDArray[np.bool_], list[Piece]]:
    """Look in the middle, and keep the pairs that are found where the cubic foretells them."""
    q = 0.5 * (left.q + right.q)
    f = family.at(q)
    one, other = left.bundle.take(rows), right.bundle.take(columns)
    width = max(one.points.shape[1], other.points.shape[1])
    x0, x1 = _padded(one.points, width), _padded(other.points, width)
    v0, v1 = _padded(left.velocity[rows], width), _padded(right.velocity[columns], width)
    step = right.q - left.q
    guess = 0.5 * (x0 + x1) + step / 8 * (v0 - v1)
    labels = _padded(one.labels, width)
    there = polish_on(f, guess, periods=one.periods)
    used = there.used
    with np.errstate(invalid="ignore"):
        way = np.where(used, np.abs(x1 - x0), 0.0).max(axis=1) + FLOOR * domain_width(f)
        expected = there.surprise <= TRUST * way
    free = _padded(left.on_corner[rows], width)
    # An orbit on a corner: its multiplier depends on the side, and changes nothing.
    stays = np.asarray(free.any(axis=1))
    same = (~used | free | (classes.of(there.labels) == classes.of(labels))).all(axis=1)
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


def _padded(rows: NDArray, width: int) -> NDArray:  # type: ignore[type-arg]
    """Widen rows to a number of columns."""
    missing = width - rows.shape[1]
    if not missing:
        return rows
    fill = np.nan if rows.dtype.kind == "f" else 0
    return np.pad(rows, ((0, 0), (0, missing)), constant_values=fill)


# ------------------------------------------------------------------ one orbit at a time


@dataclass(frozen=True, eq=False)
class End:
    """Where the way of an orbit ends, and what it looks like there."""

    # ``doubling``: it closes up on an orbit of half its period; ``standstill``: as at a fold.

    reason: Reason
    q: float  # last value of the parameter
    points: Floats
    velocity: Floats
    multiplier: float
    step: float  # last step that was too long, signed
    place: int = 0  # number of the point that ends the way
    others: tuple[int, ...] = ()  # numbers of points that meet breaks of their own there


@dataclass(eq=False)
class Way:
    """An orbit's way from a node: samples in the order of travel, and the end."""

    values: list[float] = field(default_factory=list)
    points: list[Floats] = field(default_factory=list)
    multipliers: list[float] = field(default_factory=list)
    end: End | None = None
    last: OrbitBundle | None = None  # the orbit at the last sample

    def piece(self, left: int | None, right: int | None) -> Piece:
        """Return the samples in ascending order."""
        order = np.argsort(self.values, kind="stable")
        return Piece(
            left,
            right,
            np.array(self.values)[order],
            np.array(self.points)[order],
            np.array(self.multipliers)[order],
        )


def follow(
    node: Node,
    place: int,
    goal: float,
    family: Family,
    classes: SymbolClasses,
    known: Way | None = None,
) -> Way:
    """Follow an orbit of a node towards a value, its word kept; on from a ``known`` way's end."""
    tracker = _Tracker(node, place, goal, family, classes)
    first = min(FIRST * abs(goal - node.q), node.beside)
    if known is not None and tracker.resume(known):
        assert known.end is not None
        first = min(first, abs(known.end.step))
    return tracker.go(first)


class _Tracker:
    """One orbit on its way."""

    def __init__(
        self, node: Node, place: int, goal: float, family: Family, classes: SymbolClasses
    ) -> None:
        self.family, self.classes, self.goal = family, classes, float(goal)
        self.q, self.f = node.q, node.f
        self.bundle: OrbitBundle = node.bundle.take(slice(place, place + 1))
        self.speed = node.velocity[place : place + 1]
        self.length = self.goal - self.q
        self.before: tuple[float, Floats, Floats] | None = None
        self.apart = self._apart()
        self.way = Way()
        self._note()

    def resume(self, known: Way) -> bool:
        """Go on from where another way ended, if that is before the goal."""
        q = known.values[-1]
        if known.last is None or not (q - self.q) * self.length > 0:
            return False
        if not (self.goal - q) * self.length > 0:
            return False
        self.way = Way(list(known.values), list(known.points), list(known.multipliers))
        self.q, self.f, self.bundle = q, self.family.at(q), known.last
        self.speed = velocity(self.bundle, self.f, self.family.name)
        return True

    def go(self, first: float) -> Way:
        """Step towards the goal, as far as it goes."""
        least = np.spacing(max(abs(self.q), abs(self.goal)))  # a shorter step leads nowhere
        step = max(first, least) * np.sign(self.length)
        for _ in range(MAX_STEPS):
            if self.q == self.goal:
                self.way.end = self._end("arrived", step)
                return self.way
            if abs(step) >= abs(self.goal - self.q):
                step = self.goal - self.q
            ratio = self._try(step)
            if ratio is None:
                step *= 0.4
                way = min(abs(self.goal - self.q), MANY * first)
                if abs(step) < max(least, SHORTEST * way):
                    break
            elif ratio < EASY:
                step *= 2.0
        self.way.end = self._explain(step / 0.4)
        return self.way

    def _try(self, step: float) -> float | None:
        """Take a step; return how far it led astray, None if too far or nowhere."""
        if not np.isfinite(self.speed[self.bundle.used]).all():
            return None
        q = self.goal if step == self.goal - self.q else self.q + step
        f = self.family.at(q)
        b, move = self.bundle, (q - self.q) * self.speed
        floor = FLOOR * domain_width(f)
        trust_radius = TRUST_RADIUS * (np.nanmax(np.abs(move)) + floor)
        there = polish_on(
            f,
            b.points + move,
            periods=b.periods,
            start=self._guess(q),
            trust_radius=trust_radius,
            contraction=CONTRACTS,
        )
        if not there.converged[0] or there.collapsed[0]:
            return None
        if self.classes.changed(f, there.points[0], there.labels[0], b.labels[0]):
            return None
        if (there.multipliers[0] - 1) * (b.multipliers[0] - 1) < 0:
            return None  # that is the other orbit of a fold
        way = np.abs(there.points - b.points)[b.used].max() + floor
        ratio = float(there.surprise[0] / way)
        if not ratio <= SURPRISE:
            return None
        self.before = (self.q, b.points, self.speed)
        self.q, self.f, self.bundle = q, f, there
        self.speed = velocity(there, f, self.family.name)
        self._note()
        return ratio

    def _guess(self, q: float) -> Floats | None:
        """Continue the cubic through the last two samples; None at the first step."""
        if self.before is None:
            return None
        q0, x0, v0 = self.before
        width = self.q - q0
        t, x1, v1 = (q - q0) / width, self.bundle.points, self.speed
        rise, a, b = x1 - x0, width * v0, width * v1
        guess: Floats = x0 + t * rise + t * (1 - t) * ((a - rise) * (1 - t) + (rise - b) * t)
        return guess

    def _note(self) -> None:
        self.way.values.append(self.q)
        self.way.points.append(self.bundle.orbit_points(0))
        self.way.multipliers.append(float(self.bundle.multipliers[0]))
        self.way.last = self.bundle

    def _apart(self) -> float:
        """Distance between an orbit and itself half a period later."""
        points = self.bundle.orbit_points(0)
        if len(points) % 2:
            return np.inf
        return float(np.abs(points - np.roll(points, len(points) // 2)).max())

    def _end(self, reason: Reason, step: float, place: int = 0) -> End:
        points = self.bundle.orbit_points(0)
        return End(
            reason,
            self.q,
            points,
            self.speed[0, : len(points)],
            float(self.bundle.multipliers[0]),
            step,
            place,
        )

    def _explain(self, step: float) -> End:
        """Look along the velocity for what stops the orbit."""
        neutral = abs(self.bundle.multipliers[0] - 1) < NEUTRAL
        if neutral and self._apart() < COLLAPSING * self.apart:
            return self._end("doubling", step)
        points = self.bundle.orbit_points(0)
        labels = self.bundle.labels[0, : len(points)]
        for times in LOOK_AHEAD:
            ahead = points + times * step * self.speed[0, : len(points)]
            q = self.q + times * step
            if not np.isfinite(ahead).all() or (q - self.goal) * self.length > 0:
                break
            found = self._blocked(self.family.at(q), ahead, labels)
            if found is not None:
                twice = ahead + times * step * self.speed[0, : len(points)]
                late = self._blocked(self.family.at(q), twice, labels) if len(points) > 1 else None
                others = set(late[1]) - {found[1][0]} if late and late[0] == found[0] else ()
                end = self._end(found[0], times * step, found[1][0])
                return replace(end, others=tuple(sorted(others)))
        return self._end("standstill", step)

    def _blocked(
        self, f: MapFamily, ahead: Floats, labels: NDArray[np.uint64]
    ) -> tuple[Reason, list[int]] | None:
        """Tell which points are outside, or not in their branches."""
        lo, hi = f.domain
        outside = np.flatnonzero((ahead < lo) | (ahead > hi))
        if outside.size:
            return "outside", outside.tolist()
        got = sample(f, ahead)
        gone = np.flatnonzero(got.status != OK).tolist()
        other = sorted({*gone, *self.classes.changed(f, ahead, got.label, labels)})
        return ("border", other) if other else None
