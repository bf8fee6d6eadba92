"""Label changes between two points each, closed in on until the points are adjacent floats.

Halving takes 45 evaluations per change. Where the map tells its margin (a distance to the next
change of label, zero at the change) most of them are saved: seen from either side the margin is
linear in x, or a square root; two values on each side foretell its zero, and the two forecasts
tell how good they are by agreeing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from stickslip.analysis.branches.mesh import Bools, Indices, Mesh, Nodes
    from stickslip.analysis.maps.protocol import Floats

MAX_CHANGES: Final = 4096  # label changes followed before the rest is reported as unresolved
FINEST: Final = 2.0**-12  # of the spacing of floats at the domain's size: adjacent enough near 0
MAX_ROUNDS: Final = 200  # each halves at least: 65 suffice from any domain to FINEST
TRUSTED: Final = 0.25  # of the bracket: the two sides' forecasts must agree better
RESTED: Final = 4  # rounds: by chance one in sixteen
CLOSE: Final = 1e-3  # of the bracket: ten halvings at once, or a second value to forecast from
ASIDE: Final = 2.0  # of their disagreement, to either side: expected to hold the change


class LabelBrackets:
    """Brackets of label changes; ``wide`` ones, of which there are too many, are given up."""

    def __init__(self, mesh: Mesh, left: Nodes, right: Nodes, room: int) -> None:
        self.mesh, self.room = mesh, room
        self.left, self.right = left, right
        self.wide = np.zeros(len(left), dtype=bool)
        self.halve_next = np.zeros(len(left), dtype=bool)
        # Rounds since either end has moved.
        self.rests = np.zeros((2, len(left)), dtype=np.int64)
        # Where the ends were before they last moved.
        self.old_left, self.old_right = left, right

    def close(self) -> None:
        """Narrow all brackets to adjacent floats."""
        for _ in range(MAX_ROUNDS):
            active = np.flatnonzero(are_apart(self.mesh, self.left.x, self.right.x) & ~self.wide)
            if not active.size:
                break
            width = self.right.x[active] - self.left.x[active]
            first, second = self._trials(active)
            both = np.isfinite(second)
            nodes = self.mesh.probe(np.concatenate([first, second[both]]))
            self._apply(active, nodes.take(slice(0, len(active))))
            self._apply(active[both], nodes.take(slice(len(active), None)))
            # A forecast that gains less than halving would is not followed twice.
            now = self.right.x[active] - self.left.x[active]
            self.halve_next[active] = both & (now > 0.5 * width)

    def _trials(self, k: Indices) -> tuple[Floats, Floats]:
        """Choose one point per bracket, its middle, or two on either side of a forecast."""
        lower, upper = self.left.x[k], self.right.x[k]
        centre, reach = self._forecast(k)
        ulp = np.spacing(np.maximum(np.abs(lower), np.abs(upper)))
        with np.errstate(invalid="ignore"):
            reach = np.maximum(ASIDE * reach, 2 * ulp)
            first, second = centre - reach, centre + reach
            trusted = (first > lower) & (second < upper) & (reach < TRUSTED * (upper - lower))
        trusted &= ~self.halve_next[k]
        middle = self._middle(k)
        return np.where(trusted, first, middle), np.where(trusted, second, np.nan)

    def _middle(self, k: Indices) -> Floats:
        """Halve, but step close to an end that has rested: it moves at last, or meets the other."""
        lower, upper = self.left.x[k], self.right.x[k]
        step = CLOSE * (upper - lower)
        middle = midpoint(lower, upper)
        beside = np.where(self.rests[0, k] >= RESTED, lower + step, middle)
        beside = np.where(self.rests[1, k] >= RESTED, upper - step, beside)
        wide = step > np.spacing(np.maximum(np.abs(lower), np.abs(upper)))
        return np.where(wide, beside, middle)

    def _forecast(self, k: Indices) -> tuple[Floats, Floats]:
        """Where the margins of both sides vanish together, and how well they agree on it."""
        sides = [
            [_zero(old.take(k), new.take(k), exponent) for exponent in (1, 2)]
            for old, new in ((self.old_left, self.left), (self.old_right, self.right))
        ]
        pairs = [(a, b) for a in sides[0] for b in sides[1]]
        apart = np.stack([np.abs(a - b) for a, b in pairs])
        apart = np.where(np.isnan(apart), np.inf, apart)
        best = np.argmin(apart, axis=0)
        column = np.arange(len(k))
        centre = np.stack([0.5 * (a + b) for a, b in pairs])[best, column]
        return centre, apart[best, column]

    def _apply(self, k: Indices, nodes: Nodes) -> None:
        """Move the end of each bracket that the new point has the label of."""
        inside = (nodes.x > self.left.x[k]) & (nodes.x < self.right.x[k])
        k, nodes = k[inside], nodes.take(inside)
        lower, upper = self.left.take(k), self.right.take(k)
        narrow = upper.x - lower.x <= self.mesh.resolution
        as_left = have_same_label(nodes, lower)
        # Below the resolution a third label is only "no longer the left one".
        as_right = ~as_left & (have_same_label(nodes, upper) | narrow)
        third = ~as_left & ~as_right
        if third.sum() > self.room - len(self.left):
            self.wide[k[third]] = True
            third[:] = False
        i, j = k[as_left], k[as_right | third]
        self.rests[:, k] += 1
        self.rests[0, i] = self.rests[1, j] = 0
        self.old_left = self.old_left.replaced(i, lower.take(as_left))
        self.old_right = self.old_right.replaced(j, upper.take(as_right | third))
        self.left = self.left.replaced(i, nodes.take(as_left))
        self.right = self.right.replaced(j, nodes.take(as_right | third))
        if third.any():
            self._append(nodes.take(third), upper.take(third))

    def _append(self, left: Nodes, right: Nodes) -> None:
        """Add brackets, between a third label and the one that was known."""
        self.left, self.right = self.left.joined(left), self.right.joined(right)
        self.old_left, self.old_right = self.old_left.joined(left), self.old_right.joined(right)
        no = np.zeros(len(left), dtype=bool)
        self.wide = np.concatenate([self.wide, no])
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
    same: Bools = (a.ok == b.ok) & (a.label == b.label)
    return same


def are_apart(mesh: Mesh, lower: Floats, upper: Floats) -> Bools:
    """Tell which points have floats between them that are worth a distinction."""
    finest = FINEST * float(np.spacing(max(abs(end) for end in mesh.f.domain)))
    apart: Bools = (np.nextafter(lower, upper) < upper) & (upper - lower > finest)
    return apart


def midpoint(lower: Floats, upper: Floats) -> Floats:
    """Halve brackets; 0, beside which floats are dense without end, is tried first."""
    return np.where((lower < 0) & (upper > 0), 0.0, 0.5 * (lower + upper))
