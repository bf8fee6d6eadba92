"""Figure 1: the event map as the belt slows down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.eventmap.quasistatic_map import quasistatic_map
from stickslip.plot.maps import Curve, draw_curve, trace
from stickslip.plot.style import PALETTE

TITLE: Final = "The event map as the belt slows down"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3
SPEEDS: Final = (0.2, 0.05)


@dataclass(frozen=True)
class Data:
    """Graphs of the limit and of the maps at `SPEEDS`."""

    domain: tuple[float, float]
    limit: Curve
    moving: tuple[Curve, ...]


def compute() -> Data:
    """Trace the limit and two maps on the way to it."""
    model = examples.coulomb()
    curves = [trace(event_map(model.replace(V=V)), model.domain) for V in SPEEDS]
    return Data(model.domain, trace(quasistatic_map(model), model.domain), tuple(curves))


def draw(data: Data, figure: Figure) -> None:
    """Draw the limit over the others."""
    ax = figure.add_subplot()
    draw_curve(data.limit, ax, window=data.domain)
    colours = (PALETTE["sky"], PALETTE["vermillion"])
    for V, curve, colour in zip(SPEEDS, data.moving, colours, strict=True):
        ax.plot(curve.x, curve.y, color=colour, lw=0.7, zorder=1, label=f"$V={V:g}$")
    ax.plot([], [], color=PALETTE["black"], label=r"$V\to0$")
    ax.legend(loc="lower left")


def caption(data: Data) -> str:
    """Describe the picture."""
    p = examples.coulomb().parameters
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g} at "
        f"V = {SPEEDS[0]:g} and {SPEEDS[1]:g}, and its limit V -> 0. Where one block slips "
        "alone the limit is d plus or minus a constant: lines of slope 1."
    )
