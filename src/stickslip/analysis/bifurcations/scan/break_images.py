"""Images of all breaks, between two lists of orbits: none that meets its break is left out.

While the branches that the images of a break visit stay the same, f^k(c) - c is continuous in the
parameter: it vanishes wherever its signs differ. Where the branches change, the interval is cut.
"""

from __future__ import annotations

from bisect import bisect
from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.bifurcations.conditions.orbit_paths import path_from
from stickslip.analysis.bifurcations.scan.events import Suspect
from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd, TrackedDiscontinuity
from stickslip.analysis.branches.mesh import finest
from stickslip.analysis.branches.pieces import returning
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.maps.protocol import EXACT, Indices, MapFamily, sample
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator, Set

    from numpy.typing import NDArray

    from stickslip.analysis.bifurcations.scan.nodes import Family, Node, SymbolClasses
    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.analysis.branches.breakpoints import Breakpoint


# Class of the branch that ends there, which of its ends on that side, side of the break.
Name: TypeAlias = tuple[int, int, int]
Starts: TypeAlias = "dict[int, list[float]]"  # where branches begin, ascending, by their class


@dataclass(frozen=True)
class BreakImages:
    """One side of a break at one value of the parameter."""

    border: TrackedDiscontinuity | DomainEnd
    side: int  # from which side the first image is taken
    word: tuple[int, ...]  # classes of the branches of the images
    off: tuple[float, ...]  # of each image, and of the next one, from the break

    @property
    def place(self) -> complex:
        """Of this end of a branch in the plane of x and f(x) - x: breaks may be beside others."""
        return complex(self.border.x, *self.off[:1])


def images_of_breaks(
    table: BranchTable, max_period: int, classes: SymbolClasses
) -> dict[Name, BreakImages]:
    """Follow both sides of all breaks of a map, and the ends of its domain."""
    breaks = [item for item in table.breakpoints if item.kind != "smooth"]
    sides = dict(_sides(table, breaks, classes))
    x = np.array([value for _, _, value in sides.values()])
    start = np.array([border.x for border, _, _ in sides.values()])
    words, off = [], []
    for _ in range(max_period):
        off.append(x - start)
        got = sample(table.f, x)
        words.append(classes.of(got.label).tolist())
        x = np.where(got.status == OK, got.value, np.nan)
    found = {}
    for j, (name, (border, side, _)) in enumerate(sides.items()):
        gaps = tuple(float(gap[j]) for gap in off if np.isfinite(gap[j]))
        word = tuple(word[j] for word in words[: max(len(gaps) - 1, 0)])
        found[name] = BreakImages(border, side, word, gaps)
    return found


def starts_of_branches(table: BranchTable, classes: SymbolClasses) -> Starts:
    """Gather where branches begin, but the first, by their classes."""
    breaks = [item for item in table.breakpoints if item.kind != "smooth"]
    breaks = [item for item in breaks if np.isfinite(item.right)]
    labels = np.array([item.right_label for item in breaks], dtype=np.uint64)
    found: Starts = {}
    for own, item in zip(classes.of(labels).tolist(), breaks, strict=True):
        found.setdefault(own, []).append(item.d)
    return found


def same_places(one: NDArray[Any], other: NDArray[Any]) -> tuple[Indices, Indices]:
    """Pair ascending places: in order, or those nearest to each other where some were born.

    Real, or complex: points of the plane.
    """
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
            np.array([names[name].place for name in own], dtype=np.complex128)
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
        sides = classes.of(pair).tolist(), (-1, 1), (item.left, item.right), item.scatter
        for own, side, value, scatter in zip(*sides, strict=True):
            # A gap has no images, and those of a logarithm's last value are rounding.
            if np.isfinite(value) and not scatter:
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
    before, after = (images_of_breaks(node.table, max_period, classes) for node in (left, right))
    after = _renamed(after, before)
    busy = _busy(left.table, before, max_period) | _busy(right.table, after, max_period)
    starts = {node.q: starts_of_branches(node.table, classes) for node in (left, right)}
    ends, known = (left.q, right.q), (before, after)
    search = _Search(family, max_period, classes, narrowest, busy, ends, known, starts)
    for name in sorted(set(before) | set(after)):
        yield from search.between(name, (left.q, before.get(name)), (right.q, after.get(name)))


