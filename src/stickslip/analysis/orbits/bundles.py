"""Many periodic orbits of one map, of any periods, moved to another parameter value at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.maps.protocol import sample
from stickslip.analysis.orbits.newton import EPS, residual_is_rounding, solve_cyclic, successors
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

MAX_NEWTON: Final = 12  # a guess that needs more was no guess of this orbit
STALLED: Final = 1e-9  # of the domain's size: smaller steps must go on shrinking
SAME: Final = 1e-9  # of the domain's size: points of an orbit that coincide
MANY: Final = 64.0  # roundings that may add up in a value of the map


@dataclass(frozen=True, eq=False)
class OrbitBundle:
    """k periodic orbits of one map; arrays (k, P) are padded to the longest period P."""

    periods: NDArray[np.intp]
    points: Floats  # in the map's order; NaN beyond the period
    slopes: Floats
    labels: Labels  # 0 beyond the period

    @classmethod
    def of(cls, orbits: Sequence[PeriodicOrbit], f: Map1D) -> OrbitBundle:
        """Gather orbits of the map f; refuse infinitely unstable ones, which have no slope."""
        periods = np.array([orbit.period for orbit in orbits], dtype=np.intp)
        points = np.full((len(orbits), int(periods.max(initial=1))), np.nan)
        for row, orbit in zip(points, orbits, strict=True):
            if orbit.jump is not None:
                raise ValueError(
                    f"the orbit through the jump d = {orbit.jump.d:.12g} is infinitely unstable "
                    "and cannot be followed: follow the jump itself."
                )
            row[: orbit.period] = orbit.points
        slopes, labels, _ = evaluate_padded(f, points, periods)
        return cls(periods, points, np.where(np.isnan(points), np.nan, slopes), labels)

    def __len__(self) -> int:
        """Return the number of orbits."""
        return len(self.periods)

    def take(self, index: NDArray[np.intp] | NDArray[np.bool_] | slice) -> OrbitBundle:
        """Return some of the orbits."""
        return OrbitBundle(
            self.periods[index], self.points[index], self.slopes[index], self.labels[index]
        )

    def orbit_points(self, row: int) -> Floats:
        """Return the points of one orbit, shape (period,)."""
        return self.points[row, : self.periods[row]]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which places of the padded arrays are points, shape (k, P)."""
        used: NDArray[np.bool_] = np.arange(self.points.shape[1]) < self.periods[:, None]
        return used

    @property
    def multipliers(self) -> Floats:
        """Product of each orbit's slopes, shape (k,)."""
        product: Floats = np.where(self.used, self.slopes, 1.0).prod(axis=1)
        return product


@dataclass(frozen=True, eq=False)
class Moved:
    """Orbits after a change of the parameter; arrays of shape (k,)."""

    bundle: OrbitBundle  # meaningless where not `converged`
    converged: NDArray[np.bool_]  # down to rounding
    given_up: NDArray[np.bool_]  # Newton's method led too far away, or its steps grew
    collapsed: NDArray[np.bool_]  # converged, but onto an orbit of which the period is a multiple
    surprise: Floats  # largest distance of a point from its forecast


def polish_orbits(
    bundle: OrbitBundle,
    f: Map1D,
    start: Floats | None = None,
    *,
    trust_radius: float = np.inf,
    contraction: float = np.inf,
    enough: float = 0.0,
) -> Moved:
    """Solve for orbits of f from ``start``, by default the bundle's points."""
    # Given up: further than `trust_radius` from the bundle, or steps that do not contract so.
    # A step no longer than `enough` is the last: the next would be its square.
    scale = max(abs(end) for end in f.domain)
    points = np.clip(bundle.points if start is None else start, *f.domain)
    slopes, residuals, steps = (np.full(points.shape, np.nan) for _ in range(3))
    labels = np.zeros(points.shape, dtype=np.uint64)
    todo = np.arange(len(points))
    last = np.full(len(points), np.inf)
    given_up = np.zeros(len(points), dtype=bool)
    for _ in range(MAX_NEWTON):
        periods = bundle.periods[todo]
        slope, label, residual = evaluate_padded(f, points[todo], periods)
        step = solve_cyclic(slope, -residual, periods)
        slopes[todo], labels[todo], residuals[todo], steps[todo] = slope, label, residual, step
        with np.errstate(invalid="ignore"):
            moves = ~residual_is_rounding(slope, residual, scale)
            size = np.abs(step).max(axis=1)
            moves &= size > max(EPS * scale, enough)  # not if NaN: the orbit is lost
            # Small steps that shrink no more are the rounding of the map itself.
            moves &= (size > STALLED * scale) | (size < 0.25 * last[todo])
            lost = moves & (size > STALLED * scale) & ~(size <= contraction * last[todo])
            last[todo] = size
        # An orbit may lie at the very end of the domain.
        points[todo[moves]] = np.clip(points[todo[moves]] + step[moves], *f.domain)
        if np.isfinite(trust_radius):
            away = np.abs(points[todo] - bundle.points[todo])
            lost |= moves & (np.nanmax(away, axis=1) > trust_radius)
        given_up[todo[lost]] = True
        todo = todo[moves & ~lost]
        if not todo.size:
            break
    converged = residual_is_rounding(slopes, residuals, scale, MANY) | (last <= enough)
    converged &= np.isfinite(steps).all(axis=1) & ~given_up
    # The last residuals still make for one step, which need not be checked.
    points[converged] = np.clip(points[converged] + steps[converged], *f.domain)
    unused = ~bundle.used
    points[unused] = slopes[unused] = np.nan
    moved = OrbitBundle(bundle.periods, points, slopes, labels)
    collapsed = _collapsed(moved, SAME * scale) & converged
    off = np.where(bundle.used, np.abs(points - bundle.points), 0.0)
    return Moved(moved, converged, given_up, collapsed, off.max(axis=1, initial=0.0))


def evaluate_padded(
    f: Map1D, points: Floats, periods: NDArray[np.intp]
) -> tuple[Floats, Labels, Floats]:
    """Return slopes, labels and f(x_i) - x_(i+1) in padded rows: 1, 0 and 0 beyond the period."""
    used = np.arange(points.shape[1]) < periods[:, None]
    values = sample(f, points[used])
    ok = values.status == OK
    slopes, residuals = np.ones(points.shape), np.zeros(points.shape)
    labels = np.zeros(points.shape, dtype=np.uint64)
    slopes[used] = np.where(ok, values.derivative, np.nan)
    labels[used] = np.where(ok, values.label, np.uint64(0))
    following = successors(points)
    following[np.arange(len(points)), periods - 1] = points[:, 0]
    residuals[used] = np.where(ok, values.value, np.nan) - following[used]
    return slopes, labels, residuals


def _collapsed(bundle: OrbitBundle, same: float) -> NDArray[np.bool_]:
    """Tell which orbits repeat after a divisor of their period."""
    collapsed = np.zeros(len(bundle), dtype=bool)
    columns = np.arange(bundle.points.shape[1])
    for q in range(1, bundle.points.shape[1] // 2 + 1):
        rows = np.flatnonzero((bundle.periods % q == 0) & (bundle.periods > q))
        points, periods = bundle.points[rows], bundle.periods[rows]
        later = np.take_along_axis(points, (columns + q) % periods[:, None], axis=1)
        apart = np.where(bundle.used[rows], np.abs(later - points), 0.0)
        collapsed[rows] |= apart.max(axis=1, initial=0.0) <= same
    return collapsed
