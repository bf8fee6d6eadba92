"""Derivatives of functions known by their values alone: complex step, else extrapolation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from numpy.typing import NDArray

    from stickslip.analysis.protocol import Floats

__all__ = ["complex_step", "extrapolated_difference"]

COMPLEX_STEP: Final = 1e-30  # small enough that its square is nothing beside any real part
FIRST_STEP: Final = 1 / 64  # of the scale
N_STEPS: Final = 18  # halvings: down to 1e-7 of the scale
ORDER: Final = 4  # columns of the extrapolation table


def complex_step(func: Callable[[NDArray[np.complex128]], Any], x: Floats) -> Floats:
    """Differentiate an analytic function to rounding: Im f(x + ih) / h.

    Parameters
    ----------
    func : callable
        Takes an array, complex here, and returns one of the same shape.
    x : ndarray of float

    Returns
    -------
    ndarray of float
        Nonsense where ``func`` is not analytic (``abs``, say): compare before use.
    """
    shifted = np.asarray(x, dtype=np.complex128) + 1j * COMPLEX_STEP
    slope: Floats = np.imag(func(shifted)) / COMPLEX_STEP
    return slope


def extrapolated_difference(
    func: Callable[[Floats], Floats],
    x: Floats,
    scale: float,
    usable: Callable[[Floats, Floats], NDArray[np.bool_]] | None = None,
) -> tuple[Floats, Floats]:
    """Differentiate by Ridders' method: differences at halved steps, extrapolated to zero.

    Parameters
    ----------
    func : callable
        Takes and returns arrays of one shape; NaN where undefined.
    x : ndarray of float, shape (n,)
    scale : float
        Length over which ``func`` may vary; the first step is 1/64 of it.
    usable : callable, optional
        ``usable(x, points)`` tells, as bools, which points lie on the branch of ``x``.

    Returns
    -------
    slope : ndarray of float, shape (n,)
        NaN where no step stays on the branch.
    error : ndarray of float, shape (n,)
        Estimated from the extrapolation table.

    Notes
    -----
    Central differences where both neighbours are on the branch, one-sided ones elsewhere;
    the entry whose neighbours in the table agree best wins, so steps that reach across an
    unmarked jump lose by themselves.
    """
    steps = scale * FIRST_STEP * 0.5 ** np.arange(N_STEPS)
    points = np.stack([x + sign * h for h in steps for sign in (1.0, -1.0)])
    here = np.broadcast_to(x, points.shape)
    values = func(points.ravel()).reshape(points.shape)
    good = np.isfinite(values)
    if usable is not None:
        good &= usable(here.ravel(), points.ravel()).reshape(points.shape)
    values = np.where(good, values, np.nan)
    forward, backward, centre = values[0::2], values[1::2], func(x)
    h = steps[:, None]
    candidates = [
        ((forward - backward) / (2 * h), 2),
        ((forward - centre) / h, 1),
        ((centre - backward) / h, 1),
    ]
    slope, error = np.full(x.shape, np.nan), np.full(x.shape, np.inf)
    for column, power in candidates:
        found, doubt = _best_entry(column, power)
        better = doubt < error
        slope, error = np.where(better, found, slope), np.where(better, doubt, error)
    return slope, error


def _best_entry(column: Floats, power: int) -> tuple[Floats, Floats]:
    """Extrapolate a column of differences whose error starts at h**power; pick by agreement."""
    best = np.full(column.shape[1:], np.nan)
    error = np.full(column.shape[1:], np.inf)
    # Central differences err in even powers of h only, one-sided ones in all.
    for order in range(ORDER):
        factor = 2.0 ** (power * (order + 1))
        finer = (factor * column[1:] - column[:-1]) / (factor - 1)
        doubt = np.abs(finer - column[1:]) + np.abs(finer - column[:-1])
        doubt = np.where(np.isnan(doubt), np.inf, doubt)
        row = np.argmin(doubt, axis=0)
        found, least = (np.take_along_axis(a, row[None], axis=0)[0] for a in (finer, doubt))
        better = least < error
        best, error = np.where(better, found, best), np.where(better, least, error)
        column = finer
    return best, error
