"""Newton's method for periodic orbits, with all points of an orbit as unknowns.

Shooting from one point would lose as many digits as the multiplier has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import sample, values_and_slopes
from stickslip.analysis.orbits.orbit import PeriodicOrbit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, Map1D

MAX_NEWTON: Final = 20
EPS: Final = float(np.finfo(np.float64).eps)
DENSE: Final = 16  # longest period whose equations are solved as a full matrix
STALLED: Final = 1e-9  # of the map's values: smaller steps must go on shrinking
STEEPEST: Final = 1e7  # slope beyond which rounding of a point is no excuse for a residual
MANY: Final = 64.0  # roundings that may add up in a value of the map
ROUNDINGS: Final = 4.0  # of one evaluation of a map, in its error bound

Evaluate: TypeAlias = Callable[["NDArray[np.intp]", "Floats"], tuple["Floats", "Floats"]]


@dataclass(frozen=True)
class Polished:
    """Periodic points (n, p) after Newton's method."""

    points: Floats
    slopes: Floats
    error: Floats  # bound of the points' errors: inverse Jacobian times residual and rounding
    residual: Floats  # shape (n,)
    converged: NDArray[np.bool_]  # residuals are rounding, and the error is bounded


def polish(
    evaluate: Evaluate, points: Floats, lower: Floats, upper: Floats, value_scale: float
) -> Polished:
    """Solve f(x_i) = x_(i+1) for all points of many orbits (n, p), kept between two bounds."""
    # ``evaluate(k, x)`` returns values and slopes at x, k their places in the flattened
    # ``points``.
    points = np.clip(points, lower, upper)
    slopes, residuals = np.empty_like(points), np.empty_like(points)
    still = np.zeros(len(points), dtype=bool)
    last = np.full(len(points), np.inf)
    todo = np.arange(len(points))
    for _ in range(MAX_NEWTON):
        _evaluate_rows(evaluate, points, slopes, residuals, todo)
        todo = todo[~(residual_is_rounding(slopes, residuals, value_scale) | still)[todo]]
        if not todo.size:
            break
        step = _newton_steps(slopes[todo], residuals[todo])
        moved = np.clip(points[todo] - step, lower[todo], upper[todo])
        size = np.abs(moved - points[todo]).max(axis=1)
        # Small steps that shrink no more are the rounding of the map itself.
        stalled = (size <= STALLED * value_scale) & (size > 0.25 * last[todo])
        still[todo] = (size <= EPS * value_scale) | stalled
        last[todo] = size
        points[todo] = moved
    error = _error_bound(points, slopes, residuals, value_scale)
    converged = residual_is_rounding(slopes, residuals, value_scale, MANY) & np.isfinite(error).all(
        axis=1
    )
    # The last residuals still make for one step, which need not be checked.
    points = np.clip(points - _newton_steps(slopes, residuals), lower, upper)
    return Polished(points, slopes, error, np.abs(residuals).max(axis=1), converged)


def solve_orbit(f: Map1D, guess: Floats) -> PeriodicOrbit:
    """Solve for the orbit near guessed points, on their branches; "failed" if nothing converges."""
    lo, hi = f.domain

    def evaluate(_: NDArray[np.intp], x: Floats) -> tuple[Floats, Floats]:
        return values_and_slopes(f, x)

    p = len(guess)
    ends = np.full((1, p), lo), np.full((1, p), hi)
    found = polish(evaluate, guess[None], *ends, max(abs(lo), abs(hi)))
    smallest = int(np.argmin(found.points[0]))
    points, error = np.roll(found.points[0], -smallest), np.roll(found.error[0], -smallest)
    values = sample(f, points)
    multiplier = float(values.derivative.prod())
    return PeriodicOrbit(
        points=points,
        period=p,
        multiplier=multiplier,
        stable=abs(multiplier) < 1,
        itinerary=itinerary_of(f, points, values.label),
        labels=values.label,
        quality="located" if found.converged[0] else "failed",
        interval=points[:, None] + error[:, None] * np.array([-1.0, 1.0]),
        residual=float(found.residual[0]),
        system=f,
    )


def itinerary_of(f: Map1D, points: Floats, labels: Labels) -> tuple[str, ...]:
    """Return what a map says of each point's branch: its own text if it has one, else the label."""
    describe = getattr(f, "itinerary", None)
    if describe is None:
        return tuple(str(label) for label in labels.tolist())
    return tuple(str(describe(x)) for x in points.tolist())


def residual_is_rounding(
    slopes: Floats, residuals: Floats, value_scale: float, times: float = 1.0
) -> NDArray[np.bool_]:
    """Tell which orbits no step can improve: a slope carries the rounding of its point on."""
    with np.errstate(invalid="ignore"):
        # Beside an infinite slope the bound would allow anything.
        allowed = times * EPS * value_scale * (1 + np.minimum(np.abs(slopes), STEEPEST))
        rounding = (np.abs(residuals) <= allowed) & np.isfinite(slopes)
    return np.asarray(rounding.all(axis=1))


