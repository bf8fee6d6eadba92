"""Where a law falls with speed: a template, for the laws of any number of blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.mechanics.flow.pieces import piece_row
from stickslip.mechanics.flow.system import Floats
from stickslip.mechanics.friction.columns import NEXT_PIECE_COLUMN, PIECE_END_COLUMN
from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.mechanics.friction.stub import slope


@kernel
def falls_between(laws: Floats, block: int, low: float, high: float) -> bool:
    """Whether the law of a block falls at one of 33 speeds on some piece between two speeds."""
    row = piece_row(laws, block, low)
    while True:
        end = min(high, laws[row, PIECE_END_COLUMN])
        for k in range(33):
            if slope(laws[row], -1, low + (end - low) * k / 32.0) < 0.0:
                return True
        if end == high:
            return False
        low = end
        row = int(laws[row, NEXT_PIECE_COLUMN])
