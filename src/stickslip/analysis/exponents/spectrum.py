"""Lyapunov spectra of maps of R^n, and the dimension that they stand for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.exponents._tangent_kernels import carry_frame
from stickslip.analysis.exponents.blocking import blocking_error, settled_period
from stickslip.analysis.maps.arguments import check_values, space_family, space_map, space_points
from stickslip.analysis.maps.protocol import lengths, measured, orbits
from stickslip.analysis.orbits.orbits_nd import multipliers_of
from stickslip.analysis.scales import BLOCK, FINE, ORBIT_NOISE
from stickslip.analysis.work import Work
from stickslip.checks import MOST_STEPS, shown, whole_number
from stickslip.checks import grid as grid_values
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.results.table import numbered
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import FamilyND, Floats, MapND, Modelled

ALIGNING: Final = 100  # last steps of a transient, in which the frame turns to where it belongs


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Result):
    """Lyapunov exponents of an orbit of a map of R^n, per step of the map.

    Attributes
    ----------
    values : ndarray of float, shape (n_exponents,)
        Descending; ``-inf`` for directions that the map forgets; NaN if the orbit left the domain,
        and for what is lost in rounding beside others that a step stretches 10^7 times.
    errors : ndarray of float, shape (n_exponents,)
        Standard errors (one standard deviation), correlations included; 0 on a cycle, whose
        exponents are those of its multipliers.
    dimension, dimension_error : float
        Kaplan and Yorke's, of the attractor that the orbit fills; and its standard error.
    n, transient : int
        Steps that were averaged, and dropped before.
    duration : float
        Mean time of a step, of return maps and stroboscopic maps; NaN of others (an event map
        knows of slips alone).
    """

    values: Floats
    errors: Floats
    dimension: float
    dimension_error: float
    n: int
    transient: int
    duration: float = np.nan
    _drawn: ClassVar = ("exponent", "value")
    _has_picture: ClassVar = False

    @property
    def per_time(self) -> Floats:
        """The values per unit of time."""
        return np.asarray(self.values / self.duration)

    def __repr__(self) -> str:
        """Values ± errors, the dimension."""
        pairs = zip(self.values, self.errors, strict=True)
        rows = [f"  {value: .10f} ± {error:.2g}" for value, error in pairs]
        dimension = f"dimension {self.dimension:.6g} ± {self.dimension_error:.2g}"
        return "\n".join([f"LyapunovSpectrum, n={self.n}, {dimension}", *rows])

    def _columns(self) -> dict[str, Any]:
        number = np.arange(len(self.values)) + 1
        return {"exponent": number, "value": self.values, "error": self.errors}


@waits
@suggests
def lyapunov_spectrum(
    f: MapND | Modelled[MapND],
    x0: ArrayLike,
    n: int = 10_000,
    *,
    transient: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> LyapunovSpectrum:
    """Estimate all Lyapunov exponents of the orbit that starts at a point.

    Parameters
    ----------
    f : map of R^n or model
    x0 : array_like of float, shape (n_dimensions,)
        Where the orbit starts.
    n : int
        Steps to average, after the transient.
    transient : int, optional
        Steps to drop first. By default a tenth of `n`, at least 1000.
    progress : callable, optional
        Called now and then with the share of the steps that is done, 0 to 1.

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    ValueError
        No map of R^n; a count that is too small; a point outside the domain.

    Notes
    -----
    A frame is carried along the orbit by exact Jacobians and made orthonormal after each step
    (Benettin et al., Meccanica 15, 9, 1980); errors come from blocking. An orbit that has settled
    on a cycle has the exponents log(abs(multiplier)) / period. Kaplan and Yorke's dimension is
    the number of directions whose volumes do not shrink, the last one counted in part.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Chain(static=(1.0, 1.1, 1.2), alpha=1.0, V=0.1, friction=ss.Coulomb(mu=0.22))
    >>> ss.lyapunov_spectrum(model, [0.1, 0.2], 1000).values.shape
    (2,)
    """
    found, work = space_map(f), Work(progress)
    n, skip = checked_steps_of_mean(n, transient)
    x = space_points(found, "x0", x0)
    if x.ndim != 1:
        raise ValueError(f"x0 = {shown(x0)} holds several points: one orbit has one spectrum.")
    return _spectrum(found, x, n, skip, work)[0]


def checked_steps_of_mean(n: int, transient: int | None) -> tuple[int, int]:
    """Return the steps of a mean and those dropped before it."""
    n = whole_number("n", n, 2, at_most=MOST_STEPS, what="steps of a mean")
    if transient is None:
        return n, max(1000, n // 10)
    return n, whole_number("transient", transient, 0, at_most=MOST_STEPS)


def largest_exponents(f: MapND, x: ArrayLike, n: int, skip: int) -> tuple[Floats, Floats]:
    """Return the largest exponent of the orbits from points (..., d), and the errors, (...)."""
    starts = space_points(f, "d", x)
    rows = starts.reshape(-1, f.dimension)
    shape = starts.shape[:-1]
    found = [_mean(_growth(f, row, n, skip, 1, Work())[0]) for row in rows]
    means, errors = np.array(found).reshape(-1, 2).T
    return means.reshape(shape), errors.reshape(shape)


def exponent_along(jacobians: Floats) -> tuple[float, float, int]:
    """Return the largest exponent along (n, d, d), its error, and the steps that were averaged."""
    n, d, _ = jacobians.shape
    growth = np.empty((n, 1))
    frame, image = np.full((1, d), 1.0 / np.sqrt(d)), np.empty((1, d))
    carry_frame(np.ascontiguousarray(jacobians), frame, image, growth)
    with np.errstate(divide="ignore"):
        logs = np.log(growth[n // 10 :])  # the first tenth turns the tangent
    mean, error = _mean(logs)
    return float(mean[0]), float(error[0]), len(logs)


def _growth(
    f: MapND, x: Floats, n: int, skip: int, k: int, work: Work
) -> tuple[Floats, Floats, float]:
    """Logarithms of growth in k directions, each step, (n, k); where the orbit ends; mean time."""
    d = f.dimension
    frame = np.linalg.qr(np.random.default_rng(0).normal(size=(d, d)))[0][:k].copy()
    aligning, tell = min(skip, ALIGNING), work.steps(skip + n)
    total = aligning + n
    image, growth = np.empty((k, d)), np.empty((total, k))
    unit = lengths(f)
    size = float(np.abs(x / unit).max())  # a cycle at 0 recurs within what the orbit has been
    for start in range(0, skip - aligning, BLOCK):
        steps = min(BLOCK, skip - aligning - start)
        x = orbits(f, x[None], steps)[0, -1]
        tell(steps)
    points, time = [], 0.0
    for start in range(0, total, BLOCK):
        orbit = orbits(f, x[None], min(BLOCK, total - start))[0]
        x = orbit[-1]
        points.append(orbit[:-1])
        if not np.isfinite(orbit).all():
            growth[:] = time = np.nan
            break
        values = f.evaluate(orbit[:-1])
        jacobians = np.ascontiguousarray(measured(values.derivative, unit))
        carry_frame(jacobians, frame, image, growth[start : start + BLOCK])
        lasting: Any = getattr(f, "period", np.nan)
        if getattr(f, "whole_duration", False):
            lasting = getattr(values, "duration", np.nan)
        time += len(jacobians) * float(np.mean(lasting))
        tell(len(jacobians))
    with np.errstate(divide="ignore"):
        logs = np.log(growth[aligning:])
        visited = np.concatenate(points)
        sizes = visited / unit
        period = settled_period(sizes, ORBIT_NOISE * max(size, float(np.abs(sizes).max())))
        if period:
            sizes = np.abs(multipliers_of(f.evaluate(visited[-period:]).derivative))[:k]
            sizes[np.isneginf(logs).any(axis=0)] = 0.0  # not the rounding of a product
            sizes[np.isnan(logs).any(axis=0)] = np.nan
            logs = np.broadcast_to(np.log(sizes) / period, (n, k))
    return logs, x, time / total


def _mean(logs: Floats) -> tuple[Floats, Floats]:
    """Exponents, means of logarithms (n, k), and their errors, shape (k,)."""
    mean = logs.mean(axis=0)
    errors = [
        blocking_error(column) if np.isfinite(value) else (np.nan if np.isnan(value) else 0.0)
        for value, column in zip(mean, logs.T, strict=True)
    ]
    return mean, np.array(errors)


def _spectrum(
    f: MapND, x: Floats, n: int, skip: int, work: Work
) -> tuple[LyapunovSpectrum, Floats]:
    """Return the spectrum of an orbit, and the point that it comes to."""
    logs, end, duration = _growth(f, x, n, skip, f.dimension, work)
    mean, errors = _mean(logs)
    dimension = kaplan_yorke(mean, logs)
    return LyapunovSpectrum(mean, errors, *dimension, n, skip, duration), end


def kaplan_yorke(values: Floats, logs: Floats) -> tuple[float, float]:
    """Kaplan and Yorke's dimension of descending exponents, means of logs (n, k); and its error."""
    if np.isnan(values).any():
        return np.nan, np.nan
    sums = np.cumsum(values)
    finite = int(np.isfinite(sums).sum())
    # A volume that shrinks by no more than its error does not shrink: that of a flow's direction.
    errors = [blocking_error(logs[:, : k + 1].sum(axis=1)) for k in range(finite)]
    # Exponents so small are rounding, of products over a cycle.
    full = int(np.count_nonzero(sums[:finite] >= -FINE - np.array(errors)))
    if full == len(values) or np.isneginf(values[full]):
        return float(full), 0.0
    part = (sums[full - 1] if full else 0.0) / -values[full]
    # To first order the error of S / |v| is that of the mean of (s + part v) / |v|.
    series = (logs[:, :full].sum(axis=1) + part * logs[:, full]) / -values[full]
    return float(full + part), (blocking_error(series) if full else 0.0)


