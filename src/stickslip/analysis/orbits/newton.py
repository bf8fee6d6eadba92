"""Newton's method for periodic orbits, with all points of an orbit as unknowns.

Shooting from one point would lose as many digits as the multiplier has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import apart, domain_size, lengths, measured, sample
from stickslip.analysis.orbits._kernels import NewtonLimits, NewtonStates, cyclic_rows, newton_step
from stickslip.analysis.orbits.orbit import PeriodicOrbit, orbit_of
from stickslip.numerics.arrays import EPS, Columns

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D, MapND, PointValues

MAX_NEWTON: Final = 20
STALLED: Final = 1e-9  # of the map's values: smaller steps must go on shrinking
SHRINKING: Final = 0.25  # ... by this factor
SAME: Final = 1e-9  # of the size of points or domain: points of one orbit that coincide
STEEPEST: Final = 1e7  # slope beyond which rounding of a point is no excuse for a residual
MANY: Final = 64.0  # roundings that may add up in a value of the map, or a multiplier
ROUNDINGS: Final = 4.0  # of one evaluation of a map, in its error bound
MAX_STEPS: Final = 40
HALVINGS: Final = 6
DECREASE: Final = 0.25  # of the step's share: how much smaller the residual must become
CLOSED: Final = 1e-11  # residual of an orbit that Newton's method cannot make smaller, of its size
STEP: Final = 1e-3  # of the map's values: from float to float, as beside a logarithm
SINGULAR: Final = 1e-12  # directions in which the equations are as good as blind
SETTLED: Final = 1e-7  # of an orbit's size: how well its points must be known
FARTHEST: Final = 10.0  # sizes of an orbit: steps beyond leave out the blind directions

# Values, slopes and labels at points, whose places in the flattened array come first.
Evaluate: TypeAlias = Callable[["NDArray[np.intp]", "Floats"], tuple["Floats", "Floats", "Labels"]]


def padded(rows: Sequence[Floats]) -> tuple[Floats, NDArray[np.intp]]:
    """Return rows of any lengths as one array, NaN beyond the end of each, and the lengths."""
    lengths = np.array([len(row) for row in rows], dtype=np.intp)
    wide = np.full((len(rows), int(lengths.max(initial=1))), np.nan)
    for line, row in zip(wide, rows, strict=True):
        line[: len(row)] = row
    return wide, lengths


@dataclass(frozen=True, eq=False)
class OrbitBundle(Columns):
    """k periodic orbits of one map; arrays (k, P) are padded to the longest period P."""

    periods: NDArray[np.intp]
    points: Floats  # in the map's order; NaN beyond the period
    slopes: Floats
    labels: Labels  # 0 beyond the period

    @classmethod
    def of(cls, orbits: Sequence[PeriodicOrbit], f: Map1D) -> OrbitBundle:
        """Gather orbits of the map f, none infinitely unstable: such a one has no slope."""
        points, periods = padded([orbit.points for orbit in orbits])
        values = sample(f, points)
        return cls(periods, points, values.derivative, values.label)

    def orbit_points(self, row: int) -> Floats:
        """Return the points of one orbit, shape (period,)."""
        return self.points[row, : self.periods[row]]

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which places of the padded arrays are points, shape (k, P)."""
        return np.arange(self.points.shape[1]) < self.periods[:, None]

    @property
    def multipliers(self) -> Floats:
        """Product of each orbit's slopes, shape (k,); infinite beyond the range of floats."""
        with np.errstate(over="ignore"):
            product: Floats = np.where(self.used, self.slopes, 1.0).prod(axis=1)
        return product

    def repeats(self, slack: ArrayLike) -> NDArray[np.bool_]:
        """Tell which orbits repeat, up to a slack, after a divisor of their period; shape (k,)."""
        found = np.zeros(len(self), dtype=bool)
        columns, slack = np.arange(self.points.shape[1]), np.broadcast_to(slack, self.points.shape)
        for q in range(1, self.points.shape[1] // 2 + 1):
            rows = np.flatnonzero((self.periods % q == 0) & (self.periods > q))
            if rows.size:
                points, periods = self.points[rows], self.periods[rows, None]
                later = np.take_along_axis(points, (columns + q) % periods, axis=1)
                with np.errstate(invalid="ignore"):
                    same = (np.abs(later - points) <= slack[rows]) | (columns >= periods)
                found[rows] |= same.all(axis=1)
        return found


@dataclass(frozen=True, eq=False)
class Polished(OrbitBundle):
    """Orbits after Newton's method; meaningless where not `converged`."""

    off: Floats  # residuals and rounding, which make the error
    surprise: Floats  # largest distance of a point from its guess, shape (n,)
    residual: Floats
    closed: NDArray[np.bool_]  # residuals are rounding
    converged: NDArray[np.bool_]  # ... and the equations are regular
    given_up: NDArray[np.bool_]  # led too far away, or by growing steps

    @cached_property
    def error(self) -> Floats:
        """Bound of the points' errors to first order; infinite where the equations are singular."""
        return error_bound(self.slopes, self.off)

    @cached_property
    def collapsed(self) -> NDArray[np.bool_]:
        """Which have converged onto an orbit of which their period is a multiple."""
        size = np.abs(np.nan_to_num(self.points)).max(axis=1, keepdims=True, initial=0.0)
        return self.converged & self.repeats(SAME * size)


def polish(
    evaluate: Evaluate,
    guess: Floats,
    lower: ArrayLike,
    upper: ArrayLike,
    scale: float,
    *,
    periods: NDArray[np.intp] | None = None,
    trust_radius: float = np.inf,
    contraction: float = np.inf,
    enough: float = 0.0,
) -> Polished:
    """Solve f(x_i) = x_(i+1) for all points of many orbits (n, P), kept between two bounds."""
    # Given up: further than `trust_radius` from the guess, or steps that do not contract so.
    # A step no longer than `enough` is the last: the next would be its square.
    (n, width), new = guess.shape, np.zeros_like
    periods = np.full(n, width) if periods is None else np.array(periods)
    used = np.arange(width) < periods[:, None]
    # Copies: kernels are compiled for one kind of array.
    guess, lower, upper = (np.full(guess.shape, each) for each in (guess, lower, upper))
    points = np.clip(guess, lower, upper)
    slopes, residuals, steps = np.ones_like(guess), new(guess), new(guess)
    labels, last = new(guess, dtype=np.uint64), np.full(n, np.inf)
    moving, given_up = np.ones(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    states = NewtonStates(
        *(periods, guess, lower, upper, points, slopes, residuals, steps),
        *(labels, last, moving, given_up),
    )
    limits = NewtonLimits(
        *(EPS, EPS * scale, STEEPEST, enough, STALLED * scale, SHRINKING, CLOSED * scale),
        *(contraction, trust_radius),
    )
    for _ in range(MAX_NEWTON):
        places = np.flatnonzero(used & moving[:, None])
        newton_step(states, limits, *evaluate(places, points.ravel()[places]))
        if not moving.any():
            break
    with np.errstate(invalid="ignore"):
        # A slope carries the rounding of its point on; an infinite one would excuse anything.
        allowed = MANY * EPS * scale * (1 + np.minimum(np.abs(slopes), STEEPEST))
        rounding = (np.abs(residuals) <= allowed) & np.isfinite(slopes)
    closed = rounding.all(axis=1)
    # Or the map's own, which may be more: a motion's states grow on their way.
    closed |= (last <= STALLED * scale) & (np.abs(residuals) <= CLOSED * scale).all(axis=1)
    # Or as small as points allow, however steep the map, if no float next to them is better.
    closed |= (last <= EPS * scale) & (np.abs(residuals) <= STEP * scale).all(axis=1)
    closed &= ~given_up
    converged = (closed | (last <= enough)) & np.isfinite(steps).all(axis=1) & ~given_up
    # The last residuals still make for one step, which need not be checked.
    points[converged] = (points - steps)[converged]
    points = np.where(used, np.clip(points, lower, upper), np.nan)
    off = np.where(used, np.abs(residuals) + ROUNDINGS * EPS * scale, 0.0)
    surprise = np.where(used, np.abs(points - guess), 0.0).max(axis=1, initial=0.0)
    known = off, surprise, np.abs(residuals).max(axis=1, initial=0.0)
    return Polished(periods, points, slopes, labels, *known, closed, converged, given_up)


def polish_on(f: Map1D, guess: Floats, scale: float | None = None, **options: Any) -> Polished:
    """Solve for orbits of a map near guessed ones, on its domain; see `polish`."""

    def evaluate(_: NDArray[np.intp], x: Floats) -> tuple[Floats, Floats, Labels]:
        values = sample(f, x)
        return values.value, values.derivative, values.label

    scale = domain_size(f) if scale is None else scale
    return polish(evaluate, guess, *f.domain, scale, **options)


def solve_orbit(f: Map1D, guess: Floats) -> PeriodicOrbit:
    """Solve for the orbit near guessed points, on their branches; "failed" if nothing converges."""
    found = polish_on(f, guess[None])
    quality = "located" if found.converged[0] else "failed"
    return orbit_through(f, found.points[0], found.error[0], float(found.residual[0]), quality)


def orbit_through(
    f: Map1D,
    points: Floats,
    error: Floats | None = None,
    residual: float | None = None,
    quality: str = "located",
) -> PeriodicOrbit:
    """Describe the orbit at points that are solved for; errors are those of its values if none."""
    values = sample(f, points)
    off = np.abs(values.value - np.roll(points, -1))
    return orbit_of(
        f,
        points,
        values.label,
        multiplier=float(values.derivative.prod()),
        error=off if error is None else error,
        residual=float(off.max()) if residual is None else residual,
        quality=quality,
    )


def turned(points: Floats, near: Floats) -> Floats:
    """Repeat and turn an orbit so that it comes closest to one of a multiple of its period."""
    n = len(near)
    repeated = np.tile(points, n // len(points))
    rolled = repeated[np.add.outer(np.arange(n), np.arange(n)) % n]
    return rolled[np.argmin(np.abs(rolled - near).max(axis=1))]


def solve_cyclic(slopes: Floats, right: Floats, periods: NDArray[np.intp]) -> Floats:
    """Solve s_i y_i - y_(i+1) = b_i, cyclic in each row, for many rows of their own lengths.

    Not finite where the slopes' product is 1; 0 beyond a row's length.
    """
    y: Floats = np.zeros(slopes.shape)
    cyclic_rows(slopes, right, periods, y)
    return y


def error_bound(slopes: Floats, off: Floats) -> Floats:
    """Bound the errors of orbits by residuals and rounding; infinite where that tells nothing."""
    bound = np.full(slopes.shape, np.inf)
    with np.errstate(invalid="ignore"):  # not beside an infinite slope, or at a fold
        singular = np.abs(slopes.prod(axis=1) - 1) <= EPS
    usable = np.isfinite(slopes).all(axis=1) & ~singular
    # The largest solutions of s_i y_i - y_(i+1) = b_i over all abs(b_i) <= off_i.
    s, b, p = slopes[usable], off[usable], slopes.shape[1]
    sizes, offs, total = np.abs(np.hstack([s, s])), np.hstack([b, b]), np.zeros(s.shape)
    for j in range(p):
        total = sizes[:, j : j + p] * total + offs[:, j : j + p]
    bound[usable] = total / np.abs(s.prod(axis=1) - 1)[:, None]
    return bound


# ------------------------------------------------------------------ in R^n


@dataclass(frozen=True, eq=False)
class Solutions:
    """Orbits found from several guesses, shapes (m, p, n), (m, p, n, n), (m, p), (m,).

    `degenerate`: where equations are so close to singular that rounding leaves points undecided.
    """

    points: Floats
    jacobians: Floats
    labels: Labels
    residual: Floats
    found: NDArray[np.bool_]
    degenerate: NDArray[np.bool_]
    n_evaluations: int


def shooting_matrix(jacobians: Floats) -> Floats:
    """Jacobian of ``f(x_i) - x_(i+1)``, cyclic, shape (..., p n, p n), from (..., p, n, n)."""
    *front, p, n, _ = jacobians.shape
    matrix = np.zeros((*front, p, n, p, n))
    unit = np.eye(n)
    for i in range(p):
        matrix[..., i, :, i, :] += jacobians[..., i, :, :]
        matrix[..., i, :, (i + 1) % p, :] -= unit
    return matrix.reshape(*front, p * n, p * n)


def monodromy(jacobians: Floats) -> Floats:
    """Jacobian of f^p at the first point, from those at all points, (..., p, n, n)."""
    product = jacobians[..., 0, :, :]
    for i in range(1, jacobians.shape[-3]):
        product = jacobians[..., i, :, :] @ product
    return product


def solve_orbits(f: MapND, guesses: Floats) -> Solutions:
    """Solve for periodic orbits from many guesses (m, p, n), NaN none, by damped Newton steps."""
    iteration = _Iteration(f, guesses)
    for _ in range(MAX_STEPS):
        if not iteration.active.any():
            break
        iteration.step()
    return iteration.solutions()


class _Iteration:
    """Newton's method for many orbits, in step; sizes, steps and residuals in the map's lengths."""

    def __init__(self, f: MapND, guesses: Floats) -> None:
        self.f, self.unit = f, lengths(f)
        self.x = guesses.copy()
        values = sample(f, self.x)
        self.jacobians, self.labels = values.derivative.copy(), values.label.copy()
        self.residuals, self.size = self._residuals(values, self.x)
        self.active = np.isfinite(self.size)
        self.torn = np.zeros(len(guesses), dtype=bool)  # the last step led off: to another piece
        self.n_evaluations = self.x[..., 0].size

    def _is_closed(self) -> NDArray[np.bool_]:
        return np.asarray(self.size <= CLOSED * self._sizes())

    def step(self) -> None:
        """Make one step of every orbit that still comes closer."""
        index = np.flatnonzero(self.active)
        steps = self._newton_steps(index)
        share = 1.0
        closed = self._is_closed()[index]
        for trial in range(HALVINGS):
            better = self._try(index, share * steps, share)
            keep = ~better & ~closed  # at rounding a shorter step does not help
            self.active[index[~better & closed]] = False
            index, steps, closed = index[keep], steps[keep], closed[keep]
            share *= 0.5
            if not index.size:
                return
            if trial == HALVINGS - 1:
                self.active[index] = False

    def _newton_steps(self, index: NDArray[np.intp]) -> Floats:
        matrix = shooting_matrix(measured(self.jacobians[index], self.unit))
        right = self.residuals[index].reshape(len(index), -1, 1)
        try:
            steps = -np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            steps = np.full(right.shape, np.nan)
        far = ~(np.abs(steps).max(axis=(1, 2)) <= FARTHEST * self._sizes()[index])
        steps[far] = -np.linalg.pinv(matrix[far], rcond=SINGULAR) @ right[far]
        return np.asarray(steps.reshape(self.x[index].shape))

    def _sizes(self) -> Floats:
        return np.asarray(1.0 + np.nan_to_num(np.abs(self.x / self.unit).max(axis=(1, 2))))

    def _try(self, index: NDArray[np.intp], steps: Floats, share: float) -> NDArray[np.bool_]:
        """Go where the residual falls; tell where it does."""
        x = self.x[index] + steps * self.unit
        values = sample(self.f, x)
        self.n_evaluations += x[..., 0].size
        residuals, size = self._residuals(values, x)
        better: NDArray[np.bool_] = size < (1.0 - DECREASE * share) * self.size[index]
        self.torn[index] = ~(size <= CLOSED * self._sizes()[index])
        at = index[better]
        self.x[at], self.residuals[at], self.size[at] = x[better], residuals[better], size[better]
        self.jacobians[at], self.labels[at] = values.derivative[better], values.label[better]
        return better

    def solutions(self) -> Solutions:
        """Return what has been reached."""
        closed = self._is_closed() & ~self.torn
        rows = np.flatnonzero(closed)
        matrix = shooting_matrix(measured(self.jacobians[rows], self.unit))
        least = np.linalg.svd(matrix, compute_uv=False)[:, -1]
        sizes = self._sizes()[rows]
        found = closed.copy()
        found[rows] = self.size[rows] + EPS * sizes <= SETTLED * sizes * least
        size = np.abs(self.residuals * self.unit).max(axis=(1, 2))
        parts = (self.x, self.jacobians, self.labels, size)
        return Solutions(*parts, found, closed & ~found, self.n_evaluations)

    def _residuals(self, values: PointValues, x: Floats) -> tuple[Floats, Floats]:
        """``f(x_i) - x_(i+1)``, and the largest of each orbit: infinite where there is no value."""
        residuals = apart(self.f, values.value, np.roll(x, -1, axis=-2)) / self.unit
        smooth = np.isfinite(residuals).all(axis=(1, 2)) & np.isfinite(values.derivative).all(
            axis=(1, 2, 3)
        )
        size = np.where(smooth, np.abs(np.nan_to_num(residuals)).max(axis=(1, 2)), np.inf)
        return residuals, size
