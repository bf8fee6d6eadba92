"""Figure 1: where the event map is undefined."""

from __future__ import annotations

from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.cycle.return_region import ReturnRegion
from stickslip.plot.cycles import plot_return_region
from stickslip.studies.fast_belt.claims import RANGE, region

TITLE: Final = "Where the event map is undefined"
COLUMNS: Final = "one"
HEIGHT: Final = 2.8

compute = region


def draw(data: ReturnRegion, figure: Figure) -> None:
    """Shade the gaps in the plane of d and V."""
    plot_return_region(data, figure.add_subplot())


def caption(data: ReturnRegion) -> str:
    """Describe the picture with its parameters."""
    p = examples.coulomb().parameters
    return (
        f"Values of d from which the blocks never stick together again, alpha = {p['alpha']:g}, "
        f"beta = {p['beta']:g}, mu = {p['mu']:g}, at {len(data.values)} speeds of the belt "
        f"from {RANGE[0]:g} to {RANGE[1]:g}."
    )
