"""Figure 5: event map of the Coulomb system, its attractors and unstable fixed points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.studies.galvanetto2001.orbits import coulomb_orbits, from_point_1, jump_of_s4

TITLE: Final = "Event map of the Coulomb system"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3


@dataclass(frozen=True)
class Data:
    """The map's graph, its orbits up to period 4 by name, and the jump next to S4's point 1."""

    model: TwoBlock
    curve: Curve
    orbits: dict[str, PeriodicOrbit]
    jump: float


def compute() -> Data:
    """Trace the map and find all its orbits up to period 4: the paper marks them all."""
    model = examples.coulomb()
    f = event_map(model)
    return Data(model, trace(f, f.domain), coulomb_orbits(f), jump_of_s4(f).d)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map; bold points mark attractors, squares unstable orbits, as in the paper."""
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    for orbit in data.orbits.values():
        mark_orbit(ax, orbit.points, stable=orbit.stable)
    _names(ax, data)


def _names(ax: Axes, data: Data) -> None:
    offsets = {"S1": (-4, -11), "U1": (6, -6), "U2": (7, 2)}
    for name, offset in offsets.items():
        d = data.orbits[name].points[0]
        text = f"${name[0]}_{name[1]}$"
        ax.annotate(text, (d, d), offset, textcoords="offset points")
    s4 = from_point_1(data.orbits["S4"], data.jump)
    for number, d in enumerate(s4, start=1):
        image = s4[number % 4]
        ax.annotate(str(number), (d, image), (-2, 6), textcoords="offset points", ha="right")


def caption(data: Data) -> str:
    """Describe the picture with the multipliers."""
    p = data.model.parameters
    slopes = ", ".join(f"{name} {item.multiplier:.4g}" for name, item in data.orbits.items())
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}, "
        f"V = {p['V']:g} over its whole domain. Bold points: attractors S1 and S4 (points "
        f"numbered in their order); squares: unstable fixed points. There are no other "
        f"orbits up to period 4, save infinitely unstable ones. Multipliers: {slopes}."
    )
