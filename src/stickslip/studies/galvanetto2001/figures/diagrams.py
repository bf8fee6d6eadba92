"""Bifurcation diagrams: both systems, and the crisis of the chaotic attractor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stickslip import examples
from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine
from stickslip.analysis.diagrams.diagram import Diagram, OrbitCurve
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.bifurcations import BREAK, STABLE
from stickslip.plot.diagram import draw_attractors, draw_diagram, draw_orbit_curve
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.galvanetto2001.orbits import WINDOW, named

# Figure 4: steady motions of the Coulomb system over the driving velocity.
V_RANGE: Final = (0.0366, 0.0372)
V_VALUES: Final = 601
V_LISTS: Final = 7
ENLARGED: Final = (0.2755, 0.2803)  # around S4's point 1; the paper's range is not printed


@dataclass(frozen=True)
class CoulombDiagram:
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


@cache
def compute_coulomb() -> CoulombDiagram:
    """Follow all orbits up to period 4 and the attractors over the paper's range of V."""
    model = examples.coulomb()
    values = np.linspace(*V_RANGE, V_VALUES)
    return CoulombDiagram(
        model, bifurcation_diagram(model, "V", values, max_period=4, n_lists=V_LISTS)
    )


def draw_coulomb(figure: Figure) -> str:
    """Draw all motions, and enlarged the branch of S4 that meets the discontinuity."""
    data = compute_coulomb()
    whole, enlarged = figure.subplots(1, 2)
    draw_diagram(data.diagram, whole, breakpoints=False, marks=False)
    whole.set_ylim(-0.58, 0.62)
    _name_motions(whole, data)
    _draw_enlarged(enlarged, data)
    for ax, letter in ((whole, "a"), (enlarged, "b")):
        ax.set_xticks(np.linspace(*V_RANGE, 4))
        panel_letter(ax, letter)
    lowest, longest = min(data.long_periods), max(data.long_periods)
    periodic = (data.diagram.attractors.kind == "periodic").all()
    rest = "No attractor was found that is not periodic." if periodic else ""
    return (
        f"Steady motions for {named(data.model, 'V')}. (a) "
        "Heavy: attractors S1 and S4 (points numbered in their order), thin: unstable orbits U1 "
        "and U2; there are no other orbits up to period 4. Dots: the attractors that follow S4, "
        f"all of their points. (b) Enlarged, {ENLARGED[0]:g} < d < {ENLARGED[1]:g} (our choice): "
        f"the branch S41 meets the line of discontinuity D at V = {data.end:.12f} (circle). The "
        "motions that the paper calls non-periodic have long periods here, "
        f"{lowest} to {longest} at the {len(data.diagram.values)} values of V drawn. {rest}"
    ).rstrip()


def _name_motions(ax: Axes, data: CoulombDiagram) -> None:
    for name in ("S1", "U1", "U2"):
        _write(ax, f"${name[0]}_{name[1]}$", float(data.orbits[name].points[0, 0]), 3)
    _, column = data.discontinuity
    first = data.orbits["S4"].points[0]
    for number, d in enumerate(np.roll(first, -column), start=1):
        _write(ax, f"$S_{{4{number}}}$", float(d), 4)


def _write(ax: Axes, text: str, d: float, above: int) -> None:
    ax.annotate(text, (V_RANGE[0], d), (5, above), textcoords="offset points")


def _draw_enlarged(ax: Axes, data: CoulombDiagram) -> None:
    line, column = data.discontinuity
    s4, values = data.orbits["S4"], data.diagram.values
    draw_attractors(data.diagram, ax, marker=".", ms=1.0, mew=0.0)
    draw_orbit_curve(data.diagram, s4, ax)
    ax.plot(values, line.d, **BREAK)
    looks: dict[str, Any] = {"ls": "none", "marker": "o", "mfc": "white", "mec": PALETTE["purple"]}
    ax.plot([data.end], [s4.ends[1].points[column]], ms=4.5, zorder=6, **looks)
    ax.set(xlim=V_RANGE, ylim=ENLARGED)
    ax.annotate("$D$", (V_RANGE[0], line.d[0]), (8, 4), textcoords="offset points")
    quarter = len(values) // 4
    where = (values[quarter], s4.points[quarter, column])
    ax.annotate("$S_{41}$", where, (4, -10), textcoords="offset points")
    ax.set(xlabel=r"$V_{\mathrm{dr}}$", ylabel="$d$")


# Figure 11: bifurcation diagram of the system with friction law (9).
RANGE: Final = (1.208, 1.21865)
VALUES: Final = 427
LISTS: Final = 10


@dataclass(frozen=True)
class Law9Diagram:
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


@cache
def compute_law9() -> Law9Diagram:
    """Follow all orbits up to period 2 and the attractors over the paper's range and window."""
    model = examples.law9()
    values = np.linspace(*RANGE, VALUES)
    diagram = bifurcation_diagram(
        model, "alpha", values, max_period=2, window=WINDOW, iterates=128, n_lists=LISTS
    )
    return Law9Diagram(model, diagram)


