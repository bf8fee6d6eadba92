"""Pieces of f^p: its smooth monotone intervals, pulled back lap by lap from those of f.

Every end carries its whole one-sided orbit: nothing is computed by iterating across a break.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.breakpoints import Limits
from stickslip.analysis.branches.mesh import RESOLUTION
from stickslip.analysis.maps.protocol import Bools, Floats, Indices, domain_size
from stickslip.numerics.arrays import EPS, Columns

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.branches.laps import Laps

MAX_PIECES: Final = 200_000  # more of them no list of orbits is made for
MOST_LAPS: Final = 2048  # of a map, for which a table is made of what leads where
SAME: Final = 8 * EPS  # of the domain's size: positions that coincide
ASIDE: Final = 64  # ulp of the domain's size: sides of a break that was pulled back


class TooManyPiecesError(RuntimeError):
    """A power of the map has more pieces than are followed."""


@dataclass(frozen=True, eq=False)
class Ends(Columns):
    """Ends of pieces of f^k from one side; arrays of shape (n, ...)."""

    orbit: Floats  # the end, then its images by one-sided continuity; shape (n, k + 1)
    number: Indices  # which end of a lap of f the orbit meets (see `Laps`) ...
    depth: Indices  # ... after how many maps


@dataclass(frozen=True, eq=False)
class Pieces:
    """All smooth monotone pieces of f^k, ascending; arrays of shape (n, ...)."""

    laps: Laps  # of f
    left: Ends  # one-sided orbits of both ends; column 0 is the end itself, column k its image
    right: Ends
    word: Indices  # lap of f that each of the k maps uses; shape (n, k)

    def __len__(self) -> int:
        """Return the number of pieces."""
        return len(self.word)

    @property
    def power(self) -> int:
        """The k of f^k."""
        return int(self.word.shape[1])

    @property
    def direction(self) -> Indices:
        """+1 rising, -1 falling, 0 constant."""
        return self.laps.direction[self.word].prod(axis=1)


def first_pieces(laps: Laps) -> Pieces:
    """Return the laps of f as pieces of f^1."""
    zero = np.zeros(len(laps), dtype=np.intp)
    return Pieces(
        laps,
        Ends(np.column_stack([laps.left, laps.value_left]), laps.end_left, zero),
        Ends(np.column_stack([laps.right, laps.value_right]), laps.end_right, zero),
        np.arange(len(laps))[:, None],
    )


def pieces_of_powers(laps: Laps, max_power: int, *, closed: bool = False) -> Iterator[Pieces]:
    """Yield the pieces of f, f^2, ..., up to a power, or raise `TooManyPiecesError`."""
    # ``laps`` are a table's ``laps``, or its ``pieces`` to have harmless breakpoints count too.
    # ``closed``: those alone that orbits of a period up to that power may visit.
    pieces = first_pieces(laps)
    yield pieces
    images = _EndImages(laps)
    returns = _Returns(laps, max_power) if closed and len(laps) <= MOST_LAPS else None
    for _ in range(max_power - 1):
        pieces = _pulled_back(pieces, images, returns)
        yield pieces


def itineraries(laps: Laps, power: int) -> float:
    """Count the ways to go from a lap back to it in a number of maps; NaN or inf for too many."""
    leads = _Returns(laps, 1).before(np.eye(len(laps), dtype=bool))
    with np.errstate(over="ignore", invalid="ignore"):  # more than all numbers: inf, or NaN
        return float(np.trace(np.linalg.matrix_power(leads.astype(np.float64), power)))


def returning(laps: Laps, power: int) -> Bools:
    """Tell which laps lead back to themselves, or to one beside, in up to a number of maps."""
    leads, n = _Returns(laps, 1), len(laps)
    reach = np.eye(n, dtype=bool) | np.eye(n, k=1, dtype=bool) | np.eye(n, k=-1, dtype=bool)
    found = np.zeros(n, dtype=bool)
    for _ in range(power):
        reach = leads.before(reach)
        found |= np.diagonal(reach)
    return found


class _Returns:
    """Which laps lead to which in a few maps: before what never comes back is pulled back."""

    def __init__(self, laps: Laps, highest: int) -> None:
        self.laps = laps
        self.first, self.stop = self._met(laps.value_min, laps.value_max)
        reach = within = np.eye(len(laps), dtype=bool)
        self.within = [within]  # by the number of maps at most
        for _ in range(highest - 2):
            reach = self.before(reach)
            self.within.append(self.within[-1] | reach)

    def before(self, reach: Bools) -> Bools:
        """Tell from which laps one map leads to laps from which others are reached."""
        count = _counted(reach)
        return np.asarray(count[self.stop] > count[self.first])

    def _met(self, low: Floats, high: Floats) -> tuple[Indices, Indices]:
        """First lap that each interval meets, and the one after the last."""
        # So close laps and images are taken to meet.
        slack = RESOLUTION * domain_size(self.laps.f)
        first = np.searchsorted(self.laps.right, low - slack, side="left")
        stop = np.searchsorted(self.laps.left, high + slack, side="right")
        return first, np.maximum(first, stop)

    def may_close(self, lap: Indices, piece: Indices, pieces: Pieces) -> Bools:
        """Tell for which pairs the piece's image leads back to the lap."""
        ends = pieces.left.orbit[:, -1], pieces.right.orbit[:, -1]
        first, stop = self._met(np.minimum(*ends), np.maximum(*ends))
        count = _counted(self.within[len(self.within) - pieces.power])
        unknown = np.isnan(ends[0] + ends[1])[piece]
        return unknown | (count[stop[piece], lap] > count[first[piece], lap])


