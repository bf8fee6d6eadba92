"""Images of all breaks, between two lists of orbits: none that meets its break is left out.

While the branches that the images of a break visit stay the same, f^k(c) - c is continuous in the
parameter: it vanishes wherever its signs differ. Where the branches change, the interval is cut.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Final, TypeAlias, cast

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.bifurcations.conditions.orbit_paths import path_from
from stickslip.analysis.bifurcations.scan.events import Suspect
from stickslip.analysis.branches.along.tracked import (
    ConditionLost,
    DomainEnd,
    TrackedDiscontinuity,
)
from stickslip.analysis.branches.mesh import RESOLUTION
from stickslip.analysis.branches.pieces import returning
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.protocol import sample
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses
    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Floats

ZERO: Final = 1e-13  # of the domain: an image so close to its break has no sign

# Class of the branch that ends there, which of its ends on that side, side of the break.
Name: TypeAlias = tuple[int, int, int]


@dataclass(frozen=True)
class BreakImages:
    """One side of a break at one value of the parameter."""

    border: TrackedDiscontinuity | DomainEnd
    side: int  # from which side the first image is taken
    word: tuple[int, ...]  # branches of the images
    off: tuple[float, ...]  # of each image, and of the next one, from the break


def images_of_breaks(
    table: BranchTable, max_period: int, classes: SymbolClasses, *, telling: bool
) -> dict[Name, BreakImages]:
    """Follow both sides of all breaks of a map, and the ends of its domain."""
    breaks = [item for item in table.breakpoints if item.kind != "smooth"]
    places = np.array([item.d for item in breaks])
    sides = dict(_sides(table, breaks, classes))
    x = np.array([value for _, _, value in sides.values()])
    start = np.array([border.x for border, _, _ in sides.values()])
    words, off = [], []
    for _ in range(max_period):
        off.append(x - start)
        got = sample(table.f, x)
        words.append(
            (classes.of(got.label) if telling else np.searchsorted(places, x, "right")).tolist()
        )
        x = np.where(got.status == OK, got.value, np.nan)
    found = {}
    for j, (name, (border, side, _)) in enumerate(sides.items()):
        gaps = tuple(float(gap[j]) for gap in off if np.isfinite(gap[j]))
        word = tuple(word[j] for word in words[: max(len(gaps) - 1, 0)])
        found[name] = BreakImages(border, side, word, gaps)
    return found


def same_places(one: Floats, other: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pair ascending places: in order, or those nearest to each other where some were born."""
    first = np.arange(len(one))
    if len(one) == len(other):
        return first, first
    if not (one.size and other.size):
        return first[:0], first[:0]
    apart = np.abs(one[:, None] - other)
    nearest = apart.argmin(axis=1)
    mutual = apart.argmin(axis=0)[nearest] == first
    return first[mutual], nearest[mutual]


def _renamed(
    found: dict[Name, BreakImages], known: dict[Name, BreakImages]
) -> dict[Name, BreakImages]:
    """Give breaks the names that they have at another value: one that is born shifts no other."""
    renamed = {}
    for own, side in dict.fromkeys((name[0], name[2]) for name in found):
        here, there = (
            [name for name in names if (name[0], name[2]) == (own, side)]
            for names in (found, known)
        )
        places = [
            np.array([names[name].border.x for name in own])
            for names, own in ((found, here), (known, there))
        ]
        pairs = dict(zip(*(k.tolist() for k in same_places(*places)), strict=True))
        for k, name in enumerate(here):
            new = there[pairs[k]] if k in pairs else (own, len(there) + k, side)
            renamed[new] = found[name]
    return renamed


def _sides(
    table: BranchTable, breaks: list[Breakpoint], classes: SymbolClasses
) -> Iterator[tuple[Name, tuple[TrackedDiscontinuity | DomainEnd, int, float]]]:
    """Yield the names of all sides, with what tracks them and the values there."""
    seen: Counter[tuple[int, int]] = Counter()
    for item in breaks:
        pair = np.array([item.left_label, item.right_label], dtype=np.uint64)
        values = item.left, item.right
        for own, side, value in zip(classes.of(pair).tolist(), (-1, 1), values, strict=True):
            if np.isfinite(value):  # a gap has no images
                yield (own, seen[own, side], side), (TrackedDiscontinuity.of(item), side, value)
                seen[own, side] += 1
    whole = getattr(table.f, "whole", table.f).domain
    for upper, (end, own) in enumerate(zip(whole, table.f.domain, strict=True)):
        if end == own:
            side = -1 if upper else 1
            value = float(sample(table.f, end).value)
            yield (-1, upper, side), (DomainEnd(bool(upper), end), side, value)


