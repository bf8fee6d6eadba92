"""Cyclic linear equations, as periodic orbits have them: each unknown beside its successor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats


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
    """Solve s_i y_i - y_(i+1) = b_i, cyclic in each row, for many rows of their own lengths.

    Forwards where the product of the slopes is within [-1, 1], backwards elsewhere: the solution is
    never divided by what should be large. Not finite where the product is 1.
    """
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
