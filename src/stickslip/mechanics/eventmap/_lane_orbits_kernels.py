"""Orbits of many starts: each step by lanes, and by the exact engine where these pass.

A template: the exact engine's `carry` is bound to the name imported for the type checker.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap._lane_kernels import Indices, carry_lanes
from stickslip.mechanics.eventmap._lane_passes_kernels import BLOCK
from stickslip.mechanics.eventmap.records import Controls, Scratch
from stickslip.mechanics.flow.system import Floats, System
from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._kernels import carry


@kernel
def iterate_lanes(
    row: Floats,
    streams: Floats,
    index: Indices,
    column: Floats,
    no_slope: Floats,
    orbits: NDArray[np.float64],
    start: int,
    stop: int,
    system: System,
    laws: NDArray[np.float64],
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> None:
    """Fill rows ``start..stop`` of `orbits` (starts, n + 1) from their first entries on."""
    for at in range(start, stop, BLOCK):
        n = min(BLOCK, stop - at)
        for k in range(orbits.shape[1] - 1):
            for i in range(n):
                column[i] = orbits[at + i, k]
            carry_lanes(row, streams, index, column, no_slope, 0, n, controls.max_events)
            for i in range(n):
                d, value = orbits[at + i, k], column[i]
                if math.isnan(d) or math.isinf(value):
                    value = math.nan
                elif math.isnan(value):
                    value, _, _, _, _, _ = carry(system, laws, d, scratch, controls, itinerary)
                orbits[at + i, k + 1] = value
