"""Periodic orbits of a map of R^n, searched for from many seeds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.maps.protocol_nd import sample
from stickslip.analysis.orbits.newton_nd import solve_orbits
from stickslip.analysis.orbits.orbits_nd import OrbitListND, Unseen, make_orbit
from stickslip.checks import MOST_KEPT, whole_number

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.maps.protocol_nd import MapND
    from stickslip.analysis.orbits.newton_nd import Solutions
    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND

N_STARTS: Final = 512
TRANSIENT: Final = 32  # iterates after which points count as being on an attractor
STARTS: Final = 32  # orbits that are iterated for seeds
SAME: Final = 1e-8  # of an orbit's size: points of one orbit, reached from different seeds


def search_orbits(
    f: MapND, max_period: int, period: int | None, n_starts: int = N_STARTS
) -> OrbitListND:
    """Search for orbits of a map of R^n as `periodic_orbits` does, from seeds in the domain."""
    highest = whole_number("max_period", max_period, at_most=MOST_KEPT)
    if period is not None:
        highest = period = whole_number("period", period, at_most=MOST_KEPT)
    n_starts = whole_number("n_starts", n_starts, at_most=MOST_KEPT)
    wanted = range(1, highest + 1) if period is None else (period,)
    orbits: list[PeriodicOrbitND] = []
    unseen: list[Unseen] = []
    n_evaluations = 0
    seeds = _seeds(f, n_starts)
    for p in wanted:
        solutions = solve_orbits(f, _itineraries(f, seeds, p))
        n_evaluations += solutions.n_evaluations
        census = _census(f, solutions)
        orbits += census.orbits()
        unseen.append(census.unseen(p))
    return OrbitListND(tuple(orbits), highest, tuple(unseen), n_starts, n_evaluations)


def _seeds(f: MapND, count: int) -> Floats:
    """Points spread over the domain, and points that orbits come to, shape (count, n)."""
    spread = f.spread(count - count // 2)
    x = f.spread(STARTS)
    visited = []
    for k in range(TRANSIENT + -(-count // STARTS)):
        x = sample(f, x).value
        if k >= TRANSIENT:
            visited.append(x)
    points = np.concatenate(visited)[: count // 2]
    return np.concatenate([spread, points])


def _itineraries(f: MapND, seeds: Floats, p: int) -> Floats:
    """First p points of the orbits of some seeds, shape (m, p, n); those that leave dropped."""
    points = [seeds]
    for _ in range(p - 1):
        points.append(sample(f, points[-1]).value)
    guesses = np.stack(points, axis=1)
    kept: Floats = guesses[np.isfinite(guesses).all(axis=(1, 2))]
    return kept


@dataclass
class _Census:
    """Distinct orbits of one period, and how often each was found."""

    f: MapND
    found: list[PeriodicOrbitND] = field(default_factory=list)
    hits: list[int] = field(default_factory=list)

    def add(self, orbit: PeriodicOrbitND) -> None:
        for k, known in enumerate(self.found):
            turns = (np.roll(orbit.points, k, axis=0) for k in range(len(orbit.points)))
            if any(_close(known.points, turned) for turned in turns):
                self.hits[k] += 1
                if orbit.residual < known.residual:
                    self.found[k] = orbit
                return
        self.found.append(orbit)
        self.hits.append(1)

    def orbits(self) -> list[PeriodicOrbitND]:
        counted = [replace(orbit, hits=n) for orbit, n in zip(self.found, self.hits, strict=True)]
        return sorted(counted, key=lambda orbit: tuple(orbit.points[0]))

    def unseen(self, p: int) -> Unseen:
        return Unseen(p, sum(self.hits), self.hits.count(1), self.hits.count(2))


def _census(f: MapND, solutions: Solutions) -> _Census:
    """Collect the orbits whose minimal period is that of the search."""
    census = _Census(f)
    for k in np.flatnonzero(solutions.found):
        points = solutions.points[k]
        if _is_minimal(points):
            census.add(
                make_orbit(
                    f, points, solutions.jacobians[k], solutions.labels[k], solutions.residual[k]
                )
            )
    return census


def _is_minimal(points: Floats) -> bool:
    """Whether no shorter orbit is run through several times."""
    p = len(points)
    shifts = [q for q in range(1, p) if p % q == 0]
    return not any(_close(points, np.roll(points, q, axis=0)) for q in shifts)


def _close(one: Floats, other: Floats) -> bool:
    return bool(np.abs(one - other).max() <= SAME * (1.0 + np.abs(one).max()))
