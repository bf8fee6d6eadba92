"""Laws of several smooth pieces: which one applies, and when a slip leaves it.

A step stays on the pieces on which its blocks start, each continued beyond its ends, and ends
where a slip speed has left one. That counts from `OVERLAP` beyond the end, so that a step never
starts on its own end and a speed that only touches a knot stays where it is. What this changes
in the force is below rounding: laws are continuous there.
"""

from __future__ import annotations

import math

from stickslip.mechanics.flow.system import Floats
from stickslip.mechanics.friction.columns import NEXT_PIECE_COLUMN, PIECE_END_COLUMN
from stickslip.numerics.polynomial import NO_ROOT, first_contact
from stickslip.numerics.targets import kernel

# Of 1 + the speed of a knot: well above the rounding of a speed, well below what a law feels.
OVERLAP = 1e-12


@kernel(inline=True)
def piece_row(laws: Floats, block: int, s: float) -> int:
    """Row of the piece on which the law of a block is at the speed `s`."""
    row = block
    while s > laws[row, PIECE_END_COLUMN]:
        row = int(laws[row, NEXT_PIECE_COLUMN])
    return row


@kernel
def leaving_time(laws: Floats, block: int, speed: Floats, h: float) -> float:
    """Time at which a slip speed, a series, leaves its piece, at most `h`; <= 0 if that failed."""
    start = speed[0]
    low = 0.0
    row = block
    while start > laws[row, PIECE_END_COLUMN]:
        low = laws[row, PIECE_END_COLUMN]
        row = int(laws[row, NEXT_PIECE_COLUMN])
    high = laws[row, PIECE_END_COLUMN]
    if low > 0.0:
        speed[0] = start - low + OVERLAP * (1.0 + low)
        t = first_contact(speed, h, False, 0.0)
        h = h if t == NO_ROOT else t
        speed[0] = start
    if high < math.inf and h > 0.0:
        for k in range(speed.shape[0]):
            speed[k] = -speed[k]
        speed[0] = high - start + OVERLAP * (1.0 + high)
        t = first_contact(speed, h, False, 0.0)
        h = h if t == NO_ROOT else t
    return h
