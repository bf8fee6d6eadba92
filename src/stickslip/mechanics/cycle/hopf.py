"""Belt speeds at which steady sliding loses or regains stability, and the cycles born there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from stickslip.checks import finite_number
from stickslip.mechanics.cycle.sliding import (
    Model,
    Modes,
    force_derivatives,
    modes,
    steady_displacements,
)
from stickslip.results.result import Result

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from stickslip.numerics.arrays import Complexes, Floats


N_SPEEDS: Final = 400
NEUTRAL: Final = 1e-12  # of the largest frequency: growth rates this small are rounding
SAME: Final = 1e-11  # relative: speeds that rounding tells apart
CRITICAL: Final = 1e-9  # of the largest frequency: growth rates of the pairs that cross
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
        Steady sliding is stable on one side and not on the other: no other mode grows there.
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
    found = crossings(lambda V: modes(model, V).values, np.geomspace(*speeds, N_SPEEDS))
    return tuple(point for V in found for point in _points(model, V))


def crossings(eigenvalues: Callable[[float], Complexes], grid: Floats) -> list[float]:
    """Parameter values at which a pair of sorted eigenvalues crosses the imaginary axis."""
    every = np.array([_growth_rates(eigenvalues(value)) for value in grid.tolist()])
    # Modes that are neutral everywhere stand between growing ones and others: a pair that crosses
    # would change places with them, and no sorted rate its sign.
    neutral = int((every == 0.0).sum(axis=1).min())

    def others(rates: Floats) -> Floats:
        return np.delete(rates, np.argsort(np.abs(rates), kind="stable")[:neutral])

    rates = np.array([others(row) for row in every])
    found: list[float] = []
    for j in range(rates.shape[1]):

        def rate(value: float, j: int = j) -> float:
            return float(others(eigenvalues(value).real)[j])

        for low, high in _brackets(rate, grid, rates[:, j]):
            found.append(float(brentq(rate, low, high, xtol=1e-300, rtol=1e-15)))
    # Both members of a pair cross at one value, and are two sorted rates.
    found.sort()
    return [
        value
        for k, value in enumerate(found)
        if k == 0 or value - found[k - 1] > SAME * abs(found[k - 1])
    ]


def coalescences(eigenvalues: Callable[[float], Complexes], grid: Floats) -> list[float]:
    """Parameter values at which undamped modes meet and part into one that grows, one that decays.

    There the square of the modes' difference changes its sign smoothly: flutter without damping.
    """

    def square(value: float) -> float:
        values = eigenvalues(value)
        upper = values[values.imag > 0]
        first, second = np.triu_indices(len(upper), 1)
        squares = (upper[first] - upper[second]) ** 2
        return float(squares[np.argmin(np.abs(squares))].real) if len(squares) else np.nan

    neutral = [_growth_rates(eigenvalues(value))[0] == 0.0 for value in grid.tolist()]
    ends = [(grid[k], grid[k + 1]) for k in np.flatnonzero(np.diff(neutral))]
    return [
        float(brentq(square, low, high, xtol=1e-300, rtol=1e-15))
        for low, high in ends
        if square(low) * square(high) < 0.0
    ]


def _growth_rates(values: Complexes) -> Floats:
    """Real parts, descending; exactly 0 where rounding explains the difference."""
    rates = values.real.copy()
    rates[np.abs(rates) <= NEUTRAL * np.abs(values).max()] = 0.0
    return rates


def rates_beside(mode: complex, beside: Sequence[Complexes]) -> list[float]:
    """Growth rates, at neighbouring values, of the mode that is nearest to one."""
    return [float(_growth_rates(each)[np.argmin(np.abs(each - mode))]) for each in beside]


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
            if sign * rate(float(lowest.x)) < 0:
                brackets += [(ends[0], float(lowest.x)), (float(lowest.x), ends[1])]
    return brackets


def _points(model: Model, V: float) -> list[HopfPoint]:
    """Every pair of modes that crosses at a speed (two, where a symmetry makes them)."""
    here = model.replace(V=V)
    linear = modes(here, V)
    size = np.abs(linear.values).max()
    critical = (np.abs(linear.values.real) <= CRITICAL * size) & (linear.values.imag > 0)
    step = SPEED_STEP * V
    beside = [modes(model, V + sign * step).values for sign in (-1, 1)]
    changes = bool(np.prod([_growth_rates(values)[0] for values in beside]) < 0)
    found = []
    for k in np.flatnonzero(critical):
        before, after = rates_beside(linear.values[k], beside)
        if before or after:  # it is not neutral there too
            found.append(_point(here, linear, int(k), (after - before) / (2 * step), changes))
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
