"""The equations of a periodic orbit of a map of R^n, all points unknown, and Newton's method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.maps.protocol_nd import apart, sample

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, PointValues
    from stickslip.analysis.maps.protocol_nd import MapND

MAX_STEPS: Final = 40
HALVINGS: Final = 6
DECREASE: Final = 0.25  # of the step's share: how much smaller the residual must become
CLOSED: Final = 1e-11  # residual of an orbit that Newton's method cannot make smaller, of its size
SINGULAR: Final = 1e-12  # directions in which the equations are as good as blind
SETTLED: Final = 1e-7  # of an orbit's size: how well its points must be known
ROUNDING: Final = float(np.finfo(np.float64).eps)  # of an orbit's size: of a residual
FARTHEST: Final = 10.0  # sizes of an orbit: steps beyond leave out the blind directions


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
    for i in range(p):
        matrix[..., i, :, i, :] += jacobians[..., i, :, :]
        matrix[..., i, :, (i + 1) % p, :] -= np.eye(n)
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
    """Newton's method for many orbits, in step."""

    def __init__(self, f: MapND, guesses: Floats) -> None:
        self.f = f
        self.x = guesses.copy()
        values = sample(f, self.x)
        self.jacobians, self.labels = values.derivative.copy(), values.label.copy()
        self.residuals, self.size = _residuals(f, values, self.x)
        self.active = np.isfinite(self.size)
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
        matrix = shooting_matrix(self.jacobians[index])
        right = self.residuals[index].reshape(len(index), -1, 1)
        try:
            steps = -np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            steps = np.full(right.shape, np.nan)
        far = ~(np.abs(steps).max(axis=(1, 2)) <= FARTHEST * self._sizes()[index])
        steps[far] = -np.linalg.pinv(matrix[far], rcond=SINGULAR) @ right[far]
        return np.asarray(steps.reshape(self.x[index].shape))

    def _sizes(self) -> Floats:
        return np.asarray(1.0 + np.nan_to_num(np.abs(self.x).max(axis=(1, 2))))

    def _try(self, index: NDArray[np.intp], steps: Floats, share: float) -> NDArray[np.bool_]:
        """Go where the residual falls; tell where it does."""
        x = self.x[index] + steps
        values = sample(self.f, x)
        self.n_evaluations += x[..., 0].size
        residuals, size = _residuals(self.f, values, x)
        better: NDArray[np.bool_] = size < (1.0 - DECREASE * share) * self.size[index]
        at = index[better]
        self.x[at], self.residuals[at], self.size[at] = x[better], residuals[better], size[better]
        self.jacobians[at], self.labels[at] = values.derivative[better], values.label[better]
        return better

    def solutions(self) -> Solutions:
        """Return what has been reached."""
        closed = self._is_closed()
        rows = np.flatnonzero(closed)
        matrix = shooting_matrix(self.jacobians[rows])
        least = np.linalg.svd(matrix, compute_uv=False)[:, -1]
        sizes = self._sizes()[rows]
        found = closed.copy()
        found[rows] = self.size[rows] + ROUNDING * sizes <= SETTLED * sizes * least
        parts = (self.x, self.jacobians, self.labels, self.size)
        return Solutions(*parts, found, closed & ~found, self.n_evaluations)


def _residuals(f: MapND, values: PointValues, x: Floats) -> tuple[Floats, Floats]:
    """``f(x_i) - x_(i+1)``, and the largest of each orbit: infinite where there is no value."""
    residuals = apart(f, values.value, np.roll(x, -1, axis=-2))
    smooth = np.isfinite(residuals).all(axis=(1, 2)) & np.isfinite(values.derivative).all(
        axis=(1, 2, 3)
    )
    size = np.where(smooth, np.abs(np.nan_to_num(residuals)).max(axis=(1, 2)), np.inf)
    return residuals, size
