"""Attractors of a family of maps at many parameter values, from a few orbits each.

As long as the orbits of all critical points inside a motion stay with the motion, it is a trap.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.attractors.bands import APART
from stickslip.analysis.attractors.recurrence import (
    RECURRING,
    SETTLED,
    confirmed,
    recurrences,
    same_cycle,
)
from stickslip.analysis.exponents.blocking import LONGEST_CYCLE
from stickslip.analysis.maps.differences import LIKE
from stickslip.analysis.maps.protocol import SAME, advance, domain_width, values_and_slopes
from stickslip.analysis.scales import HALF_DIGITS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.analysis.attractors.attractor import AttractorKind
    from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Map1D
    from stickslip.analysis.maps.side_by_side import Asking

BLOCKS: Final = (24, 48, 96, 160)  # steps after which orbits of critical points are looked at
WITH: Final = 16  # steps that lead back to an attractor that has changed a little; an orbit is with
# the motion that most of its last ones are inside
LONG: Final = (1024, 4096)  # steps in which a contracting motion must show its period
NEAR: Final = 5e-3  # of the domain's width: an orbit this close to a cycle that comes closer ...
ROUNDS: Final = 6  # ... in each of so many rounds is captured
TOLD: Final = 48  # last steps that tell a motion, by slopes, or if all are in one direction ...
SHORT_PERIODS: Final = 4  # ... for a period up to this, an orbit is still on its way
SIGMAS: Final = 3.0  # errors by which the mean of log |f'| must exceed 0 at first
TRIES: Final = 6  # periods proposed by an orbit that Newton's method tries
MOST_MOTIONS: Final = 8  # at one value
SPARSE: Final = 12.0  # mean gaps between iterates: wider ones are gaps between bands
MOVING, CYCLE, LEFT = -1, -2, -3  # fates of orbits, beside the number of an attractor found


@dataclass(frozen=True, eq=False)
class Motion:
    """Where orbits settle at one parameter value."""

    kind: AttractorKind  # "chaotic" means a positive mean of log |f'|, without proof
    points: Floats  # the cycle, or successive iterates
    lyapunov: float  # mean of log |f'| over the points

    @property
    def period(self) -> int:
        """Of a cycle, else 0."""
        return len(self.points) if self.kind == "periodic" else 0

    def holds(self, x: Floats) -> Bools:
        """Tell which points lie between iterates that are as close as iterates usually are."""
        places = np.sort(self.points)
        gap = SPARSE * (places[-1] - places[0]) / len(places)
        k = np.searchsorted(places, x)
        inside = (k > 0) & (k < len(places))
        k = np.clip(k, 1, len(places) - 1)
        return np.asarray(inside & (places[k] - places[k - 1] <= gap))


@dataclass
class Settler:
    """Follows the attractors of a family along ascending parameter values."""

    iterates: int  # points kept of a motion that is no cycle
    # at the last value, without the cycles that were given
    motions: list[Motion] = field(default_factory=list)

    def at(
        self, f: Map1D, cycles: Sequence[Floats], critical: Floats, spread: Floats
    ) -> Asking[list[Motion]]:
        """Find the attractors of the next map besides known stable cycles."""
        look = _Look(f, self.iterates, list(cycles))
        yield from look.go_on(self.motions)
        owner, seeds = _images(f, critical)
        fates = yield from look.follow(np.concatenate([seeds, spread]))
        fates = fates[: len(seeds)]
        self.motions = [
            motion
            for number, motion in enumerate(look.found)
            if motion.kind == "periodic" or not _leaks(motion, number, critical[owner], fates)
        ]
        return self.motions


def _images(f: Map1D, critical: Floats) -> tuple[Indices, Floats]:
    """Values on both sides of critical points, once where they agree, and whose they are."""
    step = APART * domain_width(f)
    sides = np.concatenate([critical - step, critical + step])
    owner = np.tile(np.arange(len(critical)), 2)
    value = advance(f, sides, 1)[:, 1]
    same = np.abs(value[len(critical) :] - value[: len(critical)]) <= 1e3 * step
    keep = np.isfinite(value) & ~np.concatenate([np.zeros(len(critical), dtype=bool), same])
    return owner[keep], value[keep]


def _leaks(motion: Motion, number: int, critical: Floats, fates: Indices) -> bool:
    """Tell whether the orbit of a critical point inside a motion has ended elsewhere."""
    inside = motion.holds(critical)
    return bool(np.any(inside & (fates != number) & (fates != MOVING)))


def _slow_approach(tail: Floats) -> bool:
    """Tell whether an orbit's end moves on, every p-th point in one direction, for a small p."""
    # So does a slow passage past a weakly unstable cycle, where slopes look like chaos.
    end = tail[-TOLD:]
    for p in range(1, SHORT_PERIODS + 1):
        forward = end[p:] > end[:-p]
        classes = [forward[k::p] for k in range(p)]
        if all(one.all() or not one.any() for one in classes):
            return True
    return False


