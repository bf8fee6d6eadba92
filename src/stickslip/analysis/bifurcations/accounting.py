"""Every change of the set of attractors along a parameter: listed, unresolved, or not asked for.

Attractors are looked at on the grid and on both sides of all that is listed. Between two looks
without anything listed the sets must agree, but for cycles above the longest period.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Final, TypeAlias, TypeVar

from stickslip.analysis.bifurcations.bifurcation import OUTSIDE, UnresolvedChange
from stickslip.analysis.bifurcations.scan.events import in_the_middle
from stickslip.analysis.scales import FEW_SHOWN
from stickslip.results.table import listed

BESIDE: Final = 2e-3  # of a range: how far from an event both its sides are looked at, at most
MOST_BANDS: Final = 32  # of chaos whose changes are searched thoroughly

Sort: TypeAlias = tuple[str, int]  # kind of an attractor, and its period
Part: TypeAlias = tuple[float, float, set[Sort]]  # of the range, and what attracts there


@dataclass(frozen=True, eq=False)
class Look:
    """What attracts at a value of a parameter; a quick look may miss cycles that lists have."""

    value: float
    attractors: Any  # a sequence, each with a kind, a period, and the orbit of a cycle
    quick: bool = field(default=False, kw_only=True)


LookT = TypeVar("LookT", bound=Look)


def _sorts_of(look: Look, max_period: int) -> Counter[Sort]:
    """Count the attractors at a value by kind and period; slow cycles by their multipliers."""
    # Chaos without cycles that were asked for, as of a window of long ones, by their least period.
    # Beside its stability limit a cycle is too slow to be seen to attract, but it is listed.
    sorts: Counter[Sort] = Counter()
    for attractor in look.attractors:
        if _is_slow(attractor):
            sorts["periodic", attractor.period] += 1
        else:
            asked = may_be_asked(attractor.lowest_period, max_period)
            sorts[attractor.kind, attractor.period if asked else attractor.lowest_period] += 1
    return sorts


def _is_slow(attractor: Any) -> bool:
    return attractor.kind == "undecided" and attractor.orbit is not None


def _seen(
    looks: Iterable[LookT], values: list[float], max_period: int
) -> list[tuple[LookT, Counter[Sort]]]:
    """Sort looks, but for those in the very middle of an event, which show neither side of it."""

    def shows(look: Look) -> bool:
        # Where a cycle repels too slowly to be left, what attracts is not seen.
        repels = any(_is_slow(a) and abs(a.orbit.multiplier) >= 1.0 for a in look.attractors)
        return not (repels or in_the_middle(look.value, values))

    apart = filter(shows, looks)
    return [(look, _sorts_of(look, max_period)) for look in sorted(apart, key=lambda x: x.value)]


def _cycles_differ(here: Counter[Sort], there: Counter[Sort], max_period: int) -> bool:
    """Whether the cycles that were asked for differ."""
    return any(not _beyond(sort, max_period) for sort in (here - there) + (there - here))


def _chaos_differs(here: Counter[Sort], there: Counter[Sort], max_period: int) -> bool:
    """Whether chaos comes or goes in a way that longer cycles and their chaos do not explain."""
    asked = [_asked_chaos(sorts, max_period) for sorts in (here, there)]
    more, fewer = (here, there) if asked[0].total() >= asked[1].total() else (there, here)
    # What else is new where chaos is missing may be a window of it; what is undecided may be it.
    new = fewer - Counter({sort: n for sort, n in more.items() if sort[0] != "undecided"})
    new -= _asked_chaos(new, max_period)
    others = sum(n for sort, n in new.items() if _beyond(sort, max_period))
    return abs(asked[0].total() - asked[1].total()) > others


def _bands_differ(here: Counter[Sort], there: Counter[Sort], max_period: int) -> bool:
    """Whether chaos in several bands is on one side only: a window that chaos ends in, too."""
    one, other = (_asked_chaos(sorts, max_period) for sorts in (here, there))
    return any(bands > 1 for _, bands in (one - other) + (other - one))


def _asked_chaos(sorts: Counter[Sort], max_period: int) -> Counter[Sort]:
    """Choose the attractors that are chaos, but not that of a window of longer cycles."""
    asked = (sort for sort in sorts if sort[0] == "chaotic" and may_be_asked(sort[1], max_period))
    return Counter({sort: sorts[sort] for sort in asked})


def may_be_asked(period: int, max_period: int) -> bool:
    """Whether cycles of a period, or the bands that they end in, are searched thoroughly."""
    return period <= MOST_BANDS and of_cascade(period, max_period)


def of_cascade(period: int, max_period: int) -> bool:
    """Whether a number of turns, or bands, is an asked period times a power of two."""
    return period // max(period & -period, 1) <= max_period  # 0: not known


def _beyond(sort: Sort, max_period: int) -> bool:
    """Whether an attractor is no cycle that was asked for."""
    return sort[0] != "periodic" or sort[1] > max_period


def accounted(
    looks: Iterable[Look], listed: Iterable[float], max_period: int
) -> tuple[list[UnresolvedChange], list[UnresolvedChange]]:
    """Return the changes between looks that nothing listed explains, and what was not asked for."""
    values = sorted(value for value in listed if not math.isnan(value))
    unresolved: list[UnresolvedChange] = []
    parts: list[Part] = []  # where attractors are not asked for
    seen = _seen(looks, values, max_period)
    thorough = [item for item in seen if not item[0].quick]
    for pairs, differ in ((pairwise(thorough), _cycles_differ), (pairwise(seen), _chaos_differs)):
        for (left, here), (right, there) in pairs:
            p, q = left.value, right.value
            told = any(known.lo <= p and q <= known.hi for known in unresolved)
            explained = bisect(values, q) > bisect(values, p)
            if not (told or explained) and differ(here, there, max_period):
                unresolved.append(_open(here, p, there, q, "nothing located between"))
    for (left, here), (right, there) in pairwise(seen):
        p, q = left.value, right.value
        between = values[bisect(values, p) : bisect(values, q)]
        for sorts, lo, hi in (
            (here, p, min(between, default=q)),
            (there, max(between, default=p), q),
        ):
            beyond = {sort for sort in sorts if _beyond(sort, max_period)}
            if beyond:
                parts.append((lo, hi, beyond))
    entries = ((f"{OUTSIDE}: {_told(s)}", lo, hi) for lo, hi, s in _joined(parts))
    return unresolved, [UnresolvedChange(*entry) for entry in entries]


def unlike(
    looks: Iterable[LookT], listed: Iterable[float], max_period: int
) -> list[tuple[LookT, LookT]]:
    """List neighbouring looks with nothing listed between that have chaos in other bands."""
    values = sorted(value for value in listed if not math.isnan(value))
    return [
        (left, right)
        for (left, here), (right, there) in pairwise(_seen(looks, values, max_period))
        if bisect(values, right.value) == bisect(values, left.value)
        and (_bands_differ(here, there, max_period) or _chaos_differs(here, there, max_period))
    ]


def unexplained(left: Look, right: Look, max_period: int) -> UnresolvedChange:
    """Tell of two looks between which bands merge where no more was looked for."""
    here, there = (_sorts_of(look, max_period) for look in (left, right))
    return _open(here, left.value, there, right.value, "not searched further")


def too_close(left: Look, right: Look) -> UnresolvedChange:
    """Tell of two looks between which bands merge at ever closer values."""
    reason = f"{OUTSIDE}: bands that merge closer together than is searched for"
    return UnresolvedChange(reason, left.value, right.value)


def _open(
    here: Iterable[Sort], lo: float, there: Iterable[Sort], hi: float, why: str
) -> UnresolvedChange:
    return UnresolvedChange(f"{_told(here)} before, {_told(there)} after: {why}", lo, hi)


def _joined(parts: Iterable[Part]) -> list[Part]:
    """Join intervals that touch or overlap."""
    joined: list[Part] = []
    for lo, hi, seen in sorted(parts, key=lambda part: part[:2]):
        if joined and lo <= joined[-1][1]:
            start, stop, known = joined[-1]
            joined[-1] = start, max(stop, hi), known | seen
        else:
            joined.append((lo, hi, seen))
    return joined


def _told(sorts: Iterable[Sort]) -> str:
    """Say which attractors: cycles by their periods, chaos by its bands."""
    numbers: dict[str, list[str]] = {}
    for kind, number in sorted(sorts, reverse=True):
        numbers.setdefault(kind, []).insert(0, str(number))
    texts = []
    for kind, known in numbers.items():
        shown = listed(known, FEW_SHOWN)
        bands = "chaos" if known == ["0"] else f"chaos in {shown} bands"  # not known in R^n
        words = {"periodic": f"period {shown}", "chaotic": bands}
        texts.append(words.get(kind, kind))
    return "; ".join(texts) or "nothing"
