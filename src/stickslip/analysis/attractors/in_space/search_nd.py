"""Attractors of a map of R^n: cycles by Newton's method, other sets by their recurrences.

Datseris and Wagemakers, Chaos 32 (2022) 023104, look for cells of a grid that orbits keep coming
back to. Distances between orbits do the same here, without edges of cells.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.attractors.attractor import AttractorListND, AttractorND
from stickslip.analysis.attractors.lyapunov import SETTLING, SIGMAS, LyapunovExponent
from stickslip.analysis.exponents.blocking import settled_period
from stickslip.analysis.exponents.spectrum import exponent_along
from stickslip.analysis.maps.arguments import space_points
from stickslip.analysis.maps.protocol import (
    SAME,
    apart,
    lengths,
    measured,
    orbits,
    reduced,
    sample,
    turns,
)
from stickslip.analysis.orbits.newton import solve_orbits
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND, is_minimal, make_orbit, same_points
from stickslip.analysis.scales import CELLS, NEARBY

if TYPE_CHECKING:
    from collections.abc import Callable

    from scipy.spatial import cKDTree

    from stickslip.analysis.maps.protocol import Floats, MapND
    from stickslip.analysis.work import Work

LONG: Final = 4096  # steps of an orbit on a set of its own, at first; points kept of an attractor
RESOLUTION: Final = 1 / CELLS  # of the widths: of cells about cycles; of its size: of a set's reach
REACH: Final = 2.0  # times the distance within which 0.95 of points have a neighbour: close
RECURS: Final = 0.9  # share of an orbit's points close to earlier ones: it has settled
UNFOLLOWED, LEFT = -1, -2  # fates of starts, beside the number of a set
NEUTRAL: Final = 20.0  # growth of a tangent, logarithm, over an orbit that does not stretch


@dataclass
class _Set:
    """A set that orbits settle on, as it is known so far."""

    points: Floats
    orbit: PeriodicOrbitND | None
    recurrence: float
    tree: cKDTree
    reach: float = RESOLUTION  # of the widths: other points of the set lie so close
    starts: int = 0


@dataclass
class Search:
    """Finds what starts settle on."""

    f: MapND
    widths: Floats
    max_period: int
    max_steps: int
    sets: list[_Set] = field(default_factory=list)
    settled: int = SETTLING

    def _tree(self, points: Floats) -> cKDTree:
        """Make a tree of distances in widths, angles the short way round."""
        from scipy.spatial import cKDTree  # not for maps of a line

        periods = getattr(self.f, "periods", None)
        box = None
        if periods is not None:
            box = np.where(np.isfinite(periods), periods, 0.0) / self.widths
        return cKDTree(self._scaled(points), boxsize=box)

    def _scaled(self, points: Floats) -> Floats:
        """Measure in widths; angles, from the low end of their period on, are in [0, period)."""
        whole = turns(self.f)
        low = np.where(np.isfinite(whole[:, 1]), whole[:, 0], 0.0)
        return np.asarray((reduced(self.f, points) - low) / self.widths)

    def near(self, known: _Set, points: Floats) -> float:
        """Share of points that lie close to a set."""
        reach = known.tree.query(self._scaled(points), distance_upper_bound=known.reach)[0]
        return float(np.isfinite(reach).mean())

    def recurring(self, path: Floats) -> _Set:
        """Tell how well later points come as close to earlier ones as these to each other."""
        half = len(path) // 2
        # In no order of time: of two islands visited in turn, every second step sees one.
        early = np.random.default_rng(0).permutation(path[:half])
        made = _Set(path, None, 0.0, self._tree(early[::2]))
        distances = made.tree.query(self._scaled(early[1::2]))[0]
        size = np.ptp(made.tree.data, axis=0).max()
        far = REACH * float(np.quantile(distances, 0.95))
        made.reach = max(far, RESOLUTION * float(size), SAME)  # of a point all are nothing
        made.recurrence = self.near(made, path[half:])
        made.tree = self._tree(path)
        return made

    # ------------------------------------------------------------------ cycles

    def add_cycles(self, paths: Floats) -> list[int]:
        """Find on which cycle each orbit (m, k, n) ends; -1 for none."""
        found = [-1] * len(paths)
        scaled = np.abs(apart(self.f, paths[:, -1:], paths[:, :-1])[:, ::-1] / self.widths)
        distance = scaled.max(axis=2)[:, : self.max_period]
        # Closer than after fewer steps: what repeats exactly would be tried in every multiple.
        nearest = np.minimum.accumulate(distance, axis=1)
        closer = np.diff(nearest, axis=1, prepend=np.inf) < 0.0
        for p in range(1, distance.shape[1] + 1):
            best = closer[:, p - 1] & (distance[:, p - 1] < NEARBY)
            rows = [i for i in np.flatnonzero(best) if found[i] < 0]
            if not rows:
                continue
            got = solve_orbits(self.f, paths[rows, -p:])
            for k in np.flatnonzero(got.found):
                moved = np.abs(apart(self.f, got.points[k], paths[rows[k], -p:])) / self.widths
                if moved.max() < 10 * NEARBY and is_minimal(self.f, got.points[k]):
                    parts = (got.points[k], got.jacobians[k], got.labels[k], got.residual[k])
                    orbit = make_orbit(self.f, *parts)
                    if orbit.stable:
                        found[rows[k]] = self._cycle(orbit)
        return found

    def _cycle(self, orbit: PeriodicOrbitND) -> int:
        for k, known in enumerate(self.sets):
            other = known.orbit
            if other is not None and same_points(self.f, other.points, orbit.points):
                return k
        self.sets.append(_Set(orbit.points, orbit, 1.0, self._tree(orbit.points)))
        return len(self.sets) - 1

    # ------------------------------------------------------------------ other sets

    def settle(self, path: Floats) -> int:
        """Find what one orbit (k, n) ends on, followed further until it recurs, or leaves."""
        tail = path[-len(path) // 2 :]
        steps, n = SETTLING, LONG
        while True:
            if (k := self._set_near(tail, RECURS)) is not None:
                return k
            path = orbits(self.f, path[-1:], n)[0]
            steps += n
            if not np.isfinite(path[-1]).all():
                return LEFT
            if (k := self.add_cycles(path[None])[0]) >= 0:
                break
            made = self.recurring(path)
            if made.recurrence >= RECURS or steps + 2 * n > self.max_steps:
                # Half of them close to those of another orbit: both are on one set.
                if (near := self._set_near(made.points, 0.5)) is None:
                    self.sets.append(made)
                k = len(self.sets) - 1 if near is None else near
                break
            tail, n = path[n // 2 :], 2 * n
        self.settled = max(self.settled, steps)
        return k

    def _set_near(self, points: Floats, share: float) -> int | None:
        """Return the number of a set, no cycle, that such a share of points lies close to."""
        sets = enumerate(self.sets)
        near = (k for k, s in sets if s.orbit is None and self.near(s, points) >= share)
        return next(near, None)

    # ------------------------------------------------------------------ results

    def attractor(self, known: _Set, n_starts: int) -> AttractorND:
        """Describe a set."""
        orbit = known.orbit
        kind: Any
        if orbit is not None:
            value = np.log(max(float(np.abs(orbit.multipliers[0])), 1e-300)) / orbit.period
            lyapunov = LyapunovExponent(value, 0.0, orbit.period)
            kind, reason = "periodic", ""
        else:
            jacobians = measured(sample(self.f, known.points).derivative, lengths(self.f))
            lyapunov = LyapunovExponent(*exponent_along(jacobians))
            kind, reason = self._kind(known, lyapunov, jacobians)
        return AttractorND(
            kind=kind,
            period=0 if orbit is None else orbit.period,
            orbit=orbit,
            points=known.points[-LONG:],
            lyapunov=lyapunov,
            basin_share=known.starts / n_starts,
            recurrence=known.recurrence,
            reason=reason,
        )

    def _kind(self, known: _Set, lyapunov: LyapunovExponent, jacobians: Floats) -> tuple[Any, str]:
        value, error = lyapunov
        if known.recurrence < RECURS:
            return "undecided", f"has not settled within {self.max_steps} steps"
        neutral = abs(value) * lyapunov.n <= NEUTRAL
        if neutral and (period := settled_period(self._scaled(known.points), SAME)):
            steps = "step" if period == 1 else f"{period} steps"
            return "undecided", f"repeats every {steps}, and so do motions beside it"
        volumes = float(np.linalg.slogdet(jacobians)[1].mean())  # growth of their logarithm
        keeps = abs(volumes) * lyapunov.n <= 1.0
        # Unless a set is the whole space, as on a circle that turns irrationally.
        if keeps and not (neutral and self.near(known, self.f.spread(LONG)) >= RECURS):
            return "undecided", "it keeps volumes: nothing attracts"
        if value > SIGMAS * error and value * lyapunov.n > NEUTRAL:
            return "chaotic", ""
        if neutral:
            return "quasiperiodic", ""
        return "undecided", "the exponent's sign is not clear, and no cycle was found"


def search_attractors(
    f: MapND,
    starts: Floats,
    widths: Floats,
    max_period: int,
    max_steps: int,
    features: Callable[[Floats], Any] | None,
    work: Work,
) -> AttractorListND:
    """Find what starts settle on, as `stickslip.attractors` describes it."""
    search = Search(f, widths, max_period, max_steps)
    fate = np.full(len(starts), UNFOLLOWED)
    with work.until_interrupted():
        ends = orbits(f, starts, SETTLING)[:, -1]
        paths = orbits(f, ends, SETTLING)
        there = np.flatnonzero(np.isfinite(paths[:, -1]).all(axis=1))
        fate[np.setdiff1d(np.arange(len(starts)), there)] = LEFT
        if features is None:
            if there.size:
                fate[there] = search.add_cycles(paths[there])
            for i in there[fate[there] == UNFOLLOWED]:
                work.tell(float((fate != UNFOLLOWED).mean()))
                fate[i] = search.settle(paths[i])
        elif there.size:
            fate[there] = _grouped(search, paths[there], features)
        work.tell(1.0)
    for k, known in enumerate(search.sets):
        known.starts = int((fate == k).sum())
    listed = [search.attractor(known, len(starts)) for known in search.sets]
    return AttractorListND(
        attractors=tuple(sorted(listed, key=lambda a: -a.basin_share)),
        left=float((fate == LEFT).mean()),
        n_starts=len(starts),
        resolution=max([RESOLUTION, *(known.reach for known in search.sets)]),
        widths=widths,
        settled=search.settled,
        unfollowed=int((fate == UNFOLLOWED).sum()),
        system=f,
    )


def _grouped(search: Search, paths: Floats, features: Callable[[Floats], Any]) -> list[int]:
    """Group orbits by their features: clusters of single linkage, cut at the widest gap."""
    from scipy.cluster.hierarchy import fcluster, linkage  # not for other searches

    found = np.array([np.atleast_1d(features(path)) for path in paths], dtype=np.float64)
    if len(found) == 1:
        return [search.settle(paths[0])]
    spread = np.ptp(found, axis=0)
    tree = linkage(found / np.where(spread > 0.0, spread, 1.0), "single")
    heights = np.concatenate([[0.0], tree[:, 2]])
    cut = int(np.argmax(np.diff(heights)))
    group = fcluster(tree, 0.5 * (heights[cut] + heights[cut + 1]), "distance") - 1
    for k in range(group.max() + 1):
        path = paths[np.flatnonzero(group == k)[0]]
        before = len(search.sets)
        if search.add_cycles(path[None])[0] < 0 or len(search.sets) == before:
            search.sets.append(search.recurring(path))
    return group.tolist()


def seeds(f: MapND, starts: Any, n_starts: int) -> tuple[Floats, Floats]:
    """Return starts, reduced, and the widths of their region in each coordinate."""
    given = f.spread(n_starts) if starts is None else space_points(f, "starts", starts)
    x = reduced(f, given.reshape(-1, f.dimension))
    widths = np.ptp(x, axis=0)
    if starts is not None and (domain := getattr(f, "domain", None)) is not None:
        given = np.ptp(np.asarray(domain, dtype=np.float64), axis=1)
        widths = np.where(np.isfinite(given), given, widths)
    return x, np.where(widths > 0.0, widths, 1.0)
