"""Where pieces of f^p meet the diagonal: brackets with exactly one fixed point each.

Rising pieces are halved until bounds of the slope of f^p decide: they may cross up to three times.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.mesh import slope_extremes
from stickslip.analysis.maps.protocol import Bools, Floats, Indices, domain_size
from stickslip.analysis.orbits.orbit import NearFold
from stickslip.numerics.arrays import EPS, Columns
from stickslip.numerics.zeros import MAX_STEPS

if TYPE_CHECKING:
    from stickslip.analysis.branches.laps import Laps
    from stickslip.analysis.branches.pieces import Pieces


TOUCH: Final = 16 * EPS  # of the scale: f^p(x) - x this small may be 0
FLAT: Final = 1e-13  # of the scale: where all of g is smaller nothing can be told
NARROW: Final = 3e-7  # of the scale: width of a fold's bottom that rounding levels
ALONG: Final = 1e-6  # slopes this close to 1, with g = 0: f^p runs along the diagonal
TRUSTED: Final = 0.25  # relative error of the predicted slope above which a cubic means nothing
TILT: Final = 3.1  # largest slope of t^2 (1 - t)^2 over its value in the middle
MAX_PARTS: Final = 100_000  # no more are halved at a time


@dataclass(frozen=True, eq=False)
class Brackets(Columns):
    """Intervals on one piece of f^p each; ``word`` is (n, p), orbits of the ends (n, p + 1)."""

    piece: Indices
    word: Indices
    left: Floats
    right: Floats
    slope_left: Floats  # of f^p at the ends
    slope_right: Floats

    @property
    def off_left(self) -> Floats:
        """f^p(x) - x at the left end."""
        return self.left[:, -1] - self.left[:, 0]

    @property
    def off_right(self) -> Floats:
        """f^p(x) - x at the right end."""
        return self.right[:, -1] - self.right[:, 0]

    @property
    def width(self) -> Floats:
        """Lengths of the intervals."""
        return self.right[:, 0] - self.left[:, 0]


def brackets_on_diagonal(pieces: Pieces, near: float) -> tuple[Brackets, list[NearFold]]:
    """Find an interval for every fixed point of f^p, one per class of shifted words; near-folds."""
    touch = TOUCH * domain_size(pieces.laps.f)
    ends, unknown = (pieces.left.orbit, pieces.right.orbit), np.full(len(pieces), np.nan)
    whole = Brackets(np.arange(len(pieces)), pieces.word, *ends, unknown, unknown)
    # A rising piece overlaps its image, a falling one changes sides of the diagonal.
    changes = (whole.off_left >= -touch) & (whole.off_right <= touch)
    overlaps = (ends[0][:, -1] <= ends[1][:, 0] + touch) & (ends[1][:, -1] >= ends[0][:, 0] - touch)
    candidates = whole.take(np.where(pieces.direction > 0, overlaps, changes))
    candidates = candidates.take(_one_per_class(candidates))
    candidates = candidates.take(~_of_shorter_period(candidates.word, pieces.laps.direction))
    rising = pieces.direction[candidates.piece] > 0
    found, near_folds = _Halving(pieces.laps, candidates.take(rising), near).run()
    return candidates.take(~rising).joined(found), near_folds


def _of_shorter_period(word: Indices, direction: Indices) -> Bools:
    """Tell words whose orbits repeat, by order alone: f^q is monotone where the word is v^(p/q).

    A rising one moves points one way only, and so does the second power of a falling one.
    """
    p, found = word.shape[1], np.zeros(len(word), dtype=np.bool_)
    for q in range(1, p // 2 + 1):
        if p % q == 0:
            falling = (direction[word[:, :q]] < 0).sum(axis=1) % 2 == 1
            repeats = (np.roll(word, q, axis=1) == word).all(axis=1)
            found |= repeats & ~(falling & (p == 2 * q))
    return found


def _one_per_class(candidates: Brackets) -> Indices:
    """Choose one of the pieces that the points of the same orbit visit: the widest."""
    word = candidates.word
    least = word.copy()
    for shift in range(1, word.shape[1]):
        rolled = np.roll(word, -shift, axis=1)
        # Compare lexicographically: where words differ first.
        place, row = np.argmax(rolled != least, axis=1), np.arange(len(word))
        smaller = rolled[row, place] < least[row, place]
        least[smaller] = rolled[smaller]
    if not len(word):
        return np.zeros(0, dtype=np.intp)
    _, group = np.unique(least, axis=0, return_inverse=True)
    order = np.lexsort((-candidates.width, group.ravel()))
    first = np.ones(len(order), dtype=bool)
    first[1:] = np.diff(group.ravel()[order]) > 0
    return np.sort(order[first])


def forward_orbits(
    laps: Laps, word: Indices, x: Floats, lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Follow points through given laps, between two orbits (n, p + 1); the slope of f^p as well."""
    bottom, top = np.minimum(lower, upper), np.maximum(lower, upper)
    orbit, slope = np.empty_like(bottom), np.ones(len(x))
    orbit[:, 0] = x
    for k in range(word.shape[1]):
        value, one = laps.evaluate(word[:, k], orbit[:, k])
        orbit[:, k + 1] = np.clip(value, bottom[:, k + 1], top[:, k + 1])
        slope *= one
    return orbit, slope


