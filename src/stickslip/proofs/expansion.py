"""Chaos proven: intervals that the map takes into themselves, and a metric in which it expands.

Docs: proofs, expansion.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from math import floor, inf
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.maps.protocol import iterate
from stickslip.proofs.flow import Piece
from stickslip.proofs.jet import box_of, outward
from stickslip.proofs.power import FORKS, Setting, step
from stickslip.proofs.system import decimal, number
from stickslip.proofs.verify.words import HEAVIEST, MOST_CELLS
from stickslip.proofs.wave import Undecided

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.maps.protocol import Floats, Map1D

PLACES: Final = 12  # of the ends of cells
TRANSIENT, SAMPLE = 1000, 10_000  # iterates of the start
CELLS: Final = (2**10, 2**12, 2**14)  # of half the domain, to try
HALVINGS: Final = 12  # of a cell on which the slope is not bounded away from zero
STEPS: Final = 200  # of paths, from which the exponent is guessed
ROUNDS: Final = 20_000  # in which the weights settle
SHARES: Final = (0.99, 0.9, 0.7)  # of the guess, to try
STATED: Final = 0.95  # of the exponent: so that bounds a little wider prove it, too
EXPONENT_PLACES: Final = 6


def proven_expansion(setting: Setting, f: Map1D, d: float) -> dict[str, Any]:
    """Prove that all orbits of some intervals, the orbit of d among them, expand."""
    points = iterate(f, d, TRANSIENT + SAMPLE)[TRANSIENT:]
    if not np.isfinite(points).all():
        raise Undecided("the orbit of the start does not return for ever")
    reason = Undecided("")
    for n in CELLS:
        try:
            return _Cells(setting, n).closed(points).entries()
        except Undecided as error:
            reason = error
    raise reason


@dataclass
class _Cells:
    """Cells of the domain, numbered from left to right, with the pieces of the map on them."""

    setting: Setting
    n: int  # of half the domain
    pieces: dict[int, list[tuple[int, int, float]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.width = Fraction(floor(self.setting.end / self.n * 10**PLACES), 10**PLACES)

    def closed(self, points: Floats) -> _Cells:
        """Take the cells of some points, and all to which their cells may lead."""
        waiting = set(np.floor(points / float(self.width)).astype(int).tolist())
        while waiting:
            k = waiting.pop()
            self.pieces[k] = list(self._on(k * self.width, (k + 1) * self.width, HALVINGS))
            for low, high, _ in self.pieces[k]:
                if low < -self.n or high >= self.n:
                    raise Undecided("the images reach to the end of the domain")
                waiting.update(set(range(low, high + 1)) - self.pieces.keys())
            if len(self.pieces) > MOST_CELLS:
                raise Undecided("the intervals are too many")
        return self

    def _on(self, low: Fraction, high: Fraction, left: int) -> Iterator[tuple[int, int, float]]:
        """Yield first and last cell that an image meets, and the least slope, for each piece."""
        ball = number(low).union(number(high))
        reason = f"the slope is not shown to be away from zero near d = {float(low):.12g}"
        try:
            pieces = step(self.setting, box_of(ball)[0], forks=FORKS)
            least = [_least(piece) for piece in pieces]
        except Undecided as error:
            least, reason = [0.0], str(error)
        if min(least) > 0:
            for piece, slope in zip(pieces, least, strict=True):
                ends = (Fraction(end) / self.width for end in outward(piece.value.range))
                first, last = map(floor, ends)
                yield first, last, slope
            return
        if not left:
            raise Undecided(reason)
        middle = (low + high) / 2
        yield from self._on(low, middle, left - 1)
        yield from self._on(middle, high, left - 1)

    def entries(self) -> dict[str, Any]:
        """Describe the cells, with weights in which the map expands."""
        cells = sorted(self.pieces)
        rows = [(i, *piece) for i, k in enumerate(cells) for piece in self.pieces[k]]
        of, first, last = (np.array([row[k] for row in rows]) for k in range(3))
        met = np.searchsorted(cells, np.stack([first, last], axis=1))
        met[:, 1] += 1
        rate = np.log([row[3] for row in rows])
        starts = np.flatnonzero(np.diff(of, prepend=-1))

        def least(potential: Floats) -> Floats:
            """Least of log |f'| and the potential at its image, cell by cell."""
            ahead = np.minimum.reduceat(np.append(potential, inf), met.ravel())[::2]
            return np.minimum.reduceat(rate + ahead, starts)

        paths = np.zeros(len(cells))
        marks = []
        for _ in range(2):
            for _ in range(STEPS):
                paths = least(paths)
            marks.append(paths.min())
        guess = (marks[1] - marks[0]) / STEPS
        if not guess > 0:
            raise Undecided("the map is not shown to expand along every path of cells")
        for share in SHARES:
            potential = np.zeros(len(cells))
            for _ in range(ROUNDS):
                new = np.minimum(potential, least(potential) - share * guess)
                if np.array_equal(new, potential):
                    return self._described(cells, potential, least)
                potential = new
        raise Undecided("the weights do not settle")

    def _described(self, cells: list[int], potential: Floats, least: Any) -> dict[str, Any]:
        heights = np.exp(potential - potential.max())
        weights = [max(1, round(HEAVIEST * height)) for height in heights.tolist()]
        logs = np.log(np.array(weights, dtype=float))
        unit = 10**EXPONENT_PLACES
        exponent = floor(STATED * (least(logs) - logs).min() * unit) / unit
        if not exponent > 0:
            raise Undecided("the exponent is too small to be stated")
        return {
            "exponent": f"{exponent:.{EXPONENT_PLACES}f}",
            "intervals": [
                [decimal(k * self.width), decimal((k + 1) * self.width), weight]
                for k, weight in zip(cells, weights, strict=True)
            ],
        }


def _least(piece: Piece) -> float:
    """Least of |f'|, rounded down; 0 if nothing is known."""
    slope = piece.value.gradient[0]
    return max(outward(slope.abs_lower())[0], 0.0) if slope.is_finite() else 0.0
