"""Complete lists of orbits at values of a parameter, with what it takes to join them."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.attractors.bands import image, inside, merged
from stickslip.analysis.branches.along.tracked import break_between
from stickslip.analysis.branches.discontinuities import (
    ACCUMULATE,
    LONG_MOTIONS,
    NARROW_END,
    TOO_CLOSE,
)
from stickslip.analysis.branches.mesh import RESOLUTION, WIDE
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.interpolation.interpolated import PROBES, InterpolatedMap, interpolated_map
from stickslip.analysis.maps.derived import windowed
from stickslip.analysis.maps.protocol import EXACT, SAME, domain_width, is_ok, sample
from stickslip.analysis.orbits.newton import OrbitBundle, solve_cyclic
from stickslip.analysis.orbits.periodic import periodic_orbits

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Bools, Floats, Labels, Map1D, MapFamily
    from stickslip.analysis.orbits.orbit import OrbitList, PeriodicOrbit

MARGIN: Final = 0.1  # of what these are mapped to: by more the rest does not exceed it
REMEMBERED: Final = 512  # maps of a family kept: conditions ask for the same values again


class Family:
    """The maps of a family along one parameter, within a window of the domain."""

    def __init__(self, f: MapFamily, name: str, window: tuple[float, float] | None = None) -> None:
        self.f, self.name, self.window = f, name, window
        self._maps: OrderedDict[float, MapFamily] = OrderedDict()

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel to other processes without the maps."""
        return type(self), (self.f, self.name, self.window)

    def whole(self, q: float) -> MapFamily:
        """Return the map at a value of the parameter, on all of its domain."""
        q = float(q)
        found = self._maps.get(q)
        if found is None:
            found = self._maps[q] = self.f.replace(**{self.name: q})
            if len(self._maps) > REMEMBERED:
                self._maps.popitem(last=False)
        return found

    def at(self, q: float) -> MapFamily:
        """Return the map at a value of the parameter, restricted to the window."""
        return windowed(self.whole(q), self.window)


class SymbolClasses:
    """Classes of labels: those on both sides of a harmless breakpoint are one; orbits may pass."""

    def __init__(self) -> None:
        self._smooth: set[tuple[int, int]] = set()
        self._hard: set[tuple[int, int]] = set()
        self._least: dict[int, int] = {}  # of the class of each label that is not alone in it

    def learn(self, table: BranchTable) -> None:
        """Take in the breakpoints of another table."""
        for item in table.breakpoints:
            pair = (min(item.left_label, item.right_label), max(item.left_label, item.right_label))
            (self._smooth if item.kind == "smooth" else self._hard).add(pair)
        classes: dict[int, set[int]] = {}
        for a, b in sorted(self._smooth - self._hard):
            one, other = (classes.get(label, {label}) for label in (a, b))
            # Nor do two labels that meet otherwise somewhere become one by way of a third.
            if not any((min(pair), max(pair)) in self._hard for pair in product(one, other)):
                classes |= dict.fromkeys(one | other, one | other)
        self._least = {label: min(those) for label, those in classes.items()}

    def of(self, labels: Labels) -> Labels:
        """Return the least label of each group, shaped like ``labels``."""
        if not self._least:
            return labels
        flat = [self._least.get(label, label) for label in labels.ravel().tolist()]
        return np.array(flat, dtype=np.uint64).reshape(labels.shape)

    def changed(self, f: Map1D, points: Floats, now: Labels, before: Labels) -> list[int]:
        """Places of points of f that have left their branches, but over harmless breakpoints."""
        moved = np.flatnonzero(self.of(now) != self.of(before)).tolist()
        return [k for k in moved if not self._passed(f, points[k], {int(now[k]), int(before[k])})]

    def _passed(self, f: Map1D, x: float, pair: set[int]) -> bool:
        """Whether two branches that meet harmlessly here, and otherwise elsewhere, do so near x."""
        if tuple(sorted(pair)) not in self._smooth:
            return False
        nearest = break_between(f, x, pair)
        return nearest is not None and nearest.kind == "smooth"


