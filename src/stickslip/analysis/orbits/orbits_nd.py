"""Periodic orbits of a map of R^n: what is known of each, and the search from many seeds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.maps.protocol import apart, lengths, orbits, reduced
from stickslip.analysis.orbits.newton import Solutions, monodromy, solve_orbits
from stickslip.analysis.orbits.orbit import SHOWN, AnyOrbit, OrbitSequence, wanted_periods
from stickslip.analysis.scales import FEW_SHOWN
from stickslip.checks import MOST_KEPT, whole_number
from stickslip.numerics.waiting import doing
from stickslip.results.parts import part
from stickslip.results.table import listed, more

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Indices, Labels, MapND

N_STARTS: Final = 256
ROUNDS: Final = 5  # of seeds at most, each as many as all before
SPARSE: Final = 16  # seeds of the first round for a hit: with fewer hits the estimate says little
IN_VAIN: Final = 4  # times the first round, where there are fewer
ORBITS: Final = 3  # seeds to one that is an orbit
POOL: Final = (64, 128)  # points spread over the domain that seeds are made of
EARLY: Final = 4  # iterates of each, itself included
LATE: Final = (32, 36)  # and those near attractors
SAME: Final = 1e-8  # of lengths and an orbit's size: points of one orbit, from different seeds


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
    system: MapND | None = field(default=None, repr=False, compare=False)
    _plot: ClassVar = "orbits.draw_orbit_nd"

    @property
    def kind(self) -> str:
        """``stable``, ``neutral`` or ``unstable``."""
        return self._kind(self.multipliers)

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


def multipliers_text(multipliers: NDArray[np.complex128], shown: int = FEW_SHOWN) -> str:
    """Write multipliers in decreasing modulus, a complex pair once."""
    kept = [value for value in multipliers if value.imag >= 0.0]
    texts = (f"{v.real:.8g}" + (f" ± {v.imag:.8g}i" if v.imag else "") for v in kept)
    return listed(texts, shown)


def multipliers_of(jacobians: Floats) -> NDArray[np.complex128]:
    """Eigenvalues of the Jacobian of f^p, largest modulus first, from (p, n, n)."""
    values = np.linalg.eigvals(monodromy(jacobians)).astype(np.complex128)
    if len(values) == 2 and values.any() and not values.imag.any():
        # The smaller one has the larger one's rounding: what is left of the determinant has not.
        large = values[np.argmax(np.abs(values))]
        values = np.array([large, np.prod(np.linalg.det(jacobians)) / large])
    order = np.lexsort((-values.imag, -values.real, -np.round(np.abs(values), 12)))
    return np.asarray(values[order])


def make_orbit(
    f: MapND, points: Floats, jacobians: Floats, labels: Labels, residual: float, hits: int = 0
) -> PeriodicOrbitND:
    """Put together what is known of an orbit, started at its smallest first coordinate."""
    points = reduced(f, points)
    turn = -int(np.argmin(points[:, 0]))
    points, jacobians = np.roll(points, turn, axis=0), np.roll(jacobians, turn, axis=0)
    labels = np.roll(labels, turn)
    return orbit_nd_of(f, points, multipliers_of(jacobians), labels, residual, hits)


def orbit_nd_of(
    f: MapND,
    points: Floats,
    multipliers: NDArray[np.complex128],
    labels: Labels,
    residual: float,
    hits: int = 0,
) -> PeriodicOrbitND:
    """Put together an orbit whose multipliers are known."""
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


def solve_orbit_nd(f: MapND, guess: Floats) -> PeriodicOrbitND | None:
    """Solve for the orbit near guessed points (p, n); None if nothing converges."""
    got = solve_orbits(f, guess[None])
    if not got.found[0]:
        return None
    return make_orbit(f, got.points[0], got.jacobians[0], got.labels[0], got.residual[0])


@part
@dataclass(frozen=True)
class Unseen:
    """An estimate, from how often each orbit of a period was found, of what was not found.

    Attributes
    ----------
    period : int
    n_seeds : int
        Guesses from which Newton's method started.
    n_hits : int
        Those that led to an orbit of this minimal period.
    once, twice : int
        Orbits found once and twice.
    degenerate : int
        Guesses that led to a point where f^p is so close to the identity, in some direction,
        that rounding leaves its place undecided: a family of orbits, or one where others merge.

    Notes
    -----
    Good, Biometrika 40 (1953) 237-264; Chao, Scand. J. Statist. 11 (1984) 265-270. Both take
    seeds for independent draws. An orbit that no seed is led to, because Newton's method
    converges nowhere near it, is beyond any such estimate.
    """

    period: int
    n_seeds: int
    n_hits: int
    once: int
    twice: int
    degenerate: int = 0

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
        more = f"; {self.degenerate} ended near a degenerate orbit" if self.degenerate else ""
        head = f"period {self.period}: {self.n_hits} of {self.n_seeds} seeds led to an orbit"
        if not self.n_hits:
            return f"period {self.period}: none of {self.n_seeds} seeds led to an orbit{more}"
        return (
            f"{head}, {self.once} orbits were found once; the next hit would be new with "
            f"probability {self.probability:.2g} (Good-Turing), not found are {self.at_least:.1f} "
            f"or more (Chao){more}"
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
        Seeds of the first round of each period.
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
            f"OrbitListND: {len(self)} orbits up to period {self.max_period}; seeds were doubled "
            f"from {self.n_starts} until they found no more; others may exist",
            "  period    hits  kind      first point; multipliers",
        ]
        for orbit in self.orbits[:SHOWN]:
            point = ", ".join(f"{x:.10g}" for x in orbit.points[0])
            known = multipliers_text(orbit.multipliers)
            lines.append(f"  {orbit.period:6d}  {orbit.hits:6d}  {orbit.kind:8s}  {point}; {known}")
        lines += more(len(self), SHOWN)
        lines += [f"  {item}" for item in self.unseen]
        return "\n".join(lines)


# ------------------------------------------------------------------ the search


def search_orbits(
    f: MapND, max_period: int, period: int | None, n_starts: int = N_STARTS
) -> OrbitListND:
    """Search for orbits of a map of R^n as `periodic_orbits` does, from seeds in the domain."""
    wanted = wanted_periods(max_period, period)
    n_starts = whole_number("n_starts", n_starts, at_most=MOST_KEPT)
    found: list[PeriodicOrbitND] = []
    unseen: list[Unseen] = []
    n_evaluations = 0
    for p in wanted:
        doing(f"orbits of period {p} of {wanted[-1]}")
        census = _searched(f, p, n_starts, [orbit.points for orbit in found])
        n_evaluations += census.n_evaluations
        found += census.orbits()
        unseen.append(census.unseen(p))
    doing("")
    return OrbitListND(tuple(found), wanted[-1], tuple(unseen), n_starts, n_evaluations)


def _searched(f: MapND, p: int, n_starts: int, shorter: list[Floats]) -> _Census:
    """Take as many seeds again until these find no new orbit, and each is found three times.

    Where few seeds lead to an orbit at all, that says little: then go on for some rounds.
    """
    census, count = _Census(f), n_starts
    for _ in range(ROUNDS):
        known = census.n_orbits
        pool = _Pool(f, census.n_seeds, count, shorter + census.points)
        census.add(solve_orbits(f, pool.guesses(p, count)))
        count, told = census.n_seeds, census.unseen(p)
        telling = told.n_hits >= n_starts / SPARSE or count >= IN_VAIN * n_starts
        if count > n_starts and telling and census.n_orbits == known and not told.once + told.twice:
            break
    return census


class _Pool:
    """Points spread over the domain, early and late iterates, points of known orbits; images."""

    def __init__(self, f: MapND, n_before: int, count: int, known_orbits: list[Floats]) -> None:
        self.f, self.rng = f, np.random.default_rng(n_before)
        x = f.spread(n_before + min(max(count // EARLY, POOL[0]), POOL[1]))[n_before:]
        known = np.concatenate([x[:0], *known_orbits])
        kept = self.rng.permutation(len(known))[: POOL[1] * EARLY]
        points = [known[kept]]
        images = [np.concatenate([x[:0], *(np.roll(o, -1, axis=0) for o in known_orbits)])[kept]]
        paths = orbits(f, x, LATE[1])
        for k in (*range(EARLY), *range(*LATE)):
            stay = np.isfinite(paths[:, k + 1]).all(axis=-1)
            points.append(paths[stay, k])
            images.append(paths[stay, k + 1])
        self.points, self.images = np.concatenate(points), np.concatenate(images)
        width = self.points.max(axis=0, initial=-np.inf) - self.points.min(axis=0, initial=np.inf)
        self.width = np.where(width > 0.0, width, 1.0)

    def guesses(self, p: int, count: int) -> Floats:
        """Cyclic sequences (count, p, n) of points: a part are orbits, the others walks."""
        size = len(self.points)
        if not size:
            return np.empty((0, p, self.f.dimension))
        starts = self.rng.integers(0, size, count)
        followed = orbits(self.f, self.points[starts[: count // ORBITS]], p - 1)
        walks = self._walks(starts[count // ORBITS :], p)
        return np.concatenate([followed, self.points[walks]])

    def _walks(self, at: Indices, p: int) -> Indices:
        """Pseudo-orbits (m, p): from a point to one of the r nearest to its image.

        With small r they shadow orbits; with all they are random sequences, which find the orbits
        of sets that repel, where nothing stays. The r are spread evenly in their logarithm.
        """
        reach = len(self.points) ** self.rng.random(len(at))
        walk = [at]
        for _ in range(p - 1):
            rank = (self.rng.random(len(at)) * reach).astype(np.intp)
            rows, which = np.unique(walk[-1], return_inverse=True)
            walk.append(self._nearest(rows)[which, rank])
        return np.stack(walk, axis=1)

    def _nearest(self, rows: Indices) -> Indices:
        """All points from the nearest to the image of one to the farthest, a row for each."""
        far = (apart(self.f, image, self.points) / self.width for image in self.images[rows])
        return np.array([np.abs(d).max(axis=-1).argsort() for d in far])


class _Census:
    """Distinct solutions of one length, how often each was found, and which are orbits."""

    def __init__(self, f: MapND) -> None:
        self.f, self.unit = f, lengths(f)
        self.n_seeds = self.n_evaluations = self.degenerate = 0
        self._found: list[tuple[Floats, Floats, Labels, float]] = []
        self._hits: list[int] = []
        self._means: list[Floats] = []
        self._minimal: list[bool] = []

    def add(self, solutions: Solutions) -> None:
        """Count what a set of guesses has led to."""
        self.n_seeds += len(solutions.found)
        self.n_evaluations += solutions.n_evaluations
        self.degenerate += int(solutions.degenerate.sum())
        for k in np.flatnonzero(solutions.found):
            points, label = solutions.points[k], solutions.labels[k]
            parts = (points, solutions.jacobians[k], label, float(solutions.residual[k]))
            mean = self._mean(points)
            off = np.abs(np.array(self._means).reshape(-1, len(mean)) - mean).max(axis=1)
            reach = SAME * (1.0 + np.abs(points / self.unit).max())
            for known in np.flatnonzero(off <= 2.0 * reach):
                if same_points(self.f, self._found[known][0], points):
                    self._hits[known] += 1
                    if parts[3] < self._found[known][3]:
                        self._found[known] = parts
                    break
            else:
                self._found.append(parts)
                self._hits.append(1)
                self._means.append(mean)
                self._minimal.append(is_minimal(self.f, points))

    @property
    def n_orbits(self) -> int:
        return sum(self._minimal)

    @property
    def points(self) -> list[Floats]:
        return [found[0] for found in self._found]

    def _mean(self, points: Floats) -> Floats:
        """Mean of something that neither the start of an orbit nor whole turns change."""
        turn = getattr(self.f, "periods", np.inf) / (math.tau * self.unit)
        angle = np.isfinite(turn)
        x = points / self.unit
        phase = x[:, angle] / turn[angle]
        waves = [turn[angle] * np.sin(phase), turn[angle] * np.cos(phase)]
        return np.concatenate([x[:, ~angle], *waves], axis=1).mean(axis=0)

    def orbits(self) -> list[PeriodicOrbitND]:
        """Those of minimal period."""
        rows = np.flatnonzero(self._minimal)
        made = [make_orbit(self.f, *self._found[k], hits=self._hits[k]) for k in rows]
        return sorted(made, key=lambda orbit: tuple(orbit.points[0]))

    def unseen(self, p: int) -> Unseen:
        hits = [self._hits[k] for k in np.flatnonzero(self._minimal)]
        once, twice = hits.count(1), hits.count(2)
        return Unseen(p, self.n_seeds, sum(hits), once, twice, self.degenerate)


def distinct_orbits(f: MapND, guesses: Floats) -> list[PeriodicOrbitND]:
    """Orbits of minimal period p that Newton's method finds from guesses (m, p, n), each once."""
    census = _Census(f)
    census.add(solve_orbits(f, guesses))
    return census.orbits()


def is_minimal(f: MapND, points: Floats) -> bool:
    """Tell whether no shorter orbit is run through several times."""
    p = len(points)
    return not _coincide(f, points, points, [q for q in range(1, p) if p % q == 0])


def same_points(f: MapND, one: Floats, other: Floats, tolerance: float = SAME) -> bool:
    """Tell whether points (p, n) are those of one orbit, in any turn."""
    return len(one) == len(other) and _coincide(f, one, other, range(len(other)), tolerance)


def _coincide(
    f: MapND, one: Floats, other: Floats, turns: Iterable[int], tolerance: float = SAME
) -> bool:
    unit = lengths(f)
    limit = tolerance * (1.0 + np.abs(one / unit).max())
    turned = (np.roll(other, k, axis=0) for k in turns)
    return any(np.abs(apart(f, one, each) / unit).max() <= limit for each in turned)
