"""Figure 2: the cycles that attract from the gaps."""

from __future__ import annotations

from typing import Final

from matplotlib.figure import Figure

from stickslip.mechanics.cycle.return_region import ReturnRegion
from stickslip.plot.cycles import draw_cycle_curve
from stickslip.studies.fast_belt.claims import region

TITLE: Final = "Cycles that attract from the gaps"
COLUMNS: Final = "one"
HEIGHT: Final = 2.8

compute = region


def draw(data: ReturnRegion, figure: Figure) -> None:
    """Draw the periods of the cycles over the speed of the belt."""
    ax = figure.add_subplot()
    for curve in data.curves:
        draw_cycle_curve(curve, ax)


def caption(data: ReturnRegion) -> str:
    """Say where the cycles attract."""
    told = "; ".join(
        f"cycle {number + 1} from V = {data.attracting(number)[0][0]:.6f}"
        for number in range(len(data.curves))
    )
    return (
        "Periods of the cycles to which motions from the gaps tend, over the speed of the belt. "
        f"Solid: attracts. Without global stick attract {told}."
    )
