"""Where the event map is undefined, and the cycles that attract from there."""

from __future__ import annotations

from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.cycle.return_region import ReturnRegion
from stickslip.plot.cycles import draw_cycle_curve, plot_return_region
from stickslip.studies.fast_belt.claims import RANGE, region
from stickslip.studies.figures import PaperFigure


# Figure 1: where the event map is undefined.
def draw_gaps(data: ReturnRegion, figure: Figure) -> None:
    """Shade the gaps in the plane of d and V."""
    plot_return_region(data, figure.add_subplot())


def describe_gaps(data: ReturnRegion) -> str:
    """Describe the picture with its parameters."""
    p = examples.coulomb().parameters
    return (
        f"Values of d from which the blocks never stick together again, alpha = {p['alpha']:g}, "
        f"beta = {p['beta']:g}, mu = {p['mu']:g}, at {len(data.values)} speeds of the belt "
        f"from {RANGE[0]:g} to {RANGE[1]:g}."
    )


# Figure 2: the cycles that attract from the gaps.
def draw_cycles(data: ReturnRegion, figure: Figure) -> None:
    """Draw the periods of the cycles over the speed of the belt."""
    ax = figure.add_subplot()
    for curve in data.curves:
        draw_cycle_curve(curve, ax)


def describe_cycles(data: ReturnRegion) -> str:
    """Say where the cycles attract."""
    told = "; ".join(
        f"cycle {number + 1} from V = {data.attracting(number)[0][0]:.6f}"
        for number in range(len(data.curves))
    )
    return (
        "Periods of the cycles to which motions from the gaps tend, over the speed of the belt. "
        f"Solid: attracts. Without global stick attract {told}."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.8, region, draw_gaps, describe_gaps),
    2: PaperFigure("one", 2.8, region, draw_cycles, describe_cycles),
}
