"""Breakpoints of a family of maps at many parameter values, narrowed from forecasts, all at once.

`tracked` follows one break to adjacent floats with its limits; here places are enough.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from stickslip.analysis.branches.discontinuities import Brackets
from stickslip.analysis.branches.mesh import Nodes
from stickslip.analysis.maps.protocol import SAME, domain_width, sample
from stickslip.numerics.continuation import lagrange_weights
from stickslip.numerics.processes import in_processes
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Map1D

FIRST: Final = 1e-6  # of the domain's width: half of the first bracket
SMALLEST: Final = 1e-11  # ... and of later ones, however good the predictions are
FAN: Final = np.outer(0.125 ** np.arange(3), [-1.0, 1.0]).ravel()  # of the bracket: looked at
WIDENING: Final = 16.0
WIDEST: Final = 0.05  # of the domain's width: a breakpoint further off is lost
PLACES: Final = 4  # that a prediction goes through
MET: Final = 1e-6  # of the domain's width: how well a line must meet an anchor
REMAINS: Final = 0.5  # of the difference between the sides, from one value to the next


@part
@dataclass(frozen=True, eq=False)
class BreakpointLine:
    """A breakpoint of a map over the parameter values at which it exists."""

    kind: str
    d: Floats  # its place, to 1e-12 of the domain's width; NaN at values without it


@dataclass(frozen=True)
class _Breaks:
    """Breakpoints of one map; arrays of shape (m,). ``contrast`` tells how the sides differ."""

    value: float
    x: Floats
    kind: NDArray[np.str_]
    contrast: Floats

    def take(self, rows: list[int]) -> _Breaks:
        return _Breaks(self.value, self.x[rows], self.kind[rows], self.contrast[rows])


# Between two anchors: maps and values, the breakpoints at the anchors, and how far a breakpoint may
# arrive from one there that it is.
_Stretch: TypeAlias = "tuple[Sequence[Map1D], Floats, _Breaks, _Breaks, float]"


def follow_breakpoints(
    maps: Sequence[Map1D], values: Floats, anchors: Sequence[tuple[float, BranchTable]]
) -> tuple[BreakpointLine, ...]:
    """Locate the breakpoints of a family at ascending values between anchors, complete tables."""
    lines: list[tuple[str, Floats]] = []
    between: list[_Stretch] = []
    places: list[Indices] = []
    breaks = [_breaks_at(*anchor) for anchor in anchors]
    for (here, there), (_, after) in zip(pairwise(breaks), anchors[1:], strict=True):
        inside = np.flatnonzero((values >= here.value) & (values <= there.value))
        own = [maps[k] for k in inside.tolist()]
        between.append((own, values[inside], here, there, MET * domain_width(after.f)))
        places.append(inside)
    owners = _new_lines(lines, breaks[0], len(values))
    ways = in_processes(_followed, between)
    for (_, _, here, _, reach), inside, way in zip(between, places, ways, strict=True):
        reached, old, fresh, back = way
        for line, column in zip(owners, reached.T, strict=True):
            _enter(lines[line][1], inside, column)
        new = _new_lines(lines, fresh, len(values))
        for k, column in enumerate(back.T):
            kind = str(fresh.kind[k])
            new[k] = _met(column, kind, reached, here, owners, reach, new[k])
            _enter(lines[new[k]][1], inside, column)
        names = iter(new)
        owners = [next(names) if row is None else owners[row] for row in old]
    return tuple(BreakpointLine(kind, d) for kind, d in lines if np.isfinite(d).any())


def _followed(stretch: _Stretch) -> tuple[Floats, list[int | None], _Breaks, Floats]:
    """Places of the breakpoints here, who of them arrives there, the others there, their places."""
    maps, values, here, there, reach = stretch
    order = np.arange(len(values))
    reached, end = _march(maps, values, order, here, there)
    old = _matched(here, end, there, reach)
    fresh = there.take([k for k, row in enumerate(old) if row is None])
    back, _ = _march(maps, values, order[::-1], fresh, here)
    return reached, old, fresh, back[::-1]


def _breaks_at(value: float, table: BranchTable) -> _Breaks:
    items = [item for item in table.breakpoints if item.kind != "smooth"]
    return _Breaks(
        value,
        np.array([item.d for item in items], dtype=np.float64),
        np.array([item.kind for item in items], dtype=np.str_),
        np.array([_contrast(item) for item in items], dtype=np.float64),
    )


def _contrast(item: Breakpoint) -> float:
    """How much the signal (`_signal`) differs between the two sides."""
    if item.kind == "jump":
        return abs(item.jump)
    if item.kind == "corner":
        return abs(math.atan(item.right_slope) - math.atan(item.left_slope))
    return 1.0


def _new_lines(lines: list[tuple[str, Floats]], breaks: _Breaks, n: int) -> list[int]:
    """Open a line for each breakpoint; return their numbers."""
    first = len(lines)
    lines += [(str(kind), np.full(n, np.nan)) for kind in breaks.kind]
    return list(range(first, len(lines)))


def _enter(line: Floats, places: Indices, column: Floats) -> None:
    known = np.isfinite(column)
    line[places[known]] = column[known]


def _matched(here: _Breaks, end: Floats, there: _Breaks, reach: float) -> list[int | None]:
    """For each breakpoint there, the row of the one that arrived at it, or None."""
    rows: list[int | None] = []
    for x, kind in zip(there.x, there.kind, strict=True):
        same = (here.kind == kind) & (np.abs(end - x) <= reach)
        rows.append(int(np.argmax(same)) if same.any() else None)
    return rows


def _met(
    column: Floats,
    kind: str,
    reached: Floats,
    here: _Breaks,
    owners: list[int],
    reach: float,
    own: int,
) -> int:
    """Line that a breakpoint followed back belongs to: one that it meets, else its own."""
    for row, line in enumerate(owners):
        with np.errstate(invalid="ignore"):
            if here.kind[row] == kind and (np.abs(reached[:, row] - column) <= reach).any():
                return line
    return own


def _march(
    maps: Sequence[Map1D], values: Floats, order: Indices, start: _Breaks, towards: _Breaks
) -> tuple[Floats, Floats]:
    """Follow breakpoints to the next anchor: places (len(order), m), NaN where lost; forecasts."""
    found = np.full((len(order), len(start.x)), np.nan)
    rows = np.arange(len(start.x))
    places: list[tuple[float, Floats]] = [(start.value, start.x)]
    if np.array_equal(start.kind, towards.kind):
        places.insert(0, (towards.value, towards.x))  # a chord is a better guess than none
    radius, contrast = np.full(len(start.x), FIRST), start.contrast.copy()
    for step, k in enumerate(order):
        if not rows.size:
            break
        f, value = maps[k], float(values[k])
        guess = _extrapolated(places, value)
        reach = np.maximum(radius, SMALLEST) * domain_width(f)
        x, difference = _located(f, start.kind[rows], guess[rows], reach[rows], contrast[rows])
        found[step, rows], contrast[rows] = x, difference
        rows = rows[np.isfinite(x)]
        if value not in (q for q, _ in places):
            radius = 4.0 * np.abs(found[step] - guess) / domain_width(f)
            places = [*places, (value, found[step])][-PLACES:]
    return found, _extrapolated(places, towards.value)


def _extrapolated(places: list[tuple[float, Floats]], value: float) -> Floats:
    """Continue the polynomial through the places."""
    known, x = zip(*places, strict=True)
    return np.asarray(lagrange_weights(known, value) @ np.array(x))


def _signal(kind: NDArray[np.str_], nodes: Nodes) -> Floats:
    """Reduce points to a number each that tells the two sides of a break apart."""
    signal = np.where(kind == "jump", nodes.value, np.arctan(nodes.slope))
    return np.where(kind == "edge", nodes.ok, signal)


def _located(
    f: Map1D, kind: NDArray[np.str_], x: Floats, radius: Floats, contrast: Floats
) -> tuple[Floats, Floats]:
    """Enclose and narrow breaks, all at once; their places, NaN where lost, and contrasts."""
    width = domain_width(f)

    def probe(x: Floats) -> Nodes:
        return Nodes.at(x, sample(f, x))

    def fan(k: Indices) -> list[Nodes]:
        """Points on both sides of forecasts, the farthest first: a few cost as much as one."""
        points = x[k] + radius[k] * FAN[:, None]
        nodes = probe(np.clip(points, *f.domain).ravel())
        return [nodes.take(np.arange(len(k)) + row * len(k)) for row in range(len(FAN))]

    low, high, *inner = fan(np.arange(len(x)))
    while True:
        good = np.abs(_signal(kind, high) - _signal(kind, low)) >= REMAINS * contrast
        k = np.flatnonzero(~good & (radius < WIDEST * width))
        if not k.size:
            break
        radius[k] = np.minimum(radius[k] * WIDENING, WIDEST * width)
        for old, new in zip([low, high, *inner], fan(k), strict=True):
            old.put(k, new)

    def is_left(k: Indices, left: Nodes, nodes: Nodes, right: Nodes) -> Bools:
        """Tell which points are more like the left side."""
        one, here, other = (_signal(kind[k], each) for each in (left, nodes, right))
        return np.asarray(np.abs(here - one) <= np.abs(here - other))

    brackets = Brackets(probe, low, high, is_left)
    for nodes in inner:
        brackets.take_in(np.flatnonzero(good), nodes.take(good))
    brackets.close(lambda: good & (brackets.right.x - brackets.left.x > SAME * width))
    difference = np.abs(_signal(kind, brackets.right) - _signal(kind, brackets.left))
    good &= difference >= REMAINS * contrast  # else it was slope, not a break
    middle = 0.5 * (brackets.left.x + brackets.right.x)
    # A break belongs to the line that foretold it best: another has ended, as where d wraps.
    off = np.where(good, np.abs(middle - x), np.inf)
    shared = np.abs(middle[:, None] - middle) <= SAME * width
    good &= ~(shared & (off < off[:, None])).any(axis=1)
    return np.where(good, middle, np.nan), np.where(good, difference, contrast)