class _Halving:
    """Rising pieces, halved until each part has no crossing or one."""

    def __init__(self, laps: Laps, whole: Brackets, near: float) -> None:
        self.laps, self.near = laps, near
        self.scale = domain_size(laps.f)
        self.touch = TOUCH * self.scale
        self.whole = whole
        self.found = whole.take(np.zeros(0, dtype=np.intp))
        self.closest: dict[int, NearFold] = {}

    def run(self) -> tuple[Brackets, list[NearFold]]:
        """Return brackets and near-folds."""
        parts = self.whole
        undecided = self._undecided(parts, *self._steepness(parts))
        parts = self._with_slopes(parts.take(undecided))
        for _ in range(MAX_STEPS):
            if not 0 < len(parts) <= MAX_PARTS:
                break
            parts = self._halve(parts)
        self._give_up(parts)
        crossing = set(self.found.piece.tolist())
        # Beside a crossing the distance is small without a reason.
        notes = [n for k, n in self.closest.items() if not (n.resolved and k in crossing)]
        return self.found, notes

    def _steepness(self, parts: Brackets) -> tuple[Floats, Floats]:
        """Bounds of the slope of f^p on each part: products of bounds along the orbit."""
        least, most = np.ones(len(parts)), np.ones(len(parts))
        for k in range(parts.word.shape[1]):
            a, b = parts.left[:, k], parts.right[:, k]
            one = self.laps.steepness(parts.word[:, k], np.minimum(a, b), np.maximum(a, b))
            with np.errstate(invalid="ignore"):
                least, most = least * one[0], most * one[1]
        return np.nan_to_num(least, nan=0.0), np.nan_to_num(most, nan=np.inf, posinf=np.inf)

    def _undecided(self, parts: Brackets, least: Floats, most: Floats) -> Bools:
        """Settle what the slopes settle; tell which parts are left."""
        monotone = (least >= 1) | (most <= 1)
        left, right = parts.off_left, parts.off_right
        up = (left <= self.touch) & (right >= -self.touch)
        down = (left >= -self.touch) & (right <= self.touch)
        crosses = monotone & np.where(least >= 1, up, down)
        self.found = self.found.joined(parts.take(crosses))
        low, high = _bounds_of_g(left, right, parts.width, least - 1, most - 1)
        sure, end = np.maximum(low, -high), np.minimum(np.abs(left), np.abs(right))
        # Close to the diagonal the bound must be sharp, to tell how close.
        sharp = (sure > self.near) | (end <= 2 * self.near)
        clear = ~monotone & (sure > self.touch) & sharp
        self._note_near(parts.take(clear), end[clear], resolved=True)
        return ~monotone & ~clear

    def _with_slopes(self, parts: Brackets) -> Brackets:
        """Evaluate the slopes of f^p at both ends."""
        points = np.stack([parts.left, parts.right])[:, :, :-1]
        _, slopes = self.laps.evaluate(np.tile(parts.word.ravel(), 2), points.ravel())
        of_powers = slopes.reshape(points.shape).prod(axis=2)
        return Brackets(parts.piece, parts.word, parts.left, parts.right, *of_powers)

    def _halve(self, parts: Brackets) -> Brackets:
        """Return the halves that are still undecided."""
        x = 0.5 * (parts.left[:, 0] + parts.right[:, 0])
        orbit, slope = forward_orbits(self.laps, parts.word, x, parts.left, parts.right)
        error = _slope_error(parts, orbit[:, -1], slope)
        first = Brackets(parts.piece, parts.word, parts.left, orbit, parts.slope_left, slope)
        second = Brackets(parts.piece, parts.word, orbit, parts.right, slope, parts.slope_right)
        halves, error = first.joined(second), np.concatenate([error, error])
        halves, error = self._without_flat(halves, error)
        least, most = self._steepness(halves)
        by_cubic = _cubic_slopes(halves, error)
        undecided = self._undecided(
            halves, np.maximum(least, by_cubic[0]), np.minimum(most, by_cubic[1])
        )
        return halves.take(undecided)

    def _without_flat(self, parts: Brackets, error: Floats) -> tuple[Brackets, Floats]:
        """Put aside parts on which f^p is the diagonal within rounding, or of no width."""
        size = np.maximum(np.abs(parts.off_left), np.abs(parts.off_right))
        width = parts.width
        tilt = np.maximum(np.abs(parts.slope_left - 1), np.abs(parts.slope_right - 1))
        narrow = (width <= NARROW * self.scale) | (tilt <= ALONG)
        hopeless = (size <= FLAT * self.scale) & narrow
        hopeless |= width <= 4 * EPS * self.scale
        self._give_up(parts.take(hopeless))
        return parts.take(~hopeless), error[~hopeless]

    def _give_up(self, parts: Brackets) -> None:
        distance = np.minimum(np.abs(parts.off_left), np.abs(parts.off_right))
        self._note_near(parts, distance, resolved=False)

    def _note_near(self, parts: Brackets, distance: Floats, *, resolved: bool) -> None:
        """Remember how close each piece came to the diagonal without crossing it."""
        for k in np.flatnonzero(distance <= self.near):
            piece = int(parts.piece[k])
            known = self.closest.get(piece)
            if known is None or distance[k] < known.distance or (known.resolved and not resolved):
                x = 0.5 * float(parts.left[k, 0] + parts.right[k, 0])
                period = parts.word.shape[1]
                self.closest[piece] = NearFold(period, x, float(distance[k]), resolved)


