"""Preimages: every point that a map carries to a given value."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.table import RESOLUTION, branch_table
from stickslip.checks import finite_number

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats, Map1D

SAME: Final = 8 * float(np.finfo(np.float64).eps)  # of the scale: points that coincide


def preimages(f: Map1D, x: float, *, resolution: float = RESOLUTION) -> Floats:
    """Return all y with f(y) = x, ascending, one per lap whose closed image contains x.

    At a jump the one-sided limits count as values; of a lap where f is x throughout, both ends.

    >>> import stickslip as ss
    >>> tent = ss.PiecewiseMap(lambda x: 1 - abs(2 * x - 1), (0, 1), breakpoints=[0.5])
    >>> tent.preimages(0.5)
    array([0.25, 0.75])
    """
    value = finite_number("x", x, why="It is the value whose preimages are sought.")
    laps = branch_table(f, resolution).laps
    slack = SAME * max(abs(end) for end in f.domain)
    reached = np.flatnonzero((laps.value_min <= value + slack) & (laps.value_max >= value - slack))
    flat = laps.direction[reached] == 0
    points = np.concatenate(
        [
            laps.inverse(reached[~flat], np.full(np.count_nonzero(~flat), value)),
            laps.left[reached[flat]],
            laps.right[reached[flat]],
        ]
    )
    points.sort()
    apart = np.ones(len(points), dtype=bool)
    apart[1:] = np.diff(points) > slack
    return points[apart]
