"""The end of a branch near a point where it is expected, closed in on to adjacent floats.

As `discontinuities.LabelBrackets`, but for one change in few calls: 0.5 ms instead of 10 ms.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from stickslip.analysis.branches.discontinuities import are_apart
from stickslip.analysis.branches.mesh import RESOLUTION
from stickslip.analysis.maps.protocol import SAME, Map1D, domain_width, is_ok, sample

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence


NARROWEST: Final = 1e-7  # of the domain: half width of the first fan of points, or bracket
FAN: Final = 8.0  # ratio of distances in a fan
SECTIONS: Final = 5  # points per round where no forecast is at hand: two and a half halvings
TRUSTED: Final = 0.5  # of the bracket: the two sides' forecasts must agree better
ASIDE: Final = (2.0, 64.0)  # of their disagreement, to either side: expected to hold the change


class Branch(NamedTuple):
    """What tells a branch from others, or from a gap."""

    label: int
    ok: bool

    @classmethod
    def of(cls, label: int | None) -> Branch:
        """Return the branch with a label; None stands for a gap."""
        return cls(0, False) if label is None else cls(label, True)


class Seen(NamedTuple):
    """A point of a map and what was found there."""

    x: float
    branch: Branch
    margin: float
    value: float
    slope: float


@dataclass
class Probe:
    """A map and the points of it that are known, ascending."""

    f: Map1D
    seen: list[Seen] = field(default_factory=list)

    def look(self, points: Iterable[float]) -> None:
        """Evaluate at new points, moved into the domain."""
        lo, hi = self.f.domain
        known = {s.x for s in self.seen}
        new = sorted({min(max(x, lo), hi) for x in points} - known)
        if not new:
            return
        values = sample(self.f, np.array(new))
        ok = (is_ok(values) & np.isfinite(values.value)).tolist()
        rest = (values.margin.tolist(), values.value.tolist(), values.derivative.tolist())
        for x, label, good, *what in zip(new, values.label.tolist(), ok, *rest, strict=True):
            item = Seen(x, Branch(label if good else 0, good), *what)
            self.seen.insert(bisect_left(self.seen, x, key=lambda s: s.x), item)

    def extent(self, end: Seen, inward: int) -> float:
        """How far from a point, to the right (1) or left (-1), all that was seen is its branch."""
        reach = 0.0
        for s in self.seen if inward > 0 else reversed(self.seen):
            distance = inward * (s.x - end.x)
            # Labels flicker beside a tie of events: they may be those of either side.
            if distance < SAME * domain_width(self.f):
                continue
            if s.branch != end.branch:
                break
            reach = distance
        return reach


def find_change(
    probe: Probe, left: Branch, right: Branch, x: float, reach: float
) -> tuple[Seen, Seen] | None:
    """Find the last point of one branch and the first of another near x; None if there are none."""
    # Adjacent floats, but for branches narrower than the resolution; also beyond ``reach``.
    found = _change(probe, left, right, x, reach)
    return found if found and _are_wide(probe, *found) else None


def _are_wide(probe: Probe, *ends: Seen) -> bool:
    """Tell branches from what rounding makes of a tie of events: a few floats of a third label."""
    blur = SAME * domain_width(probe.f)
    sides = tuple(zip(ends, (-1, 1), probe.f.domain, strict=True))

    def reach_in() -> bool:
        return all(
            probe.extent(end, inward) > 0 or abs(limit - end.x) <= blur
            for end, inward, limit in sides
        )

    if reach_in():
        return True
    probe.look(end.x + 2 * inward * blur for end, inward, _ in sides)
    return reach_in()


def _change(
    probe: Probe, left: Branch, right: Branch, x: float, reach: float
) -> tuple[Seen, Seen] | None:
    pair = _fan_out(probe, left, right, x, max(reach, NARROWEST * domain_width(probe.f)))
    if pair is None:
        return None
    last, first = close_in(probe, lambda branch: branch == left, pair)
    if first.branch == right:
        return last, first
    sliver = RESOLUTION * domain_width(probe.f)
    probe.look(last.x + sliver * FAN**-k for k in range(4))
    i = bisect_left(probe.seen, last.x, key=lambda s: s.x)
    while i + 1 < len(probe.seen) and probe.seen[i + 1].x <= last.x + sliver:
        if probe.seen[i + 1].branch == right:
            return last, close_in(probe, lambda branch: branch != right, (i, i + 1))[1]
        i += 1
    return None


def close_in(
    probe: Probe, is_left: Callable[[Branch], bool], pair: tuple[int, int]
) -> tuple[Seen, Seen]:
    """Narrow a bracket until its ends are adjacent floats."""
    slow = False
    if probe.seen[pair[0]].x < 0 < probe.seen[pair[1]].x:
        # Floats are dense there without end: a break at 0 is to be found at 0.
        probe.look([0.0])
        pair = _narrowed(probe.seen, is_left, probe.seen[pair[0]].x, probe.seen[pair[1] + 1].x)
    while True:
        left, right = (probe.seen[i] for i in pair)
        if not are_apart(probe.f, left.x, right.x):
            return left, right
        points = [] if slow else _forecast(probe.seen, *pair)
        probe.look(points or _sections(left.x, right.x))
        pair = _narrowed(probe.seen, is_left, left.x, right.x)
        # A forecast that gains less than halving would is not followed twice.
        gained = probe.seen[pair[1]].x - probe.seen[pair[0]].x <= 0.5 * (right.x - left.x)
        slow = bool(points) and not gained


def _fan_out(
    probe: Probe, left: Branch, right: Branch, x: float, reach: float
) -> tuple[int, int] | None:
    """Look ever farther from x until the left branch and something right of it are seen."""
    lo, hi = probe.f.domain
    # The change may be where it is expected, to the float.
    probe.look([*(x + k * reach for k in (-1.0, -1 / FAN, 1 / FAN, 1.0)), *_beside(x)])
    while True:
        pair = _nearest_pair(probe.seen, left, x)
        if pair is not None or (x - reach <= lo and x + reach >= hi):
            return pair
        met = [s.branch for s in probe.seen]
        sides = (1.0,) if left in met else (-1.0,) if right in met else (-1.0, 1.0)
        probe.look(x + side * k * reach for side in sides for k in (FAN, FAN**2))
        reach *= FAN**2


def _nearest_pair(seen: Sequence[Seen], branch: Branch, x: float) -> tuple[int, int] | None:
    """Neighbours of which the left one only is of the branch, the closest to x."""
    pairs = [
        (i, i + 1)
        for i in range(len(seen) - 1)
        if seen[i].branch == branch and seen[i + 1].branch != branch
    ]
    return min(
        pairs, key=lambda pair: max(seen[pair[0]].x - x, x - seen[pair[1]].x, 0.0), default=None
    )


def _narrowed(
    seen: Sequence[Seen], is_left: Callable[[Branch], bool], left: float, right: float
) -> tuple[int, int]:
    """First change inside a bracket."""
    i = bisect_left(seen, left, key=lambda s: s.x)
    while is_left(seen[i + 1].branch) and seen[i + 1].x < right:
        i += 1
    return i, i + 1


def _sections(left: float, right: float) -> list[float]:
    """Points that cut a bracket into equal parts."""
    step = (right - left) / (SECTIONS + 1)
    points = [left + k * step for k in range(1, SECTIONS + 1)]
    points.append(float(np.nextafter(left, right)) if step == 0 else 0.5 * (left + right))
    return [x for x in points if left < x < right]


def _forecast(seen: Sequence[Seen], i: int, j: int) -> list[float]:
    """Points where the margins of both sides vanish, linearly or as roots, if the sides agree."""
    left, right = seen[i], seen[j]
    aside = (right.x - left.x) / FAN  # nearer points tell of rounding
    from_left = _zeros((s for s in reversed(seen[:i]) if left.x - s.x >= aside), left)
    from_right = _zeros((s for s in seen[j + 1 :] if s.x - right.x >= aside), right)
    pairs = [(abs(a - b), 0.5 * (a + b)) for a in from_left for b in from_right]
    if not pairs:
        # From one side alone: a point there gives the other side its second one.
        return [x for x in from_left + from_right if left.x < x < right.x]
    apart, centre = min(pairs)
    ulp = float(np.spacing(max(abs(left.x), abs(right.x))))
    if apart > TRUSTED * (right.x - left.x):
        return []
    near, far = (max(k * apart, k * ulp) for k in ASIDE)
    points = [*(centre + k for k in (-far, -near, near, far)), *_beside(centre)]
    return [x for x in points if left.x < x < right.x]


def _beside(x: float) -> list[float]:
    """Return a float and its neighbours: a few points cost hardly more than one."""
    return [float(np.nextafter(x, -np.inf)), x, float(np.nextafter(x, np.inf))]


def _zeros(behind: Iterator[Seen], new: Seen) -> list[float]:
    """Where the straight lines through margin and through margin squared vanish."""
    old = next(behind, None)
    if old is None or old.branch != new.branch or not old.margin > new.margin >= 0:
        return []
    step = new.x - old.x
    ratios = (new.margin / old.margin, (new.margin / old.margin) ** 2)
    return [new.x + step * r / (1 - r) for r in ratios if r < 1]
