"""Where a map stops being one smooth function: label changes and breaks without one, bisected.

Margins of the map, linear or square roots beside a change, foretell it and save most rounds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.mesh import FLAT, WIDE, Mesh, Nodes, finest
from stickslip.analysis.maps.protocol import domain_size, domain_width
from stickslip.results.parts import part

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Map1D

Interval = tuple[float, float]

FINEST: Final = 2.0**-12  # of the spacing of floats at the domain's size: adjacent enough near 0
MAX_ROUNDS: Final = 200  # each halves at least: 65 suffice from any domain to FINEST
TRUSTED: Final = 0.25  # of the bracket: the two sides' forecasts must agree better
RESTED: Final = 4  # rounds: by chance one in sixteen
CLOSE: Final = 1e-3  # of the bracket: ten halvings at once, or a second value to forecast from
FEW: Final = 8  # floats, or parts of a bracket, that are looked at together
TOGETHER: Final = 64  # points that take hardly longer than one
ASIDE: Final = 2.0  # of their disagreement, to either side: expected to hold the change
MAX_SUSPECTS: Final = 256  # breaks without a label that are followed
CROWD: Final = 4  # cuts within the resolution: events that flicker at a tie make two or three
BLURRED: Final = 1e-3  # of the resolution: a wider cut holds more than one tie of events
NEAR: Final = 64.0  # resolutions: doubtful cells this close are one suspect, or none by a break
SCATTER: Final = 4  # floats beside a cut show how far values scatter; a step is as often larger
STEP: Final = 1e-10  # of the range of values: smaller steps are rounding, beside a tie of events
LEAP: Final = 1e-3  # ... and a larger one within the finest resolution is more than a root's
BEND: Final = 1e-6  # of the slopes: smaller changes are beyond what limits can tell

ACCUMULATE: Final = "branches accumulate: more than are followed, and no wide one, in"
TOO_CLOSE: Final = "label changes closer to each other than the resolution, in"
NARROW_END: Final = "a branch narrower than the resolution at the end of the domain,"
LONG_MOTIONS: Final = "motions are long: only wide branches are told apart, in"
LONG_GAPS: Final = "motions that do not return are long: gaps are not probed closely, in"


class Brackets:
    """Brackets of changes of a map, cut into parts or narrowed to what margins foretell."""

    # ``is_left`` tells of brackets, their left ends, points inside and their right ends which of
    # the points are on the left side of the change.

    def __init__(
        self,
        probe: Callable[[Floats], Nodes],
        left: Nodes,
        right: Nodes,
        is_left: Callable[[Indices, Nodes, Nodes, Nodes], Bools],
    ) -> None:
        self.probe, self.left, self.right = probe, left.copy(), right.copy()
        self.is_left = is_left
        self.halve_next = np.zeros(len(left), dtype=bool)
        # Rounds since either end has moved.
        self.rests = np.zeros((2, len(left)), dtype=np.int64)
        # Where the ends were before they last moved.
        self.old_left, self.old_right = left.copy(), right.copy()

    def close(self, are_open: Callable[[], Bools]) -> None:
        """Narrow brackets as long as they are open, and some rounds at most."""
        for _ in range(MAX_ROUNDS):
            k = np.flatnonzero(are_open())
            if not k.size:
                break
            self.narrow(k)

    def narrow(self, k: Indices) -> None:
        """Look at points inside some of the brackets: the more of them, the fewer in each."""
        width = self.right.x[k] - self.left.x[k]
        trials, foretold = self._trials(k)
        asked = np.isfinite(trials)
        self.take_in(k[asked.nonzero()[0]], self.probe(trials[asked]))
        # A forecast that gains less than halving would is not followed twice.
        self.halve_next[k] = foretold & (self.right.x[k] - self.left.x[k] > 0.5 * width)

    def take_in(self, k: Indices, nodes: Nodes) -> None:
        """Move the ends of brackets to new points inside of them; of one bracket in order."""
        inside = (nodes.x > self.left.x[k]) & (nodes.x < self.right.x[k])
        k, nodes = k[inside], nodes.take(inside)
        if not k.size:
            return
        as_left = self.is_left(k, self.left.take(k), nodes, self.right.take(k))
        begins = np.append(True, k[1:] != k[:-1])
        passed: Indices = np.cumsum(~as_left) - ~as_left  # points on the right side
        passed = passed - passed[begins][np.cumsum(begins) - 1]  # ... of this bracket
        leads = as_left & (passed == 0)
        leads &= ~np.append(leads[1:] & ~begins[1:], False)  # the last of them
        ends = ~as_left & (passed == 0)
        self.rests[:, k[begins]] += 1
        self._move((k[leads], nodes.take(leads)), (k[ends], nodes.take(ends)))

    def _move(self, left: tuple[Indices, Nodes], right: tuple[Indices, Nodes]) -> None:
        (i, new_left), (j, new_right) = left, right
        self.rests[0, i] = self.rests[1, j] = 0
        if i.size:
            self.old_left.put(i, self.left.take(i))
            self.left.put(i, new_left)
        if j.size:
            self.old_right.put(j, self.right.take(j))
            self.right.put(j, new_right)

    def _trials(self, k: Indices) -> tuple[Floats, Bools]:
        """Choose points, ascending in a row for each bracket, and tell which are around forecasts.

        Others cut it into equal parts; of a narrow one all floats are taken.
        """
        lower, upper = self.left.x[k], self.right.x[k]
        centre, reach = self._forecast(k)
        ulp = np.spacing(np.maximum(np.abs(lower), np.abs(upper)))
        with np.errstate(invalid="ignore"):
            reach = np.maximum(ASIDE * reach, 2 * ulp)
            foretold = (centre >= lower) & (centre <= upper) & (reach < TRUSTED * (upper - lower))
        foretold &= ~(self.halve_next[k] | (lower < 0) & (upper > 0))  # floats are dense beside 0
        trials = self._parts(k)
        trials[foretold] = np.nan
        trials[foretold, :2] = (centre + np.outer([-1, 1], reach)).T[foretold]
        ulp = np.spacing(np.minimum(np.abs(lower), np.abs(upper)))
        few = upper - lower <= FEW * ulp
        trials[few] = (lower + ulp * np.arange(1, FEW)[:, None]).T[few]
        trials[(trials <= lower[:, None]) | (trials >= upper[:, None])] = np.nan
        return trials, foretold

    def _parts(self, k: Indices) -> Floats:
        """Cut into equal parts, but step close to an end that has rested: it moves at last."""
        lower, upper = self.left.x[k], self.right.x[k]
        # In a gap a point costs much.
        many = min(max(TOGETHER // len(k), 1), FEW - 1)
        n = np.where(self.left.ok[k] & self.right.ok[k], many, 1)[:, None]
        place = np.arange(1, FEW)
        points = lower[:, None] + (upper - lower)[:, None] * (place / (n + 1))
        points[place > n] = np.nan
        crossing = (lower < 0) & (upper > 0)
        points[crossing], points[crossing, 0] = np.nan, 0.0
        step = CLOSE * (upper - lower)
        wide = (step > np.spacing(np.maximum(np.abs(lower), np.abs(upper)))) & ~crossing
        from_left, from_right = wide & (self.rests >= RESTED)[:, k]
        points[from_left, 0] = (lower + step)[from_left]
        points[from_right, n[from_right, 0] - 1] = (upper - step)[from_right]
        return points

    def _forecast(self, k: Indices) -> tuple[Floats, Floats]:
        """Where the margins of both sides vanish together, and how well they agree on it."""
        moves = (self.old_left, self.left), (self.old_right, self.right)
        ends = ((old.take(k), new.take(k)) for old, new in moves)
        sides = [[_zero(*both, exponent) for exponent in (1, 2)] for both in ends]
        pairs = [(a, b) for a in sides[0] for b in sides[1]]
        apart = np.stack([np.abs(a - b) for a, b in pairs])
        apart = np.where(np.isnan(apart), np.inf, apart)
        best = np.argmin(apart, axis=0)
        column = np.arange(len(k))
        centre = np.stack([0.5 * (a + b) for a, b in pairs])[best, column]
        return centre, apart[best, column]


class LabelBrackets(Brackets):
    """Brackets of label changes; where branches crowd, the mesh is resolved less."""

    def __init__(self, mesh: Mesh, left: Nodes, right: Nodes) -> None:
        super().__init__(mesh.probe, left, right, lambda _, lower, x, __: have_same_label(x, lower))
        self.mesh, nodes = mesh, mesh.nodes
        # Two points of either side foretell the change.
        self.old_left = nodes.take(np.maximum(np.searchsorted(nodes.x, left.x) - 1, 0))
        after = np.searchsorted(nodes.x, right.x) + 1
        self.old_right = nodes.take(np.minimum(after, len(nodes) - 1))

    def are_open(self) -> Bools:
        """Tell which are no adjacent floats yet, and matter."""
        return are_apart(self.mesh.f, self.left.x, self.right.x) & ~self._between_slivers()

    def _move(self, left: tuple[Indices, Nodes], right: tuple[Indices, Nodes]) -> None:
        k, nodes = right
        lower, upper = self.left.take(k), self.right.take(k)
        # Below the resolution a third label is only "no longer the left one".
        narrow = upper.x - lower.x <= self.mesh.resolution
        third = ~(have_same_label(nodes, upper) | narrow)
        super()._move(left, right)
        if third.any():
            self._append(nodes.take(third), upper.take(third))
            self._coarsen()

    def _coarsen(self) -> None:
        """Resolve no more than a crowd of the branches that are not wide, the widest of them."""
        order = np.argsort(self.left.x, kind="stable")
        most = self.right.x[order][1:] - self.left.x[order][:-1]  # that a branch may measure
        mesh = self.mesh
        crowd = most[(most > mesh.resolution) & (most < WIDE * domain_width(mesh.f))]
        if len(crowd) > mesh.crowd:
            mesh.resolution = float(np.partition(crowd, -mesh.crowd)[-mesh.crowd])

    def _between_slivers(self) -> Bools:
        """Tell which brackets have slivers on both sides: where they are does not matter."""
        order = np.argsort(self.left.x, kind="stable")
        left, right, step = self.left.x[order], self.right.x[order], self.mesh.resolution
        # Of a branch between two brackets: what it measures at least, and at most.
        least, most = left[1:] - right[:-1], right[1:] - left[:-1]
        sliver, real = most < step, least > BLURRED * step  # real: no tie of events
        between = np.zeros(len(order), dtype=bool)
        narrow = right[1:-1] - left[1:-1] <= BLURRED * step
        between[order[1:-1]] = sliver[1:] & sliver[:-1] & (narrow | real[1:] | real[:-1])
        return between

    def _append(self, left: Nodes, right: Nodes) -> None:
        """Add brackets, between a third label and the one that was known."""
        self.left, self.right = self.left.joined(left), self.right.joined(right)
        self.old_left, self.old_right = self.old_left.joined(left), self.old_right.joined(right)
        no = np.zeros(len(left), dtype=bool)
        self.halve_next = np.concatenate([self.halve_next, no])
        self.rests = np.concatenate([self.rests, np.zeros((2, len(left)), dtype=np.int64)], axis=1)


def _zero(old: Nodes, new: Nodes, exponent: int) -> Floats:
    """Zero of the straight line through margin**exponent at two points of one branch."""
    with np.errstate(all="ignore"):
        before, now = old.margin**exponent, new.margin**exponent
        zero = new.x + now * (new.x - old.x) / (before - now)
        return np.where(have_same_label(old, new) & (before > now), zero, np.nan)


def have_same_label(a: Nodes, b: Nodes) -> Bools:
    """Tell where two nodes have the same label, or both no value."""
    return (a.ok == b.ok) & (a.label == b.label)


def are_apart(f: Map1D, lower: Floats | float, upper: Floats | float) -> Bools:
    """Tell which points have floats between them that are worth a distinction."""
    finest = FINEST * float(np.spacing(domain_size(f)))
    return (np.nextafter(lower, upper) < upper) & (upper - lower > finest)


def rounding_of_points(f: Map1D) -> float:
    """How far points seem to be moved by sums with others, of the size of the whole domain."""
    return FLAT * domain_size(getattr(f, "whole", f))


@part
@dataclass(frozen=True)
class Unresolved:
    """Something that could not be decided, and where.

    Attributes
    ----------
    reason : str
        A sentence.
    lo, hi : float
        The interval of the domain that it concerns.
    period : int
        Period of the orbits in question; 0 where it does not matter.
    distance : float
        How far from a decision, where that is known; else NaN.
    """

    reason: str
    lo: float
    hi: float
    period: int = 0
    distance: float = float("nan")

    def __str__(self) -> str:
        """One line."""
        period = f", period {self.period}" if self.period else ""
        away = "" if np.isnan(self.distance) else f", distance {self.distance:.2g}"
        return f"{self.reason} [{self.lo:.12g}, {self.hi:.12g}]{period}{away}"


@dataclass(frozen=True)
class Discontinuities:
    """Neighbouring points, ``left`` and ``right`` of each break of the map, ascending."""

    left: Nodes
    right: Nodes
    first: Nodes  # outermost points: ends of the domain, or of branches as wide as the resolution
    last: Nodes

    def take(self, index: Bools) -> Discontinuities:
        """Return some of the cuts."""
        return Discontinuities(self.left.take(index), self.right.take(index), self.first, self.last)

    @property
    def starts(self) -> Nodes:
        """First points of the segments between cuts."""
        return self.first.joined(self.right)

    @property
    def ends(self) -> Nodes:
        """Last points of the segments between cuts."""
        return self.left.joined(self.last)

    def __len__(self) -> int:
        """Return the number of cuts."""
        return len(self.left)


def find_discontinuities(mesh: Mesh) -> tuple[Discontinuities, list[Unresolved]]:
    """Refine a mesh in place until nothing is open and every break lies between adjacent floats."""
    search = _Search(mesh)
    mesh.refine()
    while len((pairs := search.new_pairs())[0]):
        search.follow(*pairs)
        mesh.refine()
    search.follow_leaps()
    while search.follow_suspects():
        pass
    return search.result()


class _Search:
    """Brackets of breaks, found and bisected in rounds."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.asked = mesh.resolution  # before branches crowd
        none = mesh.nodes.take(slice(0, 0))
        self.left, self.right = none, none
        self.unresolved: list[Unresolved] = []
        self.suspected: set[Interval] = set()
        self.left_out: list[Interval] = []  # suspects that are not followed

    def new_pairs(self) -> tuple[Nodes, Nodes]:
        """Neighbouring nodes with different labels that no cut separates yet."""
        nodes = self.mesh.nodes
        cells = np.flatnonzero(~nodes.same_as_next())
        cells = cells[~np.isin(nodes.x[cells], self.left.x)]
        left, right = nodes.take(cells), nodes.take(cells + 1)
        # Of many changes within the resolution, only a few are taken apart.
        step, known = self.mesh.resolution, np.sort(self.left.x)
        count = np.searchsorted(known, right.x + step) - np.searchsorted(known, left.x - step)
        crowded = (right.x - left.x <= step) & (count >= CROWD)
        self._keep(left.take(crowded), right.take(crowded))
        return left.take(~crowded), right.take(~crowded)

    def _keep(self, left: Nodes, right: Nodes) -> None:
        self.left, self.right = self.left.joined(left), self.right.joined(right)

    def follow(self, left: Nodes, right: Nodes) -> None:
        """Bisect label changes to adjacent floats and keep them as cuts, with neighbours."""
        brackets = LabelBrackets(self.mesh, left, right)
        brackets.close(brackets.are_open)
        self._keep(brackets.left, brackets.right)
        self._keep_neighbours(brackets.left, brackets.right)

    def _keep_neighbours(self, left: Nodes, right: Nodes) -> None:
        """Put the cuts into the mesh, and a point of each branch at the resolution from them."""
        step = self.mesh.resolution
        lo, hi = self.mesh.f.domain
        starts, ends = np.sort(self.right.x), np.sort(self.left.x)
        start = np.append(-np.inf, starts)[np.searchsorted(starts, left.x, "right")]
        end = np.append(ends, np.inf)[np.searchsorted(ends, right.x)]
        # In a gap a neighbour would tell nothing, and may cost much; a sliver has none.
        on_left, on_right = left.ok & (left.x - start > step), right.ok & (end - right.x > step)
        inside_left = self.mesh.probe(np.maximum(left.x[on_left] - step, lo))
        inside_right = self.mesh.probe(np.minimum(right.x[on_right] + step, hi))
        self.mesh.insert(left.joined(right).joined(inside_left).joined(inside_right))

    def follow_leaps(self) -> None:
        """Bisect, by values alone, what rises by so much that a jump may hide in the slopes."""
        # Beside a singular jump they are as steep as the step.
        nodes = self.mesh.nodes
        left, right = nodes.take(slice(None, -1)), nodes.take(slice(1, None))
        leaps = self._leaps(left, right) & nodes.same_as_next() & ~self._hold_cuts(left, right)
        brackets = Brackets(
            self.mesh.probe,
            left.take(leaps),
            right.take(leaps),
            lambda _, low, x, high: np.abs(x.value - low.value) < np.abs(high.value - x.value),
        )
        brackets.close(
            lambda: (
                are_apart(self.mesh.f, brackets.left.x, brackets.right.x)
                & self._leaps(brackets.left, brackets.right)
            )
        )
        left, right = brackets.left, brackets.right
        real = self._leaps(left, right) & (np.abs(right.value - left.value) > _smooth(left, right))
        self._keep(left.take(real), right.take(real))

    def _leaps(self, left: Nodes, right: Nodes) -> Bools:
        """Tell between which points, no farther than the finest resolution, values differ so."""
        leaps = np.abs(right.value - left.value) > LEAP * self.mesh.value_scale
        return np.asarray(leaps & (right.x - left.x <= 1.5 * finest(self.mesh.f)))

    def follow_suspects(self) -> bool:
        """Bisect breaks without a label, by which side a point is more like; tell if one is new."""
        fresh = [ends for ends in self._suspects() if ends not in self.suspected]
        suspects = self._most_isolated(fresh, MAX_SUSPECTS - len(self.suspected))
        self.left_out += {*fresh} - {*suspects}
        if not suspects:
            return False
        self.suspected.update(suspects)
        mesh = self.mesh
        low, high = (mesh.probe(np.array(side)) for side in zip(*suspects, strict=True))
        brackets = Brackets(mesh.probe, low, high, lambda _, *nodes: _more_like_left(*nodes))
        brackets.close(lambda: are_apart(mesh.f, brackets.left.x, brackets.right.x))
        left, right = brackets.left, brackets.right
        # At a pole itself there is no value: a gap, of one float.
        gap = left.ok != right.ok
        mesh.insert(left.joined(right).take(np.append(gap, gap)))
        self.follow(*self.new_pairs())
        real = self._is_break(left, right) & ~gap
        real &= ~np.isin(left.x, self.left.x)
        self._keep(left.take(real), right.take(real))
        self._keep(*self._lost(low, high))
        return bool((real | gap).any() and not self.left_out)

    def _lost(self, low: Nodes, high: Nodes) -> tuple[Nodes, Nodes]:
        """Cells of suspects in which the value steps and bisection has found no break."""
        left, right = self._stepping()
        order = np.argsort(low.x)
        suspect = np.searchsorted(low.x[order], left.x, "right") - 1
        suspected = (suspect >= 0) & (right.x <= high.x[order][suspect])
        left, right = left.take(suspected), right.take(suspected)
        lost = np.abs(right.value - left.value) > self._noise(left, right)
        return left.take(lost), right.take(lost)

    def _hold_cuts(self, left: Nodes, right: Nodes) -> Bools:
        """Tell which cells have a cut inside that is known."""
        return np.diff(np.searchsorted(np.sort(self.left.x), [left.x, right.x]), axis=0)[0] > 0

    def _most_isolated(self, suspects: list[Interval], n: int) -> list[Interval]:
        """Choose those farthest from all other doubtful cells."""
        if len(suspects) <= n:
            return suspects
        lo, hi = np.array(sorted({*self.mesh.doubtful, *suspects})).T
        begins = np.flatnonzero(_begin(lo, hi, 0.0))
        room = np.concatenate([[np.inf], lo[begins[1:]] - hi[begins[1:] - 1], [np.inf]])
        run = np.searchsorted(lo[begins], [lower for lower, _ in suspects], "right")
        order = np.argsort(-np.minimum(room[run - 1], room[run]), kind="stable")
        return [suspects[i] for i in np.sort(order[:n])]

    def _is_break(self, left: Nodes, right: Nodes) -> Bools:
        """Tell whether adjacent floats differ by more than a smooth function could."""
        with np.errstate(all="ignore"):
            steep = np.abs(left.slope) + np.abs(right.slope)
            smooth_step = _smooth(left, right)
            smooth_step = np.where(_steps_back(left, right), 0.0, smooth_step)
            step = np.abs(right.value - left.value) - smooth_step - self._noise(left, right)
            bend = np.abs(right.slope - left.slope) / (self.mesh.slope_scale + steep)
        # Where the slope is infinite the quotient is NaN, and a break all the same.
        return (step > STEP * self.mesh.value_scale) | ~(bend <= BEND)

    def _noise(self, left: Nodes, right: Nodes) -> Floats:
        """How far values beside a cut scatter: where motions are sensitive, by more than ulp."""
        # Not closer: where rounding decides, values of both sides alternate for some floats. Nor
        # closer to each other: what is computed from points near 0 is rounded as from others.
        found = []
        aside = BLURRED * self.asked + np.arange(SCATTER + 1) * rounding_of_points(self.mesh.f)
        for end, inward in ((left, -1), (right, 1)):
            x = end.x[:, None] + inward * aside
            values, _ = self.mesh.slopes(np.clip(x, *self.mesh.f.domain).ravel())
            found.append(np.ptp(values.reshape(x.shape), axis=1))
        return np.nan_to_num(SCATTER * np.maximum(*found))

    def _suspects(self) -> list[Interval]:
        """Clusters of doubtful cells away from the cuts that are known already; steps beside them.

        Beside a square root cells are doubtful, too, but no value steps.
        """
        stepping = np.stack([end.x for end in self._stepping()], axis=1)
        ends = self._joined(self._doubts())
        # One bisection finds one step: of several in a cluster, as of those by a cut, each is one.
        inside = (stepping[:, :1] >= ends[:, 0]) & (stepping[:, 1:] <= ends[:, 1])
        crowded = inside.sum(axis=0) > 1
        alone = self._by_break(*stepping.T) | inside[:, crowded].any(axis=1)
        return [*map(tuple, ends[~crowded].tolist()), *map(tuple, stepping[alone].tolist())]

    def _stepping(self) -> tuple[Nodes, Nodes]:
        """Return the ends of cells, as narrow as the resolution, in which the value steps."""
        nodes = self.mesh.nodes
        left, right = nodes.take(slice(None, -1)), nodes.take(slice(1, None))
        steps = nodes.same_as_next() & is_step(left, right, self.mesh.value_scale)
        steps &= (right.x - left.x <= 1.5 * self.mesh.resolution) & ~self._hold_cuts(left, right)
        return left.take(steps), right.take(steps)

    def _by_break(self, lo: Floats, hi: Floats) -> Bools:
        """Tell which intervals are close to a break that is known, or to an end of the domain."""
        # The ends of the domain may be singular, too.
        breaks = np.sort(np.concatenate([self.left.x, self.right.x, self.mesh.f.domain]))
        near = NEAR * self.mesh.resolution
        return np.searchsorted(breaks, hi + near) > np.searchsorted(breaks, lo - near, "right")

    def _doubts(self) -> Floats:
        """Doubtful cells away from breaks that are known, ascending, (n, 2)."""
        cells = np.array(sorted(self.mesh.doubtful)).reshape(-1, 2)
        return cells[~self._by_break(*cells.T)]

    def _joined(self, intervals: Floats) -> Floats:
        """Join ascending intervals that are near each other, with no known break between them."""
        lo, hi = intervals.T
        n_breaks = np.searchsorted(np.sort(self.right.x), intervals, "right")
        begins = _begin(lo, hi, NEAR * self.mesh.resolution)
        begins[1:] |= n_breaks[1:, 0] != n_breaks[:-1, 1]
        first = np.flatnonzero(begins)
        return np.stack([lo[first], np.maximum.reduceat(hi, first)], axis=1)

    def _give_up(self) -> None:
        """Cut out what suspects hide that are not followed: of it nothing is known."""
        unknown = np.concatenate([self.left_out, self._doubts()])
        for lo, hi in self._joined(unknown[np.lexsort(unknown.T[::-1])]).tolist():
            first, last = np.searchsorted(self.mesh.nodes.x, [[lo], [hi]])
            outside = (self.left.x < lo) | (self.right.x > hi)
            self.left, self.right = self.left.take(outside), self.right.take(outside)
            self._keep(self.mesh.nodes.take(first), self.mesh.nodes.take(last))

    def result(self) -> tuple[Discontinuities, list[Unresolved]]:
        """Discontinuities in ascending order; what lies between slivers is one cut, or a gap."""
        mesh = self.mesh
        if self.left_out:
            self._give_up()
        order = np.argsort(self.left.x, kind="stable")
        left, right, step = self.left.take(order), self.right.take(order), mesh.resolution
        if mesh.events_left <= 0:
            self.unresolved.append(Unresolved(LONG_MOTIONS, *mesh.f.domain))
        if mesh.left_out:
            ends = np.array([*mesh.left_out])
            self.unresolved.append(Unresolved(LONG_GAPS, float(ends.min()), float(ends.max())))
        # A branch narrower than the resolution is no branch: one cut from its left neighbour
        # to its right one.
        starts = np.ones(len(left), dtype=bool)
        starts[1:] = left.x[1:] - right.x[:-1] >= step
        ends = np.append(starts[1:], True) if len(left) else starts
        left, right = left.take(starts), right.take(ends)
        # Where branches crowd, what is given up may be a thousandth of the domain: no breakpoint.
        width, step = right.x - left.x, self.asked
        for reason, some in (
            (TOO_CLOSE, (width > BLURRED * step) & (width <= step)),
            (ACCUMULATE, width > step),
        ):
            ends_of = zip(left.x[some].tolist(), right.x[some].tolist(), strict=True)
            self.unresolved += [Unresolved(reason, *ends) for ends in ends_of]
        return self._trimmed(*_opened(left, right, width > step)), self.unresolved

    def _trimmed(self, left: Nodes, right: Nodes) -> Discontinuities:
        """Let the map begin and end with branches wider than the resolution."""
        nodes, step = self.mesh.nodes, self.mesh.resolution
        first, last = nodes.take(slice(0, 1)), nodes.take(slice(-1, None))
        if len(left) and left.x[0] - first.x[0] < step:
            self._tell_narrow_end(float(first.x[0]), float(left.x[0]))
            rest = slice(1, None)
            first, left, right = right.take([0]), left.take(rest), right.take(rest)
        if len(left) and last.x[0] - right.x[-1] < step:
            self._tell_narrow_end(float(right.x[-1]), float(last.x[0]))
            last, left, right = left.take([-1]), left.take(slice(-1)), right.take(slice(-1))
        return Discontinuities(left, right, first, last)

    def _tell_narrow_end(self, lo: float, hi: float) -> None:
        """Note a branch at an end of the domain, if it is not in what is told of already."""
        if not any(other.lo <= lo <= hi <= other.hi for other in self.unresolved):
            self.unresolved.append(Unresolved(NARROW_END, lo, hi))