def _counted(leads: Bools) -> Indices:
    """Count down the columns, from 0 on."""
    return np.concatenate([np.zeros((1, len(leads)), dtype=np.intp), np.cumsum(leads, axis=0)])


class _EndImages:
    """Orbits of the images of all lap ends: row e is the left end of lap e, row n + e the right."""

    def __init__(self, laps: Laps) -> None:
        self.laps = laps
        rising = np.where(laps.direction < 0, -1, 1)
        # Just inside the left end of a rising lap values are above those at the end.
        self.side = np.concatenate([rising, -rising]).astype(np.intp)
        self.orbit = np.concatenate([laps.value_left, laps.value_right])[:, None]
        self.number = np.concatenate([laps.end_left, laps.end_right])

    def extend(self) -> None:
        """Append one more image to every orbit."""
        x = self.orbit[:, -1]
        # A value that meets an end of a lap but for rounding belongs to the side it comes from.
        lap = self.laps.locate(x + self.side * tolerance(self.laps))
        known = lap >= 0
        value = np.full(x.shape, np.nan)
        value[known], _ = self.laps.evaluate(lap[known], x[known])
        direction = np.where(self.laps.direction[lap] < 0, -1, 1)
        self.side = np.where(known, self.side * direction, self.side)
        self.orbit = np.column_stack([self.orbit, value])

    def ends(self, rows: Indices) -> Ends:
        """Return the images, with the numbers of the ends that they are images of."""
        return Ends(self.orbit[rows], self.number[rows], np.zeros(len(rows), dtype=np.intp))


def _pulled_back(pieces: Pieces, images: _EndImages, returns: _Returns | None) -> Pieces:
    """Pieces of f^(k+1) from those of f^k."""
    laps = pieces.laps
    images.extend()
    lap, piece = _overlaps(pieces)
    if returns is not None:
        closes = returns.may_close(lap, piece, pieces)
        lap, piece = lap[closes], piece[closes]
    falls = laps.direction[lap] < 0
    # Rows of `_EndImages` of the lower and the upper end of each lap's image.
    at_bottom = np.where(falls, len(laps) + lap, lap)
    at_top = np.where(falls, lap, len(laps) + lap)
    lower, upper = pieces.left.take(piece), pieces.right.take(piece)
    lower = _meet(laps, lap, lower, images, at_bottom, laps.value_min[lap] - lower.orbit[:, 0])
    upper = _meet(laps, lap, upper, images, at_top, upper.orbit[:, 0] - laps.value_max[lap])
    left, right = lower.replaced(falls, upper), upper.replaced(falls, lower)
    word = np.column_stack([lap, pieces.word[piece]])
    order = np.lexsort((left.orbit[:, 0], lap))
    return Pieces(laps, left.take(order), right.take(order), word[order])


