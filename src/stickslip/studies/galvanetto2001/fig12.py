"""Figure 12: first and second iterated map of law (9) for alpha = 1.208."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import panel_letter
from stickslip.studies.galvanetto2001.orbits import WINDOW, cusp_of, fixed_points, in_window

TITLE: Final = "First and second iterated map, alpha = 1.208"
COLUMNS: Final = "two"
HEIGHT: Final = 3.5


@dataclass(frozen=True)
class Data:
    """Graphs of f and f^2, the cusp of f, and the fixed point P1 with its multiplier."""

    model: TwoBlock
    first: Curve
    second: Curve
    cusp: float
    p1: float
    multiplier: float


def compute() -> Data:
    """Trace both maps over the paper's window and solve for P1, right of the cusp."""
    model = examples.law9()
    f = event_map(model)
    window = in_window(model.alpha)
    (p1,) = fixed_points(window)
    return Data(
        model,
        trace(f, WINDOW),
        trace(f.power(2), WINDOW),
        cusp_of(window).d,
        float(p1.points[0]),
        p1.multiplier,
    )


def draw(data: Data, figure: Figure) -> None:
    """Draw both maps with the stable fixed point."""
    axes = figure.subplots(1, 2)
    for power, (ax, letter, curve) in enumerate(
        zip(axes, "ab", (data.first, data.second), strict=True), start=1
    ):
        draw_curve(curve, ax, window=WINDOW, power=power)
        mark_orbit(ax, data.p1, power=power, stable=abs(data.multiplier) < 1.0)
        panel_letter(ax, letter)


def caption(data: Data) -> str:
    """Describe the picture with the cusp and P1 in numbers."""
    p = data.model.parameters
    numbers = ", ".join(f"{name} = {value:g}" for name, value in p.items())
    return (
        f"(a) First and (b) second iterated map for {numbers}. The map has its cusp at "
        f"d = {data.cusp:.6f}; the bold point is the stable fixed point P1, d = {data.p1:.6f}, "
        f"multiplier {data.multiplier:.5f}."
    )
