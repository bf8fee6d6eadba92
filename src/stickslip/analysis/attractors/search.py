"""The search behind `attractors`: orbits followed until they leave, settle or are explained.

Where a fast stand-in of the map proposes, the map decides.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.attractors.attractor import Attractor, AttractorKind, AttractorList
from stickslip.analysis.attractors.bands import APART, Bands, grow, merged, on_map
from stickslip.analysis.attractors.lyapunov import (
    GROWTH,
    SIGMAS,
    ChaoticMotion,
    LyapunovExponent,
    difference,
    mean_of_logs,
    perturbed,
    short_intervals,
    trace,
)
from stickslip.analysis.attractors.recurrence import (
    RECURRING,
    SETTLED,
    Cycle,
    as_orbit,
    attracts,
    capture_radius,
    confirmed,
    drawn_in,
    hidden_cycles,
    neutral_family,
    promising,
    recurrences,
    same_cycle,
    settled,
)
from stickslip.analysis.maps.protocol import advance, domain_width, sample, values_and_slopes
from stickslip.analysis.scales import BLOCK, CELLS, CLOSE, HALF_DIGITS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Floats, Map1D
    from stickslip.analysis.work import Work

LOOK: Final = 2048  # steps of one orbit that tell where it goes, as far as that is to be seen
LAST_PERIODS: Final = LOOK // 2  # periods tried on an orbit that nothing else explains


@dataclass(frozen=True, eq=False)
class _Known:
    """An attractor found so far, and how to recognise orbits that it has captured."""

    attractor: Attractor
    cycle: Cycle | None = None
    centre: float = 0.0  # a point of the cycle of the map that orbits are followed on
    reach: Callable[[], float] = float

    @cached_property
    def radius(self) -> float:
        """How close to the centre an orbit is captured: long to find for a slow or long cycle."""
        return self.reach()

    def captures(self, tails: Floats) -> Any:
        """Tell which orbits have been captured."""
        if self.attractor.kind in ("chaotic", "neutral"):
            return self.attractor.contains(tails[:, -1], self.radius)
        if self.cycle is None:
            return np.zeros(len(tails), dtype=np.bool_)
        if not self.cycle.stable:
            return self.comes_near(tails, self.radius)
        return drawn_in(tails, self.cycle, self.centre, self.radius)

    def comes_near(self, tails: Floats, distance: float) -> Any:
        """Tell which orbits' last turn comes close to the cycle's centre."""
        assert self.cycle is not None
        return np.any(np.abs(tails[:, -self.cycle.period :] - self.centre) <= distance, axis=1)


class AttractorSearch:
    """Seeds still moving, and what has been found; ``doubts`` are what the map did not confirm."""

    def __init__(
        self, f: Map1D, table: BranchTable, max_period: int, max_steps: int, fast: Map1D
    ) -> None:
        self.f, self.table, self.laps = f, table, table.laps
        self.fast = fast  # a stand-in of f that orbits are followed on, or f itself
        self.max_period, self.max_steps = max_period, max_steps
        self.known: list[_Known] = []
        self.fate: Any = None  # index of the attractor, -1 undecided, -2 left; one per seed
        self.statuses: dict[int, int] = {}
        self.doubts: list[str] = []
        self.rng = np.random.default_rng(0)

    def run(self, start: Floats, work: Work) -> None:
        """Follow seeds until each has left, been captured, or used up its steps."""
        self.fate, moving, x = np.full(len(start), -1), np.arange(len(start)), start
        done, block, reason = 0, BLOCK, ""
        with work.until_interrupted():
            while moving.size and done < self.max_steps:
                work.tell(max(1 - moving.size / len(start), done / self.max_steps))
                steps = min(block, self.max_steps - done)
                tails = advance(self.fast, x, steps)
                done, block = done + steps, block * GROWTH
                moving, tails = self._drop_left(moving, tails)
                moving, tails = self._drop_captured(moving, tails)
                moving, tails = self._settle(moving, tails)
                if moving.size:
                    reason = self._examine(float(perturbed(self.fast, tails[:1, -1], self.rng)[0]))
                    moving, tails = self._drop_captured(moving, tails)
                x = perturbed(self.fast, tails[:, -1], self.rng) if moving.size else tails[:, -1]
            if moving.size:
                self._give_up(moving, tails, reason)

    def _drop_left(self, moving: Any, tails: Floats) -> tuple[Any, Floats]:
        gone = ~np.isfinite(tails[:, -1])
        self.fate[moving[gone]] = -2
        lost = tails[gone]
        last = lost[np.arange(len(lost)), np.isnan(lost).argmax(axis=1) - 1]
        codes, counts = np.unique(sample(self.fast, last).status, return_counts=True)
        for code, count in zip(codes.tolist(), counts.tolist(), strict=True):
            self.statuses[code] = self.statuses.get(code, 0) + count
        return moving[~gone], tails[~gone]

    def _drop_captured(self, moving: Any, tails: Floats) -> tuple[Any, Floats]:
        for index, item in enumerate(self.known):
            if not moving.size:
                break
            caught = item.captures(tails)
            self.fate[moving[caught]] = index
            moving, tails = moving[~caught], tails[~caught]
        return moving, tails

    def _settle(self, moving: Any, tails: Floats) -> tuple[Any, Floats]:
        """Confirm cycles that orbits have settled on, one at a time; each captures its likes."""
        if not moving.size:
            return moving, tails
        change = recurrences(tails, self.max_period) <= SETTLED * domain_width(self.f)
        tried = np.zeros(len(moving), dtype=np.bool_)
        while np.any(candidates := change.any(axis=1) & ~tried):
            k = int(np.argmax(candidates))
            tried[k] = True
            cycle = settled(self.fast, tails[k], int(np.argmax(change[k])) + 1)
            cycle = self._accepted(cycle)
            if cycle is None or not (cycle.neutral or attracts(self.f, cycle)):
                continue
            if cycle.neutral and neutral_family(self.f, cycle) is None:
                continue
            index = self.add_cycle(cycle)
            known, close = self.known[index], SETTLED * domain_width(self.f)
            caught = change[:, cycle.period - 1] & known.comes_near(tails, close)
            caught[k] = True
            if not caught.all():
                caught |= known.captures(tails)
            self.fate[moving[caught]] = index
            keep = ~caught
            moving, tails = moving[keep], tails[keep]
            change, tried = change[keep], tried[keep]
        return moving, tails

    def _accepted(self, cycle: Cycle | None) -> Cycle | None:
        """Solve a cycle of a stand-in again on the map itself."""
        if cycle is None or self.fast is self.f:
            return cycle
        true = confirmed(self.f, cycle.points)
        if true is None or true.period != cycle.period:
            self.doubts.append(f"the map has no period-{cycle.period} orbit at {cycle.points[0]}")
            return None
        return true

    def add_cycle(self, cycle: Cycle, kind: AttractorKind = "periodic", reason: str = "") -> int:
        """Add a cycle unless it is known; return its place in the list."""
        tolerance = HALF_DIGITS * domain_width(self.f)
        for index, item in enumerate(self.known):
            known = item.cycle
            if known is not None and same_cycle(cycle.points, known.points, tolerance):
                return index
            if item.attractor.kind == "neutral" and item.attractor.contains(cycle.points[0]):
                return index
        points = np.sort(cycle.points)
        period, bands = cycle.period, np.column_stack([points, points])
        family = neutral_family(self.f, cycle) if cycle.neutral else None
        if family is not None:
            kind, reason, (period, bands) = "neutral", "", family
            if (index := self._adjoining(period, bands)) >= 0:
                return index
        doubt = 1e-15 / abs(cycle.multiplier) if cycle.multiplier else 0.0
        attractor = Attractor(
            kind=kind,
            period=period,
            orbit=as_orbit(self.f, cycle, self.table),
            bands=bands,
            lyapunov=LyapunovExponent(cycle.exponent, doubt, cycle.period),
            basin_share=0.0,
            point=float(cycle.points[0]),
            reason=reason,
        )
        # A long cycle of a stand-in lies further from the map's than from points that leave it.
        own = cycle if self.fast is self.f else confirmed(self.fast, cycle.points) or cycle
        if cycle.stable and not own.stable:
            own = cycle  # its multiplier is so close to the unit circle
        reach: Callable[[], float]
        if family is not None:
            reach = partial(float, SETTLED * domain_width(self.f))
        elif cycle.stable:
            reach = partial(capture_radius, self.fast, own)
        else:  # an orbit that approaches it slowly may come no closer in any time we have
            reach = partial(float, RECURRING * domain_width(self.f))
        self.known.append(_Known(attractor, cycle, float(own.points[0]), reach))
        return len(self.known) - 1

    def _adjoining(self, period: int, bands: Floats) -> int:
        """Join a neutral family to a known one that it continues; return its place, -1 if none."""
        slack = APART * domain_width(self.f)
        for index, item in enumerate(self.known):
            known = item.attractor
            joint = merged(np.concatenate([known.bands, bands]), slack)
            fewer = len(joint) < len(known.bands) + len(bands)
            if known.kind == "neutral" and known.period == period and fewer:
                self.known[index] = replace(item, attractor=replace(known, bands=joint))
                return index
        return -1

    def _examine(self, x: float) -> str:
        """Decide whether the orbit of `x` is chaotic; add the attractor, or say why it is not."""
        values, slopes = trace(self.fast, np.array([x]), LOOK)
        if not np.all(np.isfinite(values)):
            return "a long transient: a nearby orbit leaves the domain"
        rough = mean_of_logs(slopes)
        if rough.value <= SIGMAS * rough.error and (cycle := self._crept_along(values[0])):
            self.add_cycle(cycle, *_verdict(cycle))
            return ""
        if rough.value <= 0:
            return f"the exponent {rough.value:.3g} ± {rough.error:.1g} is not above zero"
        bands = grow(self.fast, self.laps, short_intervals(self.fast, values[0]))
        if reason := self._why_no_trap(bands) or self._known_inside(bands):
            return reason
        motion = ChaoticMotion(self.fast, bands.intervals)
        return motion.reason or self._why_not_chaotic(bands, motion)

    def _known_inside(self, bands: Bands) -> str:
        """Tell what known attractor the bands hold, or are; empty if none."""
        slack = CLOSE * domain_width(self.f)
        for item in self.known:
            cycle, theirs = item.cycle, item.attractor.bands
            if cycle is not None and cycle.stable and np.any(bands.contain(cycle.points, slack)):
                return f"a stable cycle of period {cycle.period} hides in the bands"
            if item.attractor.kind == "chaotic" and np.all(bands.contain(theirs, slack)):
                return "comes to its attractor late, or its bands hold those of another"
        return ""

    def _why_no_trap(self, bands: Bands) -> str:
        if bands.reason:
            return bands.reason
        if np.ptp(bands.intervals) <= APART * domain_width(self.f):
            return "the bands are narrower than can be told from a point"
        if bands.residual > APART * domain_width(self.f):
            return f"the map misses the bands it should fill by {bands.residual:.1e}"
        return ""

    def _why_not_chaotic(self, bands: Bands, motion: ChaoticMotion) -> str:
        proposed = hidden_cycles(
            self.fast, motion.values, motion.slopes, self.max_period, bands.period
        )
        for cycle in filter(None, map(self._accepted, proposed)):
            if not attracts(self.f, cycle):
                continue
            self.add_cycle(cycle)
            if np.any(bands.contain(cycle.points, APART * domain_width(self.f))):
                return f"a stable cycle of period {cycle.period} hides in the bands"
        value, error = motion.exponent
        if value <= SIGMAS * error:
            return f"the exponent {value:.3g} ± {error:.1g} is not above zero"
        return self._add_chaos(bands, motion)

    def _add_chaos(self, bands: Bands, motion: ChaoticMotion) -> str:
        """Add a chaotic attractor, of the map itself even if a stand-in has shown it."""
        exponent = motion.exponent
        if self.fast is not self.f:
            off, doubt = difference(self.f, motion.values, motion.slopes)
            if not off <= CLOSE * domain_width(self.f):
                return self._doubt(f"the stand-in errs by {off:.1e} on a chaotic motion")
            exponent = replace(exponent, error=float(np.hypot(exponent.error, doubt)))
            bands = on_map(self.f, self.laps, bands)
            if reason := self._why_no_trap(bands):
                return self._doubt(reason)
        attractor = Attractor(
            kind="chaotic",
            period=bands.period,
            orbit=None,
            bands=bands.intervals,
            lyapunov=exponent,
            basin_share=0.0,
            point=float(motion.values[0, -1]),
            edges=bands.causes,
            sources=bands.sources,
            lowest_period=bands.lowest_period,
        )
        self.known.append(_Known(attractor))
        return ""

    def _doubt(self, reason: str) -> str:
        self.doubts.append(reason)
        return reason

    def _give_up(self, moving: Any, tails: Floats, reason: str) -> None:
        """Group what is left by the cells it visits, and look behind each group for a cycle."""
        groups: list[tuple[set[float], int]] = []
        for seed, tail in zip(moving, tails, strict=True):
            place = (tail - self.f.domain[0]) / domain_width(self.f)
            cells = set(np.unique(np.floor(CELLS * place)).tolist())
            index = next((k for c, k in groups if len(c & cells) > 0.5 * len(cells)), -1)
            if index < 0:
                if cycle := self._crept_along(tail):
                    index = self.add_cycle(cycle, *_verdict(cycle))
                else:
                    self.known.append(_Known(_undecided(self.fast, tail, reason)))
                    index = len(self.known) - 1
                groups.append((cells, index))
            self.fate[seed] = index

    def _crept_along(self, tail: Floats) -> Cycle | None:
        """Find the cycle that an orbit approaches too slowly to have settled on it."""
        for start in self._rounds(tail):
            cycle = confirmed(self.fast, start, moved=RECURRING)
            cycle = self._accepted(cycle) if cycle is not None and not _repels(cycle) else None
            if cycle is not None and not _repels(cycle):
                return cycle
        return None

    def _rounds(self, tail: Floats) -> Iterator[Floats]:
        """Yield ends of an orbit that may have gone once around a cycle, likely ones first."""
        change = recurrences(tail[None, :], LAST_PERIODS)[0] / domain_width(self.f)
        # What recurs to many digits is a period; what comes before it is only close to one.
        for period in np.flatnonzero(change <= SETTLED)[:1] + 1:
            yield tail[-period:]
        # Short periods first: a multiple of the period recurs more closely than the period.
        starts = [tail[-period:] for period in np.flatnonzero(change <= RECURRING) + 1]
        yield from (starts[k] for k in promising(self.fast, starts, RECURRING))

    def result(self, n_spread: int) -> AttractorList:
        """Return what was found; shares refer to the first `n_spread` seeds."""
        fates = self.fate[:n_spread]
        shares = [float(np.mean(fates == k)) for k in range(len(self.known))]
        found = [
            replace(item.attractor, basin_share=share, system=self.f)
            for item, share in zip(self.known, shares, strict=True)
        ]
        return AttractorList(
            attractors=tuple(sorted(found, key=lambda a: (-a.basin_share, a.point))),
            left=float(np.mean(fates == -2)),
            statuses=dict(sorted(self.statuses.items())),
            n_starts=n_spread,
            resolution=(
                f"basins that hold none of {len(self.fate)} seeds; "
                f"cycles longer than {self.max_period}"
            ),
            unfollowed=int(np.sum(self.fate == -1)),
        )


def _repels(cycle: Cycle) -> bool:
    return not (cycle.stable or cycle.neutral)


def _undecided(f: Map1D, tail: Floats, reason: str) -> Attractor:
    late = tail[len(tail) // 2 :]
    points = np.sort(late)
    _, slopes = values_and_slopes(f, late[None, : max(len(late) - 1, 1)])
    return Attractor(
        kind="undecided",
        period=0,
        orbit=None,
        bands=np.array([[points[0], points[-1]]]),
        lyapunov=mean_of_logs(slopes),
        basin_share=0.0,
        point=float(tail[-1]),
        reason=reason or f"neither settled nor examined within {len(tail)} steps",
    )


def _verdict(cycle: Cycle) -> tuple[AttractorKind, str]:
    if cycle.stable:
        return "periodic", ""
    return "undecided", (
        f"the multiplier {cycle.multiplier:.9g} of a period-{cycle.period} orbit is too close "
        "to the unit circle"
    )
