"""Figure 14: first and second iterated map of law (9), alpha = 1.211, and its attractor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import examples
from stickslip.paper.galvanetto2001.printed import ADAPTIVE, WINDOW
from stickslip.paper.galvanetto2001.roots import cusp, fixed_point
from stickslip.plot.curve import Curve, trace
from stickslip.plot.event_map import draw_curve, mark_orbit
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.study.event_map import event_map

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

TITLE: Final = "First and second iterated map, alpha = 1.211"
COLUMNS: Final = "two"
HEIGHT: Final = 3.5


@dataclass(frozen=True)
class Data:
    """Graphs of f and f^2, the bands (2, 2) of the attractor between images of the cusp, P1."""

    model: TwoBlock
    first: Curve
    second: Curve
    bands: NDArray[np.float64]
    p1: float


def compute() -> Data:
    """Trace both maps; the first four images of the cusp bound the two bands."""
    model = examples.law9(alpha=1.211)
    f = event_map(model)
    left, right = cusp(f, WINDOW)
    images = np.sort(f.iterate(left, 4)[1:])
    p1 = fixed_point(f, right, WINDOW[1], noise=ADAPTIVE).value
    return Data(model, trace(f, WINDOW), trace(f.power(2), WINDOW), images.reshape(2, 2), p1)


def draw(data: Data, figure: Figure) -> None:
    """Draw the part of each graph over the attractor heavy, the rest light, as in the paper."""
    axes = figure.subplots(1, 2)
    for power, (ax, letter, curve) in enumerate(
        zip(axes, "ab", (data.first, data.second), strict=True), start=1
    ):
        draw_curve(curve, ax, window=WINDOW, power=power, linewidth=0.6)
        for low, high in data.bands:
            over = (curve.x >= low) & (curve.x <= high)
            ax.plot(
                np.where(over, curve.x, np.nan), curve.y, color=PALETTE["blue"], lw=2.2, zorder=3
            )
        mark_orbit(ax, data.p1, power=power, stable=False)
        panel_letter(ax, letter)


def caption(data: Data) -> str:
    """Describe the picture with the bands in numbers."""
    bands = " and ".join(f"[{low:.8f}, {high:.8f}]" for low, high in data.bands)
    return (
        f"(a) First and (b) second iterated map for alpha = {data.model.alpha:g}. Heavy: the "
        f"chaotic attractor, two bands {bands} between images of the cusp; square: the unstable "
        f"fixed point P1, d = {data.p1:.6f}."
    )
