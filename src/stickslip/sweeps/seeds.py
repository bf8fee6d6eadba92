"""Starting points of orbits: a function of seed and place in the grid alone.

So a point starts alike whatever chunk it lies in and whoever computes it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.analysis.maps.protocol import mix_labels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

BITS = 53  # of a random number


def spread_starts(
    seed: int, index: NDArray[np.uint64], count: int, low: Floats, high: Floats
) -> Floats:
    """Draw starting points, shape (n, count): one in each of `count` equal cells of the domain."""
    # `index` is the place of each grid point in the whole grid: chunks do not change what is drawn.
    cell = np.arange(count, dtype=np.float64)
    share = _share(_numbers(seed, index, count))
    width = (high - low)[:, None]
    drawn: Floats = low[:, None] + width * ((cell + share) / count)
    return drawn


def spread_shares(seed: int, index: NDArray[np.uint64], count: int, dimension: int) -> Floats:
    """Draw points of the unit cube at random, shape (n, count, dimension); as `spread_starts`."""
    axis = np.arange(dimension, dtype=np.uint64)
    return _share(mix_labels(_numbers(seed, index, count)[:, :, None], axis))


def _numbers(seed: int, index: NDArray[np.uint64], count: int) -> NDArray[np.uint64]:
    """Mix seed and place into `count` random numbers of 64 bits for each place."""
    start = np.full(index.shape, seed, dtype=np.uint64)
    cell = np.arange(count, dtype=np.uint64)
    return mix_labels(mix_labels(start, index)[:, None], cell[None, :])


def _share(numbers: NDArray[np.uint64]) -> Floats:
    shares: Floats = (numbers >> np.uint64(64 - BITS)).astype(np.float64) * 2.0**-BITS
    return shares