@dataclass(frozen=True, eq=False)
class Node:
    """All orbits up to a period at one value of the parameter."""

    q: float
    f: MapFamily  # restricted to the window
    name: str
    orbits: OrbitList
    table: BranchTable  # of `f`

    @classmethod
    def make(cls, family: Family, max_period: int, q: float) -> Node:
        """List the orbits at a value of the parameter."""
        f = family.at(q)
        table = branch_table(f)
        return cls(float(q), f, family.name, periodic_orbits(f, max_period), table)

    @cached_property
    def fast(self) -> InterpolatedMap:
        """The table as a fast map."""
        return interpolated_map(self.table)

    def why_unlisted(self, points: Floats) -> str:
        """Return why an orbit through points may be missing in the list; empty if it may not."""
        if inside(crowds(self.table), points, self.table.resolution).any():
            return f"orbits on branches narrower than {self.table.resolution:.2g}"
        on_border = {item.lo for item in self.orbits.unresolved if item.period == len(points)}
        if any(np.abs(points - x).min() <= SAME * self.width for x in on_border):
            return "orbits within rounding of a break"
        return ""

    @cached_property
    def bundle(self) -> OrbitBundle:
        """All orbits as arrays."""
        return OrbitBundle.of(self.orbits, self.f)

    @cached_property
    def velocity(self) -> Floats:
        """Derivative of each point by the parameter, padded as the bundle is."""
        return velocity(self.bundle, self.f, self.name)

    @cached_property
    def breaks(self) -> Floats:
        """Places of the breaks that matter, ascending."""
        return np.array([item.d for item in self.table.breakpoints if item.kind != "smooth"])

    @cached_property
    def telling(self) -> bool:
        """Whether labels tell all branches apart: not so for a map that has none."""
        hard = (item for item in self.table.breakpoints if item.kind != "smooth")
        return all(item.left_label != item.right_label for item in hard)

    @cached_property
    def segments(self) -> Labels:
        """Number of breaks left of each point, padded as the bundle is: labels of its own."""
        counts = np.searchsorted(self.breaks, self.bundle.points, side="right")
        return np.where(self.bundle.used, counts, 0).astype(np.uint64)

    @cached_property
    def on_corner(self) -> Bools:
        """Which points lie on a corner, padded as the bundle is: there a label is an accident."""
        corners = np.array([item.d for item in self.table.breakpoints if item.kind == "corner"])
        with np.errstate(invalid="ignore"):
            apart = np.abs(self.bundle.points[..., None] - corners)
            return (apart <= EXACT * self.width).any(axis=-1)

    def find(
        self,
        points: Floats,
        tolerance: float,
        among: Callable[[PeriodicOrbit], bool] = lambda orbit: True,
    ) -> int | None:
        """Place in the list of the orbit nearest to points, smallest first; None if all are off."""
        off = {
            k: float(np.abs(orbit.points - points).max())
            for k, orbit in enumerate(self.orbits)
            if orbit.period == len(points) and among(orbit)
        }
        nearest = min(off, key=off.__getitem__, default=None)
        return nearest if nearest is not None and off[nearest] <= tolerance else None

    def select(self, places: Iterable[int]) -> tuple[PeriodicOrbit, ...]:
        """Return some of the orbits."""
        return tuple(self.orbits[k] for k in sorted(places))

    @property
    def width(self) -> float:
        """Of the domain: the scale of distances."""
        return domain_width(self.f)


def velocity(bundle: OrbitBundle, f: MapFamily, name: str) -> Floats:
    """Differentiate orbits by a parameter: f' x_k' - x_(k+1)' = -df/dq; no answer at a fold."""
    rates = np.full(bundle.points.shape, np.nan)
    if len(bundle):
        rates[bundle.used] = f.parameter_derivative(bundle.points[bundle.used], name)
    return solve_cyclic(bundle.slopes, -rates, bundle.periods)


def crowds(table: BranchTable) -> Floats:
    """Intervals in which a table does not tell branches apart, ascending, shape (k, 2)."""
    narrow = (ACCUMULATE, TOO_CLOSE, NARROW_END)
    spots = [(item.lo, item.hi) for item in table.unresolved if item.reason in narrow]
    spots += [item.interval for item in table.breakpoints if item.quality != "located"]
    return merged(np.array(spots).reshape(-1, 2), 0.0)


def returns_to_crowd(table: BranchTable, max_period: int) -> bool:
    """Tell whether orbits up to a period may pass where a table does not tell branches apart."""
    if any(item.reason == LONG_MOTIONS for item in table.unresolved):
        return True
    crowd, width = crowds(table), domain_width(table.f)
    if not len(crowd):
        return False
    got = sample(table.f, crowd[:, :1] + np.diff(crowd) * (np.arange(PROBES) + 0.5) / PROBES)
    known = is_ok(got).any(axis=1)
    values = np.where(is_ok(got), got.value, np.nan)[known]
    reach = np.column_stack([np.nanmin(values, axis=1), np.nanmax(values, axis=1)])
    # Branches that accumulate have the images of those beside them that are not wide either.
    beside = [
        sorted((b.value_left, b.value_right))
        for b in table
        if np.isin((b.left, b.right), crowd).any() and b.right - b.left < WIDE * width
    ]
    reach = np.concatenate([reach, np.array(beside).reshape(-1, 2)])
    reach += MARGIN * np.diff(reach) * (-1, 1)
    for _ in range(max_period):
        reach = merged(reach + RESOLUTION * width * np.array([-1, 1]), 0.0)
        if ((reach[:, :1] <= crowd[:, 1]) & (reach[:, 1:] >= crowd[:, 0])).any():
            return True
        reach, _ = image(table.f, table.laps, reach, RESOLUTION * width)
    return False
