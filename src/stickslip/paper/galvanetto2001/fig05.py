"""Figure 5: event map of the Coulomb system, its attractors and unstable fixed points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from stickslip import examples
from stickslip.paper.galvanetto2001.printed import BRACKETS, EXACT, S4_POINT
from stickslip.paper.galvanetto2001.roots import fixed_point
from stickslip.plot.curve import Curve, trace
from stickslip.plot.event_map import draw_curve, mark_orbit
from stickslip.study.event_map import event_map

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

TITLE: Final = "Event map of the Coulomb system"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3


@dataclass(frozen=True)
class Data:
    """The map's graph, its marked orbits and their multipliers by name; S4 starts at point 1."""

    model: TwoBlock
    curve: Curve
    orbits: dict[str, NDArray[np.float64]]
    multipliers: dict[str, float]


def compute() -> Data:
    """Trace the map, solve for the three fixed points and the period-4 orbit."""
    model = examples.coulomb()
    f = event_map(model)
    orbits, multipliers = {}, {}
    for name, bracket in (*BRACKETS.items(), ("S4", S4_POINT)):
        power = f.power(4) if name == "S4" else f
        found = fixed_point(power, *bracket, noise=EXACT)
        orbits[name] = f.iterate(found.value, 3 if name == "S4" else 0)
        multipliers[name] = float(power.derivative(found.value))
    return Data(model, trace(f, f.domain), orbits, multipliers)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map; bold points mark attractors, squares unstable orbits, as in the paper."""
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    for name, points in data.orbits.items():
        mark_orbit(ax, points, stable=abs(data.multipliers[name]) < 1.0)
    _names(ax, data.orbits)


def _names(ax: Axes, orbits: dict[str, NDArray[np.float64]]) -> None:
    offsets = {"S1": (-4, -11), "U1": (6, -6), "U2": (7, 2)}
    for name, offset in offsets.items():
        d = orbits[name][0]
        text = f"${name[0]}_{name[1]}$"
        ax.annotate(text, (d, d), offset, textcoords="offset points")
    s4 = orbits["S4"]
    for number, d in enumerate(s4, start=1):
        image = s4[number % 4]
        ax.annotate(str(number), (d, image), (-2, 6), textcoords="offset points", ha="right")


def caption(data: Data) -> str:
    """Describe the picture with the multipliers."""
    p = data.model.parameters
    slopes = ", ".join(f"{name} {value:.4g}" for name, value in data.multipliers.items())
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}, "
        f"V = {p['V']:g} over its whole domain. Bold points: attractors S1 and S4 (points "
        f"numbered in their order); squares: unstable fixed points. Multipliers: {slopes}."
    )
