"""Belt speeds at which steady sliding loses or regains stability, and the cycles born there."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np
from scipy.optimize import linear_sum_assignment, minimize_scalar

from stickslip.checks import finite_number
from stickslip.mechanics.cycle.sliding import (
    Model,
    Modes,
    force_derivatives,
    modes,
    steady_displacements,
)
from stickslip.numerics.zeros import halved, middle_zero
from stickslip.results.result import Result

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from stickslip.numerics.arrays import Complexes, Floats


N_SPEEDS: Final = 400
SAME: Final = 1e-11  # relative: speeds that rounding tells apart
DEGENERATE: Final = 1e-9  # of the sizes that cancel in it: a Lyapunov coefficient of no sign
SPEED_STEP: Final = 1e-5  # relative, of the central difference of the growth rate


@dataclass(frozen=True, eq=False, repr=False)
class HopfPoint(Result):
    """A belt speed at which a pair of modes about steady sliding begins or ceases to grow.

    Near it the amplitude a of the motion (largest displacement of a block from steady sliding)
    obeys ``a' = crossing (V - V_0) a + lyapunov a^3``.

    Attributes
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
        At this belt speed.
    V : float
    frequency : float
        At onset, units of sqrt(k / m).
    crossing : float
        Derivative of the growth rate with V: negative where the motion calms as the belt
        becomes faster.
    changes_stability : bool
        Steady sliding is unstable on one side and not on the other: no other mode grows there.
    lyapunov : float or None
        First Lyapunov coefficient; None for a law that has no series.
    criticality : {"super", "sub", None}
        ``super``: the cycles born attract, where nothing else grows, and squeal sets in softly;
        ``sub``: they repel, and it sets in with a jump. None where the coefficient vanishes or
        is not known.
    mode : ndarray of complex, shape (N,)
        Displacements of the mode, largest entry 1.
    """

    model: Model
    V: float
    frequency: float
    crossing: float
    changes_stability: bool
    lyapunov: float | None
    criticality: Literal["super", "sub"] | None
    mode: Complexes
    _column_names: ClassVar = (
        *("V", "frequency", "period", "crossing", "changes_stability", "lyapunov", "criticality"),
    )
    _drawn: ClassVar = ("V", "frequency")
    _has_picture: ClassVar = False

    @property
    def period(self) -> float:
        """Period of the motion at onset."""
        return float(2.0 * np.pi / self.frequency)

    def amplitude(self, V: float) -> float:
        """Amplitude of the cycle at a nearby belt speed, to leading order; NaN on the side without.

        Raises
        ------
        ValueError
            The Lyapunov coefficient is unknown or zero.
        """
        if self.lyapunov is None or self.criticality is None:
            raise ValueError("the first Lyapunov coefficient of this point is unknown or zero")
        square = -self.crossing * (finite_number("V", V) - self.V) / self.lyapunov
        return float(np.sqrt(square)) if square >= 0.0 else float("nan")

    def state(self, amplitude: float) -> tuple[Floats, Floats]:
        """Displacements and velocities on the linear mode with an amplitude, shape (N,) each."""
        amplitude = finite_number("amplitude", amplitude)
        x = steady_displacements(self.model, self.V)
        v = amplitude * (1j * self.frequency * self.mode).real
        return x + amplitude * self.mode.real, np.asarray(v)

    def __repr__(self) -> str:
        """One line."""
        kind = {"super": "supercritical", "sub": "subcritical", None: "criticality undecided"}
        way = "calms" if self.crossing < 0 else "starts to grow"
        return (
            f"HopfPoint: V = {self.V:.12g}, frequency {self.frequency:.10g}, "
            f"{kind[self.criticality]}, {way} as V grows"
        )

    def _columns(self) -> dict[str, Any]:
        return {name: [getattr(self, name)] for name in self._column_names}


def hopf_points(model: Model, speeds: tuple[float, float]) -> tuple[HopfPoint, ...]:
    """Find all Hopf points in a range of belt speeds, ascending.

    Pairs alone cross the axis, as K is regular: sign changes of growth rates on a
    grid, and extrema that a parabola carries across zero, are bracketed.
    """
    grid = np.geomspace(*speeds, N_SPEEDS)
    found = FollowedModes(lambda V: modes(model, V).values, grid).crossings()
    return tuple(
        point
        for V, group in groupby(found, key=lambda each: each[0])
        for point in _points(model, V, [mode for _, mode in group])
    )


class FollowedModes:
    """Modes along a parameter, each followed to the nearest one at the next value of a grid."""

    def __init__(self, eigenvalues: Callable[[float], Complexes], grid: Floats) -> None:
        self.eigenvalues, self.grid = eigenvalues, grid
        rows = [eigenvalues(value) for value in grid.tolist()]
        for k in range(1, len(rows)):
            rows[k] = rows[k][nearest(rows[k - 1], rows[k])]
        self.values = np.array(rows)  # a column each mode
        self.rates = self.values.real

    def crossings(self) -> list[tuple[float, complex]]:
        """Values at which pairs cross the imaginary axis, ascending, and the upper mode of each."""
        found: list[tuple[float, int]] = []
        for mode, rates in enumerate(self.rates.T):

            def rate(value: float, mode: int = mode) -> float:
                return self._at(value, mode).real

            for low, high in _brackets(rate, self.grid, rates):
                if max(self._at(end, mode).imag for end in (low, high)) > 0.0:
                    found.append((middle_zero(rate, low, high), mode))
        crossed: list[tuple[float, complex]] = []
        for value, mode in sorted(found):
            if crossed and value - crossed[-1][0] <= SAME * abs(value):
                value = crossed[-1][0]  # several cross there
            crossed.append((value, self._at(value, mode)))
        return crossed

    def coalescences(self) -> list[tuple[float, complex]]:
        """Values at which undamped modes meet and part into one that grows, one that decays.

        There the square of the modes' difference changes its sign smoothly, while each has the
        accuracy of a root: flutter without damping.
        """
        neutral, found = self.rates == 0.0, set()
        for row, mode in np.argwhere(neutral[:-1] != neutral[1:]).tolist():
            apart, way = (row, 1) if neutral[row, mode] else (row + 1, -1)
            for parted in (apart + way, apart + 2 * way):  # the grid may hit where they meet
                if 0 <= parted < len(self.grid) and (met := self._met(apart, parted, mode)):
                    found.add(met)
                    break
        return sorted(found, key=lambda each: each[0])

    def _at(self, value: float, mode: int) -> complex:
        values, near = self.eigenvalues(value), np.interp(value, self.grid, self.values[:, mode])
        return complex(values[np.argmin(np.abs(values - near))])

    def _met(self, apart: int, parted: int, first: int) -> tuple[float, complex] | None:
        """Where a mode and another one meet between two values of the grid, and what they are."""
        ends = [apart, parted]
        others = np.abs(self.values[parted] + np.conj(self.values[parted, first]))
        others[first] = np.inf
        pair = sorted((first, int(np.argmin(others))))
        start, end = (self._smooth(*self.values[each, pair]) for each in ends)
        upper = (self.values[ends][:, pair].imag > 0.0).all()
        if not upper or self.rates[apart, pair].any() or start[1].real * end[1].real >= 0.0:
            return None

        def near(value: float) -> Complexes:
            values = self.eigenvalues(value)
            values = values[values.imag > 0.0]
            one, other = np.triu_indices(len(values), 1)
            means, squares = self._smooth(values[one], values[other])
            share = (value - self.grid[apart]) / (self.grid[parted] - self.grid[apart])
            mean, square = start + share * (end - start)
            off = np.abs(means - mean) ** 2 + np.abs(squares - square)
            k = np.argmin(off)
            return np.array([means[k], squares[k]])

        def apart_at(value: float) -> bool:
            return bool(near(value)[1].real * start[1].real > 0.0)

        a, b = self.grid[ends].tolist()
        value, _ = halved(apart_at, a, b, sys.float_info.mant_dig)
        return value, complex(near(value)[0])

    @staticmethod
    def _smooth(one: Complexes, other: Complexes) -> Complexes:
        """Mean of two modes and square of their difference, which are smooth where they meet."""
        return np.array([(one + other) / 2.0, (one - other) ** 2])


def nearest(modes: Complexes, values: Complexes) -> NDArray[np.intp]:
    """Which of some values is each mode's own: all together move as little as they can."""
    return np.asarray(linear_sum_assignment(np.abs(modes[:, None] - values))[1])


