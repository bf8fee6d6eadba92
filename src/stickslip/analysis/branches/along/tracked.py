"""Discontinuities and turning points of a map, followed as its parameters change.

Labels on either side tell a discontinuity; where they do not, the table of a small window does.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import permutations
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Self, TypeAlias

import numpy as np

from stickslip.analysis.branches.along.change_search import (
    NARROWEST,
    Branch,
    Probe,
    Seen,
    close_in,
    find_change,
)
from stickslip.analysis.branches.breakpoints import Breakpoint, Kind, kind_of, limits_inside
from stickslip.analysis.branches.discontinuities import are_apart, is_step
from stickslip.analysis.branches.mesh import RESOLUTION, Nodes, finest
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import (
    domain_width,
    is_ok,
    remembered,
    sample,
    values_and_slopes,
)
from stickslip.numerics.arrays import EPS
from stickslip.numerics.continuation import LeavesRegion
from stickslip.numerics.zeros import slope_zeros
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Collection

    from stickslip.analysis.maps.protocol import Floats, Map1D

Side: TypeAlias = Literal[-1, 1]
CriticalKind: TypeAlias = Literal["jump", "corner", "smooth", "edge", "turning point"]

REACH: Final = 1.5  # times the last move: where a critical point is looked for first
WINDOW: Final = 1e-3  # of the domain: half width of the window whose table is asked, at least
WIDER: Final = 8.0  # ... and times the last move
WIDENING: Final = 4.0  # of that bracket, until the slope changes its sign
CONTINUOUS: Final = 1e-3  # of the slopes around: a slope that jumps over 0 is no turning point
AWAY: Final = np.geomspace(1e-7, 1.0, 48)  # of that half width: where a jump is looked for
MAX_ROUNDS: Final = 24  # of looks at these; each leaves a thirtieth of an interval, or halves some
HIDDEN: Final = 1e-3  # of a jump: values so far off what slopes foretell may hide a nearer one
FAN: Final = 33  # points between which the end of a piece is looked for
FAN_OUT: Final = 8.0 ** np.arange(-12, -2)  # of the domain: how far an end may have moved


class ConditionLost(LeavesRegion):
    """What a condition asks for does not exist at these parameter values; the cause is a text."""


@part
@dataclass(frozen=True)
class CriticalReading:
    """A critical point of one map: where it is and what the map does on either side."""

    x: float
    left: float  # one-sided value, NaN beside a gap; equal to ``right`` at a turning point
    right: float
    left_slope: float  # infinite at a square root, 0 at a turning point
    right_slope: float
    kind: CriticalKind
    interval: tuple[float, float]  # points on either side, adjacent floats at a break
    critical: Critical  # the same one, started from here
    scatter: tuple[float, float] = (0.0, 0.0)  # of its values, from float to float: logarithms

    def value(self, side: int) -> float:
        """One-sided value: -1 left, 1 right."""
        return self.left if side < 0 else self.right

    @property
    def uncertainty(self) -> float:
        """How far off ``x`` may be: at a corner, whose sides meet, their values tell."""
        known = self.interval[1] - self.interval[0]
        if self.kind not in ("corner", "smooth"):
            return known
        steepness = abs(self.left_slope) + abs(self.right_slope)
        return known + abs(self.right - self.left) / max(1.0, steepness)

    def slope(self, side: int) -> float:
        """One-sided slope: -1 left, 1 right."""
        return self.left_slope if side < 0 else self.right_slope

    def label(self, side: int) -> int:
        """Label of the branch on one side; 0 where there is none."""
        known = getattr(self.critical, "left_label" if side < 0 else "right_label", None)
        return 0 if known is None else int(known)

    @property
    def labels(self) -> tuple[int, int]:
        """Those of the branches on both sides."""
        return self.label(-1), self.label(1)

    def is_beyond(self, side: int, x: float) -> bool:
        """Tell whether a point has left the branch on one side, or is its end."""
        return x >= self.interval[0] if side < 0 else x <= self.interval[1]

    def continued(self, side: int, x: float) -> float:
        """Value of one side's branch a little beyond its end, to first order."""
        slope = self.slope(side)
        return self.value(side) + (slope * (x - self.x) if math.isfinite(slope) else 0.0)


