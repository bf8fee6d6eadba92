"""Figure 4: steady motions of the Coulomb system over the driving velocity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine
from stickslip.analysis.diagrams.diagram import Diagram, OrbitCurve
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.bifurcations import BREAK
from stickslip.plot.diagram import draw_attractors, draw_diagram, draw_orbit_curve
from stickslip.plot.style import PALETTE, panel_letter

TITLE: Final = "Steady motions of the Coulomb system over the driving velocity"
COLUMNS: Final = "two"
HEIGHT: Final = 3.3

RANGE: Final = (0.0366, 0.0372)
VALUES: Final = 601
LISTS: Final = 7
ENLARGED: Final = (0.2755, 0.2803)  # around S4's point 1; the paper's range is not printed


@dataclass(frozen=True)
class Data:
    """The diagram, with all orbits up to period 4."""

    model: TwoBlock
    diagram: Diagram

    @property
    def orbits(self) -> dict[str, OrbitCurve]:
        """S1, U1 and U2 in ascending order, and S4, which ends inside the range."""
        (s4,) = self.diagram.of_period(4)
        ones = sorted(self.diagram.of_period(1), key=lambda orbit: float(orbit.points[0, 0]))
        return dict(zip(("S1", "U1", "U2", "S4"), (*ones, s4), strict=True))

    @property
    def end(self) -> float:
        """V at which S4 meets the discontinuity."""
        return self.orbits["S4"].ends[1].value

    @property
    def discontinuity(self) -> tuple[BreakpointLine, int]:
        """Line D that S4 meets, and the column of the point that meets it."""
        points = self.orbits["S4"].ends[1].points
        near = np.searchsorted(self.diagram.values, self.end)
        gaps = np.array([np.abs(points - line.d[near]) for line in self.diagram.breakpoints])
        line, column = np.unravel_index(int(gaps.argmin()), gaps.shape)
        return self.diagram.breakpoints[line], int(column)

    @property
    def long_periods(self) -> dict[int, tuple[float, float]]:
        """Periods of the attractors after S4, each with the range of V where it was found."""
        table, values = self.diagram.attractors, self.diagram.values
        longer = (table.kind == "periodic") & (table.period > 4)
        found = {}
        for period in np.unique(table.period[longer]):
            where = values[table.where[longer & (table.period == period)]]
            found[int(period)] = (float(where.min()), float(where.max()))
        return found


def compute() -> Data:
    """Follow all orbits up to period 4 and the attractors over the paper's range of V."""
    model = examples.coulomb()
    values = np.linspace(*RANGE, VALUES)
    return Data(model, bifurcation_diagram(model, "V", values, max_period=4, n_lists=LISTS))


def draw(data: Data, figure: Figure) -> None:
    """Draw all motions, and enlarged the branch of S4 that meets the discontinuity."""
    whole, enlarged = figure.subplots(1, 2)
    draw_diagram(data.diagram, whole, breakpoints=False, marks=False)
    whole.set_ylim(-0.56, 0.56)
    _name_motions(whole, data)
    _draw_enlarged(enlarged, data)
    for ax, letter in ((whole, "a"), (enlarged, "b")):
        ax.set_xticks(np.linspace(*RANGE, 4))
        panel_letter(ax, letter)


def _name_motions(ax: Axes, data: Data) -> None:
    for name in ("S1", "U1", "U2"):
        _write(ax, f"${name[0]}_{name[1]}$", float(data.orbits[name].points[0, 0]), 3)
    _, column = data.discontinuity
    first = data.orbits["S4"].points[0]
    for number, d in enumerate(np.roll(first, -column), start=1):
        _write(ax, f"$S_{{4{number}}}$", float(d), 4)


def _write(ax: Axes, text: str, d: float, above: int) -> None:
    ax.annotate(text, (RANGE[0], d), (5, above), textcoords="offset points")


def _draw_enlarged(ax: Axes, data: Data) -> None:
    line, column = data.discontinuity
    s4, values = data.orbits["S4"], data.diagram.values
    draw_attractors(data.diagram, ax, marker=".", ms=1.0, mew=0.0)
    draw_orbit_curve(data.diagram, s4, ax)
    ax.plot(values, line.d, **BREAK)
    looks: dict[str, Any] = {"ls": "none", "marker": "o", "mfc": "white", "mec": PALETTE["purple"]}
    ax.plot([data.end], [s4.ends[1].points[column]], ms=4.5, zorder=6, **looks)
    ax.set_xlim(RANGE)
    ax.set_ylim(ENLARGED)
    ax.annotate("$D$", (RANGE[0], line.d[0]), (8, 4), textcoords="offset points")
    ax.annotate("$S_{41}$", (RANGE[0], s4.points[0, column]), (8, -4), textcoords="offset points")
    ax.set_xlabel(r"$V_{\mathrm{dr}}$")
    ax.set_ylabel("$d$")


def caption(data: Data) -> str:
    """Describe both panels, where S4 ends and what follows it."""
    p = data.model.parameters
    longest = max(data.long_periods)
    lowest = min(data.long_periods)
    chaotic = np.unique(data.diagram.attractors.kind[data.diagram.attractors.kind != "periodic"])
    rest = "No attractor was found that is not periodic." if not chaotic.size else ""
    return (
        f"Steady motions for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}. (a) "
        "Heavy: attractors S1 and S4 (points numbered in their order), thin: unstable orbits U1 "
        "and U2; there are no other orbits up to period 4. Dots: the attractors that follow S4, "
        f"all of their points. (b) Enlarged, {ENLARGED[0]:g} < d < {ENLARGED[1]:g} (our choice): "
        f"the branch S41 meets the line of discontinuity D at V = {data.end:.12f} (circle). The "
        "motions that the paper calls non-periodic have long periods here, "
        f"{lowest} to {longest} at the {len(data.diagram.values)} values of V drawn. {rest}"
    ).rstrip()
