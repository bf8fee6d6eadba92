"""The range of the map on a box: parts of it, halved until they enclose little more than f takes.

Docs: proofs, ranges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from heapq import heappop, heappush
from itertools import count
from math import inf
from typing import Any, Final, TypeAlias

from flint import arb

from stickslip.proofs.flow import Piece
from stickslip.proofs.jet import box_of, outward
from stickslip.proofs.power import FORKS, MapSetting, step
from stickslip.proofs.system import number
from stickslip.proofs.wave import Undecided

Span: TypeAlias = tuple[Fraction, Fraction]
Ends: TypeAlias = tuple[float, float]

SHARP: Final = 2.0  # what encloses a range, in widths of what is proven to be taken
MOST_PARTS: Final = 2000
DEEPEST: Final = 20  # halvings of the box


@dataclass(frozen=True)
class Part:
    """A box with every piece of the map that is possible on it; none if the box is too wide."""

    box: tuple[Span, ...]
    pieces: tuple[Piece, ...]
    reason: str  # why there is not one piece
    depth: int

    @cached_property
    def outer(self) -> Ends:
        """Lowest and highest value that is possible."""
        if not self.pieces:
            return -inf, inf
        return outward(reduce(arb.union, (piece.value.range for piece in self.pieces)))

    @cached_property
    def inner(self) -> Ends:
        """Values between which f is proven to take all; the lower above the upper if unknown."""
        if len(self.pieces) != 1:
            return inf, -inf
        value = self.pieces[0].value
        steps = zip(value.gradient, value.box, strict=True)
        swing = sum((slope.abs_lower() * step.rad() for slope, step in steps), arb(0))
        return float((value.centre - swing).upper()), float((value.centre + swing).lower())


def parts(setting: MapSetting, box: Sequence[Span], *, most: int = MOST_PARTS) -> list[Part]:
    """Cut a box until its parts enclose at most `SHARP` times what the map takes on it.

    Or until there are so many, or one is too narrow: then those that are too wide are among them.
    """
    found = {0: _part(setting, tuple(box), 0)}
    inner = found[0].inner
    heaps: tuple[list[Any], list[Any]] = [(-inf, 0, 0)], [(-inf, 0, 0)]  # lowest, highest first
    numbers = count(1)
    while len(found) < most:
        ends = []
        for heap in heaps:
            while heap[0][-1] not in found:
                heappop(heap)
            ends.append(heap[0][-1])
        below, above = (found[k] for k in ends)
        beyond = inner[0] - below.outer[0], above.outer[1] - inner[1]
        if above.outer[1] - below.outer[0] <= SHARP * (inner[1] - inner[0]):
            break
        worst = below if beyond[0] >= beyond[1] else above
        if worst.depth == DEEPEST or all(low == high for low, high in worst.box):
            break
        del found[ends[0] if worst is below else ends[1]]
        for half in _halves(worst):
            k, part = next(numbers), _part(setting, half, worst.depth + 1)
            found[k] = part
            inner = hull_of([inner, part.inner])
            heappush(heaps[0], (part.outer[0], -part.depth, k))  # of two, the narrower one first
            heappush(heaps[1], (-part.outer[1], -part.depth, k))
    return list(found.values())


def hull_of(ends: Sequence[Ends]) -> Ends:
    """Return the lowest and the highest."""
    return min(low for low, _ in ends), max(high for _, high in ends)


def _halves(part: Part) -> list[tuple[Span, ...]]:
    """Cut a box in two, along each of its sides in turn."""
    wide = [k for k, (low, high) in enumerate(part.box) if low < high]
    k = wide[part.depth % len(wide)]
    low, high = part.box[k]
    middle = (low + high) / 2
    return [(*part.box[:k], half, *part.box[k + 1 :]) for half in ((low, middle), (middle, high))]


def _part(setting: MapSetting, box: tuple[Span, ...], depth: int) -> Part:
    d, *parameters = box_of(*(number(low).union(number(high)) for low, high in box))
    try:
        pieces = tuple(step(setting, d, parameters, forks=FORKS))
    except Undecided as error:
        return Part(box, (), str(error), depth)
    asked = [decision for piece in pieces for decision in piece.decisions]
    return Part(box, pieces, asked[0].question if asked else "", depth)