@part
@dataclass(frozen=True)
class TrackedDiscontinuity:
    """A switching boundary between two branches, plain data: finds itself in a changed map."""

    left_label: int | None  # None in a gap
    right_label: int | None
    x: float
    kind: Kind
    # how far it moved when it was followed last; 0 if never
    reach: float = field(default=0.0, compare=False)

    @classmethod
    def of(cls, breakpoint_: Breakpoint) -> Self:
        """Make a border of a breakpoint of a map's table."""
        b = breakpoint_
        left = None if math.isnan(b.left) else b.left_label
        right = None if math.isnan(b.right) else b.right_label
        return cls(left, right, b.d, b.kind)

    @property
    def labelled(self) -> bool:
        """Whether the labels tell the two sides apart."""
        return self.left_label != self.right_label

    def at(self, f: Map1D, *, successors: bool = True) -> CriticalReading:
        """Find the break in a map with other parameter values, of the map's kind and labels."""
        # If its branches no longer meet, a break that shares one may take its place.
        whole: Map1D = getattr(f, "whole", f)
        # Several conditions on one break are read off the same map.
        find = _by_labels if self.labelled else _by_step
        reading = find(whole, self, self.reach)
        if reading is None:
            if self.labelled and not successors:
                raise ConditionLost(f"the {self.kind} at {self.x:.12g} is gone")
            reading = _beside_crowd(whole, self) or _by_table(whole, self, self.reach)
        lo, hi = f.domain
        if not lo <= reading.x <= hi:
            raise ConditionLost(f"the {self.kind} at {reading.x:.12g} has left the window")
        return reading


@part
@dataclass(frozen=True)
class TurningPoint:
    """A smooth extremum of a map: f'(x) = 0 inside a branch."""

    x: float
    # how far it moved when it was followed last; 0 if never
    reach: float = field(default=0.0, compare=False)
    kind: ClassVar[CriticalKind] = "turning point"

    def at(self, f: Map1D) -> CriticalReading:
        """Find the turning point in a map with other parameter values, or raise `ConditionLost`."""
        # Many conditions are on one of them, too.
        reading = _turned(getattr(f, "whole", f), self.x, self.reach)
        lo, hi = f.domain
        if not lo <= reading.x <= hi:
            raise ConditionLost(f"the turning point at {reading.x:.12g} has left the window")
        return reading


@part
@dataclass(frozen=True)
class DomainEnd:
    """An end of a map's domain, or of its window: the edge of the gap outside."""

    upper: bool
    x: float
    kind: ClassVar[CriticalKind] = "edge"

    def at(self, f: Map1D, *, successors: bool = True) -> CriticalReading:
        """Read the map off at its end, which nothing takes the place of."""
        x = float(f.domain[self.upper])
        value, slope = (float(v) for v in values_and_slopes(f, np.array(x)))
        inside, outside = (value, slope), (math.nan, math.nan)
        (left, at_left), (right, at_right) = (inside, outside) if self.upper else (outside, inside)
        end = DomainEnd(self.upper, x)
        return CriticalReading(x, left, right, at_left, at_right, "edge", (x, x), end)


Critical: TypeAlias = TrackedDiscontinuity | TurningPoint | DomainEnd


# ---------------------------------------------------------------- breaks


@dataclass(frozen=True)
class NearDiscontinuity:
    """What limits and kinds of breaks ask of a mesh, for one break."""

    f: Map1D
    slope_scale: ClassVar = 1.0  # mean steepness

    @property
    def value_scale(self) -> float:
        """Width of the domain: a map's values lie there, but for some that leave it."""
        return domain_width(self.f)

    @property
    def resolution(self) -> float:
        """As in tables."""
        return min(finest(self.f), RESOLUTION * self.value_scale)

    def slopes(self, x: Floats) -> tuple[Floats, Floats]:
        """Evaluate the map."""
        return values_and_slopes(self.f, x)


@remembered
def _by_labels(f: Any, border: TrackedDiscontinuity, reach: float) -> CriticalReading | None:
    """Find a border by the labels of its two branches; None where these do not meet."""
    left, right = Branch.of(border.left_label), Branch.of(border.right_label)
    probe = Probe(f)
    found = find_change(probe, left, right, border.x, REACH * reach)
    return None if found is None else _described(probe, *found, border.x)


