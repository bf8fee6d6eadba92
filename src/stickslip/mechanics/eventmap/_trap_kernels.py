"""Compiled search for a part of the plane that turns into itself; see `traps`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from stickslip.numerics.arrays import Floats


@kernel
def cut_down(
    first: Floats,
    second: Floats,
    sector: NDArray[np.int64],
    share: float,
    most: float,
    settled: float,
    cuts: int,
    whole: Floats,
    reach: Floats,
    room: Floats,
) -> bool:
    """Cut a polygon down to what turns into that share of itself; tell whether it settled.

    `first`, `second`, `sector` (places, corners): the gauge of the images of places along the ray
    of each corner, at equal shares of the `whole` (corners,). `reach` (corners,) begins as that. No
    corner reaches farther than `most` times its neighbours. `room` (2, corners) is for the work.
    """
    n_places, n = first.shape
    near, new = room[0], room[1]
    for _ in range(cuts):
        for i in range(n):
            near[i] = 1.0 / reach[i]
        for i in range(n):
            before, at = 0.0, float(n_places)
            for k in range(n_places):
                j = sector[k, i]
                excess = first[k, i] * near[j] + second[k, i] * near[(j + 1) % n] - share
                if not excess <= 0.0:
                    if k < 2:
                        return False
                    rise = excess - before
                    at = k - (before / rise if rise > 0.0 else 0.0)
                    break
                before = excess
            new[i] = min(at / n_places * whole[i], reach[i])
        for step in (1, -1):  # edges steeper than the rays between them would cut corners
            for i in range(n):
                near[i] = most * new[(i + step) % n]
            for i in range(n):
                new[i] = min(new[i], near[i])
        moved = 0.0
        for i in range(n):
            moved = max(moved, 1.0 - new[i] / reach[i])
            reach[i] = new[i]
        if moved < settled:
            return True
    return False