def effect(below: Complexes, above: Complexes) -> int:
    """1 if steady sliding begins to be unstable, -1 if it ceases to be, 0 if it does neither."""
    return int(above.real.max() > 0.0) - int(below.real.max() > 0.0)


def _brackets(
    rate: Callable[[float], float], grid: Floats, values: Floats
) -> list[tuple[float, float]]:
    """Intervals over which a function changes its sign."""
    brackets: list[tuple[float, float]] = []
    for k in range(len(grid) - 1):
        if values[k] * values[k + 1] < 0:
            brackets.append((float(grid[k]), float(grid[k + 1])))
    for k in range(1, len(grid) - 1):
        if values[k] == 0.0 and values[k - 1] * values[k + 1] < 0.0:
            brackets.append((float(grid[k - 1]), float(grid[k + 1])))
        before, here, after = np.abs(values[k - 1 : k + 2])
        same = values[k - 1] * values[k] > 0 and values[k] * values[k + 1] > 0
        if same and here < min(before, after):
            ends = float(grid[k - 1]), float(grid[k + 1])
            sign = float(np.sign(values[k]))
            lowest = minimize_scalar(lambda V, s=sign: s * rate(V), bounds=ends, method="bounded")
            if sign * rate(float(lowest.x)) < 0.0:
                brackets += [(ends[0], float(lowest.x)), (float(lowest.x), ends[1])]
    return brackets