@remembered
def _by_step(f: Any, border: TrackedDiscontinuity, reach: float) -> CriticalReading | None:
    """Find the nearest jump, whatever the labels beside it; None where values show none nearby."""
    # As the table of a window does, but for jumps alone and in few calls: 3 ms instead of 50 ms.
    if border.kind != "jump":
        return None
    probe, (lo, hi) = Probe(f), f.domain
    away = max(WINDOW * (hi - lo), WIDER * reach) * AWAY
    probe.look([*(border.x - away).tolist(), border.x, *(border.x + away).tolist()])
    ends, clear = (lo, hi), finest(f)
    for _ in range(MAX_ROUNDS):
        seen = [s for s in probe.seen if ends[0] <= s.x <= ends[1]]
        nodes = _nodes(*seen)
        left, right = nodes.take(slice(None, -1)), nodes.take(slice(1, None))
        rise, mean = right.value - left.value, 0.5 * (left.slope + right.slope)
        (steps,) = is_step(left, right, hi - lo).nonzero()
        if not steps.size and ends == (lo, hi):
            return None
        if not steps.size:  # beside a singular jump a slope may be as steep, by accident
            steps = np.array([np.abs(rise).argmax()])
        distance = np.maximum(left.x - border.x, border.x - right.x)
        k = int(steps[distance[steps].argmin()])
        off = np.abs(rise - mean * (right.x - left.x))
        # What is nearer must be smooth: among steep branches another jump hides. Halves of a cell
        # that only bends, as beside a logarithm, are.
        rough = (distance < distance[k]) & (off > HIDDEN * abs(rise[k]))
        if rough.any() and ends[1] - ends[0] > clear:
            probe.look((0.5 * (left.x + right.x))[rough].tolist())
            continue
        last, first = seen[k], seen[k + 1]
        if not are_apart(f, last.x, first.x):
            break
        ends = last.x, first.x
        probe.look([*np.linspace(*ends, FAN).tolist(), *[0.0][: ends[0] < 0 < ends[1]]])
    else:
        return None
    found = _described(probe, last, first, border.x)
    return found if found.critical == replace(border, x=found.x) else None


def _described(probe: Probe, last: Seen, first: Seen, near: float) -> CriticalReading:
    """Take limits from both branches beside a break, found from where it was expected."""
    mesh = NearDiscontinuity(probe.f)
    ends = _nodes(last, first)
    room = np.array([probe.extent(last, -1), probe.extent(first, 1)])
    limits = limits_inside(mesh, ends, np.array([-1.0, 1.0]), room)
    # The first float to the right, but one that has a value; beside 0, 0 rather than a tiny one.
    x = last.x if last.x == 0 or not first.branch.ok else first.x
    limits = limits.moved(x - ends.x)
    at_left, at_right = limits.take(slice(0, 1)), limits.take(slice(1, 2))
    (kind,) = kind_of(mesh, at_left, at_right, np.array([first.x - last.x]))
    (value, beyond), (slope, slope_beyond) = limits.value.tolist(), limits.slope.tolist()
    left_label, right_label = (b.label if b.ok else None for b in (last.branch, first.branch))
    critical = TrackedDiscontinuity(left_label, right_label, x, kind, abs(x - near))
    sides = value, beyond, slope, slope_beyond
    scatter = float(at_left.scatter[0]), float(at_right.scatter[0])
    return CriticalReading(x, *sides, kind, (last.x, first.x), critical, scatter)


def break_between(f: Map1D, x: float, labels: Collection[int]) -> CriticalReading | None:
    """Find the nearest break to a point at which the branches of two labels meet, if any."""
    found = []
    for left, right in permutations(labels):
        with suppress(ConditionLost):
            break_ = TrackedDiscontinuity(left, right, x, "jump")
            found.append(break_.at(f, successors=False))
    return min(found, key=lambda one: abs(one.x - x), default=None)


def _nodes(*seen: Seen) -> Nodes:
    return Nodes(
        np.array([s.x for s in seen]),
        np.array([s.value for s in seen]),
        np.array([s.slope for s in seen]),
        np.array([s.branch.label for s in seen], dtype=np.uint64),
        np.array([s.branch.ok for s in seen]),
        np.array([s.margin for s in seen]),
    )


@remembered
def _by_table(f: Map1D, border: TrackedDiscontinuity, reach: float) -> CriticalReading:
    """Find the nearest break that may have taken a border's place, in the table of a window."""
    half = max(WINDOW * domain_width(f), WIDER * reach)
    successors = _successors(f, border, half)
    # Where labels tell nothing, every search begins here, however far the break has moved.
    while not successors and not border.labelled and half < domain_width(f):
        half *= WIDER
        successors = _successors(f, border, half)
    if not successors:
        raise ConditionLost(f"the {border.kind} at {border.x:.12g} is gone")
    # One that is of the same kind and shares a side comes first, then the nearest.
    b = min(successors, key=lambda b: (b.kind != border.kind, abs(b.d - border.x)))
    moved = replace(TrackedDiscontinuity.of(b), reach=abs(b.d - border.x))
    values = (b.left, b.right, b.left_slope, b.right_slope)
    return CriticalReading(b.d, *values, b.kind, b.interval, moved, b.scatter)


def _successors(f: Map1D, border: TrackedDiscontinuity, half: float) -> list[Breakpoint]:
    """Find breaks near a border that may have taken its place."""
    lo, hi = f.domain
    window = (max(border.x - half, lo), min(border.x + half, hi))
    if not window[0] < window[1]:
        return []
    table = branch_table(WindowMap(f, window))
    return [b for b in table.breakpoints if _may_replace(TrackedDiscontinuity.of(b), border)]


