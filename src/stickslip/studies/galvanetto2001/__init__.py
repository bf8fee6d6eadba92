"""Galvanetto (2001), Some discontinuous bifurcations in a two-block stick-slip system."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from stickslip.studies.claim import Claim, Value

SOURCE: Final = "Galvanetto (2001)"
TITLE: Final = "Some discontinuous bifurcations in a two-block stick-slip system"


def values(figures: tuple[int, ...], claims: tuple[Claim, ...]) -> tuple[Value, ...]:
    """Compute all numbers that the paper prints beside some figures, whatever claims use them."""
    from stickslip.studies.galvanetto2001 import printed

    return printed.compute(figures)