def _busy(table: BranchTable, images: dict[Name, BreakImages], max_period: int) -> set[Name]:
    """Return the breaks that an image of theirs may come back to; all but where some accumulate."""
    if table.resolution <= finest(table.f):
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
    narrowest: float
    busy: set[Name]  # all others are compared at the ends alone
    ends: tuple[float, float]  # of the parameter
    known: tuple[dict[Name, BreakImages], dict[Name, BreakImages]]  # there; names hold at the first
    starts: dict[float, Starts]  # there, and at other values as far as they were asked for
    tables: dict[float, dict[Name, BreakImages]] = field(default_factory=dict)  # at other values

    def between(self, name: Name, low: _Seen, high: _Seen) -> Iterator[Suspect]:
        (p, a), (q, b) = low, high
        if a is None and b is None:
            return
        if a is not None and b is not None:
            found, alike = self._sign_changes(low, high, self._unlabelled)
            if found:  # an image may have passed to another branch of its class
                found, alike = self._sign_changes(low, high, set(a.word + b.word))
            yield from found
            if found or alike:
                return
        if q - p <= self.narrowest or name not in self.busy:
            return
        middle = 0.5 * (p + q), self._at(name, 0.5 * (p + q), low, high)
        yield from self.between(name, low, middle)
        yield from self.between(name, middle, high)

    def _sign_changes(
        self, low: _Seen, high: _Seen, numbered: Set[int]
    ) -> tuple[list[Suspect], bool]:
        """Compare two values as far as the images visit the same branches; tell if they all do."""
        (p, a), (q, b) = low, high
        assert a is not None
        assert b is not None
        one, other = self._word(a, p, numbered), self._word(b, q, numbered)
        same = 0
        while same < min(len(one), len(other)) and one[same] == other[same]:
            same += 1
        lo, hi = self.family.f.domain
        zero, found = EXACT * (hi - lo), list[Suspect]()
        for k in range(min(same + 1, len(a.off), len(b.off))):
            if a.off[k] * b.off[k] < 0 and min(abs(a.off[k]), abs(b.off[k])) > zero:
                nearest = min(a, b, key=lambda one: abs(one.off[k]))
                collision = Collision(k + 1, nearest.border, nearest.side)
                found.append(Suspect(collision, bracket=(p, q)))
        return found, one == other and len(a.off) == len(b.off)

    def _word(self, image: BreakImages, q: float, numbered: Set[int]) -> list[tuple[int, int]]:
        """Return the classes of the branches, and of some of these which one of its class it is."""
        x = (image.border.x + off for off in image.off)
        return [
            (own, bisect(self._starts(q, own), place) if own in numbered else 0)
            for own, place in zip(image.word, x, strict=False)
        ]

    @cached_property
    def _unlabelled(self) -> Set[int]:
        """Classes of branches that meet at a break: no label tells its sides apart."""
        found = set[int]()
        for border in self._borders:
            if border.left_label is not None and border.right_label is not None:
                pair = np.array([border.left_label, border.right_label], dtype=np.uint64)
                one, other = self.classes.of(pair).tolist()
                found |= {one} if one == other else set()
        return found

    def _at(self, name: Name, q: float, low: _Seen, high: _Seen) -> BreakImages | None:
        """Follow one side of a break at a value between two others; None where it is not."""
        f = self.family.at(q)
        if not self._local:
            return self._by_table(q, f).get(name)
        reading = self._reading(name, q, low, high)
        if reading is None or reading.scatter[name[2] > 0]:
            return None
        path = path_from(f, reading, name[2], self.max_period)
        off = tuple((np.array(path.points[1:]) - reading.x).tolist())
        labels = np.array(path.labels[: max(len(off) - 1, 0)], dtype=np.uint64)
        border = cast("TrackedDiscontinuity | DomainEnd", reading.critical)
        return BreakImages(border, name[2], tuple(self.classes.of(labels).tolist()), off)

    def _by_table(self, q: float, f: MapFamily) -> dict[Name, BreakImages]:
        if q not in self.tables:
            table = branch_table(f)
            found = images_of_breaks(table, self.max_period, self.classes)
            self.tables[q] = _renamed(found, self.known[0])
            self.starts[q] = starts_of_branches(table, self.classes)
        return self.tables[q]

    @cached_property
    def _borders(self) -> list[TrackedDiscontinuity]:
        """All breaks at both ends, once for each side."""
        borders = (one.border for known in self.known for one in known.values())
        return [border for border in borders if isinstance(border, TrackedDiscontinuity)]

    @cached_property
    def _local(self) -> bool:
        """Whether breaks are found sooner one by one than by a table: by labels, or as jumps."""
        return all(border.labelled or border.kind == "jump" for border in self._borders)

    def _starts(self, q: float, own: int) -> list[float]:
        """Find where the branches of a class begin."""
        starts = self.starts.setdefault(q, {})
        if not (own in starts or q in self.ends or q in self.tables):
            found = set()
            for name in self.known[0].keys() | self.known[1].keys():
                if name[0] == own and name[2] > 0:
                    low, high = zip(self.ends, (one.get(name) for one in self.known), strict=True)
                    reading = self._reading(name, q, low, high)
                    found |= set() if reading is None else {reading.x}
            starts[own] = sorted(found)
        return starts.get(own, [])

    def _reading(self, name: Name, q: float, low: _Seen, high: _Seen) -> CriticalReading | None:
        """Find a break at a value between two others; None where it is not."""
        places = [(p, one.border) for p, one in (low, high) if one is not None]
        border = places[0][1]
        if isinstance(border, TrackedDiscontinuity):
            values, x = zip(*((p, there.x) for p, there in places), strict=True)
            border = replace(border, x=float(np.interp(q, values, x)))
        try:
            # What takes the place of a break that is gone may end another branch.
            reading = border.at(self.family.at(q), successors=False)
        except ConditionLost:
            return None
        return None if self._is_another(name, border, reading) else reading

    @cached_property
    def _places(self) -> dict[tuple[int | None, int | None], set[float]]:
        """Where the breaks between two branches are at both ends of the parameter."""
        found: dict[tuple[int | None, int | None], set[float]] = {}
        for border in self._borders:
            found.setdefault((border.left_label, border.right_label), set()).add(border.x)
        return found

    def _is_another(
        self, name: Name, border: TrackedDiscontinuity | DomainEnd, reading: CriticalReading
    ) -> bool:
        """Tell whether a break is rather another one, between the same branches or others."""
        if isinstance(border, DomainEnd):
            return False
        own_label = np.array([reading.label(name[2])], dtype=np.uint64)
        if self.classes.of(own_label)[0] != name[0]:
            return True
        own = {known[name].border.x for known in self.known if name in known}
        others = self._places.get((border.left_label, border.right_label), set()) - own
        return any(abs(reading.x - x) < abs(reading.x - border.x) for x in others)
