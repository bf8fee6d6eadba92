"""Where the event map of the paper's Coulomb system is defined, over the speed of the belt."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

from stickslip import examples
from stickslip.mechanics.cycle.return_region import return_region

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.return_region import ReturnRegion

RANGE: Final = (0.0366, 0.5)  # from the paper's own speed on
VALUES: Final = 41
POINTS: Final = 301


@cache
def region() -> ReturnRegion:
    """Find the gaps of the event map, and the cycles that attract from them."""
    return return_region(examples.coulomb(), "V", RANGE, n_values=VALUES, n_points=POINTS)
