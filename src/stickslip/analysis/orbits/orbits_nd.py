"""Periodic orbits of a map of R^n: what is known of each, and the search from many seeds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.maps.protocol_nd import sample
from stickslip.analysis.orbits.newton_nd import monodromy, solve_orbits
from stickslip.analysis.orbits.orbit import AnyOrbit, OrbitSequence
from stickslip.checks import MOST_KEPT, whole_number
from stickslip.results.parts import part

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels
    from stickslip.analysis.maps.protocol_nd import MapND
    from stickslip.analysis.orbits.newton_nd import Solutions

N_STARTS: Final = 512
TRANSIENT: Final = 32  # iterates after which points count as being on an attractor
STARTS: Final = 32  # orbits that are iterated for seeds
SAME: Final = 1e-8  # of an orbit's size: points of one orbit, reached from different seeds
SHOWN: Final = 24  # orbits in a list's repr
MULTIPLIERS_SHOWN: Final = 3


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbitND(AnyOrbit):
    """A periodic orbit of a map of R^n.

    Attributes
    ----------
    points : ndarray of float, shape (period, n)
        In the map's order, the one with the smallest first coordinate first.
    period : int
        Minimal.
    multipliers : ndarray of complex, shape (n,)
        Eigenvalues of the Jacobian of the period-th power at the orbit, largest modulus first.
    stable : bool
        All of them are inside the unit circle.
    itinerary : tuple of str, length period
        What the map says of each point's piece: its own text if it has one, else the label.
    labels : ndarray of uint64, shape (period,)
    residual : float
        Largest abs(f(x_i) - x_(i+1)).
    hits : int
        How many seeds led to it, of those that led to an orbit of this period.
    system : map or None
        The map that it is an orbit of; None if it was loaded without.
    """

    points: Floats
    period: int
    multipliers: NDArray[np.complex128]
    stable: bool
    itinerary: tuple[str, ...]
    labels: Labels = field(repr=False)
    residual: float
    hits: int = 0
    system: Any = field(default=None, repr=False, compare=False)
    _plot: ClassVar = "orbits.draw_orbit_nd"

    @property
    def kind(self) -> str:
        """``stable`` or ``unstable``."""
        return "stable" if self.stable else "unstable"

    def __repr__(self) -> str:
        """Period and multipliers in one line, a line for each point."""
        lines = [f"PeriodicOrbitND(period {self.period}, {self.kind})"]
        lines.append(f"  multipliers  {multipliers_text(self.multipliers, self.multipliers.size)}")
        lines += [f"  {', '.join(f'{x:.12g}' for x in point)}" for point in self.points]
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        return {
            "period": np.repeat(self.period, self.period),
            "kind": np.repeat(self.kind, self.period),
            "multipliers": [self.multipliers] * self.period,
            "hits": np.repeat(self.hits, self.period),
            "point": np.arange(self.period) + 1,
            "d": list(self.points),
            "itinerary": np.array(self.itinerary),
        }


def multipliers_text(multipliers: NDArray[np.complex128], shown: int = MULTIPLIERS_SHOWN) -> str:
    """Write multipliers in decreasing modulus, a complex pair once."""
    kept = [value for value in multipliers if value.imag >= 0.0]
    texts = [
        f"{value.real:.8g}" + (f" ± {value.imag:.8g}i" if value.imag else "")
        for value in kept[:shown]
    ]
    return ", ".join(texts) + (", ..." if len(kept) > shown else "")


def multipliers_of(jacobians: Floats) -> NDArray[np.complex128]:
    """Eigenvalues of the Jacobian of f^p, largest modulus first, from (p, n, n)."""
    values = np.linalg.eigvals(monodromy(jacobians)).astype(np.complex128)
    order = np.lexsort((-values.imag, -values.real, -np.round(np.abs(values), 12)))
    return np.asarray(values[order])


def make_orbit(
    f: MapND, points: Floats, jacobians: Floats, labels: Labels, residual: float, hits: int = 0
) -> PeriodicOrbitND:
    """Put together what is known of an orbit, started at its smallest first coordinate."""
    turn = -int(np.argmin(points[:, 0]))
    points, jacobians = np.roll(points, turn, axis=0), np.roll(jacobians, turn, axis=0)
    labels = np.roll(labels, turn)
    multipliers = multipliers_of(jacobians)
    text = getattr(f, "itinerary", None)
    itinerary = [str(label) for label in labels] if text is None else text(points)
    return PeriodicOrbitND(
        points=points,
        period=len(points),
        multipliers=multipliers,
        stable=bool(np.abs(multipliers[0]) < 1.0),
        itinerary=tuple(map(str, itinerary)),
        labels=labels,
        residual=float(residual),
        hits=hits,
        system=f,
    )


@part
@dataclass(frozen=True)
class Unseen:
    """An estimate, from how often each orbit of a period was found, of what was not found.

    Attributes
    ----------
    period : int
    n_hits : int
        Seeds that led to an orbit of this minimal period.
    once, twice : int
        Orbits found once and twice.

    Notes
    -----
    Good, Biometrika 40 (1953) 237-264; Chao, Scand. J. Statist. 11 (1984) 265-270. Both take
    seeds for independent draws. An orbit that no seed is led to, because Newton's method
    converges nowhere near it, is beyond any such estimate.
    """

    period: int
    n_hits: int
    once: int
    twice: int

    @property
    def probability(self) -> float:
        """Probability (Good-Turing) that the next hit would be an orbit not in the list."""
        return self.once / self.n_hits if self.n_hits else 1.0

    @property
    def at_least(self) -> float:
        """Expected number of orbits not found, at least (Chao's estimate from below)."""
        return self.once * (self.once - 1) / (2.0 * (self.twice + 1))

    def __str__(self) -> str:
        """One line."""
        if not self.n_hits:
            return f"period {self.period}: no seed led to an orbit"
        return (
            f"period {self.period}: {self.n_hits} seeds led to an orbit, {self.once} orbits were "
            f"found once; the next hit would be new with probability {self.probability:.2g} "
            f"(Good-Turing), not found are {self.at_least:.1f} or more (Chao)"
        )


@dataclass(frozen=True, eq=False, repr=False)
class OrbitListND(OrbitSequence[PeriodicOrbitND]):
    """Periodic orbits found up to a period: a sequence, with an estimate of what is missing.

    Attributes
    ----------
    orbits : tuple of PeriodicOrbitND
        By period, then by first coordinate.
    max_period : int
    unseen : tuple of Unseen
        A period each.
    n_starts : int
        Of each period.
    n_evaluations : int
        Evaluations of the map.
    """

    orbits: tuple[PeriodicOrbitND, ...]
    max_period: int
    unseen: tuple[Unseen, ...]
    n_starts: int
    n_evaluations: int
    _number: ClassVar = "orbit"
    _column_names: ClassVar = (
        *("period", "kind", "multipliers", "hits", "point"),
        *("d", "itinerary"),
    )
    _plot: ClassVar = "orbits.draw_orbits_nd"

    def __repr__(self) -> str:
        """Table of the orbits, then the estimates."""
        lines = [
            f"OrbitListND: {len(self)} orbits up to period {self.max_period} from {self.n_starts} "
            "seeds a period; others may exist",
            "  period    hits  kind      first point; multipliers",
        ]
        for orbit in self.orbits[:SHOWN]:
            point = ", ".join(f"{x:.10g}" for x in orbit.points[0])
            known = multipliers_text(orbit.multipliers)
            lines.append(f"  {orbit.period:6d}  {orbit.hits:6d}  {orbit.kind:8s}  {point}; {known}")
        if len(self) > SHOWN:
            lines.append(f"  ... {len(self) - SHOWN} more")
        lines += [f"  {item}" for item in self.unseen]
        return "\n".join(lines)


# ------------------------------------------------------------------ the search


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
