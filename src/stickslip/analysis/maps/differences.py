"""Derivatives of functions known by their values alone: complex step, else extrapolation."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.scales import HALF_DIGITS, ORBIT_NOISE
from stickslip.numerics.arrays import EPS, GOLDEN

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Bools, Floats

    Usable: TypeAlias = Callable[[Floats, Floats], Bools] | None

COMPLEX_STEP: Final = 1e-30  # small enough that its square is nothing beside any real part
STEEP: Final = 1 / HALF_DIGITS  # slope that may be infinite: a float beside a root has hardly more
FIRST_STEP: Final = 1 / 64  # of the scale
# Of a step, the next one. Over jumps of a sawtooth, n of them and m, steps of the ratio m / n agree
# on a wrong slope: the square of the golden ratio is far from all such fractions.
SHORTER: Final = 1.0 - GOLDEN
SIGNIFICANT: Final = 8  # bits of a step: a point and its neighbours differ by just the step
N_STEPS: Final = 2 + int(math.log(ORBIT_NOISE / FIRST_STEP, SHORTER))  # of steps, down to that
APPROACH: Final = 0.7  # sides differ by f'' h: smaller with the step
NOISE: Final = 32.0  # roundings of the value in a difference that may be noise
ORDER: Final = 4  # columns of the extrapolation table
PARAMETER_STEP: Final = 1e-2  # of a parameter's scale: first step of differences in it
LIKE: Final = 1e-3  # of differences: a slope that was given may be this far from all of them


def complex_step(func: Callable[[NDArray[np.complex128]], Any], x: Floats) -> Floats:
    """Differentiate an analytic function to rounding, Im f(x + ih) / h; nonsense for ``abs``."""
    slope = _imaginary_rise(func, x, COMPLEX_STEP)
    steep = np.abs(slope) > STEEP
    if steep.any():  # at a root itself the step takes the place of a distance
        shorter = _imaginary_rise(func, x[steep], COMPLEX_STEP**2)
        grows = np.abs(shorter) > 2 * np.abs(slope[steep])
        slope[steep] = np.where(grows, np.copysign(np.inf, shorter), slope[steep])
    return slope


def _imaginary_rise(func: Callable[[NDArray[np.complex128]], Any], x: Floats, h: float) -> Floats:
    shifted = np.asarray(x, dtype=np.complex128) + 1j * h
    slope: Floats = np.imag(func(shifted)) / h
    # A constant may come back as one number.
    return np.broadcast_to(slope, shifted.shape).copy()


def extrapolated_difference(
    func: Callable[[Floats], Floats],
    x: Floats,
    scale: float,
    usable: Usable = None,
    n_steps: int = N_STEPS,
) -> tuple[Floats, Floats]:
    """Return slopes and errors by Ridders' method: differences at shrinking steps, extrapolated."""
    # Differences are one-sided where one neighbour is usable. Steps across an unmarked jump lose
    # by themselves.
    h, centre, (ahead, behind, central) = _rises(func, x, scale, usable, n_steps)
    central = np.where(_sides_meet(ahead, behind, centre, h), central, np.nan)
    candidates = [(central, 2), (ahead, 1), (behind, 1)]
    rounding = EPS * np.abs(centre) / h
    slope, error = np.full(x.shape, np.nan), np.full(x.shape, np.inf)
    for column, power in candidates:
        found, doubt = _best_entry(column, h**power, rounding)
        better = share_unknown(found, doubt) < share_unknown(slope, error)
        slope, error = np.where(better, found, slope), np.where(better, doubt, error)
    return slope, error


def unlike(
    func: Callable[[Floats], Floats], x: Floats, scale: float, slope: Floats, usable: Usable = None
) -> Bools:
    """Tell where a slope that was given is not that of the values: no difference comes near."""
    differences = np.concatenate(_rises(func, x, scale, usable, N_STEPS)[2])
    known = np.isfinite(differences).any(axis=0)
    return np.asarray(known & ~are_near(slope, differences).any(axis=0))