def _may_replace(other: TrackedDiscontinuity, border: TrackedDiscontinuity) -> bool:
    """Tell whether a break may be a border after one of its branches gave way to another."""
    if not border.labelled:
        return other.kind == border.kind
    shares = other.left_label == border.left_label or other.right_label == border.right_label
    return shares and (other.kind != "smooth" or border.kind == "smooth")


@remembered
def _beside_crowd(f: Map1D, border: TrackedDiscontinuity) -> CriticalReading | None:
    """Find where a branch ends at a gap, or at branches too narrow to be told apart, if it does."""
    # The table of a window tells the same after it has told apart as many of these as it can.
    ends = (-1, border.left_label), (1, border.right_label)
    branches = [(side, label) for side, label in ends if label is not None]
    if len(branches) != 1:
        return None
    ((side, label),) = branches
    found = piece_end_near(f, {label}, border.x, side)
    if found is None or found.kind == "smooth":
        return None
    outer = found.interval[side < 0]
    beyond = sample(f, np.clip([outer, outer - side * finest(f)], *f.domain))
    if is_ok(beyond).all() and beyond.label[0] == beyond.label[1]:
        return None  # a branch that is wide enough
    moved = replace(border, kind="edge", x=found.x, reach=abs(found.x - border.x))
    edge = replace(found, kind="edge", critical=moved)
    if side > 0:
        return replace(edge, left=math.nan, left_slope=math.nan)
    return replace(edge, right=math.nan, right_slope=math.nan)


# ---------------------------------------------------------------- turning points


@remembered
def _turned(f: Map1D, near: float, reach: float) -> CriticalReading:
    """Find the turning point near a point of the whole domain, or raise `ConditionLost`."""
    scale = domain_width(f)
    ends, slopes = _slope_bracket(f, near, max(REACH * reach, NARROWEST * scale))
    (x,) = slope_zeros(lambda t: values_and_slopes(f, t)[1], ends, slopes).tolist()
    around = sample(f, np.clip(x + EPS * scale * np.array([-1.0, 0.0, 1.0]), *ends))
    if not np.max(np.abs(around.derivative)) <= CONTINUOUS * np.abs(slopes).sum():
        raise ConditionLost(f"no turning point near {near:.12g}: the slope jumps over 0")
    value = float(around.value[1])
    moved = TurningPoint(x, abs(x - near))
    interval = (float(np.nextafter(x, -math.inf)), float(np.nextafter(x, math.inf)))
    return CriticalReading(x, value, value, 0.0, 0.0, "turning point", interval, moved)


def _slope_bracket(f: Map1D, x: float, reach: float) -> tuple[Floats, Floats]:
    """Find points on either side of x with slopes of different signs; both of shape (2, 1)."""
    lo, hi = f.domain
    while True:
        ends = np.array([[max(x - reach, lo)], [min(x + reach, hi)]])
        _, slopes = values_and_slopes(f, ends)
        if slopes[0] * slopes[1] <= 0:
            return ends, slopes
        if not np.isfinite(slopes).all() or (ends[0] == lo and ends[1] == hi):
            raise ConditionLost(f"the turning point near {x:.12g} is gone")
        reach *= WIDENING


# ---------------------------------------------------------------- ends of pieces


def piece_end(
    f: Map1D, piece: Collection[int], inside: float, outside: float
) -> CriticalReading | None:
    """Find, to adjacent floats, the first end of a piece from a point on it towards one outside."""
    probe = Probe(f)
    probe.look(np.linspace(inside, outside, FAN).tolist())
    rightwards = outside > inside

    def is_left(branch: Branch) -> bool:
        return (branch.ok and branch.label in piece) == rightwards

    pairs = range(len(probe.seen) - 1)
    for i in pairs if rightwards else reversed(pairs):
        if is_left(probe.seen[i].branch) and not is_left(probe.seen[i + 1].branch):
            last, first = close_in(probe, is_left, (i, i + 1))
            return _described(probe, last, first, last.x)
    return None


def piece_end_near(f: Map1D, piece: Collection[int], x: float, side: int) -> CriticalReading | None:
    """Find the end of a piece close to x; side is -1 for a piece left of its end, else 1."""
    reach = side * domain_width(f) * FAN_OUT
    inside, outside = (np.clip(x + k * reach, *f.domain).tolist() for k in (1, -1))
    for a, b in zip(inside, outside, strict=True):
        found = piece_end(f, piece, a, b)
        if found is not None:
            return found
    return None
