"""Figure 6: event map of the Coulomb system for V = 0.0370 and its attractor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.studies.galvanetto2001.orbits import attracting_orbits

TITLE: Final = "Event map of the Coulomb system, V = 0.0370"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3


@dataclass(frozen=True)
class Data:
    """The map's graph and its attractors: the one that follows S4, and S1."""

    model: TwoBlock
    curve: Curve
    attractor: PeriodicOrbit
    s1: PeriodicOrbit


def compute() -> Data:
    """Trace the map and find its attractors."""
    model = examples.coulomb(V=0.0370)
    f = event_map(model)
    after, s1 = attracting_orbits(f)
    return Data(model, trace(f, f.domain), after, s1)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map; bold points mark the attractor, as in the paper."""
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    mark_orbit(ax, data.s1.points)
    mark_orbit(ax, data.attractor.points, ms=2.6)


def caption(data: Data) -> str:
    """Describe the picture; say what the attractor is."""
    p = data.model.parameters
    orbit = data.attractor
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}, "
        f"V = {p['V']:.4f}. Small points: the attractor that follows S4 after its collision with "
        f"the jump, periodic with period {orbit.period} in global stick phases and "
        f"multiplier {orbit.multiplier:.4g}; the paper calls it non-periodic. Large point: S1."
    )