class _Look:
    """The search for attractors of one map."""

    def __init__(self, f: Map1D, iterates: int, cycles: list[Floats]) -> None:
        self.f, self.iterates, self.cycles = f, iterates, cycles
        self.width = domain_width(f)
        self.found: list[Motion] = []

    def _all_cycles(self) -> list[Floats]:
        """Cycles that were given, and those found."""
        return [*self.cycles, *(m.points for m in self.found if m.kind == "periodic")]

    def go_on(self, motions: Sequence[Motion]) -> Asking[None]:
        """Find the cycles of the last map in this one; identify what became of the others."""
        rest = [m for m in motions if m.kind != "periodic" or not self._add_cycle(m.points)]
        for motion in rest:
            tail = yield self.f, motion.points[-1:], WITH
            if np.isfinite(tail[0, -1]):
                was_chaotic = motion.kind == "chaotic"
                yield from self._identify(tail, self.iterates, was_chaotic=was_chaotic)

    def follow(self, start: Floats) -> Asking[Indices]:
        """Follow orbits until each has left, or is with an attractor; return which."""
        fates = np.full(len(start), MOVING)
        moving, tails = np.arange(len(start)), start[:, None]
        for steps in BLOCKS:
            if not moving.size:
                break
            more = yield self.f, tails[:, -1], steps
            tails = np.hstack([tails, more[:, 1:]])
            moving, tails = self._drop(moving, tails, fates)
        while moving.size:
            moving, tails = self._drop(moving, tails, fates)
            if moving.size:
                if len(self.found) == MOST_MOTIONS:
                    break
                fate = yield from self._identify(tails[:1], self.iterates)
                same = self._beside_cycles(tails) if fate == CYCLE else np.zeros(len(tails), bool)
                same[0] = True
                fates[moving[same]] = fate
                moving, tails = moving[~same], tails[~same]
        return fates

    def _beside_cycles(self, tails: Floats) -> Bools:
        """Tell which orbits have lately been close to a known cycle, where some only crawl."""
        beside = np.zeros(len(tails), dtype=bool)
        for cycle in self._all_cycles():
            gaps = np.abs(tails[:, -WITH:, None] - cycle).min(axis=2)
            beside |= gaps.max(axis=1) <= RECURRING * self.width
        return beside

    def _drop(self, moving: Indices, tails: Floats, fates: Indices) -> tuple[Indices, Floats]:
        """Enter the fates of orbits; return those that are still moving."""
        fates[moving] = self._fates(tails)
        rest = fates[moving] == MOVING
        return moving[rest], tails[rest]

    def _fates(self, tails: Floats) -> Indices:
        """Tell which orbits have left, or been captured."""
        fate = np.full(len(tails), MOVING)
        fate[~np.isfinite(tails[:, -1])] = LEFT
        for cycle in self.cycles:
            fate[(fate == MOVING) & self._captured(tails, cycle)] = CYCLE
        for number, motion in enumerate(self.found):
            if motion.kind == "periodic":
                caught = self._captured(tails, motion.points)
            else:
                caught = motion.holds(tails[:, -WITH:]).mean(axis=1) >= 0.5
            fate[(fate == MOVING) & caught] = number
        return fate

    def _captured(self, tails: Floats, cycle: Floats) -> Bools:
        """Tell which orbits near a stable cycle come closer, or went along for half their way."""
        p, n = len(cycle), tails.shape[1]
        gaps = np.abs(tails[:, -1, None] - cycle)
        nearest = gaps.argmin(axis=1)
        rounds = min(ROUNDS, (n - 1) // p)
        with np.errstate(invalid="ignore"):
            if rounds:
                before = tails[:, [-1 - j * p for j in range(rounds, -1, -1)]]
                distance = np.abs(before - cycle[nearest][:, None])
                closer = np.diff(distance, axis=1) <= SAME * self.width
                return np.asarray((distance[:, -1] <= NEAR * self.width) & closer.all(axis=1))
            back = np.arange(n // 2)
            beside = cycle[(nearest[:, None] - back) % p]
            return np.asarray((np.abs(tails[:, n - 1 - back] - beside) <= NEAR * self.width).all(1))

    def _identify(self, tail: Floats, steps: int, *, was_chaotic: bool = False) -> Asking[int]:
        """Find out where an orbit (1, n) settles, its fate; add the attractor if it is new."""
        number = len(self.found)
        for more in (steps, *LONG):
            further = yield self.f, tail[:, -1], more
            tail = np.hstack([tail, further[:, 1:]])
            fate = int(self._fates(tail)[0])
            if fate != MOVING:
                return fate
            late = tail[0, -max(TOLD, tail.shape[1] // 4) :]
            with np.errstate(divide="ignore"):
                logs = np.log(np.abs(values_and_slopes(self.f, late)[1]))
            exponent = float(logs.mean())
            error = float(logs.std() / np.sqrt(logs.size))  # as if they were independent
            near = RECURRING if exponent <= 0.0 else SETTLED  # slopes speak against it
            if self._settled(tail[0], near * self.width):
                return number if len(self.found) > number else CYCLE
            # A smaller mean is none: slopes are like 1.
            least = LIKE if was_chaotic else max(LIKE, SIGMAS * error)
            if exponent > least and not _slow_approach(tail[0]):
                kind: AttractorKind = "chaotic"
                break
            if more in LONG and exponent <= LIKE and self._crawls(tail[0]):
                return CYCLE
        else:
            kind = "undecided"
        self.found.append(Motion(kind, tail[0, -self.iterates :], exponent))
        return number

    def _crawls(self, tail: Floats) -> bool:
        """Tell whether an orbit comes closer to a known cycle, if too slowly to settle on it."""
        quarter = len(tail) // 4
        for cycle in self._all_cycles():
            early, late = (
                np.abs(part[:, None] - cycle).min(axis=1).mean()
                for part in (tail[quarter : 2 * quarter], tail[-quarter:])
            )
            if late < min(early, RECURRING * self.width):
                return True
        return False

    def _settled(self, tail: Floats, near: float) -> bool:
        """Look for a stable cycle that the end of an orbit has come close to."""
        change = recurrences(tail[None, :], LONGEST_CYCLE)[0]
        proposed = np.flatnonzero(change <= near) + 1
        # The first periods, and the best: a multiple recurs more closely than the period itself.
        best = proposed[np.argsort(change[proposed - 1], kind="stable")][:TRIES]
        for period in sorted({*proposed[:TRIES].tolist(), *best.tolist()}):
            if self._add_cycle(tail[-period:]):
                return True
        return False

    def _add_cycle(self, points: Floats) -> bool:
        """Polish a cycle; add it if it is stable and new. False if there is none."""
        cycle = confirmed(self.f, points, RECURRING)
        if cycle is None or not cycle.stable:
            return False
        near = HALF_DIGITS * self.width
        if not any(same_cycle(cycle.points, other, near) for other in self._all_cycles()):
            self.found.append(Motion("periodic", cycle.points, cycle.exponent))
        return True