def _begin(lo: Floats, hi: Floats, near: float) -> Bools:
    """Tell which of some ascending intervals are farther than `near` from all before."""
    apart: Bools = lo[1:] - np.maximum.accumulate(hi)[:-1] > near
    return np.append(np.full(len(lo[:1]), True), apart)


def _opened(left: Nodes, right: Nodes, wide: Bools) -> tuple[Nodes, Nodes]:
    """Turn wide cuts, inside which nothing is known, into gaps, with a cut where a branch ends."""
    lower, upper = left.take(wide), right.take(wide)
    inner_left = lower.without_value(np.nextafter(lower.x, upper.x))
    inner_right = upper.without_value(np.nextafter(upper.x, lower.x))
    # Beside a gap it is one with it: no cut.
    left = left.take(~wide).joined(lower.take(lower.ok)).joined(inner_right.take(upper.ok))
    right = right.take(~wide).joined(inner_left.take(lower.ok)).joined(upper.take(upper.ok))
    order = np.argsort(left.x, kind="stable")
    return left.take(order), right.take(order)


def _smooth(left: Nodes, right: Nodes) -> Floats:
    """Largest step between points that finite slopes explain."""
    with np.errstate(all="ignore"):
        steep = (np.abs(left.slope) + np.abs(right.slope)) * (right.x - left.x)
        return np.where(np.isfinite(steep), steep, 0.0)