def _bounds_of_g(
    left: Floats, right: Floats, width: Floats, least: Floats, most: Floats
) -> tuple[Floats, Floats]:
    """Bounds of a function from its end values and bounds of its slope, least < 0 < most."""
    with np.errstate(all="ignore"):
        # The lowest possible graph falls from the left end and rises to the right one.
        t = np.where(np.isinf(most), width, (right - left - most * width) / (least - most))
        low = left + least * np.clip(t, 0, width)
        t = np.where(np.isinf(most), 0.0, (right - left - least * width) / (most - least))
        high = right - least * (width - np.clip(t, 0, width))
    return low, high


def _slope_error(parts: Brackets, value: Floats, slope: Floats) -> Floats:
    """Error of the slope of a part's cubic, seen in the middle from the true value and slope."""
    # The slope alone would not do: a fourth derivative bends it everywhere but in the middle.
    width = parts.width
    with np.errstate(all="ignore"):
        rise = parts.right[:, -1] - parts.left[:, -1]
        mean = parts.left[:, -1] + 0.5 * rise
        foretold = mean + 0.125 * width * (parts.slope_left - parts.slope_right)
        off_slope = slope - (1.5 * rise / width - 0.25 * (parts.slope_left + parts.slope_right))
        error: Floats = np.abs(off_slope) + TILT * np.abs(value - foretold) / width
    return error


def _cubic_slopes(parts: Brackets, error: Floats) -> tuple[Floats, Floats]:
    """Bounds of the slope from the cubics of the halves, whose error is at most an eighth."""
    s0, s1 = parts.slope_left, parts.slope_right
    with np.errstate(all="ignore"):
        mean = (parts.right[:, -1] - parts.left[:, -1]) / parts.width
        low, high = slope_extremes(mean, s0, s1)
    low, high = low - error, high + error
    # Rounding in the mean slope of a narrow part is no bend.
    noise = 4 * EPS * np.abs(parts.right[:, -1]) / np.maximum(parts.width, EPS)
    trusted = error <= TRUSTED * np.maximum(np.maximum(np.abs(s0), np.abs(s1)), 1.0)
    return (np.where(trusted, low - noise, 0.0), np.where(trusted, high + noise, np.inf))
