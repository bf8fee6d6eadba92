"""What surrounds an attractor: whose basin a point is in, and how near the next basin is.

On a line basins are intervals, and all of this is read from them. In R^n points are tried.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from stickslip.analysis.attractors.attractors import MAX_STEPS, spread_points
from stickslip.analysis.attractors.basin_pieces import spread_over_open
from stickslip.analysis.attractors.in_space.basins_nd import Estimate, binomial
from stickslip.analysis.attractors.in_space.fates import (
    LEFT,
    UNDECIDED,
    cells_of,
    fates,
    sample_values,
)
from stickslip.analysis.interpolation.interpolated import stand_in
from stickslip.analysis.maps.protocol import advance, apart, clip_to_domain, reduced
from stickslip.analysis.scales import BLOCK, FEW, IN_A_ROW, ROUNDS, SAMPLE
from stickslip.analysis.work import Work
from stickslip.numerics.waiting import doing
from stickslip.numerics.zeros import halved
from stickslip.results.parts import part

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.attractors.attractor import Attractor, AttractorListND, AttractorND
    from stickslip.analysis.attractors.basins import Basins
    from stickslip.analysis.maps.protocol import Floats, Map1D, MapND

    Indices = NDArray[np.integer[Any]]

HALVINGS: Final = 40  # of the way across a boundary


@part
class Displacement(NamedTuple):
    """The smallest displacement known that leads to another basin.

    Attributes
    ----------
    size, error : float
        Its length, in the units of the map's points, and how far that may be off: rounding on a
        line, more where the basin is not proved up to there; in R^n the width of the bracket. NaN
        if none was found.
    point, by : tuple of float
        The attractor's point that is displaced, and the displacement.
    into : int
        Place of the other attractor in the list; -1 what is not proved or undecided, -2 the
        orbit leaves.
    tested : int
        So many smaller displacements were tried, and none led to another basin; 0 on a line
        where that is proved.
    reason : str
        On a line, why the basin ends there.
    """

    size: float
    error: float
    point: tuple[float, ...]
    by: tuple[float, ...]
    into: int
    tested: int
    reason: str = ""


class _Way(NamedTuple):
    """A displacement of a point of an attractor that leads to another basin."""

    base: Floats
    way: Floats
    size: float
    error: float


class LineSurroundings:
    """Of an attractor of a line, by its basins."""

    def __init__(self, f: Map1D, basins: Basins, k: int) -> None:
        self.f, self.basins, self.k = f, basins, k
        self.attractor: Attractor = basins.attractors[k]
        self.fast = stand_in(f)
        points = advance(self.fast, np.array([self.attractor.point]), 2 * SAMPLE)[0, -SAMPLE:]
        orbit = self.attractor.orbit
        points = points[np.isfinite(points)] if orbit is None else orbit.points
        self.points = np.asarray(points)[:, None]

    def fate(self, x: Floats) -> Indices:
        """Tell whose basin points (m, 1) are in; what is not proved is followed until it is."""
        found = self._proved(x[:, 0])
        if (open_ := found == UNDECIDED).any():
            tails = self._proved(advance(self.fast, x[open_, 0], BLOCK))
            first = np.argmax(tails != UNDECIDED, axis=1)
            found[open_] = tails[np.arange(len(tails)), first]
        return found

    def _proved(self, x: Floats) -> Indices:
        clipped, inside = clip_to_domain(self.f.domain, x)
        return np.where(inside, self.basins.at(np.where(inside, clipped, self.f.domain[0])), LEFT)

    def step(self, x: Floats) -> Floats:
        """Apply the map to points of the basin, (m, 1)."""
        return advance(self.fast, x[:, 0], 1)[:, 1:]

    def share(self, n_samples: int) -> Estimate:
        """Return the exact share; with an error only where part of it was sampled."""
        del n_samples
        sampled, error = self.basins.sampled(self.k)
        return Estimate(self.basins.share(self.k), error if sampled else 0.0)

    def displacement(self, n_samples: int, rng: np.random.Generator) -> Displacement:
        """Compare the ends of the intervals that hold the attractor's bands.

        Beyond an end that is not proved samples tell; the error then reaches down to that end.
        """
        del rng
        edges, bands = self.basins.edges, self.attractor.bands
        piece = np.searchsorted(edges, bands.mean(axis=1), side="right") - 1
        piece = np.clip(piece, 0, len(edges) - 2)
        gaps = np.stack([bands[:, 0] - edges[piece], edges[piece + 1] - bands[:, 1]])
        proved = self.basins.index[piece] == self.k
        gaps = np.where(proved, np.maximum(gaps, 0.0), 0.0)
        side, band = np.unravel_index(np.argmin(gaps), gaps.shape)
        beyond = np.concatenate([[LEFT], self.basins.index, [LEFT]])[piece[band] + 2 * side]
        if not proved.all() or beyond == UNDECIDED:
            return self._sampled(n_samples, float(gaps.min()))
        size, point = float(gaps[side, band]), float(bands[band, side])
        error = float(np.spacing(np.abs(edges).max()))
        reason = str(self.basins.causes[piece[band] + side])
        by = size if side else -size
        return Displacement(size, error, (point,), (by,), int(beyond), 0, reason)

    def _sampled(self, n_samples: int, proved: float) -> Displacement:
        """Find the nearest of what is known to be foreign, and of samples of what is not proved."""
        edges, index = self.basins.edges, self.basins.index
        foreign = np.flatnonzero((index != self.k) & (index != UNDECIDED))
        tried = spread_over_open(edges, index, np.full(n_samples, 0.5))
        x = np.concatenate([edges[[0, -1]], edges[foreign], edges[foreign + 1], tried])
        known = np.concatenate([[LEFT, LEFT], index[foreign], index[foreign]])
        fate = np.concatenate([known, self.fate(tried[:, None])])
        distance = self._distance(x)
        away = np.where((fate == self.k) | (fate == UNDECIDED), np.inf, distance)
        best = int(np.argmin(away))
        sides = self.attractor.bands.ravel()
        point = float(sides[np.argmin(np.abs(sides - x[best]))])
        size, by = float(distance[best]), float(x[best]) - point
        tested = int(((fate == self.k) & (distance < size)).sum())
        reason = f"sampled: the basin is proved up to {proved:.6g}"
        into = int(fate[best])
        return Displacement(size, size - proved, (point,), (by,), into, tested, reason)

    def settling(self, n_samples: int, within: float) -> tuple[Floats, float]:
        """Follow starts as long again as they took to come within that share of the domain."""
        low, high = self.f.domain
        x, near = spread_points(self.f, n_samples, None), within * (high - low)
        x = x[self.fate(x[:, None]) == self.k]
        last, done = np.full(len(x), -1), 0  # step at which each was last outside
        while not done or (done < MAX_STEPS and (2 * (last + 1) > done).any()):
            n = max(BLOCK, done)
            orbits = advance(self.fast, x, n)
            outside = ~(self._distance(orbits) <= near)
            latest = done + n - np.argmax(outside[:, ::-1], axis=1)
            last, x, done = np.where(outside.any(axis=1), latest, last), orbits[:, -1], done + n
        return np.where(2 * (last + 1) <= done, last + 1.0, np.inf), near

    def _distance(self, x: Floats) -> Floats:
        """Distance of points from the attractor's bands."""
        low, high = self.attractor.bands.T
        after = np.searchsorted(low, x, side="right")
        before = np.append(-np.inf, high)[after]
        return np.minimum(np.maximum(x - before, 0.0), np.append(low, np.inf)[after] - x)