def is_step(left: Nodes, right: Nodes, scale: float) -> Bools:
    """Tell between which points the value steps: the slopes there do not enclose the mean one."""
    # Smaller steps, of the scale of values, are rounding.
    with np.errstate(all="ignore"):
        mean = (right.value - left.value) / (right.x - left.x)
        low, high = np.minimum(left.slope, right.slope), np.maximum(left.slope, right.slope)
        off = np.maximum(low - mean, mean - high)
        real = np.abs(right.value - left.value) > STEP * scale
        # A slope against the step, however steep beside a singular break, explains none of it.
        along = np.array([np.maximum(np.sign(mean) * end.slope, 0.0) for end in (left, right)])
        real &= off > along.sum(axis=0)
        return np.asarray(left.ok & right.ok & real)


def _steps_back(left: Nodes, right: Nodes, least: Floats | float = 0.0) -> Bools:
    """Tell between which points the value steps against the slopes at both: no smooth one does."""
    with np.errstate(all="ignore"):
        step = right.value - left.value
        rounding = FLAT * np.maximum(np.abs(left.value), np.abs(right.value))
        against = (left.slope * step < 0) & (right.slope * step < 0)
        return np.asarray(against & (np.abs(step) > np.maximum(rounding, least)))


def _more_like_left(left: Nodes, middle: Nodes, right: Nodes) -> Bools:
    """Tell which side continues to the middle: by values at a jump, by slopes at a corner."""
    with np.errstate(all="ignore"):
        off_left = np.abs(middle.value - left.value - left.slope * (middle.x - left.x))
        off_right = np.abs(middle.value - right.value - right.slope * (middle.x - right.x))
        jump = np.abs(right.value - left.value)
        # Beside a jump values scatter by more than their rounding.
        on_left, on_right = (
            _steps_back(*sides, STEP * jump) for sides in ((left, middle), (middle, right))
        )
        by_value = jump > 2 * (np.abs(left.slope) + np.abs(right.slope)) * (right.x - left.x)
        by_slope = np.abs(middle.slope - left.slope) < np.abs(middle.slope - right.slope)
        like_left: Bools = np.where(by_value, off_left < off_right, by_slope)
    like_left = np.where(on_left == on_right, like_left, on_right)
    return np.where(left.ok & right.ok, like_left, middle.ok == left.ok)
