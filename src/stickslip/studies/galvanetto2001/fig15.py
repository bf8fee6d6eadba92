"""Figure 15: the chaotic attractor of law (9) meets the boundary of its basin, U1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stickslip import examples
from stickslip.analysis.diagrams.diagram import Diagram, OrbitCurve
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.diagram import draw_diagram
from stickslip.plot.style import PALETTE

TITLE: Final = "Collision of the chaotic attractor with U1"
COLUMNS: Final = "one"
HEIGHT: Final = 3.0

RANGE: Final = (1.2150, 1.2156)  # around the collision; our choice
WINDOW: Final = (0.3798, 0.3824)
VALUES: Final = 181
LISTS: Final = 5
STARTS: Final = 4  # of transients, spread over the place of the attractor
STEPS: Final = 50  # of each


@dataclass(frozen=True)
class Data:
    """The diagram with its fixed points, and what becomes of orbits that start in its middle."""

    model: TwoBlock
    diagram: Diagram
    # shape (n, 2): second and first image of the cusp; an attractor fills what is between
    edges: Floats
    # shape (n, STARTS * STEPS): from between the edges; NaN beside an attractor
    transients: Floats

    @property
    def u1(self) -> OrbitCurve:
        """The boundary of the basin: the unstable one of the two fixed points of the fold."""
        s1_u1 = (o for o in self.diagram.of_period(1) if o.ends[0].reason == "fold")
        return max(s1_u1, key=lambda orbit: float(orbit.ends[1].points[0]))

    @property
    def chaotic(self) -> NDArray[np.bool_]:
        """At which values there is a chaotic attractor, shape (n,)."""
        table, found = self.diagram.attractors, np.zeros(len(self.diagram.values), dtype=bool)
        found[table.where[table.kind == "chaotic"]] = True
        return found

    @property
    def last_chaotic(self) -> float:
        """Largest alpha drawn with the attractor."""
        return float(self.diagram.values[self.chaotic].max())


def compute() -> Data:
    """Follow the fixed points and the attractors, and orbits of the cusp."""
    model = examples.law9()
    values = np.linspace(*RANGE, VALUES)
    diagram = bifurcation_diagram(
        model, "alpha", values, max_period=1, window=WINDOW, iterates=48, n_lists=LISTS
    )
    (cusp,) = (line.d for line in diagram.breakpoints if line.kind == "corner")
    maps = [event_map(model).replace(alpha=alpha) for alpha in values]
    images = [f.iterate(d, 2) for f, d in zip(maps, cusp, strict=True)]
    edges = np.array(images)[:, [2, 1]]
    data = Data(model, diagram, edges, np.full((VALUES, STARTS * STEPS), np.nan))
    shares = (np.arange(STARTS) + 0.5) / STARTS
    for k in np.flatnonzero(~data.chaotic):
        starts = edges[k, 0] + shares * (edges[k, 1] - edges[k, 0])
        data.transients[k] = maps[k].iterate(starts, STEPS)[:, 1:].ravel()
    return data


def draw(data: Data, figure: Figure) -> None:
    """Draw the attractor as an area, transients as dots and fixed points as lines over alpha."""
    ax = figure.add_subplot()
    values = data.diagram.values
    low, high = np.where(data.chaotic[:, None], data.edges, np.nan).T
    ax.fill_between(values, low, high, color=PALETTE["sky"], alpha=0.6, lw=0.0, zorder=1)
    draw_diagram(data.diagram, ax, window=WINDOW, breakpoints=False, marks=False, dots=0)
    grid = np.broadcast_to(values[:, None], data.transients.shape)
    ax.plot(grid, data.transients, ".", color=PALETTE["blue"], ms=0.9, mew=0.0, zorder=2)
    _names(ax, data)


def _names(ax: Axes, data: Data) -> None:
    fixed = {"$U_1$": (data.u1, 1.21522, (-2, 5))}
    for orbit in data.diagram.of_period(1):
        if orbit.ends[0].reason != "fold":
            fixed["$P_1$"] = (orbit, 1.21545, (0, 4))
        elif orbit is not data.u1:
            fixed["$S_1$"] = (orbit, 1.21522, (-4, -11))
    for name, (orbit, alpha, offset) in fixed.items():
        k = int(np.searchsorted(data.diagram.values, alpha))
        where = (data.diagram.values[k], orbit.points[k, 0])
        box = {"fc": "white", "ec": "none", "pad": 0.4, "alpha": 0.7} if "P" in name else None
        ax.annotate(name, where, offset, textcoords="offset points", bbox=box, zorder=7)


def caption(data: Data) -> str:
    """Describe the picture and where the collision is seen."""
    step = float(np.diff(data.diagram.values).mean())
    return (
        f"Fixed points and attractors for {RANGE[0]:g} < alpha < {RANGE[1]:g} (ranges are our "
        "choice). Shaded: the chaotic attractor, between the first two images of the cusp; heavy "
        "line: the stable fixed point S1, thin lines: the unstable ones, U1 and P1. The lower "
        "edge of the attractor meets U1, which was born with S1 in the fold at alpha = "
        f"{data.u1.ends[0].value:.10f}; the last value with the attractor is "
        f"{data.last_chaotic:.7f}, in steps of {step:.1e}. Dots: transients beyond the collision, "
        f"{STEPS} images of {STARTS} points spread over the place of the attractor. They wander "
        "over it, fall below U1 and settle on S1 (on the orbit of period 2 after its flip)."
    )
