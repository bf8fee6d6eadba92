"""What the pieces of f^p tell beforehand about f^p as a map: where to look, and exact limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.limits import Limits

if TYPE_CHECKING:
    from stickslip.analysis.branches.laps import Indices, Laps
    from stickslip.analysis.branches.pieces import Ends, Pieces
    from stickslip.analysis.maps.protocol import Floats

ASIDE: Final = 64  # ulp of the domain's size: sides of a break that was pulled back


@dataclass(frozen=True, eq=False)
class Hints:
    """Shape of a power of a map, as far as its pieces show it; nothing for a plain map."""

    seeds: Floats  # both sides of every break, every turning point, a point of every piece
    starts: Floats  # left and right ends of the pieces, ascending
    ends: Floats
    at_starts: Limits  # one-sided limits of f^p there
    at_ends: Limits
    reach: float  # how far from these positions a break found by bisection may lie

    @classmethod
    def none(cls) -> Hints:
        """Make hints that say nothing."""
        empty = np.empty(0)
        nothing = Limits(empty, empty)
        return cls(empty, empty, empty, nothing, nothing, 0.0)

    def sharpened(self, x: Floats, limits: Limits, *, at_starts: bool) -> Limits:
        """Replace limits at x, extrapolated from samples, where exact ones are known."""
        places, known = (self.starts, self.at_starts) if at_starts else (self.ends, self.at_ends)
        if not len(places):
            return limits
        right = np.clip(np.searchsorted(places, x), 0, len(places) - 1)
        left = np.maximum(right - 1, 0)
        nearest = np.where(np.abs(places[left] - x) < np.abs(places[right] - x), left, right)
        usable = (np.abs(places[nearest] - x) <= self.reach) & np.isfinite(limits.value)
        usable &= np.isfinite(known.value[nearest]) & ~np.isnan(known.slope[nearest])
        return Limits(
            np.where(usable, known.value[nearest], limits.value),
            np.where(usable, known.slope[nearest], limits.slope),
        )


def hints_of(pieces: Pieces, n_breaks: int) -> Hints:
    """Gather hints from all pieces of f^p, where f has ``n_breaks`` breakpoints."""
    lo, hi = pieces.laps.f.domain
    aside = ASIDE * float(np.spacing(max(abs(lo), abs(hi))))
    left, right = pieces.left.orbit[:, 0], pieces.right.orbit[:, 0]
    breaks = np.concatenate(
        [
            ends.orbit[(ends.number >= 0) & (ends.number < n_breaks), 0]
            for ends in (pieces.left, pieces.right)
        ]
    )
    seeds = np.concatenate([breaks - aside, breaks + aside, left, right, 0.5 * (left + right)])
    return Hints(
        np.clip(seeds, lo, hi),
        left,
        right,
        _limits(pieces.laps, pieces.word, pieces.left),
        _limits(pieces.laps, pieces.word, pieces.right),
        2 * aside,
    )


def _limits(laps: Laps, word: Indices, ends: Ends) -> Limits:
    """One-sided values and slopes of f^p at ends of its pieces, by the chain rule."""
    slope = np.ones(len(word))
    for k in range(word.shape[1]):
        lap, x = word[:, k], ends.orbit[:, k]
        _, one = laps.evaluate(lap, x)
        nearer_left = x - laps.left[lap] < laps.right[lap] - x
        at_end = np.where(nearer_left, laps.slope_left[lap], laps.slope_right[lap])
        with np.errstate(invalid="ignore"):
            slope = slope * np.where(ends.depth == k, at_end, one)
    return Limits(ends.orbit[:, -1], slope)
