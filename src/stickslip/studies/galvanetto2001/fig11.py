"""Figure 11: bifurcation diagram of the system with friction law (9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.diagrams.diagram import Diagram, OrbitCurve
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.bifurcations import STABLE
from stickslip.plot.diagram import draw_attractors, draw_diagram
from stickslip.studies.galvanetto2001.orbits import WINDOW

TITLE: Final = "Bifurcation diagram with friction law (9)"
COLUMNS: Final = "two"
HEIGHT: Final = 4.0

RANGE: Final = (1.208, 1.21865)
VALUES: Final = 427
LISTS: Final = 10


@dataclass(frozen=True)
class Data:
    """The diagram, with all orbits up to period 2 in the paper's window."""

    model: TwoBlock
    diagram: Diagram

    @property
    def orbits(self) -> dict[str, OrbitCurve]:
        """P1, S1, U1, A and B, by how and where they begin and end."""
        ones, twos = self.diagram.of_period(1), self.diagram.of_period(2)
        (p1,) = (orbit for orbit in ones if orbit.ends[0].reason == "end of range")
        s1, u1 = sorted(
            (orbit for orbit in ones if orbit.ends[0].reason == "fold"),
            key=lambda orbit: float(orbit.ends[1].points[0]),
        )
        a, b = sorted(
            (orbit for orbit in twos if orbit.ends[0].reason == "border_collision"),
            key=lambda orbit: orbit.ends[1].value,
        )
        return {"P1": p1, "S1": s1, "U1": u1, "A": a, "B": b}


def compute() -> Data:
    """Follow all orbits up to period 2 and the attractors over the paper's range and window."""
    model = examples.law9()
    values = np.linspace(*RANGE, VALUES)
    diagram = bifurcation_diagram(
        model, "alpha", values, max_period=2, window=WINDOW, iterates=128, n_lists=LISTS
    )
    return Data(model, diagram)


def draw(data: Data, figure: Figure) -> None:
    """Draw the diagram; thick attracting and thin unstable periodic motions, as in the paper."""
    ax = figure.add_subplot()
    draw_diagram(data.diagram, ax, breakpoints=False, marks=False, dots=128)
    looks: dict[str, Any] = {"marker": ".", "ms": 1.6, "mew": 0.0, "color": STABLE["color"]}
    draw_attractors(data.diagram, ax, kinds=("periodic",), **looks)
    _names(ax, data)


def _names(ax: Axes, data: Data) -> None:
    """Write names beside the curves, at an alpha and by an offset in points."""
    orbits = data.orbits
    places: list[tuple[str, OrbitCurve, int, float, tuple[int, int]]] = [
        ("$P_1$", orbits["P1"], 0, 1.2088, (6, 11)),
        ("$S_1$", orbits["S1"], 0, 1.2153, (-20, -6)),
        ("$U_1$", orbits["U1"], 0, 1.2176, (2, 22)),
    ]
    for name, alpha, offsets in (
        ("A", 1.2096, ((-10, 7), (-10, -12))),
        ("B", 1.2135, ((6, -21), (6, 19))),
    ):
        columns = np.argsort(orbits[name].ends[0].points)  # A1 and B1 lie beside the cusp of f
        for number, (column, offset) in enumerate(zip(columns, offsets, strict=True), start=1):
            text = f"${name}_{number}$"
            places.append((text, orbits[name], int(column), alpha, offset))
    for text, orbit, column, alpha, offset in places:
        k = int(np.searchsorted(data.diagram.values, alpha))
        ax.annotate(
            text,
            (data.diagram.values[k], orbit.points[k, column]),
            offset,
            textcoords="offset points",
            ha="center",
            va="center",
            bbox={"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.85},
            arrowprops={"arrowstyle": "-", "lw": 0.4, "shrinkA": 1.0, "shrinkB": 0.0},
            zorder=7,
        )


def caption(data: Data) -> str:
    """Describe the diagram with the values of alpha at which orbits begin and end."""
    orbits = data.orbits
    p = data.model.parameters
    others = ", ".join(f"{name} = {p[name]:g}" for name in ("beta", "V", "gamma", "delta", "eta"))
    cascade = next(o for o in data.diagram.of_period(2) if o.ends[0].reason == "flip")
    return (
        f"Bifurcation diagram for {others} in the window {WINDOW[0]:g} < d < {WINDOW[1]:g}. "
        "Heavy: stable, thin: unstable orbits up to period 2, all of them; dots: other attractors, "
        "black for cycles of longer periods, blue for chaotic ones. A and B are born "
        f"on the cusps of f^2 at alpha = {orbits['A'].ends[0].value:.12f}; A dies at the flip of "
        f"P1, {orbits['A'].ends[1].value:.12f}; S1 and U1 are born in a fold at "
        f"{orbits['S1'].ends[0].value:.12f}; S1 doubles at {cascade.ends[0].value:.12f}; P1, U1 "
        f"and B vanish together at {orbits['P1'].ends[1].value:.12f}. One more unstable orbit of "
        "period 2, which the paper does not mention, surrounds them all."
    )
