"""Sampling of a map until its shape is known: nodes, cells that passed a test, label changes.

Jumps, corners and turning points fail the test at every width: they are met even without a label.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.maps.protocol import (
    Map1D,
    PointValues,
    domain_width,
    is_ok,
    length,
    sample,
    values_and_slopes,
)
from stickslip.numerics.arrays import EPS, GOLDEN, Columns
from stickslip.status import GIVEN_UP

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Labels


RESOLUTION: Final = 1e-9  # of the domain: `finest` of tables, and of limits at breaks
WIDE: Final = 1e-3  # of the domain: branches that are all told apart, and the largest resolution
N_START: Final = 101  # nodes of the first grid; ten times as many found nothing more
GAP_PROBES: Final = 6e-3  # of the domain: a gap without margins is not probed more closely
GAP_FLOOR: Final = 1e-4  # ... nor one with margins, where they fall
LONG: Final = 256  # events of a motion from which on it counts as a long one
GAP_SHARE: Final = 0.125  # of a gap: its cells are halved down to this, however narrow it is
WELL_INSIDE: Final = 0.9  # of a cell: a margin that vanishes at its very end does so beyond it
JITTER: Final = 0.07  # of a cell: no node on a symmetric place, where turning points like to sit
VALUE_FIT: Final = 1e-7  # of the range of values: a prediction this good passes
SLOPE_FIT: Final = 1e-4  # of the slopes: likewise
CURVE_FIT: Final = 1e-3  # of the slopes: change of slope that neighbours may disagree about
SIGN_MARGIN: Final = 4.0  # errors of prediction that a slope must stay away from 0
MANY: Final = 16  # narrow cells that fail together for each break of a crowd
CLOSER: Final = 0.125 ** np.arange(1, 11)  # of a cell at a break that fails: it is cut there
FLAT: Final = 8 * EPS  # of a value: smaller changes are rounding


@dataclass(eq=False, slots=True)
class Nodes(Columns):
    """Points of a map in ascending order with what the map says there; shapes (n,)."""

    x: Floats
    value: Floats
    slope: Floats
    label: Labels
    ok: Bools
    margin: Floats

    @classmethod
    def at(cls, x: Floats, values: PointValues) -> Nodes:
        """Take over what an evaluation says; labels mean nothing where it has no value."""
        ok = is_ok(values) & np.isfinite(values.value)
        label = np.where(ok, values.label, 0)
        return cls(x, values.value, values.derivative, label, ok, values.margin)

    def copy(self) -> Nodes:
        """Return the same nodes in arrays of their own."""
        return self.joined()

    def merged(self, other: Nodes) -> tuple[Nodes, Indices]:
        """Return both sorted together, and where the nodes of ``other`` have gone."""
        order = np.argsort(np.concatenate([self.x, other.x]), kind="stable")
        place = np.empty(len(order), dtype=np.intp)
        place[order] = np.arange(len(order))
        return self.joined(other).take(order), place[len(self) :]

    def without_value(self, x: Floats) -> Nodes:
        """Return nodes at other points where nothing is known."""
        nothing = np.full(x.shape, np.nan)
        no_label, not_ok = np.zeros_like(self.label), np.zeros_like(self.ok)
        return Nodes(x, nothing, nothing, no_label, not_ok, nothing)

    def same_as_next(self) -> Bools:
        """Tell for each cell whether its two nodes have the same label, or both no value."""
        return (self.ok[1:] == self.ok[:-1]) & (self.label[1:] == self.label[:-1])


def finest(f: Map1D) -> float:
    """Return the resolution of tables where branches do not crowd; a window changes no units."""
    return RESOLUTION * float(length(domain_width(getattr(f, "whole", f))))


@dataclass
class Mesh:
    """A map under the probe: nodes, and the cells between them that are still open."""

    f: Map1D
    resolution: float  # no cell is made narrower
    crowd: int  # of branches that are not wide: more are not told apart, but less is resolved
    seeds: Floats = field(default_factory=lambda: np.empty(0))  # points of the first grid
    events_left: float = math.inf  # of long motions that return, before less is resolved
    gap_events_left: float = math.inf  # of those that do not: there they tell least
    nodes: Nodes = field(init=False)
    open: Bools = field(init=False)  # cells still to be tested
    # of one label, fail at the resolution
    doubtful: set[tuple[float, float]] = field(default_factory=set)
    # of gaps, not probed as closely as others, for their motions are too long
    left_out: set[tuple[float, float]] = field(default_factory=set)
    given_up: dict[float, int] = field(default_factory=dict)  # points and why: nothing is known
    n_evaluations: int = 0
    length: float = field(init=False, default=0.0)  # of long motions that do not return, in events

    def __post_init__(self) -> None:
        """Lay the first grid, off any symmetric places, with both ends of the domain."""
        lo, hi = self.f.domain
        inner = np.arange(1, N_START - 1)
        share = (inner + JITTER * _wobble(inner)) / (N_START - 1)
        grid = np.concatenate([[lo, hi], lo + (hi - lo) * share, self.seeds])
        self.nodes = self.probe(np.unique(grid))
        self.open = np.ones(len(self.nodes) - 1, dtype=bool)

    @property
    def value_scale(self) -> float:
        """Range of the values met so far, the scale of their errors; of the domain if flat."""
        # Beside a pole values are as large as floats: what leaves the domain by more than its
        # width just leaves.
        lo, hi = self.f.domain
        values = np.clip(self.nodes.value[self.nodes.ok], 2 * lo - hi, 2 * hi - lo)
        spread = float(np.ptp(values)) if values.size else 0.0
        return spread if spread > 0 else domain_width(self.f)

    @property
    def slope_scale(self) -> float:
        """Mean steepness: range of the values over width of the domain."""
        return self.value_scale / domain_width(self.f)

    def probe(self, x: Floats) -> Nodes:
        """Evaluate the map at ascending points and count."""
        self.n_evaluations += x.size
        got = sample(self.f, x)
        nodes = Nodes.at(x, got)
        if not nodes.ok.all():
            unknown = np.isin(got.status, GIVEN_UP)
            points, why = nodes.x[unknown], got.status[unknown]
            self.given_up.update(zip(points.tolist(), why.tolist(), strict=True))
        if (long := got.n_events > LONG).any():
            self.events_left -= int(got.n_events[long & nodes.ok].sum())
            if self.events_left <= 0:
                self.resolution = max(self.resolution, WIDE * domain_width(self.f))
            if (lost := long & ~nodes.ok).any():
                events = got.n_events[lost]
                self.gap_events_left -= int(events.sum())
                self.length = max(self.length, float(events.mean()))
        return nodes

    def slopes(self, x: Floats) -> tuple[Floats, Floats]:
        """Values and slopes alone, sooner than nodes, and count."""
        self.n_evaluations += x.size
        return values_and_slopes(self.f, x)

    def insert(self, nodes: Nodes) -> None:
        """Add evaluated nodes; cells beside them are open again if above the resolution."""
        _, first = np.unique(nodes.x, return_index=True)
        nodes = nodes.take(first)
        nodes = nodes.take(~np.isin(nodes.x, self.nodes.x))
        self.nodes, place = self.nodes.merged(nodes)
        self.open = _widen(self.open, place, len(self.nodes), value=True)
        self.open &= np.diff(self.nodes.x) > 1.5 * self.resolution

    def refine(self) -> None:
        """Test and halve cells until none is open and no curvature jumps between them."""
        while self.open.any():
            while self.open.any():
                self._refine_once()
            self._reopen(self._bent() | self._dipping())

    # ------------------------------------------------------------------ one round

    def _refine_once(self) -> None:
        nodes = self.nodes
        width = np.diff(nodes.x)
        candidate = self.open & nodes.same_as_next()
        wide = self._wide_enough(width)
        self._doubt(np.flatnonzero(candidate & ~wide & nodes.ok[1:]))
        cells = self._affordable(np.flatnonzero(candidate & wide), width)
        self.open[:] = False
        if not cells.size:
            return
        share = 0.5 + JITTER * _wobble(len(nodes) + cells)
        middle = self.probe(nodes.x[cells] + share * width[cells])
        passed = self._passes(nodes.take(cells), middle, nodes.take(cells + 1))
        passed &= width[cells] <= 2 * self._largest_unseen()[cells]
        self.nodes, place = nodes.merged(middle)
        self.open = _widen(self.open, place, len(self.nodes), value=False)
        failed = place[~passed]
        narrow = width[cells] <= WIDE**2 * domain_width(self.f)
        if np.count_nonzero(narrow & ~passed) > MANY * self.crowd:
            self.resolution = float(width[cells[narrow]].max())
        self.open[failed - 1] = self.open[failed] = True
        self._grade(failed)

    def _grade(self, middles: Indices) -> None:
        """Cut the halves of failed cells ever closer to the breaks that they end at."""
        # Beside a root one halving would follow the other, a call of the map each.
        nodes, step = self.nodes, self.resolution
        middles = middles[nodes.ok[middles - 1] & nodes.ok[middles] & nodes.ok[middles + 1]]
        at_break = np.concatenate([[False], np.diff(nodes.x) <= 1.5 * step, [False]])
        left, right = middles[at_break[middles - 1]], middles[at_break[middles + 2]]
        ends = np.concatenate([nodes.x[left - 1], nodes.x[right + 1]])
        off = (np.concatenate([nodes.x[left], nodes.x[right]]) - ends)[:, None] * CLOSER
        x = (ends[:, None] + off)[np.abs(off) > step]
        if x.size:
            self.nodes, place = nodes.merged(self.probe(np.sort(x)))
            self.open = _widen(self.open, place, len(self.nodes), value=True)

    def _doubt(self, cells: Indices) -> None:
        """Note cells that fail at the resolution."""
        self.doubtful.update(self._ends(cells))

    def _ends(self, cells: Indices) -> list[tuple[float, float]]:
        return list(zip(*self.nodes.x[[cells, cells + 1]].tolist(), strict=True))

    def _reopen(self, cells: Bools) -> None:
        """Open cells again, or doubt them at the resolution."""
        width = np.diff(self.nodes.x)
        narrow = (width <= 1.5 * self.resolution) | ~self._wide_enough(width)
        self._doubt(np.flatnonzero(cells & narrow & self.nodes.ok[1:]))
        self.open[self._affordable(np.flatnonzero(cells & ~narrow), width)] = True

    def _bent(self) -> Bools:
        """Tell which cells' curvature, at a common node, does not fit their neighbour's."""
        # One test point can miss a corner by accident: at 1/6 of a cell the prediction comes true.
        n = self.nodes
        same = n.same_as_next() & n.ok[1:]
        width = np.diff(n.x)
        with np.errstate(all="ignore"):
            mean = np.diff(n.value) / width
            at_left = (6 * mean - 4 * n.slope[:-1] - 2 * n.slope[1:]) / width
            at_right = (4 * n.slope[1:] + 2 * n.slope[:-1] - 6 * mean) / width
            misfit = np.abs(at_left[1:] - at_right[:-1]) * np.maximum(width[1:], width[:-1])
            typical = np.abs(n.slope[:-2]) + np.abs(n.slope[1:-1]) + np.abs(n.slope[2:])
            # In narrow cells a curvature is rounding.
            rounding = 12 * FLAT * np.abs(n.value[1:-1]) / np.minimum(width[1:], width[:-1]) ** 2
            rounding *= np.maximum(width[1:], width[:-1])
            bent = misfit > CURVE_FIT * (typical + 0.1 * self.slope_scale) + rounding
        flat = self._flat(n.take(slice(None, -1)), n.take(slice(1, None)))
        bent &= ~(flat[1:] & flat[:-1])
        bent &= same[1:] & same[:-1]
        cells = np.zeros(len(width), dtype=bool)
        cells[1:] |= bent
        cells[:-1] |= bent
        return cells

    def _dipping(self) -> Bools:
        """Tell which cells of one label may hide a branch: the margin seems to fall to 0 inside."""
        n = self.nodes
        same = n.same_as_next()
        width = np.diff(n.x)
        left, right = _reach_of_margin(n.x, n.margin, same)
        root_left, root_right = _reach_of_margin(n.x, n.margin**2, same)
        # Roots from one side alone would open every cell beside a change that is known.
        falls = np.minimum(np.minimum(left, right), np.maximum(root_left, root_right))
        return same & (falls < WELL_INSIDE * width)

    def _wide_enough(self, width: Floats) -> Bools:
        """Tell which cells may be halved: in a gap, where values cost much, only coarse ones."""
        if self.nodes.ok.all():
            return width > self.resolution
        in_gap = ~self.nodes.ok[1:]
        known = ~np.isnan(self.nodes.margin[1:])
        coarse = np.where(known, GAP_FLOOR, GAP_PROBES) * domain_width(self.f)
        coarse = np.maximum(np.minimum(coarse, self._largest_unseen()), self.resolution)
        return width > np.where(in_gap, coarse, self.resolution)

    def _affordable(self, cells: Indices, width: Floats) -> Indices:
        """Leave out the narrowest cells of gaps if motions there are too long to look into all."""
        in_gap = ~self.nodes.ok[cells + 1]
        lost = cells[in_gap]
        if len(lost) * self.length <= self.gap_events_left:
            return cells
        most = int(max(self.gap_events_left, 0) / self.length)
        lost = lost[np.argsort(-width[lost], kind="stable")]
        self.left_out.update(self._ends(lost[most:]))
        return np.sort(np.concatenate([cells[~in_gap], lost[:most]]))

    def _largest_unseen(self) -> Floats:
        """Width of a cell of a gap that its neighbours tell nothing of; of others without bound."""
        ok, x = self.nodes.ok, self.nodes.x
        if ok.all():
            return np.full(len(x) - 1, np.inf)
        before = np.maximum.accumulate(np.where(ok, np.arange(len(ok)), 0))[:-1]
        after = np.minimum.accumulate(np.where(ok, np.arange(len(ok)), len(ok) - 1)[::-1])[::-1][1:]
        in_gap = ~ok[1:] & ~ok[:-1]
        return np.where(in_gap, GAP_SHARE * (x[after] - x[before]), np.inf)

    def _passes(self, left: Nodes, middle: Nodes, right: Nodes) -> Bools:
        """Tell for which cells the middle holds no surprise."""
        gap = ~left.ok & ~middle.ok
        same = left.ok & middle.ok & (left.label == middle.label)
        with np.errstate(all="ignore"):
            value, slope = hermite(left, right, middle.x)
            off_value, off_slope = np.abs(middle.value - value), np.abs(middle.slope - slope)
            typical = np.abs(left.slope) + np.abs(right.slope) + 0.1 * self.slope_scale
            allowed = VALUE_FIT * self.value_scale
            close = (off_value <= allowed) & (off_slope <= SLOPE_FIT * typical)
            sure = _sign_is_sure(left, middle, off_slope) & _sign_is_sure(middle, right, off_slope)
            # Where the value does not change in any digit, slopes have no consequence.
            flat = self._flat(left, middle) & self._flat(middle, right)
            flat &= off_value <= allowed + FLAT * np.abs(middle.value)
        return np.asarray(gap | (same & ((close & sure) | flat)))

    def _flat(self, left: Nodes, right: Nodes) -> Bools:
        """Tell for which cells the slopes at the ends change no digit of the value."""
        steepest = np.maximum(np.abs(left.slope), np.abs(right.slope))
        rounding = FLAT * np.maximum(np.abs(left.value), np.abs(right.value))
        return np.asarray(steepest * (right.x - left.x) <= rounding)


def _wobble(k: Indices) -> Floats:
    """Return numbers in [-1, 1) without pattern, always the same: results can be repeated."""
    return np.asarray(2.0 * ((GOLDEN * k) % 1.0) - 1.0, dtype=np.float64)


def _widen(flags: Bools, place: Indices, n_nodes: int, *, value: bool) -> Bools:
    """Carry flags of cells over to the cells that new nodes have made."""
    kept = np.ones(n_nodes, dtype=bool)
    kept[place] = False
    wide = np.repeat(flags, np.diff(np.flatnonzero(kept)))
    # Nodes before the first or after the last old one do not occur: the ends are nodes.
    if value:
        wide[place] = True
        wide[place - 1] = True
    return wide


def _reach_of_margin(x: Floats, margin: Floats, same: Bools) -> tuple[Floats, Floats]:
    """How far into each cell a quantity falls to 0, going on as in the cell before or after."""
    with np.errstate(all="ignore"):
        slope = np.diff(margin) / np.diff(x)
        from_left = np.where(same[:-1] & (slope[:-1] < 0), -margin[1:-1] / slope[:-1], np.inf)
        from_right = np.where(same[1:] & (slope[1:] > 0), margin[1:-1] / slope[1:], np.inf)
    return np.append(np.inf, from_left), np.append(from_right, np.inf)


def _sign_is_sure(left: Nodes, right: Nodes, error: Floats) -> Bools:
    """Tell where the slope of a cell keeps its sign, or changes it once, beyond doubt."""
    mean = (right.value - left.value) / (right.x - left.x)
    least, most = slope_extremes(mean, left.slope, right.slope)
    least, most = least - SIGN_MARGIN * error, most + SIGN_MARGIN * error
    changes = left.slope * right.slope < 0
    return changes | (least >= 0) | (most <= 0)


def hermite(left: Nodes, right: Nodes, x: Floats) -> tuple[Floats, Floats]:
    """Value and slope, at x inside each cell, of the cubic through those at its two nodes."""
    h, rise = right.x - left.x, right.value - left.value
    t, mean = (x - left.x) / h, rise / h
    a = h * left.slope - rise
    b = rise - h * right.slope
    value: Floats = left.value + t * rise + t * (1 - t) * (a * (1 - t) + b * t)
    slope: Floats = (
        left.slope * (1 - t) * (1 - 3 * t) + right.slope * t * (3 * t - 2) + 6 * mean * t * (1 - t)
    )
    return value, slope


def slope_extremes(mean: Floats, s0: Floats, s1: Floats) -> tuple[Floats, Floats]:
    """Least and largest slope on cells of a cubic, from its mean slope and those at the ends."""
    # slope(t) = s0 + b t + c t^2
    b = 6 * mean - 4 * s0 - 2 * s1
    c = 3 * (s0 + s1 - 2 * mean)
    with np.errstate(all="ignore"):
        t = -b / (2 * c)
        inner = np.where((t > 0) & (t < 1), s0 + b * t / 2, s0)
    return np.minimum(np.minimum(s0, s1), inner), np.maximum(np.maximum(s0, s1), inner)