class SpaceSurroundings:
    """Of an attractor of R^n, by points that are tried."""

    def __init__(self, f: MapND, found: AttractorListND, k: int) -> None:
        self.f, self.found, self.k = f, found, k
        self.attractor: AttractorND = found[k]
        self.points = self.attractor.points
        self.cells, self.tree = cells_of(f, found), cKDTree(self.points)
        self._spread: tuple[Floats, Indices, Indices] | None = None

    def fate(self, x: Floats) -> Indices:
        """Tell whose basin points (m, n) are in; -1 undecided, -2 for what leaves."""
        return fates(self.f, reduced(self.f, x), self.cells, MAX_STEPS)[0]

    def step(self, x: Floats) -> Floats:
        """Apply the map to points of the basin, (m, n)."""
        return sample_values(self.f, x)

    def _starts(self, n_samples: int) -> tuple[Floats, Indices, Indices]:
        """Return starts spread over the domain, their fates, and the steps these took."""
        if self._spread is None or len(self._spread[0]) != n_samples:
            x, what = self.f.spread(n_samples), f"starts all over the domain, {n_samples}"
            work = Work(lambda share: doing(f"{what}: {share:.0%} followed"))
            self._spread = (x, *fates(self.f, x, self.cells, MAX_STEPS, work))
        return self._spread

    def share(self, n_samples: int) -> Estimate:
        """Return the share of starts, with its binomial error."""
        fate = self._starts(n_samples)[1]
        return binomial(int((fate == self.k).sum()), len(fate))

    def settling(self, n_samples: int, within: float) -> tuple[Floats, float]:
        """Return the steps until starts are in cells about the attractor, to stay."""
        del within  # the size of these is
        _, fate, steps = self._starts(n_samples)
        size = math.nan if self.cells is None else self.cells.size
        return np.maximum(steps[fate == self.k] - IN_A_ROW + 1.0, 0.0), size

    def displacement(self, n_samples: int, rng: np.random.Generator) -> Displacement:
        """Shrink the distance until none of the smaller displacements tried leads elsewhere.

        Half of these start all over the attractor, the others beside the shortest so far.
        """
        n, tested = self.points.shape[1], 0
        doing("displacements: any that lead away")
        best = self._first(n_samples, rng)
        if best is None:
            nothing = (math.nan,) * n
            return Displacement(math.nan, math.nan, nothing, nothing, UNDECIDED, n_samples)
        for k in range(1, ROUNDS + 1):
            doing(f"displacements, round {k}: shortest so far {best.size:.6g}")
            away = np.linalg.norm(apart(self.f, self.points, best.base), axis=1)
            close = np.argsort(away, kind="stable")[:FEW]
            local = np.arange(n_samples) % 2 == 0
            base = np.where(
                local, rng.choice(close, n_samples), rng.integers(len(away), size=n_samples)
            )
            ways = rng.normal(size=(n_samples, n))
            ways[local] *= 10.0 ** rng.uniform(-4.0, 0.0, (local.sum(), 1))
            ways[local] += best.way / best.size
            shares = rng.random(n_samples) ** (1.0 / n) * best.size / np.linalg.norm(ways, axis=1)
            found = self._shortest(self.points[base], ways * shares[:, None])
            if found is None:
                tested = n_samples
                break
            best = found
        point, by = (tuple(each.tolist()) for each in (best.base, best.way))
        into = int(self.fate((best.base + best.way)[None])[0])
        return Displacement(best.size, best.error, point, by, into, tested)

    def _first(self, n_samples: int, rng: np.random.Generator) -> _Way | None:
        """Find any way into another basin: along the axes, and to foreign starts."""
        axes = np.eye(self.points.shape[1]) * self.found.widths
        axes = np.concatenate([axes, -axes])[np.arange(n_samples) % (2 * len(axes))]
        base = self.points[rng.integers(len(self.points), size=n_samples)]
        ways = [axes * rng.random((n_samples, 1))]
        if self._spread is not None:
            foreign = self._spread[0][self._spread[1] != self.k][:n_samples]
            ways.append(apart(self.f, foreign, base[: len(foreign)]))
        return self._shortest(
            np.concatenate([base[: len(each)] for each in ways]), np.concatenate(ways)
        )

    def _shortest(self, base: Floats, ways: Floats) -> _Way | None:
        """Bisect the ways that lead out of the basin; return the shortest to any of their ends."""
        out = np.flatnonzero(self.fate(base + ways) != self.k)
        if not out.size:
            return None
        best, ends = self._bisected(base[out], ways[out])
        # Another point of the attractor may be closer to where a way ends.
        distances, nearest = self._distances(ends)
        k = int(np.argmin(distances))
        base = self.points[[int(nearest[k])]]
        ways = apart(self.f, ends[k][None], base)
        other = self._bisected(base, ways)[0] if self.fate(base + ways)[0] != self.k else best
        return min(best, other, key=lambda way: way.size)

    def _bisected(self, base: Floats, ways: Floats) -> tuple[_Way, Floats]:
        """Return the shortest of ways cut where they leave the basin, and ends near the attractor.

        Ways are left out as soon as neither their length nor the distance of their ends from the
        attractor can still be the least.
        """
        lengths = np.linalg.norm(ways, axis=1)
        low, high = np.zeros(len(ways)), np.ones(len(ways))

        def stays(share: Floats) -> Indices:
            return self.fate(base + share[:, None] * ways) == self.k

        for _ in range(HALVINGS):
            low, high = halved(stays, low, high, 1)
            off, far = (high - low) * lengths, high * lengths
            near = self._distances(base + high[:, None] * ways)[0]
            kept = (far - off <= far.min()) | (near - off <= (near + off).min())
            base, ways, lengths = base[kept], ways[kept], lengths[kept]
            low, high = low[kept], high[kept]
        k = int(np.argmin(high * lengths))
        error = float((high[k] - low[k]) * lengths[k])
        ways = high[:, None] * ways
        return _Way(base[k], ways[k], float(np.linalg.norm(ways[k])), error), base + ways

    def _distances(self, x: Floats) -> tuple[Floats, Indices]:
        """Distance of points (m, n) from the attractor's nearest points, and which these are."""
        distances, nearest = self.tree.query(x)
        return np.asarray(distances), np.asarray(nearest)


Surroundings: TypeAlias = LineSurroundings | SpaceSurroundings
