"""Figure 16: first iterated map of law (9) shortly before its cusp meets the diagonal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from stickslip import examples
from stickslip.mechanics.eventmap.event_map import event_map
from stickslip.paper.galvanetto2001.printed import ADAPTIVE
from stickslip.paper.galvanetto2001.roots import cusp, fixed_point
from stickslip.plot.curve import Curve, trace
from stickslip.plot.event_map import draw_curve, mark_orbit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.mechanics.model.two_block import TwoBlock

TITLE: Final = "First iterated map, alpha = 1.2182"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3

WINDOW: Final = (0.3782, 0.3824)  # around the three fixed points; our choice


@dataclass(frozen=True)
class Data:
    """The map's graph, its cusp, and the unstable fixed points on both sides of it."""

    model: TwoBlock
    curve: Curve
    cusp: float
    u1: float
    p1: float


def compute() -> Data:
    """Trace the map; U1 is on the rising side of the cusp, P1 on the falling side."""
    model = examples.law9(alpha=1.2182)
    f = event_map(model)
    left, right = cusp(f, WINDOW)
    u1 = fixed_point(f, left - 0.0003, left, noise=ADAPTIVE).value
    p1 = fixed_point(f, right, WINDOW[1], noise=ADAPTIVE).value
    return Data(model, trace(f, WINDOW), left, u1, p1)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map with both unstable fixed points."""
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=WINDOW)
    for name, d, offset in (("$U_1$", data.u1, (-16, 2)), ("$P_1$", data.p1, (6, -3))):
        mark_orbit(ax, d, stable=False)
        ax.annotate(name, (d, d), offset, textcoords="offset points")


def caption(data: Data) -> str:
    """Describe the picture with the points in numbers."""
    return (
        f"First iterated map for alpha = {data.model.alpha:g}, {WINDOW[0]:g} < d < {WINDOW[1]:g} "
        f"(our choice). Squares: the unstable fixed points U1, d = {data.u1:.8f}, and P1, "
        f"d = {data.p1:.8f}, on both sides of the cusp d = {data.cusp:.8f}."
    )
