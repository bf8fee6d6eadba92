"""The outcome of a border collision as lists of orbits and attractors on both sides show it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.outcome import LocalAttractor, OrbitOutcome, Outcome

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

MOVED: Final = 0.02  # of the window: how far an attractor may move between two parameters


def observed(
    orbits_before: Sequence[PeriodicOrbit],
    orbits_after: Sequence[PeriodicOrbit],
    attractors_before: Sequence[Attractor] = (),
    attractors_after: Sequence[Attractor] = (),
    *,
    period: int = 1,
    gap: bool = False,
    width: float | None = None,
) -> Outcome:
    """Name what happened, from orbits beside a border and all attractors, before and after.

    Attractors that are no orbit concerned and are found on both sides with the same kind and
    period, in about the same place, are bystanders. ``gap``: the border is the edge of one.
    """
    everything = (*attractors_before, *attractors_after)
    scale = width or max((float(np.abs(a.bands).max()) for a in everything), default=0.0)
    before, after = _without_onlookers(
        [_Seen(a, orbits_before, MOVED * scale) for a in attractors_before],
        [_Seen(a, orbits_after, MOVED * scale) for a in attractors_after],
        MOVED * scale,
    )
    orbits = _orbits(orbits_before, orbits_after, period, gap)
    text = f"{_counts(orbits_before)} before, {_counts(orbits_after)} after"
    left, right = _summary(before), _summary(after)
    text += f"; before {left}, after {right}"
    return Outcome(orbits, right.kind, text, left, right)


def _orbits(
    before: Sequence[PeriodicOrbit], after: Sequence[PeriodicOrbit], period: int, gap: bool
) -> OrbitOutcome:
    """Compare the numbers of orbits; those across a jump do not count as orbits of the map."""
    one, two = (_number(side, period) for side in (before, after))
    if one == two:
        if one == 0:
            return "undecided"
        doubles = (_number(side, 2 * period) for side in (before, after))
        return "persist" if len(set(doubles)) == 1 else "period-doubled"
    change = two - one
    if change % 2 == 0:
        return "born in pairs" if change > 0 else "die in pairs"
    if change > 0:
        return "born at a gap" if gap else "born at a jump"
    return "lost in a gap" if gap else "lost at a jump"


def _number(orbits: Sequence[PeriodicOrbit], period: int) -> int:
    return sum(o.period == period and not o.infinitely_unstable for o in orbits)


def _counts(orbits: Sequence[PeriodicOrbit]) -> str:
    periods = sorted(o.period for o in orbits if not o.infinitely_unstable)
    return f"periods {', '.join(map(str, periods))}" if periods else "no orbits"


class _Seen:
    """An attractor, and whether it is one of the orbits concerned."""

    def __init__(self, attractor: Attractor, orbits: Sequence[PeriodicOrbit], moved: float) -> None:
        self.kind, self.period = attractor.kind, attractor.period
        self.bands: Floats = np.asarray(attractor.bands, dtype=np.float64)
        # The lists of orbits may have been made a little closer to the collision.
        self.concerned = attractor.kind == "periodic" and any(
            o.period == attractor.period
            and np.abs(np.sort(o.points) - self.bands[:, 0]).max() <= moved
            for o in orbits
        )

    def looks_like(self, other: _Seen, moved: float) -> bool:
        """Whether the other one is this attractor, a little further on."""
        return (
            (self.kind, self.period) == (other.kind, other.period)
            and not (self.concerned or other.concerned)
            and self.bands.shape == other.bands.shape
            and bool(np.abs(self.bands - other.bands).max() <= moved)
        )

    def local(self) -> LocalAttractor:
        bands = len(self.bands) if self.kind == "chaotic" else self.period
        return LocalAttractor(self.kind, bands if self.kind != "undecided" else 0)


def _without_onlookers(
    before: list[_Seen], after: list[_Seen], moved: float
) -> tuple[list[_Seen], list[_Seen]]:
    """Take away, one for one, what is on both sides."""
    left, right = [], list(after)
    for seen in before:
        match = next((other for other in right if seen.looks_like(other, moved)), None)
        if match is None:
            left.append(seen)
        else:
            right.remove(match)
    return left, right


def _summary(attractors: list[_Seen]) -> LocalAttractor:
    """One description of all attractors concerned; no number where theirs differ."""
    found = {seen.local() for seen in attractors}
    if not found:
        return LocalAttractor("none")
    if len(found) == 1:
        return found.pop()
    kinds = {each.kind for each in found}
    return LocalAttractor(kinds.pop() if len(kinds) == 1 else "undecided")
