"""How steeply a law falls with speed: a template, for the laws of any number of blocks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stickslip.mechanics.flow.pieces import piece_row
from stickslip.mechanics.flow.system import Floats
from stickslip.mechanics.friction.columns import NEXT_PIECE_COLUMN, PIECE_END_COLUMN
from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.mechanics.friction.stub import slope


@kernel
def least_slope(laws: Floats, block: int, low: float, high: float) -> float:
    """Least slope of a block's law between two speeds, of 33 on each of its pieces."""
    row = piece_row(laws, block, low)
    least = math.inf
    while True:
        end = min(high, laws[row, PIECE_END_COLUMN])
        for k in range(33):
            least = min(least, slope(laws[row], -1, low + (end - low) * k / 32.0))
        if end == high:
            return least
        low = end
        row = int(laws[row, NEXT_PIECE_COLUMN])
