"""Every change of the set of attractors along a parameter: listed, unresolved, or not asked for.

Attractors are looked at on the grid and on both sides of all that is listed. Between two looks
without anything listed the sets must agree.
"""

from __future__ import annotations

from bisect import bisect
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor

Sort: TypeAlias = tuple[str, int]  # kind of an attractor, and its period


@dataclass(frozen=True, eq=False)
class Look:
    """All attractors at a value of the parameter."""

    q: float
    attractors: tuple[Attractor, ...]

    @property
    def sorts(self) -> Counter[Sort]:
        """How many of which kind and period."""
        return Counter((a.kind, a.period) for a in self.attractors)


def accounted(
    looks: Iterable[Look], listed: Iterable[float], max_period: int
) -> tuple[list[UnresolvedChange], list[UnresolvedChange]]:
    """Return the changes between looks that nothing listed explains, and what was not asked for."""
    ordered, values = sorted(looks, key=lambda look: look.q), sorted(listed)
    unresolved = []
    parts: list[tuple[float, float, Counter[Sort]]] = []  # where attractors are not asked for
    for one, two in pairwise(ordered):
        first, last = bisect(values, one.q), bisect(values, two.q)
        if first == last:
            gone, new = one.sorts - two.sorts, two.sorts - one.sorts
            if not _may_change(gone, new, max_period):
                reason = f"{_told(gone)} before, {_told(new)} after, and nothing located between"
                unresolved.append(UnresolvedChange(reason, one.q, two.q))
        ends = (one.q, values[first], values[last - 1], two.q) if first < last else (one.q, two.q)
        sides = ((one, ends[:2]), (two, ends[-2:])) if first < last else ((one, ends), (two, ends))
        for look, (lo, hi) in sides:
            beyond = Counter({s: n for s, n in look.sorts.items() if _beyond(s, max_period)})
            if beyond:
                parts.append((lo, hi, beyond))
    return unresolved, [_outside(part, max_period) for part in _joined(parts)]


def _beyond(sort: Sort, max_period: int) -> bool:
    """Whether windows of longer periods may lie beside an attractor, or it is one."""
    return sort[0] != "periodic" or sort[1] > max_period


def _may_change(gone: Counter[Sort], new: Counter[Sort], max_period: int) -> bool:
    """Whether orbits beyond the longest period asked for can make this change."""
    both = gone + new
    if any(not _beyond(sort, max_period) for sort in both):
        return False
    return not both or any(kind != "chaotic" or period > max_period for kind, period in both)


def _joined(
    parts: Sequence[tuple[float, float, Counter[Sort]]],
) -> list[tuple[float, float, Counter[Sort]]]:
    """Join intervals that touch or overlap."""
    joined: list[tuple[float, float, Counter[Sort]]] = []
    for lo, hi, seen in sorted(parts, key=lambda part: part[:2]):
        if joined and lo <= joined[-1][1]:
            start, stop, known = joined[-1]
            joined[-1] = start, max(stop, hi), known | seen
        else:
            joined.append((lo, hi, seen))
    return joined


def _outside(part: tuple[float, float, Counter[Sort]], max_period: int) -> UnresolvedChange:
    lo, hi, seen = part
    reason = (
        f"{_told(seen)}: what becomes of cycles above period {max_period} is outside the question"
    )
    return UnresolvedChange(reason, lo, hi)


def _told(sorts: Counter[Sort]) -> str:
    """Say which attractors: cycles by their periods, chaos by its bands."""
    cycles = [str(period) for kind, period in sorted(sorts) if kind == "periodic"]
    bands = [str(period) for kind, period in sorted(sorts) if kind == "chaotic"]
    texts = []
    if cycles:
        texts.append(f"cycles of period {', '.join(cycles)}")
    if bands:
        texts.append(f"chaos in {', '.join(bands)} bands")
    if any(kind == "undecided" for kind, _ in sorts):
        texts.append("undecided motions")
    return " and ".join(texts) or "nothing"