def hidden_collisions(
    left: Node,
    right: Node,
    family: Family,
    max_period: int,
    classes: SymbolClasses,
    narrowest: float,
) -> Iterator[Suspect]:
    """Suspect collisions where the signs of f^k(c) - c at two nodes differ, for all breaks c."""
    telling = left.telling and right.telling
    before, after = (
        images_of_breaks(node.table, max_period, classes, telling=telling) for node in (left, right)
    )
    after = _renamed(after, before)
    busy = _busy(left.table, before, max_period) | _busy(right.table, after, max_period)
    search = _Search(family, max_period, classes, telling, narrowest, busy, before, after)
    for name in sorted(set(before) | set(after)):
        yield from search.between(name, (left.q, before.get(name)), (right.q, after.get(name)))


def _busy(table: BranchTable, images: dict[Name, BreakImages], max_period: int) -> set[Name]:
    """Return the breaks that an image of theirs may come back to; all but where some accumulate."""
    if table.resolution <= RESOLUTION:
        return set(images)
    laps, back = table.laps, returning(table.laps, max_period)
    ends = {-1: laps.right, 1: laps.left}
    return {name for name, one in images.items() if back[ends[one.side] == one.border.x].any()}


_Seen: TypeAlias = "tuple[float, BreakImages | None]"


@dataclass(frozen=True)
class _Search:
    """Intervals of the parameter, halved until the images of a break visit the same branches."""

    family: Family
    max_period: int
    classes: SymbolClasses
    telling: bool  # labels tell branches apart at both ends
    narrowest: float
    busy: set[Name]  # all others are compared at the ends alone
    known: dict[Name, BreakImages]  # at the first value: their names hold
    known_there: dict[Name, BreakImages]  # at the last one
    seen: dict[float, dict[Name, BreakImages]] = field(default_factory=dict)  # at others

    def between(self, name: Name, low: _Seen, high: _Seen) -> Iterator[Suspect]:
        (p, a), (q, b) = low, high
        if a is None and b is None:
            return
        if a is not None and b is not None:
            found = list(self._sign_changes(a, b, (p, q)))
            yield from found
            if found or (a.word == b.word and len(a.off) == len(b.off)):
                return
        if q - p <= self.narrowest or name not in self.busy:
            return
        middle = 0.5 * (p + q), self._at(name, 0.5 * (p + q), a or b)
        yield from self.between(name, low, middle)
        yield from self.between(name, middle, high)

    def _sign_changes(
        self, a: BreakImages, b: BreakImages, bracket: tuple[float, float]
    ) -> Iterator[Suspect]:
        """Compare two values as far as the images visit the same branches."""
        same = 0
        while same < min(len(a.word), len(b.word)) and a.word[same] == b.word[same]:
            same += 1
        lo, hi = self.family.f.domain
        zero = ZERO * (hi - lo)
        for k in range(min(same + 1, len(a.off), len(b.off))):
            if a.off[k] * b.off[k] < 0 and min(abs(a.off[k]), abs(b.off[k])) > zero:
                nearest = min(a, b, key=lambda one: abs(one.off[k]))
                yield Suspect(Collision(k + 1, nearest.border, nearest.side), bracket=bracket)

    def _at(self, name: Name, q: float, near: BreakImages | None) -> BreakImages | None:
        """Follow one side of a break at another value; None where the break is not."""
        assert near is not None
        f, border = self.family.at(q), near.border
        if isinstance(border, TrackedDiscontinuity):
            if not self.telling:
                if q not in self.seen:
                    found = images_of_breaks(
                        branch_table(f), self.max_period, self.classes, telling=False
                    )
                    self.seen[q] = _renamed(found, self.known)
                return self.seen[q].get(name)
        try:
            # What takes the place of a break that is gone may end another branch.
            reading = border.at(f, successors=False)
        except ConditionLost:
            return None
        if self._is_another(name, border, reading.x):
            return None
        border = cast("TrackedDiscontinuity | DomainEnd", reading.critical)
        path = path_from(f, reading, near.side, self.max_period)
        gaps = np.array(path.points[1:]) - reading.x
        labels = np.array(path.labels[: max(len(gaps) - 1, 0)], dtype=np.uint64)
        word = tuple(self.classes.of(labels).tolist())
        return BreakImages(border, near.side, word, tuple(gaps.tolist()))

    @cached_property
    def _places(self) -> dict[tuple[int | None, int | None], set[float]]:
        """Where the breaks between two branches are at both ends of the parameter."""
        found: dict[tuple[int | None, int | None], set[float]] = {}
        for image in (*self.known.values(), *self.known_there.values()):
            if isinstance(border := image.border, TrackedDiscontinuity):
                found.setdefault((border.left_label, border.right_label), set()).add(border.x)
        return found

    def _is_another(self, name: Name, border: TrackedDiscontinuity | DomainEnd, x: float) -> bool:
        """Tell whether a place is rather that of another break between the same branches."""
        if isinstance(border, DomainEnd):
            return False
        own = {found[name].border.x for found in (self.known, self.known_there) if name in found}
        others = self._places.get((border.left_label, border.right_label), set()) - own
        return any(abs(x - other) < abs(x - border.x) for other in others)
