"""Figure 16: first iterated map of law (9) shortly before its cusp meets the diagonal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.maps.derived import WindowMap
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import panel_letter
from stickslip.studies.galvanetto2001.orbits import cusp_of, fixed_points

TITLE: Final = "First iterated map, alpha = 1.2182"
COLUMNS: Final = "two"
HEIGHT: Final = 3.5

WINDOW: Final = (0.3782, 0.3824)  # around the lobe; our choice
ENLARGED: Final = (0.38025, 0.38065)


@dataclass(frozen=True)
class Data:
    """The map's graph, its cusp, and all fixed points around it, S1 for the first."""

    model: TwoBlock
    curve: Curve
    cusp: float
    s1: float
    u1: float
    p1: float


def compute() -> Data:
    """Trace the map; U1 is on the rising side of the cusp, S1 and P1 on falling ones."""
    model = examples.law9(alpha=1.2182)
    f = event_map(model)
    window = WindowMap(f, WINDOW)
    s1, u1, p1 = (float(orbit.points[0]) for orbit in fixed_points(window))
    return Data(model, trace(f, WINDOW), cusp_of(window).d, s1, u1, p1)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map with its unstable fixed points and, enlarged, those beside the cusp."""
    for ax, letter, window in zip(figure.subplots(1, 2), "ab", (WINDOW, ENLARGED), strict=True):
        draw_curve(data.curve, ax, window=window)
        _mark(ax, data, window)
        panel_letter(ax, letter)


def _mark(ax: Axes, data: Data, window: tuple[float, float]) -> None:
    points = (
        ("$S_1$", data.s1, (-17, -6)),
        ("$U_1$", data.u1, (-17, 2)),
        ("$P_1$", data.p1, (7, -4)),
    )
    for name, d, offset in points:
        if window[0] < d < window[1]:
            mark_orbit(ax, d, stable=False)
            ax.annotate(name, (d, d), offset, textcoords="offset points")


def caption(data: Data) -> str:
    """Describe the picture with the points in numbers."""
    return (
        f"First iterated map for alpha = {data.model.alpha:g}: (a) the lobe, (b) its cusp enlarged "
        f"(ranges are our choice). Squares: the unstable fixed points U1, d = {data.u1:.8f}, and "
        f"P1, d = {data.p1:.8f}, on both sides of the cusp d = {data.cusp:.8f}, and S1, "
        f"d = {data.s1:.8f}, unstable since its period doubling."
    )