def draw_law9(figure: Figure) -> str:
    """Draw the diagram; thick attracting and thin unstable periodic motions, as in the paper."""
    data = compute_law9()
    ax = figure.add_subplot()
    draw_diagram(data.diagram, ax, breakpoints=False, marks=False, dots=128)
    looks: dict[str, Any] = {"marker": ".", "ms": 1.6, "mew": 0.0, "color": STABLE["color"]}
    draw_attractors(data.diagram, ax, kinds=("periodic",), **looks)
    _name_orbits(ax, data)
    orbits = data.orbits
    cascade = next(o for o in data.diagram.of_period(2) if o.ends[0].reason == "flip")
    return (
        f"Bifurcation diagram for {named(data.model, 'alpha')} in the window "
        f"{WINDOW[0]:g} < d < {WINDOW[1]:g}. "
        "Heavy: stable, thin: unstable orbits up to period 2, all of them; dots: other attractors, "
        "black for cycles of longer periods, blue for chaotic ones. A and B are born "
        f"on the cusps of f^2 at alpha = {orbits['A'].ends[0].value:.12f}; A dies at the flip of "
        f"P1, {orbits['A'].ends[1].value:.12f}; S1 and U1 are born in a fold at "
        f"{orbits['S1'].ends[0].value:.12f}; S1 doubles at {cascade.ends[0].value:.12f}; P1, U1 "
        f"and B vanish together at {orbits['P1'].ends[1].value:.12f}. One more unstable orbit of "
        "period 2, which the paper does not mention, surrounds them all."
    )


def _name_orbits(ax: Axes, data: Law9Diagram) -> None:
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


# Figure 15: the chaotic attractor of law (9) meets the boundary of its basin, U1.
CRISIS_RANGE: Final = (1.2150, 1.2156)  # around the collision; our choice
CRISIS_WINDOW: Final = (0.3798, 0.3824)
CRISIS_VALUES: Final = 181
CRISIS_LISTS: Final = 5
STARTS: Final = 4  # of transients, spread over the place of the attractor
STEPS: Final = 50  # of each


@dataclass(frozen=True)
class Crisis:
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


@cache
def compute_crisis() -> Crisis:
    """Follow the fixed points and the attractors, and orbits of the cusp."""
    model = examples.law9()
    values = np.linspace(*CRISIS_RANGE, CRISIS_VALUES)
    diagram = bifurcation_diagram(
        model,
        "alpha",
        values,
        max_period=1,
        window=CRISIS_WINDOW,
        iterates=48,
        n_lists=CRISIS_LISTS,
    )
    (cusp,) = (line.d for line in diagram.breakpoints if line.kind == "corner")
    maps = [event_map(model).replace(alpha=alpha) for alpha in values]
    images = [f.iterate(d, 2) for f, d in zip(maps, cusp, strict=True)]
    edges = np.array(images)[:, [2, 1]]
    data = Crisis(model, diagram, edges, np.full((CRISIS_VALUES, STARTS * STEPS), np.nan))
    shares = (np.arange(STARTS) + 0.5) / STARTS
    for k in np.flatnonzero(~data.chaotic):
        starts = edges[k, 0] + shares * (edges[k, 1] - edges[k, 0])
        data.transients[k] = maps[k].iterate(starts, STEPS)[:, 1:].ravel()
    return data


def draw_crisis(figure: Figure) -> str:
    """Draw the attractor as an area, transients as dots and fixed points as lines over alpha."""
    data = compute_crisis()
    ax = figure.add_subplot()
    values = data.diagram.values
    low, high = np.where(data.chaotic[:, None], data.edges, np.nan).T
    ax.fill_between(values, low, high, color=PALETTE["sky"], alpha=0.6, lw=0.0, zorder=1)
    draw_diagram(data.diagram, ax, window=CRISIS_WINDOW, breakpoints=False, marks=False, dots=0)
    grid = np.broadcast_to(values[:, None], data.transients.shape)
    ax.plot(grid, data.transients, ".", color=PALETTE["blue"], ms=0.9, mew=0.0, zorder=2)
    _name_fixed_points(ax, data)
    step = float(np.diff(values).mean())
    return (
        f"Fixed points and attractors for {named(data.model, 'alpha')}, "
        f"{CRISIS_RANGE[0]:g} < alpha < {CRISIS_RANGE[1]:g} (ranges are our choice). Shaded: the "
        "chaotic attractor, between the first two images of the cusp; heavy "
        "line: the stable fixed point S1, thin lines: the unstable ones, U1 and P1. The lower "
        "edge of the attractor meets U1, which was born with S1 in the fold at alpha = "
        f"{data.u1.ends[0].value:.10f}; the last value with the attractor is "
        f"{data.last_chaotic:.7f}, in steps of {step:.1e}. Dots: transients beyond the collision, "
        f"{STEPS} images of {STARTS} points spread over the place of the attractor. They wander "
        "over it, fall below U1 and settle on S1 (on the orbit of period 2 after its flip)."
    )


def _name_fixed_points(ax: Axes, data: Crisis) -> None:
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


FIGURES: Final = {
    4: PaperFigure("two", 3.3, draw_coulomb),
    11: PaperFigure("two", 4.0, draw_law9),
    15: PaperFigure("one", 3.0, draw_crisis),
}