# ------------------------------------------------------------------ along a parameter


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectra(Result):
    """Lyapunov exponents of a map of R^n over values of a parameter.

    Attributes
    ----------
    parameter : str
    at : ndarray of float, shape (m,)
        Its values.
    values, errors : ndarray of float, shape (m, n)
        As of `LyapunovSpectrum`; NaN from where the orbit leaves the domain.
    dimension, dimension_error : ndarray of float, shape (m,)
    n, transient : int
        Steps averaged and dropped at each value.
    """

    parameter: str
    at: Floats
    values: Floats
    errors: Floats
    dimension: Floats
    dimension_error: Floats
    n: int
    transient: int
    parameters: dict[str, float] = field(default_factory=dict)
    _plot: ClassVar = "exponents.draw_spectra"

    def _columns(self) -> dict[str, Any]:
        return {
            self.parameter: self.at,
            **numbered("value", self.values),
            **numbered("error", self.errors),
            "dimension": self.dimension,
            "dimension_error": self.dimension_error,
        }

    def _coordinates(self) -> tuple[str, ...]:
        return (self.parameter,)


@waits
@suggests
def lyapunov_spectra(
    system: FamilyND | Modelled[FamilyND],
    parameter: str,
    grid: ArrayLike,
    x0: ArrayLike,
    n: int = 2000,
    *,
    transient: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> LyapunovSpectra:
    """Estimate Lyapunov spectra along a parameter, each orbit from where the one before ended.

    Parameters
    ----------
    system : map of R^n with parameters, or model
    parameter : str
        Parameter that varies.
    grid : tuple of (float, float, int) or array_like of float
        ``(lo, hi, n)``, or the values in the order in which they are visited.
    x0 : array_like of float, shape (n_dimensions,)
        Start of the first orbit, and of those after one that left the domain.
    n, transient : int
        As of `lyapunov_spectrum`, at each value.
    progress : callable, optional
        Called now and then with the share of the work that is done, 0 to 1.

    Returns
    -------
    LyapunovSpectra

    Raises
    ------
    ValueError
        No map of R^n with parameters, an unknown parameter, a value, point or count not allowed.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    >>> spiral = ss.Map(lambda z, r: r * z @ turn, 2, parameters={"r": 0.5})
    >>> ss.lyapunov_spectra(spiral, "r", [0.25, 0.5], x0=[1.0, 1.0], n=100).values.round(6)  # log r
    array([[-1.386294, -1.386294],
           [-0.693147, -0.693147]])
    """
    family = space_family(system)
    n, skip = checked_steps_of_mean(n, transient)
    values = grid_values("grid", grid)
    check_values(family, parameter, (values.min(), values.max()), "grid")
    start = here = space_points(family, "x0", x0)
    found, work = [], Work(progress)
    for k, value in enumerate(values):
        f = family.replace(**{parameter: float(value)})
        part = work.part(k / len(values), (k + 1) / len(values))
        spectrum, here = _spectrum(f, here if f.contains(here) else start, n, skip, part)
        found.append(spectrum)
    columns = ("values", "errors", "dimension", "dimension_error")
    return LyapunovSpectra(
        parameter=parameter,
        at=values.copy(),
        **{name: np.array([getattr(each, name) for each in found]) for name in columns},
        n=n,
        transient=skip,
        parameters={key: v for key, v in family.parameters.items() if key != parameter},
    )
