"""Where the event map is undefined, and the cycles that attract from there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from stickslip import examples
from stickslip.plot.cycles import draw_cycle_curve, plot_return_region
from stickslip.studies.fast_belt.claims import RANGE, region
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_gaps(figure: Figure) -> str:
    """Shade the gaps of the event map in the plane of d and V."""
    plot_return_region(region(), figure.add_subplot())
    p = examples.coulomb().parameters
    return (
        f"Values of d from which the blocks never stick together again, alpha = {p['alpha']:g}, "
        f"beta = {p['beta']:g}, mu = {p['mu']:g}, at {len(region().values)} speeds of the belt "
        f"from {RANGE[0]:g} to {RANGE[1]:g}."
    )


def draw_cycles(figure: Figure) -> str:
    """Draw the periods of the cycles that attract from the gaps over the speed of the belt."""
    ax, data = figure.add_subplot(), region()
    for curve in data.curves:
        draw_cycle_curve(curve, ax)
    told = "; ".join(
        f"cycle {number + 1} from V = {data.attracting(number)[0][0]:.6f}"
        for number in range(len(data.curves))
    )
    return (
        "Periods of the cycles to which motions from the gaps tend, over the speed of the belt. "
        f"Solid: attracts. Without global stick attract {told}."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.8, draw_gaps),
    2: PaperFigure("one", 2.8, draw_cycles),
}