def _evaluate_rows(
    evaluate: Evaluate, points: Floats, slopes: Floats, residuals: Floats, rows: NDArray[np.intp]
) -> None:
    """Fill in slopes and f(x_i) - x_(i+1) of some orbits."""
    p = points.shape[1]
    places = (rows[:, None] * p + np.arange(p)).ravel()
    value, slope = evaluate(places, points[rows].ravel())
    slopes[rows] = slope.reshape(-1, p)
    residuals[rows] = value.reshape(-1, p) - successors(points[rows])


def _jacobian(slopes: Floats) -> Floats:
    """Differentiate the residuals: slopes on the diagonal, -1 beside it, cyclic."""
    n, p = slopes.shape
    matrix = np.zeros((n, p, p))
    i = np.arange(p)
    matrix[:, i, i] = slopes
    matrix[:, i, (i + 1) % p] -= 1.0
    return matrix


def _newton_steps(slopes: Floats, residuals: Floats) -> Floats:
    """Solve the linear equations of each orbit; no step where they are singular (a fold)."""
    usable = np.isfinite(slopes).all(axis=1) & np.isfinite(residuals).all(axis=1)
    usable &= np.abs(slopes.prod(axis=1) - 1) > EPS
    steps = np.zeros_like(slopes)
    if usable.any() and slopes.shape[1] > DENSE:
        periods = np.full(int(usable.sum()), slopes.shape[1], dtype=np.intp)
        steps[usable] = solve_cyclic(slopes[usable], residuals[usable], periods)
    elif usable.any():
        system, right = _jacobian(slopes[usable]), residuals[usable][..., None]
        steps[usable] = np.linalg.solve(system, right)[..., 0]
    return steps


def _error_bound(points: Floats, slopes: Floats, residuals: Floats, value_scale: float) -> Floats:
    """Bound the points' errors to first order; infinite where the equations are singular."""
    bound = np.full(points.shape, np.inf)
    usable = np.isfinite(slopes).all(axis=1) & (np.abs(slopes.prod(axis=1) - 1) > EPS)
    if usable.any():
        off = np.abs(residuals[usable]) + ROUNDINGS * EPS * value_scale
        bound[usable] = inverse_bound(slopes[usable], off)
    return bound


def successors(points: Floats) -> Floats:
    """Return the point after each one around its cycle; on small arrays `numpy.roll` is slower."""
    return np.concatenate((points[..., 1:], points[..., :1]), axis=-1)


def turn_towards(points: Floats, near: Floats) -> int:
    """Return by how many places to roll an orbit back so that it comes closest to another."""
    gaps = [float(np.abs(np.roll(points, -k) - near).max()) for k in range(len(near))]
    return int(np.argmin(gaps))


def turned(points: Floats, near: Floats) -> Floats:
    """Repeat and turn an orbit so that it comes closest to one of a multiple of its period."""
    repeated = np.tile(points, len(near) // len(points))
    return np.roll(repeated, -turn_towards(repeated, near))


def solve_cyclic(slopes: Floats, right: Floats, periods: NDArray[np.intp]) -> Floats:
    """Solve s_i y_i - y_(i+1) = b_i, cyclic in each row, for many rows of their own lengths."""
    # The solution is never divided by what should be large; not finite where the slopes' product
    # is 1.
    used = np.arange(slopes.shape[1]) < periods[:, None]
    # Beyond the period y is handed on unchanged.
    s = np.where(used, slopes, 1.0)
    b = np.where(used, right, 0.0)
    y = np.empty_like(s)
    with np.errstate(all="ignore"):
        forwards = np.abs(s.prod(axis=1)) <= 1
        y[forwards] = _solve_forwards(s[forwards], b[forwards])
        y[~forwards] = _solve_backwards(s[~forwards], b[~forwards])
    return y


def _solve_forwards(s: Floats, b: Floats) -> Floats:
    """Start each row where going round once with y_(i+1) = s_i y_i - b_i leads back."""
    columns = range(s.shape[1])
    end = np.zeros(len(s))
    for j in columns:
        end = s[:, j] * end - b[:, j]
    y = np.empty_like(s)
    now = end / (1 - s.prod(axis=1))
    for j in columns:
        y[:, j] = now
        now = s[:, j] * now - b[:, j]
    return y


def _solve_backwards(s: Floats, b: Floats) -> Floats:
    """Go round the other way, y_i = (y_(i+1) + b_i) / s_i."""
    columns = range(s.shape[1] - 1, -1, -1)
    end = np.zeros(len(s))
    for j in columns:
        end = (end + b[:, j]) / s[:, j]
    y = np.empty_like(s)
    now = end / (1 - 1 / s.prod(axis=1))
    for j in columns:
        now = (now + b[:, j]) / s[:, j]
        y[:, j] = now
    return y


def inverse_bound(slopes: Floats, off: Floats) -> Floats:
    """Bound the solutions of s_i y_i - y_(i+1) = b_i over all abs(b_i) <= off_i; shapes (n, p)."""
    n, p = slopes.shape
    sizes = np.abs(np.hstack([slopes, slopes]))
    offs = np.hstack([off, off])
    total = np.zeros((n, p))
    for j in range(p):
        total = sizes[:, j : j + p] * total + offs[:, j : j + p]
    bound: Floats = total / np.abs(slopes.prod(axis=1) - 1)[:, None]
    return bound
