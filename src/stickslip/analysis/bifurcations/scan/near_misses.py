"""Where pairs of events may hide between two lists of orbits that agree.

Where the parabola through three values of a function all but reaches 0, a list in between helps.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision, Fold
from stickslip.analysis.bifurcations.scan.break_images import images_of_breaks
from stickslip.analysis.bifurcations.scan.events import Suspect
from stickslip.analysis.maps.protocol import Labels, mix_labels

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.scan.nodes import Node, SymbolClasses

POINTS: Final = 2000  # of the domain, where f^p is looked at for extrema beside the diagonal
NEAR: Final = 0.1  # of the change from value to value: an extremum this small may be zero
SAME_PLACE: Final = 0.05  # of the domain: an extremum is followed so far from value to value
AT_END: Final = 1e-4  # of the value before: a function this small at an end may be zero there
TOO_CLOSE: Final = 0.02  # of the spacing: nothing new can be seen so close to a list


@dataclass(frozen=True)
class NearZero:
    """A function of the parameter that vanishes where orbits are born or lost, at one value."""

    what: Hashable  # tells functions apart: border, side and word; or an extremum's kind and period
    x: float  # where in the domain
    distance: float  # the function
    condition: Fold | Collision  # that it is zero


def near_zeros(node: Node, max_period: int, classes: SymbolClasses) -> list[NearZero]:
    """Evaluate all functions that can be evaluated at a node."""
    images = images_of_breaks(node.table, max_period, classes)
    borders = [
        NearZero(
            (name, one.word[:k]), one.border.x, one.off[k], Collision(k + 1, one.border, one.side)
        )
        for name, one in images.items()
        for k in range(len(one.off))
    ]
    return [*borders, *_extrema(node, max_period)]


def _extrema(node: Node, max_period: int) -> Iterator[NearZero]:
    """Distances from the diagonal of the extrema of f^p(x) - x, on the fast map."""
    fast = node.fast
    lo, hi = node.f.domain
    x = lo + (hi - lo) * (np.arange(POINTS) + 0.5) / POINTS
    orbit, slopes = fast.iterate_with_slopes(x, max_period)
    labels = node.table.labels_at(orbit[:, :-1])
    word: Labels = np.zeros(POINTS, dtype=np.uint64)
    slope = np.ones(POINTS)
    for period in range(1, max_period + 1):
        word = mix_labels(word, labels[:, period - 1])
        with np.errstate(over="ignore", invalid="ignore"):  # where breaks accumulate
            slope = slope * slopes[:, period - 1]
        off, tilt = orbit[:, period] - x, slope - 1
        turns = (np.sign(tilt[:-1]) * np.sign(tilt[1:]) < 0) & (word[:-1] == word[1:])
        known = np.isfinite(off) & np.isfinite(tilt)
        for k in np.flatnonzero(turns & known[:-1] & known[1:]):
            share = tilt[k] / (tilt[k] - tilt[k + 1])
            width = x[k + 1] - x[k]
            # The parabola with these slopes, from either end: their mean.
            left = off[k] + 0.5 * tilt[k] * share * width
            right = off[k + 1] - 0.5 * tilt[k + 1] * (1 - share) * width
            kind = "lowest" if tilt[k] < 0 else "highest"
            fold = Fold(period, tuple(orbit[k, :period].tolist()))
            place, distance = float(x[k] + share * width), float(0.5 * (left + right))
            yield NearZero((kind, period), place, distance, fold)


def hidden_values(
    values: Sequence[float], seen: Sequence[Sequence[NearZero]], width: float
) -> list[float]:
    """Return where a function may reach zero between lists, the likeliest value first."""
    found: list[tuple[float, float]] = []
    named = [_by_name(there) for there in seen]
    for k in range(1, len(values) - 1):
        for here in seen[k]:
            before = _same(here, named[k - 1], width)
            after = _same(here, named[k + 1], width)
            if before is None or after is None:
                continue
            distances = before.distance, here.distance, after.distance
            found += _touching(values[k - 1 : k + 2], distances)
    apart = TOO_CLOSE * min(b - a for a, b in pairwise(values))
    kept: list[tuple[float, float]] = []
    for q, least in sorted(found):
        clear = all(abs(q - other) > apart for other in (*values, *(q for q, _ in kept[-1:])))
        if clear:
            kept.append((q, least))
    return [q for q, _ in sorted(kept, key=lambda one: one[1])]


def hidden_folds(left: Node, right: Node, max_period: int) -> Iterator[Suspect]:
    """Suspect a fold where an extremum of f^p(x) - x passes 0 between two lists that agree."""
    here, there = (_by_name(list(_extrema(node, max_period))) for node in (left, right))
    for one in (each for named in here.values() for each in named):
        other = _same(one, there, left.width)
        # Of two neighbours one may be gone: each must be the other's nearest.
        if other is not None and one.distance * other.distance < 0:
            if _same(other, here, left.width) is one:
                yield Suspect(one.condition, bracket=(left.q, right.q))


def zeros_at_end(
    here: Sequence[NearZero], before: Sequence[NearZero], width: float
) -> Iterator[Fold | Collision]:
    """Conditions that hold at the end of a range, as far as lists there and before it can tell."""
    named = _by_name(before)
    for one in here:
        there = _same(one, named, width)
        if there is not None and abs(one.distance) < AT_END * abs(there.distance):
            yield one.condition


def _by_name(functions: Sequence[NearZero]) -> dict[Hashable, list[NearZero]]:
    """Gather functions by what they are."""
    named: dict[Hashable, list[NearZero]] = {}
    for one in functions:
        named.setdefault(one.what, []).append(one)
    return named


def _same(here: NearZero, others: dict[Hashable, list[NearZero]], width: float) -> NearZero | None:
    """Return the same function at another value: of those with its name the nearest."""
    named = others.get(here.what, [])
    nearest = min(named, key=lambda other: abs(other.x - here.x), default=None)
    if nearest is None or abs(nearest.x - here.x) > SAME_PLACE * width:
        return None
    return nearest


def _touching(
    values: Sequence[float], distances: tuple[float, float, float]
) -> Iterator[tuple[float, float]]:
    """Yield where the parabola through three values of one sign comes near zero, and how near."""
    (p, q, r), (a, b, c) = values, distances
    if not (a * b > 0 and b * c > 0):
        return
    chords = (b - a) / (q - p), (c - b) / (r - q)
    bend = (chords[1] - chords[0]) / (r - p)
    if bend * b <= 0:
        return
    slope = chords[0] + bend * (q - p)
    turn = -0.5 * slope / bend
    least = (b + 0.5 * slope * turn) * np.sign(b)
    change = max(abs(a - b), abs(c - b))
    if p < q + turn < r and least <= NEAR * change:
        yield float(q + turn), float(least / change)
