"""The figures of the paper, by number."""

from __future__ import annotations

from typing import Final

from stickslip.studies.galvanetto2001.figures import (
    coulomb_maps,
    diagrams,
    law9_maps,
    motions,
    system,
)

FIGURES: Final = (
    system.FIGURES | coulomb_maps.FIGURES | law9_maps.FIGURES | diagrams.FIGURES | motions.FIGURES
)
