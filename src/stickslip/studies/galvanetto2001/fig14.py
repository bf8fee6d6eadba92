"""Figure 14: first and second iterated map of law (9), alpha = 1.211, and its attractor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.attractors import attractors
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.galvanetto2001.orbits import WINDOW, cusp_of, fixed_points, in_window

TITLE: Final = "First and second iterated map, alpha = 1.211"
COLUMNS: Final = "two"
HEIGHT: Final = 3.5


@dataclass(frozen=True)
class Data:
    """Graphs of f and f^2, the attractor of the motion that starts at the cusp, and P1."""

    model: TwoBlock
    first: Curve
    second: Curve
    attractor: Attractor
    p1: float


def compute() -> Data:
    """Trace both maps and identify the attractor."""
    model = examples.law9(alpha=1.211)
    f = event_map(model)
    window = in_window(model.alpha)
    (p1,) = fixed_points(window)
    (attractor,) = attractors(window, starts=[cusp_of(window).d])
    first, second = trace(f, WINDOW), trace(f.power(2), WINDOW)
    return Data(model, first, second, attractor, float(p1.points[0]))


def draw(data: Data, figure: Figure) -> None:
    """Draw the part of each graph over the attractor heavy, the rest light, as in the paper."""
    axes = figure.subplots(1, 2)
    for power, (ax, letter, curve) in enumerate(
        zip(axes, "ab", (data.first, data.second), strict=True), start=1
    ):
        draw_curve(curve, ax, window=WINDOW, power=power, linewidth=0.6)
        for low, high in data.attractor.bands:
            over = (curve.x >= low) & (curve.x <= high)
            ax.plot(
                np.where(over, curve.x, np.nan), curve.y, color=PALETTE["blue"], lw=2.2, zorder=3
            )
        mark_orbit(ax, data.p1, power=power, stable=False)
        panel_letter(ax, letter)


def caption(data: Data) -> str:
    """Describe the picture with the bands in numbers."""
    bands = " and ".join(f"[{low:.8f}, {high:.8f}]" for low, high in data.attractor.bands)
    exponent, error = data.attractor.lyapunov
    return (
        f"(a) First and (b) second iterated map for alpha = {data.model.alpha:g}. Heavy: the "
        f"{data.attractor.kind} attractor, two bands {bands} between images of the cusp, Lyapunov "
        f"exponent {exponent:.3f} ± {error:.3f} per step; square: the unstable fixed point P1, "
        f"d = {data.p1:.6f}."
    )