def _overlaps(pieces: Pieces) -> tuple[Indices, Indices]:
    """Pairs (lap of f, piece of f^k) such that the lap's image meets the piece's inside."""
    laps = pieces.laps
    same = tolerance(laps)
    lefts, rights = pieces.left.orbit[:, 0], pieces.right.orbit[:, 0]
    flat = laps.direction == 0
    slack = np.where(flat, 0.0, same)
    first = np.searchsorted(rights, laps.value_min + slack, side="right")
    stop = np.searchsorted(lefts, laps.value_max - slack, side="left")
    # A constant lap maps into one piece, a point on a border into its left neighbour.
    first = np.where(flat, np.searchsorted(rights, laps.value_min, side="left"), first)
    stop = np.where(
        flat, np.minimum(first + 1, np.searchsorted(lefts, laps.value_max, "right")), stop
    )
    counts = np.maximum(stop - first, 0)
    if counts.sum() > MAX_PIECES:
        raise TooManyPiecesError(
            f"power {pieces.power + 1} of the map has {int(counts.sum())} pieces, more than the "
            f"{MAX_PIECES} that are followed"
        )
    lap, step = runs(counts)
    return lap, first[lap] + step


def runs(count: Indices) -> tuple[Indices, Indices]:
    """Count 0 ... count - 1 for each owner, one after the other: (owner, number)."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)


def _meet(
    laps: Laps, lap: Indices, ends: Ends, images: _EndImages, row: Indices, beyond: Floats
) -> Ends:
    """Pull ends of pieces back through laps, or stop at the lap's own end, a row of the images."""
    same = tolerance(laps)
    own = images.ends(row)
    ends = ends.replaced(beyond > same, own)
    at_lap_end = beyond >= -same
    x = np.concatenate([laps.left, laps.right])[row]
    asked = np.flatnonzero(~at_lap_end)
    x[asked] = _inverse_once(laps, lap[asked], ends.orbit[asked, 0])
    number = np.where(at_lap_end, own.number, ends.number)
    depth = np.where(at_lap_end, 0, ends.depth + 1)
    return Ends(np.column_stack([x, ends.orbit]), number, depth)


def _inverse_once(laps: Laps, lap: Indices, y: Floats) -> Floats:
    """Invert each pair of lap and value only once: neighbouring pieces share their ends."""
    pairs = np.column_stack([lap.astype(np.float64), y])
    unique, back = np.unique(pairs, axis=0, return_inverse=True)
    return laps.inverse(unique[:, 0].astype(np.intp), unique[:, 1])[back.ravel()]


def tolerance(laps: Laps) -> float:
    """Distance below which positions coincide."""
    return SAME * domain_size(laps.f)


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
        nothing = Limits(empty, empty, empty)
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
        return limits.replaced(usable, known.take(nearest))


def hints_of(pieces: Pieces, n_breaks: int) -> Hints:
    """Gather hints from all pieces of f^p, where f has ``n_breaks`` breakpoints."""
    aside = ASIDE * float(np.spacing(domain_size(pieces.laps.f)))
    left, right = pieces.left.orbit[:, 0], pieces.right.orbit[:, 0]
    both = pieces.left.joined(pieces.right)
    breaks = both.orbit[(both.number >= 0) & (both.number < n_breaks), 0]
    seeds = np.concatenate([breaks - aside, breaks + aside, left, right, 0.5 * (left + right)])
    seeds = np.clip(seeds, *pieces.laps.f.domain)
    at_left = _limits(pieces.laps, pieces.word, pieces.left)
    at_right = _limits(pieces.laps, pieces.word, pieces.right)
    return Hints(seeds, left, right, at_left, at_right, 2 * aside)


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
    return Limits(ends.orbit[:, -1], slope, np.zeros(slope.shape))
