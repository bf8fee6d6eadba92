"""Turning points: where the slope of a smooth map changes its sign, to adjacent floats."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

MAX_ROUNDS: Final = 80
ASIDE: Final = 1e-2  # of the bracket: first guess of how far the chord's zero may be off
SPREAD: Final = 0.25  # of the bracket: three points so far apart quarter it


def slope_zeros(slope: Callable[[Floats], Floats], ends: Floats, slopes: Floats) -> Floats:
    """Close in on one change of sign in each bracket; of adjacent floats, the smaller slope."""
    # Three points at once, the chord's zero and one on either side of it, make a bracket as narrow
    # as their distance. The chord's error is quadratic in the width, so the distance is squared
    # each time: from a cell of a table three or four calls suffice. Where the zero is not between
    # the outer points, the next three quarter the bracket.
    outer, ends, at = ends, ends.copy(), slopes.copy()
    rising = (at[0] < 0) | (at[1] > 0)
    aside = np.full(rising.shape, ASIDE)
    for _ in range(MAX_ROUNDS):
        width = ends[1] - ends[0]
        todo = np.flatnonzero(width > 2 * np.spacing(np.abs(ends).max(axis=0)))
        if not todo.size:
            break
        x = _trials(ends[:, todo], at[:, todo], aside[todo])
        _narrow(ends, at, todo, x, slope(x.ravel()).reshape(x.shape), rising)
        share = (ends[1] - ends[0])[todo] / width[todo]
        missed = share > 2 * np.minimum(aside[todo], SPREAD)
        aside[todo] = np.where(missed, 2 * SPREAD, np.minimum(aside[todo], ASIDE) ** 2)
    size = np.where(ends == outer, np.inf, np.abs(at))
    return np.where(size[0] <= size[1], ends[0], ends[1])


def _trials(ends: Floats, at: Floats, aside: Floats) -> Floats:
    """Three points in each bracket, shape (3, n)."""
    lower, upper = ends
    width = upper - lower
    with np.errstate(all="ignore"):
        centre = lower - at[0] * width / (at[1] - at[0])
    known = np.isfinite(centre) & (aside < SPREAD)
    centre = np.where(known, centre, 0.5 * (lower + upper))
    ulp = np.spacing(np.maximum(np.abs(lower), np.abs(upper)))
    reach = np.maximum(np.where(known, aside, SPREAD) * width, ulp)
    x = centre + reach * np.array([[-1.0], [0.0], [1.0]])
    return np.clip(x, np.nextafter(lower, upper), np.nextafter(upper, lower))


def _narrow(
    ends: Floats, at: Floats, k: np.ndarray, x: Floats, slopes: Floats, rising: np.ndarray
) -> None:
    """Move the ends of brackets to the points that lie on their sides of the zero."""
    for point, value in zip(x, slopes, strict=True):
        inside = (point > ends[0, k]) & (point < ends[1, k])
        side = np.where((value < 0) == rising[k], 0, 1)
        i, j = side[inside], k[inside]
        ends[i, j], at[i, j] = point[inside], value[inside]