def are_near(slope: Floats, differences: Floats) -> Bools:
    """Tell where differences are those of a slope that was given."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(differences - slope) <= LIKE * (1 + np.abs(differences)))


def parameter_difference(func: Callable[[Floats], Floats], now: float, n: int) -> Floats:
    """Differentiate n values by a parameter of scale 1, or of its size where that is sharper."""
    start, step = np.full(n, now), PARAMETER_STEP / FIRST_STEP
    slope, error = extrapolated_difference(func, start, step * max(abs(now), 1.0))
    rough = ~(error <= HALF_DIGITS * np.abs(slope))
    smallest = np.finfo(np.float64).tiny / EPS  # of smaller ones steps are 0
    if smallest < abs(now) < 1 and rough.any():
        finer, doubt = extrapolated_difference(func, start, step * abs(now))
        sharp = rough & (doubt <= HALF_DIGITS * np.abs(finer))
        slope, error = np.where(sharp, finer, slope), np.where(sharp, doubt, error)
    # Close to a root-like break that moves, slopes are so large that short steps leave digits.
    if (share_unknown(slope, error) > HALF_DIGITS).any():
        closer, doubt = extrapolated_difference(
            func, start, HALF_DIGITS * step * max(abs(now), 1.0)
        )
        better = share_unknown(closer, doubt) < share_unknown(slope, error)
        slope = np.where(better, closer, slope)
    return slope


def share_unknown(slope: Floats, error: Floats) -> Floats:
    """Return how little of slopes is known: what differences of any size are chosen by."""
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(error / (1 + np.abs(slope)), nan=np.inf)


def unlike_parameter(func: Callable[[Floats], Floats], now: float, slope: Floats) -> Bools:
    """Tell where a slope in a parameter is not that of the values, in steps of 1 or of its size."""
    start, step = np.full(slope.shape, now), PARAMETER_STEP / FIRST_STEP
    wrong = [unlike(func, start, step * scale, slope) for scale in (1.0, abs(now) or 1.0)]
    return wrong[0] & wrong[1]


def extrapolated_second_difference(
    func: Callable[[Floats], Floats], x: Floats, scale: float, usable: Usable, n_steps: int
) -> tuple[Floats, Floats]:
    """Differentiate twice, as `extrapolated_difference` once; both neighbours must be usable."""
    h, centre, forward, backward = _neighbours(func, x, scale, usable, n_steps)
    second = (forward - 2 * centre + backward) / h**2
    rounding = 4 * EPS * np.abs(centre) / h**2
    return _best_entry(second, h**2, rounding, lambda found, doubt: doubt)  # it has a unit


def _rises(
    func: Callable[[Floats], Floats], x: Floats, scale: float, usable: Usable, n_steps: int
) -> tuple[Floats, Floats, tuple[Floats, Floats, Floats]]:
    """Return steps, values at x, and differences ahead, behind and across."""
    h, centre, forward, backward = _neighbours(func, x, scale, usable, n_steps)
    across = (forward - backward) / (2 * h)
    return h, centre, ((forward - centre) / h, (centre - backward) / h, across)


def _neighbours(
    func: Callable[[Floats], Floats], x: Floats, scale: float, usable: Usable, n_steps: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return steps, (k, 1), values at x, and so far above and below, (k, n); NaN if not usable."""
    # ``usable(x, points)`` tells which points lie on the branch of x.
    size, exponent = np.frexp(scale * FIRST_STEP * SHORTER ** np.arange(n_steps))
    steps: Floats = np.ldexp(np.rint(np.ldexp(size, SIGNIFICANT)), exponent - SIGNIFICANT)
    points = np.stack([x + sign * h for h in steps for sign in (1.0, -1.0)])
    values = func(points.ravel())
    good = np.isfinite(values) & (points != x).ravel()  # a step may be less than rounding
    if usable is not None:
        good &= usable(np.broadcast_to(x, points.shape).ravel(), points.ravel())
    values = np.where(good, values, np.nan).reshape(points.shape)
    return steps[:, None], func(x), values[0::2], values[1::2]


def _sides_meet(ahead: Floats, behind: Floats, centre: Floats, h: Floats) -> Bools:
    """Tell where the slopes to either side approach each other: a symmetric cusp has slopes ±s."""
    with np.errstate(invalid="ignore"):
        split = np.abs(ahead - behind)
        noise = NOISE * EPS * np.abs(centre) / h
        approach = split[1:] <= APPROACH * split[:-1]
    last = np.zeros((1, *split.shape[1:]), dtype=bool)
    return np.concatenate([approach, last]) | (split <= noise)


def _best_entry(
    column: Floats,
    size: Floats,
    rounding: Floats,
    unknown: Callable[[Floats, Floats], Floats] = share_unknown,
) -> tuple[Floats, Floats]:
    """Extrapolate a column whose error is a series in ``size``; pick by agreement past rounding."""
    best = np.full(column.shape[1:], np.nan)
    error = np.full(column.shape[1:], np.inf)
    # Central differences err in even powers of h only, one-sided ones in all.
    for order in range(ORDER):
        factor = size[: -order - 1] / size[order + 1 :]
        finer = (factor * column[1:] - column[:-1]) / (factor - 1)
        rounding = rounding[1:]
        doubt = np.abs(finer - column[1:]) + np.abs(finer - column[:-1]) + rounding
        doubt = np.where(np.isnan(doubt), np.inf, doubt)
        # Steps as short as rounding agree on next to nothing where slopes are large.
        row = np.argmin(unknown(finer, doubt), axis=0)
        found, least = (np.take_along_axis(a, row[None], axis=0)[0] for a in (finer, doubt))
        better = unknown(found, least) < unknown(best, error)
        best, error = np.where(better, found, best), np.where(better, least, error)
        column = finer
    return best, error