def _points(model: Model, V: float, crossing: Sequence[complex]) -> list[HopfPoint]:
    """Every pair of modes that crosses at a speed (two, where a symmetry makes them)."""
    here = model.replace(V=V)
    linear = modes(here, V)
    step = SPEED_STEP * V
    beside = [modes(model, V + sign * step).values for sign in (-1, 1)]
    changes = effect(*beside) != 0
    found = []
    for k in sorted(nearest(np.array(crossing), linear.values).tolist()):
        rates = (each[np.argmin(np.abs(each - linear.values[k]))].real for each in beside)
        before, after = map(float, rates)
        found.append(_point(here, linear, k, (after - before) / (2 * step), changes))
    return found


def _point(here: Model, linear: Modes, k: int, crossing: float, changes: bool) -> HopfPoint:
    n = here.n_blocks
    frequency = float(linear.values[k].imag)
    mode = linear.vectors[:, k] / linear.vectors[np.argmax(np.abs(linear.vectors[:n, k])), k]
    coefficient, size = _lyapunov(here, linear.matrix, mode, frequency)
    criticality: Literal["super", "sub"] | None = None
    if coefficient is not None and abs(coefficient) > DEGENERATE * size:
        criticality = "sub" if coefficient > 0 else "super"
    return HopfPoint(
        model=here,
        V=here.V,
        frequency=frequency,
        crossing=crossing,
        changes_stability=changes,
        lyapunov=coefficient,
        criticality=criticality,
        mode=mode[:n],
    )


def _lyapunov(
    model: Model, matrix: Floats, q: Complexes, frequency: float
) -> tuple[float | None, float]:
    """First Lyapunov coefficient of the amplitude equation, and the size of what makes it up."""
    # Kuznetsov, Elements of Applied Bifurcation Theory (2004), eq. (3.20); the amplitude is twice
    # the coordinate of an eigenvector whose largest displacement is 1.
    derivatives = force_derivatives(model, model.V)
    if derivatives is None:
        return None, 0.0
    plant, n = model.plant, model.n_blocks
    weight = plant.static / plant.mass

    def quadratic(a: Complexes, b: Complexes) -> Complexes:
        return np.concatenate([np.zeros(n), weight * derivatives[:, 1] * a[n:] * b[n:]])

    def cubic(a: Complexes, b: Complexes, c: Complexes) -> Complexes:
        return np.concatenate([np.zeros(n), -weight * derivatives[:, 2] * a[n:] * b[n:] * c[n:]])

    values, left = np.linalg.eig(matrix.T)
    p = left[:, np.argmin(np.abs(values - 1j * frequency))]
    p = p / (p @ q)
    bar: Complexes = np.conj(q)
    mean = np.linalg.solve(matrix, quadratic(q, bar)).astype(np.complex128)
    resonant = 2j * frequency * np.eye(2 * n) - matrix
    twice = np.linalg.solve(resonant, quadratic(q, q)).astype(np.complex128)
    parts = (cubic(q, q, bar), -2.0 * quadratic(q, mean), quadratic(bar, twice))
    terms = np.array([np.dot(p, part) for part in parts])
    return float(terms.sum().real) / 8.0, float(np.abs(terms).sum()) / 8.0
