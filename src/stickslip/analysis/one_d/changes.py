"""Where a map stops being one smooth function: label changes and breaks without one, bisected."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.one_d.mesh import Mesh, Nodes

if TYPE_CHECKING:
    from stickslip.analysis.one_d.mesh import Bools
    from stickslip.analysis.protocol import Floats

__all__ = ["Cuts", "Unresolved", "find_cuts"]

MAX_CHANGES: Final = 4096  # label changes followed before the rest is reported as unresolved
FINEST: Final = 2.0**-12  # of the spacing of floats at the domain's size: adjacent enough near 0
MAX_ROUNDS: Final = 200  # each halves: 65 suffice from any domain to FINEST
MAX_SUSPECTS: Final = 256  # breaks without a label that are followed
BLURRED: Final = 1e-3  # of the resolution: a wider cut holds more than one tie of events
NEAR: Final = 64.0  # resolutions: doubtful cells this close are one suspect, or none by a break
STEP: Final = 1e-10  # of the range of values: a step between adjacent floats is real above it
BEND: Final = 1e-6  # of the slopes: likewise a change of the slope

ACCUMULATE: Final = "branches accumulate: more label changes than are followed, in"
CLOSE: Final = "label changes closer to each other than the resolution, in"
NARROW_END: Final = "a branch narrower than the resolution at the end of the domain,"
ROUGH: Final = "values look rough: more breaks without a label than are followed, in"


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
class Cuts:
    """Neighbouring points, ``left`` and ``right`` of each break of the map, ascending.

    ``first`` and ``last`` are the outermost points of the map: the ends of its domain, unless
    these belong to branches narrower than the resolution.
    """

    left: Nodes
    right: Nodes
    first: Nodes
    last: Nodes

    def take(self, index: Bools) -> Cuts:
        """Return some of the cuts."""
        return Cuts(self.left.take(index), self.right.take(index), self.first, self.last)

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


def find_cuts(mesh: Mesh) -> tuple[Cuts, list[Unresolved]]:
    """Refine a mesh until nothing is open and every break lies between adjacent floats.

    Parameters
    ----------
    mesh : Mesh
        Refined in place; keeps points close to each break on both sides.

    Returns
    -------
    cuts : Cuts
        Breaks closer to each other than the resolution are one cut.
    unresolved : list of Unresolved
        Intervals with more label changes than ``MAX_CHANGES`` leaves room for.
    """
    search = _Search(mesh)
    mesh.refine()
    while len((pairs := search.new_pairs())[0]):
        search.follow(*pairs)
        mesh.refine()
    search.follow_suspects()
    return search.result()


class _Search:
    """Brackets of breaks, found and bisected in rounds."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        none = mesh.nodes.take(slice(0, 0))
        self.left, self.right = none, none
        self.wide = np.zeros(0, dtype=bool)
        self.unresolved: list[Unresolved] = []
        size = max(abs(end) for end in mesh.f.domain)
        self.finest = float(np.spacing(size)) * FINEST

    def new_pairs(self) -> tuple[Nodes, Nodes]:
        """Neighbouring nodes with different labels that no cut separates yet."""
        nodes = self.mesh.nodes
        cells = np.flatnonzero(~nodes.same_as_next())
        cells = cells[~np.isin(nodes.x[cells], self.left.x)]
        left, right = nodes.take(cells), nodes.take(cells + 1)
        # More changes within the resolution of a known cut are not taken apart.
        close = self._is_close_to_cut(left.x, right.x)
        self._keep(left.take(close), right.take(close), np.zeros(int(close.sum()), dtype=bool))
        return left.take(~close), right.take(~close)

    def _is_close_to_cut(self, lower: Floats, upper: Floats) -> Bools:
        """Tell which brackets begin or end, and fit, within the resolution of a cut."""
        if not len(self.left):
            return np.zeros(len(lower), dtype=bool)
        step = self.mesh.resolution
        starts, stops = np.sort(self.left.x), np.sort(self.right.x)
        before = np.append(stops, np.inf)[np.maximum(np.searchsorted(stops, lower, "right") - 1, 0)]
        after = np.append(starts, np.inf)[np.searchsorted(starts, upper, "left")]
        near = (np.abs(lower - before) <= step) | (after - upper <= step)
        close: Bools = near & (upper - lower <= step)
        return close

    def _keep(self, left: Nodes, right: Nodes, wide: Bools) -> None:
        self.left, self.right = self.left.joined(left), self.right.joined(right)
        self.wide = np.concatenate([self.wide, wide])

    def follow(self, left: Nodes, right: Nodes) -> None:
        """Bisect label changes to adjacent floats and keep them as cuts, with neighbours."""
        left, right, wide = self._bisect_labels(left, right)
        self._keep(left, right, wide)
        self._keep_neighbours(left, right)

    def _bisect_labels(self, left: Nodes, right: Nodes) -> tuple[Nodes, Nodes, Bools]:
        wide = np.zeros(len(left), dtype=bool)
        for _ in range(MAX_ROUNDS):
            active = np.flatnonzero(self._apart(left.x, right.x) & ~wide)
            if not active.size:
                break
            lower, upper = left.take(active), right.take(active)
            middle = self.mesh.probe(_midpoint(lower.x, upper.x))
            narrow = upper.x - lower.x <= self.mesh.resolution
            as_left = _same(middle, lower)
            # Below the resolution a third label is only "no longer the left one".
            as_right = ~as_left & (_same(middle, upper) | narrow)
            third = ~as_left & ~as_right
            room = MAX_CHANGES - len(self.left) - len(left)
            if third.sum() > room:
                wide[active[third]] = True
                third[:] = False
            left = left.replaced(active[as_left], middle.take(as_left))
            right = right.replaced(active[as_right | third], middle.take(as_right | third))
            left = left.joined(middle.take(third))
            right = right.joined(upper.take(third))
            wide = np.concatenate([wide, np.zeros(int(third.sum()), dtype=bool)])
        return left, right, wide

    def _apart(self, lower: Floats, upper: Floats) -> Bools:
        apart: Bools = (np.nextafter(lower, upper) < upper) & (upper - lower > self.finest)
        return apart

    def _keep_neighbours(self, left: Nodes, right: Nodes) -> None:
        """Put the cuts into the mesh, and a point of each branch at the resolution from them."""
        step = self.mesh.resolution
        lo, hi = self.mesh.f.domain
        inside_left = self.mesh.probe(np.maximum(left.x - step, lo))
        inside_right = self.mesh.probe(np.minimum(right.x + step, hi))
        self.mesh.insert(
            left.joined(right)
            .joined(inside_left.take(_same(inside_left, left)))
            .joined(inside_right.take(_same(inside_right, right)))
        )

    def follow_suspects(self) -> None:
        """Bisect breaks without a label: by which side a point is more like."""
        suspects = self._suspects()
        if not suspects:
            return
        left = self.mesh.probe(np.array([lo for lo, _ in suspects]))
        right = self.mesh.probe(np.array([hi for _, hi in suspects]))
        for _ in range(MAX_ROUNDS):
            active = np.flatnonzero(self._apart(left.x, right.x))
            if not active.size:
                break
            lower, upper = left.take(active), right.take(active)
            middle = self.mesh.probe(_midpoint(lower.x, upper.x))
            as_left = _more_like_left(lower, middle, upper)
            left = left.replaced(active[as_left], middle.take(as_left))
            right = right.replaced(active[~as_left], middle.take(~as_left))
        real = self._is_break(left, right)
        self._keep(left.take(real), right.take(real), np.zeros(int(real.sum()), dtype=bool))

    def _is_break(self, left: Nodes, right: Nodes) -> Bools:
        """Tell whether adjacent floats differ by more than a smooth function could."""
        with np.errstate(all="ignore"):
            steep = np.abs(left.slope) + np.abs(right.slope)
            smooth_step = np.where(np.isfinite(steep), steep * (right.x - left.x), 0.0)
            step = np.abs(right.value - left.value) - smooth_step
            bend = np.abs(right.slope - left.slope) / (self.mesh.slope_scale + steep)
        # Where the slope is infinite the quotient is NaN, and a break all the same.
        real: Bools = (step > STEP * self.mesh.value_scale) | ~(bend <= BEND)
        return real

    def _suspects(self) -> list[tuple[float, float]]:
        """Clusters of doubtful cells away from the cuts that are known already."""
        near = NEAR * self.mesh.resolution
        # The ends of the domain may be singular, too.
        breaks = np.concatenate([self.left.x, self.right.x, self.mesh.f.domain])
        clusters: list[tuple[float, float]] = []
        for lo, hi in sorted(self.mesh.doubtful):
            if np.any((breaks > lo - near) & (breaks < hi + near)):
                continue
            if clusters and lo - clusters[-1][1] <= near:
                clusters[-1] = (clusters[-1][0], max(hi, clusters[-1][1]))
            else:
                clusters.append((lo, hi))
        if len(clusters) > MAX_SUSPECTS:
            self.unresolved.append(Unresolved(ROUGH, clusters[MAX_SUSPECTS][0], clusters[-1][1]))
        return clusters[:MAX_SUSPECTS]

    def result(self) -> tuple[Cuts, list[Unresolved]]:
        """Cuts in ascending order, slivers between them merged away."""
        self._open_wide()
        order = np.argsort(self.left.x, kind="stable")
        left, right = self.left.take(order), self.right.take(order)
        # A branch narrower than the resolution is no branch: one cut from its left neighbour
        # to its right one.
        starts = np.ones(len(left), dtype=bool)
        starts[1:] = left.x[1:] - right.x[:-1] >= self.mesh.resolution
        ends = np.append(starts[1:], True) if len(left) else starts
        left, right = left.take(starts), right.take(ends)
        blurred = right.x - left.x > BLURRED * self.mesh.resolution
        for lo, hi in zip(left.x[blurred], right.x[blurred], strict=True):
            self.unresolved.append(Unresolved(CLOSE, float(lo), float(hi)))
        return self._trimmed(left, right), self.unresolved

    def _trimmed(self, left: Nodes, right: Nodes) -> Cuts:
        """Let the map begin and end with branches wider than the resolution."""
        nodes, step = self.mesh.nodes, self.mesh.resolution
        first, last = nodes.take(slice(0, 1)), nodes.take(slice(-1, None))
        if len(left) and left.x[0] - first.x[0] < step:
            self.unresolved.append(Unresolved(NARROW_END, float(first.x[0]), float(left.x[0])))
            first, left, right = (
                right.take(slice(0, 1)),
                left.take(slice(1, None)),
                right.take(slice(1, None)),
            )
        if len(left) and last.x[0] - right.x[-1] < step:
            self.unresolved.append(Unresolved(NARROW_END, float(right.x[-1]), float(last.x[0])))
            last, left, right = (
                left.take(slice(-1, None)),
                left.take(slice(0, -1)),
                right.take(slice(0, -1)),
            )
        return Cuts(left, right, first, last)

    def _open_wide(self) -> None:
        """Turn an interval that was not followed into a gap with a cut at either end."""
        lower, upper = self.left.take(self.wide), self.right.take(self.wide)
        for lo, hi in zip(lower.x, upper.x, strict=True):
            self.unresolved.append(Unresolved(ACCUMULATE, float(lo), float(hi)))
        self.left, self.right = self.left.take(~self.wide), self.right.take(~self.wide)
        inner_left = lower.without_value(np.nextafter(lower.x, upper.x))
        inner_right = upper.without_value(np.nextafter(upper.x, lower.x))
        self.left = self.left.joined(lower).joined(inner_right)
        self.right = self.right.joined(inner_left).joined(upper)


def _same(a: Nodes, b: Nodes) -> Bools:
    """Tell where two nodes have the same label, or both no value."""
    same: Bools = (a.ok == b.ok) & (a.label == b.label)
    return same


def _midpoint(lower: Floats, upper: Floats) -> Floats:
    """Halve brackets; 0, beside which floats are dense without end, is tried first."""
    return np.where((lower < 0) & (upper > 0), 0.0, 0.5 * (lower + upper))


def _more_like_left(left: Nodes, middle: Nodes, right: Nodes) -> Bools:
    """Tell which side continues to the middle: by values at a jump, by slopes at a corner."""
    with np.errstate(all="ignore"):
        off_left = np.abs(middle.value - left.value - left.slope * (middle.x - left.x))
        off_right = np.abs(middle.value - right.value - right.slope * (middle.x - right.x))
        width = right.x - left.x
        jump = np.abs(right.value - left.value)
        by_value = jump > 2 * (np.abs(left.slope) + np.abs(right.slope)) * width
        by_slope = np.abs(middle.slope - left.slope) < np.abs(middle.slope - right.slope)
        like_left: Bools = np.where(by_value, off_left < off_right, by_slope)
    return like_left
