"""Means along orbits: the error that correlations leave, and whether an orbit has settled.

The error comes from blocking (Flyvbjerg and Petersen, J. Chem. Phys. 91, 461, 1989), as far as the
test of Jonsson (Phys. Rev. E 98, 043304, 2018) asks for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.scales import IN_A_ROW

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats

INDEPENDENT: Final = 0.99  # confidence of the test that blocks are no longer correlated
LONGEST_CYCLE: Final = 512  # settled orbits up to this period are averaged over whole periods


def settled_period(values: Floats, tolerance: float) -> int:
    """Smallest period of the last rounds of an orbit, (n, ...); 0 if there is none."""
    values = values.reshape(len(values), -1)
    longest = min(LONGEST_CYCLE, (len(values) - 1) // (IN_A_ROW + 1))
    last = values[::-1]
    near = np.flatnonzero((np.abs(last[1 : longest + 1] - last[0]) <= tolerance).all(axis=1)) + 1
    for period in near:
        head = last[: IN_A_ROW * period]
        if np.all(np.abs(last[period : period + len(head)] - head) <= tolerance):
            return int(period)
    return 0


def blocking_error(series: Floats) -> float:
    """Return the standard error of the mean of a correlated series, at most an eighth left out."""
    if len(series) < 2:
        return float(np.inf)
    # Short blocks, so many that their number is a power of two.
    block = 8 if len(series) >= 512 else 1
    levels = (len(series) // block).bit_length() - 1
    length = len(series) >> levels
    x = series[-(length << levels) :].reshape(-1, length).mean(axis=1)
    if levels == 0:
        return float(np.inf)
    variance, score = np.zeros(levels), np.zeros(levels)
    for level in range(levels):
        centred = x - x.mean()
        variance[level] = np.mean(centred**2)
        if variance[level] <= (1e-15 * np.max(np.abs(x), initial=0.0)) ** 2:
            if len(x) > 4:
                return 0.0  # blocks that cover whole periods: the mean is exact
            break  # a series of few values: two or four long blocks may agree by chance
        lag = np.sum(centred[1:] * centred[:-1]) / len(x)
        score[level] = len(x) * ((len(x) - 1) * variance[level] / len(x) ** 2 + lag) ** 2
        score[level] /= variance[level] ** 2
        x = 0.5 * (x[::2] + x[1::2])
    total = np.cumsum(score[::-1])[::-1]
    from scipy.special import chdtri  # not for maps without exponents

    limits = chdtri(np.arange(levels, 0, -1), 1.0 - INDEPENDENT)
    passed = np.flatnonzero(total < limits)
    # No level passes: correlations outlast the series. Four blocks then say least wrongly.
    level = int(passed[0]) if passed.size else max(levels - 2, 0)
    blocks = 2 ** (levels - level)
    return float(np.sqrt(variance[level] / (blocks - 1)))
